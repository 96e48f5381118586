"""Islands against a search through the graph of bodies in plain Python."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from gsenv.solver.core.activity import AWAKE, DRIVEN, KINEMATIC_CONTACT
from gsenv.solver.core.islands import ASLEEP, build_islands
from gsenv.solver.jit import njit
from gsenv.solver.records.bundle import Bundle
from gsenv.solver.records.model import (
    Array,
    BodyKind,
    body_model_dtype,
    body_parameter_dtype,
    body_state_dtype,
    contact_dtype,
    joint_model_dtype,
    joint_parameter_dtype,
    joint_state_dtype,
    world_state_dtype,
)
from gsenv.solver.records.scratch_dtypes import ISLAND_DTYPE

BODIES = 30
Island = tuple[list[int], list[int], list[int], int]  # bodies, contacts, joints, how awake


@njit
def islands_of(world: Any, found_count: int) -> Any:
    return build_islands(world, found_count, world.state.joints)


@dataclass
class Graph:
    """Bodies of all kinds, some asleep, with random contacts and joints between them."""

    models: Array
    parameters: Array
    states: Array
    contacts: Array
    found: list[int]  # contacts with something awake, as a step finds them
    joint_models: Array
    joint_parameters: Array

    def movable(self, body: int) -> bool:
        return bool(self.parameters["inv_mass"][body] > 0.0)

    def moving(self, body: int) -> bool:
        """A kinematic body on its way."""
        on = self.models["kind"][body] == BodyKind.KINEMATIC and self.parameters["enabled"][body]
        return bool(on and self.states["velocity"][body].any())

    def lively(self, body: int) -> bool:
        return self.moving(body) or (self.movable(body) and not self.states["asleep"][body])


def pairs(rng: np.random.Generator, count: int) -> Array:
    """Two different bodies each, mostly neighbours: several islands, not one."""
    a = rng.integers(0, BODIES - 3, count)
    return np.stack([a, a + rng.integers(1, 4, count)], 1)


def random_graph(rng: np.random.Generator) -> Graph:
    models = np.zeros(BODIES, body_model_dtype())
    models["kind"] = rng.choice([0, 1, 2, 2, 2], BODIES)
    parameters = np.zeros(BODIES, body_parameter_dtype(2))
    parameters["enabled"] = rng.random(BODIES) < 0.9
    parameters["inv_mass"] = (models["kind"] == 2) & (parameters["enabled"] == 1)
    states = np.zeros(BODIES, body_state_dtype(2))
    states["asleep"] = (rng.random(BODIES) < rng.choice([0.0, 0.5, 0.9, 1.0])) & (models["kind"] == 2)
    states["velocity"][:, 1] = (rng.random(BODIES) < 0.3) & (models["kind"] == 1)
    ends = pairs(rng, int(rng.integers(0, 20)))
    contacts = np.zeros(len(ends), contact_dtype(2))
    contacts["body_a"], contacts["body_b"] = ends.T
    contacts["sensor"] = rng.random(len(ends)) < 0.1
    ends = pairs(rng, int(rng.integers(0, 4)))
    joints = np.zeros(len(ends), joint_model_dtype())
    joints["body_a"], joints["body_b"] = ends.T
    joints["driven"] = rng.random(len(ends)) < 0.3
    switches = np.zeros(len(ends), joint_parameter_dtype(2))
    switches["enabled"] = rng.random(len(ends)) < 0.8
    graph = Graph(models, parameters, states, contacts, [], joints, switches)
    graph.found = [k for k, c in enumerate(contacts) if graph.lively(c["body_a"]) or graph.lively(c["body_b"])]
    return graph


def expected(graph: Graph) -> list[Island]:
    """The awake islands, by their lowest body."""
    contacts = [(k, int(c["body_a"]), int(c["body_b"])) for k, c in enumerate(graph.contacts) if not c["sensor"]]
    joints = [
        (j, int(m["body_a"]), int(m["body_b"]))
        for j, m in enumerate(graph.joint_models)
        if graph.joint_parameters["enabled"][j]
    ]
    links = [(a, b) for _, a, b in contacts + joints if graph.movable(a) and graph.movable(b)]
    islands = []
    left = {b for b in range(BODIES) if graph.movable(b)}
    while left:
        bodies = {min(left)}
        while more := {b for link in links for b in link if bodies & set(link)} - bodies:
            bodies |= more
        left -= bodies
        own_contacts = [(k, a, b) for k, a, b in contacts if bodies & {a, b}]
        own_joints = [(j, a, b) for j, a, b in joints if bodies & {a, b}]
        awake = 0
        if any(not graph.states["asleep"][b] for b in bodies):
            awake = AWAKE
        if any(graph.joint_models["driven"][j] for j, _, _ in own_joints):
            awake = DRIVEN
        if any(graph.moving(a) or graph.moving(b) for _, a, b in own_contacts + own_joints):
            awake = KINEMATIC_CONTACT
        if awake:
            islands.append((sorted(bodies), [k for k, _, _ in own_contacts], [j for j, _, _ in own_joints], awake))
    return islands


def built(graph: Graph) -> tuple[list[Island], Array]:
    """The awake islands as the solver lists them, and the labels of all bodies."""
    islands = np.zeros(BODIES, ISLAND_DTYPE)
    island_bodies = np.full(BODIES, -1, np.int32)
    island_contacts = np.full(len(graph.contacts), -1, np.int32)
    island_joints = np.full(len(graph.joint_models), -1, np.int32)
    listed = np.full(len(graph.contacts), -1, np.int32)
    listed[: len(graph.found)] = graph.found
    counters = np.zeros((), world_state_dtype())
    counters["contact_count"] = len(graph.contacts)
    joints = np.zeros(len(graph.joint_models), joint_state_dtype(2))
    world = Bundle(
        "World",
        2,
        model=Bundle("Model", 2, bodies=graph.models, joints=graph.joint_models),
        parameters=Bundle("Parameters", 2, bodies=graph.parameters, joints=graph.joint_parameters),
        state=Bundle("State", 2, world=counters, bodies=graph.states, contacts=graph.contacts, joints=joints),
        scratch=Bundle(
            "Scratch",
            2,
            islands=islands,
            found_places=listed,
            island_bodies=island_bodies,
            island_contacts=island_contacts,
            island_joints=island_joints,
        ),
    ).seal()
    count = islands_of(world, len(graph.found))
    lists = []
    for i in islands[:count]:
        if i["activity"]:
            parts = [
                members[i[f"{name}_first"] : i[f"{name}_first"] + i[f"{name}_count"]].tolist()
                for name, members in (("body", island_bodies), ("contact", island_contacts), ("joint", island_joints))
            ]
            lists.append((*parts, int(i["activity"])))
    return lists, islands["label"]


@pytest.mark.parametrize("seed", range(5))
def test_against_a_search(seed: int) -> None:
    rng = np.random.default_rng(seed)
    states = {0: 0, AWAKE: 0, DRIVEN: 0, KINEMATIC_CONTACT: 0}
    for _ in range(200):
        graph = random_graph(rng)
        islands, labels = built(graph)
        assert islands == expected(graph)
        for *_, awake in islands:
            states[awake] += 1
        states[0] += bool((labels == ASLEEP).any() and islands)
        for bodies, *_ in islands:
            assert len({int(labels[b]) for b in bodies}) == 1
            assert labels[bodies[0]] >= 0
        members = {b for bodies, *_ in islands for b in bodies}
        assert all(labels[b] == ASLEEP or graph.states["asleep"][b] for b in range(BODIES)
                   if graph.movable(b) and b not in members)  # fmt: skip
    assert min(states.values()) > 10, "every kind of island came up, and awake ones beside sleepers left out"
