# Sourced: `seeded NAME` makes target/NAME for another image of the firmware out of what the first one's build
# has left: all images share most of what they are linked from, and each then compiles its own part alone.
seeded() {
  local folder=target/$1
  if [ -d target/firmware ] && [ ! -d "$folder" ]; then
    mkdir "$folder"
    # Links: what is built anew gets files of its own.
    cp -al target/firmware target/thumbv7em-none-eabihf "$folder"/
  fi
}
