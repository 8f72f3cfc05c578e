# Sourced: `seeded NAME [OTHER]` makes target/NAME for another image of the firmware out of what the build of
# target/OTHER, or of the default board, has left: images for one chip share most of what they are linked from,
# and each then compiles its own part alone.
seeded() {
  local folder=target/$1 from=target${2:+/$2} own
  if [ -d "$from/firmware" ] && [ ! -d "$folder" ]; then
    mkdir "$folder"
    # Links: what the compiler builds anew gets files of its own.
    cp -al "$from/firmware" "$from/thumbv7em-none-eabihf" "$folder"/
    # What Cargo and build.rs write in place does not.
    find "$folder" -type d \( -name .fingerprint -o -path '*/build/firmware-*' \) -prune -print0 |
      while IFS= read -r -d '' own; do
        cp -a "$own" "$own.own" && rm -r "$own" && mv "$own.own" "$own"
      done
  fi
}
