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
  "$folder/bin/pip" install -q --disable-pip-version-check --no-deps nvidia-cuda-nvcc-cu12==12.9.86 || true
fi
ptxas=$(assembler)
if [ -z "$ptxas" ]; then
  echo "ptxas: not run: nvidia-cuda-nvcc-cu12 is not to be had here"
  exit 0
fi
chmod +x "$ptxas"
for card in sm_75 sm_80 sm_90; do
  # What it says of registers and of memory that is a thread's own.
  "$ptxas" -v -arch="$card" target/ptx/twinrotor.ptx -o /dev/null 2>&1 |
    sed -nE "s/.*Compiling entry function '(.*)' for '(.*)'/\2 \1:/p; s/.*(Used [0-9]+ registers).*/  \1/p;
             s/^ *([0-9]+ bytes stack frame.*)/  \1/p"
done
