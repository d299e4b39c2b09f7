"""What the tests share: the program `itarl`, models, and a small run."""

import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SVENJA = ROOT / "models/svenja.toml"
WORM = ROOT / "models/worm.toml"


def itarl(*arguments: str | os.PathLike[str]) -> str:
    """Runs the program: that of the variable ITARL, or the one that `make test` has built."""
    program = os.environ.get("ITARL", ROOT / "target/debug/itarl")
    run = subprocess.run([program, *arguments], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return run.stdout


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two cells of Svenja and of another xi each, with all of their control steps recorded."""
    folder = tmp_path_factory.mktemp("run")
    experiment = folder / "small.toml"
    experiment.write_text(
        f"""
        model = "{SVENJA}"
        learning.updates = 3
        learning.steps_per_update = 20
        learning.rate = 1
        record.steps = 60
        [sweep]
        "reward.mix.xi" = [0.5, 1]
        seeds = 2
        """
    )
    itarl("train", experiment, "--out", folder / "run")
    return folder / "run"
