#!/usr/bin/env bash
# The functional mock-up units: built, valid, and with the bits of the command line.
set -euo pipefail
cd "$(dirname "$0")/.."

cargo build --quiet -p fmu -p host-sim
cargo test --quiet -p fmu
folder=target/fmu
[ -x "$folder/venv/bin/python" ] || python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check -r bindings/fmu/tests/requirements.txt
"$folder/venv/bin/python" -m pytest -q bindings/fmu/tests
