#!/usr/bin/env bash
# Measures everything that docs/performance.md shows, and writes its tables. On two idle cores about fifteen minutes, most
# of it the second build. From the workspace's root:
#
#     python3 -m venv /tmp/peers && /tmp/peers/bin/pip install -r tests/peers/requirements.txt
#     PYTHON=/tmp/peers/bin/python bash tests/peers/measure.sh
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
    cp "$(find "$2/release/deps" -name 'qp_medians-*' -executable -printf '%T@ %p\n' | sort -n | tail -1 | cut -d' ' -f2)" \
        "$work/solves_$1"
}
build portable target
# A folder of its own, so that neither build throws the other away.
RUSTFLAGS="-C target-cpu=native" build native "${NATIVE_TARGET:-$work/target}"
rm -rf "$work/target"

stats() { # name build arguments…
    local name=$1 build=$2
    shift 2
    echo "$name, $build" >&2
    "$work/$build" --build "$build" --json "$@" >"$work/$name.$build.json"
}

for build in portable native; do
    "$work/solves_$build" >"$work/solves.$build.txt"
done
# Builds side by side in time: what disturbs the machine disturbs both.
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
    stats "${robot}_clarabel" portable --robot "$robot" --ticks 2000 --solver clarabel
    "$work/portable" --robot "$robot" --dump-problems "$work/$robot.problems"
done
"$python" tests/peers/compare.py --wbqp "$work/portable" --json "$work/peers.json" \
    "$work"/{othex,quadruped,humanoid}.problems >/dev/null

"$python" tests/peers/performance.py "$work" docs/performance.md
