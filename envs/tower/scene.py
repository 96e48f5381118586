"""tower_v0's world: two grippers, a plinth between them, blocks. Numbers as in GStack where not given."""

from __future__ import annotations

from gsenv.envs.stack import scene as stack

MAX_BLOCKS = stack.MAX_BLOCKS
AGENTS = ("left", "right")

PLINTH_X = 0.2  # m, half-range of its place
PLINTH_HALF_WIDTH = 0.35  # m
PLINTH_HEIGHT = 0.2  # m: a block beside it lies below every level

# In a gripper's own frame, x grows from its side inwards.
REACH_X = (-2.0, 0.6)  # m
START_X = (-1.8, -1.3)  # m
START_Y = (1.4, 1.9)  # m
DEPOT_X = -1.2  # m, blocks arrive further out than this

RAIL_HALF_WIDTH = 2.8  # m

GROUND_BODY, PLINTH_BODY, RAIL_BODY, FIRST_MAST, FIRST_GRIPPER, FIRST_BLOCK = 0, 1, 2, 3, 5, 7
FIRST_WELD = 2  # the two drives come before; block k belongs to gripper k % 2
FIRST_BLOCK_SHAPE = 11  # ground, plinth, rail, two masts, two grippers of three

PLINTH_COLOR = (112, 118, 130)
GRIPPER_COLORS = ((32, 98, 190), (196, 44, 66))
MAST_COLORS = ((132, 164, 208), (214, 142, 152))
