"""The command line beside the package: what both compute is to be the same."""

import csv
import importlib
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def host_sim(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """Runs a command in a folder of its own, which it answers."""
    named = os.environ.get("TWINROTOR_HOST_SIM") or shutil.which("host-sim")
    program = Path(named) if named else ROOT / "target" / "debug" / "host-sim"
    if not program.exists():
        subprocess.run(["cargo", "build", "--quiet", "-p", "host-sim"], cwd=ROOT, check=True)

    def run(*arguments: str) -> Path:
        folder = tmp_path_factory.mktemp("host-sim")
        with (folder / "stdout").open("w") as stdout:
            subprocess.run([program, *arguments], cwd=folder, stdout=stdout, check=True)
        return folder

    return run


def columns(path: Path) -> dict[str, list[float]]:
    """A CSV file's."""
    with path.open() as file:
        rows = list(csv.DictReader(file))
    return {name: [float(row[name]) for row in rows] for name in rows[0]}


@pytest.fixture
def at_the_panel(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Any]:
    """Imports an example that flies an Aero's USB panel, with a stand-in for the manufacturer's library.

    It goes as fast as it can: the stand-in's time is its reads.
    """
    here = Path(__file__).resolve().parent
    monkeypatch.syspath_prepend(str(here / "quanser"))
    monkeypatch.syspath_prepend(str(here.parent / "examples"))
    clock = {"now": 0.0}

    def now() -> float:
        clock["now"] += 1e-4
        return clock["now"]

    def imported(example: str) -> Any:
        for name in ("quanser", "quanser.hardware", "aero_usb", "record_aero"):
            sys.modules.pop(name, None)
        module = importlib.import_module(example)
        monkeypatch.setattr(module.time, "perf_counter", now)
        return module

    return imported


def is_off(card: Any) -> bool:
    """No volts, no amplifier enabled, and the card is closed."""
    return card.volts == (0.0, 0.0) and not card.enabled and card.watchdog is None and not card.is_open
