# Sourced by scripts that take long: `stage NAME COMMAND...` runs a command under a headline; at the end, and
# after a stage that failed, a table says how many seconds each has taken, by the clock and of the processors.
. scripts/processor-time.sh

stage_names=()
stage_seconds=()
stage_processor=()

stage() {
  local name=$1 began=$SECONDS before
  shift
  printf '\n== %s\n' "$name"
  processor_time
  before=$processor_seconds
  stage_names+=("$name")
  stage_seconds+=("failed")
  stage_processor+=("")
  "$@"
  processor_time
  stage_seconds[-1]=$((SECONDS - began))
  stage_processor[-1]=$((processor_seconds - before))
}

stage_table() {
  local status=$? index
  printf '\n%-44s %8s %10s\n' "== $(basename "$0")" "seconds" "processor"
  for index in "${!stage_names[@]}"; do
    printf '%-44s %8s %10s\n' "${stage_names[index]}" "${stage_seconds[index]}" "${stage_processor[index]}"
  done
  processor_time
  printf '%-44s %8s %10s\n' "in all" "$SECONDS" "$processor_seconds"
  exit "$status"
}
trap stage_table EXIT
