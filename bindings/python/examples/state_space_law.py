"""An LQG regulator with integrals for the Aero 2, designed here and written as a gains file of matrices.

    python examples/state_space_law.py --out lqg.toml
    cargo run --release -p host-sim compare --preset aero2 --controllers lqg.toml

Six states are an observer of the error (angles, rates, what the rotors give), two are integrals of both angle
errors. Volts are around what the model needs at the reference, which the board feeds forward. `gains_file` is
all that another design needs, whatever made its matrices.
"""

from __future__ import annotations

import argparse
import pathlib

import numpy as np
import numpy.typing as npt
import twinrotor as tr

Array = npt.NDArray[np.float64]
#: s; a law of matrices is sampled at the board's tick.
TICK = 1e-3
#: s; how soon an integral is led back to what the motors give.
TRACKING = 0.3

#: What stands around the law: the filter and the allocation of the preset's own gains.
SURROUNDINGS = """
[filter.bandwidth]
pitch = 2.482447213223025
yaw = 2.3798624193136217

[filter.damping]
pitch = 0.9114947417489543
yaw = 1.1348313042524403

[filter.advance]
pitch = 0.16
yaw = 0.16

[filter.reach]
pitch = 0.2617993877991494
yaw = 0.6981317007977318
"""


def sampled(a: Array, b: Array) -> tuple[Array, Array]:
    """Zero-order hold, as MATLAB's ``c2d`` has it: the exponential of both, by its series."""
    n, m = b.shape
    both = np.zeros((n + m, n + m))
    both[:n, :n], both[:n, n:] = TICK * a, TICK * b
    power = total = np.eye(n + m)
    for k in range(1, 20):
        power = power @ both / k
        total = total + power
    return total[:n, :n], total[:n, n:]


def riccati(a: Array, b: Array, q: Array, r: Array) -> Array:
    """The gain K of u = -K x, by its iteration to a standstill."""
    p: Array = q
    gain: Array = np.zeros((b.shape[1], a.shape[0]))
    for _ in range(200_000):
        new: Array = np.asarray(np.linalg.solve(r + b.T @ p @ b, b.T @ p @ a), dtype=np.float64)
        if np.allclose(new, gain, rtol=1e-12, atol=0.0):
            break
        gain, p = new, q + a.T @ p @ (a - b @ new)
    return gain


def lqg(a: Array, b: Array, c: Array) -> tuple[Array, Array, Array, Array, Array]:
    """(A, B, C, D, L) of the regulator: angle errors in, volts out."""
    a, b = sampled(a, b)
    n = len(a)
    # With the integrals of both errors.
    wide = np.block([[a, np.zeros((n, 2))], [TICK * c, np.eye(2)]])
    weights = np.diag([3000.0, 1500.0, 200.0, 60.0, 0.0, 0.0, 2e4, 6e3])
    gain = riccati(wide, np.vstack([b, np.zeros((2, 2))]), weights, np.diag([0.05, 0.05]))
    proportional, integral = gain[:, :n], gain[:, n:]
    # A disturbance of volts, and encoders that are right to a third of a count.
    count = 2.0 * np.pi / np.array([2880.0, 4096.0])
    noise = b @ (25.0 * np.eye(2)) @ b.T + 1e-9 * np.eye(n)
    correction = riccati(a.T, c.T, noise, np.diag((count / 3.0) ** 2)).T
    regulator = np.block(
        [
            [a - b @ proportional - correction @ c, -b @ integral],
            [np.zeros((2, n)), np.eye(2)],
        ]
    )
    inputs = np.vstack([correction, TICK * np.eye(2)])
    outputs = np.hstack([proportional, integral])
    # The observer is told the volts that the motors got, and the integrals follow them.
    given = np.vstack([-b, TICK / TRACKING * np.linalg.inv(integral)])
    return regulator, inputs, outputs, np.zeros((2, 2)), given


def matrix(name: str, value: Array) -> str:
    """A line of a gains file."""
    rows = ", ".join("[" + ", ".join(repr(float(x)) for x in row) + "]" for row in np.atleast_2d(value))
    return f"{name} = [{rows}]"


def gains_file(a: Array, b: Array, c: Array, d: Array, anti_windup: Array | None, inputs: list[str]) -> str:
    """The text of a gains file with this law."""
    names = ", ".join(f'"{name}"' for name in inputs)
    lines = [
        'controller = "state-space"',
        "",
        "[state-space]",
        f"inputs = [{names}]",
        'outputs = ["volts.main", "volts.tail"]',
        f"sample_time = {TICK}",
        *(matrix(*pair) for pair in [("A", a), ("B", b), ("C", c), ("D", d)]),
        "feed_forward = true",
        'anti_windup = "hold"' if anti_windup is None else matrix("anti_windup", anti_windup),
    ]
    return "\n".join(lines) + "\n" + SURROUNDINGS


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--preset", default="aero2", help="rig to design for")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("lqg.toml"), help="file to write")
    arguments = parser.parse_args()
    linear = tr.linearize(arguments.preset)
    law = lqg(linear.a, linear.b, linear.c)
    text = gains_file(*law, inputs=["angle_error.pitch", "angle_error.yaw"])
    arguments.out.write_text(text, encoding="ascii")
    poles = np.abs(np.linalg.eigvals(law[0]))
    print(f"{arguments.out}: {len(law[0])} states, largest pole of the law by itself {poles.max():.6f}")


if __name__ == "__main__":
    main()
