"""Joints laid out between hand-made anchors: where their lines run, and what changes with what."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gsenv.render.draw_list import DrawList, Layer
from gsenv.render.joint_items import DRAWN_JOINTS, KNOWN_JOINTS, TURNS, JointStencil, make_joint_stencil
from gsenv.render.world_view import JointState, JointTable

FloatArray = NDArray[np.float64]
VIEW = 8.0  # m


def one_joint(kind: str, **fields: Any) -> tuple[JointStencil, JointState]:
    """Stencil and state of one joint from (1, 2) to (4, -2): 5 m apart."""
    given = {"fixed": False, "has_spring": False, "rigid": False, "size": np.inf, "span": 0.5, "mount": -1.0}
    table = {name: np.array([fields.pop(name, value)]) for name, value in given.items()}
    bodies = np.zeros(1, np.int32)
    stencil = make_joint_stencil(JointTable((kind,), bodies, bodies + 1, **table), KNOWN_JOINTS)
    assert stencil is not None
    state = {
        "anchor_a": (1.0, 2.0),
        "anchor_b": (4.0, -2.0),
        "axis": (0.6, -0.8),
        "lower": -np.inf,
        "upper": np.inf,
        "goal": (0.0, 0.0),
        "enabled": True,
    } | fields
    arrays = {name: np.array([value]) for name, value in state.items()}
    return stencil, JointState(down=np.array([0.0, -1.0]), **arrays)


def paths(draw_list: DrawList) -> list[FloatArray]:
    """Points (point, 2) in m of each item."""
    items, vertices = draw_list
    ends = items["vertex_first"] + items["vertex_count"]
    return [vertices[first:end] for first, end in zip(items["vertex_first"], ends, strict=True)]


def longest(draw_list: DrawList) -> FloatArray:
    """The path with the most points; of equals, the first that is no dot."""
    lines = [path for path in paths(draw_list) if np.ptp(path, axis=0).any()]
    return max(lines, key=len)


def lengths(path: FloatArray) -> FloatArray:
    return np.hypot(*np.diff(path, axis=0).T)


def test_a_revolute_is_a_pin_before_the_bodies_on_a_plate_behind_them_where_it_is_fixed() -> None:
    stencil, state = one_joint("revolute", fixed=True, anchor_b=(1.0, 2.0))
    draw_list = stencil.fill(state, VIEW)
    assert list(draw_list.items["layer"]) == [Layer.LINK, Layer.PIN]
    assert draw_list.items["radius"][0] > draw_list.items["radius"][1] > 0.0
    np.testing.assert_allclose(draw_list.vertices, [(1.0, 2.0)] * 4)
    assert len(one_joint("revolute")[0].items) == 1


@pytest.mark.parametrize("fields", [{"rigid": True}, {"upper": 5.0}, {"upper": 4.9}, {"upper": np.inf}])
def test_rods_and_taut_ropes_are_straight(fields: dict[str, Any]) -> None:
    stencil, state = one_joint("distance", **fields)
    path = longest(stencil.fill(state, VIEW))
    np.testing.assert_allclose(path[[0, -1]], [(1.0, 2.0), (4.0, -2.0)])
    assert lengths(path).sum() == pytest.approx(5.0)


@pytest.mark.parametrize("length", [5.001, 5.3, 7.0, 12.0])
def test_slack_ropes_hang_down_and_keep_their_length(length: float) -> None:
    stencil, state = one_joint("distance", upper=length)
    path = longest(stencil.fill(state, VIEW))
    np.testing.assert_allclose(path[[0, -1]], [(1.0, 2.0), (4.0, -2.0)])
    assert lengths(path).sum() == pytest.approx(length, rel=0.01)  # of a chain of chords
    chord = 2.0 - 4.0 / 3.0 * (path[:, 0] - 1.0)
    assert (path[1:-1, 1] < chord[1:-1]).all()


def test_ropes_hang_along_gravity() -> None:
    stencil, state = one_joint("distance", upper=6.0)
    sideways = state._replace(down=np.array([1.0, 0.0]))
    down, right = (longest(stencil.fill(each, VIEW))[12] - (2.5, 0.0) for each in (state, sideways))
    assert down == pytest.approx((0.0, -np.hypot(*down)))
    assert right == pytest.approx((np.hypot(*right), 0.0))


def test_springs_stretch_by_their_pitch_alone() -> None:
    stencil, state = one_joint("distance", has_spring=True)
    turns, pitches = [], []
    for stretch in (0.2, 1.0, 3.0):
        end = np.array([[1.0 + 3.0 * stretch, 2.0 - 4.0 * stretch]])
        path = longest(stencil.fill(state._replace(anchor_b=end), VIEW))
        np.testing.assert_allclose(path[[0, -1]], [(1.0, 2.0), end[0]])
        along = (path - (1.0, 2.0)) @ (0.6, -0.8)
        left = (path - (1.0, 2.0)) @ (0.8, 0.6)
        assert left[[0, 1, -2, -1]] == pytest.approx(np.zeros(4))  # straight ends
        np.testing.assert_allclose(np.abs(left[2:-2]), np.abs(left[2]))
        turns.append(int((np.diff(np.sign(left[2:-2])) != 0.0).sum()) + 1)
        pitches.append(np.ptp(along[2:-2]) / stretch)
        assert (np.diff(along) > 0.0).all()
    assert turns == [TURNS] * 3
    np.testing.assert_allclose(pitches, pitches[0])


def test_rails_end_at_the_limits_with_stops() -> None:
    stencil, state = one_joint("prismatic", lower=-0.5, upper=1.5)
    path = longest(stencil.fill(state, VIEW))
    along, left = ((path - (1.0, 2.0)) @ np.array([(0.6, 0.8), (-0.8, 0.6)])).T
    assert (along.min(), along.max()) == pytest.approx((-0.5, 1.5))
    stops = np.abs(left) > 0.01
    assert stops.sum() == 4
    np.testing.assert_allclose(np.abs(along[stops] - 0.5), 1.0)


def test_rails_without_limits_cross_the_picture() -> None:
    stencil, state = one_joint("prismatic")
    path = longest(stencil.fill(state, VIEW))
    assert np.isfinite(path).all()
    assert np.hypot(*np.ptp(path, axis=0)) > 10.0 * VIEW


@pytest.mark.parametrize(("kind", "end"), [("prismatic", -1.0), ("wheel", 1.5)])
def test_springs_of_a_travel_run_from_body_a_to_the_anchor_on_body_b(kind: str, end: float) -> None:
    stencil, state = one_joint(kind, has_spring=True, mount=end)
    path = longest(stencil.fill(state, VIEW))
    np.testing.assert_allclose(path[[0, -1]], [(1.0 + 0.6 * end, 2.0 - 0.8 * end), (4.0, -2.0)])


def test_targets_are_marked_and_tied_to_their_body() -> None:
    stencil, state = one_joint("target", goal=(3.0, 3.0))
    leash, *cross = paths(stencil.fill(state, VIEW))
    np.testing.assert_allclose(leash, [(4.0, -2.0), (3.0, 3.0)])
    for arm in cross:
        np.testing.assert_allclose(arm.mean(axis=0), (3.0, 3.0))


@pytest.mark.parametrize("kind", KNOWN_JOINTS)
def test_disabled_joints_are_hidden(kind: str) -> None:
    stencil, state = one_joint(kind, has_spring=kind == "wheel")
    assert stencil.fill(state, VIEW).items["alpha"].min() == 1.0
    state = state._replace(enabled=np.zeros(1, bool))
    assert stencil.fill(state, VIEW).items["alpha"].max() == 0.0


def test_lines_are_as_wide_in_any_view_until_their_bodies_are_smaller() -> None:
    stencil, state = one_joint("distance", has_spring=True, size=0.1)
    shares, widths = [], []
    for view in (0.5, 1.0, 4.5, 9.0, 90.0):
        draw_list = stencil.fill(state, view)
        shares.append(draw_list.items["radius"][0] / view)
        path = longest(draw_list)
        widths.append(np.ptp((path - path[0]) @ (0.8, 0.6)) / view)
    for values in (shares, widths):
        assert values[:3] == pytest.approx([values[0]] * 3)
        assert values[3:] == pytest.approx([0.5 * values[0], 0.05 * values[0]])


def test_joints_without_a_picture_need_no_stencil() -> None:
    weld = one_joint("weld")[0].table
    for kind in ("gear", "rows"):
        assert make_joint_stencil(weld._replace(kinds=(kind,)), KNOWN_JOINTS) is None
    assert make_joint_stencil(weld, DRAWN_JOINTS) is None
    empty: Any = [np.asarray(field)[:0] for field in weld[1:]]
    none = JointTable((), *empty)
    assert make_joint_stencil(none, KNOWN_JOINTS) is None


def test_bounds_have_room_for_what_swings() -> None:
    stencil, state = one_joint("distance", rigid=True, fixed=True)
    assert stencil.find_bounds(state) == pytest.approx((1.0 - 5.5, 2.0 - 5.5, 1.0 + 5.5, 2.0))
    weightless = state._replace(down=np.array([0.0, 1.0]))
    assert stencil.find_bounds(weightless).top == pytest.approx(2.0 + 5.5)
    stencil, state = one_joint("distance", fixed=True, upper=7.0)
    assert stencil.find_bounds(state).bottom == pytest.approx(2.0 - 7.5)
    stencil, state = one_joint("distance", rigid=True)
    assert stencil.find_bounds(state) == pytest.approx((1.0, -2.0, 4.0, 2.0))
