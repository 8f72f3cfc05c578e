#!/usr/bin/env python3
"""Reads what `simulate --export` wrote with the tools that people use; compares every number with the CSV.

    pip install numpy pyarrow mcap
    cargo run -p host-sim --features formats simulate --csv run.csv --export run.parquet
    (then run.mcap, run.npz)
    scripts/read-exports.py run.csv run.parquet run.mcap run.npz
"""

import csv
import json
import sys

import numpy as np


def from_csv(path):
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    return {name: np.array([float(row[k]) for row in rows[1:]]) for k, name in enumerate(rows[0])}


def from_parquet(path):
    import pyarrow.parquet

    table = pyarrow.parquet.read_table(path)
    return {name: table[name].to_numpy() for name in table.column_names}


def from_mcap(path):
    from mcap.reader import make_reader

    with open(path, "rb") as file:
        messages = list(make_reader(file).iter_messages(topics=["/flight"]))
    told = [json.loads(message.data) for _, _, message in messages]
    assert all(abs(m.log_time * 1e-9 - t["t"]) < 1e-9 for (_, _, m), t in zip(messages, told))
    return {name: np.array([t[name] for t in told]) for name in told[0]}


def from_npz(path):
    return dict(np.load(path))


READERS = {"csv": from_csv, "parquet": from_parquet, "mcap": from_mcap, "npz": from_npz}


def main(reference, *others):
    expected = from_csv(reference)
    for path in others:
        found = READERS[path.rsplit(".", 1)[-1]](path)
        assert set(found) == set(expected), f"{path}: columns {sorted(found)}"
        for name, values in expected.items():
            assert np.array_equal(found[name], values), f"{path}: {name} differs"
        print(f"{path}: {len(expected)} columns of {len(values)} numbers, all as in {reference}")


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
