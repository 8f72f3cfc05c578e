"""The recorder of an Aero at its USB panel, against a stand-in for the manufacturer's library."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import twinrotor as tr
from conftest import is_off


@pytest.fixture
def recorder(at_the_panel: Callable[[str], Any]) -> Any:
    return at_the_panel("record_aero")


def off() -> bool:
    return is_off(sys.modules["aero_usb"].HIL.last)


def test_a_recording_tells_the_rig(recorder: Any, tmp_path: Path) -> None:
    rows = np.array(recorder.record("aero2", True))
    assert off() and rows[-1, 0] == pytest.approx(recorder.steps()[-1][0], abs=0.01)
    assert np.abs(rows[:, 1]).max() > np.radians(5.0) and np.abs(rows[:, 2]).max() > np.radians(20.0)
    path = tmp_path / "aero2.csv"
    recorder.save(rows.tolist(), path)
    assert path.read_text().startswith("t,pitch,yaw,v0,v1\n")
    held = ["rotor_reaction", "quadratic_effectiveness", "coulomb_friction", "rotor_time_constant"]
    found = tr.identify(path, "aero2", fix=held, population=2, iterations=0)
    assert not [note for note in found.notes if "resampled" not in note], found.notes
    for constant in found.constants:
        if abs(constant.preset) > 0.0 and not constant.at_bound:
            assert constant.value == pytest.approx(constant.preset, rel=0.1), constant.name


def test_it_ends_where_pitch_goes_too_far(recorder: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recorder, "PULSES", [(9.0, 0.0, 5.0, False)])
    rows = np.array(recorder.record("aero2", True, scale=5.0))
    assert off() and rows[-1, 0] < recorder.steps()[-1][0] - 1.0
    # What was sent, behind the limit.
    assert np.abs(rows[:, 3]).max() == 18.0
    assert np.abs(rows[:, 1]).max() <= recorder.MOST_PITCH


@pytest.mark.parametrize("mishap", [KeyboardInterrupt(), OSError("the cable")])
def test_whatever_ends_it_the_amplifiers_are_off(recorder: Any, mishap: BaseException) -> None:
    hil = sys.modules["aero_usb"].HIL
    opened = hil.open

    def fails(card: Any, *arguments: str) -> None:
        opened(card, *arguments)
        card.mishap = (9_000, mishap)

    hil.open = fails
    try:
        with pytest.raises(type(mishap)):
            recorder.record("aero2", True)
    finally:
        hil.open = opened
    assert off()
