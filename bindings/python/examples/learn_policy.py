"""Learns a linear policy from volts alone, by the cross-entropy method, and ranks it beside the board's loop.

    python examples/learn_policy.py --generations 30

Every episode flies another plant. The returns printed are means over plants that no learning has seen;
nothing here makes the policy safe on a real rig, the board's supervisor does: see ``action="setpoint"``.
"""

from __future__ import annotations

import argparse

import gymnasium
import numpy as np
import numpy.typing as npt
import twinrotor.gym as gym

Array = npt.NDArray[np.float64]
#: What the policy sees of an observation, each in a unit in which it is about 1.
SCALE = np.array([1 / 0.3, 1.0, 1.0, 1.0, 1 / 0.3, 1 / 0.7, 0.0, 0.0])


def episode(env: gymnasium.Env[gym.Vector, gym.Vector], weights: Array, seed: int) -> float:
    """The return of volts that are linear in the observation."""
    seen, _ = env.reset(seed=seed)
    total, ended, cut = 0.0, False, False
    gains = weights.reshape(2, 8)
    while not (ended or cut):
        action = np.clip(gains @ (SCALE * seen), -1.0, 1.0).astype(np.float32)
        seen, reward, ended, cut, _ = env.step(action)
        total += float(reward)
    return total


def learn(generations: int, population: int = 24, elite: int = 6, seed: int = 1) -> Array:
    """The mean of the last generation's best."""
    env = gymnasium.make("Twinrotor-v0", seconds=4.0)
    rng = np.random.default_rng(seed)
    # A guess of the signs: push towards the goal, against the rate.
    mean = np.zeros(16)
    mean[[2, 4, 8 + 3, 8 + 5]] = [-0.3, 0.5, -0.3, 0.5]
    spread = np.full(16, 0.3)
    for generation in range(generations):
        tried = mean + spread * rng.standard_normal((population, mean.size))
        plants = [seed + 1_000 * generation + k for k in range(3)]
        returns = np.array([np.mean([episode(env, weights, plant) for plant in plants]) for weights in tried])
        best = tried[np.argsort(returns)[-elite:]]
        mean, spread = best.mean(axis=0), best.std(axis=0) + 0.02
        print(f"generation {generation:3}: mean return {returns.mean():9.2f}, best {returns.max():8.2f}")
    return mean


def rank(weights: Array, plants: int = 10) -> dict[str, float]:
    """Mean returns on plants that were not learned from."""
    volts = gymnasium.make("Twinrotor-v0", seconds=4.0)
    seeds = range(10**6, 10**6 + plants)
    found = {
        "zero volts": np.mean([episode(volts, np.zeros(16), seed) for seed in seeds]),
        "learned": np.mean([episode(volts, weights, seed) for seed in seeds]),
    }
    board = gymnasium.make("Twinrotor-v0", seconds=4.0, action="setpoint")
    inner = board.unwrapped
    assert isinstance(inner, gym.Twinrotor)
    returns = []
    for seed in seeds:
        board.reset(seed=seed)
        total, ended, cut = 0.0, False, False
        while not (ended or cut):
            _, reward, ended, cut, _ = board.step((inner.goal / np.radians([25.0, 90.0])).astype(np.float32))
            total += float(reward)
        returns.append(total)
    found["the board's loop"] = np.mean(returns)
    return {name: float(value) for name, value in found.items()}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--generations", type=int, default=30)
    for name, value in rank(learn(parser.parse_args().generations)).items():
        print(f"{name:17} {value:9.2f}")
