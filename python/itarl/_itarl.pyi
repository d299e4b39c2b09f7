"""What the package is made of, in Rust. Use `itarl` itself."""

import os
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

VERSION: str

class Error(ValueError):
    """What the lab refused, or couldn't do: a file, a folder, a setting, a value."""

class Worlds:
    COLUMNS: ClassVar[list[str]]
    sensors: list[str]
    n_contacts: int
    actuators: list[str]
    frequency_hz: float
    physics_steps: int
    settings: str
    def __init__(
        self,
        model: str | os.PathLike[str] | None,
        experiment: str | os.PathLike[str] | None,
        setting: str | None,
        changes: list[str],
        n_worlds: int,
    ) -> None: ...
    def begin(self, world: int, seed: int) -> NDArray[np.float64]: ...
    def step(
        self, targets: NDArray[np.float64], moves: NDArray[np.bool_]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], list[str | None]]: ...
    def close(self) -> None: ...

class Sampler:
    def draw(self, reading: NDArray[np.float64]) -> tuple[NDArray[np.bool_], NDArray[np.float64]]: ...

class RunFolder:
    def __init__(self, folder: str | os.PathLike[str]) -> None: ...
    def experiment(self) -> str: ...
    def every(self) -> int: ...
    def cells(self) -> list[tuple[str, int, Path, str]]: ...
    def failure(self, index: int) -> str | None: ...
    def rows(self, index: int) -> dict[str, NDArray[np.float64]]: ...
    def policy(self, index: int) -> tuple[str, dict[str, NDArray[Any]]]: ...
    def sampler(self, index: int, seed: int, stream: str) -> Sampler: ...
    def recording(self, index: int) -> dict[str, Any] | None: ...
