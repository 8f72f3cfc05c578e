"""How fast many environments fly, beside Gymnasium's CartPole and the same plant in NumPy.

    python benches/batch.py --count 16384

Prints environment steps a second (20 ms each), ticks of a rig a second (20 to a step), and the same for each
second of processor time: where others use the processors too, compare that.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
import twinrotor as tr

TICKS = 20
Array = npt.NDArray[np.float32]


class Loop:
    """Aero 2 plants as :class:`twinrotor.Batch` has them, one number of all plants in a NumPy array each:
    rotor lag exactly, the body by Runge-Kutta 4, a tick of 1 ms. Without compensated sums and PWM steps."""

    def __init__(self, count: int) -> None:
        plant = tr.Rig.of("aero2").constants["plant"]
        full = np.ones(count, np.float32)
        self.thrust = [[np.float32(plant["effectiveness"][f"{m}_on_{a}"]) * full for m in ("main", "tail")]
                       for a in ("pitch", "yaw")]  # fmt: skip
        self.inertia = [np.float32(plant["inertia"][a]) * full for a in ("pitch", "yaw")]
        self.damping = [np.float32(plant["damping"][a]) * full for a in ("pitch", "yaw")]
        self.stiffness = np.float32(plant["stiffness"]) * full
        self.decay = np.float32(np.exp(-0.5e-3 / plant["rotor_time_constant"]["main"]))
        self.state = np.zeros((4, count), np.float32)
        self.volts = np.zeros((2, count), np.float32)
        assert plant["center_of_mass"] == 0.0, "or the equations have more terms"

    def change(self, state: Array, torque: list[Array]) -> Array:
        pitch = (torque[0] - self.damping[0] * state[2] - self.stiffness * np.sin(state[0])) / self.inertia[0]
        return np.stack(
            [state[2], state[3], pitch, (torque[1] - self.damping[1] * state[3]) / self.inertia[1]]
        )

    def torque(self) -> list[Array]:
        return [row[0] * self.volts[0] + row[1] * self.volts[1] for row in self.thrust]

    def fly(self, volts: Array) -> None:
        step = np.float32(1e-3)
        for _ in range(TICKS):
            begin = self.torque()
            self.volts = volts + (self.volts - volts) * self.decay
            middle = self.torque()
            self.volts = volts + (self.volts - volts) * self.decay
            k1 = self.change(self.state, begin)
            k2 = self.change(self.state + k1 * (step / 2), middle)
            k3 = self.change(self.state + k2 * (step / 2), middle)
            k4 = self.change(self.state + k3 * step, self.torque())
            self.state = self.state + (k1 + np.float32(2.0) * (k2 + k3) + k4) * (step / 6)


def rate(work: Callable[[], object], count: int, seconds: float) -> tuple[float, float]:
    """Environment steps for each second by the clock and of processor time, the best of five stretches."""
    best = (0.0, 0.0)
    work()
    for _ in range(5):
        clock, processor, steps = time.perf_counter(), time.process_time(), 0
        while time.perf_counter() - clock < seconds / 5:
            work()
            steps += count
        found = steps / (time.perf_counter() - clock), steps / (time.process_time() - processor)
        best = max(best[0], found[0]), max(best[1], found[1])
    return best


def same_plant(count: int = 32) -> float:
    """How far (rad) both plants are from one another after 2 s of the same volts."""
    batch = tr.Batch("aero2", count, spread=False)
    batch.begin(1)
    loop, rng = Loop(count), np.random.default_rng(1)
    given = rng.uniform(-0.3, 0.3, (count, 2)).astype(np.float32)
    for _ in range(100):
        seen = batch.fly(given).observations
        loop.fly(given.T * np.float32(18.0))
    return float(np.abs(seen[:, :2].T - loop.state[:2]).max())


def measure(count: int, seconds: float, threads: int | None) -> dict[str, tuple[float, float]]:
    rng = np.random.default_rng(1)
    given = rng.uniform(-0.2, 0.2, (count, 2)).astype(np.float32)
    found: dict[str, tuple[float, float]] = {}

    def batch(action: Any, number: int, supervised: bool = True) -> tuple[float, float]:
        batch = tr.Batch("aero2", number, action=action, supervised=supervised, threads=threads)
        batch.begin(1)
        return rate(lambda: batch.fly(given[:number]), number, seconds)

    found["Batch, volts"] = batch("volts", count)
    few = max(1, count // 16)
    found["Batch, setpoints, supervised"] = batch("setpoint", few)
    found["Batch, setpoints"] = batch("setpoint", few, False)
    pole = gymnasium.make_vec("CartPole-v1", num_envs=count, vectorization_mode="vector_entry_point")
    pole.reset(seed=1)
    choices = rng.integers(0, 2, count)
    found["Gymnasium's CartPole"] = rate(lambda: pole.step(choices), count, seconds)
    loop, volts = Loop(count), given.T * np.float32(18.0)
    found["the plant in NumPy"] = rate(lambda: loop.fly(volts), count, seconds)
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=16_384)
    parser.add_argument("--seconds", type=float, default=5.0, help="for each")
    parser.add_argument("--threads", type=int, default=None)
    arguments = parser.parse_args()
    print(f"both plants differ by {same_plant():.1e} rad after 2 s")
    found = measure(arguments.count, arguments.seconds, arguments.threads)
    base = found["Batch, volts"]
    print(f"{'':30}{'env steps/s':>12}{'rig ticks/s':>13}{'steps/s of processor':>22}{'Batch/it':>10}")
    for name, (clock, processor) in found.items():
        ticks = f"{clock * TICKS:13.2e}" if "CartPole" not in name else " " * 13
        print(f"{name:30}{clock:12.2e}{ticks}{processor:22.2e}{base[1] / processor:10.1f}")
