from collections.abc import Callable
from typing import Self, TypeAlias

import numpy as np
import numpy.typing as npt

from ._coverage import Studied

Array: TypeAlias = npt.NDArray[np.float64]
Candidates: TypeAlias = list[tuple[list[float], float]]
Rows: TypeAlias = npt.NDArray[np.float32]
Progress: TypeAlias = Callable[[int, int, float], object]
Log: TypeAlias = tuple[str, list[tuple[str, Array]] | None]

def presets() -> list[str]: ...
def rig(preset: str) -> tuple[str, str]: ...
def gains(gains: str | None, preset: str) -> str: ...
def settings() -> str: ...
def simulate(
    preset: str,
    gains: str | None,
    scenario: str,
    fidelity: str,
    scalar: str,
    seed: int,
    initial: tuple[float, float] | None,
    duration: float | None,
    true_rig: str | None,
) -> tuple[dict[str, Array], dict[str, Array], str]: ...
def tune(
    preset: str,
    objective: str,
    algorithm: str,
    seed: int,
    population: int | None,
    iterations: int,
    scenario: str,
    fidelity: str,
    bounds: tuple[float, float],
    progress: Progress | None,
) -> tuple[str, str]: ...
def tune_robust(
    preset: str,
    controller: str,
    start: str | None,
    parameters: list[str],
    at_most: list[str],
    plants: int,
    rounds: int,
    range: float,
    algorithm: str,
    seed: int,
    population: int | None,
    iterations: int,
    progress: Progress | None,
    evaluate: Callable[[Candidates], list[float]] | None,
    keep: Callable[[bytes], object] | None,
    resume: bytes | None,
) -> tuple[str, str]: ...
def robust_costs(
    preset: str,
    controller: str,
    start: str | None,
    parameters: list[str],
    at_most: list[str],
    plants: int,
    seed: int,
    candidates: Candidates,
) -> list[float]: ...
def compare(
    preset: str, controllers: list[tuple[str, str | None]], plants: int, seed: int
) -> list[tuple[Array, str]]: ...
def compare_chunk(
    preset: str, controllers: list[tuple[str, str | None]], plants: int, seed: int, first: int, end: int
) -> bytes: ...
def compare_chunks(
    preset: str, controllers: list[tuple[str, str | None]], plants: int, seed: int, chunks: list[bytes]
) -> list[tuple[Array, str]]: ...
def draw(preset: str, count: int, seed: int) -> list[str]: ...
def linearize(preset: str, pitch: float) -> tuple[Array, Array, Array, Array, tuple[float, float]]: ...
def margins(preset: str, gains: str | None, rotor_lag: float | None) -> str: ...
def identify(
    logs: list[Log],
    validate: list[Log],
    preset: str,
    columns: str,
    free: list[str],
    fix: list[str],
    window: float,
    population: int,
    iterations: int,
    seed: int,
    rotor_lag: float | None,
    progress: Callable[[str, float], object] | None,
) -> tuple[str, str]: ...
def replay(
    log: Log,
    preset: str,
    gains: str | None,
    columns: str,
    scenario: str | None,
    rotor_lag: float | None,
) -> tuple[dict[str, Array], str]: ...
def coverage_chunk(studied: Studied, first: int, end: int) -> bytes: ...
def coverage_chunks(studied: Studied, chunks: list[bytes]) -> str: ...
def bench_tuner(
    preset: str, algorithm: str, seed: int, population: int | None, iterations: int
) -> tuple[str, str]: ...
def standings(peers: list[tuple[str, list[tuple[float, list[tuple[int, float]]]]]]) -> tuple[float, str]: ...
def rank_sum(a: list[float], b: list[float]) -> float: ...
def holm(p_values: list[float]) -> list[float]: ...

class ControlLoop:
    def __new__(
        cls,
        preset: str,
        gains: str | None,
        counters: tuple[int, int],
        counter_bits: int,
        checked: bool,
    ) -> Self: ...
    def request(self, what: str) -> None: ...
    def zero(self) -> None: ...
    def aim(
        self, angle: tuple[float, float], rate: tuple[float, float], accel: tuple[float, float]
    ) -> None: ...
    def tick(self, pitch: int, yaw: int, supply: float) -> tuple[float, float]: ...
    @property
    def state(self) -> str: ...
    @property
    def fault(self) -> str | None: ...
    @property
    def conditions(self) -> list[str]: ...
    @property
    def motors_may_turn(self) -> bool: ...
    def frame(self) -> dict[str, object]: ...

class Bench:
    supply: float
    def __new__(cls, preset: str) -> Self: ...
    def tick(self, volts: tuple[float, float], enabled: bool = True, ticks: int = 1) -> None: ...
    def place(self, pitch: float, yaw: float) -> None: ...
    @property
    def counts(self) -> tuple[int, int]: ...
    @property
    def counters(self) -> tuple[int, int]: ...
    @property
    def state(self) -> tuple[tuple[float, float], tuple[float, float]]: ...
    @property
    def disturbance(self) -> None: ...
    @disturbance.setter
    def disturbance(self, volts: tuple[float, float]) -> None: ...
    @property
    def table(self) -> None: ...
    @table.setter
    def table(self, table: bool) -> None: ...
    @property
    def encoder_stuck(self) -> None: ...
    @encoder_stuck.setter
    def encoder_stuck(self, stuck: tuple[bool, bool]) -> None: ...
    @property
    def encoder_reversed(self) -> None: ...
    @encoder_reversed.setter
    def encoder_reversed(self, reversed: tuple[bool, bool]) -> None: ...

class SimulatedBoard:
    def __new__(cls, preset: str, gains: str | None, checked: bool) -> Self: ...
    def request(self, what: str) -> None: ...
    def zero(self) -> None: ...
    def aim(
        self, angle: tuple[float, float], rate: tuple[float, float], accel: tuple[float, float]
    ) -> None: ...
    def tick(self) -> None: ...
    @property
    def state(self) -> str: ...
    def frame(self) -> dict[str, object]: ...

class Batch:
    def __new__(
        cls,
        preset: str,
        count: int,
        action: str,
        gains: str | None,
        supervised: bool,
        true_rig: str | None,
        spread: bool,
        seconds: float,
        autoreset: str,
        threads: int | None,
    ) -> Self: ...
    @property
    def count(self) -> int: ...
    @property
    def threads(self) -> int: ...
    def reset(
        self, mask: npt.NDArray[np.bool_], seeds: npt.NDArray[np.uint64] | None, observations: Rows
    ) -> None: ...
    def step(
        self,
        actions: Rows,
        observations: Rows,
        finals: Rows,
        rewards: Array,
        terminated: npt.NDArray[np.bool_],
        truncated: npt.NDArray[np.bool_],
    ) -> None: ...
    def goals(self) -> Rows: ...
