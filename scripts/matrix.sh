#!/usr/bin/env bash
# The full matrix: on every phantom, the scans that ship with the project and those in HOLLOWCAST_DATA, every lossless
# method is compared with box, bit by bit, over all views and settings (see `hollowcast verify --help`).
#
# scripts/matrix.sh [BACKEND [SIZE [METHODS]]]    default: gpu, 512 pixels, all methods; hours on two cores without a GPU
set -euo pipefail
cd "$(dirname "$0")/.."
backend=${1:-gpu}
size=${2:-512}
methods=${3:+--methods $3}

cargo build --quiet --locked --release
failed=0
check() {
    target/release/hollowcast verify "$@" --full --backend "$backend" --size "$size" $methods || failed=1
}
for name in sphere shells pot capsules gyroid menger checkerboard noise empty full thin slab ramp; do
    check "phantom:$name:96" --tf ramp:40:255:0.3
done
for name in shells:257x255x63 pot:1x96x96 shells:512; do
    check "phantom:$name" --tf ramp:40:255:0.3
done
check data/qim3d_shell.nrrd --tf ramp:40:255:0.3
check data/stent.nrrd --tf ramp:8:32:0.3
for name in boston_teapot engine aneurism; do
    if [ -n "${HOLLOWCAST_DATA:-}" ]; then
        check "$HOLLOWCAST_DATA/$name.nrrd" --tf ramp:40:255:0.3
    else
        echo "matrix.sh: $name: not run, for HOLLOWCAST_DATA is not set"
    fi
done
exit "$failed"
