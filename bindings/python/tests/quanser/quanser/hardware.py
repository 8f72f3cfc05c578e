"""``quanser.hardware`` with a simulated rig behind it."""

from __future__ import annotations

from typing import Any

import numpy as np
import twinrotor as tr


class HIL:
    """A card; ``HIL.last`` is the newest."""

    last: HIL

    def __init__(self) -> None:
        HIL.last = self
        self.calls: list[str] = []
        self.volts = (0.0, 0.0)
        self.enabled = False
        self.watchdog: float | None = None
        self.is_open = False
        #: What happens in which read of the encoders.
        self.mishap: tuple[int, BaseException] | None = None
        self.reads = 0

    def open(self, card: str, identifier: str) -> None:
        assert card == "quanser_aero2_usb", card
        self.identifier = identifier
        self.bench = tr.Bench("aero2")
        self.is_open = True

    def read_encoder(self, channels: Any, count: int, counts: Any) -> None:
        assert self.is_open and list(channels) == [2, 3] and count == 2
        self.reads += 1
        if self.mishap is not None and self.reads == self.mishap[0]:
            raise self.mishap[1]
        self.bench.table = not self.enabled
        self.bench.tick(self.volts, self.enabled)
        counts[:] = np.array(self.bench.counts, dtype=np.int32)

    def write_analog(self, channels: Any, count: int, volts: Any) -> None:
        assert self.is_open and list(channels) == [0, 1] and count == 2
        main, tail = volts
        self.volts = (float(main), float(tail))

    def write_digital(self, channels: Any, count: int, values: Any) -> None:
        assert self.is_open and list(channels) == [0, 1] and count == 2
        self.enabled = bool(np.all(values))

    def watchdog_clear(self) -> None:
        self.calls.append("clear")

    def watchdog_set_analog_expiration_state(self, channels: Any, count: int, volts: Any) -> None:
        assert np.all(np.asarray(volts) == 0.0)
        self.calls.append("expiration")

    def watchdog_start(self, seconds: float) -> None:
        self.watchdog = seconds

    def watchdog_reload(self) -> None:
        assert self.watchdog is not None

    def watchdog_stop(self) -> None:
        self.watchdog = None

    def close(self) -> None:
        self.is_open = False
