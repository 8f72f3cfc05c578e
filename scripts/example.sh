# Sourced from the top folder: builds the programs and goes to an empty folder, in which `example FILE.md`
# runs every line of the shell blocks of a document. `cargo run --release -p host-sim [--] ...` and
# `cargo board ...` in them are what was built. Without --release the searches would take several times as
# long, which is more than the build does.
. scripts/programs.sh
cargo build --release -p host-sim
cargo build --quiet "${board[@]}"
root=$PWD
virtual_board=$programs/virtual-board
host_sim=${CARGO_TARGET_DIR:-$root/target}/release/host-sim
export TWINROTOR_ELF=${TWINROTOR_ELF:-$root/target/thumbv7em-none-eabihf/firmware/firmware}

folder=$(mktemp -d)
# A board in the background ends with the script.
trap 'kill $(jobs -p) 2>/dev/null || true; wait; rm -rf "$folder"' EXIT
cd "$folder"
ln -s "$root/gains" "$root/scenarios" .

cargo() {
  case $1 in
    run)
      shift 4
      [ "$1" = -- ] && shift
      "$host_sim" "$@"
      ;;
    board)
      shift
      # In the background it is to be killed itself, and not a shell around it.
      if [[ " $* " == *" --listen "* ]]; then exec "$virtual_board" "$@"; fi
      "$virtual_board" "$@"
      ;;
  esac
}
# A board is there a moment after it was started.
reachable() {
  local k
  for k in $(seq 300); do
    (exec 3<>/dev/tcp/127.0.0.1/4000) 2>/dev/null && return
    sleep 0.1
  done
  echo "no board listens" >&2
  return 1
}

example() {
  local block=() line text commands
  commands=$(awk '/^```sh$/ { code = 1; next } /^```$/ { if (code) print "#end"; code = 0 } code' "$root/$1")
  while IFS= read -r line <&9; do
    if [ "$line" != "#end" ]; then
      block+=("$line")
      continue
    fi
    text=$(printf '%s\n' "${block[@]}")
    printf '\n$ %s\n' "$text"
    eval "$text"
    [[ $text == *"--listen"* ]] && reachable
    block=()
  done 9<<<"$commands"
}
