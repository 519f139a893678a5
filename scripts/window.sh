#!/usr/bin/env bash
# From end to end in the real window, on a display of its own (Xvfb): loads the shipped scan, turns it, drags a control
# point, switches the method, compares, and saves a picture, which the copied command line must draw again, bit for bit.
# Fails too where the window is redrawn although nothing changes. Needs Xvfb, xdotool and ImageMagick, and the window built:
#   cargo build --features viewer
# With a folder as argument, screenshots are left there.
set -euo pipefail
cd "$(dirname "$0")/.."

scratch=$(mktemp -d)
folder=${1:-$scratch}
. scripts/display.sh
trap 'close_display; rm -rf "$scratch"' EXIT

open_window 1280 720 "$PWD/data/stent.nrrd"
shoot() {
    import -window root "$folder/$1.png"
}
# Pixels that differ between two screenshots.
apart() {
    local count
    count=$(compare -metric AE "$folder/$1.png" "$folder/$2.png" null: 2>&1 || true)
    echo "${count%%[!0-9]*}"
}
# drag X Y X Y: slowly enough to be followed.
drag() {
    local i moves=()
    for i in $(seq 12); do
        moves+=(mousemove $(($1 + ($3 - $1) * i / 12)) $(($2 + ($4 - $2) * i / 12)) sleep 0.05)
    done
    xdotool mousemove "$1" "$2" sleep 0.3 mousedown 1 sleep 0.1 "${moves[@]}" mouseup 1
}
key() {
    xdotool key --delay 40 "$@"
    sleep 0.5
}

settle
shoot window
[ "$(identify -format %k "$folder/window.png")" -gt 1000 ] || fail "no picture"

drag 760 260 900 270
settle
shoot turned
[ "$(apart window turned)" -gt 3000 ] || fail "dragging turned nothing"

# The last control point lies at the right edge of the editor.
drag 1263 634 1180 590
settle
shoot edited
[ "$(apart turned edited)" -gt 3000 ] || fail "dragging moved no control point"

# Off the editor, whose wheel and clicks would edit.
xdotool mousemove 760 260
for _ in 1 2; do key m; done
await "a picture by hull" grep -q ' by hull, .* at rest' "$scratch/window.log"

for _ in 1 2 3; do key c; done
settle
shoot difference
[ "$(apart edited difference)" -gt 3000 ] || fail "comparing shows nothing"
key c

key ctrl+shift+c
await "the command line" grep -q 'copied: ' "$scratch/window.log"
# A transfer function that is no preset is in it as the text of its file, line by line.
line=$(sed -n '/copied: /,/-o picture.png/p' "$scratch/window.log" | sed '1s/.*copied: //')
[[ $line == *"--method hull"* && $line == *"opacity = "* ]] || fail "the command line is another: $line"

key ctrl+s
sleep 1
key ctrl+a
xdotool type --delay 20 "$scratch/saved.png"
key Return
await "the saved picture" test -s "$scratch/saved.png"
hollowcast() { "$binary" "$@"; }
(cd "$scratch" && eval "$line") > /dev/null
cmp "$scratch/saved.png" "$scratch/picture.png" || fail "the command line draws another picture: $line"

settle
kill -0 $window 2> /dev/null || fail "the window closed"
echo "window.sh: turned, edited, switched, compared, saved as the copied command line draws it, and at rest"
