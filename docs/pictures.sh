#!/usr/bin/env bash
# Makes the pictures of the tutorials and of the gallery from runs, into docs/pictures:
#
#     bash docs/pictures.sh [FOLDER]
#
# FOLDER is that of the robots of the PyPI package example-robot-data; without it the pictures of its robots stay.
# `wbqp` is taken from PATH, or compiled. The same runs give the same pictures; the films are made by the scripts in
# python/examples.
set -euo pipefail
cd "$(dirname "$0")/.."

wbqp=wbqp
command -v wbqp >/dev/null || { cargo build --release --locked --bin wbqp && wbqp=target/release/wbqp; }
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

# run FILE CASE NAME [OPTIONS]: keeps the figure of the forces and the picture of the robot.
run() {
    local file=$1 case=$2 name=$3
    "$wbqp" run "$file" --case "$case" --out "$out/$name" "${@:4}" >/dev/null 2>&1
    local folder
    folder=$out/$name/$(basename "$file" .toml)
    cp "$folder/$case.contacts.svg" "docs/pictures/${name}_forces.svg"
    cp "$folder/$case.robot.svg" "docs/pictures/${name}_robot.svg"
}

# first_panel NAME: of the figure of several contacts the first, which is what its page is about.
first_panel() {
    python3 - "docs/pictures/${1}_forces.svg" <<'PYTHON'
import re
import sys
from pathlib import Path

HEIGHT = 390  # of a panel
path = Path(sys.argv[1])
text = path.read_text()
# What is drawn lower has its first y beyond.
element = re.compile(r'<(text|polyline|line|rect)\b[^>]*?(?:\by|y1)="(\d+)"[^>]*?(?:/>|>.*?</text>)\n?|'
                     r'<(polyline)\b[^>]*?points="[\d.]+,(\d+)[^>]*?/>\n?', re.DOTALL)
text = element.sub(lambda m: "" if int(m.group(2) or m.group(4)) > HEIGHT else m.group(0), text)
path.write_text(re.sub(r'(height="|viewBox="0 0 960 )\d+"', rf'\g<1>{HEIGHT}"', text, count=3))
PYTHON
}

mkdir -p docs/pictures
run examples/scenarios/push_with_disturbance.toml with_ft push
run examples/scenarios/push_and_slide.toml with_ff slide
run examples/tutorials/quadruped_lift.toml lift quadruped
first_panel quadruped
run examples/scenarios/humanoid_stand.toml stand humanoid
if test $# -gt 0; then
    run examples/tutorials/hextilt_push.toml push hextilt \
        --urdf "$1/hextilt_description/urdf/hextilt_flying_arm_5.urdf"
fi

# Twenty seconds on two soles are more lines than a picture needs.
rm docs/pictures/humanoid_forces.svg

# Small enough for a page that is read on a phone.
for picture in docs/pictures/*; do
    size=$(stat -c %s "$picture")
    test "$size" -le 300000 || { echo "$picture: $size bytes" >&2; exit 1; }
done
ls -l docs/pictures
