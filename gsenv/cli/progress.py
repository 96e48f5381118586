"""Progress bars on stderr."""

from gsenv.train.progress import counting, make_progress

__all__ = ["counting", "make_progress"]
