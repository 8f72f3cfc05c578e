#!/usr/bin/env bash
# How fast the closed loop runs here and as one would write it elsewhere, side by side in one run on this
# machine: plain C, Numba, SciPy, and mealpy's FPA around the Numba loop. Prints a table; ratios are to plain
# C.
set -euo pipefail
cd "$(dirname "$0")/../.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cargo build --release -q -p host-sim
sim=${CARGO_TARGET_DIR:-target}/release/host-sim
gcc -O3 -march=native -std=gnu11 -Wall -Wextra benches/rivals/closed_loop.c -lm -o "$work/closed_loop"
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install -q -r benches/rivals/requirements.txt

"$work/closed_loop" >"$work/c.txt"
"$sim" bench --json >"$work/bench.json"
"$work/venv/bin/python" benches/rivals/closed_loop.py >"$work/python.txt"
"$work/closed_loop" >>"$work/c.txt"
"$sim" tune --json >"$work/tune.json"

"$work/venv/bin/python" - "$work" <<'PYTHON'
import json
import sys

work = sys.argv[1]
read = lambda name: [line.split() for line in open(f"{work}/{name}")]
c = max(float(v) for k, v in read("c.txt") if k == "steps_per_second")
python = {k: float(v) for k, v in read("python.txt")}
bench, tune = json.load(open(f"{work}/bench.json")), json.load(open(f"{work}/tune.json"))
rates = {k["name"]: k["steps_per_second"] for k in bench["kernels"]}
rows = [("SciPy, solve_ivp", python["scipy"]), ("Numba, f64", python["numba"])]
rows += [("C, gcc -O3 -march=native, f32", c)]
rows += [(f"Twinrotor, {name}", rates[name]) for name in rates]
print(bench["machine"])
print("| the paper's step | steps/s, one core | ratio to C |\n|---|---|---|")
for name, rate in rows:
    print(f"| {name} | {rate:.2e} | {rate / c:.2g} |")
print("\n| the paper's tune, 50 flowers x 30 iterations | seconds | ISE |\n|---|---|---|")
print(f"| mealpy's FPA, Numba loop | {python['mealpy_tune_s']:.2f} | {python['mealpy_ise']:.5f} |")
print(f"| Twinrotor, all cores | {tune['wall_s']:.3f} | {tune['cost']:.5f} |")
ise = f"C {read('c.txt')[0][1]}, Numba {python['ise_numba']}, SciPy (continuous) {python['ise_scipy']}"
print(f"\nISE of the paper's gains: {ise}")
PYTHON
