"""The USB panel's example, against a stand-in for the manufacturer's library."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from conftest import is_off


@pytest.fixture
def aero(at_the_panel: Callable[[str], Any]) -> Any:
    return at_the_panel("aero_usb")


@pytest.mark.parametrize(("hardware", "identifier"), [(True, "0"), (False, "0@tcpip://localhost:18950")])
def test_it_flies_a_step_and_switches_off(aero: Any, hardware: bool, identifier: str) -> None:
    angles = aero.fly("aero2", None, hardware, 8.0)
    assert np.allclose(np.degrees(angles[-1]), [10.0, 30.0], atol=1.0)
    card = aero.HIL.last
    assert card.identifier == identifier and is_off(card) and card.calls == ["clear", "expiration"]


@pytest.mark.parametrize("mishap", [KeyboardInterrupt(), OSError("the cable"), MemoryError()])
@pytest.mark.parametrize("when", [1, 700, 400_000])
def test_whatever_ends_it_the_amplifiers_are_off(aero: Any, mishap: BaseException, when: int) -> None:
    opened = aero.HIL.open

    def fails(card: Any, *arguments: str) -> None:
        opened(card, *arguments)
        card.mishap = (when, mishap)

    aero.HIL.open = fails
    try:
        with pytest.raises(type(mishap)):
            aero.fly("aero2", None, True, 400.0)
    finally:
        aero.HIL.open = opened
    assert is_off(aero.HIL.last)


def test_a_late_loop_ends_the_flight(aero: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    ticks = iter(range(10**9))

    def now() -> float:
        tick = next(ticks)
        return tick * 1e-4 + (0.02 if tick > 50_000 else 0.0)

    monkeypatch.setattr(time, "perf_counter", now)
    monkeypatch.setattr(aero.time, "perf_counter", now)
    with pytest.raises(TimeoutError, match="ms late"):
        aero.fly("aero2", None, True, 400.0)
    assert is_off(aero.HIL.last)
