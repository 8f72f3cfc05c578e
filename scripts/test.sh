#!/usr/bin/env bash
# All tests of the project, from a bare clone.
set -euo pipefail
cd "$(dirname "$0")/.."

cargo test --workspace
