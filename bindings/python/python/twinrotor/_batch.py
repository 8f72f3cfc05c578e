"""Many helicopters at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple, Self, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _native
from ._gains import GainsLike, RigLike, gains_text, rig_text

Action: TypeAlias = Literal["volts", "setpoint"]
Autoreset: TypeAlias = Literal["next-step", "same-step", "disabled"]
Rows: TypeAlias = npt.NDArray[np.float32]
Flags: TypeAlias = npt.NDArray[np.bool_]
#: Ticks of 1 ms between two actions.
TICKS = 20
#: Numbers of an observation.
SEEN = 8


class Stepped(NamedTuple):
    """What an action each came to. The arrays are the batch's own, and the next step writes over them."""

    observations: Rows
    rewards: npt.NDArray[np.float64]
    terminated: Flags
    truncated: Flags


class Batch(_native.Batch):
    """Helicopters that fly on together, 20 ms with every action: plants in lanes, lanes in threads.

    An observation is θ, ψ (rad), θ̇, ψ̇ (rad/s), what is missing to the goal in pitch and yaw (rad), and the
    volts at the motors. An action has two parts within ±1: with ``action="volts"`` of the motors' limits;
    with ``action="setpoint"`` of ±25° and ±90°, flown by the board's controller with ``gains``, behind the
    board's supervisor unless ``supervised`` is false.

    A reward is minus the mean squared error (rad²) of the 20 ms. An episode begins at rest at zero with a
    goal within ±15° and ±40°; it ends where the rig leaves its envelope or the supervisor switches the motors
    off, with -10, and is cut after ``seconds``. With ``spread``, each flies another plant, drawn as the
    robust objective draws them: around the preset, or around ``true_rig`` whatever the controller believes.
    ``autoreset`` says when the next one begins, as Gymnasium names it.

    What an environment does depends on its seed, its number of episodes and its actions, to the bit: neither
    on the other environments nor on ``threads`` (``None``: one for each processor).

    :raises ValueError: if an argument is not what it may be.
    """

    def __new__(
        cls,
        preset: RigLike,
        count: int,
        *,
        action: Action = "volts",
        gains: GainsLike = None,
        supervised: bool = True,
        true_rig: RigLike | None = None,
        spread: bool = True,
        seconds: float = 10.0,
        autoreset: Autoreset = "next-step",
        threads: int | None = None,
    ) -> Self:
        truth = None if true_rig is None else rig_text(true_rig)
        return super().__new__(
            cls,
            rig_text(preset),
            count,
            action,
            gains_text(gains),
            supervised,
            truth,
            spread,
            seconds,
            autoreset,
            threads,
        )

    def __init__(self, preset: RigLike, count: int, **_: object) -> None:
        self._seen = np.zeros((count, SEEN), np.float32)
        #: What was last seen of episodes that ended in the last step, with ``autoreset="same-step"``.
        self.final_observations = np.zeros((count, SEEN), np.float32)
        self._rewards = np.zeros(count)
        self._terminated = np.zeros(count, np.bool_)
        self._truncated = np.zeros(count, np.bool_)

    def begin(self, seeds: Sequence[int] | int | None = None, *, mask: Flags | None = None) -> Rows:
        """Begins episodes, of all environments or where ``mask`` is true, and answers what is seen.

        ``seeds`` is one for each environment, or the first one's, after which they count on; without them,
        each goes on with the next of its episodes.
        """
        given: npt.NDArray[np.uint64] | None = None
        if isinstance(seeds, int | np.integer):
            if not 0 <= seeds < 2**64:
                raise ValueError(f"seeds is {seeds}; allowed: 0 to {2**64 - 1}")
            given = np.array([(int(seeds) + k) % 2**64 for k in range(self.count)], dtype=np.uint64)
        elif seeds is not None:
            given = np.array(seeds, dtype=np.uint64)
        chosen = np.ones(self.count, np.bool_) if mask is None else np.array(mask, dtype=np.bool_)
        super().reset(chosen, given, self._seen)
        return self._seen

    def fly(self, actions: npt.ArrayLike) -> Stepped:
        """20 ms with an action each; the actions are copied first."""
        given = np.ascontiguousarray(actions, dtype=np.float32)
        if given.ndim != 2 or given.shape[1] != 2:
            raise ValueError(f"actions have the shape {given.shape}; allowed: ({self.count}, 2)")
        arrays = (self._seen, self.final_observations, self._rewards, self._terminated, self._truncated)
        super().step(given, *arrays)
        return Stepped(self._seen, self._rewards, self._terminated, self._truncated)
