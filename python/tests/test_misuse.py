"""Whatever is done in whatever order, from whatever thread, is done or is an exception of Python."""

import random
import threading
import warnings
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from conftest import ROOT, WORM

from itarl import Env, VectorEnv, read_run
from itarl._itarl import RunFolder, Worlds

CALLS = 10_000
N = 12  # the worm's actuators


def an_object(rng: random.Random):
    """Something that isn't meant, or that is, of any kind."""
    shape = rng.choice([(), (0,), (1,), (N,), (N + 1,), (2, N), (3, N), (N, 2), (2, N, 1), (0, N), (2, 0)])
    dtype = rng.choice([float, float, float, "f4", "f2", int, bool, complex, "U3", "M8[s]", object, ">f8"])
    kinds = [
        lambda: None,
        lambda: rng.choice([-1, 0, 1, 2, 3, 2**63, 2**64, -(2**70), 10**30]),
        lambda: rng.choice([0.5, float("nan"), float("inf"), 1j, True]),
        lambda: rng.choice(["", "up", "\0", "xi=1", b"up", "\ud800", "x" * 100_000]),
        lambda: rng.choice([[], [1.0] * N, [[1.0], [1.0, 2.0]], {}, {"a": 1}, {1: 2}, object(), int, [[]] * 3]),
        lambda: np.zeros(shape).astype(dtype) if dtype != "M8[s]" else np.zeros(shape, "M8[s]"),
        lambda: np.random.default_rng(rng.randrange(9)).uniform(-1, 1, (2, N)),
        lambda: np.random.default_rng(rng.randrange(9)).uniform(-1.1, 1.1, N),
        lambda: np.full((2, N), rng.choice([np.nan, np.inf, -np.inf, 1e300, 1.0])),
        lambda: np.zeros((4, 2 * N))[::2, ::2],
        lambda: np.asfortranarray(np.zeros((2, N))),
        lambda: np.broadcast_to(np.float64(0.25), (2, N)),
        lambda: np.array([True, False, True][: rng.randrange(4)]),
    ]
    return rng.choice(kinds)()


def a_subject(rng: random.Random, folder):
    """A new object, or what comes of trying to make one."""
    thing = lambda: an_object(rng)
    made = rng.randrange(12)
    if made < 3:
        return Env(WORM, max_episode_steps=rng.choice([None, 1, 3]))
    if made < 6:
        return VectorEnv(WORM, num_envs=2, max_episode_steps=rng.choice([None, 1, 3]))
    if made < 8:
        return Worlds(WORM, None, None, [], 2)
    if made == 8:
        return read_run(folder).cells[0].policy().sampler(seed=rng.randrange(9))
    if made == 9:
        return RunFolder(folder)
    if made == 10:
        return Env(rng.choice([WORM, thing()]), thing(), setting=thing(), settings=thing(), max_episode_steps=thing())
    # Few worlds, many, and too many: each is built.
    n = rng.choice([0, 3, -1, 5000, 10**30, 1.5, None])
    return rng.choice([VectorEnv, lambda *a, **k: Worlds(*a, None, [], n)])(WORM, None, n)


def a_call(rng: random.Random, subject) -> None:
    """Something that the object can be asked, with fitting arguments or others."""
    thing = lambda: an_object(rng)
    calls = {
        Env: ["step", "step", "reset", "close", "render", "sample"],
        VectorEnv: ["step", "step", "reset", "close", "render", "sample"],
        Worlds: ["step", "step", "begin", "close"],
        RunFolder: ["cells", "rows", "policy", "sampler", "recording", "failure", "every"],
    }
    name = rng.choice(calls.get(type(subject), ["__call__"]))
    match name:
        case "reset":
            subject.reset(seed=rng.choice([None, 1, thing()]), options=rng.choice([None, {}, thing()]))
        case "sample":
            subject.step(subject.action_space.sample())
        case "step" if isinstance(subject, Worlds):
            moves = rng.choice([np.ones(2, bool), np.array([True, False]), thing()])
            subject.step(rng.choice([np.zeros((2, N)), thing()]), moves)
        case "begin":
            subject.begin(rng.choice([0, 1, thing()]), rng.choice([1, thing()]))
        case "sampler":
            subject.sampler(0, rng.choice([1, thing()]), rng.choice(["rollout", thing()]))
        case "rows" | "policy" | "recording" | "failure":
            getattr(subject, name)(rng.choice([0, 1, thing()]))
        case "cells" | "every" | "render":
            getattr(subject, name)()
        case "close" if rng.random() < 0.7:
            pass
        case "close":
            subject.close()
        case _:
            getattr(subject, name)(thing())


def misuse(seed: int, subjects: list, folder, counts: dict, n_calls: int) -> None:
    """Random calls of objects that other threads have at hand, too."""
    rng = random.Random(seed)
    for _ in range(n_calls):
        try:
            if rng.random() < 0.05 or not subjects:
                subjects.append(a_subject(rng, folder))
                del subjects[:-8]
            else:
                a_call(rng, rng.choice(subjects))
            outcome = "done"
        # A panic would be no Exception, and go through; an abort would end the tests.
        except Exception as error:
            outcome = type(error).__name__
            assert str(error), f"{outcome} without a word"
        with counts["lock"]:
            counts[outcome] = counts.get(outcome, 0) + 1


def test_ten_thousand_calls_are_done_or_refused():
    folder = ROOT / "tests/folders/first"
    counts: dict = {"lock": threading.Lock()}
    # NumPy and Gymnasium warn of much that is tried here.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        misuse(1, [], folder, counts, CALLS // 2)
        shared: list = []
        with ThreadPoolExecutor(5) as pool:
            jobs = [pool.submit(misuse, seed, shared, folder, counts, CALLS // 10) for seed in range(5)]
            for job in jobs:
                job.result()
    del counts["lock"]
    print(counts)
    assert sum(counts.values()) == CALLS
    assert counts["done"] > CALLS / 20
    for error in ("TypeError", "ValueError", "Error", "ClosedEnvironmentError", "ResetNeeded"):
        assert counts[error] > 0, error
