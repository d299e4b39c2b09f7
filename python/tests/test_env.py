"""Environments: Gymnasium's API, and the bits of the lab."""

import csv
import threading
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from conftest import ROOT, SVENJA, WORM, itarl
from gymnasium.error import ClosedEnvironmentError, ResetNeeded
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

from itarl import Env, Error, VectorEnv, read_run
from itarl.env import Worlds

REACH = {"reward": {"extrinsic": {"kind": "reach", "radius_m": 0.01}}}


def actions(n_steps: int, *shape: int, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-1, 1, (n_steps, *shape))


@pytest.mark.parametrize(
    ("model", "settings"),
    [(SVENJA, {}), (ROOT / "models/quadruped.toml", REACH), (WORM, {"control": {"settle_steps": 0}})],
)
def test_gymnasium_finds_nothing_wrong(model, settings):
    check_env(Env(model, settings=settings), skip_render_check=True)  # it has none
    made = gymnasium.make("itarl/Robot-v0", model=model, settings=settings, max_episode_steps=5)
    check_env(made.unwrapped)
    made.reset()
    assert [made.step(made.action_space.sample())[3] for _ in range(5)] == [False] * 4 + [True]


def columns(path: Path, start: str) -> np.ndarray:
    """The columns of a rollout's table whose names begin so, [n_steps x n_columns]."""
    with open(path) as file:
        rows = list(csv.DictReader(file))
    return np.array([[float(row[name]) for name in row if name.startswith(start)] for row in rows])


@pytest.mark.parametrize("model", ["svenja", "quadruped", "biped", "worm"])
def test_it_does_what_a_rollout_does(tmp_path, model):
    path, table = ROOT / f"models/{model}.toml", tmp_path / "walk.csv"
    itarl("rollout", path, "--policy", "random", "--seed", "3", "--steps", "40", "--csv", table)
    env = Env(path)
    env.reset(seed=3)
    steps = [env.step(targets) for targets in columns(table, "target ")]
    observations = np.array([observation for observation, *_ in steps])
    n_contacts = columns(table, "contact ").shape[1]
    np.testing.assert_array_equal(observations[:, :-n_contacts or None], columns(table, "sensor "))
    if n_contacts:
        np.testing.assert_array_equal(observations[:, -n_contacts:], columns(table, "contact "))
    np.testing.assert_array_equal([reward for _, reward, *_ in steps], columns(table, "reward")[:, 0])
    for name in Worlds.COLUMNS:
        if name == "clipped_readings":
            continue
        with open(table) as file:
            expected = [float(row[name]) for row in csv.DictReader(file)]
        assert [info[name] for *_, info in steps] == expected, name


def test_it_does_what_training_does(run):
    """What the cells did in training, step by step, from rest on, in an environment of each cell."""
    for cell in read_run(run).cells:
        recording = cell.recording()
        assert recording.first_control_step == 0
        assert recording.actions.shape == (60, 24)
        env, vector = cell.env(), VectorEnv(experiment=run / "experiment.toml", num_envs=3, setting=cell.setting)
        env.reset(seed=cell.seed)
        vector.reset(seed=cell.seed)
        assert env.sensors == recording.sensor_names
        assert env.actuators == recording.actuator_names
        assert list(Worlds.COLUMNS[: len(recording.term_names)]) == recording.term_names
        others = actions(60, 2, 24)
        for step, targets in enumerate(recording.actions):
            observation, _, _, _, info = env.step(targets)
            beside, *_, infos = vector.step(np.stack([targets, *others[step]]))
            np.testing.assert_array_equal(observation.astype(np.float32), recording.sensors[step])
            np.testing.assert_array_equal(beside[0], observation)
            terms = [info[name] for name in recording.term_names]
            np.testing.assert_array_equal(terms, recording.terms[step])
            np.testing.assert_array_equal([infos[name][0] for name in recording.term_names], terms)


@pytest.mark.parametrize("settings", [{}, REACH])
def test_many_worlds_have_the_bits_of_single_ones(settings):
    """Also where they begin anew by themselves, at the same time or at others."""
    n = 5
    model = ROOT / "models/quadruped.toml"
    vector = VectorEnv(model, num_envs=n, settings=settings, max_episode_steps=4)
    singles = [Env(model, settings=settings, max_episode_steps=4) for _ in range(n)]
    assert vector.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    observations, _ = vector.reset(seed=[7, 8, None, 9, 7])
    first = [single.reset(seed=seed)[0] for single, seed in zip(singles, [7, 8, 2, 9, 7], strict=True)]
    np.testing.assert_array_equal(observations, first)
    ended = [False] * n
    for targets in actions(11, n, vector.single_action_space.shape[0]):
        observations, rewards, terminated, truncated, info = vector.step(targets)
        for world, single in enumerate(singles):
            if settings and world == 2:
                continue  # its seed was drawn
            if ended[world]:
                expected = (single.reset()[0], 0.0, False, False, {})
            else:
                expected = single.step(targets[world])
            np.testing.assert_array_equal(observations[world], expected[0])
            assert (rewards[world], terminated[world], truncated[world]) == expected[1:4]
            assert info["_xi"][world] == (not ended[world])
            assert {name: info[name][world] for name in expected[4]} == expected[4]
            ended[world] = expected[3]
    assert vector.observation_space.contains(observations)


def test_the_seed_is_that_of_the_task():
    env = Env(ROOT / "models/quadruped.toml", settings=REACH)
    targets = actions(3, *env.action_space.shape)

    def rewards(seed: int) -> list[float]:
        env.reset(seed=seed)
        return [env.step(it)[4]["extrinsic_raw"] for it in targets]

    assert rewards(1) == rewards(1) != rewards(2)


def test_a_robot_that_blows_up_ends_its_episode_and_no_other():
    torn = {"experiment": ROOT / "tests/experiments/torn.toml", "setting": "model=torn"}
    single, vector = Env(**torn), VectorEnv(**torn, num_envs=2)
    single.reset(seed=1)
    vector.reset(seed=1)
    n = single.action_space.shape[0]
    for targets in actions(100, n):
        _, reward, terminated, _, info = single.step(targets)
        both = np.stack([np.zeros(n), targets])
        observations, rewards, ends, truncated, infos = vector.step(both)
        assert ends.tolist() == [False, terminated] and not truncated.any()
        assert rewards[1] == reward
        if terminated:
            break
    assert "body 'forearm' of joint 'elbow'" in info["blew_up"] and reward == 0
    assert infos["blew_up"].tolist() == [None, info["blew_up"]]
    assert infos["_blew_up"].tolist() == [False, True] and infos["_xi"].tolist() == [True, False]
    assert vector.observation_space.contains(observations)
    with pytest.raises(ResetNeeded):
        single.step(targets)
    observations, *_ = vector.step(both)
    np.testing.assert_array_equal(observations[1], single.reset()[0])


def test_mistakes_say_what_was_expected_and_found(tmp_path):
    env = Env(WORM)
    n = env.action_space.shape[0]
    with pytest.raises(ResetNeeded, match="reset"):
        env.step(np.zeros(n))
    env.reset()
    for action, error, text in [
        (np.zeros(n + 1), ValueError, rf"action: shape \({n},\) expected, got \({n + 1},\)"),
        (np.zeros(n, int), TypeError, rf"action: floats of shape \({n},\) expected, got int64"),
        ("up", TypeError, "action: floats .* got <U2"),
        (None, TypeError, "action: floats .* got object"),
        (np.full(n, np.nan), ValueError, r"action\[0\]: within -1 to 1 expected, got nan"),
        (np.linspace(0, 1.5, n), ValueError, rf"action\[\d\]: within -1 to 1 expected, got 1"),
    ]:
        with pytest.raises(error, match=text):
            env.step(action)
    for seed, error in [(-1, ValueError), (2**64, ValueError), (1.5, TypeError), ("1", TypeError)]:
        with pytest.raises(error, match="seed: "):
            env.reset(seed=seed)
    with pytest.raises(NotImplementedError, match="`itarl rollout` and `itarl replay` show robots"):
        env.render()
    env.close()
    env.close()
    for call in (lambda: env.step(np.zeros(n)), env.reset):
        with pytest.raises(ClosedEnvironmentError, match="closed"):
            call()

    experiment = tmp_path / "two.toml"
    experiment.write_text(f'model = "{WORM}"\n[sweep]\n"reward.mix.xi" = [0.5, 1]\n')
    for arguments, error, text in [
        ({}, Error, "a model's file or an experiment's expected, got neither"),
        ({"model": tmp_path / "none.toml"}, Error, r"none\.toml: can't be read"),
        ({"experiment": experiment}, Error, "setting: one of xi=0.5, xi=1 expected, got none"),
        ({"experiment": experiment, "setting": "xi=2"}, Error, "expected, got xi=2"),
        ({"model": WORM, "settings": {"reward.mix.x": 1}}, Error, "unknown key 'x'"),
        ({"model": WORM, "settings": {"codec": {"sensor_bits": None}}}, TypeError, "codec.sensor_bits: "),
        ({"model": WORM, "settings": [1]}, TypeError, "settings: a mapping"),
        ({"model": WORM, "max_episode_steps": 0}, ValueError, "max_episode_steps: from 1 "),
    ]:
        with pytest.raises(error, match=text):
            Env(**arguments)
    assert Env(WORM, experiment, setting="xi=1").settings.count("xi = 1.0") == 1
    for n_worlds, error in [(0, ValueError), (-1, ValueError), (4097, ValueError), (1.5, TypeError)]:
        with pytest.raises(error, match="num_envs: "):
            VectorEnv(WORM, num_envs=n_worlds)
    with pytest.raises(ValueError, match="seed: 2 seeds expected, got 3"):
        VectorEnv(WORM, num_envs=2).reset(seed=[1, 2, 3])


def test_a_robot_without_sensors_has_no_information(tmp_path):
    """As for `itarl rollout`: there's nothing to measure information of."""
    blind = tmp_path / "blind.toml"
    blind.write_text("sensors = []\n" + WORM.read_text())
    env = Env(blind)
    env.reset(seed=1)
    *_, info = env.step(np.zeros(env.action_space.shape))
    assert (info["xi"], info["intrinsic_nats"]) == (1, 0)
    with pytest.raises(Error, match="sensors"):
        Env(blind, settings={"reward.intrinsic.kind": "mutual_information"})


def test_other_threads_run_meanwhile_and_are_told():
    """Stepping lets go of the interpreter: another thread comes in between, and is refused."""
    vector = VectorEnv(SVENJA, num_envs=16)
    vector.reset(seed=1)
    still, told = np.zeros(vector.action_space.shape), []

    def step():
        while not told:
            try:
                vector.step(still)
            except RuntimeError as error:
                told.append(str(error))

    thread = threading.Thread(target=step)
    thread.start()
    step()
    thread.join()
    assert set(told) == {"the environment is used by another thread just now"}
    vector.step(still)
