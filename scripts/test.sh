#!/usr/bin/env bash
# All tests of the project, from a bare clone: the host's, then the firmware built, read and flown on the
# virtual board.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/stage.sh

features=host-sim/formats,host-sim/monitor
stage "tests on the host" cargo test --workspace --exclude firmware --features "$features"

# The firmware needs a compiler for the board; everything else stays on the default one.
toolchain="$(scripts/setup-target.sh)"
firmware() { RUSTUP_TOOLCHAIN="$toolchain" cargo fw "$@"; }
stage "firmware" firmware
stage "firmware, sign and magnitude" firmware --features sign-magnitude --target-dir target/sign-magnitude
stage "firmware, for bootstrapped bridges" firmware --features bootstrap --target-dir target/bootstrap
stage "firmware, for a debugger" firmware --features debug --target-dir target/debug-build
stage "firmware, with a simulated rig" env RUSTUP_TOOLCHAIN="$toolchain" cargo fw-f405-sim
stage "the same for a Nucleo-F446RE" env RUSTUP_TOOLCHAIN="$toolchain" cargo fw-nucleo-f446-sim
stage "tests of the firmware as a file" cargo fw-test
stage "tests on the virtual board" cargo board-test
