"""How the time of a step grows with the number of bodies, and what sleeping bodies cost.

Awake: scenes of 10 to 5,000 boxes at a fixed number of sweeps (tolerance 0, sleeping off), from the same settled
and slightly disturbed state for each solver. Asleep: the same scenes at default options, all awake, all asleep, and
asleep beside a tower of ten that a moving plate keeps awake. CPU time of step calls, kernels compiled before, median.
"""

from .report import report
from .run import add_options, measure

__all__ = ["add_options", "measure", "report"]
