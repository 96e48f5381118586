"""gsenv and MuJoCo behind one interface: a machine of an MJCF file that is stepped under controls."""

from __future__ import annotations

import warnings
from typing import Any, Protocol

import mujoco
import numpy as np
from numpy.typing import NDArray

from gsenv.mjcf import build_scene, coordinates, parse_mjcf, set_coordinates
from gsenv.solver import Options, World

Array = NDArray[np.float64]
ROWS, JOINTS = "rows", "joint coordinates"
INTEGRATORS = ("Euler", "implicitfast", "RK4")
ENGINES = (ROWS, JOINTS, *INTEGRATORS)


class Machine(Protocol):
    """One simulated copy of a file."""

    def place(self, qpos: Array, qvel: Array) -> None:
        """Set the state, and forget what the last steps left for the next."""

    def steer(self, control: Array) -> None:
        """Set the controls."""

    def step(self, count: int) -> None:
        """Take steps."""

    def state(self) -> tuple[Array, Array]:
        """Return qpos and qvel."""

    def contacts(self) -> int:
        """Return the number of contacts of the last step."""

    def penetration(self) -> float:
        """Return the deepest overlap in m of the present poses."""


class Ours:
    """The file in gsenv."""

    def __init__(self, source: Any, timestep: float, articulated: bool, **options: Any) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self.model = parse_mjcf(source)
            scene, self.names = build_scene(self.model)
            chosen = {"substeps": 1, "sleep": False, **options}
            self.world = World(scene, options=Options(timestep=timestep, articulated=articulated, **chosen))

    def place(self, qpos: Array, qvel: Array) -> None:
        self.world.reset()
        set_coordinates(self.world, self.model, self.names, qpos, qvel)

    def steer(self, control: Array) -> None:
        self.world.control[0] = control

    def step(self, count: int) -> None:
        self.world.step(count)

    def state(self) -> tuple[Array, Array]:
        qpos, qvel = coordinates(self.world, self.model, self.names)
        return qpos[0], qvel[0]

    def contacts(self) -> int:
        return len(self.world.contacts())

    def penetration(self) -> float:
        return float(self.world.diagnostics().penetration[0])


class Theirs:
    """The file in MuJoCo, with the options of the file but for timestep and integrator."""

    def __init__(self, source: Any, timestep: float, integrator: str) -> None:
        text = str(source)
        load = mujoco.MjModel.from_xml_string if text.lstrip().startswith("<") else mujoco.MjModel.from_xml_path
        self.model = load(text)
        self.model.opt.timestep = timestep
        self.model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
        self.data = mujoco.MjData(self.model)

    def place(self, qpos: Array, qvel: Array) -> None:
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:], self.data.qvel[:] = qpos, qvel

    def steer(self, control: Array) -> None:
        self.data.ctrl[:] = control

    def step(self, count: int) -> None:
        mujoco.mj_step(self.model, self.data, nstep=count)

    def state(self) -> tuple[Array, Array]:
        return self.data.qpos.copy(), self.data.qvel.copy()

    def contacts(self) -> int:
        return int(self.data.ncon)

    def penetration(self) -> float:
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_collision(self.model, self.data)
        return max((-float(d) for d in self.data.contact.dist if d < 0.0), default=0.0)


def machine(engine: str, source: Any, timestep: float, **options: Any) -> Machine:
    """Return the file in an engine of ``ENGINES``; ``options`` are further ones of gsenv."""
    if engine in INTEGRATORS:
        return Theirs(source, timestep, engine)
    return Ours(source, timestep, engine == JOINTS, **options)
