"""Worlds to pictures."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gsenv.render import make_renderer
from gsenv.render.camera import Camera, FollowCamera
from gsenv.render.joint_items import DRAWN_JOINTS
from gsenv.render.projection import project
from gsenv.render.scene_renderer import SceneRenderer
from gsenv.render.theme import FORCE_COLOR, PALETTE
from gsenv.solver import Handle, Scene
from gsenv.solver.api.world import World
from gsenv.solver.planar import Box, Capsule, Circle, Distance, HalfPlane, Polygon, Target, Terrain, Weld
from gsenv.solver.spatial import Sphere
from tests.solver.joints import make_joint

WIDTH, HEIGHT = 160, 120
CAMERA = Camera((0.0, 1.0), 6.0)  # 20 px per m
HILLS = np.stack([np.linspace(-9.0, 9.0, 19), np.sin(np.linspace(-9.0, 9.0, 19))], axis=1)


def make_world(world_count: int = 1) -> World:
    scene = Scene()
    scene.add_body("ground", "static", [HalfPlane()])
    scene.add_body("box", shapes=[Box(half_extents=(0.5, 0.25))], position=(-2.0, 1.0))
    scene.add_body("ball", shapes=[Circle(radius=0.5)], position=(0.0, 2.0))
    scene.add_body("rod", shapes=[Capsule(half_length=0.5, radius=0.2)], position=(2.0, 1.0), angle=0.5)
    return World(scene, world_count)


def pixel(x: float, y: float) -> tuple[int, int]:
    """Row and column of a world point under CAMERA."""
    column, row = CAMERA.to_pixel((x, y), WIDTH, HEIGHT)
    return int(row), int(column)


def changed(a: NDArray[np.uint8], b: NDArray[np.uint8]) -> NDArray[np.bool_]:
    return (a != b).any(axis=2)


def test_frames_are_fresh_rgb_arrays_and_repeat() -> None:
    renderer = SceneRenderer(make_world(), WIDTH, HEIGHT)
    first, second = renderer.render(), renderer.render()
    assert first.shape == (HEIGHT, WIDTH, 3)
    assert first.dtype == np.uint8
    assert not np.shares_memory(first, second)
    np.testing.assert_array_equal(first, second)


def test_rendering_leaves_the_simulation_alone() -> None:
    world = make_world()
    arrays = [*vars(world.state).values(), *vars(world.parameters).values()]
    arrays = [array for array in arrays if isinstance(array, np.ndarray)]
    before = [array.tobytes() for array in arrays]
    renderer = SceneRenderer(world, WIDTH, HEIGHT, FollowCamera([1]), overlay=("contacts", "joints"))
    renderer.render(hud=("t",))
    assert [array.tobytes() for array in arrays] == before


def test_bodies_are_where_they_are_in_palette_colours() -> None:
    image = SceneRenderer(make_world(), WIDTH, HEIGHT, CAMERA).render()
    for k, point in enumerate([(-2.0, 1.0), (-0.25, 2.2), (2.0, 1.0)]):
        # shading changes a colour by at most a tenth
        np.testing.assert_allclose(image[pixel(*point)].astype(float), PALETTE[k], atol=27)
    assert image[pixel(0.0, -1.0)].sum() < 400 < image[pixel(0.0, 3.5)].sum()


def test_each_world_has_its_own_picture() -> None:
    world = make_world(2)
    world.set_pose("box", worlds=1, position=(1.0, 3.0))
    renderer = SceneRenderer(world, WIDTH, HEIGHT, CAMERA)
    moved = changed(renderer.render(0), renderer.render(1))
    assert moved[pixel(-2.0, 1.0)]
    assert moved[pixel(1.0, 3.0)]
    assert not moved[pixel(2.0, 1.0)]


@pytest.mark.parametrize("wheels", [(), (2,)])
def test_a_turning_circle_can_be_seen_to_turn(wheels: tuple[int, ...]) -> None:
    world = make_world()
    renderer = SceneRenderer(world, WIDTH, HEIGHT, CAMERA, wheels=wheels)
    start = renderer.render()
    turns = (0.3, 1.0, np.pi) if not wheels else (0.3, 0.6)
    for angle in turns:
        world.set_pose("ball", angle=angle)
        difference = changed(renderer.render(), start)
        row, column = pixel(0.0, 2.0)
        assert difference[row - 10 : row + 10, column - 10 : column + 10].sum() > 25
        difference[row - 11 : row + 11, column - 11 : column + 11] = False
        assert not difference.any()


def test_disabled_bodies_vanish() -> None:
    world = make_world(2)
    renderer = SceneRenderer(world, WIDTH, HEIGHT, CAMERA)
    full = renderer.render(1)
    world.parameters.set("box", worlds=1, enabled=False)
    assert changed(renderer.render(1), full)[pixel(-2.0, 1.0)]
    np.testing.assert_array_equal(renderer.render(0), full)
    world.parameters.set("box", worlds=1, enabled=True)
    np.testing.assert_array_equal(renderer.render(1), full)


def test_shape_offsets_and_centres_of_mass_do_not_mix() -> None:
    scene = Scene()
    parts = [Box(half_extents=(0.2, 0.2)), Box(half_extents=(0.2, 0.2), position=(1.0, 0.0))]
    scene.add_body("pair", shapes=parts, position=(0.0, 1.0), angle=np.pi / 2.0)
    image = SceneRenderer(World(scene), WIDTH, HEIGHT, CAMERA).render().astype(float)
    for point in [(0.0, 1.0), (0.0, 2.0)]:
        np.testing.assert_allclose(image[pixel(*point)], PALETTE[0], atol=27)
    assert image[pixel(1.0, 1.0)].min() > 150
    assert image[pixel(0.0, 0.5)].min() > 150


@pytest.mark.parametrize("color", [(10, 200, 30), (0, 0, 0)])
def test_given_colours_win(color: tuple[int, int, int]) -> None:
    scene = Scene()
    scene.add_body("box", shapes=[Box(half_extents=(1.0, 1.0))], position=(0.0, 1.0), color=color)
    image = SceneRenderer(World(scene), WIDTH, HEIGHT, CAMERA).render()
    np.testing.assert_allclose(image[pixel(0.0, 1.0)], color, atol=10)


def test_terrain_and_polygons_are_drawn() -> None:
    scene = Scene()
    scene.add_body("hills", "static", [Terrain(vertices=HILLS)])
    scene.add_body(
        "wedge",
        shapes=[Polygon(vertices=[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])],
        position=(0.0, 2.0),
    )
    image = SceneRenderer(World(scene), WIDTH, HEIGHT, CAMERA).render().astype(int)
    soil, sky = image[pixel(1.5, 0.0)], image[pixel(1.5, 1.8)]
    assert soil[0] > soil[2] + 20
    assert sky.min() > 180
    assert (image[pixel(0.3, 2.3)] != image[pixel(0.8, 2.8)]).any()


def test_the_default_camera_shows_all_bodies() -> None:
    world = make_world()
    world.set_pose("box", position=(-30.0, 12.0))
    renderer = SceneRenderer(world, WIDTH, HEIGHT)
    renderer.render()
    assert isinstance(renderer.camera, Camera)
    pixels = renderer.camera.to_pixel(world.position[0, 1:], WIDTH, HEIGHT)
    assert (pixels > 0.0).all()
    assert (pixels < (WIDTH, HEIGHT)).all()


def test_the_follow_camera_keeps_its_body_in_place() -> None:
    world = make_world()
    renderer = SceneRenderer(world, WIDTH, HEIGHT, FollowCamera([2], height=6.0))
    before = renderer.render()
    world.set_pose("ball", position=(40.0, 7.0))
    after = renderer.render()
    middle = (slice(52, 68), slice(72, 88))
    difference = before[middle].astype(int) - after[middle]
    assert np.abs(difference).max() <= 1  # the dither alone


def test_contact_arrows_show_point_and_direction() -> None:
    world = make_world()
    world.state.worlds["contact_count"] = 1
    contact = world.state.contacts[0, :1]
    contact["point"], contact["normal"] = (0.0, 0.0), (0.0, 1.0)
    contact["total_impulse"] = (1.0, 0.0)
    plain = SceneRenderer(world, WIDTH, HEIGHT, CAMERA).render()
    renderer = SceneRenderer(world, WIDTH, HEIGHT, CAMERA, overlay=["contacts"])
    marked = changed(renderer.render(), plain)
    rows, columns = np.nonzero(marked)
    row, column = pixel(0.0, 0.0)
    assert row - 16 < rows.min() < row - 8
    assert rows.max() < row + 6
    assert column - 6 < columns.min()
    assert columns.max() < column + 6
    np.testing.assert_allclose(renderer.render()[row - 7, column].astype(float), FORCE_COLOR, atol=60)
    contact["sensor"] = 1
    np.testing.assert_array_equal(renderer.render(), plain)


def jointed_world(kind: str | None = None) -> tuple[World, Handle | None]:
    """Box and ball side by side, the box hung from the point (-1, 3) by a joint; and that joint."""
    scene = Scene()
    scene.add_body("wall", "static")
    scene.add_body("box", shapes=[Box(half_extents=(0.4, 0.4))], position=(-1.0, 1.0))
    scene.add_body("ball", shapes=[Circle(radius=0.4)], position=(1.0, 1.0))
    given: dict[str, dict[str, Any]] = {
        "revolute": {"anchor": (-1.0, 3.0)},
        "prismatic": {"anchor": (-1.0, 3.0), "axis": (0.0, 1.0)},
        "distance": {"anchor_a": (-1.0, 3.0), "anchor_b": (0.0, 0.0)},
        "wheel": {"anchor": (-1.0, 3.0), "axis": (0.0, 1.0), "frequency": 2.0},
    }
    joint = None if kind is None else scene.add_joint("joint", make_joint(kind, "wall", "box", **given[kind]))
    return World(scene), joint


@pytest.mark.parametrize("kind", DRAWN_JOINTS)
def test_joints_are_drawn_where_they_are_unless_switched_off(kind: str) -> None:
    world, joint = jointed_world(kind)
    bare = SceneRenderer(jointed_world()[0], WIDTH, HEIGHT, CAMERA).render()
    renderer = SceneRenderer(world, WIDTH, HEIGHT, CAMERA)
    near = changed(renderer.render(), bare)
    row, column = pixel(-1.0, 3.0)
    assert near[row, column]
    assert not near[:, WIDTH // 2 + 5 :].any()
    off = SceneRenderer(world, WIDTH, HEIGHT, CAMERA, joints=())
    np.testing.assert_array_equal(off.render(), bare)
    world.parameters.set(joint, enabled=False)
    np.testing.assert_array_equal(renderer.render(), bare)


def test_joints_of_disabled_bodies_vanish() -> None:
    (world, _), (bare, _) = jointed_world("distance"), jointed_world()
    for each in (world, bare):
        each.parameters.set("box", enabled=False)
    picture, expected = (SceneRenderer(each, WIDTH, HEIGHT, CAMERA).render() for each in (world, bare))
    np.testing.assert_array_equal(picture, expected)


def test_welds_and_targets_are_drawn_only_if_asked_for() -> None:
    def world(*kinds: str) -> World:
        scene = Scene()
        scene.add_body("a", shapes=[Box(half_extents=(0.4, 0.4))], position=(-0.4, 1.0))
        scene.add_body("b", shapes=[Box(half_extents=(0.4, 0.4))], position=(0.4, 1.0))
        if "weld" in kinds:
            scene.add_joint("weld", Weld("a", "b", anchor=(0.0, 1.0)))
        if "target" in kinds:
            scene.add_joint("target", Target("a", frequency=1.0))
        return World(scene)

    bare = SceneRenderer(world(), WIDTH, HEIGHT, CAMERA).render()
    for kind, place in (("weld", (0.0, 1.0)), ("target", (-0.4, 1.0))):
        plain = SceneRenderer(world(kind), WIDTH, HEIGHT, CAMERA).render()
        np.testing.assert_array_equal(plain, bare)
        shown = SceneRenderer(world(kind), WIDTH, HEIGHT, CAMERA, joints=(kind,)).render()
        assert changed(shown, bare)[pixel(*place)]


@pytest.mark.parametrize("kind", ["wheel", "revolute"])
def test_circles_on_axles_are_wheels(kind: str) -> None:
    def picture(anchor: tuple[float, float] | None, wheels: tuple[int, ...]) -> NDArray[np.uint8]:
        scene = Scene()
        scene.add_body("chassis", shapes=[Box(half_extents=(1.0, 0.3))], position=(0.0, 2.0))
        scene.add_body("wheel", shapes=[Circle(radius=0.6)], position=(0.0, 0.6))
        if anchor is not None:
            axis: dict[str, Any] = {"axis": (0.0, 1.0)} if kind == "wheel" else {}
            scene.add_joint("axle", make_joint(kind, "chassis", "wheel", anchor=anchor, **axis))
        return SceneRenderer(World(scene), WIDTH, HEIGHT, CAMERA, wheels=wheels, joints=()).render()

    ball, wheel = picture(None, ()), picture(None, (1,))
    assert changed(ball, wheel).any()
    np.testing.assert_array_equal(picture((0.0, 0.6), ()), wheel)
    np.testing.assert_array_equal(picture((0.0, 1.1), ()), ball)


def test_the_default_camera_shows_what_a_pendulum_will_swing_through() -> None:
    scene = Scene()
    scene.add_body("wall", "static")
    scene.add_body("bob", shapes=[Circle(radius=0.2)], position=(-2.0, 3.0))
    scene.add_joint("rod", Distance("wall", "bob", anchor_a=(0.0, 3.0), anchor_b=(0.0, 0.0)))
    renderer = SceneRenderer(World(scene), WIDTH, HEIGHT)
    renderer.render()
    assert isinstance(renderer.camera, Camera)
    corners = renderer.camera.to_pixel([(-2.2, 3.0), (2.2, 3.0), (0.0, 0.8)], WIDTH, HEIGHT)
    assert (corners > 0.0).all()
    assert (corners < (WIDTH, HEIGHT)).all()


def test_static_circles_have_no_mark_of_turning() -> None:
    scene = Scene()
    scene.add_body("drum", "static", [Circle(radius=1.0)], position=(0.0, 1.0))
    row = SceneRenderer(World(scene), WIDTH, HEIGHT, CAMERA).render()[pixel(0.0, 1.0)[0]].astype(int)
    inside = row[pixel(-0.8, 1.0)[1] : pixel(0.8, 1.0)[1]]
    assert np.ptp(inside, axis=0).max() <= 1  # the dither alone


def test_joint_frames_sit_on_their_anchors() -> None:
    scene = Scene()
    scene.add_body("a", shapes=[Box(half_extents=(0.4, 0.4))], position=(-1.0, 1.0))
    scene.add_body("b", shapes=[Box(half_extents=(0.4, 0.4))], position=(1.0, 1.0), angle=0.3)
    scene.add_joint("weld", Weld("a", "b", anchor=(0.0, 2.0)))
    world = World(scene)
    plain, marked = (
        SceneRenderer(world, WIDTH, HEIGHT, CAMERA, overlay=overlay).render() for overlay in ((), ("joints",))
    )
    rows, columns = np.nonzero(changed(plain, marked))
    row, column = pixel(0.0, 2.0)
    assert abs(rows - row).max() < 9
    assert abs(columns - column).max() < 9


def test_the_hud_is_drawn_on_top() -> None:
    renderer = SceneRenderer(make_world(), WIDTH, HEIGHT, CAMERA)
    assert changed(renderer.render(hud=("t = 1.0 s",)), renderer.render())[4:15, 4:40].any()


def test_bad_arguments() -> None:
    world = make_world()
    with pytest.raises(ValueError, match="overlay"):
        SceneRenderer(world, overlay=("velocities",))
    with pytest.raises(ValueError, match="width and height"):
        SceneRenderer(world, 0, 10)
    with pytest.raises(ValueError, match="joints"):
        SceneRenderer(world, joints=("gear",))
    with pytest.raises(ValueError, match=r"overlay must be a sequence of names, such as \('contacts',\)"):
        SceneRenderer(world, overlay="contacts")
    for wheels in ([99], [-1], [0.5], ["ball"], 2):
        with pytest.raises(ValueError, match="wheels must be indices of bodies, below 4"):
            SceneRenderer(world, wheels=wheels)  # type: ignore[arg-type]
    for scale in (np.nan, np.inf, -1.0, "x"):
        with pytest.raises(ValueError, match="force_scale must be None or a finite number"):
            SceneRenderer(world, force_scale=scale)  # type: ignore[arg-type]


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"world_index": -1}, "world_index must be a whole number from 0 to 0, got -1"),
        ({"world_index": 1}, "world_index must be a whole number"),
        ({"world_index": 0.0}, "world_index must be a whole number"),
        ({"world_index": False}, "world_index must be a whole number"),
        ({"world_index": "a"}, "world_index must be a whole number"),
        ({"hud": "text"}, "hud must be a sequence of lines of text, got 'text'"),
        ({"hud": [1]}, "hud must be a sequence of lines of text"),
        ({"hud": 1}, "hud must be a sequence of lines of text"),
        ({"lines": np.zeros((2, 5))}, r"lines must be an array \(line, 2, [23]\) of numbers, got \(2, 5\)"),
        ({"lines": "x"}, "lines must be an array"),
        ({"lines": [[[0.0, np.nan, 0.0][:2]] * 2]}, "lines must be"),
    ],
)
def test_what_cannot_be_rendered_is_one_sentence(dim: int, arguments: dict[str, Any], sentence: str) -> None:
    renderer = make_renderer(scene_world(dim), 32, 24)
    with pytest.raises(ValueError, match=sentence):
        renderer.render(**arguments)
    assert renderer.render(np.int64(0), hud=["text"], lines=np.ones((1, 2, dim))).shape == (24, 32, 3)


def scene_world(dim: int, world_count: int = 1) -> World:
    scene = Scene(dim=dim)
    ball: Any = Circle(radius=0.5) if dim == 2 else Sphere(radius=0.5)
    scene.add_body("ball", shapes=[ball])
    scene.add_body("other", shapes=[ball], position=(2.0,) + (0.0,) * (dim - 1))
    return World(scene, world_count)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_body_that_is_nowhere_is_one_sentence_unless_it_is_disabled(dim: int) -> None:
    world = scene_world(dim, 2)
    renderer = make_renderer(world, 32, 24)
    expected = renderer.render(0)
    world.state.bodies["position"][1, 1] = np.nan
    with pytest.raises(ValueError, match="the pose of body 'other' in world 1 is not finite"):
        renderer.render(1)
    np.testing.assert_array_equal(renderer.render(0), expected)
    world.parameters.set("other", worlds=1, enabled=False)
    renderer.render(1)


@pytest.mark.parametrize("dim", [2, 3])
def test_one_thread_at_a_time_uses_a_renderer_and_its_world(dim: int) -> None:
    world = scene_world(dim)
    renderer = make_renderer(world, 32, 24)
    expected = renderer.render()
    for use, name in ((renderer._use, type(renderer).__name__), (world._use, "World")):
        use.free.pop()  # as another thread does
        try:
            with pytest.raises(RuntimeError, match=f"render: another thread is using this {name}"):
                renderer.render()
        finally:
            use.free.append(True)
        np.testing.assert_array_equal(renderer.render(), expected)


def test_worlds_and_cameras_of_the_other_dimension_are_refused() -> None:
    with pytest.raises(ValueError, match="a SceneRenderer draws 2D worlds, got one with dim 3"):
        SceneRenderer(scene_world(3))
    renderer = make_renderer(scene_world(3), 32, 24)
    renderer.camera = CAMERA
    with pytest.raises(TypeError, match="camera must be a SpatialCamera"):
        renderer.render()


@pytest.mark.parametrize(
    "camera",
    [Camera((0, 0), 0), Camera((0, 0), -1.0), Camera((np.nan, 0.0), 1.0), Camera((0.0, 0.0), np.nan), Camera(0.0, 1.0)],  # type: ignore[arg-type]
)
def test_cameras_that_show_nothing_are_one_sentence(camera: Camera) -> None:
    with pytest.raises(ValueError, match=r"a Camera needs a finite center \(x, y\) and a positive height"):
        SceneRenderer(make_world(), WIDTH, HEIGHT, camera).render()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"bodies": []}, "bodies must be at least one"),
        ({"bodies": [-1]}, "bodies must be indices of bodies, below 4"),
        ({"bodies": [0, 9]}, r"bodies must be indices of bodies, below 4, got \[0, 9\]"),
        ({"bodies": ["ball"]}, "bodies must be indices of bodies"),
        ({"height": np.nan}, "height must be a finite number of at least 0"),
        ({"height": None}, "height must be a finite number of at least 0"),
        ({"smooth_time": -1.0}, "smooth_time must be a finite number of at least 0"),
        ({"margin": np.inf}, "margin must be a finite number of at least 0"),
        ({"offset": (np.nan, 0.0)}, "offset must be two finite numbers"),
        ({"offset": 1.0}, "offset must be two finite numbers"),
    ],
)
def test_bad_follow_cameras_are_one_sentence(arguments: dict[str, Any], sentence: str) -> None:
    camera = FollowCamera(**({"bodies": [0]} | arguments))
    with pytest.raises(ValueError, match=sentence):
        SceneRenderer(make_world(), WIDTH, HEIGHT, camera).render()


def test_a_camera_of_whole_numbers_compiles_nothing() -> None:
    world = make_world()
    expected = SceneRenderer(world, WIDTH, HEIGHT, Camera((0.0, 1.0), 5.0)).render()
    kernel: Any = project
    count = len(kernel.signatures)
    np.testing.assert_array_equal(SceneRenderer(world, WIDTH, HEIGHT, Camera((0, 1), 5)).render(), expected)
    assert len(kernel.signatures) == count
