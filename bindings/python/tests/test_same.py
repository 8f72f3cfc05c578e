"""What Python computes is what the command line computes, to the last bit."""

import dataclasses
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import twinrotor as tr
from conftest import ROOT, columns

Run = Callable[..., Path]


@pytest.mark.parametrize(
    ("preset", "gains", "scenario", "fidelity", "seed"),
    [
        ("paper", "paper", "step", "ideal", 1),
        ("paper", "paper", "3", "rig", 7),
        ("aero2", str(ROOT / "gains" / "aero2.toml"), "2", "rig", 1),
        ("aero2", str(ROOT / "gains" / "aero2.toml"), str(ROOT / "scenarios" / "gusts.toml"), "rig", 3),
        ("heli", str(ROOT / "gains" / "heli.toml"), str(ROOT / "scenarios" / "reversals.toml"), "rig", 2),
    ],
)
def test_a_flight(host_sim: Run, preset: str, gains: str, scenario: str, fidelity: str, seed: int) -> None:
    flags = f"simulate --preset {preset} --gains {gains} --scenario {scenario} --fidelity {fidelity}"
    folder = host_sim(*flags.split(), "--seed", str(seed), "--csv", "flight.csv", "--json")
    flown = tr.simulate(preset, gains, scenario, fidelity=fidelity, seed=seed)  # type: ignore[arg-type]
    written = columns(folder / "flight.csv")
    assert list(written) == list(flown.columns)
    for name, column in written.items():
        assert np.array_equal(flown[name], column), name
    document = json.loads((folder / "stdout").read_text())
    assert {name: document[name] for name in flown.report} == flown.report


def test_a_flight_of_another_rig_than_is_believed(host_sim: Run, tmp_path: Path) -> None:
    truth = tr.draw("aero2", 1, seed=5)[0]
    truth.save(tmp_path / "truth.toml")
    gains = str(ROOT / "gains" / "aero2.toml")
    flags = f"simulate --preset aero2 --gains {gains} --fidelity rig --true-rig {tmp_path}/truth.toml"
    folder = host_sim(*flags.split(), "--csv", "flight.csv")
    flown = tr.simulate("aero2", gains, fidelity="rig", true_rig=truth)
    assert np.array_equal(flown["theta"], columns(folder / "flight.csv")["theta"])
    assert not np.array_equal(flown["theta"], tr.simulate("aero2", gains, fidelity="rig")["theta"])


@pytest.mark.parametrize(("algorithm", "seed"), [("fpa-paper", 1), ("fpa-adaptive", 5), ("cmaes", 2)])
def test_gains_of_a_search(host_sim: Run, algorithm: str, seed: int) -> None:
    folder = host_sim("tune", "--algorithm", algorithm, "--seed", str(seed), "--iterations", "6", "--json")
    tuned = tr.tune(algorithm=algorithm, seed=seed, iterations=6)
    assert tuned.gains.toml == (folder / "gains.toml").read_text()
    assert tuned.history[-1][1] == tuned.cost
    told = json.loads((folder / "stdout").read_text())["at_bounds"]
    assert [dataclasses.asdict(end) for end in tuned.at_bounds] == told


def test_a_search_that_its_bounds_hold_back_says_so() -> None:
    held = tr.tune(bounds=(1.0, 5.0), population=12, iterations=12)
    assert held.at_bounds and {(end.side, end.bound) for end in held.at_bounds} == {("most", 5.0)}


def test_gains_of_a_robust_search(host_sim: Run) -> None:
    flags = (
        "tune --preset aero2 --objective robust --scenes step --algorithm fpa-paper --plants 4 --rounds 2"
        " --population 6 --iterations 2 --seed 3"
    )
    folder = host_sim(*flags.split(), "--at-most", "overshoot_p95.yaw=2")
    tuned = tr.tune_robust(
        "aero2", plants=4, rounds=2, population=6, iterations=2, seed=3, at_most={"overshoot_p95.yaw": 2}
    )
    assert tuned.gains.toml == (folder / "gains.toml").read_text()


def test_a_comparison(host_sim: Run) -> None:
    flags = "compare --preset aero2 --plants 24 --seed 4 --controllers paper --json"
    folder = host_sim(*flags.split(), "--gains", str(ROOT / "gains"))
    rows = {row["name"]: row for row in json.loads((folder / "stdout").read_text())["controllers"]}
    found = tr.compare("aero2", {"ours": None, "paper": "paper"}, plants=24, seed=4)
    for name, comparison in found.items():
        for number in ("failures", "J", "cost", "settling_p95", "hold_rms_deg", "p_value"):
            assert comparison.row[number] == rows[name][number], (name, number)
    costs = found["ours"].costs
    assert costs.shape == (24,)
    assert np.isclose(found["ours"].total, costs.mean() + 0.5 * np.quantile(costs, 0.9))


@pytest.mark.parametrize(
    ("preset", "gains", "rotor_lag"),
    [("paper", "paper", None), ("aero2", str(ROOT / "gains" / "aero2.toml"), None), ("heli", "paper", 0.05)],
)
def test_margins(host_sim: Run, preset: str, gains: str, rotor_lag: float | None) -> None:
    lag = [] if rotor_lag is None else ["--rotor-lag", str(rotor_lag)]
    folder = host_sim("margins", "--preset", preset, "--gains", gains, *lag, "--json")
    document = json.loads((folder / "stdout").read_text())
    found = tr.margins(preset, gains, rotor_lag=rotor_lag)
    for name in ("thrust", "lag", "inertia"):
        assert list(getattr(found, name)) == document[name]
    assert (found.delay_ms, found.slowest_pole) == (document["delay_ms"], document["slowest_pole"])


def test_margins_are_those_of_the_presets_own_gains() -> None:
    assert tr.margins("aero2") == tr.margins("aero2", ROOT / "gains" / "aero2.toml")
    assert tr.margins("aero2") != tr.margins("aero2", "paper")


def test_presets_gains_and_settings_are_the_engines() -> None:
    assert set(tr.presets()) == {"paper", "paper-fixed", "aero", "aero2", "aero-lab", "heli"}
    own = tr.Gains.of_preset("aero2").values
    file = tr.Gains.load(ROOT / "gains" / "aero2.toml").values
    assert {k: v for k, v in file.items() if k != "provenance"} == own
    # Its text is a rig as well as its name is.
    rig = tr.Rig.of("aero2")
    assert tr.Rig(name="mine", toml=rig.toml).constants == rig.constants
    table = (ROOT / "docs" / "settings.md").read_text()
    for setting in tr.settings():
        assert setting.explanation.split(";")[0][:30] in table, setting


def test_drawn_rigs_are_the_objectives() -> None:
    drawn = tr.draw("aero2", 3, seed=9)
    again = tr.draw("aero2", 2, seed=9)
    assert [rig.toml for rig in drawn[:2]] == [rig.toml for rig in again]
    nominal = tr.Rig.of("aero2").constants["plant"]["inertia"]["pitch"]
    factors = [rig.constants["plant"]["inertia"]["pitch"] / nominal for rig in drawn]
    assert all(0.7 <= factor <= 1.3 for factor in factors) and len(set(factors)) == 3
