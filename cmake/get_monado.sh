#!/bin/bash
# get_monado.sh PREFIX: the OpenXR runtime Monado, for tests: PREFIX/inproc runs within the program that uses it,
# PREFIX/service in a process of its own (bin/monado-service). Both have share/openxr/1/openxr_monado.json.
#
# Debian 12 has no package of it, and the library of Debian 13's wants a newer C library; its source compiles here, and
# get_debian_source.sh fetches that.
#
# PREFIX appears by one rename when everything is built, so that a killed run leaves no half runtime; a second run finds
# the stamp and does nothing.
set -euo pipefail

prefix=$(realpath -m "${1:?usage: get_monado.sh PREFIX}")
stamp="$prefix/.stamp"
part="$prefix.part"
here=$(dirname "$(realpath "$0")")
version=$(cat "$here/get_monado.sh" "$here/get_debian_source.sh" | sha256sum | cut -c1-16)

say() { printf 'get_monado: %s\n' "$*" >&2; }
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

for tool in apt-get dpkg-source cmake ninja c++ pkg-config python3 glslangValidator tar xz; do
    command -v "$tool" >/dev/null || fail "$tool is missing; ./dev names the packages (build_packages, test_packages)"
done

rm -rf "$part"
mkdir -p "$part/stage" || fail "cannot write to $part"
trap 'rm -rf "$part"' EXIT
trap 'exit 130' INT TERM HUP

say "fetching the source"
source="$part/source"
run fetch "the source of Monado could not be fetched" "$here/get_debian_source.sh" monado "$source" trixie

# What is changed in version 25.0.0. correct FILE SED-COMMAND: changes that file of its source, or fails.
correct() {
    local file="$source/src/xrt/$1" before
    before=$(cksum "$file") || fail "Monado's source has no src/xrt/$1 any more"
    run correct "cannot correct src/xrt/$1" sed -i "$2" "$file"
    [ "$before" != "$(cksum "$file")" ] || fail "Monado's source has changed: see what is corrected in src/xrt/$1"
}
# The head and the controllers that tests steer over TCP (the driver `remote`).
hub=drivers/remote/r_hub.c
# It listens to the whole network. Tests are of this machine alone.
correct $hub 's/htonl(INADDR_ANY)/htonl(INADDR_LOOPBACK)/'
# It says nothing when it has taken a packet, so that a test could only wait and hope: now it sends the packet back.
correct $hub 's/^\t\t\tr->latest = data;$/&\n\t\t\tr_remote_connection_write_one(\&r->rc, \&r->latest);/'
# Who hung up stays open until the end: a file for each test program that came and went.
correct $hub '/^\t\t\tret = read_one(r, &data);$/,/^\t\t\t}$/ s/^\t\t\t\tbreak;$/\t\t\t\tsocket_close(r->rc.fd);\n\t\t\t\tr->rc.fd = -1;\n&/'
# It looks once a second whether it should end, and whoever destroys the instance waits for that.
correct $hub 's/{\.tv_sec = 1, \.tv_usec = 0}/{.tv_sec = 0, .tv_usec = 20000}/'
# Its head has no function for the visibility mask, and xrGetVisibilityMaskKHR calls it all the same: a crash.
correct drivers/remote/r_hmd.c \
    's/^\trh->base\.get_view_poses = .*$/&\n\trh->base.get_visibility_mask = u_device_get_visibility_mask;/'

# The compositor that shows nothing has views of 320x240 at 20 Hz. A test chooses both; the largest size follows.
null=compositor/null/null_compositor.c
# number_from_environment C-NAME VARIABLE DEFAULT: a line of Monado's that declares debug_get_num_option_C-NAME().
number_from_environment() { printf 'DEBUG_GET_ONCE_NUM_OPTION(%s, "%s", %s)' "$@"; }
recommended='^static const uint64_t RECOMMENDED_VIEW_'
correct $null "s/${recommended}WIDTH = 320;\$/$(number_from_environment null_width XRT_COMPOSITOR_NULL_WIDTH 320)\\n\
#define RECOMMENDED_VIEW_WIDTH ((uint32_t)debug_get_num_option_null_width())/"
correct $null "s/${recommended}HEIGHT = 240;\$/$(number_from_environment null_height XRT_COMPOSITOR_NULL_HEIGHT 240)\\n\
#define RECOMMENDED_VIEW_HEIGHT ((uint32_t)debug_get_num_option_null_height())\\n\
$(number_from_environment null_hz XRT_COMPOSITOR_NULL_HZ 20)/"
correct $null 's/^\(static const uint64_t MAX_VIEW_WIDTH\) = 1920;/\1 = 8192;/'
correct $null 's/^\(static const uint64_t MAX_VIEW_HEIGHT\) = 1080;/\1 = 8192;/'
correct $null 's/U_TIME_1S_IN_NS \/ 20; \/\/ 20 FPS/U_TIME_1S_IN_NS \/ debug_get_num_option_null_hz();/'

# The simulated head moves with the clock on the wall, so that no two runs see the same. SIMULATED_STATIONARY=1 stills it.
simulated=drivers/simulated/simulated_hmd.c
correct $simulated "s/^DEBUG_GET_ONCE_NUM_OPTION(view_count, .*\$/&\\n\
$(number_from_environment stationary SIMULATED_STATIONARY 0)/"
correct $simulated \
    's/hmd->movement = movement;/hmd->movement = debug_get_num_option_stationary() ? SIMULATED_MOVEMENT_STATIONARY : movement;/'

# What this machine happens to have must not change what is built: off goes everything but the null compositor, the
# compositor in an X window, and the drivers `remote` and `simulated`.
off=(BUILD_TESTING BUILD_DOC XRT_BUILD_SAMPLES XRT_FEATURE_STEAMVR_PLUGIN XRT_MODULE_MONADO_CLI XRT_MODULE_MONADO_GUI
    XRT_HAVE_{OPENGL,OPENGLES,EGL,SDL2,XLIB,LIBUDEV,WAYLAND,DBUS,OPENCV,GST,HIDAPI,LIBUSB,LIBUVC,JPEG,SYSTEMD,LIBBSD}
    XRT_HAVE_{SYSTEM_CJSON,BLUETOOTH,OPENVR,REALSENSE,ONNXRUNTIME,PERCETTO}
    XRT_BUILD_DRIVER_{VIVE,WMR,PSMV,PSSENSE,HYDRA,HDK,NS,RIFT_S,STEAMVR_LIGHTHOUSE,SURVIVE,TWRAP,ULV2,ARDUINO,DAYDREAM}
    XRT_BUILD_DRIVER_{OHMD,DEPTHAI})
off=("${off[@]/%/=OFF}")
for variant in inproc service; do
    say "building it ($variant)"
    case $variant in
        inproc) separate=OFF ;;
        service) separate=ON ;;
    esac
    run "configure_$variant" "cmake cannot configure Monado" \
        cmake -G Ninja -S "$source" -B "$part/$variant" -DCMAKE_BUILD_TYPE=Release "${off[@]/#/-D}" \
        -DXRT_FEATURE_SERVICE=$separate -DXRT_MODULE_IPC=$separate \
        -DCMAKE_INSTALL_PREFIX="$part/stage/$variant" -DCMAKE_INSTALL_LIBDIR=lib
    run "build_$variant" "Monado does not compile" ninja -C "$part/$variant" -j "${JOBS:-$(nproc)}" install
    manifest="$part/stage/$variant/share/openxr/1/openxr_monado.json"
    # Relative, so that the rename below does not part it from its library.
    grep -q '"library_path": "\.\./\.\./\.\./lib/libopenxr_monado\.so"' "$manifest" ||
        fail "the build left no manifest that finds its library"
    [ -e "$part/stage/$variant/lib/libopenxr_monado.so" ] || fail "the build left no lib/libopenxr_monado.so"
done
[ -x "$part/stage/service/bin/monado-service" ] || fail "the build left no bin/monado-service"
cp "$source/LICENSE"* "$part/stage/" 2>/dev/null || true

echo "$version" >"$part/stage/.stamp"
rm -rf "$prefix"
mv "$part/stage" "$prefix" || fail "cannot move the finished runtime to $prefix"
say "$prefix is ready"
