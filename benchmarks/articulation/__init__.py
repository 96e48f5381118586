"""Bodies on joints: rows of joints, joint coordinates, and MuJoCo's integrators on the same files.

Gymnasium's robots in four states, an env step of 15 ms, chains and a double pendulum by error against time, a heap of
ragdolls, the ragdoll and the car of GCar-v0. One core. Gymnasium's files come from its installation.
"""

from .run import add_options, measure, report

__all__ = ["add_options", "measure", "report"]
