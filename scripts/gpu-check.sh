#!/usr/bin/env bash
# On a machine with an NVIDIA card: every bit against the processor's, then the table of speeds of
# docs/gpu.md, then plain JAX beside it. At most five minutes beside the build. (`--build` only builds, for
# a machine that reaches no registry: target/gpu-check is all that has to be carried there.)
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
[ "${1:-}" != --build ] || exit 0
timeout 240 "$check"
# The paper's step as one would write it in plain JAX, on the same card in the same run, where there is JAX.
if python3 -c 'import jax' 2>/dev/null; then
  echo
  timeout 60 python3 benches/rivals/closed_loop_jax.py
else
  echo "JAX: not run: python3 here has none"
fi
