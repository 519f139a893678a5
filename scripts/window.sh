#!/usr/bin/env bash
# Opens the real window on a display of its own (Xvfb), turns the shipped scan in it, and fails where no picture comes or
# where the window goes on working once all is drawn. Needs Xvfb, xdotool and ImageMagick, and the window built:
#   cargo build --features viewer
# With a folder as argument, screenshots are left there.
set -euo pipefail
cd "$(dirname "$0")/.."

binary=${CARGO_TARGET_DIR:-target}/${PROFILE:-debug}/hollowcast
scratch=$(mktemp -d)
folder=${1:-$scratch}
display=
window=
trap 'kill $window $display 2> /dev/null || true; rm -rf "$scratch"' EXIT

mkfifo "$scratch/number"
Xvfb -displayfd 3 -screen 0 1280x720x24 -nolisten tcp 3> "$scratch/number" 2> "$scratch/xvfb.log" &
display=$!
read -r number < "$scratch/number"
export DISPLAY=:$number
unset WAYLAND_DISPLAY

fail() {
    echo "window.sh: $1" >&2
    cat "$scratch/window.log" >&2
    exit 1
}

"$binary" view data/stent.nrrd > "$scratch/window.log" 2>&1 &
window=$!
timeout 60 xdotool search --sync --onlyvisible --name '^hollowcast$' > /dev/null || fail "no window opened"

shoot() {
    import -window root "$folder/$1.png"
}
# Waits until the screen shows a picture, which has more colours than panels alone, and no longer changes.
settle() {
    local last=
    for _ in $(seq 60); do
        kill -0 $window 2> /dev/null || fail "the window closed"
        shoot "$1"
        local now
        now=$(identify -format '%k %#' "$folder/$1.png")
        [ "$now" = "$last" ] && [ "${now%% *}" -gt 1000 ] && return
        last=$now
        sleep 1
    done
    fail "no picture that stays"
}

settle window
xdotool mousemove 760 260
sleep 0.5
xdotool mousedown 1
for x in $(seq 770 10 900); do
    xdotool mousemove "$x" 270
    sleep 0.05
done
xdotool mouseup 1
sleep 1
settle turned
apart=$(compare -metric AE "$folder/window.png" "$folder/turned.png" null: 2>&1 || true)
[ "${apart%%.*}" -gt 3000 ] || fail "dragging turned nothing"

# At rest it uses no time: jiffies of the process over two seconds.
used() { awk '{ print $14 + $15 }' "/proc/$window/stat"; }
idle=
for _ in $(seq 30); do
    from=$(used)
    sleep 2
    if [ $(($(used) - from)) -le 4 ]; then
        idle=yes
        break
    fi
done
[ -n "$idle" ] || fail "the window does not come to rest"
kill -0 $window 2> /dev/null || fail "the window closed"
echo "window.sh: the window opens, turns and rests"
