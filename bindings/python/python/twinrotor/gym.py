"""The helicopter as a Gymnasium environment, ``Twinrotor-v0`` once this module is imported.

``gymnasium.make`` makes one (:class:`Twinrotor`), ``gymnasium.make_vec`` many that fly together
(:class:`TwinrotorVector`). What is seen, what an action means and what it earns: :class:`twinrotor.Batch`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeVar

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from ._batch import Action, Autoreset, Batch, Flags, Rows
from ._gains import GainsLike, Rig, RigLike

Vector = npt.NDArray[np.float32]
_Item = TypeVar("_Item", bound=np.generic)

_AUTORESETS: dict[AutoresetMode, Autoreset] = {
    AutoresetMode.NEXT_STEP: "next-step",
    AutoresetMode.SAME_STEP: "same-step",
    AutoresetMode.DISABLED: "disabled",
}


def _spaces(preset: Rig, seconds: float) -> tuple[gymnasium.Space[Vector], gymnasium.Space[Vector]]:
    """What may be seen, and what may be done."""
    constants = preset.constants
    supply = 1.01 * max(constants["volts_limit"].values())
    turned = 100.0 + seconds * float(constants["envelope"]["rate"]["yaw"])
    most = np.array([100.0, turned, 100.0, 100.0, 100.0, turned, supply, supply], dtype=np.float32)
    seen = gymnasium.spaces.Box(-most, most, dtype=np.float32)
    return seen, gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float32)


class Twinrotor(gymnasium.Env[Vector, Vector]):
    """Fly to a goal and stay there: a :class:`twinrotor.Batch` of one."""

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012, as Gymnasium has it

    def __init__(
        self,
        preset: RigLike = "aero2",
        *,
        action: Action = "volts",
        gains: GainsLike = None,
        supervised: bool = True,
        spread: bool = True,
        seconds: float = 10.0,
        render_mode: None = None,
    ) -> None:
        self.render_mode = render_mode
        self.preset = Rig.of(preset)
        self.batch = Batch(
            self.preset,
            1,
            action=action,
            gains=gains,
            supervised=supervised,
            spread=spread,
            seconds=seconds,
            autoreset="disabled",
            threads=1,
        )
        self.observation_space, self.action_space = _spaces(self.preset, seconds)
        self._seeded = False

    @property
    def goal(self) -> Vector:
        """Pitch and yaw (rad) that are to be flown to."""
        goal: Vector = self.batch.goals()[0]
        return goal

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Vector, dict[str, Any]]:
        """With a seed, the first of its episodes; without one, the next."""
        super().reset(seed=seed)
        if seed is None and not self._seeded:
            seed = int(self.np_random.integers(2**32))
        self._seeded = True
        return self.batch.begin(seed)[0].copy(), {}

    def step(self, action: Vector) -> tuple[Vector, float, bool, bool, dict[str, Any]]:
        seen, rewards, terminated, truncated = self.batch.fly(np.asarray(action)[None])
        return seen[0].copy(), float(rewards[0]), bool(terminated[0]), bool(truncated[0]), {}


class TwinrotorVector(VectorEnv[Rows, Rows, npt.NDArray[Any]]):
    """Many of them, each with the bytes of a :class:`Twinrotor` of its seed.

    :param autoreset_mode: when an environment whose episode is over begins its next one. All three of
        Gymnasium's: with the next step, in the same step (``infos["final_obs"]`` has what was seen last), or
        by ``reset(options={"reset_mask": mask})``.
    :param threads: one for each processor if ``None``.
    :param copy: without it, arrays that are answered are written over by the next step.
    """

    def __init__(
        self,
        num_envs: int = 1,
        preset: RigLike = "aero2",
        *,
        action: Action = "volts",
        gains: GainsLike = None,
        supervised: bool = True,
        spread: bool = True,
        seconds: float = 10.0,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        threads: int | None = None,
        copy: bool = True,
        render_mode: None = None,
    ) -> None:
        self.num_envs = num_envs
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.metadata = {"render_modes": [], "autoreset_mode": self.autoreset_mode}
        self.render_mode = render_mode
        self.copy = copy
        self.preset = Rig.of(preset)
        self.batch = Batch(
            self.preset,
            num_envs,
            action=action,
            gains=gains,
            supervised=supervised,
            spread=spread,
            seconds=seconds,
            autoreset=_AUTORESETS[self.autoreset_mode],
            threads=threads,
        )
        self.single_observation_space, self.single_action_space = _spaces(self.preset, seconds)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._seeded = np.zeros(num_envs, np.bool_)

    @property
    def goals(self) -> Rows:
        """Pitch and yaw (rad) that are to be flown to, a row for each."""
        return self.batch.goals()

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Rows, dict[str, Any]]:
        """Begins episodes, of all or where ``options["reset_mask"]`` is true.

        With ``seed`` k, environment i begins the first episode of seed k + i; with a list, of its own entry;
        with ``None``, its next one.
        """
        super().reset(seed=seed if isinstance(seed, int) else None)
        mask = np.ones(self.num_envs, np.bool_)
        if options and "reset_mask" in options:
            mask = np.asarray(options["reset_mask"])
            if mask.shape != (self.num_envs,) or mask.dtype != np.bool_:
                raise ValueError(f"reset_mask is {mask!r}; allowed: {self.num_envs} truth values")
        if isinstance(seed, int):
            seeds: list[int | None] = [seed + k for k in range(self.num_envs)]
        else:
            seeds = [None] * self.num_envs if seed is None else list(seed)
        if len(seeds) != self.num_envs:
            raise ValueError(f"seed has {len(seeds)} entries; allowed: {self.num_envs}")
        for k in np.flatnonzero(~self._seeded):
            if seeds[k] is None:
                seeds[k] = int(self.np_random.integers(2**32))
        self._seeded |= mask
        given = np.array([one is not None for one in seeds])
        if np.any(mask & given):
            self.batch.begin([one or 0 for one in seeds], mask=mask & given)
        seen = self.batch.begin(mask=mask & ~given)
        return self._own(seen), {}

    def step(self, actions: Rows) -> tuple[Rows, npt.NDArray[Any], Flags, Flags, dict[str, Any]]:
        seen, rewards, terminated, truncated = self.batch.fly(actions)
        infos: dict[str, Any] = {}
        if self.autoreset_mode == AutoresetMode.SAME_STEP:
            over = terminated | truncated
            if over.any():
                last = np.full(self.num_envs, None, dtype=object)
                for k in np.flatnonzero(over):
                    last[k] = self.batch.final_observations[k].copy()
                infos = {"final_obs": last, "_final_obs": over, "final_info": {}, "_final_info": over.copy()}
        return self._own(seen), self._own(rewards), self._own(terminated), self._own(truncated), infos

    def _own(self, array: npt.NDArray[_Item]) -> npt.NDArray[_Item]:
        return array.copy() if self.copy else array


gymnasium.register(
    id="Twinrotor-v0",
    entry_point="twinrotor.gym:Twinrotor",
    vector_entry_point="twinrotor.gym:TwinrotorVector",
)
