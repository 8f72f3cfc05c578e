#!/usr/bin/env bash
# Runs the commands of docs/first-flight.md, every line of them, in an empty folder: with the programs as they
# are built, and the firmware as `cargo fw` has built it, on the virtual board.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/example.sh

example docs/first-flight.md
cmp -s my.toml gains/aero2.toml && exit 1
grep -q '^\[provenance\]' my-gains.toml
