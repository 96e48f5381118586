"""Guard of the kinetic energy of islands whose masses ``slow_swings`` scales, by a factor that is new in each step.

What their substeps keep is the energy with scaled masses, and over the steps the true one may grow without limit.
Where nothing drives such an island, its kinetic energy and that of its springs should change by no more than the work
of gravity and applied forces.  What a step loses is a credit for the next ones, since the error of a step has both
signs; the credit fades, so that what friction takes is not given back much later.  A gain beyond it is taken out of the
velocities.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..records.model import JointKind
from .dispatch import by_dimension
from .joint_rows import has_armature
from .joints import Joint, is_held
from .slices import part

read_joint = by_dimension("joint_readings", "read_joint")
spin_energy = by_dimension("rotation", "spin_energy")

FADING = 0.999  # of the credit is left after a step; with 0.99 a slow swing would lose what it regains much later
_ROWS = int(JointKind.ROWS)
_TARGET = int(JointKind.TARGET)
_GEAR = int(JointKind.GEAR)


@njit
def start_step_energy(world: Any, island: Any, joints: Any) -> None:
    """Set whether the guard acts on the island in this step, and keep its energy at the start."""
    island.guarded = False
    if joints is None:
        return
    if not island.slowed or island.driven or world.variant.soft is not None:
        return
    if _any_rotor(world, island) or _any_torque(world, island):
        return
    island.guarded = True
    island.energy = _kinetic_energy(world, island) + _spring_energy(world, island, joints)


@njit
def _any_rotor(world: Any, island: Any) -> Any:
    """Whether a joint has a rotor, whose energy is not measured here."""
    joint_parameters = world.parameters.joints
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    for k in range(len(island_joints)):
        if has_armature(joint_parameters[island_joints[k]]):
            return True
    return False


@njit
def _any_torque(world: Any, island: Any) -> Any:
    """Whether a torque is applied to a body, whose work is not measured here."""
    bodies = world.state.bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    for k in range(len(island_bodies)):
        body = bodies[island_bodies[k]]
        for d in range(len(body.position), len(body.force)):
            if body.force[d] != 0.0:
                return True
    return False


@njit
def _kinetic_energy(world: Any, island: Any) -> Any:
    """Return the kinetic energy of the island in J, with its true masses and velocities in the world."""
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    energy = 0.0
    for k in range(len(island_bodies)):
        body = bodies[island_bodies[k]]
        parameters = body_parameters[island_bodies[k]]
        for d in range(len(body.position)):
            energy += 0.5 * parameters.mass * body.velocity[d] * body.velocity[d]
        energy += spin_energy(body, parameters)
    return energy


@njit
def _spring_energy(world: Any, island: Any, joints: Any) -> Any:
    """Return the energy in J of the springs and soft limits of the island."""
    energy = 0.0
    if not island.has_springs:
        return energy
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    for k in range(len(island_joints)):
        j = island_joints[k]
        model = joint_models[j]
        if model.kind == _ROWS or model.kind == _TARGET or model.kind == _GEAR:
            continue
        a = model.body_a
        b = model.body_b
        joint = Joint(model, joint_parameters[j], joints[j])
        _, stored = read_joint(bodies[a], bodies[b], body_parameters[a], body_parameters[b], joint)
        energy += stored
    return energy


@njit
def guard_step_energy(world: Any, island: Any, joints: Any) -> None:
    """At the end of the step, take a gain beyond the credit of the island out of the velocities."""
    if joints is None:
        return
    if not island.guarded:
        return
    kinetic = _kinetic_energy(world, island)
    credit = FADING * _take_credit(world, island, joints)
    energy = kinetic + _spring_energy(world, island, joints)
    credit -= energy - island.energy - _work(world, island)
    if credit < 0.0:
        _slow_down(world, island, kinetic, -credit)
    if credit > 0.0:  # false, too, where a body is lost
        joints[world.scratch.island_joints[island.joint_first]].credit = credit


@njit
def _take_credit(world: Any, island: Any, joints: Any) -> Any:
    """Return the sum of the credits of the island's joints, and set them to 0."""
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    credit = 0.0
    for k in range(len(island_joints)):
        joint = joints[island_joints[k]]
        credit += joint.credit
        joint.credit = 0.0
    return credit


@njit
def _work(world: Any, island: Any) -> Any:
    """Return the work in J of gravity and applied forces over the step."""
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    gravity = world.parameters.world.gravity
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    work = 0.0
    for k in range(len(island_bodies)):
        body = bodies[island_bodies[k]]
        parameters = body_parameters[island_bodies[k]]
        start = substep_bodies[island_bodies[k]].start_position
        for d in range(len(body.position)):
            force = parameters.mass * parameters.gravity_scale * gravity[d] + body.force[d]
            work += force * (body.position[d] - start[d])
    return work


@njit
def _slow_down(world: Any, island: Any, kinetic: Any, gain: Any) -> None:
    """Scale the velocities, those of a free island relative to its centre of mass, to take ``gain`` out of them."""
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    held = is_held(world, island)
    mass = 0.0
    for k in range(len(island_bodies)):
        mass += body_parameters[island_bodies[k]].mass
    for d in range(len(bodies[0].position)):
        mean = _mean_velocity(world, island, d, mass, held)
        kinetic -= 0.5 * mass * mean * mean
    scale = (1.0 - gain / kinetic) ** 0.5 if kinetic > gain else 0.0
    for d in range(len(bodies[0].velocity)):
        mean = _mean_velocity(world, island, d, mass, held or d >= len(bodies[0].position))
        for k in range(len(island_bodies)):
            velocity = bodies[island_bodies[k]].velocity
            velocity[d] = mean + scale * (velocity[d] - mean)


@njit
def _mean_velocity(world: Any, island: Any, d: Any, mass: Any, held: Any) -> Any:
    """Return the velocity of the centre of mass along an axis, or 0 where it is ``held``."""
    if held:
        return 0.0
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    momentum = 0.0
    for k in range(len(island_bodies)):
        momentum += body_parameters[island_bodies[k]].mass * bodies[island_bodies[k]].velocity[d]
    return momentum / mass
