#!/usr/bin/env bash
# What an owner of a board without a rig does, README's "Without a rig", with the virtual board's TCP port in
# place of the USB cable: the firmware as `cargo fw-BOARD-sim` has built it, nucleo-f446 or the BOARD that is
# named, written, checked, flown over all scenarios, and its report.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/programs.sh
build_programs
cargo build --quiet "${board[@]}"
virtual_board=$programs/virtual-board
host_sim=$programs/host-sim
name=${1:-nucleo-f446}
elf=$PWD/target/$name-sim/thumbv7em-none-eabihf/firmware/firmware

folder=$(mktemp -d)
# The board in the background ends with this script.
trap 'kill $(jobs -p) 2>/dev/null || true; wait; rm -rf "$folder"' EXIT
"$virtual_board" --elf "$elf" --listen 127.0.0.1:0 --fast >"$folder/board" &
for _ in $(seq 300); do
  address=$(sed -n 's,^listening at ,,p' "$folder/board")
  [ -n "$address" ] && break
  sleep 0.1
done
[ -n "$address" ] || { echo "no board listens" >&2; exit 1; }

"$host_sim" fly --port "$address" --board "$name" --yes --write --report "$folder/report.json"
grep -q '"port": "simulated"' "$folder/report.json"
grep -q '"differs": null' "$folder/report.json"
grep -Eq '"serial": "[0-9A-F]{24}"' "$folder/report.json"
equal=$(sed -n 's/.*"equal_ticks": \([0-9]*\).*/\1/p' "$folder/report.json")
[ "$equal" -gt 20000 ] || { echo "only $equal ticks were compared" >&2; exit 1; }

# What befalls the rig ends the flight, with status 3.
status=0
"$host_sim" fly --port "$address" --board "$name" --yes --inject stuck-pitch@1 >"$folder/injected" 2>&1 ||
  status=$?
cat "$folder/injected"
[ "$status" = 3 ] && grep -q "the pitch encoder does not show the motion" "$folder/injected"
