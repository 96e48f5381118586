"""GRagdoll2D's world: numbers and indices, of which build.py makes the scene. Everything in SI units.

Lengths and masses are those of a person of 1.7 m and 60 kg by the mean proportions of D. A. Winter, "Biomechanics and
Motor Control of Human Movement" (2009), table 4.1. Each body's own frame is at its joint towards the pelvis, that of
the pelvis at the hips; all angles are 0 in a figure that stands upright and looks to the right.
"""

from __future__ import annotations

import math
from typing import NamedTuple

HEIGHT = 1.7  # m, upright
FRICTION = 0.9
GRAVITY = 9.81

# Lengths, m
ANKLE = 0.066  # from the sole
SHIN = 0.418
THIGH = 0.4165
WAIST = 0.13  # from the hips
SHOULDER = 0.36  # from the waist
HEAD = 0.309  # from the shoulder to the crown
HEEL = -0.068  # of the sole, from the ankle
TOE = 0.19
CROWN = SHOULDER + HEAD  # from the waist

# Masses, kg
FOOT_MASS, SHIN_MASS, THIGH_MASS = 0.87, 2.79, 6.0
PELVIS_MASS = 8.52
CHEST_MASS, HEAD_MASS = 21.3, 4.86
ARM_MASS = 3.0
MASS = 2.0 * (FOOT_MASS + SHIN_MASS + THIGH_MASS + ARM_MASS) + PELVIS_MASS + CHEST_MASS + HEAD_MASS

# Bodies, in the order in which they are painted
GROUND_BODY, ARROW_BODY, FAR_ARM, FAR_FOOT, FAR_SHIN, FAR_THIGH, PELVIS, TORSO = range(8)
NEAR_FOOT, NEAR_SHIN, NEAR_THIGH, NEAR_ARM = range(8, 12)
BODIES = (
    "ground", "arrow", "far_arm", "far_foot", "far_shin", "far_thigh", "pelvis", "torso",
    "near_foot", "near_shin", "near_thigh", "near_arm",
)  # fmt: skip
FIRST_PART = FAR_ARM  # the figure's bodies are those from here on
FEET = (NEAR_FOOT, FAR_FOOT)


class Axis(NamedTuple):
    """A joint of the figure; angles in rad, positive counterclockwise, of the child relative to its parent."""

    name: str
    parent: int
    child: int
    anchor: tuple[float, float]  # m, in the parent's frame
    limits: tuple[float, float]
    stand: float  # angle of the stand with bent knees
    stiffness: float  # N m/rad
    effort: float  # N m, the largest torque of its drive


def _leg(side: str, thigh: int, shin: int, foot: int) -> tuple[Axis, ...]:
    return (
        Axis(f"{side}_hip", PELVIS, thigh, (0.0, 0.0), (-0.6, 2.0), 0.3, 300.0, 150.0),
        Axis(f"{side}_knee", thigh, shin, (0.0, -THIGH), (-2.4, 0.0), -0.6, 300.0, 150.0),
        Axis(f"{side}_ankle", shin, foot, (0.0, -SHIN), (-0.8, 0.7), 0.28, 150.0, 80.0),
    )


AXES = (
    Axis("waist", PELVIS, TORSO, (0.0, WAIST), (-0.9, 0.5), -0.1, 300.0, 150.0),
    *_leg("near", NEAR_THIGH, NEAR_SHIN, NEAR_FOOT),
    *_leg("far", FAR_THIGH, FAR_SHIN, FAR_FOOT),
)
SHOULDERS = tuple(
    Axis(f"{side}_shoulder", TORSO, arm, (0.0, SHOULDER), (-1.2, 2.8), 0.1, 8.0, 60.0)
    for side, arm in (("near", NEAR_ARM), ("far", FAR_ARM))
)
JOINTS = (*AXES, *SHOULDERS)
DAMPING = 0.1  # s, of every joint: damping over stiffness
REACH = 0.6  # of half a joint's range: what a full action adds to the angle of the stand

GROUND, FIGURE = 2, 4  # categories
NOTHING = 0
PARKED = (0.0, -40.0)  # m, of the arrow while no push is shown
ARROW_LENGTH = 0.5  # m, of the arrow of a push of 1 m/s
ARROW_HEAD = 0.11  # m
ARROW_GAP = 0.16  # m, from the middle of the pelvis to its tip


def hips_height() -> float:
    """Return the height in m of the hips above the soles in the stand."""
    hip, knee = (axis.stand for axis in AXES[1:3])
    tilt = _stand_tilt()
    return ANKLE + THIGH * math.cos(tilt + hip) + SHIN * math.cos(tilt + hip + knee)


def stand_height() -> float:
    """Return the height in m of the crown above the soles in the stand."""
    tilt = _stand_tilt()
    return hips_height() + WAIST * math.cos(tilt) + CROWN * math.cos(tilt + AXES[0].stand)


def _stand_tilt() -> float:
    """Return the tilt in rad of the pelvis over level soles in the stand."""
    return -sum(axis.stand for axis in AXES[1:4])
