"""Rotation of 2D bodies: the inertia is one number, so rotation is as linear as translation.

spatial/rotation.py has the same functions; those that only 3D needs do nothing here.
"""

from __future__ import annotations

from typing import Any

from ..core.trig import sin_cos
from ..jit import njit
from .math import rotate, turn, unrotate


@njit
def begin_rotation(body: Any, parameters: Any, substep_body: Any) -> None:
    """Set inertia and angular acceleration at the start of a step."""
    substep_body.mass_matrix[2, 2] = parameters.inertia
    substep_body.inverse[2] = parameters.inv_inertia
    substep_body.acceleration[2] = body.force[2] * parameters.inv_inertia


@njit
def move_body(body: Any, parameters: Any, substep_body: Any, h: Any) -> None:
    """Rotate a body by its displacement in this substep, which ``correction`` holds."""
    _turn(body, substep_body.correction[2])


@njit
def displace_body(body: Any, substep_body: Any) -> None:
    """Move and rotate a body by ``correction``, a displacement without velocity."""
    body.position[0] += substep_body.correction[0]
    body.position[1] += substep_body.correction[1]
    _turn(body, substep_body.correction[2])


@njit
def start_closing(body: Any, substep_body: Any) -> None:
    """Do nothing: rows use the present pose of a 2D body."""


@njit
def spin_to_frame(body: Any, substep_body: Any) -> None:
    """Do nothing: 2D bodies have no frame."""


@njit
def spin_to_world(body: Any, substep_body: Any) -> None:
    """Do nothing."""


@njit
def rotate_from_start(body: Any, substep_body: Any, time: Any) -> None:
    """Set the rotation of a kinematic body ``time`` seconds into the step."""
    body.rotation[0] = substep_body.start_rotation[0]
    body.rotation[1] = substep_body.start_rotation[1]
    body.angle = substep_body.start_angle
    _turn(body, substep_body.displacement[2])


@njit
def _turn(body: Any, angle: Any) -> None:
    body.angle += angle
    body.rotation[0], body.rotation[1] = turn(body.rotation[0], body.rotation[1], angle)


@njit
def path_of_turn(body: Any, substep_body: Any, h: Any) -> Any:
    """Return the angle by which a body turns from the start of the step to ``h`` from now, rad."""
    return abs(substep_body.displacement[2]) + h * abs(body.velocity[2])


@njit
def set_turn(body: Any, substep_body: Any, h: Any) -> None:
    """Set the rotation of a body since the start of the step, now and ``h`` / 2 from now."""
    start = substep_body.start_rotation
    cos, sin = unrotate(start[0], start[1], body.rotation[0], body.rotation[1])
    substep_body.turn[0], substep_body.turn[1] = cos, sin
    c, s = sin_cos(0.5 * h * body.velocity[2])
    substep_body.mid_turn[0], substep_body.mid_turn[1] = rotate(c, s, cos, sin)


@njit
def clear_turn(substep_body: Any) -> None:
    """Set that a body has not turned since the start of the step."""
    for d in range(2):
        substep_body.turn[d] = substep_body.mid_turn[d] = 1.0 - d


@njit
def spin_energy(body: Any, parameters: Any) -> Any:
    """Return the kinetic energy of a body's rotation, J."""
    return 0.5 * parameters.inertia * body.velocity[2] * body.velocity[2]


@njit
def gyration(parameters: Any) -> Any:
    """Return the radius of gyration of a body, m."""
    return (parameters.inertia * parameters.inv_mass) ** 0.5
