"""Runs of the lab: metrics as frames, policies as arrays with what draws their actions, recordings."""

from __future__ import annotations

import os
import tomllib
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _itarl
from ._itarl import Error, RunFolder

if TYPE_CHECKING:
    import pandas
    import polars

    from .env import Env

Columns = dict[str, NDArray[Any]]


def read_run(folder: str | os.PathLike[str]) -> Run:
    """Opens a run's folder, or a published one, finished or not.

    Raises `itarl.Error` if it isn't one, or is damaged.
    """
    return Run(RunFolder(folder), Path(folder))


class Run:
    """What `itarl train` has left in a folder, or is still at."""

    def __init__(self, run: RunFolder, folder: Path) -> None:
        self._run = run
        self.folder = folder
        #: The experiment file, without what it sweeps, and what that is: keys with their values.
        self.experiment: dict[str, Any] = tomllib.loads(run.experiment())
        self.sweep: dict[str, Any] = self.experiment.pop("sweep", {})
        #: Updates that a row is the mean of: 1, but in a published run.
        self.every: int = run.every()
        #: All cells, in the run's order.
        self.cells = [Cell(run, index, *its) for index, its in enumerate(run.cells())]

    def __repr__(self) -> str:
        return f"Run({str(self.folder)!r}, {len(self.cells)} cells)"

    def columns(self) -> Columns:
        """The rows of all cells beneath each other: `setting`, `seed`, a column for each swept key that has one
        value in a cell, and those of metrics.csv. A cell that can't be read is left out, with a warning.
        """
        swept = {key: self._swept(key) for key in self.sweep if key != "seeds"}
        parts: list[Columns] = []
        for index, cell in enumerate(self.cells):
            try:
                metrics = cell.columns()
            except Error as error:
                warnings.warn(f"{cell.setting}, seed {cell.seed}, is left out: {error}", stacklevel=2)
                continue
            values = {key: of_cells[index] for key, of_cells in swept.items()}
            labels = {"setting": cell.setting, "seed": cell.seed} | values
            n = len(metrics["update"])
            parts.append({key: np.repeat(np.asarray(value), n) for key, value in labels.items()} | metrics)
        names = [key for key in (parts[0] if parts else {}) if all(part[key].dtype != object for part in parts)]
        return {name: np.concatenate([part[name] for part in parts]) for name in names}

    def _swept(self, key: str) -> list[Any]:
        """Of each cell the value of a swept key. Settings don't name a kind that is the default: that is the one
        which no cell names.
        """
        named = [_look_up(cell.settings, key) for cell in self.cells]
        left = [it for it in self.sweep[key] if it not in named and not isinstance(it, dict | list)]
        return [left[0] if value is None and len(left) == 1 else value for value in named]

    def pandas(self) -> pandas.DataFrame:
        """`columns()` as a frame of pandas."""
        return _pandas(self.columns())

    def polars(self) -> polars.DataFrame:
        """`columns()` as a frame of polars."""
        return _polars(self.columns())


class Cell:
    """One training instance of a run."""

    def __init__(
        self, run: RunFolder, index: int, setting: str, seed: int, folder: Path, settings: str
    ) -> None:
        self._run, self._index = run, index
        #: What sets it apart, as in `xi=0.75`, and its seed.
        self.setting, self.seed = setting, seed
        self.folder = Path(folder)
        #: All its settings, as an experiment file has them.
        self.settings: dict[str, Any] = tomllib.loads(settings)

    def __repr__(self) -> str:
        return f"Cell({self.setting!r}, seed={self.seed})"

    @property
    def failure(self) -> str | None:
        """Why it ended before its end, if it did."""
        return self._run.failure(self._index)

    def columns(self) -> Columns:
        """The columns of its metrics.csv, as far as it has come: docs/run-folders.md has their meaning."""
        columns: Columns = self._run.rows(self._index)
        for whole in ("update", "control_steps"):
            columns[whole] = columns[whole].astype(np.int64)
        return columns

    def pandas(self) -> pandas.DataFrame:
        """`columns()` as a frame of pandas."""
        return _pandas(self.columns())

    def polars(self) -> polars.DataFrame:
        """`columns()` as a frame of polars."""
        return _polars(self.columns())

    def policy(self) -> Policy:
        """What it has learned, as of its last checkpoint. Raises `itarl.Error` if there's none yet."""
        kind, tensors = self._run.policy(self._index)
        return Policy(kind, tensors, self._run, self._index)

    def recording(self) -> Recording | None:
        """Its last control steps, as of its last checkpoint, in the first of its worlds; None if it keeps none."""
        arrays = self._run.recording(self._index)
        return None if arrays is None else Recording(**arrays)

    def env(self, **more: Any) -> Env:
        """The environment that it learns in; `more` is what `itarl.Env` takes besides."""
        from .env import Env

        experiment = self.folder.parents[2] / "experiment.toml"
        return Env(experiment=experiment, setting=self.setting, **more)


@dataclass(frozen=True)
class Policy:
    """What a cell has learned."""

    #: `policy.kind`, and its tensors by name, as docs/run-folders.md lists them.
    kind: str
    tensors: dict[str, NDArray[Any]]
    _run: RunFolder
    _index: int

    def sampler(self, seed: int = 1, stream: str = "rollout") -> Sampler:
        """The policy with random numbers of its own, from the start of a stream: those of `itarl rollout --seed`.
        With the stream `"policy"` and the cell's seed they are those that it learned with.
        """
        return Sampler(self._run.sampler(self._index, seed, stream))


class Sampler:
    """A policy that draws the actions that the lab would draw, to the bit.

    Call it with each reading of an episode, in their order: it remembers as many as its policy sees.
    """

    def __init__(self, sampler: _itarl.Sampler) -> None:
        self._sampler = sampler
        #: The last action as the policy has drawn it, `[n_actuators x bits]`; None before the first.
        self.bits: NDArray[np.bool_] | None = None

    def __call__(self, reading: ArrayLike) -> NDArray[np.float64]:
        """Targets for the servos, `[n_actuators]`, given the next reading, `[n_readings]`."""
        given = np.asarray(reading)
        if given.dtype.kind != "f" or given.ndim != 1:
            raise TypeError(f"reading: floats of one dimension expected, got {given.dtype} of shape {given.shape}")
        self.bits, targets = self._sampler.draw(given.astype(np.float64))
        return targets


@dataclass(frozen=True)
class Recording:
    """The last T control steps of a cell, with F frames each of B bodies; docs/run-folders.md has the units."""

    first_control_step: int
    seconds_per_frame: float
    bodies: list[str]
    sensor_names: list[str]
    actuator_names: list[str]
    term_names: list[str]
    #: `[T x F x B x 7]`
    poses: NDArray[np.float32]
    #: `[T x n_sensors]`, `[T x n_actuators]`, `[T x B]`, `[T x n_terms]`
    sensors: NDArray[np.float32]
    actions: NDArray[np.float32]
    contacts: NDArray[np.uint8]
    terms: NDArray[np.float64]


def _look_up(settings: dict[str, Any], key: str) -> Any:
    """The value at a key with dots; None where there's none, or a table or a list."""
    value: Any = settings
    for name in key.split("."):
        value = value.get(name) if isinstance(value, dict) else None
    return None if isinstance(value, dict | list) else value


def _pandas(columns: Columns) -> pandas.DataFrame:
    try:
        import pandas
    except ImportError as error:
        raise ImportError("pandas() needs pandas: pip install pandas") from error
    return pandas.DataFrame(columns)


def _polars(columns: Columns) -> polars.DataFrame:
    try:
        import polars
    except ImportError as error:
        raise ImportError("polars() needs polars: pip install polars") from error
    return polars.DataFrame(columns)
