"""Gymnasium environments on a global constraint solver of their own.

Importing gsenv registers the environments by name and loads neither numba nor torch:
`gymnasium.make("GStack-v0")` works after it, and `gymnasium.make("gsenv:GStack-v0")` imports it.
"""

from gsenv.envs import register_envs

__version__ = "0.1.0"

register_envs()
