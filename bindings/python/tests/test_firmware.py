"""The loop in Python beside the firmware itself: a flight that was recorded on the virtual board.

``tests/virtual-board/tests/firmware/recorded.rs`` flies it and writes it down.
"""

import csv
import struct

import pytest
import twinrotor as tr
from conftest import ROOT

FLIGHT = ROOT / "target" / "telemetry" / "aero2.csv"
TICKS = 60_000
PAIRS = ["angle", "rate", "disturbance", "reference", "demand", "unallocated_torque", "volts"]
MOTORS = {"demand", "volts"}


def bits(number: object) -> str:
    """As the flight has them: those of an ``f32``."""
    assert isinstance(number, float)
    return struct.pack(">f", number).hex()


def number(digits: str) -> float:
    value: float = struct.unpack(">f", bytes.fromhex(digits))[0]
    return value


class Recorded:
    """A port at which the flight passes by."""

    def __init__(self, first: dict[str, str]) -> None:
        self.row = first
        self.given = (0.0, 0.0)

    def read(self) -> tuple[int, int, float]:
        return int(self.row["pitch"]), int(self.row["yaw"]), number(self.row["supply"])

    def write(self, volts: tuple[float, float], enabled: bool) -> None:
        self.given = volts if enabled else (0.0, 0.0)


def told(frame: dict[str, object]) -> dict[str, str]:
    """A frame's numbers by the flight's columns."""
    columns = {"told_supply": bits(frame["supply"])}
    for name in PAIRS:
        pair = frame[name]
        assert isinstance(pair, tuple)
        ends = ("main", "tail") if name in MOTORS else ("pitch", "yaw")
        columns |= {f"{name}_{end}": bits(value) for end, value in zip(ends, pair, strict=True)}
    return columns


@pytest.mark.skipif(
    not FLIGHT.exists(),
    reason="no flight of the virtual board is there; 'cargo fw', then 'cargo board-test recorded' make it",
)
def test_a_minute_of_ticks_is_the_firmwares() -> None:
    with FLIGHT.open() as file:
        rows = list(csv.DictReader(file))
    port = Recorded(rows[0])
    controller = tr.Controller(port, "aero2", counter_bits=16, checked=True)
    compared = armed = 0
    for tick, row in enumerate(rows):
        port.row = row
        if row["command"] == "zero":
            controller.loop.zero()
        elif row["command"] == "arm":
            controller.loop.request("arm")
        elif row["command"] == "aim":
            controller.loop.aim((number(row["aim_pitch"]), number(row["aim_yaw"])))
        state = controller.tick()
        if not row["told_supply"]:
            continue
        frame = told(controller.loop.frame())
        assert frame == {name: row[name] for name in frame}, tick
        compared += 1
        if state == "armed":
            assert [bits(volts) for volts in port.given] == [row["volts_main"], row["volts_tail"]], tick
            armed += 1
    assert armed >= TICKS and compared >= armed
