"""Rows of joints on a whole pose, welds and targets, in 2D and 3D."""

from __future__ import annotations

from typing import Any

from ..jit import njit
from .dispatch import by_dimension
from .joint_rows import bound_row, finish_row, soften
from .springs import has_spring

set_point_rows = by_dimension("joints.point", "set_point_rows")
set_rotation_rows = by_dimension("joints.weld", "set_rotation_rows")
add_inertia_biases = by_dimension("joints.weld", "add_inertia_biases")
set_stretch_rows = by_dimension("joints.weld", "set_stretch_rows")
anchor_give = by_dimension("joints.reference", "anchor_give")
turn_give = by_dimension("joints.reference", "turn_give")
set_target_direction = by_dimension("joints.target", "set_target_direction")


@njit
def add_weld_rows(
    rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the rows of a weld, rigid or springs. Slots: the anchors, then the rotation of b in a."""
    set_rotation_rows(rows, row, parameters, bodies, substep_bodies)
    if has_spring(parameters):
        set_stretch_rows(rows, row, parameters, bodies, body_parameters, substep_bodies, h)
        a, b = body_parameters[rows[row].body_a], body_parameters[rows[row].body_b]
        along, about = anchor_give(parameters, a, b), turn_give(a, b)
        for r in range(len(rows[row].jacobian_a)):
            give = along if r < len(bodies[0].position) else about
            soften(rows[row + r], parameters, give, 0.0, substep_bodies, h)
    else:
        set_point_rows(rows, row, parameters, bodies, body_parameters, substep_bodies, h)
    add_inertia_biases(rows, row, body_parameters, substep_bodies, h)


@njit
def add_target_rows(
    rows: Any, row: Any, joint: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the rows of a target, springs of bounded force and torque. Slots: the anchor, then the rotation."""
    parameters = joint.parameters
    state = joint.state
    b = rows[row].body_b
    for r in range(len(rows[row].jacobian_a)):
        made = rows[row + r]
        error = set_target_direction(made, r, joint, bodies[b], body_parameters[b], substep_bodies)
        for d in range(len(made.jacobian_a)):
            made.jacobian_a[d] = 0.0
        finish_row(made, r, error, substep_bodies)
        soften(made, parameters, 0.0, state.target_velocity[r], substep_bodies, h)
        linear = r < len(state.target_position)
        bound_row(made, h * (parameters.max_force if linear else parameters.max_torque))
