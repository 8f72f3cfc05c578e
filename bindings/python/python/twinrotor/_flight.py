"""One flight."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _native
from ._gains import GainsLike, RigLike, gains_text, rig_text

Array = npt.NDArray[np.float64]
Fidelity = Literal["ideal", "rig"]


@dataclass(frozen=True)
class Flight:
    """A flight, tick by tick: columns with the names and values of ``host-sim simulate --csv``.

    ``log`` is what a logger on the rig would have written of it, with the columns of ``--log``: for
    :func:`identify` and :func:`replay`. ``report`` is what ``host-sim simulate --json`` says of it: each
    axis' settling, overshoot and errors, each motor's volts, the board's state, and when it left its
    envelope if it did.
    """

    columns: Mapping[str, Array] = field(repr=False)
    log: Mapping[str, Array] = field(repr=False)
    report: Mapping[str, Any]

    def __getitem__(self, column: str) -> Array:
        return self.columns[column]

    @property
    def time(self) -> Array:
        """s."""
        return self.columns["t"]

    @property
    def angle(self) -> Array:
        """rad, shape (ticks, 2): pitch and yaw."""
        return np.column_stack([self.columns["theta"], self.columns["psi"]])

    @property
    def volts(self) -> Array:
        """V, shape (ticks, 2): main and tail motor."""
        return np.column_stack([self.columns["v_main"], self.columns["v_tail"]])


def simulate(
    preset: RigLike = "paper",
    gains: GainsLike = "paper",
    scenario: str | os.PathLike[str] = "step",
    *,
    fidelity: Fidelity = "ideal",
    scalar: Literal["f32", "f64"] = "f32",
    seed: int = 1,
    initial: tuple[float, float] | None = None,
    duration: float | None = None,
    true_rig: RigLike | None = None,
) -> Flight:
    """Flies a scenario, as ``host-sim simulate`` does: the same numbers to the last bit.

    :param gains: ``None`` for what the preset's board boots with.
    :param fidelity: the paper's world, or the rig's with encoders, rotor lag, delay and PWM steps.
    :param initial: rad of pitch and yaw, instead of the scenario's start.
    :param duration: s, instead of the scenario's.
    :param true_rig: what is flown, where the controller believes in another, ``preset``.
    :raises ValueError: if an argument is not what it may be.
    :raises RuntimeError: if the loop diverges.
    """
    columns, log, report = _native.simulate(
        rig_text(preset),
        gains_text(gains),
        os.fspath(scenario),
        fidelity,
        scalar,
        seed,
        initial,
        duration,
        None if true_rig is None else rig_text(true_rig),
    )
    return Flight(columns, log, json.loads(report))
