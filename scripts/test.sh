#!/usr/bin/env bash
# Tests of the project, from a bare clone: the host's. `--board` builds the firmware, reads it and flies it on
# the virtual board instead. `--all`, as `.ci/run` calls it, does both, with those tests that are marked
# `#[ignore = "long: ..."]`, each of which repeats with more cases what a shorter one proves, and with the
# images of the firmware that they alone fly.
set -euo pipefail
on_the_host=yes
on_the_board=
long=()
case "${1:-}" in
  "") ;;
  --board) on_the_host="" on_the_board=yes ;;
  --all) on_the_board=yes long=(-- --include-ignored) ;;
  *) echo "usage: $0 [--board | --all]" >&2; exit 2 ;;
esac
cd "$(dirname "$0")/.."
. scripts/stage.sh
. scripts/programs.sh

[ -z "$on_the_host" ] || stage "tests on the host" cargo test "${tested[@]}" "${long[@]}"
[ -n "$on_the_board" ] || exit 0

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
for_a_feather() {
  seeded feather-f405
  RUSTUP_TOOLCHAIN="$toolchain" cargo fw-feather-f405
}
if [ ${#long[@]} != 0 ]; then
  stage "the same for a Feather" without_a_rig feather-f405
  stage "firmware for a Feather with a rig" for_a_feather
  stage "the same for a Nucleo-F446RE" without_a_rig nucleo-f446
  stage "the same for a Nucleo-F411RE" without_a_rig nucleo-f411
  stage "the same for a Black Pill" without_a_rig black-pill nucleo-f411
fi
stage "tests of the firmware as a file" cargo fw-test
stage "tests on the virtual board" cargo board-test "${long[@]}"
