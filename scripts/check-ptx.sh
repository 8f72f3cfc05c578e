#!/usr/bin/env bash
# The kernels without a card: builds the PTX, reads it (gpu/tests/ptx.rs), and has NVIDIA's own assembler
# take it where its package can be had. About half a minute of a processor.
set -euo pipefail
cd "$(dirname "$0")/.."

status=0
scripts/build-ptx.sh || status=$?
# 69: not to be had here, as the script has said.
[ "$status" != 69 ] || exit 0
[ "$status" = 0 ] || exit "$status"
cargo test -q -p twinrotor-gpu --features ptx-tests --test ptx

folder=target/ptx/venv
assembler() { find "$folder" -path '*/cuda_nvcc/bin/ptxas' -print -quit; }
if [ -z "$(assembler 2>/dev/null)" ]; then
  python3 -m venv "$folder"
  "$folder/bin/python" -m pip install -q --disable-pip-version-check --no-deps \
    nvidia-cuda-nvcc-cu12==12.9.86 || true
fi
ptxas=$(assembler)
if [ -z "$ptxas" ]; then
  echo "ptxas: not run: nvidia-cuda-nvcc-cu12 is not to be had here"
  exit 0
fi
chmod +x "$ptxas"
for card in sm_75 sm_80 sm_90; do
  # Of each kernel its registers, and the memory that is a thread's own: none, or the check fails.
  "$ptxas" -v -arch="$card" target/ptx/twinrotor.ptx -o /dev/null 2>&1 |
    awk -v card="$card" '
      /Compiling entry/ { gsub("\047", ""); kernel = $7; stack = "" }
      /stack frame/ && stack == "" { stack = $1; stores = $5; loads = $9 }
      /Used .* registers/ {
        print card, kernel ": " $5 " registers, " stack " bytes of stack, " stores + loads " of spills"
        kernels += 1
        own += stack + stores + loads
      }
      END {
        if (kernels != 5) { print card ": " kernels + 0 " of 5 kernels"; exit 1 }
        if (own > 0) { print card ": kernels have local memory"; exit 1 }
      }'
done
