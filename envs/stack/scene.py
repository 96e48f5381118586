"""GStack's world: numbers and indices, of which build.py makes the scene. Everything in SI units."""

from __future__ import annotations

Color = tuple[int, int, int]

MAX_BLOCKS = 8

# Blocks, uniform within these ranges.
HALF_WIDTH = (0.15, 0.30)  # m
HALF_HEIGHT = (0.12, 0.20)  # m
MASS = (2.0, 16.0)  # kg
FRICTION = (0.4, 0.8)
GRASP_OFFSET = 0.50  # of the half-width: how far off its middle a block is held
GRASP_TILT = 0.40  # rad, at most, either way

# Gripper. Its drive carries the heaviest of these blocks with 1.5 times its weight in hand.
GRIPPER_MASS = 10.0  # kg
GRIPPER_INERTIA = 2.0  # kg m^2: of the drive; a far lighter one could not turn a block
MAX_FORCE = 400.0  # N, per axis
MAX_TORQUE = 80.0  # N m
SPEED = 1.5  # m/s at a full action
TURN_SPEED = 1.5  # rad/s at a full action
REACH_X = 1.8  # m, the gantry's half-width
REACH_Y = (0.15, 4.4)  # m
REACH_ANGLE = 0.6  # rad
MAGNET_RADIUS = 0.08  # m
GAP = 0.01  # m, between magnet and block: nearer, and both would rub
START_X = 1.2  # m, half-range of the first position
START_Y = (1.0, 1.4)  # m

RAIL_Y = 5.0  # m
MAST_HALF_LENGTH = 2.6  # m

GROUND_BODY, RAIL_BODY, MAST_BODY, GRIPPER_BODY, FIRST_BLOCK = 0, 1, 2, 3, 4
DRIVE_JOINT, FIRST_WELD = 0, 1
FIRST_BLOCK_SHAPE = 6  # ground, rail, mast, magnet, wrist, collar come before
PARKED_Y = -20.0  # m, of blocks that are yet to come; disabled, so nothing meets them there

NOTHING = 0  # mask of what is only to be seen

COLORS = (
    (238, 90, 46),
    (252, 172, 20),
    (70, 174, 144),
    (104, 158, 196),
    (126, 46, 143),
    (168, 203, 134),
    (44, 54, 98),
    (248, 180, 148),
)
STEEL = (74, 84, 102)
MAST_COLOR = (150, 160, 174)
