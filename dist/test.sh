#!/bin/bash
# An archive in systems that have nothing of what it needs: an empty root with /proc and /dev alone, and
# an older Debian. What it trains there has the bytes of the installed program.
#
# usage: test.sh PROGRAM ARCHIVE.tar.gz [ROOT OF AN OLDER SYSTEM]...
set -euo pipefail
program=$(realpath "$1")
archive=$(realpath "$2")
shift 2
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
what=(tests/experiments/crawler.toml --out)
"$program" train "${what[@]}" "$work/installed"

mkdir "$work/empty"
for system in "$work/empty" "$@"; do
  rm -rf "$system/itarl-test"
  mkdir -p "$system"/{proc,dev,itarl-test/tests}
  tar --extract --gzip --file="$archive" --directory="$system/itarl-test" --strip-components=1
  cp -r tests/experiments tests/models "$system/itarl-test/tests/"
  # Its own mounts, which end with it.
  unshare --mount bash -euc '
    mount --rbind /proc "$0/proc"
    mount --rbind /dev "$0/dev"
    for words in "train $1 /itarl-test/run" "report /itarl-test/run" "status /itarl-test/run"; do
      chroot "$0" /itarl-test/bin/itarl $words
    done' "$system" "/itarl-test/${what[*]}"
  diff --recursive --brief --exclude=lock "$work/installed/cells" "$system/itarl-test/run/cells"
  test -s "$system/itarl-test/run/report.html"
  rm -rf "$system/itarl-test"
  echo "$system: trained and reported, with the same bytes"
done
