#!/usr/bin/env bash
# get_instrumented_tbb.sh PREFIX: oneTBB compiled with the thread sanitizer, for the preset tsan.
#
# Debian's oneTBB is not: the sanitizer then sees no order between what a task wrote and who reads it after the join, and
# reports correct programs by the hundred. Silencing whatever has libtbb.so in its stack silences every race in our own
# parallel loops, too. With the library instrumented, a race in a loop's body is reported (tests/tsan_suppressions.txt).
# It is compiled by the preset's own compiler: one program has one sanitizer.
set -euo pipefail
prefix=$(realpath -m "${1:?usage: get_instrumented_tbb.sh PREFIX}")
here=$(dirname "$(realpath "$0")")
version=$(cat "$0" "$here/get_debian_source.sh" | sha256sum | cut -c1-16)
part=$prefix.part
say() { printf 'get_instrumented_tbb: %s\n' "$*" >&2; }
[ "$(cat "$prefix/.stamp" 2> /dev/null || true)" != "$version" ] || exit 0

rm -rf "$part"
mkdir -p "$part"
trap 'rm -rf "$part"' EXIT
trap 'exit 130' INT TERM HUP
say "fetching the source of oneTBB"
"$here/get_debian_source.sh" onetbb "$part/source"
say "building it"
{
    cmake -G Ninja -S "$part/source" -B "$part/build" -DCMAKE_BUILD_TYPE=Release -DTBB_SANITIZE=thread \
        -DCMAKE_C_COMPILER=clang-16 -DCMAKE_CXX_COMPILER=clang++-16 \
        -DTBB_TEST=OFF -DTBB_STRICT=OFF -DTBBMALLOC_BUILD=OFF \
        -DCMAKE_INSTALL_PREFIX="$part/stage" -DCMAKE_INSTALL_LIBDIR=lib &&
        ninja -C "$part/build" install
} > "$part/log" 2>&1 < /dev/null || {
    tail -n 25 "$part/log" >&2
    say "oneTBB does not build with the thread sanitizer; its last lines stand above"
    exit 1
}
echo "$version" > "$part/stage/.stamp"
rm -rf "$prefix"
mv "$part/stage" "$prefix"
say "$prefix is ready"
