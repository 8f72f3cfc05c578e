#!/usr/bin/env bash
# The functional mock-up units: built, valid, and with the bits of the command line.
set -euo pipefail
cd "$(dirname "$0")/.."

. scripts/programs.sh
build_programs
folder=target/fmu
[ -x "$folder/venv/bin/python" ] || python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check -r bindings/fmu/tests/requirements.txt
"$folder/venv/bin/python" -m pytest -q bindings/fmu/tests

if command -v valgrind >/dev/null; then
  instances="$(cargo test --quiet "${tested[@]}" --test instances --no-run --message-format=json |
    sed -n 's/.*"executable":"\([^"]*instances[^"]*\)".*/\1/p')"
  TWINROTOR_INSTANCES=100 valgrind --quiet --leak-check=full --show-leak-kinds=definite \
    --errors-for-leak-kinds=definite --error-exitcode=9 "$instances"
else
  echo "valgrind is not installed: leaks are not looked for"
fi
