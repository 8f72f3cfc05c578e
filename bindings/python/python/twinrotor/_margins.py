"""How far a rig may be from what its controller believes."""

from __future__ import annotations

import json
from dataclasses import dataclass

from . import _native
from ._gains import GainsLike, RigLike, gains_text, rig_text

Edges = tuple[float | None, float | None]


@dataclass(frozen=True)
class Margins:
    """Between which factors of thrust, rotor lag and inertia the linearised loop is stable: least and most.

    An edge is ``None`` where it is stable as far as is looked: factors of 0.01 to 20, and 500 ms.
    ``delay_ms`` is the longest delay beyond the one tick that there is; at ``slowest_pole`` (1/s) the slowest
    part of a small error dies, or grows where it is negative: the loop is not ``stable`` then, and has no
    margins.
    """

    stable: bool
    thrust: Edges
    lag: Edges
    inertia: Edges
    delay_ms: int | None
    slowest_pole: float


def margins(preset: RigLike, gains: GainsLike = None, *, rotor_lag: float | None = None) -> Margins:
    """What ``host-sim margins`` says.

    :param gains: ``None`` for what the preset's board boots with.
    :param rotor_lag: s, of both motors, instead of the preset's.
    :raises ValueError: if an argument is not what it may be.
    """
    found = json.loads(_native.margins(rig_text(preset), gains_text(gains), rotor_lag))
    edges = {name: (found[name][0], found[name][1]) for name in ("thrust", "lag", "inertia")}
    return Margins(
        stable=found["stable"],
        thrust=edges["thrust"],
        lag=edges["lag"],
        inertia=edges["inertia"],
        delay_ms=found["delay_ms"],
        slowest_pole=found["slowest_pole"],
    )
