#!/usr/bin/env bash
# Makes `cargo build --target TARGET` work, thumbv7em-none-eabihf or the one named, such as
# wasm32-unknown-unknown, and prints the toolchain that can do it:
#
#     export RUSTUP_TOOLCHAIN="$(scripts/setup-target.sh [TARGET])"
#
# Two ways, in this order:
#   1. rustup has the target, or fetches it: the active toolchain, unchanged.
#   2. Debian's rustc and its library source: core, alloc and compiler_builtins are compiled once
#      (about two minutes) into that compiler's own sysroot, which rustup then knows as `debian`.
# A second call returns at once. TWINROTOR_NO_RUSTUP_TARGET=1 goes straight to the second way.
# Without rustup the name printed is `system`: /usr/bin/cargo serves, and the variable is ignored.
set -euo pipefail

target=${1:-thumbv7em-none-eabihf}
host=x86_64-unknown-linux-gnu
log() { echo "setup-target: $*" >&2; }
as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }

# Two calls at once would both write the sysroot.
exec 9>"${TMPDIR:-/tmp}/twinrotor-setup-target.$(id -u).lock"
flock 9

# 1. rustup ---------------------------------------------------------------------------------------
if [ -z "${TWINROTOR_NO_RUSTUP_TARGET:-}" ] && command -v rustup >/dev/null; then
  unset RUSTUP_TOOLCHAIN
  if rustup target list --installed 2>/dev/null | grep -qx "$target" ||
    timeout 120 rustup target add "$target" >&2; then
    log "$target by rustup ($(rustc -V))"
    rustup show active-toolchain | cut -d' ' -f1
    exit 0
  fi
  log "rustup cannot supply $target; building it from Debian's library source"
fi

# 2. Debian ---------------------------------------------------------------------------------------
if ! command -v apt-get >/dev/null; then
  log "no rustup target and no apt-get: install the target $target by hand"
  exit 1
fi

apt_install() {
  local missing=() package
  for package in "$@"; do
    dpkg-query -Wf '${db:Status-Status}\n' "$package" 2>/dev/null | grep -qx installed ||
      missing+=("$package")
  done
  [ ${#missing[@]} = 0 ] && return
  if [ -z "${apt_updated:-}" ]; then
    as_root apt-get -o DPkg::Lock::Timeout=300 -qq update >&2
    apt_updated=1
  fi
  as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get -o DPkg::Lock::Timeout=300 -qq install -y --no-install-recommends "${missing[@]}" >&2
}

apt_install rustc-web cargo-web rust-web-src libstd-rust-web-dev
rustc=/usr/bin/rustc
sysroot=$($rustc --print sysroot)
version=$($rustc -vV)
library=$sysroot/lib/rustlib/$target/lib

# Debian's rustc has no rust-lld; its lld of the same LLVM is that program under another name.
llvm=$($rustc -vV | sed -n 's/^LLVM version: \([0-9]*\).*/\1/p')
apt_install "lld-$llvm"
linker=$sysroot/lib/rustlib/$host/bin/rust-lld
as_root mkdir -p "$(dirname "$linker")"
as_root ln -sfn "/usr/bin/lld-$llvm" "$linker"

# That package holds wasm32-unknown-unknown as it is.
if [ "$target" = wasm32-unknown-unknown ]; then
  [ -d "$library" ] || { log "libstd-rust-web-dev has no $target"; exit 1; }
elif [ "$(cat "$library/.built-by" 2>/dev/null)" != "$version" ]; then
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT
  mkdir -p "$work/src"
  echo '#![no_std]' >"$work/src/lib.rs"
  # One object per intrinsic, as the official builds have: what is not called is not linked.
  cat >"$work/Cargo.toml" <<'TOML'
[package]
name = "sysroot"
version = "0.0.0"
edition = "2021"
[workspace]
[profile.release]
opt-level = 3
codegen-units = 1
debug = 0
panic = "abort"
[profile.release.package.compiler_builtins]
codegen-units = 10000
TOML
  log "compiling core, alloc and compiler_builtins for $target with $($rustc -V)"
  (
    cd "$work"
    unset RUSTUP_TOOLCHAIN CARGO_BUILD_TARGET CARGO_ENCODED_RUSTFLAGS CARGO_BUILD_RUSTFLAGS
    PATH=/usr/bin:/bin RUSTC=$rustc RUSTC_BOOTSTRAP=1 CARGO_TARGET_DIR=$work/target \
      RUSTFLAGS=-Cembed-bitcode=yes \
      /usr/bin/cargo build -q --release --target "$target" -Zbuild-std=core,alloc \
      -Zbuild-std-features=compiler-builtins-mem >&2
  )
  as_root rm -rf "$library"
  as_root mkdir -p "$library"
  for crate in core alloc compiler_builtins; do
    as_root cp "$work/target/$target/release/deps/lib$crate"-*.{rlib,rmeta} "$library"/
  done
  echo "$version" | as_root tee "$library/.built-by" >/dev/null
fi

if command -v rustup >/dev/null; then
  rustup toolchain link debian "$sysroot" >&2
  log "$target by Debian ($($rustc -V)), known to rustup as 'debian'"
  echo debian
else
  log "$target by Debian ($($rustc -V)); no rustup, so plain /usr/bin/cargo"
  echo system
fi
