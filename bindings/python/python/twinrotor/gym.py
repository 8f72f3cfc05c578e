"""The helicopter as a Gymnasium environment, ``Twinrotor-v0`` once this module is imported."""

from __future__ import annotations

from typing import Any, Literal

import gymnasium
import numpy as np
import numpy.typing as npt

from ._board import Bench, ControlLoop
from ._gains import GainsLike, Rig, RigLike
from ._search import draw

#: Ticks of 1 ms between two actions.
TICKS = 20
#: Ticks for which a rig lies still before where it lies is its rest pose.
REST_TICKS = 1_600
#: rad of pitch and yaw: goals are drawn from within.
GOALS = np.radians([15.0, 40.0])

Vector = npt.NDArray[np.float32]


class Twinrotor(gymnasium.Env[Vector, Vector]):
    """Fly to a goal and stay there.

    Observation: θ, ψ (rad), θ̇, ψ̇ (rad/s), what is missing to the goal in pitch and yaw (rad), and the volts
    of the last action. Action, each in -1 to 1: with ``action="volts"`` of the motors' limits, every 20 ms;
    with ``action="setpoint"`` of ±25° and ±90°, flown by the board's own loop behind its supervisor, from its
    rest pose.

    Reward: minus the mean squared error (rad²) of the 20 ms. An episode ends where the rig leaves its
    envelope or the supervisor switches the motors off, with -10; it is cut after ``seconds``. With
    ``spread``, each episode flies another plant, drawn as the robust objective draws them.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012, as Gymnasium has it

    def __init__(
        self,
        preset: RigLike = "aero2",
        *,
        action: Literal["volts", "setpoint"] = "volts",
        gains: GainsLike = None,
        spread: bool = True,
        seconds: float = 10.0,
        render_mode: None = None,
    ) -> None:
        if action not in ("volts", "setpoint"):
            raise ValueError(f"action is {action!r}; allowed: 'volts', 'setpoint'")
        if not 0.02 <= seconds <= 3600.0:
            raise ValueError(f"seconds is {seconds}; allowed: 0.02 to 3600")
        self.render_mode = render_mode
        self.preset = Rig.of(preset)
        constants = self.preset.constants
        self.limit = np.array([constants["volts_limit"][motor] for motor in ("main", "tail")])
        self.envelope = float(constants["envelope"]["pitch"])
        self.rates = np.array([constants["envelope"]["rate"][axis] for axis in ("pitch", "yaw")])
        self.kind, self.gains, self.spread = action, gains, spread
        self.steps = round(seconds * 1000 / TICKS)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float32)
        most = np.array([*[100.0] * 6, *self.limit], dtype=np.float32)
        self.observation_space = gymnasium.spaces.Box(-most, most, dtype=np.float32)
        self.left = 0
        self.loop: ControlLoop | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Vector, dict[str, Any]]:
        super().reset(seed=seed)
        drawn = int(self.np_random.integers(2**31))
        self.rig = draw(self.preset, 1, seed=drawn)[0] if self.spread else self.preset
        self.goal = self.np_random.uniform(-GOALS, GOALS)
        self.volts = np.zeros(2)
        self.left = self.steps
        self.bench = Bench(self.rig)
        self.loop = None
        if self.kind == "setpoint":
            self.loop = self._armed()
        else:
            self.bench.place(0.0, 0.0)
        return self._seen(), {}

    def step(self, action: Vector) -> tuple[Vector, float, bool, bool, dict[str, Any]]:
        wanted = np.clip(np.asarray(action, dtype=float), -1.0, 1.0)
        if self.loop is None:
            self.volts = wanted * self.limit
            self.bench.tick((float(self.volts[0]), float(self.volts[1])), ticks=TICKS)
        else:
            pitch, yaw = wanted * np.radians([25.0, 90.0])
            self.loop.aim((float(pitch), float(yaw)))
            for _ in range(TICKS):
                self._tick(self.loop)
        error = self._error()
        off = self.loop is not None and self.loop.state != "armed"
        angle, rate = (np.array(pair) for pair in self.bench.state)
        ended = bool(off or abs(angle[0]) > self.envelope or np.any(np.abs(rate) > self.rates))
        self.left -= 1
        reward = -float(np.sum(error**2)) - (10.0 if ended else 0.0)
        return self._seen(), reward, ended, self.left <= 0, {}

    def _tick(self, loop: ControlLoop) -> None:
        volts = loop.tick(*self.bench.counters, self.bench.supply)
        self.volts = np.array(volts)
        self.bench.tick(volts, loop.motors_may_turn)

    def _armed(self) -> ControlLoop:
        """The board's loop, zeroed where the rig rests, and armed."""
        loop = ControlLoop(
            self.preset, self.gains, counters=self.bench.counters, counter_bits=16, checked=True
        )
        for _ in range(REST_TICKS):
            self._tick(loop)
        loop.zero()
        for _ in range(5):
            self._tick(loop)
        loop.request("arm")
        for _ in range(5):
            self._tick(loop)
        if loop.state != "armed":
            raise RuntimeError(f"the board's loop is not armed: {', '.join(loop.conditions)}")
        self.bench.table = False
        return loop

    def _error(self) -> npt.NDArray[np.float64]:
        error: npt.NDArray[np.float64] = self.goal - np.array(self.bench.state[0])
        return error

    def _seen(self) -> Vector:
        angle, rate = self.bench.state
        return np.array([*angle, *rate, *self._error(), *self.volts], dtype=np.float32)


gymnasium.register(id="Twinrotor-v0", entry_point="twinrotor.gym:Twinrotor")
