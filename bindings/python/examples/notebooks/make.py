"""Makes a notebook of each script here, with what it prints and draws: no Jupyter is needed for that.

    python examples/notebooks/make.py            # runs the scripts, writes the notebooks
    python examples/notebooks/make.py --check    # runs the scripts; are the notebooks theirs?

A script's cells begin with ``# %%``, those of text with ``# %% [markdown]``, as editors and jupytext know
them.
"""

from __future__ import annotations

import argparse
import base64
import contextlib
import io
import json
import sys
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).resolve().parent
Cell = dict[str, Any]


def cells(script: str) -> list[Cell]:
    """A script's, none of which has run."""
    found: list[Cell] = []
    for number, piece in enumerate(script.split("# %%")[1:]):
        head, _, body = piece.partition("\n")
        text = body.strip("\n")
        if "[markdown]" in head:
            text = "\n".join(line.removeprefix("#").removeprefix(" ") for line in text.splitlines())
            cell: Cell = {"cell_type": "markdown"}
        else:
            cell = {"cell_type": "code", "execution_count": None, "outputs": []}
        found.append(
            cell | {"id": f"cell-{number}", "metadata": {}, "source": text.splitlines(keepends=True)}
        )
    return found


def run(found: list[Cell], name: str) -> None:
    """Runs them in their order, and keeps what they print and draw."""
    names: dict[str, Any] = {"__name__": "__main__"}
    count = 0
    for cell in found:
        if cell["cell_type"] != "code":
            continue
        count += 1
        told = io.StringIO()
        with contextlib.redirect_stdout(told):
            exec(compile("".join(cell["source"]), f"{name}, cell {count}", "exec"), names)
        outputs: list[Cell] = []
        if told.getvalue():
            lines = told.getvalue().splitlines(keepends=True)
            outputs.append({"output_type": "stream", "name": "stdout", "text": lines})
        for number in plt.get_fignums():
            drawn = io.BytesIO()
            plt.figure(number).savefig(drawn, dpi=80, bbox_inches="tight", metadata={"Software": None})
            picture = {"image/png": base64.b64encode(drawn.getvalue()).decode() + "\n"}
            outputs.append({"output_type": "display_data", "data": picture, "metadata": {}})
        plt.close("all")
        cell["execution_count"], cell["outputs"] = count, outputs


def sources(found: list[Cell]) -> list[tuple[str, str]]:
    """What they are, whatever came of them."""
    return [(cell["cell_type"], "".join(cell["source"])) for cell in found]


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    sys.path.insert(0, str(HERE.parent))
    stale = []
    for script in sorted(HERE.glob("*.py")):
        if script.name == "make.py":
            continue
        found = cells(script.read_text())
        notebook = script.with_suffix(".ipynb")
        if check and (
            not notebook.exists() or sources(json.loads(notebook.read_text())["cells"]) != sources(found)
        ):
            stale.append(notebook.name)
        run(found, script.name)
        if not check:
            kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
            whole = {"cells": found, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}
            notebook.write_text(json.dumps(whole, indent=1, ensure_ascii=False) + "\n")
    for name in stale:
        print(f"{name} is not its script's: run this without --check", file=sys.stderr)
    return bool(stale)


if __name__ == "__main__":
    sys.exit(main())
