"""Many environments at once: the same bytes as one by one, whatever computes them."""

import os
import shutil
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
import twinrotor as tr
import twinrotor.gym as gym
from gymnasium.vector import AutoresetMode, SyncVectorEnv

PRESETS = tr.presets()


def actions(count: int, steps: int, seed: int = 3) -> np.ndarray[Any, np.dtype[np.float32]]:
    """Each holds what it does for a while, so that some leave their envelope."""
    rng = np.random.default_rng(seed)
    held = rng.uniform(-1.2, 1.2, (steps // 25 + 1, count, 2)).astype(np.float32)
    return np.repeat(held, 25, axis=0)[:steps]


@pytest.mark.parametrize("preset", PRESETS)
def test_a_plant_in_a_lane_is_the_benchs_bit_for_bit(preset: str) -> None:
    rig = tr.draw(preset, 1, seed=8)[0]
    count, limit = 19, [rig.constants["volts_limit"][motor] for motor in ("main", "tail")]
    batch = tr.Batch(rig, count, spread=False, threads=2, seconds=3600.0)
    batch.begin(1)
    benches = [tr.Bench(rig) for _ in range(count)]
    for bench in benches:
        bench.place(0.0, 0.0)
    flying = np.ones(count, bool)
    for given in actions(count, 100):
        seen, _, terminated, _ = batch.fly(given)
        volts = np.clip(given, -1.0, 1.0) * np.array(limit, np.float32)
        for k in np.flatnonzero(flying):
            benches[k].tick((float(volts[k, 0]), float(volts[k, 1])), ticks=20)
            angle, rate = benches[k].state
            assert [*angle, *rate] == [float(x) for x in seen[k, :4]], k
        flying &= ~terminated
    assert np.abs(seen[:, 1]).max() > 0.3, "they flew"


@pytest.mark.parametrize("preset", PRESETS)
def test_the_supervisor_changes_no_bit_until_it_cuts(preset: str) -> None:
    behind, without = (
        tr.Batch(preset, 6, action="setpoint", supervised=supervised, autoreset="disabled")
        for supervised in (True, False)
    )
    assert np.array_equal(behind.begin(4), without.begin(4))
    # Within what such a machine can follow.
    for given in 0.4 * actions(6, 120):
        (seen, rewards, ended, _), other = behind.fly(given), without.fly(given)
        assert not ended.any()
        assert np.array_equal(seen, other.observations) and np.array_equal(rewards, other.rewards)


def test_what_the_motors_cannot_hold_ends_an_episode_behind_the_supervisor() -> None:
    """A rig whose tail pushes the other way is cut before it leaves its envelope."""
    told = tr.Rig.of("aero2").toml
    rig = tr.Rig("reversed", told.replace("tail_on_yaw = 0", "tail_on_yaw = -0"))
    assert rig.constants["plant"]["effectiveness"]["tail_on_yaw"] < 0.0
    batch, free = (
        tr.Batch("aero2", 4, action="setpoint", true_rig=rig, supervised=supervised, autoreset="disabled")
        for supervised in (True, False)
    )
    free.begin(1)
    batch.begin(1)
    for _ in range(200):
        given = np.full((4, 2), 0.5, np.float32)
        stepped, other = batch.fly(given), free.fly(given)
        assert not other.terminated.any(), "it is not the envelope"
        if stepped.terminated.any():
            assert np.all(stepped.rewards[stepped.terminated] < -10.0)
            return
    pytest.fail("it was never cut")


@pytest.mark.parametrize("action", ["volts", "setpoint"])
def test_neither_threads_nor_neighbours_change_a_byte(action: Any) -> None:
    count, steps = 37, 160

    def flown(count: int, threads: int, first: int) -> list[bytes]:
        batch = tr.Batch("aero2", count, action=action, seconds=2.0, autoreset="same-step", threads=threads)
        rows = [batch.begin(100 + first).tobytes()]
        for given in actions(37, steps)[:, first : first + count]:
            stepped = batch.fly(given)
            rows += [array.tobytes() for array in (*stepped, batch.final_observations)]
        return rows

    whole = flown(count, 1, 0)
    assert whole == flown(count, 2, 0) == flown(count, 3, 0)
    width = [len(row) // count for row in whole]
    for k in (0, 16, 36):
        alone = flown(1, 1, k)
        assert alone == [row[k * n : (k + 1) * n] for row, n in zip(whole, width, strict=True)]


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize("action", ["volts", "setpoint"])
def test_it_is_gymnasiums_own_vector_of_single_ones(action: Any, mode: AutoresetMode) -> None:
    """All three modes beside ``SyncVectorEnv``, byte for byte."""
    count = 5
    native = gym.TwinrotorVector(count, action=action, seconds=1.5, autoreset_mode=mode)
    plain = SyncVectorEnv([lambda: gym.Twinrotor(action=action, seconds=1.5)] * count, autoreset_mode=mode)
    assert native.metadata["autoreset_mode"] is mode
    assert native.observation_space == plain.observation_space
    assert native.action_space == plain.action_space
    assert np.array_equal(native.reset(seed=7)[0], plain.reset(seed=7)[0])
    ends = 0
    for given in actions(count, 200):
        ours, theirs = native.step(given), plain.step(given)
        for one, other in zip(ours[:4], theirs[:4], strict=True):
            assert one.dtype == other.dtype and np.array_equal(one, other)
        over = ours[2] | ours[3]
        ends += over.sum()
        assert set(ours[4]) == set(theirs[4])
        if "final_obs" in ours[4]:
            assert np.array_equal(ours[4]["_final_obs"], theirs[4]["_final_obs"])
            for one, other in zip(ours[4]["final_obs"], theirs[4]["final_obs"], strict=True):
                assert (one is None and other is None) or np.array_equal(one, other)
        if mode is AutoresetMode.DISABLED and over.any():
            with pytest.raises(ValueError, match="is in no episode"):
                native.step(given)
            begun, others = (env.reset(options={"reset_mask": over.copy()}) for env in (native, plain))
            assert np.array_equal(begun[0], others[0])
    assert ends > count


def test_gymnasium_makes_it() -> None:
    env = gymnasium.make_vec("Twinrotor-v0", num_envs=3, spread=False)
    assert isinstance(env, gym.TwinrotorVector)
    seen, _ = env.reset(seed=[5, None, 5])
    assert np.array_equal(seen[0], seen[2]) and env.observation_space.contains(seen)
    assert np.array_equal(env.goals, seen[:, 4:6])
    again, _ = env.reset()
    assert not np.array_equal(again[:, 4:6], seen[:, 4:6]), "the next episodes"
    kept, *_ = env.step(env.action_space.sample())
    before = kept.copy()
    env.step(env.action_space.sample())
    assert np.array_equal(kept, before), "what was answered is not written over"


def test_python_goes_on_while_it_flies() -> None:
    batch = tr.Batch("aero2", 2_000, action="setpoint", threads=1)
    batch.begin(1)
    counted, stop = [0], threading.Event()

    def count() -> None:
        while not stop.is_set():
            counted[0] += 1

    other = threading.Thread(target=count)
    other.start()
    try:
        given = np.zeros((2_000, 2), np.float32)
        before = counted[0]
        for _ in range(10):
            batch.fly(given)
        assert counted[0] > before + 1_000
    finally:
        stop.set()
        other.join()


COUNT = """
import ctypes
import numpy as np
import twinrotor as tr

allocations = ctypes.CDLL(None).allocations
allocations.restype = ctypes.c_long
for action in ("volts", "setpoint"):
    for count in (16, 160):
        batch = tr.Batch("aero2", count, action=action, threads=2)
        batch.begin(1)
        given = np.zeros((count, 2), np.float32)
        for _ in range(3):
            batch.fly(given)
        before = allocations()
        for _ in range(50):
            batch.fly(given)
        print(allocations() - before)
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="libraries are put in front of others so")
def test_a_step_allocates_nothing_for_its_plants(tmp_path: Path) -> None:
    compiler = shutil.which("cc")
    assert compiler is not None, "what links Rust is there"
    counter = tmp_path / "counter.so"
    source = Path(__file__).with_name("allocations.c")
    subprocess.run([compiler, "-O1", "-shared", "-fPIC", source, "-o", counter, "-ldl"], check=True)
    told = subprocess.run(
        [sys.executable, "-c", COUNT],
        env={**os.environ, "LD_PRELOAD": str(counter), "PYTHONMALLOC": "malloc"},
        check=True,
        capture_output=True,
        text=True,
    )
    counted = [int(line) for line in told.stdout.split()]
    # What Python itself allocates for a call, which is not always the same.
    assert min(counted) > 0, "they are counted"
    assert max(counted) - min(counted) < 50, "for 144 plants more not one a step"


def test_what_is_wrong_is_said() -> None:
    wrongs: list[tuple[dict[str, Any], str]] = [
        ({"count": 0}, "count is 0; allowed: 1 to 1000000"),
        ({"action": "torque"}, "unknown action 'torque'"),
        ({"autoreset": "never"}, "unknown autoreset 'never'"),
        ({"seconds": float("nan")}, "seconds is NaN; allowed: 0.02 to 3600"),
        ({"threads": 0}, "threads is 0"),
    ]
    for wrong, told in wrongs:
        with pytest.raises(ValueError, match=told):
            tr.Batch(**{"preset": "aero2", "count": 2, **wrong})
    batch = tr.Batch("aero2", 2)
    with pytest.raises(ValueError, match="environment 0 is in no episode"):
        batch.fly(np.zeros((2, 2)))
    batch.begin(1)
    shapes: list[tuple[Any, str]] = [
        (np.zeros((3, 2)), "actions has 3 rows; allowed: 2"),
        (np.zeros(4), "actions have the shape"),
        ([[0.0, 0.0], [0.0, np.nan]], "action 1 is"),
    ]
    for given, told in shapes:
        with pytest.raises(ValueError, match=told):
            batch.fly(given)
    with pytest.raises(ValueError, match="seeds has 1 rows"):
        batch.begin([1])
    with pytest.raises(ValueError, match="reset_mask"):
        gym.TwinrotorVector(2).reset(options={"reset_mask": np.ones(3, bool)})
