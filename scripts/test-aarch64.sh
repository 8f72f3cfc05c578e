#!/usr/bin/env bash
# Lanes on another processor: every operation, and whole flights against the board's control loop, compiled
# for 64-bit ARM (NEON) and run under emulation. Installs what it needs (rustup's target; Debian's cross
# linker and qemu-user).
set -euo pipefail
cd "$(dirname "$0")/.."

as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }
if ! command -v aarch64-linux-gnu-gcc >/dev/null || ! command -v qemu-aarch64 >/dev/null; then
  as_root apt-get -qq update
  as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends \
    gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user
fi
rustup target add aarch64-unknown-linux-gnu

export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER="qemu-aarch64 -L /usr/aarch64-linux-gnu"
# Optimised, the kernels take the compiler more than half an hour for this target; unoptimised, two minutes,
# and much stack when they run.
export RUST_MIN_STACK=1073741824
cargo test --config 'profile.dev.package.twinrotor-sim.opt-level=0' \
  --config 'profile.dev.package.twinrotor-tune.opt-level=0' \
  --target aarch64-unknown-linux-gnu -p twinrotor-sim -p twinrotor-tune --lib lane
