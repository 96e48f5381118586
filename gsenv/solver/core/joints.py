"""Joints in a step: rows, impulses, drives and substeps of all kinds, in 2D and 3D.

Which rows a kind adds: planar/joints/ and spatial/joints/.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..jit import njit
from ..records.model import ActuatorMode, JointKind
from .coupled import has_half
from .dispatch import by_dimension, no_nutation
from .joint_rows import gear_rows, has_armature, has_friction, has_limit, has_motor
from .pose_joints import add_target_rows, add_weld_rows
from .rows import EQUATION, HALF, UNILATERAL
from .slices import part
from .springs import has_spring

set_effective_mass = by_dimension("contact_rows", "set_effective_mass")
add_user_constraint_rows = by_dimension("joints.user_constraint", "add_user_constraint_rows")
add_linked_rows = by_dimension("joints", "add_linked_rows")
add_reaction = by_dimension("joints", "add_reaction")
move_target = by_dimension("joints.target", "move_target")
set_target = by_dimension("joints.target", "set_target")
keep_near = by_dimension("joints.target", "keep_near")
arm_over_inertia = by_dimension("joints", "arm_over_inertia")
swing_of_side = by_dimension("joints", "swing_of_side")
tension_of = by_dimension("joints", "tension_of")
axle_nutation = by_dimension("joints.gyroscopic_axes", "axle_nutation", otherwise=no_nutation)

_ROWS = int(JointKind.ROWS)
_WELD = int(JointKind.WELD)
_TARGET = int(JointKind.TARGET)
_DISTANCE = int(JointKind.DISTANCE)
_LAST_UNLINKED = _TARGET  # kinds after it need the joint factor
_INFINITY = float("inf")
_VELOCITY = int(ActuatorMode.VELOCITY)
_POSITION = int(ActuatorMode.POSITION)
SWING_PER_SUBSTEP = 1.5  # rad: largest swing of a taut link in a substep
TURN_PER_SUBSTEP = 0.15  # rad: largest rotation in a substep of a body whose anchor is off its centre
OFF_CENTER = (
    0.1  # of the radius: anchors nearer to the centre count as at the centre, as of wheels, and need no more substeps
)
NUTATION_PER_SUBSTEP = (
    0.85  # rad: largest angle by which a top's own inertia rotates the velocity of its arm in two substeps
)


class Joint(NamedTuple):
    """The records of one joint."""

    model: Any
    parameters: Any
    state: Any


@njit
def joint_row_count(model: Any, parameters: Any) -> Any:
    """Return the number of rows of a joint, which its parameters alone determine."""
    if model.kind <= _LAST_UNLINKED:
        return model.row_count
    count = model.row_count + int(has_limit(parameters)) + int(has_motor(parameters)) + int(has_friction(parameters))
    count += int(has_armature(parameters))
    if model.kind == _DISTANCE:
        return count + int(has_spring(parameters) or parameters.rigid != 0)
    return count + int(has_spring(parameters))


@njit
def count_joint_rows(island_joints: Any, joint_models: Any, joint_parameters: Any) -> Any:
    """Return the number of rows of all joints of an island."""
    count = 0
    for k in range(len(island_joints)):
        count += joint_row_count(joint_models[island_joints[k]], joint_parameters[island_joints[k]])
    return count


@njit
def add_joint_rows(world: Any, island: Any, joints: Any, linked: Any, scale: Any) -> None:
    """Write the rows of the island's joints, which come before those of its contacts.

    ``joints``: states, None in a scene without joints; ``linked``: None in a scene that has only user
    constraints, welds and targets.  ``scale``: factor of the stored impulses, 0 for a cold start.
    """
    if joints is None:
        return
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    row = 0
    for k in range(len(island_joints)):
        row = write_joint_rows(world, island_joints[k], row, joints, linked, scale, island.h)


@njit
def write_joint_rows(world: Any, j: Any, row: Any, joints: Any, linked: Any, scale: Any, h: Any) -> Any:
    """Write the rows of joint j from ``rows[row]`` on; returns the place after them. See ``add_joint_rows``."""
    rows = world.scratch.rows
    joint = Joint(world.model.joints[j], world.parameters.joints[j], joints[j])
    end = row + joint_row_count(joint.model, joint.parameters)
    for r in range(row, end):
        rows[r].body_a = joint.model.body_a
        rows[r].body_b = joint.model.body_b
        rows[r].source = j
    _add_rows(world, row, joint, linked, h)
    for r in range(row, end):
        rows[r].impulse = start_impulse(rows[r], joint.state, scale)
    if has_armature(joint.parameters):
        gear_rows(rows, row, end, len(joint.state.impulse) - 1)
    return end


@njit
def start_impulse(row: Any, state: Any, scale: Any) -> Any:
    """Return the impulse that a row starts from: ``scale`` times that of the last substep."""
    slot = row.slot
    if slot < 0:
        return max(-scale * state.impulse[-1 - slot], 0.0)
    if row.correction == UNILATERAL or (row.lower == 0.0 and row.upper == _INFINITY):
        return max(scale * state.impulse[slot], 0.0)
    return scale * state.impulse[slot]


@njit
def fit_to_part(rows: Any, first: Any, end: Any, share: Any, substep_bodies: Any) -> None:
    """Fit rows whose errors and softnesses are given for the usual substeps to those of a part of the step.

    ``share``: length of these over that of the usual ones.
    """
    for r in range(first, end):
        rows[r].error *= share
        if rows[r].softness > 0.0:
            rows[r].softness /= share
            set_effective_mass(rows[r], substep_bodies)


@njit
def _add_rows(world: Any, row: Any, joint: Any, linked: Any, h: Any) -> None:
    """Write the rows of one joint, from ``rows[row]`` on."""
    rows = world.scratch.rows
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    kind = joint.model.kind
    if kind == _ROWS:
        add_user_constraint_rows(rows, row, joint.model, world.parameters.rows, bodies, substep_bodies, h)
        share = world.scratch.division.share[0]
        if share != 1.0:
            fit_to_part(rows, row, row + joint.model.row_count, share, substep_bodies)
    elif kind == _WELD:
        add_weld_rows(rows, row, joint.parameters, bodies, body_parameters, substep_bodies, h)
    elif kind == _TARGET:
        add_target_rows(rows, row, joint, bodies, body_parameters, substep_bodies, h)
    elif linked is not None:
        add_linked_rows(world, rows, row, joint, bodies, body_parameters, substep_bodies, h)


@njit
def store_joint_impulses(world: Any, island: Any, joints: Any) -> None:
    """Store the impulses of a substep for the next one, and add them to the reactions of the step."""
    rows = world.scratch.rows
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    scale = island.stored_scale
    for r in range(island.joint_rows):
        row = rows[r]
        j = row.source
        state = joints[j]
        if row.kind == HALF:
            pass  # its impulse is that of the row before it
        elif row.slot < 0:
            if scale > 0.0:
                state.impulse[-1 - row.slot] = -scale * row.impulse
            state.total_impulse[-1 - row.slot] -= row.impulse
        else:
            if scale > 0.0:
                state.impulse[row.slot] = scale * row.impulse
            state.total_impulse[row.slot] += row.impulse
            if row.slot == len(state.impulse) - 1:
                state.rate -= row.softness * row.impulse
        if has_half(rows, r, island.joint_rows):
            continue  # reactions are those on the second joint's body b
        ahead = 0.0  # s: rows are of the pose at the start of the substep, or half a substep ahead
        if joint_models[j].kind > _LAST_UNLINKED or joint_models[j].kind == _WELD:
            ahead = 0.5 * island.h
        i = row.body_b
        add_reaction(row, joint_parameters[j], bodies[i], body_parameters[i], substep_bodies[i], state, ahead)


@njit
def forget_joint_impulses(rows: Any, end: Any, joints: Any) -> None:
    """Set the stored impulses of rows that contradict each other to 0: with warm starts they would grow."""
    for r in range(end):
        for d in range(len(joints[rows[r].source].impulse)):
            joints[rows[r].source].impulse[d] = 0.0


@njit
def any_driven(island_joints: Any, joint_models: Any, joint_parameters: Any) -> Any:
    """Whether a joint may do work on the island, so that the energy guard must not act."""
    for k in range(len(island_joints)):
        kind = joint_models[island_joints[k]].kind
        parameters = joint_parameters[island_joints[k]]
        if kind == _ROWS or kind == _TARGET or has_motor(parameters):
            return True
    return False


@njit
def any_equation(rows: Any, end: Any) -> Any:
    """Whether a row is an equation."""
    for r in range(end):
        if rows[r].kind == EQUATION:
            return True
    return False


@njit
def start_joints(joints: Any, joint_parameters: Any) -> None:
    """Set the impulses and reactions of disabled joints to 0."""
    for j in range(len(joints)):
        if joint_parameters[j].enabled == 0:
            state = joints[j]
            for d in range(len(state.impulse)):
                state.impulse[d] = 0.0
                state.total_impulse[d] = 0.0
            for d in range(len(state.reaction)):
                state.reaction[d] = 0.0


@njit
def clear_totals(island_joints: Any, joints: Any) -> None:
    """Set the sums over the step to 0; joints of sleeping islands keep theirs."""
    for k in range(len(island_joints)):
        state = joints[island_joints[k]]
        for d in range(len(state.total_impulse)):
            state.total_impulse[d] = 0.0
        for d in range(len(state.reaction)):
            state.reaction[d] = 0.0


@njit
def drive_joints(world: Any, joints: Any) -> None:
    """Apply the control, clipped to the range of each actuator."""
    if joints is None:
        return
    actuators = world.model.actuators
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    control = world.state.control
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    for k in range(len(actuators)):
        actuator = actuators[k]
        value = actuator.gain * min(max(control[k], actuator.lower), actuator.upper) + actuator.offset
        j = actuator.joint
        state = joints[j]
        if joint_models[j].kind == _TARGET:
            i = actuator.body
            _drive_target(actuator, value, state, joint_parameters[j], bodies[i], body_parameters[i])
        elif actuator.mode == _VELOCITY:
            state.motor_speed = value
        elif actuator.mode == _POSITION:
            state.rest = value
        else:
            state.effort = value


@njit
def _drive_target(actuator: Any, value: Any, state: Any, parameters: Any, body: Any, masses: Any) -> None:
    """Set the target's velocity or position from an actuator's value.

    A target driven by velocity waits for a body that cannot follow: it stays within the distance at
    which its spring reaches the force bound, which prevents windup.
    """
    if actuator.mode == _VELOCITY:
        state.target_velocity[actuator.axis] = value
        keep_near(state, actuator.axis, parameters, body, masses)
    else:
        set_target(state, actuator.axis, value)


@njit
def move_targets(island_joints: Any, joint_models: Any, joints: Any, h: Any) -> None:
    """Move the target poses by ``h`` s at the velocities of the targets."""
    for k in range(len(island_joints)):
        if joint_models[island_joints[k]].driven:
            move_target(joints[island_joints[k]], h)


@njit
def substeps_for(world: Any, island: Any, joints: Any) -> Any:
    """Return the number of substeps that keeps taut joints stable and rotating bodies accurate.

    The tension T is that of the last step.

    A link under tension swings at omega^2 = T (r_a / I_a + r_b / I_b); the explicit step follows it for
    omega h < 2.  Rods and ropes: see ``rod_swing``.
    """
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    dt = world.options.timestep
    least = island.substeps
    most = world.options.max_substeps
    fastest = rod_swing(world, island_joints, joints, dt)
    spin = 0.0
    nutation = 0.0
    for k in range(len(island_joints)):
        j = island_joints[k]
        model = joint_models[j]
        if model.kind == _ROWS or model.kind == _TARGET:
            continue
        tension = tension_of(joints[j]) / dt
        a = body_parameters[model.body_a]
        b = body_parameters[model.body_b]
        parameters = joint_parameters[j]
        square, turn_a, top_a = swing_of_side(bodies[model.body_a], a, parameters.anchor_a)
        more, turn_b, top_b = swing_of_side(bodies[model.body_b], b, parameters.anchor_b)
        square += more
        spin = max(spin, max(turn_a, turn_b))
        nutation = max(nutation, max(top_a, top_b))
        nutation = max(nutation, axle_nutation(world, j, world.variant.axes))
        if model.kind != _DISTANCE:
            fastest = max(fastest, tension * square)
    island.swing = fastest
    needed = max(dt * fastest**0.5 / SWING_PER_SUBSTEP, dt * spin / TURN_PER_SUBSTEP)
    count = min(max(least, int(np.ceil(min(needed, 1e6)))), max(least, most))
    finer = max(least, int(world.scratch.division.finest[0]))
    tops = 0.5 * finer * dt * nutation / NUTATION_PER_SUBSTEP  # more where the options ask for more substeps
    return max(count, min(int(np.ceil(min(tops, 1e6))), max(most, 2 * least)))


@njit
def rod_swing(world: Any, island_joints: Any, joints: Any, dt: Any) -> Any:
    """Return a bound of the squared frequency, 1/s^2, at which taut rods and ropes swing; 0 without any.

    With the sum of ``swing`` over all joints of a body, the largest frequency of the whole is at most that of two
    bodies on one rod together (Anderson and Morley, "Eigenvalues of the Laplacian of a graph", Linear and
    Multilinear Algebra 18, 1985); in a straight chain it is equal.
    """
    joint_models = world.model.joints
    for k in range(len(island_joints)):
        if joint_models[island_joints[k]].kind == _DISTANCE:
            break
    else:
        return 0.0
    sum_swings(world, island_joints, joints, dt)
    substep_bodies = world.scratch.substep_bodies
    largest = 0.0
    for k in range(len(island_joints)):
        model = joint_models[island_joints[k]]
        if model.kind == _DISTANCE:
            largest = max(largest, substep_bodies[model.body_a].swing + substep_bodies[model.body_b].swing)
    return largest


@njit
def sum_swings(world: Any, island_joints: Any, joints: Any, dt: Any) -> None:
    """Set ``swing`` of the substep bodies to the sum over their joints, for the tensions T of the last step.

    A rod of length L pulls back an end that moves sideways with the stiffness T / L, on the inverse mass 1/m + r^2/I
    of that point, and it rotates a body whose arm is r by T r / I; a pin does only the latter.
    """
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    for k in range(len(island_joints)):
        model = joint_models[island_joints[k]]
        substep_bodies[model.body_a].swing = 0.0
        substep_bodies[model.body_b].swing = 0.0
    for k in range(len(island_joints)):
        j = island_joints[k]
        model = joint_models[j]
        if model.kind == _ROWS or model.kind == _TARGET:
            continue
        parameters = joint_parameters[j]
        tension = tension_of(joints[j]) / dt
        length = rod_length(parameters) if model.kind == _DISTANCE else 0.0
        a = model.body_a
        b = model.body_b
        substep_bodies[a].swing += tension * _swing_on(body_parameters[a], parameters.anchor_a, length)
        substep_bodies[b].swing += tension * _swing_on(body_parameters[b], parameters.anchor_b, length)


@njit
def rod_length(parameters: Any) -> Any:
    """Return the length of a rod, or the largest of a rope, in m."""
    return parameters.length if parameters.rigid or parameters.upper == np.inf else parameters.upper


@njit
def _swing_on(masses: Any, anchor: Any, length: Any) -> Any:
    """Return the squared frequency of a body for each newton of tension, on a rod or, with ``length`` 0, on a pin."""
    square = arm_over_inertia(masses, anchor)
    if length <= 0.0:
        return square
    reach = 0.0
    for d in range(len(anchor)):
        reach += (anchor[d] - masses.center[d]) ** 2
    return square + (masses.inv_mass + reach**0.5 * square) / length


@njit
def slow_swings(world: Any, island: Any, joints: Any) -> None:
    """Increase the inertia of bodies on taut joints that swing faster than the substeps can follow.

    Explicit steps need omega h < 2, and the number of substeps is limited.  Mass scaling keeps such a body stable: it
    does not change its weight, nor the tension.  The mass that it adds is about T h^2 / L, which is small compared
    with the load T / g wherever g h^2 is small compared with L.  Where nothing holds the island, T is no load: there
    the added mass falls as all mass does.
    Source: L. Olovsson, K. Simonsson, M. Unosson, "Selective mass scaling for explicit finite element analyses",
    Int. J. Numer. Meth. Engng 63 (2005).
    """
    most = (SWING_PER_SUBSTEP * island.substeps / world.options.timestep) ** 2
    if island.swing <= most:
        return
    island.slowed = True
    substep_bodies = world.scratch.substep_bodies
    solver_bodies = world.scratch.solver_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    for k in range(len(island_bodies)):
        substep_bodies[island_bodies[k]].swing = 0.0
    sum_swings(world, island_joints, joints, world.options.timestep)
    first = 0 if is_held(world, island) else len(world.state.bodies[0].position)  # degree of freedom that is slowed
    for k in range(len(island_bodies)):
        body = substep_bodies[island_bodies[k]]
        factor = 2.0 * body.swing / most
        if factor <= 1.0:
            continue
        for d in range(len(body.inverse)):
            body.inverse[d] /= factor
            if d >= first:
                body.acceleration[d] /= factor
            body.constrained_acceleration[d] = body.acceleration[d]
            body.mass_matrix[d, d] *= factor
            solver_bodies[island_bodies[k]].inverse[d] = body.inverse[d]


@njit
def is_held(world: Any, island: Any) -> Any:
    """Whether a contact or a joint connects the island to a body that is not dynamic."""
    parameters = world.parameters.bodies
    contacts = world.state.contacts
    joint_models = world.model.joints
    island_contacts = part(world.scratch.island_contacts, island.contact_first, island.contact_count)
    for k in range(len(island_contacts)):
        contact = contacts[island_contacts[k]]
        if parameters[contact.body_a].inv_mass == 0.0 or parameters[contact.body_b].inv_mass == 0.0:
            return True
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    for k in range(len(island_joints)):
        model = joint_models[island_joints[k]]
        if parameters[model.body_a].inv_mass == 0.0 or parameters[model.body_b].inv_mass == 0.0:
            return True
    return False
