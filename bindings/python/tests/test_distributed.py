"""On a Dask cluster: the bytes of one machine, whatever happens to workers and client."""

import json
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TypedDict

import numpy as np
import pytest
import twinrotor as tr
from distributed import Client, LocalCluster
from twinrotor import distributed

PLANTS, SEED = 25, 3
CONTROLLERS = {"the preset's": None, "the paper's": "paper"}


class Study(TypedDict):
    rigs: int
    scenario: str
    fix: list[str]
    window: float
    population: int
    iterations: int
    seed: int


@pytest.fixture(scope="module")
def cluster() -> Iterator[LocalCluster]:
    with LocalCluster(
        n_workers=1, threads_per_worker=1, dashboard_address=None, processes=True, silence_logs=50
    ) as cluster:
        yield cluster


@pytest.fixture(scope="module")
def alone() -> dict[str, tr.Comparison]:
    return tr.compare("aero2", CONTROLLERS, plants=PLANTS, seed=SEED)


def same(one: dict[str, tr.Comparison], other: dict[str, tr.Comparison]) -> bool:
    return list(one) == list(other) and all(
        one[name].costs.tobytes() == other[name].costs.tobytes() and one[name].row == other[name].row
        for name in one
    )


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_a_comparison_is_one_machines(
    cluster: LocalCluster, alone: dict[str, tr.Comparison], workers: int
) -> None:
    cluster.scale(workers)
    with Client(cluster) as client:
        client.wait_for_workers(workers)
        found = distributed.compare(client, "aero2", CONTROLLERS, plants=PLANTS, seed=SEED, chunk=4)
    assert same(found, alone)


def test_a_worker_that_is_killed_changes_nothing(
    cluster: LocalCluster, alone: dict[str, tr.Comparison], tmp_path: Path
) -> None:
    cluster.scale(2)
    left: list[int] = []

    def kill(pid: int) -> None:
        while not any(tmp_path.glob("*.bin")):
            time.sleep(0.001)
        os.kill(pid, signal.SIGKILL)
        left.append(PLANTS - len(list(tmp_path.glob("*.bin"))))

    with Client(cluster) as client:
        client.wait_for_workers(2)
        before = set(client.run(os.getpid).values())
        killer = threading.Thread(target=kill, args=(min(before),))
        killer.start()
        found = distributed.compare(
            client, "aero2", CONTROLLERS, plants=PLANTS, seed=SEED, chunk=1, checkpoint=tmp_path
        )
        killer.join()
        client.wait_for_workers(2)
        assert min(before) not in client.run(os.getpid).values()
    assert left[0] > 5, "in the middle"
    assert same(found, alone)


def test_a_comparison_goes_on_from_its_chunks(
    cluster: LocalCluster, alone: dict[str, tr.Comparison], tmp_path: Path
) -> None:
    def compare(client: Client, seed: int = SEED) -> dict[str, tr.Comparison]:
        return distributed.compare(
            client, "aero2", CONTROLLERS, plants=PLANTS, seed=seed, chunk=10, checkpoint=tmp_path
        )

    with Client(cluster) as client:
        assert same(compare(client), alone)
        kept = sorted(path.name for path in tmp_path.iterdir())
        assert kept == ["plants-0-10.bin", "plants-10-20.bin", "plants-20-25.bin"]
        # A client that died before the second was done.
        (tmp_path / kept[1]).unlink()
        there = (tmp_path / kept[0]).stat().st_mtime_ns
        assert same(compare(client), alone)
        assert (tmp_path / kept[0]).stat().st_mtime_ns == there
        with pytest.raises(ValueError, match="belongs to another run: seed is 3 there, 4 here"):
            compare(client, seed=4)


def test_a_tuning_is_one_machines_and_goes_on_where_its_client_died(
    cluster: LocalCluster, tmp_path: Path
) -> None:
    class Died(Exception):
        pass

    def die(evaluations: int, budget: int, best: float) -> None:
        if evaluations > 20:
            raise Died

    plan = {"plants": 3, "rounds": 2, "population": 6, "iterations": 3, "seed": 5, "algorithm": "de"}
    alone = tr.tune_robust("aero2", controller="pid", **plan)  # type: ignore[arg-type]
    state = tmp_path / "search.bin"
    with Client(cluster) as client:
        whole = distributed.tune_robust(client, "aero2", controller="pid", **plan)  # type: ignore[arg-type]
        assert whole.gains.toml == alone.gains.toml and whole.history == alone.history
        given = {**plan, "controller": "pid", "checkpoint": state}
        with pytest.raises(Died):
            distributed.tune_robust(client, "aero2", progress=die, **given)  # type: ignore[arg-type]
        assert state.exists()
        seen: list[int] = []
        resumed = distributed.tune_robust(
            client,
            "aero2",
            progress=lambda done, budget, best: seen.append(done),
            **given,  # type: ignore[arg-type]
        )
        assert seen[0] > 20 and resumed.gains.toml == alone.gains.toml
        with pytest.raises(ValueError, match="another run"):
            distributed.tune_robust(client, "aero2", **{**given, "seed": 6})  # type: ignore[arg-type]
        with pytest.raises(ValueError, match="plants is 0"):
            distributed.tune_robust(client, "aero2", **{**given, "plants": 0})  # type: ignore[arg-type]


def test_methods_of_search_do_as_at_the_command_line(
    cluster: LocalCluster, host_sim: Callable[..., Path]
) -> None:
    names = ["de", "fpa-paper"]
    flags = ["--algorithms", ",".join(names), "--seeds", "3", "--evaluations", "100", "--json"]
    told = json.loads((host_sim("bench-tuners", *flags) / "stdout").read_text())
    with Client(cluster) as client:
        found = distributed.bench_tuners(client, names, seeds=3, iterations=1)
        with pytest.raises(ValueError, match="unknown algorithm"):
            distributed.bench_tuners(client, ["luck"], seeds=1)
    for peer in told["algorithms"]:
        assert [run["cost"] for run in peer["runs"]] == [one.cost for one in found[peer["name"]]]
    # The table with its rank tests, too.
    standings = tr.standings(found)
    assert [asdict(standings[name]) for name in names] == told["standings"]
    assert standings["de"].p_value is None and standings["fpa-paper"].p_value is not None


#: Few constants and a short flight, since it is the counting that is compared.
STUDY: Study = {
    "rigs": 3,
    "scenario": "duration = 9.0\n[pitch.steps]\njumps = [[1, 20], [5, -15]]\n"
    "[yaw.steps]\njumps = [[3, 60], [7, -30]]\n",
    "fix": ["effectiveness", "quadratic_effectiveness", "rotor_time_constant", "rotor_reaction"],
    "window": 1.5,
    "population": 2,
    "iterations": 0,
    "seed": 3,
}


@pytest.fixture(scope="module")
def studied_alone() -> tr.Coverage:
    return tr.coverage("aero2", **STUDY)


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_a_study_of_coverage_is_one_machines(
    cluster: LocalCluster, studied_alone: tr.Coverage, workers: int
) -> None:
    cluster.scale(workers)
    with Client(cluster) as client:
        client.wait_for_workers(workers)
        assert distributed.coverage(client, "aero2", **STUDY) == studied_alone


def test_a_study_goes_on_from_its_chunks(
    cluster: LocalCluster, studied_alone: tr.Coverage, tmp_path: Path
) -> None:
    with Client(cluster) as client:
        assert distributed.coverage(client, "aero2", chunk=2, checkpoint=tmp_path, **STUDY) == studied_alone
        (tmp_path / "rigs-2-3.bin").unlink()
        there = (tmp_path / "rigs-0-2.bin").stat().st_mtime_ns
        assert distributed.coverage(client, "aero2", chunk=2, checkpoint=tmp_path, **STUDY) == studied_alone
        assert (tmp_path / "rigs-0-2.bin").stat().st_mtime_ns == there
        with pytest.raises(ValueError, match=r"another run: window is 1\.5 there, 2 here"):
            other: Study = {**STUDY, "window": 2.0}
            distributed.coverage(client, "aero2", chunk=2, checkpoint=tmp_path, **other)


def test_a_study_of_coverage_is_the_command_lines(
    studied_alone: tr.Coverage, host_sim: Callable[..., Path], tmp_path: Path
) -> None:
    (tmp_path / "short.toml").write_text(STUDY["scenario"])
    flags = ["--preset", "aero2", "--rigs", "3", "--scenario", str(tmp_path / "short.toml"), "--seed", "3"]
    fit = ["--fix", ",".join(STUDY["fix"]), "--window", "1.5", "--population", "2", "--iterations", "0"]
    told = json.loads((host_sim("coverage", *flags, *fit, "--json") / "stdout").read_text())
    named = {"scenario": told["scenario"]}
    assert told == {**studied_alone.told, **named}
    stiffness = studied_alone.constants["stiffness"]
    assert stiffness.intervals == 3 - len(studied_alone.failures) and stiffness.held <= stiffness.intervals
    with pytest.raises(ValueError, match="rigs is 0"):
        tr.coverage("aero2", rigs=0)
    with pytest.raises(ValueError, match=r"spread is 1; allowed: 0 to 0\.9"):
        tr.coverage("aero2", spread=1.0)


def test_tests_on_ranks() -> None:
    """SciPy: ``mannwhitneyu(a, b, method="asymptotic")``."""
    a = [1.1, 2.2, 3.3, 4.4, 5.5, 6.6, 7.7, 8.8]
    b = np.array([2.0, 4.0, 6.0, 8.0, 9.0, 10.0, 11.0, 12.0])
    assert tr.rank_sum(a, b) == pytest.approx(0.103562, abs=1e-6)
    assert tr.holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    with pytest.raises(ValueError, match="no search of 'de'"):
        tr.standings({"de": []})


def test_a_chunk_is_the_wholes() -> None:
    """Without any cluster: chunks of any size, and what is no whole is refused."""
    from twinrotor import _native
    from twinrotor._gains import rig_text

    named: list[tuple[str, str | None]] = [("one", None)]
    what = (rig_text("aero2"), named, PLANTS, SEED)
    whole = _native.compare(*what)
    chunks = [_native.compare_chunk(*what, a, b) for a, b in [(0, 1), (1, 18), (18, 25)]]
    joined = _native.compare_chunks(*what, chunks)
    assert np.array_equal(joined[0][0], whole[0][0]) and joined[0][1] == whole[0][1]
    for wrong, told in [(chunks[:2], "25 plants"), (chunks[1:], "in order"), ([b"x"], "no checkpoint")]:
        with pytest.raises(ValueError, match=told):
            _native.compare_chunks(*what, wrong)
