#!/usr/bin/env bash
# On a machine with an NVIDIA card: every bit against the processor's, then a table of speeds for
# docs/speed.md. At most five minutes beside the build. (`--build` only builds, for a machine that reaches no
# registry: target/gpu-check is all that has to be carried there.)
#
#     scripts/gpu-check.sh [--build]
set -euo pipefail
cd "$(dirname "$0")/.."

check=target/gpu-check/check
if [ "${1:-}" = --build ] || [ ! -x "$check" ]; then
  scripts/build-ptx.sh
  cargo build --release -p twinrotor-gpu --example check --features cuda
  mkdir -p "$(dirname "$check")"
  cp target/release/examples/check "$check"
fi
[ "${1:-}" = --build ] || timeout 300 "$check"
