#!/usr/bin/env bash
# Runs all tests, on a machine that may have nothing but Rust: where no graphics adapter is found, Mesa's software one is
# installed first (Debian and Ubuntu), for the tests that draw with one fail without it. So is Chromium, in which the test of
# reports opens one; without it that test says that it was not run. And so is a display without a screen, on which the test of
# the window opens it.
#
# HOLLOWCAST_DATA and HOLLOWCAST_FORMATS name folders with more volumes and with conformance samples; where both are set,
# the tests that read them run too.
set -euo pipefail
cd "$(dirname "$0")/.."

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

has_adapter() {
    cargo run --quiet --locked --features viewer -- render phantom:sphere:8 --backend gpu --size 8 -o "$scratch/probe.npy" > "$scratch/probe.log" 2>&1
}

as_root() {
    if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi
}

# Without the feature nothing that opens windows is built.
cargo check --locked
windowing=$(cargo tree --locked -e normal --prefix none | grep -E '^(eframe|egui|winit|rfd|wayland-client|x11rb) ' || true)
if [ -n "$windowing" ]; then
    echo "test.sh: the command without the feature viewer depends on $windowing" >&2
    exit 1
fi

cargo build --locked --features viewer
if ! has_adapter; then
    echo "test.sh: no graphics adapter works here ($(tail -n 1 "$scratch/probe.log"))"
    if ! command -v apt-get > /dev/null; then
        echo "test.sh: install a Vulkan driver (Mesa's software one will do) and run this again" >&2
        exit 1
    fi
    echo "test.sh: installing Mesa's software adapter"
    as_root apt-get update -q
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends libvulkan1 mesa-vulkan-drivers
fi

if ! command -v chromium > /dev/null && ! command -v chromium-browser > /dev/null && command -v apt-get > /dev/null; then
    echo "test.sh: installing chromium"
    as_root apt-get update -q || true
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends chromium ||
        echo "test.sh: chromium could not be installed: reports are not opened in a browser"
fi

if [ -n "${HOLLOWCAST_DATA:-}" ] && [ -n "${HOLLOWCAST_FORMATS:-}" ]; then
    cargo test --locked --features viewer -- --include-ignored
else
    cargo test --locked --features viewer
    for folder in HOLLOWCAST_DATA HOLLOWCAST_FORMATS; do
        if [ -z "${!folder:-}" ]; then
            echo "test.sh: $folder is not set: tests that read it were not run; they are in"
            grep -rl "$folder" tests src --include='*.rs' | sed 's/^/  /' || true
        fi
    done
    echo "test.sh: tests that are run only where both are set:"
    cargo test --locked --features viewer -- --ignored --list 2> /dev/null | sed -n 's/: test$//p' | sed 's/^/  /'
fi

has_display() {
    for tool in Xvfb xdotool import; do
        command -v "$tool" > /dev/null || return 1
    done
}
if ! has_display; then
    if ! command -v apt-get > /dev/null; then
        echo "test.sh: install Xvfb, xdotool and ImageMagick and run this again" >&2
        exit 1
    fi
    echo "test.sh: installing a display without a screen"
    as_root apt-get update -q
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends \
        xvfb xdotool imagemagick libxkbcommon-x11-0 libxcursor1 libxi6 libxrandr2
fi
scripts/window.sh
