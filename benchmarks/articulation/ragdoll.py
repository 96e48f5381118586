"""A ragdoll of 13 bodies on 12 ball joints and a chain of 20 links, one substep per step."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmarks.common.progress import track
from benchmarks.common.report import Part
from benchmarks.common.tables import Table
from benchmarks.common.timing import cpu_time, step_time
from gsenv.scenes.spatial import ball_chain
from gsenv.solver import Options, Scene, World
from gsenv.solver.spatial import Ball, Capsule, Plane

TIMESTEP = 0.003  # s
HALF = math.sqrt(0.5)
ALONG_Y = (HALF, HALF, 0.0, 0.0)
UPRIGHT = (1.0, 0.0, 0.0, 0.0)
LIMBS = 2  # collision category: the ragdoll does not collide with itself
FRICTION = 0.8

# name: place (m), half length (m), radius (m), whether it lies along y
Limb = tuple[tuple[float, float, float], float, float, bool]
TRUNK: dict[str, Limb] = {
    "pelvis": ((0.0, 0.0, 0.0), 0.08, 0.10, True),
    "belly": ((0.0, 0.0, 0.2), 0.06, 0.10, True),
    "chest": ((0.0, 0.0, 0.4), 0.08, 0.11, True),
    "neck": ((0.0, 0.0, 0.55), 0.01, 0.05, False),
    "head": ((0.0, 0.0, 0.68), 0.04, 0.09, False),
}
SIDE: dict[str, Limb] = {
    "upper_arm": ((0.0, 0.38, 0.42), 0.12, 0.045, True),
    "forearm": ((0.0, 0.70, 0.42), 0.12, 0.04, True),
    "thigh": ((0.0, 0.10, -0.28), 0.15, 0.06, False),
    "shin": ((0.0, 0.10, -0.70), 0.15, 0.05, False),
}
TRUNK_JOINTS = (
    ("pelvis", "belly", (0.0, 0.0, 0.1)),
    ("belly", "chest", (0.0, 0.0, 0.3)),
    ("chest", "neck", (0.0, 0.0, 0.5)),
    ("neck", "head", (0.0, 0.0, 0.58)),
)
SIDE_JOINTS = (
    ("chest", "upper_arm", (0.0, 0.2, 0.42)),
    ("upper_arm", "forearm", (0.0, 0.54, 0.42)),
    ("pelvis", "thigh", (0.0, 0.1, -0.08)),
    ("thigh", "shin", (0.0, 0.1, -0.49)),
)
PARTS: dict[str, Limb] = {
    **TRUNK,
    **{
        f"{name}_{side}": ((x, sign * y, z), half, radius, lies)
        for name, ((x, y, z), half, radius, lies) in SIDE.items()
        for side, sign in (("l", 1.0), ("r", -1.0))
    },
}


def joints() -> list[tuple[str, str, tuple[float, float, float]]]:
    """(parent, child, place) of the ragdoll's joints."""
    made = list(TRUNK_JOINTS)
    for side, y in (("l", 1.0), ("r", -1.0)):
        for parent, child, (px, py, pz) in SIDE_JOINTS:
            holder = parent if parent in TRUNK else f"{parent}_{side}"
            made.append((holder, f"{child}_{side}", (px, y * py, pz)))
    return made


def ragdoll(height: float) -> Scene:
    """Build a ragdoll of 13 capsules of 1000 kg/m^3 on 12 ball joints, its pelvis ``height`` m above the ground."""
    scene = Scene(dim=3)
    scene.add_body("ground", "static", shapes=[Plane(friction=FRICTION)])
    for name, ((x, y, z), half, radius, lies) in PARTS.items():
        shape = Capsule(half_length=half, radius=radius, density=1000.0, friction=FRICTION, category=LIMBS, mask=~LIMBS)
        scene.add_body(name, shapes=[shape], position=(x, y, z + height), orientation=ALONG_Y if lies else UPRIGHT)
    for parent, child, (x, y, z) in joints():
        scene.add_joint(f"{parent}-{child}", Ball(parent, child, anchor=(x, y, z + height)))
    return scene


def mujoco_ragdoll(height: float) -> Any:
    """Return (module, model, data) of the same ragdoll in MuJoCo, or None where it is not installed."""
    try:
        import mujoco
    except ImportError:
        return None
    spec = mujoco.MjSpec()
    spec.option.timestep = TIMESTEP
    ground = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], friction=[FRICTION, 0, 0])
    ground.conaffinity, ground.contype = 1, 1
    made: dict[str, Any] = {}
    parents = {child: (parent, at) for parent, child, at in joints()}
    for name, (place, half, radius, lies) in PARTS.items():
        parent, at = parents.get(name, (None, None))
        origin = np.array(PARTS[parent][0]) if parent else np.array([0.0, 0.0, -height])
        body = (made[parent] if parent else spec.worldbody).add_body(name=name, pos=np.array(place) - origin)
        if at is None:
            body.add_freejoint()
        else:
            body.add_joint(type=mujoco.mjtJoint.mjJNT_BALL, pos=np.array(at) - place)
        geom = body.add_geom(type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=[radius, half, 0], density=1000.0)
        geom.quat = ALONG_Y if lies else UPRIGHT
        geom.friction, geom.contype, geom.conaffinity = [FRICTION, 0, 0], 2, 1
        made[name] = body
    model = spec.compile()
    return mujoco, model, mujoco.MjData(model)


def options(on: bool, timestep: float = TIMESTEP) -> Options:
    return Options(timestep=timestep, substeps=1, sleep=False, articulated=on)


def time_ragdoll(height: float, on: bool, settle: int, steps: int) -> dict[str, Any]:
    world = World(ragdoll(height), options=options(on))
    world.step(settle)
    seconds = step_time(world, steps)
    diagnostics = world.diagnostics()
    return {
        "us": 1e6 * seconds,
        "contacts": int(diagnostics.contacts[0]),
        "rows": int(diagnostics.rows[0]),
        "sweeps": int(diagnostics.sweeps[0]),
        "penetration": float(diagnostics.penetration[0]),
    }


def time_fall(on: bool, steps: int) -> dict[str, Any]:
    """From a height of 1.2 m until it lies: mean over all steps."""
    world = World(ragdoll(1.2), options=options(on))
    world.step()
    times, deepest, sweeps = [], 0.0, 0
    for _ in range(3):
        world.reset()
        times.append(cpu_time(lambda: world.step(steps)))
    world.reset()
    for _ in range(steps // 10):  # reading would push the step's code out of the processor's caches
        world.step(10)
        diagnostics = world.diagnostics()
        deepest = float(np.maximum(deepest, diagnostics.penetration[0]))  # NaN stays
        sweeps = max(sweeps, int(diagnostics.sweeps[0]))
    return {"us": 1e6 * statistics.median(times) / steps, "penetration": deepest, "sweeps": sweeps}


def time_mujoco(height: float, settle: int, steps: int) -> dict[str, Any] | None:
    made = mujoco_ragdoll(height)
    if made is None:
        return None
    mujoco, model, data = made
    mujoco.mj_step(model, data, nstep=max(settle, 1))
    seconds = statistics.median(cpu_time(lambda: mujoco.mj_step(model, data, nstep=steps)) for _ in range(5))
    return {"us": 1e6 * seconds / steps, "contacts": int(data.ncon)}


def chain(on: bool, timestep: float, seconds: float) -> dict[str, Any]:
    """A chain of 20 equal links let go level: CPU time and energy lost."""
    scene = ball_chain(20, 0.25, 90.0, last_mass=1.0)
    world = World(scene, options=Options(timestep=timestep, sleep=False, articulated=on))
    world.step()
    world.reset()
    start = float(world.diagnostics().energy[0])
    spent = cpu_time(lambda: world.step(round(seconds / timestep)))
    fallen = 20.0 * 9.81 * 2.5  # J, between level and hanging
    diagnostics = world.diagnostics()
    return {
        "us": 1e6 * spent / seconds,
        "lost": (start - float(diagnostics.energy[0])) / fallen,
        "joint_error": float(diagnostics.joint_error[0]),
    }


def measure_ragdolls(quick: bool, seconds: float) -> dict[str, Any]:
    """Return times of the ragdoll in three states, and of the chain."""
    steps = 200 if quick else 1000
    results: dict[str, Any] = {"seconds": seconds, "ragdoll": {}, "chain": {}}
    for on in track((True, False), "ragdoll and chain", 2):
        name = "joint coordinates" if on else "rows"
        results["ragdoll"][name] = {
            "airborne": time_ragdoll(1e5, on, 1, steps),
            "lying": time_ragdoll(1.2, on, 2000, steps),
            "falling": time_fall(on, 1000),
        }
        results["chain"][name] = {str(rate): chain(on, 1.0 / rate, seconds) for rate in (60, 240)}
    theirs = time_mujoco(1e5, 1, steps)
    if theirs is not None:
        results["ragdoll"]["MuJoCo"] = {"airborne": theirs, "lying": time_mujoco(1.2, 2000, steps)}
    return results


def report_ragdolls(results: Mapping[str, Any]) -> list[Part]:
    """Return the tables of ``measure_ragdolls``."""
    lines = []
    for name, states in results["ragdoll"].items():
        for state, entry in states.items():
            given = [str(entry.get(word, "")) for word in ("contacts", "rows", "sweeps")]
            depth = f"{1e3 * entry['penetration']:.2f}" if "penetration" in entry else ""
            lines.append([name, state, f"{entry['us']:.1f}", *given, depth])
    chains = [
        [name, rate, f"{entry['us']:.0f}", f"{100 * entry['lost']:.2f}", f"{entry['joint_error']:.1e}"]
        for name, rates in results["chain"].items()
        for rate, entry in rates.items()
    ]
    return [
        "## A ragdoll on ball joints, and a free chain",
        "13 capsules on 12 ball joints, steps of 3 ms, one substep.",
        Table(["", "state", "us a step", "contacts", "rows", "sweeps", "deepest, mm"], lines, words=2),
        f"A chain of 20 equal links let go level, {results['seconds']:g} s, default options.",
        Table(["", "steps per s", "us per simulated s", "energy lost, %", "joint error, m"], chains),
    ]
