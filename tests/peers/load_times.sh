#!/usr/bin/env bash
# Times how long `wbqp check` takes for files that nobody would write (tests/src/hostile.rs), and what memory, beside
# another build of the program, and writes the table in docs/performance.md. From the workspace's root:
#
#     bash tests/peers/load_times.sh BEFORE [FOLDER …]
#
# It fails if a promise is not kept: of time, of the first two files beside the other program, and of memory.
#
# BEFORE is the other program, such as one that was built at an older commit; files (*.toml) of further folders are
# timed too. ROUNDS=3 is how often each file is read; the best counts. A program gets SECONDS_MOST=60 s per file.
set -euo pipefail
cd "$(dirname "$0")/../.."

if [ $# -lt 1 ]; then
    sed -n '2,11s/^# \{0,1\}//p' "$0" >&2
    exit 2
fi
before=$(realpath "$1")
shift
cargo build --release --locked -p wbqp-cli
cargo build --release --locked -p wbqp-tests --bin hostile_files
work=${WORK:-target/load-times}
rm -rf "$work"
target/release/hostile_files "$work/files" >"$work.list"
for folder in "$@"; do
    cp "$folder"/*.toml "$work/files/"
done
"${PYTHON:-python3}" tests/peers/load_times.py --before "$before" --after target/release/wbqp --files "$work/files" \
    --list "$work.list" --rounds "${ROUNDS:-3}" --most "${SECONDS_MOST:-60}" --page docs/performance.md
