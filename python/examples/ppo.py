"""PPO on Svenja, beside the lab's own learner: one file of NumPy, in the manner of CleanRL, gradients by hand.

    pip install './python[gymnasium]'
    python python/examples/ppo.py                     # what experiments/quick.toml trains, xi = 0.75
    python python/examples/ppo.py --setting xi=1 --seed 2
    python python/examples/ppo.py --bits              # with the actions of the lab's policies

Same robot, same reward, same number of control steps (128,000) as a cell of `itarl train
experiments/quick.toml`, in one life: no episode ends. Not the same are the policy, a network that sees positions
and not only their signs, and by default the targets, any within -1 to 1 and not only -0.5 or 0.5.

Schulman et al., Proximal policy optimization algorithms, 2017; the details are those of CleanRL's
`ppo_continuous_action.py`, but rewards alone are scaled, and neither values nor observations.
"""

import argparse
import os
import time
from pathlib import Path

# Matrices of 64 columns are slower on several threads than on one. NumPy asks when it's imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import itarl

EXPERIMENT = Path(__file__).parents[2] / "experiments/quick.toml"


def parse_arguments(given: list[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--experiment", default=EXPERIMENT, help="whose robot and reward")
    parser.add_argument("--setting", default="xi=0.75", help="which of what it sweeps")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--bits", action="store_true", help="targets are -0.5 or 0.5, as one bit means")
    parser.add_argument("--control-steps", type=int, default=128_000, help="in all worlds together")
    parser.add_argument("--worlds", type=int, default=16)
    parser.add_argument("--horizon", type=int, default=128, help="control steps from update to update, in each world")
    parser.add_argument("--epochs", type=int, default=10)
    parser.add_argument("--minibatches", type=int, default=32)
    parser.add_argument("--rate", type=float, default=3e-4)
    parser.add_argument("--discount", type=float, default=0.99)
    parser.add_argument("--trace", type=float, default=0.95, help="lambda of the advantages")
    parser.add_argument("--clip", type=float, default=0.2)
    return parser.parse_args(given)


class Network:
    """Two layers of 64 tanh units and a linear one; `parameters` are weights and biases in turn."""

    def __init__(self, random: np.random.Generator, n_inputs: int, n_outputs: int, gain: float) -> None:
        self.parameters = []
        for rows, columns, its in [(n_inputs, 64, 2**0.5), (64, 64, 2**0.5), (64, n_outputs, gain)]:
            left, _, right = np.linalg.svd(random.normal(size=(rows, columns)), full_matrices=False)
            self.parameters += [its * left @ right, np.zeros(columns)]

    def __call__(self, inputs: np.ndarray) -> np.ndarray:
        """`[n x n_inputs]` to `[n x n_outputs]`; remembers what `gradient` needs."""
        w1, b1, w2, b2, w3, b3 = self.parameters
        first = np.tanh(inputs @ w1 + b1)
        second = np.tanh(first @ w2 + b2)
        self.layers = inputs, first, second
        return second @ w3 + b3

    def gradient(self, slopes: np.ndarray) -> list[np.ndarray]:
        """By the parameters, of a loss whose slopes by the last outputs are given."""
        gradients = []
        for layer, weights in zip(reversed(self.layers), self.parameters[-2::-2], strict=True):
            gradients = [layer.T @ slopes, slopes.sum(axis=0), *gradients]
            slopes = (slopes @ weights.T) * (1 - layer**2)
        return gradients


class Agent:
    """A critic, and an actor whose outputs are means of normal distributions, or logits of bits."""

    def __init__(self, random: np.random.Generator, n_readings: int, n_actuators: int, bits: bool) -> None:
        self.random, self.bits = random, bits
        self.critic = Network(random, n_readings, 1, 1.0)
        self.actor = Network(random, n_readings, n_actuators, 0.01)
        self.log_std = np.full(n_actuators, -0.5)
        self.parameters = [*self.critic.parameters, *self.actor.parameters, self.log_std]

    def values(self, observations: np.ndarray) -> np.ndarray:
        return self.critic(observations)[:, 0]

    def draw(self, observations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Actions, and the logarithms of their probabilities."""
        outputs = self.actor(observations)
        if self.bits:
            actions = (self.random.random(outputs.shape) < sigmoid(outputs)).astype(float)
        else:
            actions = outputs + np.exp(self.log_std) * self.random.normal(size=outputs.shape)
        return actions, self.log_probability(outputs, actions)[0]

    def log_probability(self, outputs: np.ndarray, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Its value `[n]`, but for a constant, and its slopes by the outputs and by log_std, `[n x n_actuators]`."""
        if self.bits:
            each = actions * outputs - np.logaddexp(0, outputs)
            return each.sum(axis=1), actions - sigmoid(outputs), np.zeros_like(outputs)
        z = (actions - outputs) / np.exp(self.log_std)
        return (-0.5 * z**2 - self.log_std).sum(axis=1), z / np.exp(self.log_std), z**2 - 1

    def targets(self, actions: np.ndarray) -> np.ndarray:
        return actions - 0.5 if self.bits else actions.clip(-1, 1)

    def loss(self, batch: tuple[np.ndarray, ...], clip: float) -> tuple[float, list[np.ndarray]]:
        """The loss of policy and values, and its gradient by the parameters."""
        observations, actions, old_log, advantages, returns = batch
        n = len(observations)
        log, by_outputs, by_log_std = self.log_probability(self.actor(observations), actions)
        ratio = np.exp(log - old_log)
        free, clipped = ratio * advantages, ratio.clip(1 - clip, 1 + clip) * advantages
        errors = self.values(observations) - returns
        loss = -np.minimum(free, clipped).mean() + 0.25 * np.square(errors).mean()
        # Where the clipped one is the smaller, the ratio is beyond the range, and moves nothing.
        slopes = np.where(free <= clipped, -free / n, 0.0)[:, None]
        of_critic = self.critic.gradient(0.5 * errors[:, None] / n)
        return loss, [*of_critic, *self.actor.gradient(slopes * by_outputs), (slopes * by_log_std).sum(axis=0)]


def sigmoid(x: np.ndarray) -> np.ndarray:
    return 0.5 * (1 + np.tanh(0.5 * x))


class Adam:
    """Kingma and Ba, 2015, of gradients whose norm is 0.5 at most."""

    def __init__(self, parameters: list[np.ndarray]) -> None:
        self.parameters, self.t = parameters, 0
        self.means = [np.zeros_like(it) for it in parameters]
        self.squares = [np.zeros_like(it) for it in parameters]

    def step(self, gradients: list[np.ndarray], rate: float) -> None:
        self.t += 1
        scale = min(1.0, 0.5 / (np.sqrt(sum(np.sum(it**2) for it in gradients)) + 1e-6))
        all_parts = zip(self.parameters, gradients, self.means, self.squares, strict=True)
        for parameter, gradient, mean, square in all_parts:
            mean += 0.1 * (scale * gradient - mean)
            square += 0.001 * ((scale * gradient) ** 2 - square)
            divisor = np.sqrt(square / (1 - 0.999**self.t)) + 1e-5
            parameter -= rate * mean / (1 - 0.9**self.t) / divisor


class Scale:
    """Rewards are divided by the standard deviation of their discounted sum so far, as Gymnasium's wrapper does."""

    def __init__(self, n_worlds: int, discount: float) -> None:
        self.sums, self.discount = np.zeros(n_worlds), discount
        self.n, self.mean, self.squares = 1e-4, 0.0, 1e-4

    def __call__(self, rewards: np.ndarray) -> np.ndarray:
        self.sums = self.discount * self.sums + rewards
        for value in self.sums:
            self.n += 1
            change = value - self.mean
            self.mean += change / self.n
            self.squares += change * (value - self.mean)
        return np.clip(rewards / np.sqrt(self.squares / self.n + 1e-8), -10, 10)


def advantages(rewards: np.ndarray, values: np.ndarray, discount: float, decay: float) -> np.ndarray:
    """Generalised advantage estimates, `[horizon x worlds]`; there's one more of the values. No episode ends."""
    estimates, trace = np.zeros_like(rewards), 0.0
    for t in reversed(range(len(rewards))):
        error = rewards[t] + discount * values[t + 1] - values[t]
        estimates[t] = trace = error + discount * decay * trace
    return estimates


def improve(agent: Agent, adam: Adam, batch: list[np.ndarray], rate: float, args: argparse.Namespace) -> None:
    """Some epochs over what was seen, `[horizon x worlds x ...]` each."""
    batch = [it.reshape(-1, *it.shape[2:]) for it in batch]
    for _ in range(args.epochs):
        order = agent.random.permutation(len(batch[0]))
        for part in np.array_split(order, args.minibatches):
            observations, actions, old_log, estimates, returns = (it[part] for it in batch)
            estimates = (estimates - estimates.mean()) / (estimates.std() + 1e-8)
            _, gradients = agent.loss((observations, actions, old_log, estimates, returns), args.clip)
            adam.step(gradients, rate)


def main(args: argparse.Namespace) -> None:
    envs = itarl.VectorEnv(experiment=args.experiment, setting=args.setting, num_envs=args.worlds)
    n_readings, n_actuators = len(envs.sensors), len(envs.actuators)
    agent = Agent(np.random.default_rng(args.seed), n_readings, n_actuators, args.bits)
    adam, scale = Adam(agent.parameters), Scale(args.worlds, args.discount)
    shape = (args.horizon, args.worlds)
    observations, actions = np.zeros((*shape, n_readings)), np.zeros((*shape, n_actuators))
    log, rewards, values = np.zeros(shape), np.zeros(shape), np.zeros((args.horizon + 1, args.worlds))

    observation, _ = envs.reset(seed=args.seed)
    n_updates = args.control_steps // (args.horizon * args.worlds)
    told, began = [], time.perf_counter()
    for update in range(1, n_updates + 1):
        for t in range(args.horizon):
            observations[t], values[t] = observation, agent.values(observation)
            actions[t], log[t] = agent.draw(observation)
            observation, reward, terminated, _, info = envs.step(agent.targets(actions[t]))
            if terminated.any():
                raise RuntimeError(info["blew_up"])
            rewards[t] = scale(reward)
            told.append([reward.mean(), info["advance_m"].mean(), info["intrinsic_nats"].mean()])
        values[-1] = agent.values(observation)
        estimates = advantages(rewards, values, args.discount, args.trace)
        rate = args.rate * (1 - (update - 1) / n_updates)
        improve(agent, adam, [observations, actions, log, estimates, estimates + values[:-1]], rate, args)
        if update % 8 == 0 or update == n_updates:
            # Of the last 12,800 control steps, as in a cell's last 16 updates.
            r, way, information = np.mean(told[-(12_800 // args.worlds) :], axis=0)
            print(
                f"{update * args.horizon * args.worlds:7} control steps  R {r:.5f}  R_Loc {way:+.4f} m"
                f"  R_MI {information:.3f} nats  {time.perf_counter() - began:.0f} s",
                flush=True,
            )


if __name__ == "__main__":
    main(parse_arguments())
