"""The board's loop in Python: for a rig of one's own, real or simulated."""

from __future__ import annotations

from types import TracebackType
from typing import Protocol, Self

from . import _native
from ._gains import GainsLike, RigLike, gains_text, rig_text

Pair = tuple[float, float]
#: Ticks that a rig may take to come to rest.
SETTLE_TICKS = 180_000
#: Ticks from one attempt to zero to the next.
ZERO_EVERY = 500


class ControlLoop(_native.ControlLoop):
    """The loop that the firmware runs, with its supervisor: counters in, volts out, once a millisecond.

    :param counters: what the encoders' counters show now.
    :param counter_bits: 16 for an STM32's timers, 24 for the Aero's and the Aero 2's.
    :param checked: the wiring is known to be right; else the first-power check comes before arming.
    """

    def __new__(
        cls,
        preset: RigLike,
        gains: GainsLike = None,
        *,
        counters: tuple[int, int] = (0, 0),
        counter_bits: int = 24,
        checked: bool = False,
    ) -> Self:
        return super().__new__(cls, rig_text(preset), gains_text(gains), counters, counter_bits, checked)

    def aim(self, angle: Pair, rate: Pair = (0.0, 0.0), accel: Pair = (0.0, 0.0)) -> None:
        """Wants the helicopter at ``angle`` (rad of pitch and yaw), moving on at ``rate`` and ``accel``."""
        super().aim(angle, rate, accel)


class Bench(_native.Bench):
    """A simulated rig in its rest pose, with a table under it until it is taken away."""

    def __new__(cls, preset: RigLike) -> Self:
        return super().__new__(cls, rig_text(preset))


class SimulatedBoard(_native.SimulatedBoard):
    """A whole simulated board with its rig, at the other end of its line.

    Control loop, conversation and record store are those of the firmware; a tick is a millisecond.
    """

    def __new__(cls, preset: RigLike, gains: GainsLike = None, *, checked: bool = False) -> Self:
        return super().__new__(cls, rig_text(preset), gains_text(gains), checked)

    def aim(self, angle: Pair, rate: Pair = (0.0, 0.0), accel: Pair = (0.0, 0.0)) -> None:
        """See :meth:`ControlLoop.aim`."""
        super().aim(angle, rate, accel)


class Port(Protocol):
    """Encoders and amplifiers."""

    def read(self) -> tuple[int, int, float]:
        """Both counters, and the supply (V)."""

    def write(self, volts: Pair, enabled: bool) -> None:
        """What the amplifiers give from now on."""


class Fault(RuntimeError):
    """The supervisor has switched the motors off."""


class Controller:
    """A rig at a port, flown by the board's loop::

        with Controller(port, "aero2") as controller:
            controller.prepare()
            controller.arm()
            controller.loop.aim((0.1, 0.4))
            controller.run(5_000)

    The port keeps the time: its ``read`` returns once a millisecond. A context manager: whatever ends it, the
    motors get zero volts and the amplifiers are switched off.
    """

    def __init__(
        self,
        port: Port,
        preset: RigLike,
        gains: GainsLike = None,
        *,
        counter_bits: int = 24,
        checked: bool = False,
    ) -> None:
        pitch, yaw, _ = port.read()
        self.port = port
        self.loop = ControlLoop(
            preset, gains, counters=(pitch, yaw), counter_bits=counter_bits, checked=checked
        )

    def tick(self) -> str:
        """A millisecond; answers the supervisor's state."""
        pitch, yaw, supply = self.port.read()
        volts = self.loop.tick(pitch, yaw, supply)
        self.port.write(volts, self.loop.motors_may_turn)
        return self.loop.state

    def off(self) -> None:
        """Zero volts, amplifiers off, whatever else is."""
        self.port.write((0.0, 0.0), False)

    def run(self, ticks: int) -> None:
        """Goes on for so long.

        :raises Fault: if the supervisor switches the motors off.
        """
        for _ in range(ticks):
            if self.tick() == "fault":
                raise Fault(f"the supervisor switched the motors off: {self.loop.fault}")

    def until(self, *states: str, ticks: int) -> None:
        """Goes on until one of these states is there.

        :raises Fault: if a fault comes first.
        :raises TimeoutError: if none is there after so many ticks; with what is wrong.
        """
        for _ in range(ticks):
            state = self.tick()
            if state in states:
                return
            if state == "fault":
                raise Fault(f"the supervisor switched the motors off: {self.loop.fault}")
        wrong = ", ".join(self.loop.conditions) or "nothing is wrong"
        raise TimeoutError(f"not {' or '.join(states)} after {ticks} ticks: {wrong}")

    def prepare(self) -> None:
        """The first-power check if it is due, in which each motor pushes the rig a little, and zero where it
        rests.

        :raises Fault: if a fault ends it.
        :raises TimeoutError: if the rig does not come to rest, or the check did not pass.
        """
        self.run(100)
        if "NotChecked" in self.loop.conditions:
            self.loop.request("check")
            self.until("checking", ticks=100)
            self.until("disarmed", "ready", ticks=3 * SETTLE_TICKS)
            if "NotChecked" in self.loop.conditions:
                raise TimeoutError(
                    "the first-power check did not pass: is each motor and each encoder at its own place?"
                )
        for _ in range(SETTLE_TICKS // ZERO_EVERY):
            # It is not taken while the rig moves.
            self.loop.zero()
            self.run(ZERO_EVERY)
            if self.loop.state == "ready":
                return
        raise TimeoutError(f"the rig did not come to rest: {', '.join(self.loop.conditions)}")

    def arm(self) -> None:
        """The motors turn from now on.

        :raises TimeoutError: if something forbids it; with what.
        """
        self.loop.request("arm")
        self.until("armed", ticks=100)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.off()
