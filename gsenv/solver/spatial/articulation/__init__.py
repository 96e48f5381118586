"""Links in 3D: poses and velocities, forces and inertias, coordinates of their joints."""

from __future__ import annotations

from .forces import (
    add_reaction,
    added,
    carry,
    impulse_at_origin,
    keep_momentum,
    no_impulse,
    reduced,
    set_applied,
    set_force,
    set_inertia,
    set_moment,
    set_motions,
)
from .places import (
    enter_joint,
    enter_link,
    keep_world_frames,
    leave_link,
    mismatch,
    place_link,
    set_motion,
    start_rates,
    turning_rate,
)
from .servos import coordinate_of, numbers_of, set_pivot_direction, set_servo_direction

__all__ = [
    "add_reaction",
    "added",
    "carry",
    "coordinate_of",
    "enter_joint",
    "enter_link",
    "impulse_at_origin",
    "keep_momentum",
    "keep_world_frames",
    "leave_link",
    "mismatch",
    "no_impulse",
    "numbers_of",
    "place_link",
    "reduced",
    "set_applied",
    "set_force",
    "set_inertia",
    "set_moment",
    "set_motion",
    "set_motions",
    "set_pivot_direction",
    "set_servo_direction",
    "start_rates",
    "turning_rate",
]
