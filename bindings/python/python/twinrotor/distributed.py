"""Comparisons, tunings and studies on a Dask cluster: byte for byte what one machine computes.

``client`` is a ``distributed.Client``, of worker processes on this machine, or of a cluster of Slurm's or
Kubernetes' (``dask_jobqueue``, ``dask_kubernetes``). Dask schedules, moves data and tries again what a lost
worker has not finished; a task here is a pure function of settings, seed and a chunk of plants or candidates,
so that neither the number of workers nor their end changes a byte. This package must be installed on all.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from . import _native
from ._coverage import Coverage, chunks_of, covered, studied
from ._gains import GainsLike, RigLike, gains_text, rig_text
from ._search import Comparison, Tuned, comparisons, tuned

if TYPE_CHECKING:
    from distributed import Client, Future

Progress: TypeAlias = Callable[[int, int, float], object]
Candidates: TypeAlias = list[tuple[list[float], float]]


def compare(
    client: Client,
    preset: RigLike,
    controllers: Mapping[str, GainsLike],
    *,
    plants: int = 300,
    seed: int = 1,
    chunk: int = 64,
    checkpoint: str | os.PathLike[str] | None = None,
) -> dict[str, Comparison]:
    """:func:`twinrotor.compare`, ``chunk`` plants a task.

    :param checkpoint: a folder in which finished chunks are kept; those that it has are not flown again.
    :raises ValueError: if an argument is not what it may be, or a chunk that was kept is of another run.
    """
    if chunk < 1:
        raise ValueError(f"chunk is {chunk}; allowed: at least 1")
    rig = rig_text(preset)
    named = [(name, gains_text(gains)) for name, gains in controllers.items()]
    bounds = [(first, min(first + chunk, plants)) for first in range(0, plants, chunk)]
    chunks = _chunks(client, _native.compare_chunk, (rig, named, plants, seed), bounds, "plants", checkpoint)
    return comparisons(named, _native.compare_chunks(rig, named, plants, seed, chunks))


def tune_robust(
    client: Client,
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
    chunk: int = 1,
    checkpoint: str | os.PathLike[str] | None = None,
) -> Tuned:
    """:func:`twinrotor.tune_robust`, ``chunk`` candidates a task.

    Candidates of one generation are flown side by side: as many tasks as the method asks for at once.

    :param checkpoint: a file that has the search after every generation, and is gone on from if it is there.
    :raises ValueError: if an argument is not what it may be, or the checkpoint is of another run.
    """
    if chunk < 1:
        raise ValueError(f"chunk is {chunk}; allowed: at least 1")
    limits = [f"{name}={most}" for name, most in (at_most or {}).items()]
    what = (rig_text(preset), controller, gains_text(start), list(parameters), limits, plants, seed)
    path = None if checkpoint is None else Path(checkpoint)

    def evaluate(candidates: Candidates) -> list[float]:
        pieces = [candidates[k : k + chunk] for k in _range(0, len(candidates), chunk)]
        futures = [
            client.submit(_native.robust_costs, *what, piece, pure=False, retries=3) for piece in pieces
        ]
        return [cost for costs in client.gather(futures) for cost in costs]

    return tuned(
        _native.tune_robust(
            *what[:6],
            rounds,
            range,
            algorithm,
            seed,
            population,
            iterations,
            progress,
            evaluate,
            None if path is None else lambda state: _write(path, state),
            path.read_bytes() if path is not None and path.exists() else None,
        )
    )


def coverage(
    client: Client,
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
    chunk: int = 1,
    checkpoint: str | os.PathLike[str] | None = None,
) -> Coverage:
    """:func:`twinrotor.coverage`, ``chunk`` rigs a task.

    :param checkpoint: a folder in which finished chunks are kept; those that it has are not computed again.
    :raises ValueError: if an argument is not what it may be, or a chunk that was kept is of another study.
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
    bounds = chunks_of(rigs, chunk)
    return covered(what, _chunks(client, _native.coverage_chunk, (what,), bounds, "rigs", checkpoint))


def bench_tuners(
    client: Client,
    algorithms: Sequence[str],
    *,
    preset: RigLike = "paper",
    seeds: int = 20,
    seed: int = 1,
    population: int | None = None,
    iterations: int = 30,
) -> dict[str, list[Tuned]]:
    """Methods of search on the paper's four gains and their ISE, ``seeds`` searches of each, a task each.

    What ``host-sim bench-tuners --evaluations N`` computes, for N = population (50 if ``None``) times
    ``iterations`` + 1; :func:`twinrotor.standings` makes its table of it.

    :raises ValueError: if an argument is not what it may be.
    """
    rig = rig_text(preset)
    futures = {
        name: [
            client.submit(
                _native.bench_tuner,
                rig,
                name,
                seed + k,
                population,
                iterations,
                pure=False,
                retries=3,
            )
            for k in _range(seeds)
        ]
        for name in algorithms
    }
    return {name: [tuned(found) for found in client.gather(runs)] for name, runs in futures.items()}


def _chunks(
    client: Client,
    compute: Callable[..., bytes],
    what: tuple[object, ...],
    bounds: Sequence[tuple[int, int]],
    kind: str,
    checkpoint: str | os.PathLike[str] | None,
) -> list[bytes]:
    """``compute(*what, first, end)`` of all ``bounds``, each a task, without those that the folder has."""
    folder = None if checkpoint is None else Path(checkpoint)
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)

    def place(first: int, end: int) -> Path | None:
        return None if folder is None else folder / f"{kind}-{first}-{end}.bin"

    done: dict[int, bytes] = {}
    asked: dict[Future[bytes], tuple[int, int]] = {}
    for first, end in bounds:
        path = place(first, end)
        if path is not None and path.exists():
            done[first] = path.read_bytes()
        else:
            future = client.submit(compute, *what, first, end, pure=False, retries=3)
            asked[future] = (first, end)
    for future in _as_completed(asked):
        first, end = asked[future]
        done[first] = future.result()
        path = place(first, end)
        if path is not None:
            _write(path, done[first])
    return [done[first] for first, _ in bounds]


#: ``range`` is also the name of an argument.
_range = range


def _as_completed(futures: Mapping[Any, object]) -> Any:
    from distributed import as_completed

    return as_completed(list(futures))


def _write(path: Path, data: bytes) -> None:
    """The whole of it or nothing."""
    beside = path.with_name(path.name + ".new")
    beside.write_bytes(data)
    beside.replace(path)
