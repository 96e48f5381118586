"""Which kernel steps a World: the one of its scene's features, or that of all features until there is one."""

from __future__ import annotations

from collections.abc import Callable

from ..core.step import step_worlds
from ..jit import is_compiled, say_once
from ..records.bundle import Bundle
from ..records.kernel_variants import OWN_KERNELS, KernelVariant, choose_variant, kernel_variant_of
from ..records.model import Model
from ..records.scratch import Scratch

_ANY = 16  # contacts


def variant_of_step(model: Model, bundle_of: Callable[[KernelVariant, Scratch], Bundle]) -> KernelVariant:
    """Return the variant whose kernel steps a scene, and say so where it is that of all scenes.

    Args:
        model: of the scene.
        bundle_of: makes the bundle of a variant and its scratch, whose type tells the kernel.
    """

    def is_at_hand(variant: KernelVariant) -> bool:
        bundle = bundle_of(variant, Scratch(model, variant, _ANY))
        return is_compiled(step_worlds, bundle, 0, 1, 0)

    variant = choose_variant(model, is_at_hand)
    if variant != kernel_variant_of(model):
        say_once(
            "general kernel",
            "gsenv: this scene runs on the kernel of all scenes (equal results, up to 40 % slower); with "
            f"{OWN_KERNELS}=1 one of its own is compiled, a minute or more, once",
        )
    return variant
