#!/usr/bin/env bash
# Runs the commands of docs/first-flight.md, every line of them, in an empty folder: with the programs as they
# are built, and the firmware as `cargo fw` has built it, on the virtual board.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD
cargo build --release -p host-sim
cargo build --release --ignore-rust-version --manifest-path tests/virtual-board/Cargo.toml
virtual_board=${CARGO_TARGET_DIR:-$root/tests/virtual-board/target}/release/virtual-board
host_sim=${CARGO_TARGET_DIR:-$root/target}/release/host-sim
export TWINROTOR_ELF=${TWINROTOR_ELF:-$root/target/thumbv7em-none-eabihf/firmware/firmware}

folder=$(mktemp -d)
# The board in the background ends with this script.
trap 'kill $(jobs -p) 2>/dev/null || true; wait; rm -rf "$folder"' EXIT
cd "$folder"
ln -s "$root/gains" gains

# In place of `cargo run --release -p host-sim [--] ...` and `cargo board ...`.
cargo() {
  case $1 in
    run)
      shift 4
      [ "$1" = -- ] && shift
      "$host_sim" "$@"
      ;;
    board)
      shift
      exec "$virtual_board" "$@"
      ;;
  esac
}
# A board is there a moment after it was started.
reachable() {
  local k
  for k in $(seq 300); do
    (exec 3<>/dev/tcp/127.0.0.1/4000) 2>/dev/null && return
    sleep 0.1
  done
  echo "no board listens" >&2
  return 1
}

awk '/^```sh$/ { code = 1; next } /^```$/ { if (code) print "#end"; code = 0 } code' \
  "$root/docs/first-flight.md" >commands
block=()
while IFS= read -r line <&9; do
  if [ "$line" != "#end" ]; then
    block+=("$line")
    continue
  fi
  text=$(printf '%s\n' "${block[@]}")
  printf '\n$ %s\n' "$text"
  eval "$text"
  [[ $text == "cargo board"* ]] && reachable
  block=()
done 9<commands
cmp -s my.toml gains/aero2.toml && exit 1
grep -q '^\[provenance\]' my-gains.toml
