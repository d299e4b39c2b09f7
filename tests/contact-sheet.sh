#!/bin/sh
# Pictures of all robots below some folders on one page, OUT/index.html, and why one has none:
#   contact-sheet.sh ITARL OUT FOLDER...
set -eu
itarl=$1
out=$2
shift 2
mkdir -p "$out"

as_text() {
  sed 's/&/\&amp;/g; s/</\&lt;/g'
}

find "$@" -type f \( -name '*.toml' -o -name '*.urdf' -o -name '*.xml' -o -name '*.sdf' -o -name '*.rosiml' \) |
  sort | {
  n=0
  echo '<!DOCTYPE html><meta charset="utf-8"><title>Robots</title>'
  echo '<style>body { display: flex; flex-wrap: wrap } figure { width: 400px; margin: 4px } img { max-width: 400px; max-height: 400px }</style>'
  while IFS= read -r robot; do
    n=$((n + 1))
    echo '<figure>'
    if "$itarl" replay "$robot" --png "$out/$n.png" >/dev/null 2>"$out/why"; then
      echo "<img src=\"$n.png\">"
    else
      echo "<pre>$(as_text <"$out/why")</pre>"
    fi
    echo "<figcaption>$(echo "$robot" | as_text)</figcaption></figure>"
  done
  rm -f "$out/why"
} >"$out/index.html"
