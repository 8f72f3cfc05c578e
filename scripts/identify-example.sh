#!/usr/bin/env bash
# Runs the commands of docs/identify.md, every line of them, in an empty folder, and holds what comes of them:
# constants near those of the rig that made the logs, and gains that fly the example's own scenario on it.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/example.sh

example docs/identify.md

"$host_sim" simulate --preset lab.toml --true-rig aero-lab --fidelity rig --gains lab-gains.toml \
  --scenario excite.toml --json >flown.json
python3 - <<'END'
import json
import tomllib

mine = tomllib.load(open("lab.toml", "rb"))["plant"]
# Of the preset `aero-lab`: lag, and each motor's torque on its own axis at 10 V.
lag, thrust = 0.15, {"main_on_pitch": 0.00965, "tail_on_yaw": 0.00862}
print(mine["rotor_time_constant"], flown := json.load(open("flown.json"))["board"])
for motor, on in ("main", "main_on_pitch"), ("tail", "tail_on_yaw"):
    assert abs(mine["rotor_time_constant"][motor] / lag - 1) < 0.2, mine["rotor_time_constant"]
    found = 10 * mine["effectiveness"][on] + 100 * mine["quadratic_effectiveness"][on]
    assert abs(found / thrust[on] - 1) < 0.1, (on, found)
assert flown["state"] == "armed", flown
END
