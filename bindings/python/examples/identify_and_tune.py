"""From a log to gains: identify a rig, tune for what was found, and fly both sets of gains on the rig.

    python examples/identify_and_tune.py

The "rig" is an Aero 2 drawn from within its tolerances; the program knows only its log, as its encoders and
its board would have written it. The table has each controller's J on plants drawn around what was found, and
the error (degrees, RMS) of pitch and yaw when it flies the rig itself through a scenario that neither the
identification nor the tuning has seen. The search is short: for gains that are kept, give it 48 plants and
60 iterations.
"""

from __future__ import annotations

import argparse

import numpy as np
import twinrotor as tr

PRESET = "aero2"
EXCITE = """
duration = 20.0
[pitch.steps]
jumps = [[1, 20], [6, -15], [11, 10], [15, 25]]
[yaw.steps]
jumps = [[3, 60], [8, -30], [13, 40], [17, 0]]
"""
#: What so short a log does not tell.
FIX = ("quadratic_effectiveness", "rotor_reaction", "coulomb_friction")


def error(preset: tr.RigLike, gains: tr.Gains, truth: tr.Rig) -> tuple[float, float]:
    """Of a flight of the rig by a controller that believes in ``preset``."""
    flight = tr.simulate(preset, gains, "2", fidelity="rig", duration=20.0, true_rig=truth)
    wanted = np.column_stack([flight["theta_ref"], flight["psi_ref"]])
    pitch, yaw = np.degrees(np.sqrt(np.mean((flight.angle - wanted) ** 2, axis=0)))
    return float(pitch), float(yaw)


def run(seed: int, plants: int, iterations: int) -> tuple[tr.Identified, dict[str, tuple[float, ...]]]:
    """What was found, and for each controller J, and its errors in pitch and yaw."""
    truth = tr.draw(PRESET, 1, seed=seed)[0]
    log = tr.simulate(PRESET, None, EXCITE, fidelity="rig", true_rig=truth).log
    found = tr.identify(log, PRESET, fix=FIX, window=2.0, population=4, iterations=1, seed=seed)
    before = tr.Gains.of_preset(PRESET)
    tuned = tr.tune_robust(
        found.rig,
        start=before,
        range=2.0,
        algorithm="fpa-adaptive",
        plants=plants,
        rounds=2,
        population=12,
        iterations=iterations,
        seed=seed,
    ).gains
    scores = tr.compare(found.rig, {"the preset's": before, "tuned": tuned}, plants=24, seed=seed)
    return found, {
        "the preset's": (scores["the preset's"].total, *error(PRESET, before, truth)),
        "tuned": (scores["tuned"].total, *error(found.rig, tuned, truth)),
    }


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--plants", type=int, default=16)
    parser.add_argument("--iterations", type=int, default=12)
    arguments = parser.parse_args()
    identified, table = run(arguments.seed, arguments.plants, arguments.iterations)
    for constant in identified.constants:
        interval = "" if constant.ci95 is None else f"{constant.ci95[0]:12.4e} to {constant.ci95[1]:.4e}"
        print(f"{constant.name:32} {constant.value:12.4e} {constant.unit:10} {interval}")
    for name, (total, pitch, yaw) in table.items():
        print(f"{name:15} J {total:7.3f}   errors {pitch:6.2f}° {yaw:6.2f}°")
