#!/usr/bin/env bash
# What the first command costs a newcomer: a cold build of `cargo run -p host-sim tune` and the search itself,
# in seconds of processor time. Fails above the budget. Downloads are not counted.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/processor-time.sh
budget=${1:-180}

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cargo fetch --quiet --locked
processor_time
before=$processor_seconds
CARGO_TARGET_DIR=$folder/target cargo build --quiet --locked -p host-sim
processor_time
built=$processor_seconds
(cd "$folder" && target/debug/host-sim tune >/dev/null)
processor_time
spent=$((processor_seconds - before))
printf 'first command: %d s of processor time, %d of them to build; budget %d s\n' \
  "$spent" "$((built - before))" "$budget"
[ "$spent" -le "$budget" ]
