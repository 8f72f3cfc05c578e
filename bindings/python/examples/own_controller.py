"""A controller of one's own, in Python, beside the board's on plants that neither has seen.

    python examples/own_controller.py --plants 20

Both fly from level to 15° and 40° with encoders, rotor lag and PWM steps, and a volt of disturbance on each
motor. The table has the median over the plants of the error (degrees, RMS) in the last second, and how many
plants were lost.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import twinrotor as tr

Array = npt.NDArray[np.float64]
Law = Callable[[tr.Bench], tuple[float, float]]
PRESET = "aero2"
GOAL = np.radians([15.0, 40.0])
#: rad; of the Aero 2's encoders.
COUNT = 2.0 * np.pi / np.array([2880.0, 4096.0])
TICK = 1e-3
#: V.
LIMIT = 18.0
#: ms that a rig lies still before it is zeroed.
REST = 1_600


def state_feedback() -> Law:
    """LQR of the linear plant, by its discrete Riccati equation; rates are filtered differences."""
    linear = tr.linearize(PRESET)
    a = np.eye(len(linear.a)) + TICK * linear.a
    b = TICK * linear.b
    cost, effort = np.diag([200.0, 100.0, 20.0, 20.0, 0.0, 0.0]), 0.02 * np.eye(2)
    p = cost
    for _ in range(20_000):
        gain = np.linalg.solve(effort + b.T @ p @ b, b.T @ p @ a)
        p = cost + a.T @ p @ (a - b @ gain)
    before, rate, rotors = np.zeros(2), np.zeros(2), np.zeros(2)
    tick = 0

    def control(bench: tr.Bench) -> tuple[float, float]:
        nonlocal before, rate, rotors, tick
        angle = np.array(bench.counts) * COUNT
        rate = rate + 0.02 * ((angle - before) / TICK - rate)
        before = angle
        tick += 1
        if tick <= REST:
            return 0.0, 0.0
        volts = np.clip(-gain @ np.concatenate([angle - GOAL, rate, rotors]), -LIMIT, LIMIT)
        rotors = rotors + TICK * (linear.a[4:, 4:] @ rotors + linear.b[4:] @ volts)
        return float(volts[0]), float(volts[1])

    return control


def boards() -> Law:
    """The loop that the firmware runs; it believes in the preset, whatever it flies."""
    loop = tr.ControlLoop(PRESET, counter_bits=16, checked=True)
    tick = 0

    def control(bench: tr.Bench) -> tuple[float, float]:
        nonlocal tick
        if tick == REST:
            loop.zero()
        elif tick == REST + 5:
            loop.request("arm")
        elif tick == REST + 10:
            loop.aim((float(GOAL[0]), float(GOAL[1])))
        tick += 1
        return loop.tick(*bench.counters, bench.supply)

    return control


def fly(rig: tr.Rig, law: Law, seconds: float = 12.0) -> float | None:
    """Error in the last second, degrees RMS; ``None`` where the rig is lost."""
    bench = tr.Bench(rig)
    squares = 0.0
    for tick in range(REST + round(seconds / TICK)):
        if tick == REST:
            bench.disturbance = (1.0, -1.0)
        # Until then it lies on its table.
        bench.table = tick < REST
        bench.tick(law(bench))
        angle = np.array(bench.state[0])
        if abs(angle[0]) > np.radians(60.0):
            return None
        if tick >= REST + round((seconds - 1.0) / TICK):
            squares += TICK * float(np.sum((angle - GOAL) ** 2))
    return float(np.degrees(np.sqrt(squares)))


def compare(plants: int) -> dict[str, tuple[float, int]]:
    """For each law the median error and the plants that were lost."""
    rigs = tr.draw(PRESET, plants, seed=1_000_001)
    found = {}
    for name, law in (("state feedback", state_feedback), ("the board's", boards)):
        errors = [fly(rig, law()) for rig in rigs]
        kept = [error for error in errors if error is not None]
        found[name] = (float(np.median(kept)) if kept else float("nan"), len(errors) - len(kept))
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--plants", type=int, default=20)
    for name, (error, lost) in compare(parser.parse_args().plants).items():
        print(f"{name:15} {error:8.3f}° {lost:4} lost")
