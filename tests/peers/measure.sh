#!/usr/bin/env bash
# Measures everything that docs/performance.md shows, and writes its tables. Two rounds of 20 000 ticks (`ROUNDS=2
# TICKS=20000`) take seven minutes with dependencies already built. From the workspace's root:
#
#     python3 -m venv target/peers && target/peers/bin/pip install -r tests/peers/requirements.txt
#     PYTHON=target/peers/bin/python bash tests/peers/measure.sh
set -euo pipefail
cd "$(dirname "$0")/../.."

python=${PYTHON:-python3}
ticks=${TICKS:-100000}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

build() { # name, folder for cargo
    cargo build --release --locked --bin tick_stats --target-dir "$2"
    cp "$2/release/tick_stats" "$work/$1"
    cargo bench --no-run --locked -p wbqp-tests --bench qp_medians --target-dir "$2"
    cp "$(find "$2/release/deps" -name 'qp_medians-*' -executable -printf '%T@ %p\n' \
        | sort -n | tail -1 | cut -d' ' -f2)" "$work/solves_$1"
}
build portable target
# A folder of its own, so that neither build throws the other away.
RUSTFLAGS="-C target-cpu=native" build native "${NATIVE_TARGET:-$work/target}"
rm -rf "$work/target"

# Keeps the least of several runs: what else the machine does makes some of them half as long again.
p50='import json, sys; print(json.load(open(sys.argv[1]))["tick"]["p50"])'
stats() { # name build arguments…
    local name=$1 build=$2
    shift 2
    echo "$name, $build" >&2
    local new="$work/new.json" kept="$work/$name.$build.json"
    "$work/$build" --build "$build" --json "$@" >"$new"
    if [ ! -e "$kept" ] || "$python" -c 'import sys; sys.exit(not float(sys.argv[1]) < float(sys.argv[2]))' \
        "$("$python" -c "$p50" "$new")" "$("$python" -c "$p50" "$kept")"; then
        mv "$new" "$kept"
    fi
}

# Builds side by side, and rounds apart in time: what disturbs the machine disturbs all alike.
for round in $(seq "${ROUNDS:-3}"); do
    for contact in none normal normal_tilt point full; do
        for build in portable native; do
            stats "othex_$contact" "$build" --robot othex --contact "$contact" --ticks "$ticks"
        done
    done
    for robot in quadruped humanoid; do
        for build in portable native; do
            stats "$robot" "$build" --robot "$robot" --ticks "$ticks"
        done
    done
    for formulation in ${FORMULATIONS:-condensed torque_eliminated explicit}; do
        for robot in othex quadruped humanoid; do
            stats "${robot}_$formulation" portable --robot "$robot" --ticks 20000 --formulation "$formulation"
        done
    done
    for robot in othex quadruped humanoid; do
        stats "${robot}_clarabel" portable --robot "$robot" --ticks 1000 --solver clarabel
    done
    for build in portable native; do
        "$work/solves_$build" >"$work/solves.$build.$round.txt"
    done
done
for robot in othex quadruped humanoid; do
    "$work/portable" --robot "$robot" --dump-problems "$work/$robot.problems"
done
"$python" tests/peers/compare.py --wbqp "$work/portable" --json "$work/peers.json" \
    "$work"/{othex,quadruped,humanoid}.problems >/dev/null

"$python" tests/peers/performance.py "$work" docs/performance.md
