#!/usr/bin/env bash
# All tests of the project, from a bare clone: the thumb target is set up and the firmware built first, since tests read it.
set -euo pipefail
cd "$(dirname "$0")/.."

toolchain=$(scripts/setup-target.sh)
RUSTUP_TOOLCHAIN=$toolchain cargo fw
cargo test --workspace
