#!/bin/bash
# Packs a program that was built on Debian with its loader, its libraries and their licences: one
# archive, the same bytes for the same files.
#
# usage: pack.sh PROGRAM ARCHIVE.tar.gz
set -euo pipefail
program=$(realpath "$1")
archive=$(realpath --canonicalize-missing "$2")
cd "$(dirname "$0")/.."
name=$(basename "$archive" .tar.gz)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
root=$work/$name
mkdir -p "$root"/{bin,lib,licences}

cp "$program" "$root/lib/itarl"
strip "$root/lib/itarl"
cc -static -Os -s -Wall -Wextra -Werror -o "$root/bin/itarl" dist/launcher.c

# dpkg knows a file by the path that its package has, and /lib may be a link to /usr/lib.
package_of() {
  file=$(realpath "$1")
  { dpkg-query --search "$file" || dpkg-query --search "${file#/usr}"; } 2>/dev/null | cut -d: -f1 | head -n 1
}

# "libm.so.6 => /lib/.../libm.so.6 (0x...)", and the loader, which has no arrow.
libraries=$(ldd "$program" | sed -n 's/.*=> \(\/[^ ]*\) .*/\1/p; s/^[ \t]*\(\/[^ ]*\) (.*/\1/p')
for library in $libraries; do
  cp --dereference "$library" "$root/lib/"
  package=$(package_of "$library")
  echo "$package $(dpkg-query --show --showformat='${Version}, source ${source:Package} ${source:Version}' "$package")"
  cp --dereference "/usr/share/doc/$package/copyright" "$root/licences/$package"
done | sort -u >"$root/licences/debian-packages"

dist/licences.sh "$root/licences"

mkdir -p "$root/share/man/man1"
"$program" man --out "$root/share/man/man1" >/dev/null

cp dist/README "$root/README"
cp -r experiments models "$root/"
find "$root" -type d -exec chmod 755 {} +
find "$root" -type f -exec chmod u=rw,go=r {} +
chmod 755 "$root/bin/itarl" "$root/lib/itarl" "$root/lib/ld-linux-x86-64.so.2"
mkdir -p "$(dirname "$archive")"
tar --create --directory="$work" --sort=name --owner=0 --group=0 --numeric-owner --mtime=@0 "$name" |
  gzip --no-name -9 >"$archive"
echo "$archive: $(du -h "$archive" | cut -f1)"
