"""Comparison of a parsed model with MuJoCo's own compilation of the same file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import mujoco
import numpy as np

from gsenv.mjcf import MjcfModel
from gsenv.mjcf.frames import Pose

GYMNASIUM = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"
FILES = sorted(path.name for path in GYMNASIUM.glob("*.xml"))
TOLERANCE = 1e-9
GEOM_KINDS = {"mesh": "MESH", "hfield": "HFIELD"}


def same(ours: Any, theirs: Any, what: str, tolerance: float = TOLERANCE) -> None:
    """Assert that numbers agree within ``tolerance``, absolute below 1 and relative above."""
    np.testing.assert_allclose(ours, theirs, rtol=tolerance, atol=tolerance, err_msg=what)


def axes(quaternion: Any) -> Any:
    return Pose(np.zeros(3), np.asarray(quaternion, float)).axes


def same_pose(ours: Pose, position: Any, quaternion: Any, what: str) -> None:
    same(ours.position, position, f"{what}: position")
    same(ours.axes, axes(quaternion), f"{what}: axes")


def compare(ours: MjcfModel, theirs: mujoco.MjModel) -> None:
    """Assert that both describe the same bodies, geoms, joints, actuators and keyframes."""
    compare_bodies(ours, theirs)
    compare_geoms(ours, theirs)
    compare_joints(ours, theirs)
    compare_actuators(ours, theirs)
    compare_others(ours, theirs)


def compare_bodies(ours: MjcfModel, theirs: mujoco.MjModel) -> None:
    assert len(ours.bodies) == theirs.nbody
    data = mujoco.MjData(theirs)
    mujoco.mj_kinematics(theirs, data)
    for k, body in enumerate(ours.bodies):
        what = f"body {k} {body.name!r}"
        assert body.name == theirs.body(k).name, what
        if k == 0:
            continue
        assert body.parent == theirs.body_parentid[k], what
        same_pose(body.pose, theirs.body_pos[k], theirs.body_quat[k], what)
        same_pose(body.world_pose, data.xpos[k], data.xquat[k], what)
        same(body.inertia.mass, theirs.body_mass[k], f"{what}: mass")
        if body.inertia.mass > 0.0:
            same(body.inertia.center, theirs.body_ipos[k], f"{what}: centre")
        principal = axes(theirs.body_iquat[k])
        same(body.inertia.tensor, principal @ np.diag(theirs.body_inertia[k]) @ principal.T, f"{what}: inertia")
        same(body.gravity_compensation, theirs.body_gravcomp[k], what)
        assert body.mocap == (theirs.body_mocapid[k] >= 0), what


def compare_geoms(ours: MjcfModel, theirs: mujoco.MjModel) -> None:
    assert len(ours.geoms) == theirs.ngeom
    for k, geom in enumerate(ours.geoms):
        what = f"geom {k} {geom.name!r}"
        assert geom.name == theirs.geom(k).name, what
        assert geom.body == theirs.geom_bodyid[k], what
        assert mujoco.mjtGeom(theirs.geom_type[k]) == getattr(mujoco.mjtGeom, f"mjGEOM_{geom.kind.upper()}"), what
        if geom.kind == "mesh":
            compare_mesh(ours, theirs, k)
        else:
            same_pose(geom.pose, theirs.geom_pos[k], theirs.geom_quat[k], what)
        if geom.kind not in ("mesh", "hfield"):
            same(geom.size, theirs.geom_size[k], f"{what}: size")
        bits = (geom.contype, geom.conaffinity, geom.condim, geom.group)
        theirs_bits = (theirs.geom_contype, theirs.geom_conaffinity, theirs.geom_condim, theirs.geom_group)
        assert bits == tuple(int(array[k]) for array in theirs_bits), what
        same(geom.friction, theirs.geom_friction[k], f"{what}: friction")
        if theirs.geom_matid[k] < 0:
            same(geom.rgba, theirs.geom_rgba[k], f"{what}: rgba", 1e-6)


def compare_mesh(ours: MjcfModel, theirs: mujoco.MjModel, k: int) -> None:
    """Compare the corners of a mesh in the body's frame; MuJoCo moves the mesh's own frame, and stores floats."""
    geom = ours.geoms[k]
    mesh = theirs.geom_dataid[k]
    first, count = theirs.mesh_vertadr[mesh], theirs.mesh_vertnum[mesh]
    vertices = theirs.geom_pos[k] + theirs.mesh_vert[first : first + count] @ axes(theirs.geom_quat[k]).T
    mine = geom.pose.point(ours.meshes[geom.asset].vertices)
    apart = np.linalg.norm(mine[:, None] - vertices[None], axis=2)
    assert apart.min(axis=1).max() < 1e-6
    assert apart.min(axis=0).max() < 1e-6


def compare_joints(ours: MjcfModel, theirs: mujoco.MjModel) -> None:
    assert len(ours.joints) == theirs.njnt
    assert (ours.coordinate_count, ours.rate_count) == (theirs.nq, theirs.nv)
    for k, joint in enumerate(ours.joints):
        what = f"joint {k} {joint.name!r}"
        assert joint.name == theirs.joint(k).name, what
        assert joint.body == theirs.jnt_bodyid[k], what
        kind = mujoco.mjtJoint(theirs.jnt_type[k])
        assert kind == getattr(mujoco.mjtJoint, f"mjJNT_{joint.kind.upper()}"), what
        assert (joint.coordinate, joint.rate) == (theirs.jnt_qposadr[k], theirs.jnt_dofadr[k]), what
        if joint.kind != "free":
            same(joint.position, theirs.jnt_pos[k], f"{what}: anchor")
        if joint.kind in ("slide", "hinge"):
            same(joint.axis, theirs.jnt_axis[k], f"{what}: axis")
            same(joint.reference, theirs.qpos0[joint.coordinate], f"{what}: ref")
            same(joint.spring_reference, theirs.qpos_spring[joint.coordinate], f"{what}: springref")
        assert (joint.limits is not None) == bool(theirs.jnt_limited[k]), what
        if joint.limits is not None:
            same(joint.limits, theirs.jnt_range[k], f"{what}: range")
        same(joint.stiffness, theirs.jnt_stiffness[k], f"{what}: stiffness")
        dof = joint.rate
        same(joint.damping, theirs.dof_damping[dof], f"{what}: damping")
        same(joint.armature, theirs.dof_armature[dof], f"{what}: armature")
        same(joint.friction_loss, theirs.dof_frictionloss[dof], f"{what}: frictionloss")
        assert (joint.force_range is not None) == bool(theirs.jnt_actfrclimited[k]), what
        if joint.force_range is not None:
            same(joint.force_range, theirs.jnt_actfrcrange[k], what)


def compare_actuators(ours: MjcfModel, theirs: mujoco.MjModel) -> None:
    assert len(ours.actuators) == theirs.nu
    for k, actuator in enumerate(ours.actuators):
        what = f"actuator {k} {actuator.name!r}"
        assert actuator.name == theirs.actuator(k).name, what
        same(actuator.gear, theirs.actuator_gear[k], f"{what}: gear")
        same(actuator.gain, theirs.actuator_gainprm[k][0], f"{what}: gain")
        same(actuator.bias, theirs.actuator_biasprm[k][:3], f"{what}: bias")
        for bounds, limited, numbers in (
            (actuator.control_range, theirs.actuator_ctrllimited, theirs.actuator_ctrlrange),
            (actuator.force_range, theirs.actuator_forcelimited, theirs.actuator_forcerange),
        ):
            assert (bounds is not None) == bool(limited[k]), what
            if bounds is not None:
                same(bounds, numbers[k], f"{what}: range")


def compare_others(ours: MjcfModel, theirs: mujoco.MjModel) -> None:
    assert len(ours.sites) == theirs.nsite
    for k, site in enumerate(ours.sites):
        assert (site.name, site.body) == (theirs.site(k).name, theirs.site_bodyid[k])
        same_pose(site.pose, theirs.site_pos[k], theirs.site_quat[k], f"site {k}")
    assert len(ours.cameras) == theirs.ncam
    for k, camera in enumerate(ours.cameras):
        assert (camera.name, camera.body) == (theirs.cam(k).name, theirs.cam_bodyid[k])
        same_pose(camera.pose, theirs.cam_pos[k], theirs.cam_quat[k], f"camera {k}")
        same(np.degrees(camera.fovy), theirs.cam_fovy[k], f"camera {k}: fovy", 1e-6)
    assert len(ours.keyframes) <= theirs.nkey
    for k, key in enumerate(ours.keyframes):
        same(key.coordinates, theirs.key_qpos[k], f"key {k}: qpos")
        same(key.rates, theirs.key_qvel[k], f"key {k}: qvel")
        same(key.controls, theirs.key_ctrl[k], f"key {k}: ctrl")
    assert len(ours.equalities) == theirs.neq
    assert len(ours.sensors) == theirs.nsensor
    assert len(ours.excludes) == theirs.nexclude
    assert len(ours.pairs) == theirs.npair
    same(ours.simulation.timestep, theirs.opt.timestep, "timestep")
    same(ours.simulation.gravity, theirs.opt.gravity, "gravity")
    same(ours.simulation.density, theirs.opt.density, "density")
