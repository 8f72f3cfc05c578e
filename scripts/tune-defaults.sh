#!/bin/sh
# Makes the committed gains of every preset, or of those named: `aero`, `aero2` and `aero-lab` are tuned from
# their seeds, the others are taken from gains/starts/. The same files, byte for byte, as long as law and
# plants are what they are (docs/rig-law.md says which were tuned before that). At most five minutes for each
# preset on two cores.
set -eu
cd "$(dirname "$0")/.."
cargo build --release -q -p host-sim
rough=$(mktemp -d)
trap 'rm -r "$rough"' EXIT

host_sim=${CARGO_TARGET_DIR:-target}/release/host-sim

# On the step alone, without limits if none are given.
search() {
    case " $* " in
        *" --at-most "*) ;;
        *) set -- "$@" --at-most none ;;
    esac
    "$host_sim" tune --objective robust --scenes step --algorithm fpa-adaptive --population 25 \
        --iterations 39 "$@"
}

# refine PRESET START FILE LIMITS PLANTS SEED RANGE: with all scenes.
refine() {
    "$host_sim" tune --objective robust --scenes all --algorithm fpa-adaptive --population 25 \
        --iterations 9 --rounds 1 --preset "$1" --start "$2" --out "$3" --at-most "$4" --plants "$5" \
        --seed "$6" --range "$7"
}

# tune PRESET CONTROLLER FILE SEED [LIMITS]: from the design on 32 plants, from there on 256, from there on
# 1,024.
tune() {
    preset=$1 file=$3 seed=$4 limits=${5:+--at-most $5}
    search --preset "$preset" --controller "$2" --rounds 4 --plants 32 --seed "$seed" \
        --out "$rough/first.toml"
    seed=$((seed + 1))
    # shellcheck disable=SC2086  # two words or none
    search --preset "$preset" --start "$rough/first.toml" --rounds 4 --range 1.8 --plants 256 --seed $seed \
        $limits --out "$rough/second.toml"
    # shellcheck disable=SC2086
    search --preset "$preset" --start "$rough/second.toml" --rounds 3 --range 1.4 --plants 1024 --seed $seed \
        $limits --out "$file"
}

# take PRESET: nothing but its start is tried, which was found with lags that are wrong by far.
take() {
    search --preset "$1" --start "gains/starts/$1.toml" --population 5 --iterations 0 --rounds 1 \
        --range 1.000001 --plants 64 --seed 6 --true-lags .2,3 --at-most failures=0,lags.failures=0 \
        --out "gains/$1.toml"
}

# tune_near PRESET START FILE LIMITS: what is near START, with its observer.
tune_near() {
    search --preset "$1" --start "$2" \
        --parameters pitch,yaw,allocation,filter.bandwidth,filter.damping,filter.advance \
        --rounds 3 --range 2 --plants 256 --seed 2 --at-most "$4" --out "$3"
}

for name in ${*:-paper paper-fixed aero aero2 aero-lab heli}; do
    # With these limits, what laboratories fly today is worse not only in the sum but in its terms
    # (docs/rig-law.md). They are a little below what is asked for, since other plants are flown than are
    # tuned on.
    seed=1
    case $name in
        aero)
            seed=5
            limits=overshoot_p95.pitch=2.5,overshoot_p95.yaw=2,settling_p95.pitch=2,voltage_variation=135
            limits=$limits,failures=0
            ;;
        aero2)
            limits=disturbance_rms_deg.pitch=0.068,disturbance_rms_deg.yaw=0.084
            limits=$limits,overshoot_p95.pitch=2.5,overshoot_p95.yaw=2.7,failures=0
            ;;
        aero-lab)
            # Gentler than the cheapest: what fails on reversals is warm motors.
            limits=overshoot_p95.pitch=1.8,overshoot_p95.yaw=1.5,settling_p95.pitch=1.5
            limits=$limits,voltage_variation=80,failures=0
            ;;
    esac
    case $name in
        paper | paper-fixed | heli) take "$name" ;;
        aero-lab) tune_near "$name" gains/starts/aero-lab.toml "gains/$name.toml" "$limits" ;;
        *) tune "$name" cancelling "gains/$name.toml" $seed "$limits" ;;
    esac
    # Where another kind, tuned so without limits, wins by a little.
    case $name in
        paper | paper-fixed) tune "$name" pid-plus "gains/choices/$name-pid-plus.toml" 1 ;;
    esac
    # On all scenes from there on, with half the chatter.
    case $name in
        aero2)
            limits=$limits,J_step=8.87
            refine "$name" "gains/$name.toml" "$rough/first.toml" "$limits,voltage_variation=95" 96 7 1.25
            refine "$name" "$rough/first.toml" "gains/choices/$name-quiet.toml" \
                "$limits,voltage_variation=70" 256 8 1.2
            ;;
    esac
done
