"""Sessions for the tests, without windows."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.core.interactive import TaskSimulation, make_steering
from gsenv.envs.core.policies import make_batch
from gsenv.scenes import SCENES, make_world
from gsenv.train.evaluate import make_actor
from gsenv.view.events import Event
from gsenv.view.session import Session
from gsenv.view.simulation import SceneSimulation

SIZE = (320, 240)
FRAME = 1.0 / 60.0  # s


def scene_session(name: str, worlds: int = 1) -> Session:
    spec = SCENES[name]
    world = make_world(name, worlds)
    simulation = SceneSimulation(world, name, view=spec.view, follow=spec.follow, camera=spec.camera)
    return Session(simulation, SIZE)


def view_session(name: str, worlds: int = 1, policy: str | None = None, **settings: Any) -> Session:
    actor = None if policy is None else make_actor(policy, name)
    return Session(TaskSimulation(make_batch(name, worlds, **settings), name, 0, actor), SIZE)


def play_session(name: str, policy: str | None = None, **settings: Any) -> Session:
    env = make_batch(name, 1, **settings)
    actor = None if policy is None else make_actor(policy, name)
    steering = make_steering(env.task, len(env.task.agents) if policy is None else 1)
    return Session(TaskSimulation(env, name, 0, actor, steering), SIZE)


def send(session: Session, *events: Event) -> None:
    for event in events:
        session.handle(event)


def pass_time(session: Session, seconds: float) -> None:
    """Let real time pass, a frame at a time."""
    for _ in range(round(seconds / FRAME)):
        session.tick(FRAME)


def time_of(session: Session, world: int = 0) -> float:
    return float(session.simulation.world.time[world])


def pixel_of(session: Session, body: str) -> NDArray[np.float64]:
    """Where the picture shows the centre of mass of a body."""
    session.picture()
    world = session.simulation.world
    place = world.state.bodies["position"][session.shown.world, world.model.body_names.index(body)]
    return session.screen.control.project(place)
