"""GStack's world: numbers, indices and the scene. Everything in SI units."""

from __future__ import annotations

from gsenv.solver import Handle, Scene
from gsenv.solver.planar import Box, Circle, HalfPlane, Target, Weld

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
START_Y = (1.8, 2.2)  # m

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
MAGNET_COLOR = (214, 62, 62)
MAST_COLOR = (150, 160, 174)


def build_scene() -> Scene:
    """Return the scene: ground, gantry, gripper, and all blocks, which are parked and disabled."""
    scene = Scene()
    scene.add_body("ground", "static", [HalfPlane(friction=0.8)])
    rail = Box(half_extents=(2.6, 0.05), mask=NOTHING)
    scene.add_body("rail", "static", [rail], position=(0.0, RAIL_Y))
    add_mast(scene, "mast", 0.0, MAST_COLOR)
    gripper = add_gripper(scene, "gripper", 0.0, STEEL)
    blocks = [add_block(scene, k) for k in range(MAX_BLOCKS)]
    drive = add_drive(scene, "drive", gripper)
    for k, block in enumerate(blocks):
        scene.add_joint(f"grip_{k}", Weld(gripper, block, collide=True, enabled=False))
    add_actuators(scene, drive, "")
    return scene


def add_mast(scene: Scene, name: str, x: float, color: Color) -> None:
    mast = Box(half_extents=(0.035, MAST_HALF_LENGTH), mask=NOTHING)
    scene.add_body(name, "kinematic", [mast], position=(x, START_Y[0]), color=color)


def add_gripper(scene: Scene, name: str, x: float, color: Color) -> Handle:
    return scene.add_body(
        name,
        shapes=[
            Circle(radius=MAGNET_RADIUS, friction=0.3, name="magnet"),
            Box(half_extents=(0.10, 0.045), position=(0.0, 0.11), density=0.0, name="wrist"),
            Box(half_extents=(0.055, 0.03), position=(0.0, 0.185), density=0.0, name="collar"),
        ],
        position=(x, START_Y[0]),
        mass=GRIPPER_MASS,
        inertia=GRIPPER_INERTIA,
        gravity_scale=0.0,
        color=color,
    )


def add_block(scene: Scene, k: int) -> Handle:
    """Add block k, parked and disabled."""
    return scene.add_body(
        f"block_{k}",
        shapes=[Box(half_extents=(HALF_WIDTH[1], HALF_HEIGHT[1]))],
        position=(2.0 * k, PARKED_Y),
        enabled=False,
        color=COLORS[k],
    )


def add_drive(scene: Scene, name: str, gripper: Handle) -> Handle:
    return scene.add_joint(
        name, Target(gripper, frequency=6.0, damping_ratio=1.5, max_force=MAX_FORCE, max_torque=MAX_TORQUE)
    )


def add_actuators(scene: Scene, drive: Handle, suffix: str) -> None:
    """Add the actuators that `blocks.steer` sets, in its order."""
    scene.add_actuator(f"move_x{suffix}", drive, "x", "velocity", -SPEED, SPEED)
    scene.add_actuator(f"move_y{suffix}", drive, "y", "velocity", -SPEED, SPEED)
    scene.add_actuator(f"turn{suffix}", drive, "angle", "velocity", -TURN_SPEED, TURN_SPEED)
