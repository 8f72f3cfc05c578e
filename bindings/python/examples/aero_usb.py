"""Flies an Aero or an Aero 2 at its USB panel with the board's loop, through Quanser's own Python library.

    python examples/aero_usb.py --hardware 1

``--hardware 0`` (the default) is Quanser's virtual rig on this computer. It never met a real one: it is
tested against a stand-in with the same calls (``tests/quanser``). Keep a hand at the supply's switch.

Whatever ends it, an exception, Ctrl-C, a late loop: zero volts, amplifiers off. Where this program itself
dies, the card's own watchdog does the same after 50 ms.
"""

from __future__ import annotations

import argparse
import time
from types import TracebackType
from typing import Self

import numpy as np
import twinrotor as tr
from quanser.hardware import HIL

#: s between two ticks.
TICK = 1e-3
#: s that a tick may be late; then the flight ends.
LATE = 5e-3
#: s after which the card switches off by itself.
WATCHDOG = 0.05
MOTORS = np.array([0, 1], dtype=np.uint32)
#: Pitch and yaw; 0 and 1 are the motors'.
ENCODERS = np.array([2, 3], dtype=np.uint32)
CARDS = {"aero": "quanser_aero_usb", "aero-lab": "quanser_aero_usb", "aero2": "quanser_aero2_usb"}
VIRTUAL = "@tcpip://localhost:18950"


class AeroUsb:
    """Encoders and amplifiers of an Aero at its USB panel: a port, once a millisecond."""

    def __init__(self, preset: str, hardware: bool, identifier: str = "0") -> None:
        supply = tr.Rig.of(preset).constants["supply"]
        self.supply = float(supply["nominal"])
        self.counts = np.zeros(2, dtype=np.int32)
        self.enabled = False
        self.card = HIL()
        self.card.open(CARDS[preset], identifier if hardware else identifier + VIRTUAL)
        try:
            self._switch(False)
            self.card.watchdog_clear()
            self.card.watchdog_set_analog_expiration_state(MOTORS, 2, np.zeros(2))
            self.card.watchdog_start(WATCHDOG)
        except BaseException:
            self.card.close()
            raise
        self.due = time.perf_counter()

    def read(self) -> tuple[int, int, float]:
        """Waits for the next millisecond.

        :raises TimeoutError: if it is long gone.
        """
        self.due += TICK
        now = time.perf_counter()
        if now > self.due + LATE:
            raise TimeoutError(f"a tick came {1e3 * (now - self.due):.1f} ms late: this computer is too busy")
        while time.perf_counter() < self.due:
            pass
        self.card.read_encoder(ENCODERS, 2, self.counts)
        return int(self.counts[0]), int(self.counts[1]), self.supply

    def write(self, volts: tuple[float, float], enabled: bool) -> None:
        self.card.write_analog(MOTORS, 2, np.array(volts if enabled else (0.0, 0.0)))
        if enabled != self.enabled:
            self._switch(enabled)
        self.card.watchdog_reload()

    def _switch(self, on: bool) -> None:
        self.card.write_digital(MOTORS, 2, np.full(2, int(on), dtype=np.int8))
        self.enabled = on

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        try:
            self.card.write_analog(MOTORS, 2, np.zeros(2))
        finally:
            try:
                self._switch(False)
            finally:
                self.card.watchdog_stop()
                self.card.close()


def fly(preset: str, gains: str | None, hardware: bool, seconds: float) -> np.ndarray:
    """A step of 10° and 30°; angles (rad) tick by tick."""
    angles = []
    with AeroUsb(preset, hardware) as port, tr.Controller(port, preset, gains) as controller:
        print("let the rig rest; the first-power check pushes it a little")
        controller.prepare()
        controller.arm()
        controller.loop.aim((0.0, 0.0))
        controller.run(2_000)
        controller.loop.aim((np.radians(10.0), np.radians(30.0)))
        for _ in range(round(seconds / TICK)):
            controller.run(1)
            angles.append(controller.loop.frame()["angle"])
        controller.loop.aim((0.0, 0.0))
        controller.run(2_000)
    return np.array(angles)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--preset", default="aero2", choices=sorted(CARDS))
    parser.add_argument("--gains", help="a gains file [default: the preset's own]")
    parser.add_argument("--hardware", type=int, default=0, choices=[0, 1])
    parser.add_argument("--seconds", type=float, default=6.0)
    arguments = parser.parse_args()
    flown = fly(arguments.preset, arguments.gains, bool(arguments.hardware), arguments.seconds)
    print("at the end: {:.2f}° of pitch, {:.2f}° of yaw".format(*np.degrees(flown[-1])))
