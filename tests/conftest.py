"""Settings for the whole suite."""

import os

from hypothesis import settings

# One thread each for BLAS and torch: the suite runs in several processes side by side.
os.environ.setdefault("OMP_NUM_THREADS", "1")

# All scenes of space share one kernel here, which takes minutes to compile; a test has the others' bits.
os.environ.setdefault("GSENV_ONE_KERNEL", "3")

# No deadline: the first example may wait for a compilation. In CI always the same examples.
settings.register_profile("gsenv", deadline=None, derandomize="CI" in os.environ)
settings.load_profile("gsenv")
