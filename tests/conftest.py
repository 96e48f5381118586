"""Settings for the whole suite."""

import os

from hypothesis import settings

# One thread each for BLAS and torch: the suite runs in several processes side by side.
os.environ.setdefault("OMP_NUM_THREADS", "1")

# No test needs a display: windows of checkers and wrappers are pygame's dummies.
os.environ.setdefault("SDL_VIDEODRIVER", "dummy")

# All scenes of a dimension share one kernel here: each variant takes a minute or more to compile, and all have the
# same bits, which solver/core/test_skipping.py checks.
os.environ.setdefault("GSENV_ONE_KERNEL", "2,3")

# No deadline: the first example may wait for a compilation. In CI always the same examples.
settings.register_profile("gsenv", deadline=None, derandomize="CI" in os.environ)
settings.load_profile("gsenv")
