#!/usr/bin/env bash
# What the first command costs a newcomer: a cold build of `cargo run -p host-sim tune` and the search itself,
# in seconds of processor time. Fails above the budget. Downloads are not counted.
set -euo pipefail
cd "$(dirname "$0")/.."
budget=${1:-180}

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cargo fetch --quiet --locked
seconds() {
  awk '{ split($1, m, "m"); split($2, s, "m"); print m[1] * 60 + m[2] + s[1] * 60 + s[2] }' <<<"$1"
}
# The last line of `times`: user and system time of all children so far. By way of a file: in a pipe or a
# substitution it would be told by a shell of its own, which has no children.
spent() {
  times >"$folder/times"
  awk 'END { print }' "$folder/times"
}
spent >"$folder/before"
CARGO_TARGET_DIR=$folder/target cargo build --quiet --locked -p host-sim
spent >"$folder/built"
(cd "$folder" && target/debug/host-sim tune >/dev/null)
spent >"$folder/after"
of() { seconds "$(cat "$folder/$1")"; }
awk -v before="$(of before)" -v built="$(of built)" -v after="$(of after)" \
  -v budget="$budget" 'BEGIN {
  printf "first command: %.0f s of processor time to build, ", built - before
  printf "%.1f s to search; budget %d s\n", after - built, budget
  exit after - before > budget
}'
