"""The observed order of convergence: errors against the timestep on scenes with known answers.

Default options, two substeps, timesteps of 1/30 to 1/480 s. Each error is the largest over all steps against
a closed form or, for pendulums, a Runge-Kutta solution of their own equations of motion. The order is the slope
of a least-squares line through log(error) over log(timestep), of errors above rounding. A full run takes a minute,
most of it for compiling.
"""

from .cases import CASES, Case
from .run import add_options, measure, observed_order, report

__all__ = ["CASES", "Case", "add_options", "measure", "observed_order", "report"]
