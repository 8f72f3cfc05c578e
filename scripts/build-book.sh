#!/usr/bin/env bash
# The documents as a site, target/book/index.html, by mdBook (cargo install mdbook --locked).
set -euo pipefail
cd "$(dirname "$0")/.."
if ! command -v mdbook >/dev/null; then
  echo "not built: mdBook is not installed (cargo install mdbook --locked)"
  exit 0
fi
mdbook build docs
