"""GRagdoll's figure as numbers that kernels may know; figure.py has what its file says. Everything in SI units.

The lengths are those of GRagdoll2D's figure.
"""

from __future__ import annotations

import numpy as np

from gsenv.envs.ragdoll2d import scene as lengths

AXIS_COUNT = 21  # driven joints
STAND_TILT = 0.02  # rad, of the pelvis in the stand, where the soles are level
ARROW_LENGTH = 0.5  # m, of the arrow of a push of 1 m/s
ARROW_GAP = 0.24  # m, from the middle of the pelvis to its tip
ARROW_BARB = 0.085  # m, half the length of the two barbs of its head
ARROW_RADIUS = 0.016  # m
PARKED = (0.0, 0.0, -40.0)  # m, of the arrow while no push is shown

CROWN = lengths.CROWN  # m, above the waist
STAND_HEIGHT = lengths.stand_height()  # m, of the crown in the stand
HIPS_HEIGHT = lengths.hips_height()  # m
ANKLE, HEEL, TOE = lengths.ANKLE, lengths.HEEL, lengths.TOE  # of the sole, from the ankle
HALF_SOLE = 0.047  # m, half its width
HAND = (0.004, 0.0, -0.3)  # m, the middle of a hand in the frame of the forearm

PELVIS, TORSO = "pelvis", "torso"
FEET = ("left_foot", "right_foot")
HANDS = ("left_forearm", "right_forearm")
LEGS = tuple(f"{side}_{part}" for side in ("left", "right") for part in ("thigh", "shin", "foot"))

LINK_DTYPE = np.dtype(
    [
        ("body", "i4"),
        ("parent", "i4"),
        ("joint", "i4"),
        ("first", "i4"),  # of its axes
        ("count", "i4"),
    ],
    align=True,
)
AXIS_DTYPE = np.dtype(
    [
        ("turn", "i4"),  # number of the coordinate (gsenv/solver/spatial/joints/axes.py)
        ("sign", "f8"),  # of the coordinate over the angle of the file
    ],
    align=True,
)
PARTS_DTYPE = np.dtype(
    [
        ("pelvis", "i4"),
        ("torso", "i4"),
        ("arrow", "i4"),
        ("shaft", "i4"),  # shape
        ("feet", "i4", (2,)),
        ("hands", "i4", (2,)),
        ("first", "i4"),  # the figure's bodies are those from first to last
        ("last", "i4"),
    ],
    align=True,
)
