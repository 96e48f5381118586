"""PPO whose learning rate follows the change of the policy, and whose exploration may end with the run.

J. Schulman et al., "Proximal policy optimization algorithms" (2017), section 4, adapt the weight of a penalty in this
way; here it is the learning rate. Policies are judged by their mean action: where success may depend on noise, as that
of a threshold just out of the mean's reach, the noise must fade while there is time to learn.
"""

from __future__ import annotations

from typing import Any

from stable_baselines3 import PPO

FACTOR = 1.5  # by which the rate changes at most from one update to the next
LEAST, MOST = 1e-5, 3e-3  # of the rate


class AdaptivePPO(PPO):
    """PPO that lowers the learning rate after updates with more than twice a KL divergence, and raises it below half.

    Args:
        wanted_kl: of the policy before and after an update, mean over the rollout; 0 keeps the schedule of the rate.
        final_log_std: logarithm of a standard deviation. In the second half of the run the largest one of the actions
            falls to it, linearly in the logarithm, from the initial one; None leaves them free.
    """

    def __init__(self, *args: Any, wanted_kl: float = 0.0, final_log_std: float | None = None, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.wanted_kl = wanted_kl
        self.final_log_std = final_log_std

    def train(self) -> None:
        super().train()
        if self.wanted_kl > 0.0:
            kl = float(self.logger.name_to_value["train/approx_kl"])
            factor = 1.0 / FACTOR if kl > 2.0 * self.wanted_kl else FACTOR if kl < 0.5 * self.wanted_kl else 1.0
            for group in self.policy.optimizer.param_groups:
                group["lr"] = min(max(group["lr"] * factor, LEAST), MOST)
        if self.final_log_std is not None:
            self.policy.log_std.data.clamp_(max=self._most_log_std(self.final_log_std))

    def _most_log_std(self, final: float) -> float:
        late = 2.0 * self.num_timesteps / self._total_timesteps - 1.0
        first = float(self.policy.log_std_init)
        return first + min(late, 1.0) * (final - first) if late > 0.0 else float("inf")

    def _update_learning_rate(self, optimizers: Any) -> None:
        if self.wanted_kl == 0.0:
            super()._update_learning_rate(optimizers)
            return
        self.logger.record("train/learning_rate", optimizers.param_groups[0]["lr"])  # saved with the optimiser
