"""Whether the intervals of an identification hold the truth."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypedDict

from . import _native
from ._gains import GainsLike, RigLike, gains_text, rig_text


class Studied(TypedDict):
    """What is studied."""

    preset: str
    gains: str | None
    scenario: str | None
    rigs: int
    spread: float
    lag_spread: float
    free: list[str]
    fix: list[str]
    window: float
    population: int
    iterations: int
    seed: int


@dataclass(frozen=True)
class Covered:
    """One constant over all rigs that were identified.

    Of so many ``intervals`` that were printed, ``held`` hold the truth: a part ``coverage``, with its own
    95 % interval ``coverage_ci95`` (Wilson's). Widths and errors are medians, in the constant's unit.
    """

    name: str
    unit: str
    intervals: int
    held: int
    coverage: float | None
    coverage_ci95: tuple[float, float] | None
    median_width: float | None
    median_error: float | None
    identifiable: int
    at_bound: int


@dataclass(frozen=True)
class Coverage:
    """A study; ``failures`` has, by a rig's number, why it has no answer."""

    constants: dict[str, Covered] = field(repr=False)
    failures: dict[int, str]
    rigs: int
    told: Mapping[str, Any] = field(repr=False)


def studied(
    preset: RigLike,
    gains: GainsLike,
    scenario: str | os.PathLike[str] | None,
    rigs: int,
    spread: float,
    lag_spread: float,
    free: Sequence[str],
    fix: Sequence[str],
    window: float,
    population: int,
    iterations: int,
    seed: int,
) -> Studied:
    return {
        "preset": rig_text(preset),
        "gains": gains_text(gains),
        "scenario": None if scenario is None else os.fspath(scenario),
        "rigs": rigs,
        "spread": spread,
        "lag_spread": lag_spread,
        "free": list(free),
        "fix": list(fix),
        "window": window,
        "population": population,
        "iterations": iterations,
        "seed": seed,
    }


def chunks_of(rigs: int, chunk: int) -> list[tuple[int, int]]:
    """First and end of each.

    :raises ValueError: if there are none.
    """
    if chunk < 1:
        raise ValueError(f"chunk is {chunk}; allowed: at least 1")
    if rigs < 1:
        raise ValueError(f"rigs is {rigs}; allowed: 1 to 100000")
    return [(first, min(first + chunk, rigs)) for first in range(0, rigs, chunk)]


def covered(what: Studied, chunks: list[bytes]) -> Coverage:
    told = json.loads(_native.coverage_chunks(what, chunks))
    constants = [
        Covered(
            **{**one, "coverage_ci95": None if one["coverage_ci95"] is None else tuple(one["coverage_ci95"])}
        )
        for one in told["constants"]
    ]
    return Coverage(
        {one.name: one for one in constants},
        {failed["rig"]: failed["why"] for failed in told["failures"]},
        told["rigs"],
        told,
    )


def coverage(
    preset: RigLike = "paper",
    *,
    gains: GainsLike = None,
    scenario: str | os.PathLike[str] | None = None,
    rigs: int = 100,
    spread: float = 0.3,
    lag_spread: float = 0.7,
    free: Sequence[str] = (),
    fix: Sequence[str] = (),
    window: float = 3.5,
    population: int = 12,
    iterations: int = 3,
    seed: int = 1,
    progress: Callable[[int, int], object] | None = None,
) -> Coverage:
    """How often the intervals of :func:`identify` hold the truth: what ``host-sim coverage`` counts.

    Rigs are drawn around the preset, each flies ``scenario`` with ``gains`` that believe the preset, and its
    log is identified with the preset as what is known before.

    :param scenario: ``None`` is the flight of docs/identify.md.
    :param spread: part of the preset's constants within which they are drawn; ``lag_spread`` of the lags.
    :param progress: called with rigs done and all of them.
    :raises ValueError: if an argument is not what it may be.
    """
    what = studied(
        preset,
        gains,
        scenario,
        rigs,
        spread,
        lag_spread,
        free,
        fix,
        window,
        population,
        iterations,
        seed,
    )
    chunks: list[bytes] = []
    for first, end in chunks_of(rigs, 4 * (os.cpu_count() or 1)):
        chunks.append(_native.coverage_chunk(what, first, end))
        if progress is not None:
            progress(end, rigs)
    return covered(what, chunks)
