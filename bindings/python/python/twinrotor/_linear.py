"""The plant as a linear system."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _native
from ._gains import RigLike, rig_text

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Linear:
    """ẋ = A x + B u, y = C x + D u, of differences from a pose.

    States are θ, ψ, θ̇, ψ̇ and the volts in effect of each motor that lags; inputs the volts applied to main
    and tail motor; outputs θ and ψ. ``volts`` hold the pose. ``control.ss(*linear.abcd)`` is python-control's
    system.
    """

    a: Array
    b: Array
    c: Array
    d: Array
    volts: tuple[float, float]

    @property
    def abcd(self) -> tuple[Array, Array, Array, Array]:
        return self.a, self.b, self.c, self.d


def linearize(preset: RigLike, pitch: float = 0.0) -> Linear:
    """The plant near rest at ``pitch`` (rad), with the lag and the reaction torque of its rotors.

    Coulomb friction, which has no slope, is left out.

    :raises ValueError: if the pitch is not within a right angle.
    """
    a, b, c, d, (main, tail) = _native.linearize(rig_text(preset), pitch)
    return Linear(a, b, c, d, (main, tail))
