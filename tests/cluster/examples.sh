#!/bin/bash
# What docs/clusters.md shows for GNU parallel and Snakemake, as it stands there, but with a smaller
# experiment, a folder of its own, and this machine as the only one.
#
# usage: examples.sh PROGRAM
set -euo pipefail
program=$(realpath "$1")
cd "$(dirname "$0")/../.."
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
mkdir "$dir/bin" "$dir/shared"
ln -s "$program" "$dir/bin/itarl"
export PATH=$dir/bin:$PATH
echo : >"$dir/nodes"

# The block with this name in the page.
example() {
  sed -n "/^\`\`\`[a-z]* $1\$/,/^\`\`\`\$/p" docs/clusters.md | sed '1d;$d' |
    sed "s#experiments/quick.toml#$PWD/tests/experiments/crawler.toml#g; s#/shared/quick#$dir/shared/$1#g
         s#--sshloginfile nodes#--sshloginfile $dir/nodes#g"
}

itarl train tests/experiments/crawler.toml --out "$dir/alone" 2>/dev/null
for name in parallel-workers parallel-parts; do
  example $name >"$dir/$name"
  test -s "$dir/$name"
  bash -eu "$dir/$name"
done
example snakemake >"$dir/Snakefile"
snakemake --quiet --snakefile "$dir/Snakefile" --directory "$dir" --cores 2 --nolock
test -s "$dir/shared/snakemake/report.html"
for name in parallel-workers parallel-parts snakemake; do
  diff --recursive --brief --exclude=lock "$dir/alone/cells" "$dir/shared/$name/cells"
  echo "$name: the same bytes"
done
