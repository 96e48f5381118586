"""Gymnasium environments built on the package's own rigid-body constraint solver.

Importing gsenv registers the environments by name and loads neither numba nor torch. Afterwards
`gymnasium.make("GStack-v0")` works; `gymnasium.make("gsenv:GStack-v0")` imports gsenv itself.
"""

from gsenv.envs import register_envs

__version__ = "0.1.0"

register_envs()
