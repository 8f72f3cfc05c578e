"""Identification and replay from Python are those of the command line, from files and from arrays."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import twinrotor as tr
from conftest import ROOT, columns

Run = Callable[..., Path]
GAINS = str(ROOT / "gains" / "aero2.toml")
FIX = ("quadratic_effectiveness", "rotor_reaction", "coulomb_friction", "stiffness", "effectiveness")


@pytest.fixture(scope="module")
def logs(host_sim: Run) -> tuple[Path, Path]:
    """Two short ones of an Aero 2."""

    def flown(scenario: str) -> Path:
        flags = f"simulate --preset aero2 --gains {GAINS} --scenario {scenario} --fidelity rig --duration 9"
        return host_sim(*flags.split(), "--log", "log.csv") / "log.csv"

    return flown("step"), flown("2")


def short(log: Path) -> dict[str, Any]:
    """Columns of its first seconds, as arrays."""
    return {name: np.array(column[:6_000]) for name, column in columns(log).items()}


def test_a_flights_log_is_what_the_command_line_writes(logs: tuple[Path, Path]) -> None:
    flown = tr.simulate("aero2", None, "2", fidelity="rig", duration=9.0)
    written = columns(logs[1])
    assert list(written) == list(flown.log)
    for name, column in written.items():
        assert np.array_equal(flown.log[name], column), name


def test_an_identification(host_sim: Run, logs: tuple[Path, Path]) -> None:
    train, other = logs
    flags = "--preset aero2 --free inertia.yaw --window 2 --population 2 --iterations 1 --seed 3 --json"
    folder = host_sim(
        "identify", str(train), "--validate", str(other), *flags.split(), "--fix", ",".join(FIX)
    )
    seen: list[str] = []
    options: dict[str, Any] = {"free": ["inertia.yaw"], "fix": FIX, "window": 2.0, "population": 2}
    found = tr.identify(
        train,
        "aero2",
        validate=[other],
        **options,
        iterations=1,
        seed=3,
        progress=lambda what, best: seen.append(what),
    )
    document = json.loads((folder / "stdout").read_text())
    assert len(found.constants) == len(document["parameters"]) == 5
    for constant, told in zip(found.constants, document["parameters"], strict=True):
        assert constant == tr.Constant(**{**told, "ci95": told["ci95"] and tuple(told["ci95"])})
    assert found.fits == [tr.Fit(**fit) for fit in document["fits"]]
    assert {fit.role for fit in found.fits} == {"train", "validate"}
    for name in ("windows", "cost", "descents", "notes"):
        assert getattr(found, name) == document[name], name
    assert (folder / "preset.toml").read_text().split("\n", 1)[1] == found.rig.toml
    assert seen == ["search", "search", "descent", "descent", "descent"]
    # The same rows as arrays are the same log.
    again = tr.identify(
        {name: np.array(column) for name, column in columns(train).items()},
        "aero2",
        **options,
        iterations=1,
        seed=3,
    )
    assert again.rig.toml == found.rig.toml and again.constants == found.constants


def test_an_exception_in_progress_ends_an_identification(logs: tuple[Path, Path]) -> None:
    def progress(what: str, best: float) -> None:
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        tr.identify(short(logs[0]), "aero2", fix=FIX, window=2.0, progress=progress)


@pytest.mark.parametrize("scenario", [None, "step"])
def test_a_replay(host_sim: Run, logs: tuple[Path, Path], scenario: str | None) -> None:
    wanted = [] if scenario is None else ["--scenario", scenario]
    folder = host_sim("replay", str(logs[1]), "--preset", "aero2", "--gains", GAINS, *wanted, "--json")
    document = json.loads((folder / "stdout").read_text())
    found = tr.replay(logs[1], "aero2", scenario=scenario)
    assert {name: document[name] for name in found.report} == found.report
    assert found.notes == document["notes"]
    # The arrays are what the numbers are of.
    assert found.time[0] == 0.0 and found.time.shape == (9_001,)
    error = np.sqrt(np.mean((found.rate - found.smoothed) ** 2, axis=0))
    assert np.allclose(error, list(document["rate_error"].values()), rtol=1e-12)
    assert found.ours is not None
    difference = np.sqrt(np.mean((found.ours - found.volts) ** 2, axis=0))
    assert np.allclose(difference, list(document["volts_difference"].values()), rtol=1e-12)


def test_a_law_that_is_told_nothing_is_not_asked(logs: tuple[Path, Path]) -> None:
    log = {name: column for name, column in short(logs[0]).items() if not name.startswith("ref")}
    assert tr.replay(log, "aero2").ours is None
    asked = tr.replay(short(logs[0]), "aero2")
    assert asked.ours is not None and np.isfinite(asked.ours).all()


@pytest.mark.parametrize(
    ("changed", "options", "told"),
    [
        ({"v1": [0.0]}, {}, "length of column 'v1' is 1; allowed: 6000"),
        ({"v1": ["text"]}, {}, "column 'v1' is no array of numbers: could not convert"),
        ({"v1": [[0.0]]}, {}, "dimensions of column 'v1' is 2; allowed: 1"),
        ({"pitch": np.full(6_000, np.nan)}, {}, "pitch"),
        ({}, {"free": ["inertia.rol"]}, "free is 'inertia.rol'; allowed: "),
        ({}, {"window": 0.1}, "window is 0.1; allowed: a finite number of at least 0.2"),
        ({}, {"population": 1}, "population is 1; allowed: 2 to 10000"),
        ({}, {"iterations": 100_001}, "iterations is 100001; allowed: 0 to 100000"),
        ({}, {"rotor_lag": -1.0}, "rotor_lag is -1; allowed"),
        ({}, {"columns": "pitch=theta:yd"}, "unknown unit"),
    ],
)
def test_a_wrong_log_is_a_value_error(
    logs: tuple[Path, Path], changed: dict[str, Any], options: dict[str, Any], told: str
) -> None:
    with pytest.raises(ValueError, match=r".") as raised:
        tr.identify({**short(logs[0]), **changed}, "aero2", **options)
    assert told in str(raised.value)


def test_no_log_and_no_such_log_are_value_errors() -> None:
    with pytest.raises(ValueError, match="logs is empty; allowed: at least one"):
        tr.identify([], "aero2")
    with pytest.raises(ValueError, match=r"nowhere\.csv"):
        tr.replay("nowhere.csv", "aero2")
