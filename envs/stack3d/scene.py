"""GStack3D's world: numbers and indices, of which build.py makes the scene. Everything in SI units, z up."""

from __future__ import annotations

MAX_BLOCKS = 6

# Blocks, uniform within these ranges.
HALF_WIDTH = (0.15, 0.25)  # m, along x and along y
HALF_HEIGHT = (0.10, 0.18)  # m
MASS = (2.0, 16.0)  # kg
FRICTION = (0.4, 0.8)
GRASP_OFFSET = 0.40  # of the half-widths: how far off its middle a block is held
GRASP_TURN = 0.60  # rad, at most, either way

# Gripper. Its drive carries the heaviest of these blocks with 1.5 times its weight in hand.
GRIPPER_MASS = 10.0  # kg
GRIPPER_INERTIA = 2.0  # kg m^2: of the drive; a far lighter one could not turn a block
MAX_FORCE = 400.0  # N, per axis
MAX_TORQUE = 80.0  # N m, per axis
SPEED = 1.5  # m/s at a full action
TURN_SPEED = 1.5  # rad/s at a full action
REACH = 1.2  # m, the gantry's half-width along x and y
REACH_Z = (0.15, 3.6)  # m
REACH_ANGLE = 1.6  # rad
PAD_WIDTH, PAD_HEIGHT = 0.09, 0.02  # m, halves
GAP = 0.01  # m, between pad and block: nearer, and both would rub
START = 0.6  # m, half-range of the first position along x and y
START_Z = (1.0, 1.4)  # m

MAST_FOOT = 0.15  # m, above the pad's middle
MAST_HALF_LENGTH = 2.5  # m

GROUND_BODY, MAST_BODY, GRIPPER_BODY, FIRST_BLOCK = 0, 1, 2, 3
DRIVE_JOINT, FIRST_WELD = 0, 1
FIRST_BLOCK_SHAPE = 4  # ground, mast, pad, wrist come before
PARKED_Z = -20.0  # m, of blocks that are yet to come; disabled, so nothing meets them there

NOTHING = 0  # mask of what is only to be seen
