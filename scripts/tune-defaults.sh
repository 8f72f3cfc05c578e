#!/bin/sh
# Tunes the committed gains of every preset, or of those named, from their seeds: the same files, byte for byte.
# About a minute for each preset on two cores.
set -eu
cd "$(dirname "$0")/.."
cargo build --release -q -p host-sim
rough=$(mktemp -d)
trap 'rm -r "$rough"' EXIT

search() {
    "${CARGO_TARGET_DIR:-target}/release/host-sim" tune --objective robust --fidelity rig --algorithm fpa-adaptive \
        --population 25 --iterations 39 "$@"
}

# tune PRESET CONTROLLER FILE [LIMITS]: from the design on 32 plants, from there on 128.
tune() {
    search --preset "$1" --controller "$2" --rounds 4 --plants 32 --seed 1 --out "$rough/start.toml"
    search --preset "$1" --start "$rough/start.toml" --rounds 3 --range 1.6 --plants 128 --seed 2 ${4:+--at-most "$4"} --out "$3"
}

# tune_near PRESET START FILE LIMITS: what is near START.
tune_near() {
    search --preset "$1" --start "$2" --rounds 1 --range 1.1 --plants 256 --seed 2 --at-most "$4" --out "$3"
}

for name in ${*:-paper paper-fixed aero aero2 aero-lab heli}; do
    # Where lead or cancellation gain little, or where a motor faster than believed would make them a limit cycle: without.
    case $name in
        paper) controller=integral ;;
        *) controller=cancelling ;;
    esac
    # With these, what laboratories fly today is worse not only in the sum but in its terms (docs/rig-law.md names the exceptions).
    # They are a little below what is asked for, since other plants are flown than are tuned on.
    case $name in
        paper)
            limits=settling_time_2.yaw=0.81,overshoot_p95.pitch=1.7,overshoot_p95.yaw=2,disturbance_rms_deg.yaw=0.107
            ;;
        paper-fixed)
            limits=settling_time_2.pitch=1.28,settling_time_2.yaw=1.17,overshoot_p95.pitch=2,overshoot_p95.yaw=2.5
            limits=$limits,disturbance_rms_deg.pitch=0.0505,disturbance_rms_deg.yaw=0.0415
            limits=$limits,hold_rms_deg.pitch=0.0465,hold_rms_deg.yaw=0.0335
            ;;
        aero) limits=overshoot_p95.pitch=2.5,overshoot_p95.yaw=2 ;;
        aero2)
            limits=disturbance_rms_deg.pitch=0.068,disturbance_rms_deg.yaw=0.084
            limits=$limits,overshoot_p95.pitch=2.5,overshoot_p95.yaw=2.7
            ;;
        heli)
            limits=disturbance_rms_deg.pitch=0.124,disturbance_rms_deg.yaw=0.094
            limits=$limits,hold_rms_deg.pitch=0.0255,hold_rms_deg.yaw=0.0155
            ;;
    esac
    case $name in
        aero-lab)
            tune_near "$name" gains/starts/aero-lab.toml "gains/$name.toml" overshoot_p95.pitch=1.8,overshoot_p95.yaw=1.5
            ;;
        *) tune "$name" "$controller" "gains/$name.toml" "$limits" ;;
    esac
    # Where another kind, tuned so without limits, wins by a little.
    case $name in
        paper | paper-fixed) tune "$name" pid-plus "gains/choices/$name-pid-plus.toml" ;;
    esac
done
