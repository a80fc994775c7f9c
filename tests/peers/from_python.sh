#!/usr/bin/env bash
# Compares wbqp's Python package with PlaCo, tsid and mink (from_python.py), and writes the tables in
# docs/performance.md. Installs all that is needed below target/; tsid and PlaCo come with different versions of
# Pinocchio, so that there are two environments. Needs Rust, for wbqp's package, and Python 3.11. From the workspace's
# root:
#
#     bash tests/peers/from_python.sh
#
# ROUNDS=7 is how often each step is timed. Two minutes once everything is installed.
set -euo pipefail
cd "$(dirname "$0")/../.."

work=${WORK:-target/peers-python}
python=${PYTHON:-python3}
mkdir -p "$work"

environment() { # name requirements
    if ! cmp -s "$2" "$work/$1/requirements.txt"; then
        "$python" -m venv --clear "$work/$1"
        "$work/$1/bin/pip" install -q -r "$2"
        cp "$2" "$work/$1/requirements.txt"
    fi
}
environment tsid tests/peers/requirements_python_tsid.txt
environment peers tests/peers/requirements_python.txt
"$work/peers/bin/pip" install -q ./python

# Ahead of what else the machine does, where one may.
ahead=()
if nice -n -5 true 2>/dev/null; then ahead=(nice -n -5); fi
"${ahead[@]}" "$work/tsid/bin/python" tests/peers/from_python.py --work "$work/run" --rounds "${ROUNDS:-7}" \
    --python "$work/peers/bin/python" --tsid "$work/tsid/bin/python" \
    --json "$work/from_python.json" --page docs/performance.md "$@"
