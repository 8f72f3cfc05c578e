#!/usr/bin/env bash
# All tests of the project, from a bare clone: the host's, then the firmware built, read and flown on the
# virtual board.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/stage.sh
. scripts/programs.sh

stage "tests on the host" cargo test "${tested[@]}"

# The firmware needs a compiler for the board; everything else stays on the default one.
toolchain="$(scripts/setup-target.sh)"
. scripts/seeded.sh
firmware() { RUSTUP_TOOLCHAIN="$toolchain" cargo fw "$@"; }
variant() {
  seeded "$2"
  firmware --features "$1" --target-dir "target/$2"
}
without_a_rig() {
  seeded "$1-sim" ${2:+"$2-sim"}
  RUSTUP_TOOLCHAIN="$toolchain" cargo "fw-$1-sim"
}
stage "firmware" firmware
stage "firmware, sign and magnitude" variant sign-magnitude sign-magnitude
stage "firmware, for bootstrapped bridges" variant bootstrap bootstrap
stage "firmware, for a debugger" variant debug debug-build
stage "firmware, with a simulated rig" without_a_rig f405
stage "the same for a Feather" without_a_rig feather-f405
for_a_feather() {
  seeded feather-f405
  RUSTUP_TOOLCHAIN="$toolchain" cargo fw-feather-f405
}
stage "firmware for a Feather with a rig" for_a_feather
stage "the same for a Nucleo-F446RE" without_a_rig nucleo-f446
stage "the same for a Nucleo-F411RE" without_a_rig nucleo-f411
stage "the same for a Black Pill" without_a_rig black-pill nucleo-f411
stage "tests of the firmware as a file" cargo fw-test
stage "tests on the virtual board" cargo board-test
