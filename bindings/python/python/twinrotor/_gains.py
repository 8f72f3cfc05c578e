"""Rigs, gains and the table of settings."""

from __future__ import annotations

import json
import os
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from . import _native


def presets() -> list[str]:
    """The names of the rigs that are built in."""
    return _native.presets()


@dataclass(frozen=True)
class Rig:
    """A machine: its name, and its preset file as text."""

    name: str
    toml: str = field(repr=False)

    @classmethod
    def of(cls, preset: RigLike) -> Rig:
        """The preset of that name, or the one in the file at that path.

        :raises ValueError: if there is none, or its file is not one of a rig that could be.
        """
        if isinstance(preset, Rig):
            return preset
        return cls(*_native.rig(os.fspath(preset)))

    @property
    def constants(self) -> dict[str, Any]:
        """What its preset file says, SI units."""
        return tomllib.loads(self.toml)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes its preset file."""
        Path(path).write_text(self.toml)


RigLike = Rig | str | os.PathLike[str]


def rig_text(preset: RigLike) -> str:
    """A name as it is: what a preset's own gains and allowances go by."""
    if isinstance(preset, Rig):
        return preset.name if preset.name in presets() else preset.toml
    return os.fspath(preset)


@dataclass(frozen=True)
class Gains:
    """A controller with its numbers: a gains file's text."""

    toml: str

    @classmethod
    def load(cls, gains: str | os.PathLike[str] = "paper") -> Gains:
        """Those of the paper's Table 4 (``"paper"``), or of the file at that path.

        :raises ValueError: if there is no such file, or it is none of gains.
        """
        return cls(_native.gains(os.fspath(gains), "paper"))

    @classmethod
    def of_preset(cls, preset: RigLike) -> Gains:
        """Those that the preset's board boots with.

        :raises ValueError: if it is a rig of your own, which has none.
        """
        return cls(_native.gains(None, rig_text(preset)))

    @property
    def values(self) -> dict[str, Any]:
        """What its file says."""
        return tomllib.loads(self.toml)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the file that ``host-sim`` flies and flashes."""
        Path(path).write_text(self.toml)


GainsLike = Gains | str | os.PathLike[str] | None


def gains_text(gains: GainsLike) -> str | None:
    if gains is None:
        return None
    return gains.toml if isinstance(gains, Gains) else os.fspath(gains)


@dataclass(frozen=True)
class Setting:
    """A number of a controller that a person may choose, as the core declares it."""

    name: str
    part: str
    kind: str | None
    unit: str
    allowed: str
    least: float | None
    most: float | None
    typical: tuple[float, float]
    default: float | None
    explanation: str


def settings() -> list[Setting]:
    """All of them."""
    rows = json.loads(_native.settings())
    return [Setting(**{**row, "typical": tuple(row["typical"])}) for row in rows]
