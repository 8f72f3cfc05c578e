# Sourced: `processor_time` puts into $processor_seconds what this shell's children have taken so far, user
# and system, in whole seconds. By way of a file: in a pipe or a substitution `times` would speak of a shell
# of its own, which has no children.
processor_time() {
  local file
  file=$(mktemp)
  times >"$file"
  processor_seconds=$(awk 'END { for (i = 1; i <= 2; i++) { split($i, t, /[ms]/); s += t[1] * 60 + t[2] }
    printf "%.0f", s }' "$file")
  rm "$file"
}
