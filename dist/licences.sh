#!/bin/bash
# The terms of all that is in the program itself: its own, those of the Rust crates, of the font and of
# three.js. Bullet and the system's libraries are beside it, and have their own.
#
# usage: licences.sh FOLDER
set -euo pipefail
mkdir -p "$1"
folder=$(realpath "$1")
cd "$(dirname "$0")/.."
cp LICENSE-MIT LICENSE-APACHE "$folder/"
cp crates/scenes/fonts/OFL.txt "$folder/Liberation-Sans"
cp crates/scenes/assets/three/LICENSE "$folder/three.js"
registry=${CARGO_HOME:-$HOME/.cargo}/registry/src
cargo tree --package runner --edges normal --prefix none --format '{p}	{l}' --no-dedupe | sort -u |
  while IFS=$'\t' read -r package licence; do
    read -r crate version rest <<<"$package"
    for sources in "$registry"/*/"$crate-${version#v}"; do
      test -d "$sources" || continue
      echo "== $crate ${version#v}: $licence"
      find "$sources" -maxdepth 1 -type f \( -iname 'licen[cs]e*' -o -iname 'copying*' -o -iname 'notice*' \) |
        sort | xargs -r -d '\n' cat
    done
  done >"$folder/rust-crates"
test -s "$folder/rust-crates"
