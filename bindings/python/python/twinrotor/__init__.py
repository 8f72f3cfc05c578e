"""Twinrotor: a two-rotor laboratory helicopter, its controllers and their tuning, with the bits that fly.

Rigs are presets by name (:func:`presets`), paths of preset files, or a :class:`Rig`. Gains are what a
preset's board boots with (``None``), ``"paper"``, paths of gains files, or :class:`Gains`. Scenarios are
names, paths of files or TOML text. Angles are in rad, times in s, volts in V.

What is wrong raises ``ValueError`` with field, value and what is allowed.
"""

from ._batch import Batch, Stepped
from ._board import Bench, Controller, ControlLoop, Fault, Port, SimulatedBoard
from ._contest import Standing, holm, rank_sum, standings
from ._coverage import Coverage, Covered, coverage
from ._flight import Flight, simulate
from ._gains import Gains, GainsLike, Rig, RigLike, Setting, presets, settings
from ._identify import Constant, Fit, Identified, identify
from ._linear import Linear, linearize
from ._margins import Margins, margins
from ._replay import Replay, replay
from ._search import AtBound, Comparison, Tuned, compare, draw, tune, tune_robust

__all__ = [
    "AtBound",
    "Batch",
    "Bench",
    "Comparison",
    "Constant",
    "ControlLoop",
    "Controller",
    "Coverage",
    "Covered",
    "Fault",
    "Fit",
    "Flight",
    "Gains",
    "GainsLike",
    "Identified",
    "Linear",
    "Margins",
    "Port",
    "Replay",
    "Rig",
    "RigLike",
    "Setting",
    "SimulatedBoard",
    "Standing",
    "Stepped",
    "Tuned",
    "compare",
    "coverage",
    "draw",
    "holm",
    "identify",
    "linearize",
    "margins",
    "presets",
    "rank_sum",
    "replay",
    "settings",
    "simulate",
    "standings",
    "tune",
    "tune_robust",
]
__version__ = "0.1.0"
