#!/usr/bin/env bash
# Measures the window at 800x600 on a display of its own (Xvfb), with the shipped scan: pictures a second while it is dragged,
# the time from letting go to full quality, and redraws in two seconds at rest. Build it before, best for release:
#   cargo build --release --features viewer && PROFILE=release scripts/frame_rate.sh [RUNS] [ARGUMENTS OF view]
set -euo pipefail
cd "$(dirname "$0")/.."

runs=${1:-5}
scratch=$(mktemp -d)
. scripts/display.sh
trap 'close_display; rm -rf "$scratch"' EXIT

open_window 800 600 "${@:2}" data/stent.nrrd
settle
moves=()
for i in $(seq 240); do
    moves+=(mousemove $((520 + i * 7 % 180)) $((180 + i * 3 % 60)) sleep 0.016)
done
# The time that the last line which matches was logged at, in ms.
last_at() {
    grep "$1" "$scratch/window.log" | tail -n 1 | sed 's/.*at \([0-9]*\) ms:.*/\1/'
}
for _ in $(seq "$runs"); do
    from=$(lines)
    xdotool mousemove 520 180 mousedown 1
    start=$(date +%s%3N)
    xdotool "${moves[@]}"
    took=$(($(date +%s%3N) - start))
    pictures=$(tail -n "+$((from + 1))" "$scratch/window.log" | grep -c 'ms: picture' || true)
    level=$(grep 'moving' "$scratch/window.log" | tail -n 1 | sed 's/.*moving: //')
    moved=$(last_at 'moving')
    xdotool mouseup 1
    settle
    full=$(grep 'at rest' "$scratch/window.log" | tail -n +1 | sed 's/.*at \([0-9]*\) ms:.*/\1/' | awk -v from="$moved" '$1 > from { print; exit }')
    still=$(lines)
    sleep 2
    echo "$((pictures * 10000 / took))" | sed 's/\(.\)$/.\1/' | tr '\n' ' '
    echo "pictures a second ($level); full quality $((full - moved)) ms after the last; $(($(lines) - still)) lines logged in 2 s at rest; load $(cut -d' ' -f1 /proc/loadavg)"
done
