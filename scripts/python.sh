#!/usr/bin/env bash
# The Python package: formatted, linted, installed as its README says, typed, tested.
set -euo pipefail
cd "$(dirname "$0")/../bindings/python"

cargo fmt --check
# Lints share a folder with pip's build, which does not know the repository's settings.
own="$PWD/target"
CARGO_TARGET_DIR=$own cargo clippy --release --all-targets -- -D warnings
folder=../../target/python
python=$folder/venv/bin/python
[ -x "$python" ] || python3 -m venv "$folder/venv"
CARGO_TARGET_DIR=$own "$python" -m pip install -q --disable-pip-version-check ".[test]"
"$python" -c 'import twinrotor'
"$python" -m ruff format --check --quiet .
"$python" -m ruff check --quiet .
"$python" -m mypy --strict tests examples examples/notebooks/make.py benches python/twinrotor
"$python" -m pytest -q -rs tests
"$python" examples/notebooks/make.py --check
