"""Rotation of 3D bodies, and the frame of a body in a substep: its principal axes half a substep ahead.

In this frame the inertia is diagonal, so that solver bodies have a vector of inverse masses as in 2D.
A substep is split symmetrically: the body rotates freely and exactly for half of it, takes all impulses and
torques at the midpoint, and rotates freely again.  A top therefore precesses at the right rate however
fast it rotates.  A body with equal moments keeps the axes of the world.  Between ``enter_frames`` and
``move_body`` the angular parts of ``velocity`` and of all ``substep_bodies`` are in this frame, at the midpoint
of the substep.
"""

from __future__ import annotations

from typing import Any

from ..core.slices import part
from ..jit import njit
from .free_rotation import rotate_with_velocity
from .math import (
    Vec,
    add,
    conjugate,
    cross,
    dot,
    multiply,
    near_turn_of,
    near_unit,
    normalised,
    pose_of,
    quaternion,
    scaled,
    sub,
    turn_of,
    turned,
    vec,
)

EQUAL = 1e-9  # of a moment: two that differ by less count as equal


@njit
def in_frame(substep_body: Any, v: Vec) -> Vec:
    """Return a direction of the world in the body's frame."""
    f = substep_body.frame
    return (
        f[0, 0] * v[0] + f[0, 1] * v[1] + f[0, 2] * v[2],
        f[1, 0] * v[0] + f[1, 1] * v[1] + f[1, 2] * v[2],
        f[2, 0] * v[0] + f[2, 1] * v[1] + f[2, 2] * v[2],
    )


@njit
def in_world(substep_body: Any, v: Vec) -> Vec:
    f = substep_body.frame
    return (
        f[0, 0] * v[0] + f[1, 0] * v[1] + f[2, 0] * v[2],
        f[0, 1] * v[0] + f[1, 1] * v[1] + f[2, 1] * v[2],
        f[0, 2] * v[0] + f[1, 2] * v[1] + f[2, 2] * v[2],
    )


@njit
def spin_of(field: Any) -> Vec:
    """Return the angular part of a field of length six."""
    return field[3], field[4], field[5]


@njit
def set_spin(field: Any, v: Vec) -> None:
    field[3] = v[0]
    field[4] = v[1]
    field[5] = v[2]


@njit
def _set_world_frame(substep_body: Any) -> None:
    for i in range(3):
        for j in range(3):
            substep_body.frame[i, j] = 1.0 if i == j else 0.0


@njit
def is_round(parameters: Any) -> Any:
    """Whether all three moments are equal, so that rotation does not depend on the axes."""
    i = parameters.inertia
    return abs(i[0] - i[1]) <= EQUAL * i[0] and abs(i[0] - i[2]) <= EQUAL * i[0]


@njit
def begin_rotation(body: Any, parameters: Any, substep_body: Any) -> None:
    """Set the inertia at the start of a step, with the world's frame."""
    _set_world_frame(substep_body)
    substep_body.rotated_frame = 1 if parameters.inv_mass > 0.0 and not is_round(parameters) else 0
    for d in range(3):
        substep_body.mass_matrix[3 + d, 3 + d] = parameters.inertia[d]
        substep_body.inverse[3 + d] = parameters.inv_inertia[d]
        substep_body.acceleration[3 + d] = 0.0


@njit
def flies_freely(world: Any, island: Any) -> Any:
    """Whether the island has no contacts, joints or damping: then one substep is exact at any timestep."""
    if island.contact_count + island.joint_count > 0:
        return False
    body_parameters = world.parameters.bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    for k in range(len(island_bodies)):
        parameters = body_parameters[island_bodies[k]]
        if parameters.linear_damping != 0.0 or parameters.angular_damping != 0.0:
            return False
    return True


@njit
def enter_frames(world: Any, island: Any) -> None:
    """Rotate bodies freely for half a substep, and transform all angular quantities to their frames there."""
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        substep_body = substep_bodies[i]
        parameters = body_parameters[i]
        torque = spin_of(bodies[i].force)
        if substep_body.rotated_frame:
            _enter_frame(bodies[i], parameters, substep_body, island.h)
            torque = in_frame(substep_body, torque)
        for d in range(3):
            substep_body.acceleration[3 + d] = torque[d] * parameters.inv_inertia[d]
        for d in range(6):
            substep_body.constrained_acceleration[d] = substep_body.acceleration[d]


@njit
def _enter_frame(body: Any, parameters: Any, substep_body: Any, h: Any) -> None:
    shift = in_world(substep_body, spin_of(substep_body.displacement))
    axes = quaternion(parameters.axes)
    principal = multiply(quaternion(body.rotation), axes)
    middle, spin = rotate_with_velocity(principal, vec(parameters.inertia), spin_of(body.velocity), 0.5 * h)
    rotation = multiply(middle, conjugate(axes))
    for d in range(4):
        substep_body.mid_rotation[d] = rotation[d]
    own = pose_of((0.0, 0.0, 0.0), middle)
    for d in range(3):
        substep_body.frame[0, d] = own.x[d]
        substep_body.frame[1, d] = own.y[d]
        substep_body.frame[2, d] = own.z[d]
    set_spin(body.velocity, in_frame(substep_body, spin))
    set_spin(substep_body.displacement, in_frame(substep_body, shift))


@njit
def _leave_frame(body: Any, parameters: Any, substep_body: Any, extra: Vec, h: Any) -> None:
    """Rotate a body freely for the other half of the substep, with the velocity after the solve.

    ``extra``: further rotation, rad in the frame; the velocity is rotated with the body to keep the energy.
    """
    axes = quaternion(parameters.axes)
    turn = near_turn_of(in_world(substep_body, extra))
    middle = multiply(turn, multiply(quaternion(substep_body.mid_rotation), axes))
    spin = turned(turn, in_world(substep_body, spin_of(body.velocity)))
    after, spin = rotate_with_velocity(middle, vec(parameters.inertia), spin, 0.5 * h)
    rotation = near_unit(multiply(after, conjugate(axes)))
    for d in range(4):
        body.rotation[d] = rotation[d]
    set_spin(body.velocity, spin)


@njit
def leave_frames(world: Any, island: Any) -> None:
    """Rotate the angular velocities of bodies back from their frames to the start of the substep, in the world."""
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        substep_body = substep_bodies[i]
        if substep_body.rotated_frame:
            parameters = body_parameters[i]
            body = world.state.bodies[i]
            middle = multiply(quaternion(substep_body.mid_rotation), quaternion(parameters.axes))
            spin = in_world(substep_body, spin_of(body.velocity))
            _, spin = rotate_with_velocity(middle, vec(parameters.inertia), spin, -0.5 * island.h)
            set_spin(body.velocity, spin)


@njit
def spin_change(substep_body: Any, parameters: Any) -> Vec:
    """Return the angular acceleration by the body's own inertia, rad/s^2 in the frame: I^-1 (I w x w)."""
    if substep_body.rotated_frame == 0:
        return 0.0, 0.0, 0.0
    w = spin_of(substep_body.start_velocity)
    i = parameters.inertia
    turning = cross((i[0] * w[0], i[1] * w[1], i[2] * w[2]), w)
    return turning[0] / i[0], turning[1] / i[1], turning[2] / i[2]


@njit
def expected_spin(substep_body: Any, velocity: Any) -> Vec:
    """Return the spin in the body's frame after the impulses of the last substep, for terms that are quadratic in it.

    Where that differs from the spin at the start by more than the spin itself, as after an impact on a limit or where a
    motor has changed its direction, the last impulses tell nothing, and the spin at the start is returned.
    """
    spin = spin_of(velocity)
    start = spin_of(substep_body.start_velocity)
    change = sub(spin, start)
    return spin if dot(change, change) <= dot(start, start) else start


@njit
def any_rotated_frame(world: Any, island: Any) -> Any:
    """Whether a body of the island has a frame that rotates with it."""
    substep_bodies = world.scratch.substep_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    for k in range(len(island_bodies)):
        if substep_bodies[island_bodies[k]].rotated_frame:
            return True
    return False


@njit
def move_body(body: Any, parameters: Any, substep_body: Any, h: Any) -> None:
    """Rotate a body by its displacement in this substep, which ``correction`` holds; a rotated frame ends here."""
    turn = spin_of(substep_body.correction)
    if substep_body.rotated_frame:
        old = spin_of(substep_body.start_velocity)
        new = spin_of(body.velocity)
        mean = scaled(add(old, new), 0.5 * h)  # rad, by both halves of the free rotation
        _leave_frame(body, parameters, substep_body, sub(turn, mean), h)
    else:
        rotate_body(body, body.rotation, turn)


@njit
def displace_body(body: Any, substep_body: Any) -> None:
    """Move and rotate a body by ``correction``, a displacement without velocity.

    A tilted body's angular velocity rotates with it: otherwise its energy would change.
    """
    turn = in_world(substep_body, spin_of(substep_body.correction))
    for d in range(3):
        body.position[d] += substep_body.correction[d]
    if substep_body.rotated_frame:
        set_spin(body.velocity, turned(turn_of(turn), spin_of(body.velocity)))
    rotate_body(body, body.rotation, turn)


@njit
def path_of_turn(body: Any, substep_body: Any, h: Any) -> Any:
    """Return a bound of the angle by which a body turns from the start of the step to ``h`` from now, rad."""
    turn = substep_body.displacement
    spin = body.velocity
    return abs(turn[3]) + abs(turn[4]) + abs(turn[5]) + h * (abs(spin[3]) + abs(spin[4]) + abs(spin[5]))


@njit
def set_turn(body: Any, substep_body: Any, h: Any) -> None:
    """Set the rotation of a body since the start of the step, now and ``h`` / 2 from now."""
    back = conjugate(quaternion(substep_body.start_rotation))
    now = multiply(quaternion(body.rotation), back)
    if substep_body.rotated_frame:
        middle = multiply(quaternion(substep_body.mid_rotation), back)
    else:
        middle = multiply(turn_of(scaled(spin_of(body.velocity), 0.5 * h)), now)
    for d in range(4):
        substep_body.turn[d] = now[d]
        substep_body.mid_turn[d] = middle[d]


@njit
def clear_turn(substep_body: Any) -> None:
    """Set that a body has not turned since the start of the step."""
    for d in range(4):
        substep_body.turn[d] = substep_body.mid_turn[d] = 1.0 if d == 0 else 0.0


@njit
def start_closing(body: Any, substep_body: Any) -> None:
    """Make the present rotation that from which rows are made."""
    for d in range(4):
        substep_body.mid_rotation[d] = body.rotation[d]


@njit
def spin_to_frame(body: Any, substep_body: Any) -> None:
    """Express the angular velocity of a body after the substep in the frame of the substep."""
    if substep_body.rotated_frame:
        set_spin(body.velocity, in_frame(substep_body, spin_of(body.velocity)))


@njit
def spin_to_world(body: Any, substep_body: Any) -> None:
    """Express the angular velocity in the world again."""
    if substep_body.rotated_frame:
        set_spin(body.velocity, in_world(substep_body, spin_of(body.velocity)))


@njit
def rotate_from_start(body: Any, substep_body: Any, time: Any) -> None:
    """Set the rotation of a kinematic body ``time`` seconds into the step."""
    rotate_body(body, substep_body.start_rotation, scaled(spin_of(body.velocity), time))


@njit
def rotate_body(body: Any, rotation: Any, turn: Vec) -> None:
    """Set the body's rotation to ``rotation``, rotated further by ``turn`` rad in the world."""
    q = normalised(multiply(turn_of(turn), quaternion(rotation)))
    for d in range(4):
        body.rotation[d] = q[d]


@njit
def enter_link_frames(world: Any, island: Any) -> None:
    """In joint coordinates: take the principal axes of the present poses of all links as the frames of their bodies.

    Their inertia is diagonal there.  ``rotated_frame`` stays 0, since the rates of links contain the free rotation.
    """
    links = world.scratch.articulation.links
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    for k in range(island.body_count):
        i = links[k].body
        substep_body = substep_bodies[i]
        axes = multiply(quaternion(links[k].rotation), quaternion(body_parameters[i].axes))
        own = pose_of((0.0, 0.0, 0.0), axes)
        for d in range(3):
            substep_body.frame[0, d] = own.x[d]
            substep_body.frame[1, d] = own.y[d]
            substep_body.frame[2, d] = own.z[d]
            substep_body.inverse[3 + d] = body_parameters[i].inv_inertia[d]
        set_spin(substep_body.start_velocity, in_frame(substep_body, spin_of(substep_body.start_velocity)))
        set_spin(substep_body.free_velocity, in_frame(substep_body, spin_of(substep_body.free_velocity)))


@njit
def leave_link_frames(world: Any, island: Any) -> None:
    """Express the Jacobians of rows of joints in no tree, and the velocities, in the world again."""
    rows = world.scratch.rows
    links = world.scratch.articulation.links
    substep_bodies = world.scratch.substep_bodies
    for r in range(island.other_rows):
        row = rows[r]
        set_spin(row.jacobian_a, in_world(substep_bodies[row.body_a], spin_of(row.jacobian_a)))
        set_spin(row.jacobian_b, in_world(substep_bodies[row.body_b], spin_of(row.jacobian_b)))
    for k in range(island.body_count):
        substep_body = substep_bodies[links[k].body]
        set_spin(substep_body.start_velocity, in_world(substep_body, spin_of(substep_body.start_velocity)))
        set_spin(substep_body.free_velocity, in_world(substep_body, spin_of(substep_body.free_velocity)))
        _set_world_frame(substep_body)


@njit
def spin_energy(body: Any, parameters: Any) -> Any:
    """Return the kinetic energy of a body's rotation in J; its velocity must be in the world."""
    axes = pose_of((0.0, 0.0, 0.0), multiply(quaternion(body.rotation), quaternion(parameters.axes)))
    spin = spin_of(body.velocity)
    x, y, z = dot(axes.x, spin), dot(axes.y, spin), dot(axes.z, spin)
    inertia = parameters.inertia
    return 0.5 * (inertia[0] * x * x + inertia[1] * y * y + inertia[2] * z * z)


@njit
def gyration(parameters: Any) -> Any:
    """Return the largest radius of gyration of a body, m."""
    inertia = parameters.inertia
    return (max(inertia[0], inertia[1], inertia[2]) * parameters.inv_mass) ** 0.5
