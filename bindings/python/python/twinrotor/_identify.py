"""A rig's constants from its logs."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

from . import _native
from ._gains import Rig, RigLike, rig_text
from ._logs import LogLike, all_given


@dataclass(frozen=True)
class Constant:
    """A constant as it was found, and as the preset has it, SI units.

    ``ci95`` is its 95 % interval: ``None`` at a bound that physics sets, or where the logs say nothing.
    """

    name: str
    value: float
    preset: float
    unit: str
    ci95: tuple[float, float] | None
    identifiable: bool
    at_bound: bool


@dataclass(frozen=True)
class Fit:
    """How well a log is explained with windows of ``window_s``: percent of each axis' motion.

    ``None`` for an axis that does not move. ``role`` is ``train`` or ``validate``.
    """

    log: str
    role: str
    offset_deg: float
    window_s: float
    pitch: float | None
    yaw: float | None


@dataclass(frozen=True)
class Identified:
    """What the logs tell of a rig; ``notes`` has what was found odd about them."""

    rig: Rig
    constants: list[Constant] = field(repr=False)
    fits: list[Fit] = field(repr=False)
    notes: list[str]
    windows: int
    cost: float
    descents: list[float] = field(repr=False)


def identify(
    logs: LogLike | Iterable[LogLike],
    preset: RigLike = "paper",
    *,
    validate: LogLike | Iterable[LogLike] = (),
    columns: str = "",
    free: Sequence[str] = (),
    fix: Sequence[str] = (),
    window: float = 3.5,
    population: int = 12,
    iterations: int = 3,
    seed: int = 1,
    rotor_lag: float | None = None,
    progress: Callable[[str, float], object] | None = None,
) -> Identified:
    """The constants of a rig, from logs of its own: the numbers of ``host-sim identify``.

    :param logs: paths of CSV files, or columns as arrays, with ``t`` (s), ``pitch``, ``yaw`` (rad), ``v0``
        and ``v1`` (V); one or several.
    :param preset: what is known of the rig before.
    :param validate: logs that are kept out of the fit and compared afterwards.
    :param columns: other names, signs and units of columns: ``"t=time:ms,pitch=-theta:deg"``.
    :param free: constants to fit beside the usual ones, such as ``"inertia.yaw"``.
    :param fix: constants to leave as the preset has them, such as ``"rotor_time_constant.tail"``.
    :param window: s; length of the windows that are fitted.
    :param population: flowers of the search for where to begin.
    :param iterations: its generations after the first.
    :param rotor_lag: s, of both motors, instead of the preset's.
    :param progress: called after every step with what was done, ``search`` or ``descent``, and the best cost.
    :raises ValueError: if an argument or a log is not what it may be.
    :raises RuntimeError: if the logs lead to a rig that cannot be.
    """
    toml, text = _native.identify(
        all_given(logs, "log"),
        all_given(validate, "validation log"),
        rig_text(preset),
        columns,
        list(free),
        list(fix),
        window,
        population,
        iterations,
        seed,
        rotor_lag,
        progress,
    )
    found = json.loads(text)
    constants = [
        Constant(**{**constant, "ci95": None if constant["ci95"] is None else tuple(constant["ci95"])})
        for constant in found["parameters"]
    ]
    return Identified(
        Rig(f"identified on the basis of {found['preset']}", toml),
        constants,
        [Fit(**fit) for fit in found["fits"]],
        found["notes"],
        found["windows"],
        found["cost"],
        found["descents"],
    )
