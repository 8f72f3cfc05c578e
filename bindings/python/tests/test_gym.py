"""The environment."""

import warnings

import gymnasium
import numpy as np
import pytest
import twinrotor.gym as gym
from gymnasium.utils.env_checker import check_env


@pytest.mark.parametrize("action", ["volts", "setpoint"])
def test_gymnasium_finds_nothing_wrong(action: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make("Twinrotor-v0", action=action).unwrapped)


def test_the_boards_loop_flies_to_its_goal_on_drawn_plants() -> None:
    env = gymnasium.make("Twinrotor-v0", action="setpoint")
    inner = env.unwrapped
    assert isinstance(inner, gym.Twinrotor)
    for seed in range(5):
        env.reset(seed=seed)
        ended = cut = False
        while not (ended or cut):
            seen, _, ended, cut, _ = env.step((inner.goal / np.radians([25.0, 90.0])).astype(np.float32))
        assert cut and not ended
        assert np.all(np.abs(seen[4:6]) < np.radians(2.0)), seed


def test_full_volts_leave_the_envelope_and_the_same_seed_is_the_same_episode() -> None:
    def fly(seed: int) -> list[float]:
        env = gymnasium.make("Twinrotor-v0")
        env.reset(seed=seed)
        rewards = []
        for _ in range(500):
            _, reward, ended, _, _ = env.step(np.ones(2, dtype=np.float32))
            rewards.append(float(reward))
            if ended:
                break
        assert ended and rewards[-1] < -10.0
        return rewards

    assert fly(1) == fly(1) != fly(2)
