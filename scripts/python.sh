#!/usr/bin/env bash
# The Python package: formatted, linted, installed as its README says, typed, tested.
set -euo pipefail
cd "$(dirname "$0")/../bindings/python"

cargo fmt --check
# Lints share a folder with pip's build, which does not know the repository's settings.
own="$PWD/target"
CARGO_TARGET_DIR=$own cargo clippy --release --all-targets -- -D warnings
folder=../../target/python
[ -x "$folder/venv/bin/python" ] || python3 -m venv "$folder/venv"
CARGO_TARGET_DIR=$own "$folder/venv/bin/pip" install -q --disable-pip-version-check ".[test]"
"$folder/venv/bin/python" -c 'import twinrotor'
"$folder/venv/bin/ruff" format --check --quiet .
"$folder/venv/bin/ruff" check --quiet .
"$folder/venv/bin/python" -m mypy --strict tests examples examples/notebooks/make.py benches python/twinrotor
"$folder/venv/bin/python" -m pytest -q tests
"$folder/venv/bin/python" examples/notebooks/make.py --check
