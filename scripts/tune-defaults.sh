#!/bin/sh
# Tunes the committed gains of every preset, or of those named, from their seeds: the same files, byte for byte.
set -eu
cd "$(dirname "$0")/.."
cargo build --release -q -p host-sim
rough=$(mktemp -d)
trap 'rm -r "$rough"' EXIT

tune() {
    "${CARGO_TARGET_DIR:-target}/release/host-sim" tune --objective robust --fidelity rig "$@"
}

for name in ${*:-paper paper-fixed aero aero2 aero-lab heli}; do
    out=gains/$name.toml
    case $name in
        # The lag is uncertain and short: neither lead nor cancellation.
        paper) start="--controller integral --algorithm fpa-paper --population 30 --iterations 30" ;;
        # Lead gains nothing where the motors are weak and the flight long.
        aero2) start="--controller integral --algorithm fpa-yang --population 25 --iterations 19" ;;
        *) start="--controller cancelling --algorithm fpa-yang --population 25 --iterations 19" ;;
    esac
    # shellcheck disable=SC2086
    tune --preset "$name" $start --rounds 4 --plants 32 --seed 1 --out "$out"
    # Where 32 plants do not show what 300 do, it goes on from there on more.
    case $name in
        paper | aero)
            cp "$out" "$rough/$name.toml"
            tune --preset "$name" --start "$rough/$name.toml" --algorithm fpa-yang --population 25 \
                --iterations 19 --rounds 3 --range 1.6 --plants 128 --seed 2 --out "$out"
            ;;
    esac
done
