"""PPO on Svenja, beside the lab's own learner: one file, in the manner of CleanRL.

    pip install ./python torch gymnasium
    python python/examples/ppo.py                     # what experiments/quick.toml trains, xi = 0.75
    python python/examples/ppo.py --setting xi=1 --seed 2
    python python/examples/ppo.py --bits              # with the actions of the lab's policies

Same robot, same reward, same number of control steps (128,000) as a cell of `itarl train
experiments/quick.toml`, in one life: no episode ends. Not the same are the policy, a network that sees positions
and not only their signs, and by default the targets, any within -1 to 1 and not only -0.5 or 0.5.
"""

import argparse
import time
from pathlib import Path

import numpy as np
import torch
from torch import nn
from torch.distributions import Bernoulli, Independent, Normal

import itarl

EXPERIMENT = Path(__file__).parents[2] / "experiments/quick.toml"


def parse_arguments() -> argparse.Namespace:
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
    return parser.parse_args()


def layer(n_inputs: int, n_outputs: int, gain: float = 2**0.5) -> nn.Linear:
    linear = nn.Linear(n_inputs, n_outputs)
    nn.init.orthogonal_(linear.weight, gain)
    nn.init.zeros_(linear.bias)
    return linear


def network(n_inputs: int, n_outputs: int, gain: float) -> nn.Sequential:
    return nn.Sequential(layer(n_inputs, 64), nn.Tanh(), layer(64, 64), nn.Tanh(), layer(64, n_outputs, gain))


class Agent(nn.Module):
    def __init__(self, n_readings: int, n_actuators: int, bits: bool) -> None:
        super().__init__()
        self.bits = bits
        self.critic = network(n_readings, 1, 1.0)
        self.actor = network(n_readings, n_actuators, 0.01)
        self.log_std = nn.Parameter(torch.full((n_actuators,), -0.5))

    def distribution(self, observations: torch.Tensor) -> Independent:
        outputs = self.actor(observations)
        each = Bernoulli(logits=outputs) if self.bits else Normal(outputs, self.log_std.exp())
        return Independent(each, 1)

    def targets(self, actions: torch.Tensor) -> np.ndarray:
        return (actions - 0.5 if self.bits else actions.clamp(-1, 1)).double().numpy()


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


def advantages(rewards: torch.Tensor, values: torch.Tensor, args: argparse.Namespace) -> torch.Tensor:
    """Generalised advantage estimates, `[horizon x worlds]`; there's one more of the values. No episode ends."""
    estimates, trace = torch.zeros_like(rewards), 0.0
    for t in reversed(range(args.horizon)):
        error = rewards[t] + args.discount * values[t + 1] - values[t]
        estimates[t] = trace = error + args.discount * args.trace * trace
    return estimates


def improve(agent: Agent, optimizer: torch.optim.Optimizer, batch: list[torch.Tensor], args: argparse.Namespace) -> None:
    observations, actions, old_log, estimates, returns = (it.flatten(0, 1) for it in batch)
    n = len(observations)
    for _ in range(args.epochs):
        for part in torch.randperm(n).chunk(args.minibatches):
            distribution = agent.distribution(observations[part])
            ratio = (distribution.log_prob(actions[part]) - old_log[part]).exp()
            advantage = estimates[part]
            advantage = (advantage - advantage.mean()) / (advantage.std() + 1e-8)
            clipped = ratio.clamp(1 - args.clip, 1 + args.clip)
            loss_of_policy = -torch.minimum(ratio * advantage, clipped * advantage).mean()
            loss_of_values = 0.5 * (agent.critic(observations[part]).squeeze(-1) - returns[part]).square().mean()
            optimizer.zero_grad()
            (loss_of_policy + 0.5 * loss_of_values).backward()
            nn.utils.clip_grad_norm_(agent.parameters(), 0.5)
            optimizer.step()


def main() -> None:
    args = parse_arguments()
    torch.manual_seed(args.seed)
    torch.set_num_threads(1)
    envs = itarl.VectorEnv(experiment=args.experiment, setting=args.setting, num_envs=args.worlds)
    n_readings, n_actuators = len(envs.sensors), len(envs.actuators)
    agent = Agent(n_readings, n_actuators, args.bits)
    optimizer = torch.optim.Adam(agent.parameters(), lr=args.rate, eps=1e-5)
    scale = Scale(args.worlds, args.discount)
    shape = (args.horizon, args.worlds)
    observations, actions = torch.zeros(*shape, n_readings), torch.zeros(*shape, n_actuators)
    log, rewards, values = torch.zeros(shape), torch.zeros(shape), torch.zeros(args.horizon + 1, args.worlds)

    observation = torch.tensor(envs.reset(seed=args.seed)[0], dtype=torch.float32)
    n_updates = args.control_steps // (args.horizon * args.worlds)
    told, began = [], time.perf_counter()
    for update in range(1, n_updates + 1):
        optimizer.param_groups[0]["lr"] = args.rate * (1 - (update - 1) / n_updates)
        for t in range(args.horizon):
            with torch.no_grad():
                distribution = agent.distribution(observation)
                observations[t], actions[t] = observation, distribution.sample()
                log[t], values[t] = distribution.log_prob(actions[t]), agent.critic(observation).squeeze(-1)
            seen, reward, terminated, _, info = envs.step(agent.targets(actions[t]))
            if terminated.any():
                raise RuntimeError(info["blew_up"])
            rewards[t] = torch.tensor(scale(reward))
            observation = torch.tensor(seen, dtype=torch.float32)
            told.append([reward.mean(), info["advance_m"].mean(), info["intrinsic_nats"].mean()])
        with torch.no_grad():
            values[-1] = agent.critic(observation).squeeze(-1)
        estimates = advantages(rewards, values, args)
        improve(agent, optimizer, [observations, actions, log, estimates, estimates + values[:-1]], args)
        done = update * args.horizon * args.worlds
        if update % 8 == 0 or update == n_updates:
            # The last 16,000 control steps or so, as the last 20 updates of a cell.
            r, way, information = np.mean(told[-(16_000 // args.worlds) :], axis=0)
            print(
                f"{done:7} control steps  R {r:.5f}  R_Loc {way:+.4f} m  R_MI {information:.3f} nats"
                f"  {time.perf_counter() - began:.0f} s",
                flush=True,
            )


if __name__ == "__main__":
    main()
