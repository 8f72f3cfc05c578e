"""The command line beside the package: what both compute is to be the same."""

import csv
import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

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
