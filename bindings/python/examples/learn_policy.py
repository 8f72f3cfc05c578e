"""Learns a linear policy from volts alone, by the cross-entropy method, and ranks it beside the board's loop.

    python examples/learn_policy.py --generations 30

Every candidate of a generation flies the same plants, all of them at once, and every generation others. The
returns printed are means over plants that no learning has seen, the same for all; nothing here makes the
policy safe on a real rig, the board's supervisor does: see ``action="setpoint"``.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import twinrotor as tr
import twinrotor.gym as gym

Array = npt.NDArray[np.float64]
Act = Callable[[gym.Vector], Array]
#: What the policy sees of an observation, each in a unit in which it is about 1.
SCALE = np.array([1 / 0.3, 1.0, 1.0, 1.0, 1 / 0.3, 1 / 0.7, 0.0, 0.0])
SECONDS = 4.0


def linear(weights: Array) -> Act:
    """Volts that are linear in the observation; a row of 16 weights for each environment, or one for all."""
    gains = weights.reshape(-1, 2, 8)
    return lambda seen: np.clip(np.einsum("eij,ej->ei", gains, SCALE * seen), -1.0, 1.0)


def returns(batch: tr.Batch, seeds: list[int], act: Act) -> Array:
    """Of an episode of each environment, begun with these seeds."""
    seen = batch.begin(seeds)
    total, flying = np.zeros(batch.count), np.ones(batch.count, np.bool_)
    while flying.any():
        stepped = batch.fly(act(seen))
        seen = stepped.observations
        total += np.where(flying, stepped.rewards, 0.0)
        flying &= ~(stepped.terminated | stepped.truncated)
    return total


def learn(
    generations: int,
    population: int = 64,
    elite: int = 12,
    plants: int = 4,
    seed: int = 1,
    told: Callable[[int, Array], object] | None = None,
) -> Array:
    """The mean of the last generation's best; ``told`` hears every generation's mean returns."""
    batch = tr.Batch("aero2", population * plants, seconds=SECONDS)
    rng = np.random.default_rng(seed)
    # A guess of the signs: push towards the goal, against the rate.
    mean = np.zeros(16)
    mean[[2, 4, 8 + 3, 8 + 5]] = [-0.3, 0.5, -0.3, 0.5]
    spread = np.full(16, 0.3)
    for generation in range(generations):
        tried = mean + spread * rng.standard_normal((population, mean.size))
        seeds = [seed + 1_000 * generation + k for k in range(plants)] * population
        found = returns(batch, seeds, linear(np.repeat(tried, plants, axis=0)))
        means = found.reshape(population, plants).mean(axis=1)
        best = tried[np.argsort(means)[-elite:]]
        mean, spread = best.mean(axis=0), best.std(axis=0) + 0.02
        if told is not None:
            told(generation, means)
    return mean


def rank(weights: Array, plants: int = 100) -> dict[str, Array]:
    """Each one's returns on plants that were not learned from, the best mean first."""
    seeds = list(range(10**6, 10**6 + plants))
    volts = tr.Batch("aero2", plants, seconds=SECONDS)
    board = tr.Batch("aero2", plants, seconds=SECONDS, action="setpoint")
    reach = np.radians([25.0, 90.0])
    found = {
        "zero volts": returns(volts, seeds, linear(np.zeros(16))),
        "learned": returns(volts, seeds, linear(weights)),
        "the board's loop": returns(board, seeds, lambda _: board.goals() / reach),
    }
    return dict(sorted(found.items(), key=lambda one: -float(one[1].mean())))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--generations", type=int, default=30)

    def show(generation: int, means: Array) -> None:
        print(f"generation {generation:3}: mean return {means.mean():9.2f}, best {means.max():8.2f}")

    for name, found in rank(learn(parser.parse_args().generations, told=show)).items():
        print(f"{name:17} {found.mean():9.2f}")
