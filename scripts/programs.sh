# Sourced from the top folder: what scripts/test.sh and what comes after it in CI share. One choice of
# packages and features, since another one makes Cargo compile half of them again; `build_programs` builds
# those that people start into $programs, where the tests have left them: the loop is optimised even there.
tested=(--workspace --exclude firmware --features host-sim/formats,host-sim/monitor)
programs=${CARGO_TARGET_DIR:-$PWD/target}/debug
# The examples are not needed by all; with them Cargo chooses as for the tests.
build_programs() { cargo build --quiet "${tested[@]}" --lib --bins --examples; }
# The emulated board is a workspace of its own, on a newer compiler than it asks for
# (tests/virtual-board/Cargo.toml says why).
board=(--manifest-path tests/virtual-board/Cargo.toml --ignore-rust-version)
