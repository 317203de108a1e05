#!/bin/bash
# get_e57format.sh PREFIX: libE57Format, static and position independent, under PREFIX/include and PREFIX/lib.
#
# Debian 12 has no package of it, but carries its source within that of freecad; get_debian_source.sh fetches that.
#
# PREFIX appears by one rename when everything is built, so that a killed run leaves no half library; a second run finds
# the stamp and does nothing.
set -euo pipefail

prefix=$(realpath -m "${1:?usage: get_e57format.sh PREFIX}")
stamp="$prefix/.stamp"
part="$prefix.part"
here=$(dirname "$(realpath "$0")")
version=$(cat "$here/get_e57format.sh" "$here/get_debian_source.sh" | sha256sum | cut -c1-16)

say() { printf 'get_e57format: %s\n' "$*" >&2; }
fail() { say "$*"; exit 1; }
# run LOG-NAME WHAT-FAILED COMMAND...: quiet unless it fails.
run() {
    local log="$part/$1.log" what=$2
    shift 2
    "$@" >"$log" 2>&1 </dev/null || { tail -n 25 "$log" >&2; fail "$what (the last lines of its output stand above)"; }
}

mkdir -p "$(dirname "$prefix")" || fail "cannot create $(dirname "$prefix")"
exec 9>"$prefix.lock" || fail "cannot write $prefix.lock"
flock 9 || fail "cannot lock $prefix.lock"
[ "$(cat "$stamp" 2>/dev/null || true)" = "$version" ] && exit 0
if [ -e "$prefix" ] && [ ! -e "$stamp" ] && [ -n "$(ls -A "$prefix")" ]; then
    fail "$prefix holds something else; name an empty or a new folder"
fi

for tool in apt-get dpkg-source cmake ninja c++ tar xz; do
    command -v "$tool" >/dev/null || fail "$tool is missing; install the packages that README.md names"
done

rm -rf "$part"
mkdir -p "$part/stage" || fail "cannot write to $part"
trap 'rm -rf "$part"' EXIT
trap 'exit 130' INT TERM HUP

say "fetching the source"
run fetch "the source of freecad, which carries libE57Format, could not be fetched" \
    "$here/get_debian_source.sh" freecad "$part/freecad"
source="$part/freecad/src/3rdParty/libE57Format"
[ -d "$source" ] || fail "freecad's source has no src/3rdParty/libE57Format any more"

# Two faults of version 2.2.1 are corrected. correct FILE SED-COMMAND: changes that file of its source, or fails.
correct() {
    local file="$source/src/$1" before
    before=$(cksum "$file") || fail "libE57Format's source has no src/$1 any more"
    run correct "cannot correct src/$1" sed -i "$2" "$file"
    [ "$before" != "$(cksum "$file")" ] || fail "libE57Format's source has changed: see what is corrected in src/$1"
}
# It wants every index packet to be as long as the longest one, and so refuses the files that its own later versions write.
# An index packet is at least as long as its header.
correct Packet.cpp '/^void IndexPacket::verify/,/^}/ s/packetLength < sizeof( \*this )/packetLength < 16/'
# It looks a word past the end of its buffer where the last integer does not reach into that word.
correct Decoder.cpp \
    's/RegisterT high = inp\[wordPosition + 1\];/RegisterT high = bitOffset + bitsPerRecord_ > 8 * sizeof( RegisterT ) ? inp[wordPosition + 1] : 0;/'

say "building it"
run configure "cmake cannot configure libE57Format" \
    cmake -G Ninja -S "$source" -B "$part/build" -DCMAKE_BUILD_TYPE=Release -DCMAKE_POSITION_INDEPENDENT_CODE=ON \
    -DBUILD_SHARED_LIBS=OFF -DCMAKE_INSTALL_PREFIX="$part/stage" -DCMAKE_INSTALL_LIBDIR=lib
run build "libE57Format does not compile" ninja -C "$part/build" -j "${JOBS:-$(nproc)}" install
# freecad's copy installs the library and one generated header alone; all headers go into one folder.
headers="$part/stage/include/E57Format"
mkdir -p "$headers"
cp "$source"/include/*.h "$headers/" || fail "libE57Format's source has no headers in include/"
[ -e "$headers/E57Export.h" ] || fail "the build left no E57Export.h"
cp "$source"/LICENSE* "$part/stage/" 2>/dev/null || true
[ -e "$part/stage/lib/libE57Format.a" ] || fail "the build left no lib/libE57Format.a"

echo "$version" >"$part/stage/.stamp"
rm -rf "$prefix"
mv "$part/stage" "$prefix" || fail "cannot move the finished library to $prefix"
say "$prefix is ready"
