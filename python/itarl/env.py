"""Robots as environments of Gymnasium: `Env` has one, `VectorEnv` as many as you like, in lanes.

An action is the targets of all servos, floats within -1 to 1; an observation is the readings that the lab's
own policies see: positions within -1 to 1 over their ranges, then contacts, 0 or 1. A step is a control step
(ten of physics, as it comes), the reward is the experiment's, with xi as at the start of training, and `info`
has its terms. An episode begins where the robot has settled, as training does, and ends after
`max_episode_steps`, if that's given, or where the simulation blows up.

The same actions give the same observations and rewards, to the last bit, in one world or in many, and in
`itarl train`, which adds only the wind of `perturbation` (it flips bits of its policy's actions).
"""

from __future__ import annotations

import contextlib
import json
import operator
import os
import threading
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

try:
    import gymnasium
except ImportError as error:
    raise ImportError("itarl.Env and itarl.VectorEnv need gymnasium: pip install gymnasium") from error
import numpy as np
from gymnasium.error import ClosedEnvironmentError, ResetNeeded
from gymnasium.spaces import Box
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from ._itarl import Worlds

Path = str | os.PathLike[str]
Settings = Mapping[str, Any]

#: The most worlds of a `VectorEnv`.
MOST_WORLDS = 4096


class _Robots:
    """Worlds with what checks the calls: one thread at a time, in an order that makes sense."""

    def __init__(
        self,
        n_worlds: int,
        model: Path | None,
        experiment: Path | None,
        setting: str | None,
        settings: Settings | None,
        max_episode_steps: int | None,
    ) -> None:
        if max_episode_steps is not None:
            max_episode_steps = _whole("max_episode_steps", max_episode_steps, 1, 2**63 - 1)
        self.max_episode_steps = max_episode_steps
        self.worlds = Worlds(model, experiment, setting, _assignments(settings), n_worlds)
        self.n_worlds = n_worlds
        self.is_closed = False
        self.has_begun = False
        self._lock = threading.Lock()
        n_readings, n_contacts = len(self.worlds.sensors), self.worlds.n_contacts
        low = np.repeat([-1.0, 0.0], [n_readings - n_contacts, n_contacts])
        self.observation_space = Box(low, 1.0, dtype=np.float64)
        self.action_space = Box(-1.0, 1.0, (len(self.worlds.actuators),), dtype=np.float64)
        #: Control steps since each world began.
        self.steps = np.zeros(n_worlds, dtype=np.int64)

    @contextlib.contextmanager
    def alone(self) -> Iterator[None]:
        """One thread at a time; the others are told."""
        if not self._lock.acquire(blocking=False):
            raise RuntimeError("the environment is used by another thread just now")
        try:
            if self.is_closed:
                raise ClosedEnvironmentError("the environment was closed")
            yield
        finally:
            self._lock.release()

    def close(self) -> None:
        if not self.is_closed:
            with self.alone():
                self.worlds.close()
                self.is_closed = True

    def begin(self, world: int, seed: int | None, random: np.random.Generator) -> NDArray[np.float64]:
        """The world of a seed; without one, of the next that is drawn."""
        drawn = int(random.integers(2**63)) if seed is None else seed
        self.steps[world] = 0
        return self.worlds.begin(world, drawn)

    def targets(self, action: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float64]:
        """An action that may be done now, `[n_worlds x n_actuators]`."""
        if not self.has_begun:
            raise ResetNeeded("reset() is expected before step()")
        return _targets(action, shape).reshape(self.n_worlds, shape[-1])

    def step(self, targets: NDArray[np.float64], moves: NDArray[np.bool_]) -> tuple[Any, ...]:
        """Observations, what each world did, why it blew up, whether it did, and whether its time is over."""
        readings, did, reasons = self.worlds.step(targets, moves)
        self.steps[moves] += 1
        blew_up = np.array([reason is not None for reason in reasons])
        limit = self.max_episode_steps
        is_over = np.zeros_like(moves) if limit is None else self.steps >= limit
        return readings, did, reasons, blew_up, is_over & moves & ~blew_up


class Env(gymnasium.Env[NDArray[np.float64], NDArray[np.float64]]):
    """A robot in a world of its own.

    `model` is a model file or a robot in URDF, MJCF, SDF or RoSiML, `experiment` an experiment file; with both,
    it's the experiment with that robot. `settings` has keys of the experiment file with other values, as in
    `{"reward.mix.xi": 1.0}`. A file that sweeps says with `setting`, as in `"xi=0.75"`, which is meant.

    `reset(seed=N)` begins the world of `itarl rollout --seed N`: what a task draws, as the points of `reach`, is
    of the seed. Without a seed the next one is drawn from `np_random`.
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(
        self,
        model: Path | None = None,
        experiment: Path | None = None,
        *,
        setting: str | None = None,
        settings: Settings | None = None,
        max_episode_steps: int | None = None,
    ) -> None:
        self._robots = _Robots(1, model, experiment, setting, settings, max_episode_steps)
        self.observation_space = self._robots.observation_space
        self.action_space = self._robots.action_space
        worlds = self._robots.worlds
        self.metadata = {**self.metadata, "render_fps": worlds.frequency_hz}
        #: Names of the observation's values, and of the action's.
        self.sensors: list[str] = worlds.sensors
        self.actuators: list[str] = worlds.actuators
        #: All settings, as the text of an experiment file.
        self.settings: str = worlds.settings

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float64], dict[str, Any]]:
        """The readings of the robot where it has settled."""
        with self._robots.alone():
            seed = None if seed is None else _seed(seed)
            super().reset(seed=seed)
            observation = self._robots.begin(0, seed, self.np_random)
            self._robots.has_begun = True
        return observation, {}

    def step(
        self, action: ArrayLike
    ) -> tuple[NDArray[np.float64], float, bool, bool, dict[str, Any]]:
        """A control step: its readings, its reward, and in `info` the terms of that.

        Where the simulation blows up the episode is terminated with a reward of 0, and `info` says in `blew_up`
        what did, and where.
        """
        robots = self._robots
        with robots.alone():
            targets = robots.targets(action, robots.action_space.shape)
            stepped = robots.step(targets, np.ones(1, dtype=np.bool_))
            readings, did, (reason,), (blew_up,), (is_over,) = stepped
            if blew_up or is_over:
                robots.has_begun = False
        info: dict[str, Any] = dict(zip(Worlds.COLUMNS, did[0].tolist(), strict=True))
        if reason is not None:
            info = {"blew_up": reason}
        return readings[0], float(did[0, 0]), bool(blew_up), bool(is_over), info

    def render(self) -> None:
        """There are no render modes: the program shows what a robot does."""
        raise NotImplementedError("an environment draws nothing: `itarl rollout` and `itarl replay` show robots")

    def close(self) -> None:
        """Gives the world back. Closing twice is no mistake."""
        self._robots.close()


class VectorEnv(gymnasium.vector.VectorEnv[NDArray[np.float64], NDArray[np.float64], NDArray[Any]]):
    """As many robots as you like, in lanes of the processor's vectors: each has the bits of an `Env`.

    A world whose episode has ended begins anew in the next step (`AutoresetMode.NEXT_STEP`): its action is then
    ignored, its reward is 0, and its observation the first of the new episode. `reset(seed=N)` gives the worlds
    the seeds N, N+1, ...; a list gives each its own.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        model: Path | None = None,
        experiment: Path | None = None,
        num_envs: int = 16,
        *,
        setting: str | None = None,
        settings: Settings | None = None,
        max_episode_steps: int | None = None,
    ) -> None:
        self.num_envs = _whole("num_envs", num_envs, 1, MOST_WORLDS)
        robots = _Robots(self.num_envs, model, experiment, setting, settings, max_episode_steps)
        self._robots = robots
        self.single_observation_space = robots.observation_space
        self.single_action_space = robots.action_space
        self.observation_space = batch_space(robots.observation_space, self.num_envs)
        self.action_space = batch_space(robots.action_space, self.num_envs)
        self.metadata = {**self.metadata, "render_fps": robots.worlds.frequency_hz}
        self.sensors: list[str] = robots.worlds.sensors
        self.actuators: list[str] = robots.worlds.actuators
        self.settings: str = robots.worlds.settings
        self._randoms = [seeding.np_random(None)[0] for _ in range(self.num_envs)]
        self._ended = np.zeros(self.num_envs, dtype=np.bool_)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[NDArray[np.float64], dict[str, Any]]:
        """The readings of all robots where they have settled, `[num_envs x n_readings]`."""
        with self._robots.alone():
            seeds = self._seeds(seed)
            for world, its in enumerate(seeds):
                if its is not None:
                    self._randoms[world], _ = seeding.np_random(its)
            rows = [self._robots.begin(i, its, self._randoms[i]) for i, its in enumerate(seeds)]
            self._ended[:] = False
            self._robots.has_begun = True
        return np.stack(rows), {}

    def step(
        self, actions: ArrayLike
    ) -> tuple[
        NDArray[np.float64],
        NDArray[np.float64],
        NDArray[np.bool_],
        NDArray[np.bool_],
        dict[str, Any],
    ]:
        """A control step of all robots, `[num_envs x n_actuators]`; `info` has arrays with masks."""
        robots = self._robots
        with robots.alone():
            targets = robots.targets(actions, self.action_space.shape)
            for world in np.flatnonzero(self._ended):
                robots.begin(int(world), None, self._randoms[world])
            moves = ~self._ended
            readings, did, reasons, blew_up, is_over = robots.step(targets, moves)
            self._ended = blew_up | is_over
        did_well = moves & ~blew_up
        info: dict[str, Any] = {}
        for name, values in zip(Worlds.COLUMNS, did.T, strict=True):
            info[name], info[f"_{name}"] = values.copy(), did_well.copy()
        if blew_up.any():
            info["blew_up"], info["_blew_up"] = np.array(reasons, dtype=object), blew_up.copy()
        return readings, did[:, 0].copy(), blew_up, is_over, info

    def close_extras(self, **_: Any) -> None:
        """Gives the worlds back."""
        self._robots.close()

    def _seeds(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, Sequence | np.ndarray) and not isinstance(seed, str):
            if len(seed) != self.num_envs:
                raise ValueError(f"seed: {self.num_envs} seeds expected, got {len(seed)}")
            return [None if its is None else _seed(its) for its in seed]
        first = _seed(seed)
        return [_seed(first + world) for world in range(self.num_envs)]


def _targets(action: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """An action as the worlds take it."""
    given = np.asarray(action)
    if given.dtype.kind != "f":
        raise TypeError(f"action: floats of shape {shape} expected, got {given.dtype} of shape {given.shape}")
    if given.shape != shape:
        raise ValueError(f"action: shape {shape} expected, got {given.shape}")
    beyond = ~(np.abs(given) <= 1)
    if beyond.any():
        place = tuple(int(i) for i in np.argwhere(beyond)[0])
        value = given[place]
        raise ValueError(
            f"action{list(place)}: within -1 to 1 expected, got {value} (gymnasium.wrappers.ClipAction clips)"
        )
    return np.ascontiguousarray(given, dtype=np.float64)


def _whole(name: str, value: Any, low: int, high: int) -> int:
    """A whole number within a range."""
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{name}: a whole number expected, got {value!r}") from None
    if not low <= number <= high:
        raise ValueError(f"{name}: from {low} to {high} expected, got {number}")
    return number


def _seed(seed: Any) -> int:
    return _whole("seed", seed, 0, 2**64 - 1)


def _assignments(settings: Settings | None, table: str = "") -> list[str]:
    """Settings as `--set` takes them: key=value, with values in TOML."""
    if settings is None:
        return []
    if not isinstance(settings, Mapping):
        raise TypeError(f"settings: a mapping of keys to values expected, got {settings!r}")
    assignments = []
    for key, value in settings.items():
        if not isinstance(key, str):
            raise TypeError(f"settings: keys are texts, got {key!r}")
        if isinstance(value, Mapping):
            assignments += _assignments(value, f"{table}{key}.")
            continue
        try:
            # Texts, numbers, truths and lists are the same in JSON as in TOML.
            text = json.dumps(value, ensure_ascii=False, allow_nan=False)
        except (TypeError, ValueError) as error:
            raise TypeError(f"settings: {table}{key}: {value!r} is nothing that TOML has: {error}") from None
        if "null" in text and value is None:
            raise TypeError(f"settings: {table}{key}: a value expected, got None")
        assignments.append(f"{table}{key}={text}")
    return assignments


if "itarl/Robot-v0" not in gymnasium.registry:
    gymnasium.register(
        "itarl/Robot-v0", entry_point="itarl.env:Env", vector_entry_point="itarl.env:VectorEnv"
    )
