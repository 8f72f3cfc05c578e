"""The board's loop in Python."""

import itertools
import random

import numpy as np
import pytest
import twinrotor as tr

REST = 1_600


class Simulated:
    """A port to a simulated rig."""

    def __init__(self, preset: str) -> None:
        self.bench = tr.Bench(preset)
        self.enabled = False
        self.volts = (0.0, 0.0)

    def read(self) -> tuple[int, int, float]:
        return *self.bench.counters, self.bench.supply

    def write(self, volts: tuple[float, float], enabled: bool) -> None:
        self.volts, self.enabled = volts, enabled
        self.bench.tick(volts, enabled)


def armed(preset: str = "aero2", *, checked: bool = True) -> tr.Controller:
    port = Simulated(preset)
    controller = tr.Controller(port, preset, counter_bits=16, checked=checked)
    controller.prepare()
    controller.arm()
    port.bench.table = False
    return controller


@pytest.mark.parametrize("preset", ["aero2", "heli"])
def test_sixty_thousand_ticks_are_the_simulated_boards(preset: str) -> None:
    board = tr.SimulatedBoard(preset, checked=True)
    bench = tr.Bench(preset)
    loop = tr.ControlLoop(preset, counters=bench.counters, counter_bits=16, checked=True)

    def tick() -> None:
        volts = loop.tick(*bench.counters, bench.supply)
        # A board lies on a table until it is armed.
        bench.table = loop.state != "armed"
        bench.tick(volts, loop.motors_may_turn)

    first = board.frame()["tick"]
    assert isinstance(first, int)
    for _ in range(first + 1):
        tick()
    chance = random.Random(5)
    flown = 0
    for k in range(60_000):
        if k == REST:
            board.zero()
            loop.zero()
        elif k == REST + 5:
            board.request("arm")
            loop.request("arm")
        elif k > REST + 20 and k % 1_500 == 0:
            angle = (chance.uniform(-0.2, 0.2), chance.uniform(-0.7, 0.7))
            board.aim(angle)
            loop.aim(angle)
        board.tick()
        tick()
        assert board.state == loop.state, k
        assert board.frame() == loop.frame(), k
        flown += loop.state == "armed"
    assert flown > 58_000


def test_a_flight_with_the_first_power_check_reaches_its_goal() -> None:
    with armed(checked=False) as controller:
        controller.loop.aim((0.15, 0.4))
        for _ in range(9_000):
            assert controller.tick() == "armed"
        # From where it was zeroed, which after the check is not where it began.
        assert np.allclose(controller.loop.frame()["angle"], (0.15, 0.4), atol=0.02)  # type: ignore[arg-type]
    assert controller.port.volts == (0.0, 0.0) and not controller.port.enabled  # type: ignore[attr-defined]


def test_a_check_with_wrong_wiring_does_not_pass() -> None:
    port = Simulated("heli")
    port.bench.encoder_reversed = (True, False)
    controller = tr.Controller(port, "heli", counter_bits=16)
    with pytest.raises(TimeoutError, match="did not pass"):
        controller.prepare()


def test_what_is_unchecked_does_not_arm() -> None:
    controller = tr.Controller(Simulated("aero2"), "aero2", counter_bits=16)
    controller.run(REST)
    controller.loop.zero()
    with pytest.raises(TimeoutError, match="NotChecked"):
        controller.until("ready", ticks=20)


@pytest.mark.parametrize("end", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_whatever_ends_it_the_amplifiers_are_off(end: type[BaseException]) -> None:
    controller = armed()
    with pytest.raises(end), controller:
        for k in itertools.count():
            controller.tick()
            if k == 300:
                assert controller.port.enabled  # type: ignore[attr-defined]
                raise end
    assert controller.port.volts == (0.0, 0.0) and not controller.port.enabled  # type: ignore[attr-defined]


def test_the_supervisor_finds_a_stuck_encoder() -> None:
    with armed() as controller, pytest.raises(tr.Fault, match="Pitch"):
        controller.port.bench.encoder_stuck = (True, False)  # type: ignore[attr-defined]
        for angle in itertools.cycle([0.25, -0.25]):
            controller.loop.aim((angle, 0.0))
            controller.run(1_500)


def test_the_linear_plant_is_the_plants_slope() -> None:
    """Volts stepped by a little: the bench's angles beside exp(At)."""
    linear = tr.linearize("aero2", 0.0)
    poles = np.linalg.eigvals(linear.a)
    assert np.sum(np.abs(poles) < 1e-9) == 1, "yaw has nothing that pulls it back"
    step = np.array([4.0, -3.0])
    bench = tr.Bench("aero2")
    bench.place(0.0, 0.0)
    state, dt = np.zeros(len(linear.a)), 1e-3
    held = np.array(linear.volts)
    assert np.allclose(held, 0.0), "an Aero 2 is in balance"
    for _ in range(1_500):
        bench.tick((float(step[0]), float(step[1])))
        for _ in range(4):
            state = state + dt / 4 * (linear.a @ state + linear.b @ step)
    (pitch, yaw), _ = bench.state
    # Thrust is linear on this preset, and the pitch small: a degree or two of difference in phase.
    assert abs(pitch - state[0]) < 0.05 * abs(state[0]) + 0.01
    assert abs(yaw - state[1]) < 0.05 * abs(state[1]) + 0.01
