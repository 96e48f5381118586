"""What the tasks of GStack-v0, GStack3D-v0 and tower_v0 share outside their kernels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import ModuleType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from gsenv.envs.core.task import Array, Task
from gsenv.envs.stack.crack_lines import crack_lines
from gsenv.envs.stack.domain_randomization import QUANTITIES
from gsenv.envs.stack.settings import write_settings
from gsenv.solver import Options
from gsenv.solver.records.plain import as_bytes, as_records

if TYPE_CHECKING:
    from gsenv.render.camera import Camera


class BlocksTask(Task):
    """Building a tower of blocks, by the kernels of the module `rules`."""

    rules: ClassVar[ModuleType]
    first_block: ClassVar[int]  # index of its body
    first_shape: ClassVar[int]  # index of its shape
    info_fields: ClassVar[Sequence[tuple[str, Any]]] = (
        ("success", "?"),
        ("is_success", "?"),
        ("placed", "i8"),
        ("stand_time", "f8"),
        ("cracked", "?"),
        ("impact", "f8"),
    )
    quantities = QUANTITIES
    _before: Array | None = None  # bodies at the start of a step of the engine
    _bytes: tuple[Array, Array] | None = None  # of these, and of the world's bodies

    def solver_options(self) -> Options:
        """The grip is a weld that switches; without it no bodies are linked, so that joint coordinates save nothing."""
        return Options.preset(self.fidelity, articulated=False)

    def initialize_episode(self, worlds: Array, draws: Array, options: Mapping[str, Any]) -> None:
        write_settings(self.task_state, worlds, options)
        self.rules.initialize_worlds(self.kernel_world, worlds, draws, self.world.timestep)

    def apply_action(self, actions: Array) -> int:
        bad: int = self.rules.apply_actions(self.kernel_world, actions)
        return bad

    def simulate(self) -> None:
        """Advance the physics, and note after each step of the engine which impacts there were."""
        bodies = self.world.state.bodies
        if self._bytes is None or self._bytes[1].base is not bodies:  # e.g. after unpickling, when views are copies
            self._before = as_records(np.empty_like(bodies))
            self._bytes = as_bytes(self._before), as_bytes(bodies)
        for _ in range(self.engine_steps):
            if self.before_step is not None:
                self.before_step()
            np.copyto(*self._bytes)
            self.world.step(1)
            self.rules.note_impacts(self.kernel_world, self._before)

    def evaluate(self) -> None:
        self.rules.evaluate_worlds(self.kernel_world, self.world.timestep)

    def front_camera(self, world: int, width: int, height: int, reach: float) -> Camera:
        """Return a camera that sees `reach` m to either side, and higher for towers of more than four blocks."""
        from gsenv.render.camera import Bounds, Camera

        state = self.task_state[world]
        block_height = 2.0 * float(state["half_height"][1])
        top = 2.7 + block_height * max(int(state["blocks"]) - 4, 0)
        return Camera.fit(Bounds(-reach, -0.25, reach, top), width, height, margin=0.0)

    def captions(self, world: int) -> Sequence[str]:
        state = self.task_state[world]
        lines = [f"blocks {state['placed']} / {state['blocks']}"]
        if state["placed"] == state["blocks"]:
            lines.append(f"stands {self.infos['stand_time'][world]:.1f} s")
        if state["cracked"]:
            lines.append(f"cracked at {self.infos['impact'][world]:.2f} m/s")
        return lines

    def lines(self, world: int) -> Array | None:
        """Return the cracks in blocks, (line, 2, dim) in m."""
        cracked = int(self.task_state["cracked"][world])
        return crack_lines(self.world, world, self.first_block, self.first_shape, cracked) if cracked else None
