#!/usr/bin/env bash
# get_debian_source.sh PACKAGE FOLDER [SUITE]: the upstream archive of one of Debian's source packages, unpacked in FOLDER.
# SUITE is a release of Debian; without it, this machine's own.
#
# Fetched through a private apt configuration whose mirror and keys are those the machine's own apt uses; apt checks the
# archive against the signed index, and nothing of the machine's apt configuration is changed.
set -euo pipefail
package=${1:?usage: get_debian_source.sh PACKAGE FOLDER [SUITE]}
folder=$(realpath -m "${2:?usage: get_debian_source.sh PACKAGE FOLDER [SUITE]}")
suite=${3:-}
fail() {
    printf 'get_debian_source: %s\n' "$*" >&2
    exit 1
}

part=$folder.part
rm -rf "$part"
mkdir -p "$part"/apt/{lists/partial,cache/archives/partial,sources} "$part/tree" || fail "cannot write $part"
trap 'rm -rf "$part"' EXIT
trap 'exit 130' INT TERM HUP

# shellcheck disable=SC1091
codename=$(. /etc/os-release && echo "${VERSION_CODENAME:-}")
# shellcheck disable=SC2016 # apt expands these
mirror=$(apt-get indextargets --format '$(SITE)|$(RELEASE)|$(COMPONENT)' 'Created-By: Packages' |
    awk -F'|' -v release="$codename" '$2 == release && $3 == "main" { print $1; exit }') || true
[ -n "$mirror" ] || fail "apt knows no main packages of '$codename'; add Debian's own to apt's sources"
cat > "$part/apt/sources/main.sources" << END
Types: deb-src
URIs: $mirror
Suites: ${suite:-$codename}
Components: main
Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg
END
# The sandbox user of apt may not reach a folder in somebody's home.
cat > "$part/apt/apt.conf" << END
Dir::Etc::sourcelist "/dev/null";
Dir::Etc::sourceparts "$part/apt/sources";
Dir::Etc::preferencesparts "/dev/null";
Dir::State::lists "$part/apt/lists";
Dir::Cache "$part/apt/cache";
APT::Sandbox::User "root";
Acquire::Languages "none";
Acquire::Retries "3";
END
export APT_CONFIG=$part/apt/apt.conf
cd "$part"
{ apt-get -q update && apt-get -q source --tar-only --download-only "$package"; } > "$part/log" 2>&1 < /dev/null || {
    tail -n 5 "$part/log" >&2
    fail "apt cannot fetch the source of $package from ${suite:-$codename}; see above"
}
archive=$(find . -maxdepth 1 -name '*.orig.tar.*' ! -name '*.asc' | head -n 1)
[ -n "$archive" ] || fail "apt fetched no upstream archive of $package"
tar -xf "$archive" -C "$part/tree" --strip-components=1 || fail "cannot unpack $archive"
rm -rf "$folder"
mv "$part/tree" "$folder"
