"""Bad files are refused with one sentence that names the place and the reason."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import pytest

from gsenv.mjcf import MjcfError, load_mjcf, parse_mjcf


def world(text: str) -> str:
    return f"<mujoco>\n<worldbody>\n{text}\n</worldbody>\n</mujoco>"


def body(text: str) -> str:
    return world(f'<body name="b"><geom size=".1"/>{text}</body>')


JOINTED = '<worldbody><body name="b"><joint name="j" range="-1 1"/><geom name="g" size=".1"/></body></worldbody>'
BILLION_LAUGHS = (
    '<!DOCTYPE x [<!ENTITY a "lol"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]><mujoco model="&b;"><worldbody/></mujoco>'
)

CASES = {
    "text before XML": ("model <mujoco/>", "string, line 1: not well-formed XML: it must start with '<'"),
    "not XML": ("<mujoco", "string, line 1: not well-formed XML: unclosed token"),
    "empty element": ("<mujoco></worldbody>", "not well-formed XML: mismatched tag"),
    "entities": (BILLION_LAUGHS, "string, line 1: a document type declaration is not allowed"),
    "URDF": ("<robot/>", "the outermost element of an MJCF file is mujoco, not robot"),
    "section": ("<mujoco><wordbody/></mujoco>", "wordbody is no section of an MJCF file"),
    "element of a body": (world("<geo size='1'/>"), "line 3: geo is no element of a body"),
    "joint of the world": (world("<joint/>"), "the world must not have a joint"),
    "size missing": (world("<geom name='g'/>"), "line 3: geom 'g': the size of a sphere must be a positive number"),
    "size too short": (
        world("<geom type='box' size='1 2'/>"),
        "size of a box must be three positive numbers, got '1 2'",
    ),
    "size negative": (world("<geom size='-1'/>"), "size of a sphere must be a positive number, got '-1'"),
    "size too large": (world("<geom size='1e300'/>"), "geom: its size is too large"),
    "size too long": (world("<geom size='1 2 3 4'/>"), "size must be at most three numbers, got '1 2 3 4'"),
    "not a number": (world("<geom size='.1' pos='0 0 x'/>"), "pos must be finite numbers, got 'x'"),
    "nan": (world("<geom size='nan'/>"), "size must be finite numbers, got 'nan'"),
    "infinite": (world("<geom size='.1' pos='0 0 1e999'/>"), "pos must be finite numbers, got '1e999'"),
    "underscore": (world("<geom size='1_0'/>"), "size must be finite numbers, got '1_0'"),
    "count": (world("<geom size='.1' pos='0 0'/>"), "pos must be three numbers, got '0 0'"),
    "no count": (world("<geom size='.1' pos=''/>"), "pos must be three numbers, got ''"),
    "kind": (world("<geom type='ball' size='.1'/>"), "type must be one of plane, sphere, .*, got 'ball'"),
    "condim": (world("<geom size='.1' condim='2'/>"), "condim must be 1, 3, 4 or 6, got 2"),
    "bits": (world("<geom size='.1' contype='.5'/>"), "contype must be a whole number, got 0.5"),
    "density": (world("<geom size='.1' density='-1'/>"), "density must not be negative, got -1"),
    "friction": (world("<geom size='.1' friction='-1'/>"), "friction must not be negative, got '-1'"),
    "two rotations": (world("<geom size='.1' euler='0 0 1' quat='1 0 0 0'/>"), "given twice, by quat and euler"),
    "zero quaternion": (world("<geom size='.1' quat='0 0 0 0'/>"), "quat has no direction, got '0 0 0 0'"),
    "parallel axes": (world("<geom size='.1' xyaxes='1 0 0 1 0 0'/>"), "xyaxes has no direction"),
    "fromto of a point": (world("<geom type='capsule' size='.1' fromto='1 1 1 1 1 1'/>"), "two different points"),
    "no mesh": (world("<geom type='mesh' mesh='m'/>"), "there is no mesh 'm'"),
    "no hfield": (world("<geom type='hfield'/>"), "hfield is missing"),
    "class": (world("<geom size='.1' class='c'/>"), "there is no default class 'c'"),
    "class twice": (
        "<mujoco><default><default class='c'/><default class='c'/></default></mujoco>",
        "the default class 'c' is defined twice",
    ),
    "class without name": ("<mujoco><default><default/></default></mujoco>", "a default inside another needs a class"),
    "names": (
        world("<geom name='g' size='1'/>\n<geom name='g' size='1'/>"),
        "geom: the name 'g' is given already",
    ),
    "actuator names": (
        f"<mujoco>{JOINTED}<actuator><motor name='m' joint='j'/><motor name='m' joint='j'/></actuator></mujoco>",
        "actuator: the name 'm' is given already in string, line 1",
    ),
    "frames": (world("<frame>" * 5000 + "</frame>" * 5000), "frames are nested too deeply"),
    "axis": (body("<joint axis='0 0 0'/>"), "axis must not be zero"),
    "range": (body("<joint range='1 -1'/>"), "range must be two numbers, the lower one first, got 1 -1"),
    "limited without range": (body("<joint limited='true'/>"), "range must be two numbers"),
    "damping": (body("<joint damping='-1'/>"), "damping must not be negative, got -1"),
    "free joint inside": (body("<body><freejoint/><geom size='1'/></body>"), "must be the only joint of its body"),
    "ball and hinge": (body("<joint type='ball'/><joint/>"), "rotate beside a ball joint"),
    "no mass": (world("<body name='b'><joint/></body>"), "body 'b' moves and needs a mass and moments of inertia"),
    "mocap inside": (body("<body mocap='true'/>"), "only a child of the world may be a mocap body"),
    "inertia": (
        world("<body><inertial pos='0 0 0' mass='1' diaginertia='1 1 3'/><joint/></body>"),
        "moments of inertia that no body has, 1, 1, 3 kg",
    ),
    "inertial without pos": (world("<body><inertial mass='1'/></body>"), "inertial: pos is missing"),
    "global": ("<mujoco><compiler coordinate='global'/></mujoco>", "coordinate is global"),
    "eulerseq": ("<mujoco><compiler eulerseq='xya'/></mujoco>", "eulerseq must be three letters"),
    "timestep": ("<mujoco><option timestep='0'/></mujoco>", "timestep must be positive, got 0"),
    "flag": ("<mujoco><option><flag gravity='off'/></option></mujoco>", "flag gravity must be enable or disable"),
    "include without file": ("<mujoco><include/></mujoco>", "include needs a file"),
    "missing include": ("<mujoco><include file='no.xml'/></mujoco>", "'no.xml' cannot be read: No such file"),
    "motor of nothing": (f"<mujoco>{JOINTED}<actuator><motor/></actuator></mujoco>", "needs one of joint.*got none"),
    "motor of no joint": (
        f"<mujoco>{JOINTED}<actuator><motor joint='x'/></actuator></mujoco>",
        "motor: there is no joint 'x'",
    ),
    "kp": (
        f"<mujoco>{JOINTED}<actuator><position joint='j' kp='-1'/></actuator></mujoco>",
        "kp must be one number that is not negative, got '-1'",
    ),
    "sensor of no joint": (
        f"<mujoco>{JOINTED}<sensor><jointpos joint='x'/></sensor></mujoco>",
        "jointpos: there is no joint 'x'",
    ),
    "exclude": (
        f"<mujoco>{JOINTED}<contact><exclude body1='b' body2='c'/></contact></mujoco>",
        "exclude: there is no body 'c'",
    ),
    "pair": (f"<mujoco>{JOINTED}<contact><pair geom1='g' geom2='h'/></contact></mujoco>", "there is no geom 'h'"),
    "equality": (
        f"<mujoco>{JOINTED}<equality><connect body1='b'/></equality></mujoco>",
        "connect: anchor is missing",
    ),
    "keyframe": (
        f"<mujoco>{JOINTED}<keyframe><key qpos='1 2'/></keyframe></mujoco>",
        "qpos must be 1 numbers, got 2",
    ),
    "mesh without triples": (
        "<mujoco><asset><mesh name='m' vertex='1 2'/></asset></mujoco>",
        "vertex must be triples of numbers, got 2 numbers",
    ),
    "heights": (
        "<mujoco><asset><hfield name='h' nrow='2' ncol='2' size='1 1 1 1' elevation='1 2'/></asset></mujoco>",
        "elevation must be 4 numbers, got 2",
    ),
    "too many heights": (
        "<mujoco><asset><hfield name='h' nrow='1000000' ncol='1000000' size='1 1 1 1'/></asset></mujoco>",
        "nrow times ncol must not exceed 1,000,000, got 1000000 times 1000000",
    ),
    "too few heights": (
        "<mujoco><asset><hfield name='h' nrow='1' ncol='10000000' size='1 1 1 1'/></asset></mujoco>",
        "a hfield needs nrow and ncol of at least 2 each, got 1 and 10000000",
    ),
}


@pytest.mark.parametrize("name", list(CASES))
def test_bad_file(name: str) -> None:
    text, message = CASES[name]
    with pytest.raises(MjcfError, match=message) as caught:
        parse_mjcf(text)
    sentence = str(caught.value)
    assert sentence.startswith("string, line ")
    assert sentence.endswith(".")
    assert "\n" not in sentence


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(MjcfError, match=r"the file '.*no\.xml' cannot be read: No such file or directory\.$"):
        parse_mjcf(tmp_path / "no.xml")


def test_deep_files_are_read() -> None:
    depth = 3000  # deeper than Python's stack
    text = '<body pos="0 0 1"><joint/><geom size=".1"/>' * depth + "</body>" * depth
    model = parse_mjcf(world(text))
    assert model.coordinate_count == depth
    assert model.bodies[-1].world_pose.position[2] == depth


def test_unknown_attributes_are_told_once_each() -> None:
    model = parse_mjcf(
        world('<geom size=".1" colour="red"/>\n' * 3 + '<geom name="g" size=".1" margin="1" solref="1 1"/>')
    )
    assert model.warnings == (
        "string, line 3: geom (and 2 more): the attribute colour of geom is ignored.",
        "string, line 6: geom 'g': soft-contact parameters are ignored, contacts and limits are rigid.",
    )


def test_parsing_issues_no_warnings() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parsed = parse_mjcf(world('<geom size=".1" colour="red"/>'))
    assert len(parsed.geoms) == 1


@pytest.mark.parametrize("nothing", ["", " \n", None, 3])
def test_what_is_no_path_and_no_text_is_refused_in_one_sentence(nothing: Any) -> None:
    with pytest.raises(MjcfError, match=r"^a path or the text of a file is needed, got .*"):
        load_mjcf(nothing)
