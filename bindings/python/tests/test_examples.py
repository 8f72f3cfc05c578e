"""The examples, short, and what they show."""

import importlib
import sys
from pathlib import Path
from typing import Any

import pytest
import twinrotor as tr

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


@pytest.fixture(autouse=True)
def _examples(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(EXAMPLES))


def example(name: str) -> Any:
    sys.modules.pop(name, None)
    return importlib.import_module(name)


def test_the_boards_controller_holds_against_a_disturbance_that_plain_feedback_does_not() -> None:
    found = example("own_controller").compare(3)
    assert found["the board's"][0] < 0.2 < found["state feedback"][0]
    assert found["the board's"][1] == found["state feedback"][1] == 0


def test_a_policy_is_learned_and_ranked() -> None:
    learning = example("learn_policy")
    found = learning.rank(learning.learn(12), plants=40)
    better = found["learned"] > found["zero volts"]
    assert better.mean() > 0.9, "on nearly every plant that it has not seen"


def test_a_rig_is_identified_from_its_log_and_tuned_for() -> None:
    whole = example("identify_and_tune")
    found, table = whole.run(seed=5, plants=16, iterations=12)
    truth = tr.draw("aero2", 1, seed=5)[0].constants["plant"]

    def gain(plant: dict[str, Any], by: str, axis: str) -> float:
        """Acceleration for a volt: what a log tells, which tells neither thrust nor inertia alone."""
        return float(plant["effectiveness"][f"{by}_on_{axis}"] / plant["inertia"][axis])

    for by, axis in (("main", "pitch"), ("tail", "pitch"), ("main", "yaw"), ("tail", "yaw")):
        told = gain(found.rig.constants["plant"], by, axis)
        assert abs(told / gain(truth, by, axis) - 1.0) < 0.05, (by, axis)
    assert table["tuned"][0] < table["the preset's"][0]


def test_the_readmes_lines_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = (EXAMPLES.parent / "README.md").read_text()
    blocks = [block.split("```")[0] for block in text.split("```python\n")[1:]]
    assert len(blocks) >= 4
    names: dict[str, Any] = {}
    for block in blocks:
        exec(compile(block, "README.md", "exec"), names)
    assert (tmp_path / "gains.toml").exists() and (tmp_path / "my.toml").exists()
