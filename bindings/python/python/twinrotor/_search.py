"""Tuning, and comparing what was tuned."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _native
from ._flight import Fidelity
from ._gains import Gains, GainsLike, Rig, RigLike, gains_text, rig_text

Progress = Callable[[int, int, float], object]


@dataclass(frozen=True)
class AtBound:
    """A parameter that a search has left at an end of its box: what is beyond, no search has seen."""

    name: str
    value: float
    side: Literal["least", "most"]
    bound: float


@dataclass(frozen=True)
class Tuned:
    """What a search has found.

    ``history`` has evaluations and cost at every improvement; ``at_bounds`` what it has left at a bound of
    its box, or of its last round's.
    """

    gains: Gains
    cost: float
    evaluations: int
    history: list[tuple[int, float]] = field(repr=False)
    at_bounds: list[AtBound] = field(repr=False)


def tuned(found: tuple[str, str]) -> Tuned:
    toml, text = found
    course = json.loads(text)
    history = [(int(n), float(cost)) for n, cost in course["history"]]
    at_bounds = [AtBound(**end) for end in course["at_bounds"]]
    return Tuned(Gains(toml), course["cost"], course["evaluations"], history, at_bounds)


def tune(
    preset: RigLike = "paper",
    *,
    objective: Literal["ise", "iae", "itae"] = "ise",
    algorithm: str = "fpa-paper",
    seed: int = 1,
    population: int | None = None,
    iterations: int = 30,
    scenario: str | os.PathLike[str] = "step",
    fidelity: Fidelity = "ideal",
    bounds: tuple[float, float] = (1.0, 25.0),
    progress: Progress | None = None,
) -> Tuned:
    """Gains of the paper's law that minimise an integral of the error: the bytes of ``host-sim tune``.

    :param algorithm: ``fpa-paper``, ``fpa-yang``, ``fpa-demo``, ``fpa-adaptive``, ``ga``, ``pso``, ``gwo``,
        ``de``, ``cmaes``, ``nelder-mead``, ``random``, ``sobol``.
    :param progress: called after every generation with evaluations, budget and best cost.
    :raises ValueError: if an argument is not what it may be.
    """
    return tuned(
        _native.tune(
            rig_text(preset),
            objective,
            algorithm,
            seed,
            population,
            iterations,
            os.fspath(scenario),
            fidelity,
            bounds,
            progress,
        )
    )


def tune_robust(
    preset: RigLike,
    *,
    controller: str = "integral",
    start: GainsLike = None,
    parameters: Sequence[str] = (),
    at_most: Mapping[str, float] | None = None,
    plants: int = 32,
    rounds: int = 4,
    range: float = 4.0,
    algorithm: str = "fpa-paper",
    seed: int = 1,
    population: int | None = None,
    iterations: int = 30,
    progress: Progress | None = None,
) -> Tuned:
    """Any parameter of any controller on many plants: ``host-sim tune --objective robust --scenes step``.

    :param controller: whose design to start from, unless ``start`` is given.
    :param parameters: names of :func:`settings`; all if none is given.
    :param at_most: numbers of :func:`compare` to keep within a limit, such as ``{"overshoot_p95.yaw": 2}``.
    :raises ValueError: if an argument is not what it may be.
    """
    limits = [f"{name}={most}" for name, most in (at_most or {}).items()]
    return tuned(
        _native.tune_robust(
            rig_text(preset),
            controller,
            gains_text(start),
            list(parameters),
            limits,
            plants,
            rounds,
            range,
            algorithm,
            seed,
            population,
            iterations,
            progress,
            None,
            None,
            None,
        )
    )


@dataclass(frozen=True)
class Comparison:
    """A controller on drawn plants.

    ``costs`` has what each plant costs, ``row`` what ``host-sim compare --json`` says; its ``p_value`` is
    Wilcoxon's against the first controller.
    """

    costs: npt.NDArray[np.float64] = field(repr=False)
    row: Mapping[str, Any]

    @property
    def total(self) -> float:
        """J = mean(c) + q90(c)/2."""
        return float(self.row["J"])


def compare(
    preset: RigLike, controllers: Mapping[str, GainsLike], *, plants: int = 300, seed: int = 1
) -> dict[str, Comparison]:
    """Controllers on the same drawn plants, which no tuning with this seed has seen.

    :raises ValueError: if an argument is not what it may be.
    """
    named = [(name, gains_text(gains)) for name, gains in controllers.items()]
    return comparisons(named, _native.compare(rig_text(preset), named, plants, seed))


def comparisons(
    named: list[tuple[str, str | None]], scores: list[tuple[npt.NDArray[np.float64], str]]
) -> dict[str, Comparison]:
    """By the controllers' names."""
    return {
        name: Comparison(costs, json.loads(row))
        for (name, _), (costs, row) in zip(named, scores, strict=True)
    }


def draw(preset: RigLike, count: int, *, seed: int = 1) -> list[Rig]:
    """Rigs around a preset, as the robust objective draws its plants: for :func:`simulate` and the like.

    :raises ValueError: if ``count`` is not within 1 to 100,000.
    """
    name = Rig.of(preset).name
    rigs = _native.draw(rig_text(preset), count, seed)
    return [Rig(f"{name}, drawn {number}", toml) for number, toml in enumerate(rigs)]
