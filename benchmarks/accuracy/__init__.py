"""Run time against error of gsenv and other engines, on scenes with known answers.

In the plane beside Box2D and pymunk, with --dim 3 beside MuJoCo, PyBullet and Rapier; engines that are not installed
are left out. Box2D v3 and Box3D are built from a folder of their sources if it is given, which needs cmake and a
compiler.
A full run takes half an hour. Each point is written as soon as it is measured: after Ctrl-C the same command continues.
Points are measured again where the solver, an engine, the benchmark or the machine has changed.
"""

from .page import report
from .run import add_options, measure

__all__ = ["add_options", "measure", "report"]
