"""Sleeping: an island whose bodies have all been slow for a while stops being simulated."""

from __future__ import annotations

from typing import Any

from ..jit import njit
from .dispatch import by_dimension
from .slices import part

gyration = by_dimension("rotation", "gyration")

CALM = 0.01  # of what gravity adds to a speed in a step: bodies at rest that are slower are calm


@njit
def any_awake(bodies: Any, body_models: Any, body_parameters: Any) -> Any:
    """Whether a body may move in this step: an awake dynamic or a moving kinematic body."""
    for i in range(len(bodies)):
        if body_parameters[i].enabled == 0:
            continue
        if body_models[i].kind == 2:
            if bodies[i].asleep == 0:
                return True
        elif body_models[i].kind == 1:
            for d in range(len(bodies[i].velocity)):
                if bodies[i].velocity[d] != 0.0:
                    return True
    return False


@njit
def _speed(v: Any, radius: Any) -> Any:
    """Return a bound of the speed of a body's fastest point, in m/s.

    ``v`` (3,) or (6,): linear and angular components; ``radius``: m.
    """
    linear = 0.0
    angular = 0.0
    for d in range(len(v)):
        if d < (len(v) + 1) // 2:
            linear += v[d] * v[d]
        else:
            angular += v[d] * v[d]
    return linear**0.5 + angular**0.5 * radius


@njit
def point_speed(velocity: Any, parameters: Any) -> Any:
    """Return a bound of the speed in m/s of a body's fastest point; without shapes, at the radius of gyration."""
    return _speed(velocity, parameters.radius if parameters.radius > 0.0 else gyration(parameters))


@njit
def is_calm(body: Any, parameters: Any, gravity: Any, timestep: Any) -> Any:
    """Whether a body has rested for a step and nothing begins to move it or damps it; gravity in m/s^2."""
    if parameters.linear_damping != 0.0 or parameters.angular_damping != 0.0:
        return False  # substeps are what makes damping accurate
    if body.sleep_time == 0.0 or point_speed(body.velocity, parameters) >= CALM * gravity * timestep:
        return False
    for d in range(len(body.force)):
        if body.force[d] != 0.0:
            return False
    return True


@njit
def all_calm(world: Any, island: Any) -> Any:
    """Whether all bodies of the island are calm."""
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    timestep = world.options.timestep
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        if not is_calm(bodies[i], body_parameters[i], island.gravity_norm, timestep):
            return False
    return True


@njit
def update_sleep(
    island_bodies: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, options: Any, restless: Any
) -> None:
    """Update the time at rest of an awake island's bodies, and put them to sleep once all have rested long enough."""
    least = options.sleep_time
    for k in range(len(island_bodies)):
        body = bodies[island_bodies[k]]
        parameters = body_parameters[island_bodies[k]]
        # the position pass moves bodies at rest as well
        moved = point_speed(substep_bodies[island_bodies[k]].displacement, parameters)
        body.travel += moved
        slow = point_speed(body.velocity, parameters) <= options.sleep_speed  # NaN is not
        slow = slow and moved / options.timestep <= options.sleep_speed
        body.asleep = 0
        if restless or not slow:
            body.sleep_time = 0.0
        else:
            body.sleep_time += options.timestep
        least = min(least, body.sleep_time)
    if least < options.sleep_time or options.sleep == 0 or restless:
        return
    for k in range(len(island_bodies)):
        body = bodies[island_bodies[k]]
        body.asleep = 1
        for d in range(len(body.velocity)):
            body.velocity[d] = 0.0
