#!/usr/bin/env bash
# Makes the pictures of the documents: those of the viewer with the real viewer, headless, and that of the report with Chromium:
#
#   docs/pictures.sh [FOLDER]     default: docs/images
#
# viewer_before.png, viewer_first_yield.png, viewer_peak.png and viewer_rest.png show the column of config/heb220_s355.yaml at four
# moments with its displacements magnified, viewer_car.png the same at the peak to scale, and viewer_fleet.png twelve such columns
# of which two were hit, over DDS on loopback.
# risk_*.svg and estimate_forecast.svg are the figures of docs/results.md.
# report.png is the first page of the report about the default impact of config/heb220_s355.yaml, as printed.
# The script needs Rust, Python, Chromium with the DejaVu fonts, poppler-utils, access to PyPI (tests/interop/viewer.sh installs the viewer) and a Vulkan driver; without a
# graphics card, Debian's mesa-vulkan-drivers is sufficient.
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
mkdir -p "${1:-$repository/docs/images}"
folder=$(cd "${1:-$repository/docs/images}" && pwd)
cd "$repository"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

viewer=$(tests/interop/viewer.sh)
venv=${viewer%/lib/*}
home=$venv/home
cargo build --quiet --release --bin column-twin --example viewer_moments
program=${CARGO_TARGET_DIR:-target}/release/column-twin
moments=${CARGO_TARGET_DIR:-target}/release/examples/viewer_moments
# To scale, nobody sees a column bend by 21 mm.
{
  cat config/heb220_s355.yaml
  printf '\n    viewer:\n      magnification: 10.0\n'
} >"$work/magnified.yaml"
"$moments" "$work/magnified.yaml" "$work"
mkdir "$work/car"
"$moments" config/heb220_s355.yaml "$work/car"
mv "$work/car/peak.rrd" "$work/car.rrd"

# Rows of the fleet stand 8 m apart, its columns 6 m.
{
  printf 'namespace,column_id,site.x,site.y\n'
  y=0
  for row in a b c; do
    for number in 1 2 3 4; do
      printf '/garage/%s,%s,%d,%d\n' "$row$number" "$row$number" $((6 * number)) "$y"
    done
    y=$((y + 8))
  done
} >"$work/fleet.csv"
# Each row of the table has a column_id of its own.
sed '/column_id:/d' config/heb220_s355.yaml >"$work/fleet.yaml"
export XDG_STATE_HOME=$work/state ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST ROS_DOMAIN_ID=$((100 + RANDOM % 100))
"$program" fleet --params-file "$work/fleet.yaml" --columns "$work/fleet.csv" --ros-args -p viewer.mode:=save \
  -p "viewer.directory:=$work/fleet" >"$work/log" 2>&1 &
fleet=$!
# The pauses let the viewer's file have the end of each impact.
if ! { "$program" impact --column c1 --velocity 10 && sleep 3 &&
  "$program" impact --column b3 --vehicle lorry_16t --velocity 15 && sleep 3; } >"$work/impacts" 2>&1; then
  cat "$work/log" "$work/impacts" >&2
  printf 'pictures: no impacts on the fleet\n' >&2
  kill "$fleet" || true
  exit 1
fi
kill "$fleet"
wait "$fleet"
mv "$work"/fleet/fleet_*.rrd "$work/fleet.rrd"

for moment in before first_yield peak rest car fleet; do
  # The viewer needs a free port, although no program connects to it.
  port=$(python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
  HOME=$home XDG_CONFIG_HOME=$home XDG_RUNTIME_DIR=$work RUST_LOG=error \
    timeout 120 "$viewer" "$work/$moment.rrd" --headless --window-size 1600x1000 --bind 127.0.0.1 --port "$port" \
    --screenshot-to "$folder/viewer_$moment.png" >"$work/log" 2>&1 || {
    cat "$work/log" >&2
    printf 'pictures: no picture of %s\n' "$moment" >&2
    exit 1
  }
  printf '%s\n' "$folder/viewer_$moment.png"
done

"$program" simulate --config config/heb220_s355.yaml --report "$work/report.html" >"$work/log"
# Chromium's sandbox does not run as root; the file is our own.
chromium --headless --no-sandbox --user-data-dir="$work/chromium" --no-pdf-header-footer \
  --print-to-pdf="$work/report.pdf" "file://$work/report.html" >"$work/log" 2>&1 &&
  pdftoppm -f 1 -l 1 -r 100 -singlefile -png "$work/report.pdf" "$folder/report" 2>"$work/log" || {
  cat "$work/log" >&2
  printf 'pictures: no picture of the report\n' >&2
  exit 1
}
printf '%s\n' "$folder/report.png"

sensors=(--config config/heb220_s355.yaml --config config/sensors_industrial.yaml)
"$program" risk --config config/heb220_s355.yaml --scenario urban --distance 3 --vehicles-per-day 10000 --samples 2000 --measures \
  --figures "$work/risk" >"$work/log"
"$program" simulate "${sensors[@]}" --vehicle mid_car --velocity 12 --readings "$work/readings.csv" >"$work/log"
"$program" estimate "${sensors[@]}" --readings "$work/readings.csv" --figures "$work/estimate" >"$work/log"
cp "$work/risk/risk_probability.svg" "$work/risk/risk_measures.svg" "$work/estimate/estimate_forecast.svg" "$folder"
printf '%s\n' "$folder/risk_probability.svg" "$folder/risk_measures.svg" "$folder/estimate_forecast.svg"
