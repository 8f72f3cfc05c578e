# Sourced by scripts that take long: `stage NAME COMMAND...` runs a command under a headline; at the end, and
# after a stage that failed, a table says how many seconds each has taken.

stage_names=()
stage_seconds=()

stage() {
  local name=$1 began=$SECONDS
  shift
  printf '\n== %s\n' "$name"
  stage_names+=("$name")
  stage_seconds+=("failed")
  "$@"
  stage_seconds[-1]=$((SECONDS - began))
}

stage_table() {
  local status=$? index
  printf '\n%-44s %8s\n' "== $(basename "$0")" "seconds"
  for index in "${!stage_names[@]}"; do
    printf '%-44s %8s\n' "${stage_names[index]}" "${stage_seconds[index]}"
  done
  printf '%-44s %8s\n' "in all" "$SECONDS"
  exit "$status"
}
trap stage_table EXIT
