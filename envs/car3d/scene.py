"""GCar3D's world: numbers and indices, of which build.py makes the scene. Everything in SI units."""

from __future__ import annotations

import math

# Ground: a heightfield of square cells, whose heights each episode sets anew
CELL = 1.0  # m
FIRST_X, LAST_X = -10.0, 144.0  # m
HALF_DEPTH = 24.0  # m
COLUMNS = round((LAST_X - FIRST_X) / CELL) + 1
ROWS = round(2.0 * HALF_DEPTH / CELL) + 1

# Road: nodes of its centre line are equally spaced along it; lengths along it are horizontal
STEP = 0.5  # m, between the nodes of the centre line
NODES = round((LAST_X - FIRST_X) / STEP) + 1
CHICANES = 3  # pairs of opposite bends
FIRST_CHICANE = 22.0  # m along the centre line, of its middle
CHICANE_SPACING = 36.0  # m
FINISH = 122.0  # m
ROAD_HALF = 2.2  # m, of the drawn road
SHOULDER = 3.2  # m from the centre line, up to where the ground is level across
VERGE = 5.0  # m beyond that, over which it turns into hills
OFF_ROAD = ROAD_HALF  # m from the centre line, beyond which it costs: the middle of the car is beside the road
STRAY = 6.0  # m from the centre line, where the ride ends
STRAY_BEHIND = 5.0  # m behind the start, where it ends, too
FIRST_STRIP = -4.0  # m, where the drawn road begins
STRIP = 1.25  # m, length of a mark of the kerbs
EDGE = 0.16  # m, width of the lines along the road
DASH_SPACING = 4  # marks
KERB_BEND = 0.08  # 1/m, curvature from which on there are kerbs
KERB = 0.4  # m, their width

# Car
CHASSIS_MASS = 160.0  # kg
WHEEL_MASS = 10.0  # kg, of each
WHEEL_INERTIA = 0.7  # kg m^2, about all axes
RADIUS = 0.36  # m, of the wheels
WHEEL_HALF = 0.13  # m, half their width
AXLES = 0.8  # m, of the axles before and behind the middle
TRACK = 0.62  # m, of the wheels from the middle
CHASSIS_Z = 0.48  # m, of its centre of mass on level ground
SUSPENSION = 2.2  # Hz
STIFFNESS = 0.25 * CHASSIS_MASS * (2.0 * math.pi * SUSPENSION) ** 2  # N/m, of each wheel's spring
DAMPING = 2.0 * 0.5 * 0.25 * CHASSIS_MASS * 2.0 * math.pi * SUSPENSION  # N s/m
REST = -9.81 / (2.0 * math.pi * SUSPENSION) ** 2  # m
TRAVEL = 0.14  # m, up and down
TORQUE = 110.0  # N m, of the motor of each wheel at a full action
BRAKE_TORQUE = 200.0  # N m
TOP_SPEED = 36.0  # rad/s: 13 m/s
STEERING = 0.5  # rad
STEERING_RATE = 2.0  # rad/s
FRICTION = 0.7
GRAVITY = 9.81

# Obstacles: three drawn from two of each kind, on the straights behind the chicanes
SLOTS = 3
FIRST_SLOT = 40.0  # m along the centre line
SLOT_SPACING = CHICANE_SPACING  # m
RAMPS = 2
RAMP_BASE, RAMP_TOP = 2.6, 0.9  # m, half lengths
RAMP_HEIGHT = 0.6  # m
RAMP_HALF = 1.25  # m, half width
BUMPS = 2  # groups
BUMP_SPACING = 1.3  # m
GROUP_BUMPS = 3
BUMP_RADIUS = 0.3  # m
BUMP_HEIGHT = 0.13  # m, over the road
BALL_GROUPS = 2
GROUP_BALLS = 3
BALL_RADIUS = 0.45  # m: too high to get below the chassis
BALL_MASS = 5.0  # kg

# Gates, one at each obstacle
GATE_AHEAD = (0.3, 1.3, 0.0)  # m from the middle of ramps, bumps and balls to the gate
GATE_HALF = 0.4  # m, before and behind the arch, where a wheel of each axle must touch something
GATE_WIDTH = 2.0  # m from the centre line, within which the car must pass
GATE_HEIGHT = 2.7  # m
FINISH_HEIGHT = 3.4  # m
FINISH_REACH = 2.9  # m, of its posts
CHECK = 0.28  # m, half, of the banner's fields

FINISH_BODY = 1  # posts, dark and light fields; the ground is body 0
FIRST_ARCH = FINISH_BODY + 3
FIRST_RED = FIRST_ARCH + SLOTS
FIRST_GREEN = FIRST_RED + SLOTS
FIRST_RAMP = FIRST_GREEN + SLOTS
FIRST_BUMPS = FIRST_RAMP + RAMPS
CHASSIS_BODY = FIRST_BUMPS + BUMPS
FIRST_WHEEL = CHASSIS_BODY + 1  # rear left, rear right, front left, front right
CABIN_BODY = FIRST_WHEEL + 4
FIRST_BALL = CABIN_BODY + 1
AXLE_JOINTS = (0, 2, 4, 7)  # of the suspensions; the spins and steerings lie between
FIRST_STEERING = 4  # of the controls

NOTHING = 0  # mask
DECOR = 8  # category
PARKED_Z = -30.0  # m, of what an episode does without; disabled
