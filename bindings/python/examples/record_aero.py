"""Records an Aero or an Aero 2 at its USB panel, for ``host-sim identify``: no controller, no board of ours.

    python examples/record_aero.py --hardware 1 --out aero2.csv

It sends short pulses of volts, open loop, and writes what the encoders showed before each write, in the
columns and units that ``identify`` and ``replay`` read: ``t,pitch,yaw,v0,v1`` in s, rad, rad, V, V. The card
is that of ``aero_usb.py``, through Quanser's own library, and so is what ends a run: zero volts, amplifiers
off. It never met a real rig: it is tested against a stand-in. ``--hardware 0`` is Quanser's virtual rig. Put
the rig where pitch rests and yaw can turn, and keep a hand at the supply's switch.
"""

from __future__ import annotations

import argparse
import csv
import time
from pathlib import Path

import numpy as np
import twinrotor as tr
from aero_usb import CARDS, TICK, AeroUsb

#: s between two pulses, in which the rig swings out.
PAUSE = 2.0
#: Volts of the main and of the tail motor, for how long (s), and whether the same follows with the other
#: sign: short, since nothing holds the rig; of several sizes and signs, each motor alone and both together.
PULSES = [
    (6.0, 0.0, 0.25, False),
    (-9.0, 0.0, 0.25, False),
    (11.0, 0.0, 0.25, False),
    (0.0, 6.0, 0.6, False),
    (0.0, -9.0, 0.6, False),
    (0.0, 12.0, 0.6, False),
    (0.0, -12.0, 0.6, False),
    (6.0, 8.0, 0.3, True),
    (-10.0, 8.0, 0.3, True),
    (8.0, -12.0, 0.3, True),
]
#: rad of pitch, from where it rested; beyond it the run ends.
MOST_PITCH = np.radians(35.0)


def steps() -> list[tuple[float, float, float]]:
    """From when on (s) how many volts are sent; with the last of them it is over."""
    at, found = PAUSE / 2.0, [(0.0, 0.0, 0.0)]
    for main, tail, lasts, back in PULSES:
        for sign in (1.0, -1.0) if back else (1.0,):
            found.append((at, sign * main, sign * tail))
            at += lasts
        found.append((at, 0.0, 0.0))
        at += PAUSE
    return [*found, (at, 0.0, 0.0)]


def within(volts: float, most: float) -> float:
    """What the amplifier gives."""
    return max(-most, min(most, volts))


def record(preset: str, hardware: bool, scale: float = 1.0) -> list[list[float]]:
    """Rows of t, pitch, yaw, v0, v1; fewer if pitch went too far."""
    constants = tr.Rig.of(preset).constants
    turn, most = constants["encoder_counts"], constants["volts_limit"]
    course = steps()
    rows: list[list[float]] = []
    with AeroUsb(preset, hardware) as port:
        rest = port.read()
        begun = time.perf_counter()
        for _ in range(round(course[-1][0] / TICK)):
            counts = port.read()
            now = time.perf_counter() - begun
            pitch = 2.0 * np.pi * (counts[0] - rest[0]) / turn["pitch"]
            yaw = 2.0 * np.pi * (counts[1] - rest[1]) / turn["yaw"]
            if abs(pitch) > MOST_PITCH:
                break
            # The row's own: what is sent after it was read, and stays until the next.
            _, main, tail = max(step for step in course if step[0] <= now)
            volts = (within(scale * main, most["main"]), within(scale * tail, most["tail"]))
            port.write(volts, True)
            rows.append([now, float(pitch), float(yaw), *volts])
    return rows


def save(rows: list[list[float]], path: Path) -> None:
    """As CSV with the names that are read without ``--columns``."""
    with path.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["t", "pitch", "yaw", "v0", "v1"])
        table.writerows([f"{value:.6f}" for value in row] for row in rows)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--preset", default="aero2", choices=sorted(CARDS))
    parser.add_argument("--hardware", type=int, default=0, choices=[0, 1])
    parser.add_argument("--scale", type=float, default=1.0, help="all volts by this; begin with .5")
    parser.add_argument("--out", type=Path, default=Path("aero.csv"))
    arguments = parser.parse_args()
    recorded = record(arguments.preset, bool(arguments.hardware), arguments.scale)
    save(recorded, arguments.out)
    print(f"{arguments.out}: {len(recorded)} rows, {recorded[-1][0] if recorded else 0.0:.1f} s")
