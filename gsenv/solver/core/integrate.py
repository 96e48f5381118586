"""Velocities and poses of free bodies over one substep, second order in smooth motion.

Rotation differs in 2D and 3D: see planar/rotation.py and spatial/rotation.py.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from .dispatch import by_dimension
from .islands import ASLEEP, is_kinematic
from .slices import part
from .turning import forget_turn

begin_rotation = by_dimension("rotation", "begin_rotation")
move_body = by_dimension("rotation", "move_body")
rotate_from_start = by_dimension("rotation", "rotate_from_start")


@njit
def start_bodies(world: Any) -> None:
    """Start the scratch of all bodies but sleeping ones: accelerations, start poses, no displacement."""
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    gravity = world.parameters.world.gravity
    islands = world.scratch.islands
    substep_bodies = world.scratch.substep_bodies
    solver_bodies = world.scratch.solver_bodies
    for i in range(len(bodies)):
        forget_turn(substep_bodies[i])
        if islands[i].label != ASLEEP:
            _start_body(bodies[i], body_parameters[i], gravity, substep_bodies[i])
            _start_solver_body(bodies[i], substep_bodies[i], solver_bodies[i])


@njit
def _start_body(body: Any, parameters: Any, gravity: Any, substep_body: Any) -> None:
    for d in range(len(body.velocity)):
        for e in range(len(body.velocity)):
            substep_body.mass_matrix[d, e] = 0.0
    for d in range(len(gravity)):
        substep_body.mass_matrix[d, d] = parameters.mass
        substep_body.inverse[d] = parameters.inv_mass
        substep_body.acceleration[d] = 0.0
        if parameters.inv_mass > 0.0:
            scale = parameters.gravity_scale
            substep_body.acceleration[d] = gravity[d] * scale + body.force[d] * parameters.inv_mass
        substep_body.start_position[d] = body.position[d]
    for d in range(len(body.rotation)):
        substep_body.start_rotation[d] = body.rotation[d]
    substep_body.start_angle = body.angle
    begin_rotation(body, parameters, substep_body)
    for d in range(len(body.velocity)):
        substep_body.constrained_acceleration[d] = substep_body.acceleration[d]
        substep_body.displacement[d] = 0.0
        substep_body.impact_displacement[d] = 0.0
        substep_body.correction[d] = 0.0
        substep_body.start_velocity[d] = body.velocity[d]
        substep_body.free_velocity[d] = body.velocity[d]


@njit
def _start_solver_body(body: Any, substep_body: Any, solver_body: Any) -> None:
    for d in range(len(body.velocity)):
        solver_body.inverse[d] = substep_body.inverse[d]
        solver_body.velocity[d] = body.velocity[d]
        solver_body.start[d] = body.velocity[d]


@njit
def hold_disabled(bodies: Any, body_parameters: Any, substep_bodies: Any) -> None:
    """Set the velocity of disabled bodies, which act as fixed for their joints, to 0 and keep it in scratch."""
    for i in range(len(bodies)):
        if body_parameters[i].enabled == 0:
            for d in range(len(bodies[i].velocity)):
                substep_bodies[i].saved_velocity[d] = bodies[i].velocity[d]
                bodies[i].velocity[d] = 0.0


@njit
def release_disabled(bodies: Any, body_parameters: Any, substep_bodies: Any) -> None:
    """Restore the velocities of disabled bodies: once enabled again, a body continues with its own velocity."""
    for i in range(len(bodies)):
        if body_parameters[i].enabled == 0:
            for d in range(len(bodies[i].velocity)):
                bodies[i].velocity[d] = substep_bodies[i].saved_velocity[d]


@njit
def keep_velocities(island_bodies: Any, bodies: Any, substep_bodies: Any) -> None:
    """Make the present velocities the start velocities of the substep."""
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        for d in range(len(bodies[i].velocity)):
            substep_bodies[i].start_velocity[d] = bodies[i].velocity[d]


@njit
def integrate_velocities(world: Any, island: Any) -> None:
    """Set v += h a, then v /= 1 + h c for implicit damping; copies v to the solver bodies."""
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    solver_bodies = world.scratch.solver_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    h = island.h
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        body = bodies[i]
        substep_body = substep_bodies[i]
        linear = 1.0 / (1.0 + h * body_parameters[i].linear_damping)
        angular = 1.0 / (1.0 + h * body_parameters[i].angular_damping)
        for d in range(len(body.velocity)):
            substep_body.start_velocity[d] = body.velocity[d]
            damping = linear if d < len(body.position) else angular
            v = (body.velocity[d] + h * substep_body.acceleration[d]) * damping
            body.velocity[d] = v
            substep_body.free_velocity[d] = v
            substep_body.correction[d] = 0.0
            solver_bodies[i].velocity[d] = v
            solver_bodies[i].start[d] = v


@njit
def copy_velocities(island_bodies: Any, bodies: Any, solver_bodies: Any) -> None:
    """Copy the velocities of the solver bodies to the bodies."""
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        for d in range(len(bodies[i].velocity)):
            bodies[i].velocity[d] = solver_bodies[i].velocity[d]


@njit
def integrate_positions(world: Any, island: Any) -> None:
    """Set x += h (v + correction) + impact_displacement.

    With ``island.smooth`` = 1, v is the mean of old and new velocity.  The mean
    makes smooth motion second order (a parabola exact); ``smooth`` is 0 where a velocity jumped at a contact,
    since the mean would move the body into the other one.
    """
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    h = island.h
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        body = bodies[i]
        substep_body = substep_bodies[i]
        for d in range(len(body.velocity)):
            v = body.velocity[d] + 0.5 * island.smooth * (substep_body.start_velocity[d] - body.velocity[d])
            step = h * (v + substep_body.correction[d]) + substep_body.impact_displacement[d]
            substep_body.correction[d] = step  # from here on the displacement of the substep
            substep_body.displacement[d] += step
            substep_body.impact_displacement[d] = 0.0
        for d in range(len(body.position)):
            body.position[d] += substep_body.correction[d]
        move_body(body, body_parameters[i], substep_body, h)


@njit
def any_kinematic(bodies: Any, body_models: Any, body_parameters: Any) -> Any:
    """Whether there is an enabled kinematic body."""
    for i in range(len(bodies)):
        if is_kinematic(body_models[i], body_parameters[i]):
            return True
    return False


@njit
def move_kinematic(world: Any, time: Any) -> None:
    """Move kinematic bodies to their pose ``time`` seconds into the step."""
    bodies = world.state.bodies
    body_models = world.model.bodies
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    for i in range(len(bodies)):
        if is_kinematic(body_models[i], body_parameters[i]):
            body = bodies[i]
            substep_body = substep_bodies[i]
            for d in range(len(body.velocity)):
                substep_body.displacement[d] = body.velocity[d] * time
            for d in range(len(body.position)):
                body.position[d] = substep_body.start_position[d] + substep_body.displacement[d]
            rotate_from_start(body, substep_body, time)


@njit
def clear_forces(bodies: Any) -> None:
    """Set the applied forces to 0."""
    for i in range(len(bodies)):
        for d in range(len(bodies[i].force)):
            bodies[i].force[d] = 0.0


@njit
def any_lost(bodies: Any) -> Any:
    """Whether the position, velocity or rotation of a body is not finite; readings/diagnostics.py says of which."""
    total = 0.0  # NaN where one is not: 0 times NaN or infinity is NaN
    for i in range(len(bodies)):
        turn = 0.0  # 1; an angle that overflows gives NaN or 0
        for d in range(len(bodies[i].rotation)):
            turn += bodies[i].rotation[d] * bodies[i].rotation[d]
        if not 0.5 < turn < 2.0:
            return True
        for d in range(len(bodies[i].position)):
            total += 0.0 * bodies[i].position[d]
        for d in range(len(bodies[i].velocity)):
            total += 0.0 * bodies[i].velocity[d]
    return total != 0.0


@njit
def copy_pose(source: Any, target: Any) -> None:
    """Copy position, rotation and angle of a body's record to another record that has these fields."""
    for d in range(len(source.position)):
        target.position[d] = source.position[d]
    for d in range(len(source.rotation)):
        target.rotation[d] = source.rotation[d]
    target.angle = source.angle
