#!/usr/bin/env bash
# The page, tested: its types, its module in Node, and the whole of it in a headless Chromium, driven over
# WebDriver, against what the same code gives on this machine; then as `host-sim monitor` serves it. What
# needs a program that is not here says that it was not run. With a folder as argument, pictures of the page
# are put there.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=target/page

scripts/build-page.sh
. scripts/programs.sh
build_programs
host_sim=$programs/host-sim
$host_sim page --out $folder/heli.html
size=$(wc -c <$folder/heli.html)
[ "$size" -le 600000 ] || { echo "the page has $size bytes; 600,000 are allowed"; exit 1; }

$programs/examples/fingerprints 1000000 >$folder/fingerprints.txt
for kind in csv mcap; do
  $host_sim fly --scenario step --record $folder/flown.$kind >/dev/null
done
$host_sim simulate --csv $folder/simulated.csv >/dev/null
$host_sim tune --preset paper --seed 7 --out $folder/gains.toml >/dev/null

long=$(find web/page web/tests -name '*.js' -not -path '*/vendor/*' -o -name '*.mjs' | xargs wc -l |
  awk '$2 != "total" && $1 >= 300')
[ -z "$long" ] || { echo "300 lines and more: $long"; exit 1; }

if ! command -v node >/dev/null; then
  echo "not run: there is no Node here (apt-get install nodejs npm)"
  exit 0
fi
if command -v npx >/dev/null; then
  npx --yes -p typescript@5.9.3 tsc -p web/page/tsconfig.json
else
  echo "types not checked: there is no npx here (apt-get install npm)"
fi
node web/tests/bits.mjs $folder/twinrotor.wasm.gz $folder/fingerprints.txt
axe=$folder/axe/node_modules/axe-core/axe.min.js
if [ ! -f $axe ] && command -v npm >/dev/null; then
  npm install --silent --no-save --prefix $folder/axe axe-core@4.10.3
fi

# In a browser.
begun=$SECONDS
node web/tests/page.mjs $folder/heli.html $folder/fingerprints.txt $folder/gains.toml "${1:-}"
# These measure no time of the clock: beside each other.
tests=("serial.mjs $folder/heli.html"
  "record.mjs $folder/heli.html $folder/flown.csv $folder/flown.mcap $folder/simulated.csv")
if [ -f $axe ]; then
  tests+=("axe.mjs $folder/heli.html $axe")
else
  echo "accessibility not checked: there is no npm here (apt-get install npm)"
fi
running=()
for test in "${tests[@]}"; do
  node web/tests/$test &
  running+=($!)
done
failed=0
for one in "${running[@]}"; do wait "$one" || failed=1; done
[ $failed = 0 ]
node web/tests/beside.mjs $host_sim $folder/flown.csv $folder/flown.mcap "${1:-}"
node web/tests/monitor.mjs $host_sim 60 "${1:-}"
echo "in a browser: $((SECONDS - begun)) s of the 180 that it may take"
[ $((SECONDS - begun)) -le 180 ]
