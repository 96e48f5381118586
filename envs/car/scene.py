"""GCar's world: numbers and indices, of which build.py makes the scene. Everything in SI units."""

from __future__ import annotations

import math

# Course: one chain of vertices, whose heights each episode sets anew.
FINISH = 100.0  # m
SPACING = 0.25  # m, between the vertices
FIRST_X = -12.0  # m
LAST_X = 120.0  # m
VERTICES = round((LAST_X - FIRST_X) / SPACING) + 1
WALL_X = -10.0  # m: the chain rises to a wall left of it
WALL_HEIGHT = 8.0  # m

SLOTS = 6  # places for obstacles, each flat ground amid the hills
FIRST_SLOT = 17.0  # m
SLOT_SPACING = 13.5  # m

# Car
CHASSIS_MASS = 100.0  # kg
WHEEL_MASS = 12.0  # kg, of each
WHEEL_INERTIA = 1.8  # kg m^2: nearly all in the tyre, so that the drive turns a flying car
RADIUS = 0.4  # m, of the wheels
WHEELBASE = 1.7  # m
CHASSIS_Y = 0.8  # m, of its centre of mass in the scene
SUSPENSION = 2.0  # Hz
STIFFNESS = 0.5 * CHASSIS_MASS * (2.0 * math.pi * SUSPENSION) ** 2  # N/m, of each wheel's spring
TRAVEL = 0.2  # m, up and down
TORQUE = 350.0  # N m, of each motor at a full action
BRAKE_TORQUE = 400.0  # N m, of each brake at a full action
TOP_SPEED = 50.0  # rad/s, beyond which the motors do not drive: 20 m/s
REVERSE_SPEED = 5.0  # rad/s: 2 m/s
FRICTION = 1.0
GRAVITY = 9.81

# Obstacles
BRIDGES = 2
PLANKS = 6  # of a bridge
PLANK_RADIUS = 0.07  # m
PLANK_MASS = 14.0  # kg/m
BRIDGE_BEND = 0.25  # rad, at each end of a bridge that hangs at rest
GAP_DEPTH = 2.5  # m
SEESAWS = 2
BOARD_THICKNESS = 0.06  # m, half
WEDGE_HALF = 0.3  # m, half width of the wedge of 1 m below a see-saw
BOARD_MASS = 10.0  # kg/m
BOARD_OFFSET = 0.08  # m, of its middle from the hinge, towards the start
BOX_GROUPS = 2
GROUP_BOXES = 3
BOX_DENSITY = 30.0  # kg/m^2

# Gates, one for each bridge and each see-saw: an arch over it with a bar that is red, and green once it is passed
GATES = BRIDGES + SEESAWS
GATE_HALF = 1.0  # m, of the bar and of the stretch below it, on which both wheels must touch the obstacle
GATE_REACH = 3.3  # m, of the arch's posts from its middle
GATE_HEIGHT = 3.5  # m

GROUND_BODY, FLAG_BODY = 0, 1  # pole, dark and light fields: painted before the car
FIRST_ARCH = 4
FIRST_RED = FIRST_ARCH + GATES
FIRST_GREEN = FIRST_RED + GATES
CHASSIS_BODY = FIRST_GREEN + GATES
REAR_BODY, FRONT_BODY, FIRST_PLANK = CHASSIS_BODY + 1, CHASSIS_BODY + 2, CHASSIS_BODY + 3
FIRST_BOARD = FIRST_PLANK + BRIDGES * PLANKS
FIRST_FULCRUM = FIRST_BOARD + SEESAWS
FIRST_BOX = FIRST_FULCRUM + SEESAWS
LAST_OBSTACLE = FIRST_BOX + BOX_GROUPS * GROUP_BOXES
BURST_BODY = LAST_OBSTACLE  # a star where a landing was too hard
CHECKS = (4, 3)  # fields of the finish flag
ARCH_SHAPES = 3  # two posts and a beam
FIRST_OWN_SHAPE = 2 + CHECKS[0] * CHECKS[1] + GATES * (ARCH_SHAPES + 2)  # after ground, pole, flag and gates
FIRST_OBSTACLE_SHAPE = FIRST_OWN_SHAPE + 4  # after hull, cab and wheels
REAR_AXLE, FRONT_AXLE, FIRST_HINGE = 0, 1, 2
HINGES = PLANKS + 1  # of a bridge
FIRST_PIVOT = FIRST_HINGE + BRIDGES * HINGES

GROUND = 2  # categories
PLANK = 4
GATE = 8
NOTHING = 0

PARKED_Y = -40.0  # m, of obstacles that an episode does without; disabled, so nothing meets them
CHECK_SIZE = 0.14  # m, half
POLE_HEIGHT = 3.2  # m
