# Opens the window on a display of its own (Xvfb), for the scripts that drive it. To be sourced, after `scratch` names a folder;
# needs Xvfb, xdotool and ImageMagick, and the window built: cargo build --features viewer
# shellcheck shell=bash

binary=$(realpath "${CARGO_TARGET_DIR:-target}/${PROFILE:-debug}/hollowcast")
display=
window=

# Ends what was started.
close_display() {
    kill $window $display 2> /dev/null || true
}

# fail WHY
fail() {
    echo "$(basename "$0"): $1" >&2
    tail -n 40 "$scratch/window.log" >&2
    exit 1
}

# open_window WIDTH HEIGHT ARGUMENTS: shows the window, in all of a screen of that size. What it does is logged.
open_window() {
    local width=$1 height=$2 number id
    shift 2
    mkfifo "$scratch/number"
    Xvfb -displayfd 3 -screen 0 "${width}x${height}x24" -nolisten tcp 3> "$scratch/number" 2> "$scratch/xvfb.log" &
    display=$!
    read -r number < "$scratch/number"
    export DISPLAY=:$number
    unset WAYLAND_DISPLAY
    NO_COLOR=1 RUST_LOG=hollowcast=debug "$binary" view "$@" > "$scratch/window.log" 2>&1 &
    window=$!
    id=$(timeout 60 xdotool search --sync --onlyvisible --name '^hollowcast$' | head -n 1)
    [ -n "$id" ] || fail "no window opened"
    # Without a window manager nobody else gives it the keyboard.
    xdotool windowsize "$id" "$width" "$height" windowmove "$id" 0 0 windowfocus "$id"
}

# logged PATTERN: how many lines of the log match.
logged() {
    grep -c "$1" "$scratch/window.log" || true
}

# lines: how long the log is.
lines() {
    wc -l < "$scratch/window.log"
}

# settle: waits until a picture at rest is there and the window is no longer redrawn for two seconds.
settle() {
    local last now
    for _ in $(seq 60); do
        kill -0 $window 2> /dev/null || fail "the window closed"
        last=$(lines)
        sleep 2
        now=$(lines)
        [ "$now" = "$last" ] && [ "$(logged 'at rest')" -gt 0 ] && return
    done
    fail "the window does not come to rest"
}

# await WHAT COMMAND: waits until a command succeeds.
await() {
    local what=$1
    shift
    for _ in $(seq 150); do
        kill -0 $window 2> /dev/null || fail "the window closed"
        "$@" && return
        sleep 0.2
    done
    fail "$what does not come"
}
