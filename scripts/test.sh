#!/usr/bin/env bash
# All tests of the project, from a bare clone: the host's, then the firmware built, read and flown on the virtual board.
set -euo pipefail
cd "$(dirname "$0")/.."

cargo test --workspace --exclude firmware --features host-sim/formats

# The firmware needs a compiler for the board; everything else stays on the default one.
toolchain="$(scripts/setup-target.sh)"
RUSTUP_TOOLCHAIN="$toolchain" cargo fw
RUSTUP_TOOLCHAIN="$toolchain" cargo fw --features sign-magnitude --target-dir target/sign-magnitude
cargo test -p firmware
cd tests/virtual-board
cargo test --release --ignore-rust-version
