#!/usr/bin/env bash
# Builds what the page computes with, web/ as WebAssembly, and packs it into target/page/twinrotor.wasm.gz,
# from which `host-sim page` makes the page:
#
#     scripts/build-page.sh && cargo run -p host-sim -- page --out heli.html
#
# The module is never committed. The compiler's target comes by scripts/setup-target.sh.
set -euo pipefail
cd "$(dirname "$0")/.."

toolchain="$(scripts/setup-target.sh wasm32-unknown-unknown)"
# Vectors of four, which every browser has since 2023 (Safari 16.4): the search's lanes are made of them.
export CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS="-C target-feature=+simd128"
RUSTUP_TOOLCHAIN="$toolchain" cargo build --quiet --locked --target wasm32-unknown-unknown --profile web \
  -p twinrotor-web
mkdir -p target/page
packed=target/page/twinrotor.wasm.gz
gzip -9 -n -c target/wasm32-unknown-unknown/web/twinrotor_web.wasm >$packed.new
mv $packed.new $packed
gzip -9 -n -c web/page/vendor/uPlot.iife.min.js >target/page/uplot.js.gz.new
mv target/page/uplot.js.gz.new target/page/uplot.js.gz
echo "$packed: $(wc -c <$packed) bytes"
