#!/bin/sh
# Tunes the committed gains of every preset from their seeds: the same files, byte for byte. Some minutes on two cores.
set -eu
cd "$(dirname "$0")/.."
tune() {
    cargo run --release -q -p host-sim tune --objective robust --fidelity rig --population 25 --iterations 19 "$@"
}
