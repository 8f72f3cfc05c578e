#!/usr/bin/env bash
# Runs the commands of docs/first-flight.md, every line of them, in an empty folder: with the programs as they
# are built, and the firmware as `cargo fw` has built it, on the virtual board.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release -p host-sim
cargo build --release --ignore-rust-version --manifest-path tests/virtual-board/Cargo.toml
. scripts/example.sh

folder=$(mktemp -d)
# The board in the background ends with this script.
trap 'kill $(jobs -p) 2>/dev/null || true; wait; rm -rf "$folder"' EXIT
cd "$folder"
ln -s "$root/gains" gains
example docs/first-flight.md
cmp -s my.toml gains/aero2.toml && exit 1
grep -q '^\[provenance\]' my-gains.toml
