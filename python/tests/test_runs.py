"""Runs: the same numbers as the files have, and the same actions as the program draws."""

import csv
import json
import shutil
import warnings

import numpy as np
import pandas
import pytest
from conftest import SVENJA, itarl

import itarl as lab


def test_frames_are_the_files(run):
    frames = lab.read_run(run)
    assert [(cell.setting, cell.seed) for cell in frames.cells] == [
        ("xi=0.5", 1),
        ("xi=0.5", 2),
        ("xi=1", 1),
        ("xi=1", 2),
    ]
    assert frames.every == 1 and frames.sweep["reward.mix.xi"] == [0.5, 1]
    for cell in frames.cells:
        expected = pandas.read_csv(cell.folder / "metrics.csv")
        found = cell.pandas()
        pandas.testing.assert_frame_equal(found, expected, check_dtype=False, check_exact=True)
        assert found["update"].dtype == np.int64
    whole = frames.pandas()
    assert list(whole.columns[:3]) == ["setting", "seed", "reward.mix.xi"]
    assert len(whole) == 12 and (whole["reward.mix.xi"] == whole["xi"]).all()
    polar = frames.polars()
    assert polar.columns == list(whole.columns)
    for name in polar.columns:
        np.testing.assert_array_equal(polar[name].to_list(), whole[name].to_list())


def test_a_swept_kind_is_a_column(tmp_path):
    """Also the one that is the default, which settings don't name."""
    experiment = tmp_path / "kinds.toml"
    experiment.write_text(
        f"""
        model = "{SVENJA}"
        learning.updates = 1
        learning.steps_per_update = 2
        [sweep]
        "policy.kind" = ["logistic", "crbm", "modular"]
        """
    )
    itarl("train", experiment, "--out", tmp_path / "run")
    whole = lab.read_run(tmp_path / "run").pandas()
    assert list(whole["policy.kind"]) == ["logistic", "crbm", "modular"]
    assert list(whole["setting"]) == ["kind=logistic", "kind=crbm", "kind=modular"]


def tensors_of(path) -> dict[str, np.ndarray]:
    """As docs/run-folders.md reads them."""
    with open(path, "rb") as file:
        header = json.loads(file.read(int.from_bytes(file.read(8), "little")))
        data = file.read()
    header.pop("__metadata__")
    read = {}
    for name, it in header.items():
        begin, end = it["data_offsets"]
        types = {"F64": "<f8", "F32": "<f4", "U8": "u1"}
        read[name] = np.frombuffer(data[begin:end], types[it["dtype"]]).reshape(it["shape"])
    return read


def test_arrays_are_the_files(run):
    cell = lab.read_run(run).cells[1]
    policy = cell.policy()
    assert policy.kind == "crbm"
    expected = tensors_of(cell.folder / "policy.safetensors")
    assert policy.tensors.keys() == expected.keys()
    for name, tensor in expected.items():
        np.testing.assert_array_equal(policy.tensors[name], tensor)
    recording = cell.recording()
    for name, tensor in tensors_of(cell.folder / "replay.safetensors").items():
        np.testing.assert_array_equal(getattr(recording, name), tensor)


def test_a_sampler_draws_what_a_rollout_draws(run, tmp_path):
    cell = lab.read_run(run).cells[2]
    table = tmp_path / "walk.csv"
    itarl("rollout", cell.folder, "--seed", "5", "--steps", "30", "--csv", table)
    with open(table) as file:
        rows = list(csv.DictReader(file))
    env, sampler = cell.env(), cell.policy().sampler(seed=5)
    observation, _ = env.reset(seed=5)
    for row in rows:
        targets = sampler(observation)
        assert sampler.bits.shape == (24,)
        observation, reward, *_ = env.step(targets)
        assert targets.tolist() == [float(row[name]) for name in row if name.startswith("target ")]
        assert reward == float(row["reward"])
    for reading, error in [(observation[1:], lab.Error), (["up"], TypeError), (observation[None], TypeError)]:
        with pytest.raises(error):
            sampler(reading)


def test_published_runs_are_read(run, tmp_path):
    itarl("publish", run, "--out", tmp_path / "small", "--every", "3")
    published = lab.read_run(tmp_path / "small")
    assert published.every == 3 and len(published.pandas()) == 4
    assert published.cells[0].policy().kind == "crbm"


def test_what_cannot_be_read_is_named(run, tmp_path):
    with pytest.raises(lab.Error, match="nowhere"):
        lab.read_run(tmp_path / "nowhere")
    folder = tmp_path / "run"
    shutil.copytree(run, folder)
    (folder / "cells/xi=1/seed=1/metrics.csv").write_text("update\n1\n")
    (folder / "cells/xi=1/seed=2/policy.safetensors").write_bytes(b"other")
    damaged = lab.read_run(folder)
    with pytest.warns(UserWarning, match=r"xi=1, seed 1, is left out: .*metrics\.csv"):
        assert len(damaged.pandas()) == 9
    with pytest.raises(lab.Error, match=r"policy\.safetensors"):
        damaged.cells[3].policy()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(damaged.cells[3].pandas()) == 3
