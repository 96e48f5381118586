"""Sensors of accelerations and contact forces in both dimensions, against closed forms."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World, planar, spatial
from gsenv.solver.records.model import Array

G = 9.81
BOTH = pytest.mark.parametrize("dim", [2, 3], ids=["2D", "3D"])
MODULES: dict[int, Any] = {2: planar, 3: spatial}


def at(dim: int, x: float = 0.0, up: float = 0.0) -> tuple[float, ...]:
    """A point or vector: along x, and upward."""
    return (x, up) if dim == 2 else (x, 0.0, up)


def up_of(dim: int, value: float) -> Array:
    return np.array(at(dim, 0.0, value))


def spin_of(dim: int, value: float) -> Any:
    """A rotation that turns x to up in 2D, and x to y in 3D, about z."""
    return value if dim == 2 else (0.0, 0.0, value)


def box_of(dim: int, half: float = 0.5, **given: Any) -> Any:
    return MODULES[dim].Box(half_extents=(half,) * dim, **given)


def ground_of(dim: int, **given: Any) -> Any:
    return planar.HalfPlane(**given) if dim == 2 else spatial.Plane(**given)


def turned(dim: int, angle: float) -> dict[str, Any]:
    """Arguments of a body rotated about z."""
    return {"angle": angle} if dim == 2 else {"orientation": (np.cos(angle / 2), 0, 0, np.sin(angle / 2))}


def sensed(dim: int, body: str, scene: Scene, **site: Any) -> None:
    """Add all sensors of this file to a body."""
    made = MODULES[dim]
    scene.add_sensor("a", made.AccelerationSensor(body, **site))
    scene.add_sensor("imu", made.AccelerationSensor(body, subtract_gravity=True, **site))
    scene.add_sensor("load", made.ContactForceSensor(body))


# ---------------------------------------------------------------- accelerations


@BOTH
def test_free_fall(dim: int) -> None:
    """g along the body's own axes, half-way turned; an accelerometer reads 0, also with another gravity_scale."""
    scene = Scene(dim=dim)
    scene.add_body("box", shapes=[box_of(dim)], angular_velocity=spin_of(dim, 3.0), **turned(dim, 0.4))
    scene.add_body("balloon", shapes=[box_of(dim)], position=at(dim, 9.0), gravity_scale=-0.5)
    sensed(dim, "box", scene)
    scene.add_sensor("drift", MODULES[dim].AccelerationSensor("balloon"))
    scene.add_sensor("drift imu", MODULES[dim].AccelerationSensor("balloon", subtract_gravity=True))
    world = World(scene, 2)
    world.parameters.set(gravity=up_of(dim, -2.0), worlds=1)
    world.step(5)
    angle = 0.4 + 4.5 * 3.0 * world.timestep
    for w, g in enumerate((G, 2.0)):
        # in 3D the rotation is about the vertical, in 2D it turns gravity in the body's frame
        expected = [-g * np.sin(angle), -g * np.cos(angle)] if dim == 2 else [0.0, 0.0, -g]
        np.testing.assert_allclose(world.sensor("a")[w, :dim], expected, atol=1e-11)
        np.testing.assert_allclose(world.sensor("drift")[w, :dim], up_of(dim, 0.5 * g), atol=1e-11)
    np.testing.assert_allclose(world.sensor("imu"), 0.0, atol=1e-11)
    np.testing.assert_allclose(world.sensor("drift imu"), 0.0, atol=1e-11)
    assert not world.sensor("load").any()


@BOTH
def test_an_accelerometer_at_rest_reads_gravity_upward(dim: int) -> None:
    """On a body that rests, sleeps, or is static; and before the first step."""
    scene = Scene(dim=dim)
    scene.add_body("ground", "static", [ground_of(dim, friction=0.5)])
    scene.add_body("box", shapes=[box_of(dim)], position=at(dim, 0.0, 0.5))
    sensed(dim, "box", scene, position=at(dim, 0.3, 0.2))
    scene.add_sensor("floor", MODULES[dim].AccelerationSensor("ground", subtract_gravity=True))
    world = World(scene)
    expected = np.concatenate([up_of(dim, G), np.zeros(1 if dim == 2 else 3)])
    for steps in (0, 60, 200):
        world.step(steps)
        np.testing.assert_allclose(world.sensor("imu")[0], expected, atol=2e-3)
        np.testing.assert_allclose(world.sensor("floor")[0], expected, atol=1e-12)
    assert world.asleep[0, 1]
    assert not world.sensor("a").any()


@BOTH
@pytest.mark.parametrize("rate", [15, 60, 240])
def test_centripetal_acceleration_about_a_pivot(dim: int, rate: int) -> None:
    """w^2 r towards the pivot; the mean over a step of h is shorter by the chord, sin(w h / 2) / (w h / 2)."""
    w, made = 3.0, MODULES[dim]
    scene = Scene(dim=dim, gravity=at(dim))
    scene.add_body("base", "static")
    scene.add_body("arm", shapes=[box_of(dim, 0.2)], position=at(dim, 1.0), angular_velocity=spin_of(dim, w),
                   linear_velocity=(0, w) if dim == 2 else (0, w, 0))  # fmt: skip
    scene.add_joint("pin", planar.Revolute("base", "arm", anchor=at(dim)) if dim == 2 else
                    spatial.Ball("base", "arm", anchor=at(dim)))  # fmt: skip
    for name, x in (("tip", 1.5), ("middle", 0.0), ("pivot", -1.0)):
        scene.add_sensor(name, made.AccelerationSensor("arm", position=at(dim, x)))
    world = World(scene, options=Options(timestep=1 / rate))
    world.step(5)
    half = 0.5 * w / rate
    chord = np.sin(half) / half
    # in 3D a pendulum is integrated exactly, in 2D at second order
    atol = 0.1 * (w / rate) ** 2 * w * w * 2.5 if dim == 2 else 1e-6
    for name, r in (("tip", 2.5), ("middle", 1.0), ("pivot", 0.0)):
        expected = np.zeros(3 if dim == 2 else 6)
        expected[0] = -w * w * r * chord
        np.testing.assert_allclose(world.sensor(name)[0], expected, atol=atol, err_msg=name)


@BOTH
def test_centripetal_acceleration_of_a_kinematic_body_tends_to_the_closed_form(dim: int) -> None:
    """At second order in the timestep."""
    errors = []
    for rate in (30, 60, 120):
        scene = Scene(dim=dim)
        scene.add_body(
            "wheel", "kinematic", [box_of(dim)], position=at(dim, 4.0, 2.0), angular_velocity=spin_of(dim, 5.0)
        )
        scene.add_sensor("rim", MODULES[dim].AccelerationSensor("wheel", position=at(dim, 0.7)))
        world = World(scene, options=Options(timestep=1 / rate))
        world.step(7)
        errors.append(abs(world.sensor("rim")[0, 0] + 25.0 * 0.7))
    assert errors[0] < 0.03 * 25.0 * 0.7
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 4.0, rtol=0.02)


@BOTH
def test_angular_acceleration_and_alpha_cross_r(dim: int) -> None:
    """A torque from rest: alpha = torque / I, alpha x r at the site, and nothing at the centre of mass."""
    torque, inertia = 0.6, 0.3
    scene = Scene(dim=dim, gravity=at(dim))
    moments = inertia if dim == 2 else (0.4, 0.5, inertia)
    scene.add_body("box", shapes=[box_of(dim)], mass=2.0, inertia=moments, **turned(dim, 0.8))
    site = (0.5, -0.2) if dim == 2 else (0.5, -0.2, 0.9)
    sensed(dim, "box", scene, position=site)
    scene.add_sensor("middle", MODULES[dim].AccelerationSensor("box"))
    world = World(scene, options=Options(timestep=1e-3))
    force = (4.0, 0.0) if dim == 2 else (4.0, 0.0, 0.0)
    world.apply_force("box", force=force, torque=spin_of(dim, torque))
    world.step()
    alpha, c, s = torque / inertia, np.cos(0.8), np.sin(0.8)
    own = np.array((2.0 * c, -2.0 * s))  # force / mass along the body's axes
    reading, middle = world.sensor("a")[0], world.sensor("middle")[0]
    turn = slice(dim, None)
    np.testing.assert_allclose(reading[turn], np.append(np.zeros(dim - 2 + (dim == 3)), alpha)[-len(reading[turn]) :],
                               atol=1e-9)  # fmt: skip
    np.testing.assert_allclose(middle[:2], own, atol=1e-5)
    np.testing.assert_allclose(reading[:2], own + alpha * np.array((0.2, 0.5)), atol=1e-5)
    np.testing.assert_array_equal(world.sensor("imu"), world.sensor("a"))


def test_a_free_top_turns_by_eulers_equations() -> None:
    """I dw/dt = -w x I w along the body's axes, and the centripetal acceleration of a site off all axes."""
    moments, spin, site = np.array((0.3, 0.5, 0.7)), np.array((2.0, 1.0, -3.0)), np.array((0.3, -0.4, 0.2))
    scene = Scene(dim=3, gravity=(0, 0, 0))
    scene.add_body("top", shapes=[spatial.Sphere(radius=0.1)], mass=1.0, inertia=moments, angular_velocity=spin)
    sensed(3, "top", scene, position=site)
    scene.add_sensor("frame", spatial.FrameSensor("top", position=site))
    errors = []
    for rate in (200, 400):
        world = World(scene, options=Options(timestep=1 / rate))
        before = world.sensor("frame")[0, 10:]
        world.step()
        w = 0.5 * (before + world.sensor("frame")[0, 10:])
        alpha = np.cross(moments * w, w) / moments
        expected = np.concatenate([np.cross(alpha, site) + np.cross(w, np.cross(w, site)), alpha])
        errors.append(abs(world.sensor("a")[0] - expected).max())
    assert errors[0] < 2e-3
    assert errors[1] < 0.3 * errors[0]


@BOTH
def test_the_mean_over_an_impact(dim: int) -> None:
    """A ball that bounces within the step: the change of its velocity divided by the timestep."""
    scene = Scene(dim=dim)
    scene.add_body("ground", "static", [ground_of(dim)])
    ball = planar.Circle(radius=0.5, restitution=0.8) if dim == 2 else spatial.Sphere(radius=0.5, restitution=0.8)
    scene.add_body("ball", shapes=[ball], position=at(dim, 0, 0.55), linear_velocity=at(dim, 0, -6.0), mass=2.0)
    sensed(dim, "ball", scene)
    world = World(scene)
    world.step()
    speed = world.linear_velocity[0, 1, -1]
    assert speed > 4.0
    np.testing.assert_allclose(world.sensor("a")[0, dim - 1], (speed + 6.0) / world.timestep, rtol=1e-12)
    np.testing.assert_allclose(world.sensor("load")[0, -1], 2.0 * ((speed + 6.0) / world.timestep + G), rtol=1e-9)


# ---------------------------------------------------------------- contact forces


@BOTH
def test_load_of_a_body_at_rest(dim: int) -> None:
    scene = Scene(dim=dim)
    scene.add_body("ground", "static", [ground_of(dim, friction=0.5)])
    scene.add_body("box", shapes=[box_of(dim)], position=at(dim, 0.0, 0.5), mass=3.0)
    scene.add_body("lid", shapes=[box_of(dim, 0.25)], position=at(dim, 0.1, 1.25), mass=2.0)
    for name in ("ground", "box", "lid"):
        scene.add_sensor(name, MODULES[dim].ContactForceSensor(name))
    world = World(scene, 2)
    world.parameters.set("lid", mass=4.0, worlds=1)
    for steps in (60, 200):  # awake, asleep
        world.step(steps)
        for w, lid in enumerate((2.0, 4.0)):
            box = world.sensor("box")[w]
            np.testing.assert_allclose(box[:dim], up_of(dim, 3 * G), atol=1e-2)
            np.testing.assert_allclose(box[dim:-1], 0.0, atol=1e-2)  # in balance
            np.testing.assert_allclose(box[-1], (3 + 2 * lid) * G, rtol=1e-3)  # below and above it
            np.testing.assert_allclose(world.sensor("lid")[w, :dim], up_of(dim, lid * G), atol=1e-2)
            np.testing.assert_allclose(world.sensor("ground")[w, -1], (3 + lid) * G, rtol=1e-3)
    assert world.asleep[:, 1:].all()


@BOTH
@pytest.mark.parametrize("friction", [0.2, 0.9])
def test_components_on_an_incline(dim: int, friction: float) -> None:
    """Sliding: m g cos and mu m g cos; at rest: m g cos and m g sin."""
    slope, mass = 0.5, 2.0
    c, s = np.cos(slope), np.sin(slope)
    normal, along = np.array(at(dim, -s, c)), np.array(at(dim, c, s))
    scene = Scene(dim=dim)
    scene.add_body("ramp", "static", [ground_of(dim, normal=normal, friction=friction)])
    turn = {"angle": slope} if dim == 2 else {"orientation": (np.cos(slope / 2), 0, -np.sin(slope / 2), 0)}
    half = (0.5, 0.2) if dim == 2 else (0.5, 0.5, 0.2)
    box = MODULES[dim].Box(half_extents=half, friction=friction)
    scene.add_body("box", shapes=[box], position=0.2 * normal, mass=mass, **turn)
    sensed(dim, "box", scene)
    world = World(scene)
    world.step(30)
    load = world.sensor("load")[0]
    drag = min(friction * c, s) * mass * G
    np.testing.assert_allclose(load[:dim], mass * G * c * normal + drag * along, rtol=2e-3, atol=2e-2)
    np.testing.assert_allclose(load[-1], mass * G * c, rtol=2e-3)
    np.testing.assert_allclose(load[dim:-1], 0.0, atol=3e-2)  # it does not tip
    # what is not carried accelerates it, along its own axes
    np.testing.assert_allclose(world.sensor("a")[0, :dim], at(dim, min(friction * c - s, 0.0) * G), atol=2e-2)
    accelerometer = at(dim, drag / mass, c * G)
    np.testing.assert_allclose(world.sensor("imu")[0, :dim], accelerometer, atol=2e-2)


@BOTH
def test_the_load_explains_the_motion(dim: int) -> None:
    """m dv = (force + m g) dt and I dw = torque dt in every step, for a ball thrown with a spin onto the ground."""
    mass, radius = 2.0, 0.4
    ball: Any = planar.Circle(radius=radius, friction=0.3) if dim == 2 else spatial.Sphere(
        radius=radius, friction=0.3, rolling_friction=0.01, torsional_friction=0.02)  # fmt: skip
    inertia = (0.5 if dim == 2 else 0.4) * mass * radius**2
    scene = Scene(dim=dim)
    scene.add_body("ground", "static", [ground_of(dim, friction=0.3)])
    spin = 9.0 if dim == 2 else (3.0, 9.0, -4.0)
    velocity = (5.0, -1.0) if dim == 2 else (5.0, 2.0, -1.0)
    scene.add_body("ball", shapes=[ball], position=at(dim, 0, 0.45), mass=mass, linear_velocity=velocity,
                   angular_velocity=spin)  # fmt: skip
    sensed(dim, "ball", scene)
    world = World(scene)
    turned_by = 0.0
    for _ in range(40):
        v, w = world.linear_velocity[0, 1], np.atleast_1d(world.angular_velocity[0, 1])
        world.step()
        load, h = world.sensor("load")[0], world.timestep
        dv, dw = world.linear_velocity[0, 1] - v, np.atleast_1d(world.angular_velocity[0, 1]) - w
        np.testing.assert_allclose(load[:dim] + up_of(dim, -mass * G), mass * dv / h, atol=1e-9)
        np.testing.assert_allclose(load[dim:-1], inertia * dw / h, atol=1e-9)
        turned_by += abs(load[dim:-1]).max()
    assert turned_by > 1.0


@pytest.mark.parametrize("restitution", [0.0, 0.6])
def test_the_load_explains_how_a_box_tumbles(restitution: float) -> None:
    """The angular momentum about the centre of mass changes by torque times timestep, for unequal moments too.

    Within 3 % in steps where a corner hits: to keep the energy, the solver turns the angular velocity of a body with
    its correction of the rotation. Exactly in all others. Sleep is off: it stops a body without an impulse.
    """
    box = spatial.Box(half_extents=(0.5, 0.3, 0.1), friction=0.6, restitution=restitution)
    scene = Scene(dim=3)
    scene.add_body("ground", "static", [ground_of(3, friction=0.6)])
    scene.add_body("box", shapes=[box], position=(0, 0, 0.7), orientation=(0.9, 0.2, 0.3, 0.1), mass=2.0,
                   linear_velocity=(2, 1, -1), angular_velocity=(2.0, -3.0, 4.0))  # fmt: skip
    sensed(3, "box", scene)
    world = World(scene, options=Options(sleep=False))
    largest, exact = 0.0, 0

    def momentum() -> Array:
        """About the centre of mass: that about the origin minus r x p."""
        d = world.diagnostics()
        return np.asarray(d.angular_momentum[0] - np.cross(world.center_of_mass[0, 1], d.momentum[0]))

    for _ in range(60):
        before = momentum()
        world.step()
        torque = world.sensor("load")[0, 3:6]
        error = abs(torque - (momentum() - before) / world.timestep).max()
        assert error < 1e-9 + 0.03 * abs(torque).max()
        exact += int(error < 1e-9 and torque.any())
        largest = max(largest, abs(torque).max())
    assert largest > 10.0
    assert exact > 0 or restitution > 0.0


# ---------------------------------------------------------------- state


def rolling(dim: int) -> Scene:
    scene = Scene(dim=dim)
    scene.add_body("ground", "static", [ground_of(dim, friction=0.5)])
    for k in range(3):
        scene.add_body(f"b{k}", shapes=[box_of(dim, 0.3)], position=at(dim, 0.4 * k, 0.5 + 0.7 * k),
                       angular_velocity=spin_of(dim, 1.0 + k))  # fmt: skip
    sensed(dim, "b1", scene, position=at(dim, 0.2))
    return scene


@BOTH
def test_readings_are_of_the_last_step_and_survive_edits_and_snapshots(dim: int) -> None:
    """Bit for bit, in any batch and on threads; a reset forgets them."""
    world, several = World(rolling(dim), 3), World(rolling(dim), 3, threads=2)
    for one in (world, several):
        one.set_velocity("b1", angular=[spin_of(dim, x) for x in (0.0, 2.0, 4.0)])
        one.step(25)
    reading = world.sensors()
    assert reading.any(0).sum() >= 4
    assert several.sensors().tobytes() == reading.tobytes()
    single = World(world.model, 3)
    single.set_velocity("b1", angular=[spin_of(dim, x) for x in (0.0, 2.0, 4.0)])
    for _ in range(25):
        single.step()
    assert single.sensors().tobytes() == reading.tobytes()

    saved = pickle.loads(pickle.dumps(world.save()))
    fresh = World(world.model, 3)
    fresh.restore(saved)
    assert fresh.sensors().tobytes() == reading.tobytes()
    fresh.set_velocity("b1", linear=(7.0,) * dim)
    fresh.set_pose("b1", position=(9.0,) * dim)
    assert fresh.sensors()[:, : len(reading[0])].tobytes() == reading.tobytes()

    world.reset(worlds=1)
    assert world.sensors()[[0, 2]].tobytes() == reading[[0, 2]].tobytes()
    assert not world.sensor("a")[1].any()
    world.restore(saved)
    assert world.sensors().tobytes() == reading.tobytes()


@BOTH
def test_the_motion_is_kept_only_where_a_sensor_needs_it(dim: int) -> None:
    """And it changes nothing; snapshots fit in both directions."""
    scene, plain = rolling(dim), Scene(dim=dim)
    plain = rolling(dim)
    plain.sensors.clear()
    with_motion, without = World(scene), World(plain)
    assert without.state.motions is None
    assert with_motion.state.motions is not None
    for world in (with_motion, without):
        world.step(20)
    for name in ("position", "rotation", "velocity"):
        assert with_motion.state.bodies[name].tobytes() == without.state.bodies[name].tobytes()
    saved, bare = with_motion.save(), without.save()
    assert bare.motions is None
    without.restore(saved)
    with_motion.restore(bare)
    assert not with_motion.sensor("a").any()


def test_a_bad_control_leaves_the_readings() -> None:
    scene = rolling(2)
    scene.add_joint("pull", planar.Target("b0"))
    scene.add_actuator("x", "pull", "x")
    world = World(scene)
    world.step(20)
    reading = world.sensors().tobytes()
    world.control[0] = np.nan
    for count in (1, 3):
        with pytest.raises(ValueError, match="control of actuator 'x'"):
            world.step(count)
        assert world.sensors().tobytes() == reading
