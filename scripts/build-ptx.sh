#!/usr/bin/env bash
# Makes target/ptx/twinrotor.ptx: the kernels of gpu/ as text for the driver of an NVIDIA card, compute
# capability 7.5 (Turing, sm_75) and newer. A host-sim built after it with the feature `cuda` carries it.
#
#     scripts/build-ptx.sh
#
# It needs three components of rustup, which it fetches: rust-src, since the target's core is compiled from
# source (ready-made it is often not to be had), llvm-tools and llvm-bitcode-linker, the target's linker.
# RUSTC_BOOTSTRAP lets the stable compiler take what is unstable of it: build-std for that core; abi_ptx for
# functions that a driver calls, stdarch_nvptx for a thread's number, asm_experimental_arch for the square
# root that rounds as IEEE 754 says. Exit status 69: a component is not to be had here.
set -euo pipefail
cd "$(dirname "$0")/.."
unset RUSTUP_TOOLCHAIN

components=(rust-src llvm-tools llvm-bitcode-linker)
if ! command -v rustup >/dev/null || ! timeout 300 rustup component add "${components[@]}" >&2; then
  echo "build-ptx: left out: rustup has no ${components[*]} here" >&2
  exit 69
fi

# All in one unit and inlined to the end: what is called keeps its state in memory, where a GPU is slow, and
# not in registers. Debug lines would be a driver's to parse.
cargo_flags=(--release --package twinrotor-gpu --lib --crate-type cdylib
  --target nvptx64-nvidia-cuda -Zbuild-std=core --target-dir target/ptx)
for setting in 'lto="fat"' 'panic="abort"' codegen-units=1 debug=false; do
  cargo_flags+=(--config "profile.release.$setting")
done
RUSTC_BOOTSTRAP=1 \
  RUSTFLAGS="-Ctarget-cpu=sm_75 -Cllvm-args=-inline-threshold=1000000" \
  cargo rustc "${cargo_flags[@]}"
cp target/ptx/nvptx64-nvidia-cuda/release/twinrotor_gpu.ptx target/ptx/twinrotor.ptx
# The next build of a host-sim looks whether they are there (gpu/build.rs).
touch gpu/build.rs
echo "target/ptx/twinrotor.ptx: $(wc -l <target/ptx/twinrotor.ptx) lines" >&2
