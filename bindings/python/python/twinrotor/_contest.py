"""Methods of search side by side, and tests on ranks: what ``host-sim bench-tuners`` prints."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from . import _native
from ._search import Tuned


@dataclass(frozen=True)
class Standing:
    """A method's searches in numbers.

    ``p_value`` says how likely its costs differ from the first method's by chance: Wilcoxon's rank-sum test,
    two-sided, with Holm's correction for the number of methods; ``None`` for the first. The evaluations to
    within 1 % and .1 % of the best cost known are medians; ``None`` if fewer than half of the searches got
    there.
    """

    name: str
    median: float
    interquartile_range: float
    best: float
    worst: float
    evaluations_to_1_percent: float | None
    evaluations_to_01_percent: float | None
    p_value: float | None


def standings(found: Mapping[str, Sequence[Tuned]]) -> dict[str, Standing]:
    """What :func:`twinrotor.distributed.bench_tuners` has found, in numbers, compared with the first.

    :raises ValueError: if a method has no search.
    """
    for name, runs in found.items():
        if not runs:
            raise ValueError(f"found has no search of {name!r}; allowed: at least one of each")
    peers = [(name, [(one.cost, one.history) for one in runs]) for name, runs in found.items()]
    _, told = _native.standings(peers)
    return {standing["name"]: Standing(**standing) for standing in json.loads(told)}


def rank_sum(a: Iterable[float], b: Iterable[float]) -> float:
    """How likely two independent samples differ by chance: Wilcoxon's rank-sum test (Mann-Whitney's U).

    The two-sided p-value by the normal approximation with ties and continuity corrected, good from about
    eight of each on.
    """
    return _native.rank_sum(list(a), list(b))


def holm(p_values: Iterable[float]) -> list[float]:
    """Holm's correction of several p-values, such as those of :func:`compare`'s rows, which have none."""
    return _native.holm(list(p_values))
