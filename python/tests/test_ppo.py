"""The example: what it calls a gradient is one, and it runs."""

import importlib.util

import numpy as np
import pytest
from conftest import ROOT, WORM

spec = importlib.util.spec_from_file_location("ppo", ROOT / "python/examples/ppo.py")
ppo = importlib.util.module_from_spec(spec)
spec.loader.exec_module(ppo)


@pytest.mark.parametrize("bits", [False, True])
def test_gradients_are_the_slopes_of_the_loss(bits):
    random = np.random.default_rng(1)
    agent = ppo.Agent(random, 5, 3, bits)
    agent.log_std[:] = [-0.5, 0.1, 0.3]
    observations = random.uniform(-1, 1, (40, 5))
    actions, log = agent.draw(observations)
    # Ratios on both sides of the range that is left free, and within.
    batch = (observations, actions, log + random.uniform(-0.5, 0.5, 40), *random.normal(size=(2, 40)))
    _, gradients = agent.loss(batch, clip=0.2)
    for parameter, gradient in zip(agent.parameters, gradients, strict=True):
        assert gradient.shape == parameter.shape
        direction, step = random.normal(size=parameter.shape), 1e-6
        before = parameter.copy()
        losses = []
        for sign in (1, -1):
            parameter[:] = before + sign * step * direction
            losses.append(agent.loss(batch, clip=0.2)[0])
        parameter[:] = before
        # A central difference in double precision: 1e-16 / 1e-6, with some digits to spare.
        assert (losses[0] - losses[1]) / (2 * step) == pytest.approx(np.sum(gradient * direction), abs=1e-8)


@pytest.mark.parametrize("more", [[], ["--bits"]])
def test_it_runs(tmp_path, capsys, more):
    experiment = tmp_path / "worm.toml"
    experiment.write_text(f'model = "{WORM}"\n[sweep]\n"reward.mix.xi" = [0.75, 1]\n')
    numbers = ["--worlds", "2", "--horizon", "8", "--control-steps", "32", "--minibatches", "2"]
    ppo.main(ppo.parse_arguments(["--experiment", str(experiment), *numbers, *more]))
    assert "     32 control steps  R " in capsys.readouterr().out
