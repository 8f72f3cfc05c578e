"""Units as a master sees them, through fmpy: valid, and with the bits of the command line."""

from __future__ import annotations

import csv
import os
import random
import resource
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

ROOT = Path(__file__).resolve().parents[3]
PROGRAMS = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "debug"
PRESETS = ["paper", "paper-fixed", "aero", "aero2", "aero-lab", "heli"]
KINDS = ["plant", "controller", "loop"]
PITCH, YAW = 0.25, -0.6


@pytest.fixture(scope="session")
def units(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with PRESET-KIND.fmu of all of them."""
    folder = tmp_path_factory.mktemp("units")
    for preset in PRESETS:
        for kind in KINDS:
            out = folder / f"{preset}-{kind}.fmu"
            flags = ["--preset", preset, "--what", kind, "--out", str(out)]
            subprocess.run([PROGRAMS / "fmu", *flags], check=True, stdout=subprocess.DEVNULL)
    return folder


class Unit:
    """An instance with variables by name."""

    def __init__(self, path: Path, guid: str | None = None) -> None:
        self.description = read_model_description(str(path))
        self.folder = extract(str(path))
        self.reference = {v.name: v.valueReference for v in self.description.modelVariables}
        self.slave = FMU2Slave(
            guid=guid or self.description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="unit",
        )
        self.slave.instantiate()
        self.time = 0.0

    def begin(self) -> Unit:
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()
        return self

    def set(self, **values: float) -> None:
        names = [name.replace("__", ".") for name in values]
        self.slave.setReal([self.reference[name] for name in names], list(values.values()))

    def get(self, *names: str) -> list[float]:
        return list(self.slave.getReal([self.reference[name] for name in names]))

    def step(self, size: float = 0.001) -> None:
        self.slave.doStep(currentCommunicationPoint=self.time, communicationStepSize=size)
        self.time += size

    def close(self) -> None:
        self.slave.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


@pytest.fixture
def unit(units: Path) -> Iterator:
    opened: list[Unit] = []

    def make(name: str, **arguments: str) -> Unit:
        opened.append(Unit(units / f"{name}.fmu", **arguments))
        return opened[-1]

    yield make
    for one in opened:
        one.close()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("preset", PRESETS)
def test_a_validator_has_nothing_to_say(units: Path, preset: str, kind: str) -> None:
    assert validate_fmu(str(units / f"{preset}-{kind}.fmu")) == []


def simulated(preset: str, folder: Path) -> list[dict[str, float]]:
    """The same from the command line, tick by tick."""
    scenario = folder / "jump.toml"
    degrees = [value * 180.0 / 3.141592653589793 for value in (PITCH, YAW)]
    text = "duration = 3.0\n" + "".join(
        f"[{axis}.steps]\njumps = [[0.0, {value!r}]]\n" for axis, value in zip(("pitch", "yaw"), degrees)
    )
    scenario.write_text(text)
    gains = ROOT / "gains" / f"{preset}.toml"
    flags = ["--preset", preset, "--gains", str(gains), "--scenario", str(scenario), "--fidelity", "rig"]
    out = folder / "flight.csv"
    program = [PROGRAMS / "host-sim", "simulate", *flags, "--csv", str(out)]
    subprocess.run(program, check=True, stdout=subprocess.DEVNULL)
    with out.open() as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


GAIN = "controller.pitch.position"
STATE = {"angle.pitch": "theta", "angle.yaw": "psi", "rate.pitch": "theta_dot", "rate.yaw": "psi_dot"}


@pytest.mark.parametrize("milliseconds", [1, 10, 50])
@pytest.mark.parametrize("preset", ["aero2", "heli"])
def test_the_loop_flies_the_command_lines_bits(unit, tmp_path: Path, preset: str, milliseconds: int) -> None:
    rows = simulated(preset, tmp_path)
    loop = unit(f"{preset}-loop").begin()
    # What the command line made of the angle in degrees.
    loop.set(setpoint__pitch=rows[0]["theta_ref"], setpoint__yaw=rows[0]["psi_ref"])
    for tick in range(0, 3_000, milliseconds):
        assert loop.get(*STATE) == [rows[tick][name] for name in STATE.values()], tick
        loop.step(milliseconds * 1e-3)
    assert loop.get("armed") == [1.0]
    assert abs(loop.get("angle.pitch")[0] - PITCH) < 0.05


@pytest.mark.parametrize("preset", ["aero2", "heli", "paper"])
def test_plant_and_controller_coupled_are_the_loop(unit, preset: str) -> None:
    loop, plant, board = (unit(f"{preset}-{kind}").begin() for kind in ("loop", "plant", "controller"))
    for both in (loop, board):
        both.set(setpoint__pitch=PITCH, setpoint__yaw=YAW)
    for tick in range(3_000):
        assert plant.get(*STATE) == loop.get(*STATE), tick
        if tick == 1_000:
            # A trial in both.
            for both in (loop, board):
                both.set(controller__pitch__position=0.9 * both.get(GAIN)[0])
        pitch, yaw, supply = plant.get("counts.pitch", "counts.yaw", "supply")
        main, tail = board.get("volts.main", "volts.tail")
        board.set(counts__pitch=pitch, counts__yaw=yaw, supply=supply)
        plant.set(volts__main=main, volts__tail=tail)
        for one in (loop, plant, board):
            one.step()
    assert board.get("armed") == [1.0] and abs(plant.get("angle.pitch")[0] - PITCH) < 0.05


def test_a_hundred_rollbacks_are_the_straight_run(unit) -> None:
    straight, wild = unit("aero2-loop").begin(), unit("aero2-loop").begin()
    chance = random.Random(3)
    for _ in range(100):
        setpoint = {"setpoint__pitch": chance.uniform(-0.2, 0.2), "setpoint__yaw": chance.uniform(-0.5, 0.5)}
        state, time = wild.slave.getFMUstate(), wild.time
        # Elsewhere, and back.
        wild.set(setpoint__pitch=0.3, disturbance__main=2.0)
        for _ in range(chance.randrange(1, 5)):
            wild.step(0.01)
        wild.slave.setFMUstate(state)
        wild.slave.freeFMUstate(state)
        wild.time = time
        for one in (straight, wild):
            one.set(**setpoint)
            one.step(0.02)
        assert straight.get(*STATE) == wild.get(*STATE)


def test_a_hundred_states_as_bytes_are_the_straight_run(unit) -> None:
    """Each in another instance, with a parameter that was set before it began."""
    straight = unit("aero2-loop")
    value = 0.8 * straight.get("controller.pitch.position")[0]
    straight.set(controller__pitch__position=value)
    straight.begin()
    others = [unit("aero2-loop").begin() for _ in range(2)]
    chance = random.Random(4)
    for k in range(100):
        straight.set(setpoint__pitch=chance.uniform(-0.2, 0.2), disturbance__main=chance.uniform(-1.0, 1.0))
        state = straight.slave.getFMUstate()
        data = straight.slave.serializeFMUstate(state)
        straight.slave.freeFMUstate(state)
        one = others[k % 2]
        there = one.slave.deSerializeFMUstate(data)
        one.slave.setFMUstate(there)
        one.slave.freeFMUstate(there)
        one.time = straight.time
        for each in (straight, one):
            each.step(0.03)
        assert straight.get(*STATE) == one.get(*STATE), k
        assert one.get("controller.pitch.position") == [value]


def test_bytes_that_are_no_state_of_this_unit_are_refused(unit) -> None:
    one, other = unit("aero2-loop").begin(), unit("heli-loop").begin()
    state = other.slave.getFMUstate()
    data = other.slave.serializeFMUstate(state)
    other.slave.freeFMUstate(state)
    for wrong in (data, data[:-1], b"", bytes([data[0] ^ 1]) + data[1:]):
        with pytest.raises(FMICallException):
            one.slave.deSerializeFMUstate(wrong)
    one.step()


def test_a_parameter_changes_the_flight_before_it_begins(unit) -> None:
    own, other = unit("aero2-loop"), unit("aero2-loop")
    (value,) = own.get(GAIN)
    other.set(**{GAIN.replace(".", "__"): 0.5 * value})
    for one in (own, other):
        one.begin()
        one.set(setpoint__pitch=PITCH)
        one.step(0.5)
    assert own.get("angle.pitch") != other.get("angle.pitch")
    other.slave.reset()
    assert other.get(GAIN) == [value]


def test_a_parameter_set_in_flight_is_a_trial(unit) -> None:
    """A shadow for 300 ms, faded in for 100, alone from then on, and accepted."""
    own, same, other = (unit("aero2-loop").begin() for _ in range(3))
    (value,) = own.get(GAIN)

    def step(size: float) -> None:
        for one in (own, same, other):
            one.step(size)

    def aim(pitch: float) -> None:
        for one in (own, same, other):
            one.set(setpoint__pitch=pitch)

    # What a board has seen of its own errors is what a trial is judged by.
    aim(PITCH)
    step(3.0)
    aim(0.0)
    step(1.0)
    same.set(**{GAIN.replace(".", "__"): value})
    other.set(**{GAIN.replace(".", "__"): 0.8 * value})
    assert own.get(*STATE) == other.get(*STATE)
    step(0.3)
    assert own.get(*STATE) == other.get(*STATE), "a shadow turns no motor"
    for _ in range(20):
        step(0.1)
        # A controller that is its own trial gives the same bits.
        assert own.get(*STATE) == same.get(*STATE)
    assert own.get(*STATE) != other.get(*STATE)
    assert other.get(GAIN) == [0.8 * value] and own.get(GAIN) == [value]


def test_a_trial_that_tracks_badly_is_taken_back(unit) -> None:
    one = unit("aero2-loop").begin()
    (value,) = one.get(GAIN)
    one.step(1.0)
    # The board has seen next to no error of its own, and a turn costs a trial more than a degree.
    one.set(setpoint__pitch=PITCH, controller__pitch__position=0.5 * value)
    assert one.get(GAIN) == [0.5 * value]
    one.step(4.0)
    assert one.get(GAIN) == [value]
    assert one.get("armed") == [1.0]
    with pytest.raises(FMICallException):
        one.set(controller__pitch__position=-1.0)
    assert one.get(GAIN) == [value]


def test_a_trial_under_way_is_part_of_a_state(unit) -> None:
    """As a copy and as bytes, before, in the middle of and after it."""
    straight, copy, read = (unit("aero2-loop").begin() for _ in range(3))
    (value,) = straight.get(GAIN)
    for k in range(40):
        straight.set(setpoint__pitch=0.1 if k % 7 < 4 else -0.1)
        if k % 20 == 2:
            straight.set(controller__pitch__position=(0.8 if k == 2 else 1.2) * value)
        state = straight.slave.getFMUstate()
        data = straight.slave.serializeFMUstate(state)
        copy.slave.setFMUstate(state)
        straight.slave.freeFMUstate(state)
        state = read.slave.deSerializeFMUstate(data)
        read.slave.setFMUstate(state)
        read.slave.freeFMUstate(state)
        copy.time = read.time = straight.time
        for one in (straight, copy, read):
            one.step(0.1)
        there = straight.get(*STATE, GAIN)
        assert there == copy.get(*STATE, GAIN) == read.get(*STATE, GAIN), k
    assert straight.get(GAIN) == [1.2 * value]


def test_every_setting_of_the_table_is_a_parameter_with_its_range(units: Path) -> None:
    description = read_model_description(str(units / "aero2-controller.fmu"))
    parameters = [v for v in description.modelVariables if v.causality == "parameter"]
    assert len(parameters) > 20 and all(v.description for v in parameters)
    position = next(v for v in parameters if v.name == "controller.pitch.position")
    assert (position.unit, position.min, position.variability) == ("1/s", "0.0", "tunable")


@pytest.mark.parametrize(
    "wrong",
    [
        lambda unit: unit.set(setpoint__pitch=float("nan")),
        lambda unit: unit.set(disturbance__tail=float("inf")),
        lambda unit: unit.set(angle__pitch=0.1),
        lambda unit: unit.step(0.0015),
        lambda unit: unit.step(0.0),
        lambda unit: unit.step(-0.001),
        lambda unit: unit.slave.doStep(currentCommunicationPoint=0.5, communicationStepSize=0.001),
        lambda unit: unit.slave.getReal([9_999]),
        lambda unit: unit.slave.setReal([4_000_000_000], [0.0]),
        lambda unit: unit.slave.getInteger([0]),
    ],
)
def test_what_is_wrong_is_an_error_and_the_unit_flies_on(unit, wrong) -> None:
    sound, tried = unit("aero2-loop").begin(), unit("aero2-loop").begin()
    with pytest.raises(FMICallException):
        wrong(tried)
    for one in (sound, tried):
        one.set(setpoint__pitch=PITCH)
        one.step(0.1)
    assert sound.get(*STATE) == tried.get(*STATE)


def test_a_parameter_out_of_range_is_refused(unit) -> None:
    one = unit("aero2-loop")
    before = one.get("controller.pitch.position")
    with pytest.raises(FMICallException):
        one.set(controller__pitch__position=-1.0)
    assert one.get("controller.pitch.position") == before


def test_another_units_guid_is_refused_with_a_sentence(unit, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(Exception, match="instantiate"):
        unit("aero2-loop", guid="{00000000-0000-0000-0000-000000000000}")
    told = "".join(capfd.readouterr())
    assert "guid" in told and "allowed" in told


def test_a_thousand_instances_come_and_go(units: Path) -> None:
    path = units / "aero2-loop.fmu"
    one = Unit(path)
    one.close()
    description, folder = read_model_description(str(path)), extract(str(path))

    def cycle(count: int) -> int:
        for _ in range(count):
            slave = FMU2Slave(
                guid=description.guid,
                unzipDirectory=folder,
                modelIdentifier=description.coSimulation.modelIdentifier,
                instanceName="unit",
            )
            slave.instantiate()
            slave.setupExperiment(startTime=0.0)
            slave.enterInitializationMode()
            slave.exitInitializationMode()
            slave.doStep(currentCommunicationPoint=0.0, communicationStepSize=0.01)
            # Not `freeInstance`, which also unloads the library.
            slave.fmi2FreeInstance(slave.component)
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    before = cycle(200)
    grown = cycle(1_000) - before
    shutil.rmtree(folder)
    assert grown < 4_096, f"{grown} KiB more after a thousand"


def test_bad_flags_are_told() -> None:
    cases = [
        (["--what", "board"], "unknown what 'board'"),
        (["--preset", "areo"], "did you mean 'aero'"),
        (["--gains", "nowhere.toml"], "nowhere.toml"),
    ]
    for flags, sentence in cases:
        ended = subprocess.run(
            [PROGRAMS / "fmu", *flags, "--out", "never.fmu"], capture_output=True, text=True, check=False
        )
        assert ended.returncode == 2 and sentence in ended.stderr, ended
        assert not Path("never.fmu").exists()
