"""What is wrong is told with field, value and what is allowed; Ctrl-C ends what takes long."""

import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
import twinrotor as tr


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: tr.simulate("areo"), "did you mean 'aero'"),
        (lambda: tr.simulate(gains="nowhere.toml"), "nowhere.toml"),
        (lambda: tr.simulate(scenario="4"), "unknown scenario '4'; did you mean"),
        (lambda: tr.simulate(duration=-1.0), "duration is -1"),
        (lambda: tr.simulate(fidelity="real"), "unknown fidelity 'real'"),  # type: ignore[arg-type]
        (lambda: tr.tune(algorithm="fpa"), "unknown algorithm 'fpa'; did you mean"),
        (lambda: tr.tune(bounds=(0.0, 25.0)), "bounds"),
        (lambda: tr.tune(population=0), "population"),
        (lambda: tr.tune_robust("aero2", parameters=["pitch.postion"]), "postion"),
        (lambda: tr.compare("aero2", {"own": None}, plants=0), "plants is 0; allowed: 1 to 100000"),
        (lambda: tr.linearize("aero2", float("nan")), "pitch is NaN"),
        (lambda: tr.ControlLoop("aero2", counter_bits=8), "counter_bits is 8; allowed: 16, 24"),
        (lambda: tr.draw("aero2", 0), "count is 0"),
        (lambda: tr.margins("aero2", rotor_lag=-1.0), "rotor_lag is -1; allowed"),
        (lambda: tr.margins(tr.draw("aero2", 1)[0]), "gains is left out"),
    ],
)
def test_bad_input_is_a_value_error(call: Callable[[], object], told: str) -> None:
    with pytest.raises(ValueError, match=r".") as raised:
        call()
    assert told in str(raised.value)


def test_a_file_with_a_fault_is_told_by_its_field(tmp_path: Path) -> None:
    text = tr.Rig.of("aero2").toml.replace("mass = 1.07", "mass = -1.0")
    path = tmp_path / "rig.toml"
    path.write_text(text)
    with pytest.raises(ValueError, match="mass is -1; allowed"):
        tr.simulate(path)


def test_an_exception_in_progress_ends_the_search() -> None:
    seen: list[int] = []

    def progress(evaluations: int, budget: int, best: float) -> None:
        seen.append(evaluations)
        assert budget == 1550 and best > 0.0
        if len(seen) == 3:
            raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        tr.tune(progress=progress)
    assert len(seen) == 3 and seen == sorted(seen)


@pytest.mark.parametrize(
    "call",
    [
        "t.tune_robust('heli', plants=999)",
        "t.identify(t.simulate('aero2', None, '2', fidelity='rig').log, 'aero2')",
    ],
)
def test_ctrl_c_ends_what_takes_long_within_a_second(call: str) -> None:
    text = (
        # A shell's job in the background is begun with Ctrl-C ignored.
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler);"
        f"import twinrotor as t; print('begun', flush=True); {call}"
    )
    process = subprocess.Popen([sys.executable, "-c", text], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None and process.stdout.readline() == b"begun\n"
    time.sleep(1.5)
    process.send_signal(signal.SIGINT)
    begun = time.monotonic()
    try:
        _, stderr = process.communicate(timeout=20)
    finally:
        process.kill()
    # A second, and as much again where other work keeps the machine busy.
    assert time.monotonic() - begun < 2.0
    assert b"KeyboardInterrupt" in stderr
