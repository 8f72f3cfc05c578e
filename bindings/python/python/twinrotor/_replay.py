"""A log through the firmware's estimator and law."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _native
from ._gains import GainsLike, RigLike, gains_text, rig_text
from ._logs import LogLike, given

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Replay:
    """What the board would have made of a log, a tick every ms.

    ``columns`` has them by name; ``report`` is what ``host-sim replay --json`` says of them, ``notes`` what
    was found odd about the log.
    """

    columns: Mapping[str, Array] = field(repr=False)
    report: Mapping[str, Any]
    notes: list[str]

    def __getitem__(self, column: str) -> Array:
        return self.columns[column]

    @property
    def time(self) -> Array:
        """s."""
        return self.columns["t"]

    @property
    def rate(self) -> Array:
        """rad/s, shape (ticks, 2): pitch and yaw as the estimator had them, from what came before."""
        return np.column_stack([self.columns["rate_pitch"], self.columns["rate_yaw"]])

    @property
    def smoothed(self) -> Array:
        """rad/s, shape (ticks, 2): as a smoother has them, from what came before and after."""
        return np.column_stack([self.columns["smoothed_pitch"], self.columns["smoothed_yaw"]])

    @property
    def volts(self) -> Array:
        """V, shape (ticks, 2): main and tail motor in the log."""
        return np.column_stack([self.columns["v0"], self.columns["v1"]])

    @property
    def ours(self) -> Array | None:
        """V, shape (ticks, 2): what the law would have sent, where it was told what is wanted."""
        if self.report["volts_difference"] is None:
            return None
        return np.column_stack([self.columns["ours_v0"], self.columns["ours_v1"]])


def replay(
    log: LogLike,
    preset: RigLike,
    gains: GainsLike = None,
    *,
    columns: str = "",
    scenario: str | os.PathLike[str] | None = None,
    rotor_lag: float | None = None,
) -> Replay:
    """A log through the firmware's estimator and law, as ``host-sim replay`` does: the same numbers.

    :param log: the path of a CSV file, or columns as arrays, with ``t`` (s), ``pitch``, ``yaw`` (rad), ``v0``
        and ``v1`` (V), and ``ref_pitch``, ``ref_yaw`` (rad) where that was recorded.
    :param gains: ``None`` for what the preset's board boots with.
    :param columns: other names, signs and units of columns: ``"t=time:ms,pitch=-theta:deg"``.
    :param scenario: what was wanted, where the log does not say.
    :param rotor_lag: s, of both motors, instead of the preset's.
    :raises ValueError: if an argument or the log is not what it may be.
    """
    arrays, text = _native.replay(
        given(log, "the log"),
        rig_text(preset),
        gains_text(gains),
        columns,
        None if scenario is None else os.fspath(scenario),
        rotor_lag,
    )
    report = json.loads(text)
    return Replay(arrays, report, report.pop("notes"))
