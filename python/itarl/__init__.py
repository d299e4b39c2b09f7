"""The lab itarl in Python: its runs as frames, its robots as Gymnasium's environments.

    import itarl

    run = itarl.read_run("runs/quick")
    run.pandas()                                  # or run.polars(): all metrics.csv, beneath each other
    run.cells[0].policy().tensors                 # what was learned, as arrays

    env = itarl.Env("models/svenja.toml")         # gymnasium.Env
    envs = itarl.VectorEnv("models/svenja.toml", num_envs=16)

NumPy is all that's needed to read runs; `pandas`, `polars` and `gymnasium` are asked for where they are used.
"""

from typing import TYPE_CHECKING

from ._itarl import VERSION as __version__
from ._itarl import Error
from ._runs import Cell, Policy, Recording, Run, Sampler, read_run

if TYPE_CHECKING:
    from .env import Env, VectorEnv

__all__ = [
    "Cell",
    "Env",
    "Error",
    "Policy",
    "Recording",
    "Run",
    "Sampler",
    "VectorEnv",
    "__version__",
    "read_run",
]


def __getattr__(name: str) -> object:
    # Whoever reads runs needs no Gymnasium.
    if name in ("Env", "VectorEnv"):
        from . import env

        return getattr(env, name)
    raise AttributeError(f"module 'itarl' has no attribute {name!r}")
