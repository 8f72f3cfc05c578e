"""Logs of real rigs, as files or as arrays."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any, Protocol, cast

import numpy as np
import numpy.typing as npt

from . import _native


class Columns(Protocol):
    """Arrays by name: a dict, the ``log`` of a flight, a pandas frame; of a polars one its ``to_dict()``."""

    def keys(self) -> Iterable[Any]: ...
    def __getitem__(self, name: Any, /) -> npt.ArrayLike: ...


#: The path of a CSV file, or its columns ``t``, ``pitch``, ``yaw``, ``v0``, ``v1`` as arrays.
LogLike = str | os.PathLike[str] | Columns


def given(log: LogLike, name: str) -> _native.Log:
    """As the engine takes it; ``name`` is what arrays go by in what is said of them.

    :raises ValueError: if a column is not one of numbers.
    """
    if isinstance(log, str | os.PathLike):
        return os.fspath(log), None
    columns = []
    for column in log.keys():  # noqa: SIM118, as frames have it
        try:
            array = np.ascontiguousarray(log[column], dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise ValueError(f"{name}: column '{column}' is no array of numbers: {error}") from None
        if array.ndim != 1:
            raise ValueError(f"{name}: dimensions of column '{column}' is {array.ndim}; allowed: 1")
        columns.append((str(column), array))
    return name, columns


def all_given(logs: LogLike | Iterable[LogLike], name: str) -> list[_native.Log]:
    """The same of one or several."""
    if isinstance(logs, str | os.PathLike) or hasattr(logs, "keys"):
        return [given(cast(LogLike, logs), name)]
    return [given(log, f"{name} {number}") for number, log in enumerate(logs, 1)]
