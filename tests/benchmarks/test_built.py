"""Engines that the benchmarks build from sources. Tests of the engines themselves need BOX2D_SOURCE or BOX3D_SOURCE."""

from __future__ import annotations

import math
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks import command, heaps
from benchmarks.accuracy import cases, cases3d
from benchmarks.accuracy.built import BUILT
from benchmarks.accuracy.engines import Setting, Simulation, box2d_v3, box3d
from benchmarks.accuracy.engines.peers import STAGES, WHOLE
from benchmarks.accuracy.fronts import ENGINES, Points
from benchmarks.accuracy.method import method
from benchmarks.accuracy.page import limit_table
from benchmarks.accuracy.plot import COLORS
from benchmarks.accuracy.points import Point, finite_error, record
from benchmarks.accuracy.suites import suite_of
from benchmarks.common.run import Unable
from benchmarks.stages.peers import Profiled
from gsenv.scenes import bouncing_balls, box_on_incline, pendulum, spring_mass, stack
from gsenv.scenes.spatial import cart, cube_stack, roller_on_incline, spinning_box
from gsenv.solver import Model, Scene
from gsenv.solver import planar as flat
from gsenv.solver.spatial import Box, Plane, Sphere

Array = NDArray[np.float64]
MODULES = {"Box2D v3": box2d_v3, "Box3D": box3d}
TOOLS = all(shutil.which(tool) for tool in ("cmake", "cc", "c++"))
needs_tools = pytest.mark.skipif(not TOOLS, reason="no cmake or compiler")


def source_of(name: str) -> Path:
    """The folder of an engine's sources; skips where it is not given."""
    variable = {"Box2D v3": "BOX2D_SOURCE", "Box3D": "BOX3D_SOURCE"}[name]
    if variable not in os.environ or not TOOLS:
        pytest.skip(f"{variable} names no folder, or there is no compiler")
    return Path(os.environ[variable])


def fake(folder: Path, lists: str) -> Path:
    """Return a folder that looks like Box2D's."""
    header = folder / "include" / "box2d" / "box2d.h"
    header.parent.mkdir(parents=True)
    header.write_text("")
    (folder / "src").mkdir()
    (folder / "CMakeLists.txt").write_text(lists)
    return folder


# ---------------------------------------------------------------- refusals


@pytest.mark.parametrize("name", ["accuracy", "heaps", "stages"])
def test_folder_of_the_other_dimension(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main([name, "--quick", "--dim", "3", "--box2d-source", "."]) == 2
    assert capsys.readouterr().err == "benchmarks: --box2d-source: Box2D v3 is measured with --dim 2.\n"


def test_engine_without_its_folder(capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["accuracy", "--quick", "--dim", "3", "--engine", "Box3D"]) == 2
    assert "it is built from its sources; give --box3d-source FOLDER." in capsys.readouterr().err


@pytest.mark.parametrize("name", ["accuracy", "heaps", "stages"])
def test_folder_without_sources(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main([name, "--quick", "--box2d-source", str(tmp_path)]) == 1
    said = capsys.readouterr().err
    assert "this is no source folder of Box2D v3, it has no include/box2d/box2d.h." in said.replace("\\", "/")


def test_no_compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr("shutil.which", lambda tool: None)
    with pytest.raises(Unable, match=r"^--box2d-source: building Box2D v3 needs the program cmake, which is not inst"):
        box2d_v3.version(fake(tmp_path / "box2d", ""))


@needs_tools
def test_failed_build_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    empty = fake(
        tmp_path / "box2d", "add_library(box2d INTERFACE)\ntarget_include_directories(box2d INTERFACE include)"
    )
    with pytest.raises(Unable, match=r"^--box2d-source: building Box2D v3 failed: .*error") as caught:
        box2d_v3.version(empty)
    assert "\n" not in str(caught.value)
    assert not list((tmp_path / "cache").rglob("*.so"))


# ---------------------------------------------------------------- what goes in


def test_rows_of_bodies_and_shapes() -> None:
    model = box_on_incline(20.0).compile()
    rows = box2d_v3.body_rows(model)
    assert rows[:, 0].tolist() == [0.0, 1.0]
    assert rows[1, 1:3] == pytest.approx(model.start_bodies["position"][1])
    assert rows[1, 7:] == pytest.approx([model.nominal_bodies["mass"][1], model.nominal_bodies["inertia"][1]])
    ground = np.array(box2d_v3.shape_row(model, 0))
    up = np.array([-math.sin(ground[4]), math.cos(ground[4])])
    assert ground[2:4] + box2d_v3.GROUND_HALF[1] * up == pytest.approx(model.nominal_shapes["local_position"][0])


def test_rows_of_hinges_and_springs() -> None:
    model = pendulum(90.0).compile()
    nominal = model.nominal_joints[0]
    expected = [0.0, 0.0, 1.0, *nominal["anchor_a"], *nominal["anchor_b"]]
    assert box2d_v3.joint_row(model, 0)[:7] == pytest.approx(expected)
    assert box2d_v3.joint_row(spring_mass(2.0, 0.2).compile(), 0)[8:] == pytest.approx((2.0, 0.2))


def test_shapes_and_joints_that_are_not_there() -> None:
    scene = Scene()
    scene.add_body("capsule", shapes=[flat.Capsule(half_length=0.5, radius=0.1)])
    with pytest.raises(ValueError, match="boxes, circles and half-planes"):
        box2d_v3.shape_row(scene.compile(), 0)
    with pytest.raises(ValueError, match="ball joints"):
        box3d.joint_row(cart().compile(), 0)


def test_settings_have_different_labels() -> None:
    for dim, all_cases, name in ((2, cases.all_cases(), "Box2D v3"), (3, cases3d.all_cases(), "Box3D")):
        for case in all_cases:
            for quick in (False, True):
                labels = [setting.label for setting in suite_of(dim).settings[name](case, quick)]
                assert len(set(labels)) == len(labels) > 0


# ---------------------------------------------------------------- what is shown


def test_suites_know_the_engines_that_are_built() -> None:
    for engine in BUILT.values():
        suite = suite_of(engine.dim)
        assert engine.name not in suite.installed
        assert engine.name in suite_of(engine.dim, {engine.name: Path()}).installed
        assert suite.engines[engine.name] == ""
        assert suite.module(engine.name).PEER.name == engine.name
        assert suite.module(engine.name).PEER.option == engine.flag
        assert all(path.is_file() for path in suite.files(engine.name))


def test_pages_with_and_without_them() -> None:
    assert set(ENGINES) == set(COLORS) == set(suite_of(2).engines) | set(suite_of(3).engines)
    assert "is built from its sources" not in method(2, ["gsenv", "Box2D"])
    assert method(2, ["gsenv", "Box2D v3"]).count("Box2D v3 is built from its sources") == 1
    assert method(3, ["gsenv", "Box3D"]).count("Box3D is built from its sources") == 1
    point = Point("tower:10", "gsenv", "one", 1.0 / 60.0, "", 1e-4, 1e-4, 10.0, 10.0, 3, "a")
    newer = Point("tower:10", "Box2D v3", "60 Hz x 4", 1.0 / 60.0, "", 1e-3, 1e-3, 5.0, 5.0, 3, "a")
    tower = [case for case in cases.all_cases() if case.key == "tower:10"]
    alone, beside = limit_table(tower, Points([point]), 1e-2), limit_table(tower, Points([point, newer]), 1e-2)
    assert list(alone.header[2:4]) == ["gsenv", "gsenv / best peer"]
    assert list(beside.header[2:5]) == ["gsenv", "Box2D v3", "gsenv / best peer"]
    assert beside.rows[0][4:7] == ["2.00", "one", "60 Hz x 4"]


# ---------------------------------------------------------------- heaps


def test_heaps_start_touching_and_a_sunk_box_is_seen() -> None:
    for dim, model in ((2, stack(3).compile()), (3, cube_stack(3).compile())):
        states = np.concatenate([model.start_bodies["position"], angles(model), model.start_bodies["velocity"]], 1)
        assert heaps.overlap_of(model, states) == pytest.approx(0.0, abs=1e-12)
        states[2, dim - 1] -= 0.004
        assert heaps.overlap_of(model, states) == pytest.approx(0.004)


def angles(model: Model) -> Array:
    return model.start_bodies["angle"][:, None] if model.dim == 2 else model.start_bodies["rotation"]


def test_heaps_settings() -> None:
    ours = ["balanced", "fast", "fast, undivided", "soft, 4 substeps"]
    assert [setting.label for setting in heaps.settings_of(suite_of(2))] == ours
    labels = [setting.label for setting in heaps.settings_of(suite_of(2, {"Box2D v3": Path()}))]
    assert "4 substeps, scalar" in labels
    assert len(set(labels)) == len(labels)
    (soft,) = (setting for setting in heaps.settings_of(suite_of(3)) if setting.label == "soft, 4 substeps")
    assert soft.values["solver"] == "soft"
    assert not soft.values["sleep"]


def test_heaps_report() -> None:
    timing = heaps.Timing("stack of 50", "gsenv", "balanced", 1.5, 1.25, 1.0, 1.0, 1e-6, 2e-6, 3e-5, 4e-5)
    shown = heaps.table([timing], "stack of 50")
    assert shown.rows == [["gsenv, balanced", "1.500", "1.250", "1.00", "1.00", "0.001", "0.002", "0.03", "0.04"]]
    assert heaps.table([timing], "pyramid, base 20").rows == []


# ---------------------------------------------------------------- the engines


def built(name: str, scene: Scene, rate: float = 240.0, substeps: int = 4, **values: Any) -> Simulation:
    setting = Setting(name, "", 1.0 / rate, {"substeps": substeps, **values})
    simulation: Simulation = MODULES[name].Simulation(scene.compile(), setting, source_of(name))
    return simulation


def start_of(scene: Scene) -> Array:
    model = scene.compile()
    return np.concatenate([model.start_bodies["position"], angles(model), model.start_bodies["velocity"]], 1)


@pytest.mark.parametrize(
    ("name", "scene"),
    [("Box2D v3", pendulum(150.0)), ("Box2D v3", bouncing_balls([0.8])),
     ("Box3D", roller_on_incline("cylinder", 20.0)), ("Box3D", spinning_box((1.0, 2.0, 3.0), (0.1, 1.0, 0.2)))],
)  # fmt: skip
def test_reads_what_was_given(name: str, scene: Scene) -> None:
    assert built(name, scene).read() == pytest.approx(start_of(scene), abs=1e-6)


def test_versions_name_the_library() -> None:
    for name, module in MODULES.items():
        assert len(module.version(source_of(name)).split()) >= 2


@pytest.mark.parametrize(("name", "dim"), [("Box2D v3", 2), ("Box3D", 3)])
def test_profiled_steps_are_the_same_steps(name: str, dim: int) -> None:
    scene = stack(5) if dim == 2 else cube_stack(5)
    plain, profiled = built(name, scene), cast(Profiled, built(name, scene))
    plain.step(50)
    times = profiled.profile(50)
    assert times.shape == (50, len(STAGES))
    assert np.array_equal(plain.read(), profiled.read())
    parts = [k for k, stage in enumerate(STAGES) if stage != WHOLE]
    whole = times[:, STAGES.index(WHOLE)]
    assert (times >= 0.0).all()
    assert (whole > 0.0).all()
    assert (times[:, parts].sum(axis=1) <= whole * 1.001).all()
    for stage in ("pairs", "collide", "warmStart", "solveImpulses", "relaxImpulses", "transforms"):
        assert times[:, STAGES.index(stage)].sum() > 0.0, stage
    assert times[:, STAGES.index("sleepIslands")].sum() == 0.0


def scene_of(dim: int, ground: Mapping[str, Any], body: Mapping[str, Any], height: float, speed: float) -> Scene:
    """A box of 1 m if it has a speed (m/s), else a ball of 0.5 m, whose centre is ``height`` m above the ground."""
    scene = Scene(dim=dim)
    plane: Any = flat.HalfPlane(**ground) if dim == 2 else Plane(**ground)
    shape: Any
    if speed:
        shape = flat.Box(half_extents=(0.5, 0.5), **body) if dim == 2 else Box(half_extents=(0.5, 0.5, 0.5), **body)
    else:
        shape = flat.Circle(radius=0.5, **body) if dim == 2 else Sphere(radius=0.5, **body)
    between = (0.0,) * (dim - 2)
    scene.add_body("ground", "static", shapes=[plane])
    scene.add_body(
        "body", shapes=[shape], position=(0.0, *between, height), linear_velocity=(speed, *between, 0.0)
    )  # fmt: skip
    return scene


@pytest.mark.parametrize(("name", "dim"), [("Box2D v3", 2), ("Box3D", 3)])
def test_friction_combines_as_in_gsenv(name: str, dim: int) -> None:
    simulation = built(name, scene_of(dim, {"friction": 0.2}, {"friction": 0.45}, 0.5, 3.0))
    simulation.step(120)
    speed = 3.0 - math.sqrt(0.2 * 0.45) * 9.81 * 0.5
    assert simulation.read()[1, 3 if dim == 2 else 7] == pytest.approx(speed, rel=5e-3)


@pytest.mark.parametrize(("name", "dim"), [("Box2D v3", 2), ("Box3D", 3)])
def test_restitution_combines_as_in_gsenv(name: str, dim: int) -> None:
    simulation = built(name, scene_of(dim, {"restitution": 0.3}, {"restitution": 0.6}, 0.7, 0.0), 960.0)
    speeds = []
    for _ in range(400):
        simulation.step(1)
        speeds.append(simulation.read()[1, 4 if dim == 2 else 9])
    assert max(speeds) / -min(speeds) == pytest.approx(0.6, rel=0.02)


def test_angles_are_not_wrapped() -> None:
    case = next(case for case in cases.all_cases() if case.key == "rolling")
    setting = Setting("Box2D v3", "", 1.0 / 60.0, {"substeps": 4})
    model = case.scene().compile()
    trajectory = record(box2d_v3.Simulation(model, setting, source_of("Box2D v3")), case, model, setting.timestep)
    assert np.abs(np.diff(trajectory.angle[:, 1])).max() < 1.0
    assert abs(trajectory.angle[-1, 1]) > 2.0 * math.pi


@pytest.mark.parametrize(("name", "all_cases"), [("Box2D v3", cases.all_cases()), ("Box3D", cases3d.all_cases())])
def test_stiff_towers_stand(name: str, all_cases: list[cases.Case]) -> None:
    case = next(case for case in all_cases if case.key == "tower:10")
    setting = Setting(name, "", 1.0 / 60.0, {"substeps": 16, "contact": (1e6, 10.0, 3.0)})
    model = case.scene().compile()
    trajectory = record(MODULES[name].Simulation(model, setting, source_of(name)), case, model, setting.timestep)
    error = finite_error(case.error, trajectory)
    assert error is not None
    assert error < 1e-3


def test_builds_give_the_same_motion() -> None:
    wide, scalar = built("Box2D v3", stack(5)), built("Box2D v3", stack(5), build="scalar")
    for simulation in (wide, scalar):
        simulation.step(100)
    assert wide.read() == pytest.approx(scalar.read(), abs=1e-5)
