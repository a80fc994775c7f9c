#!/usr/bin/env bash
# Compares wbqp's solver with DAQP's C workspace interface and eiquadprog's fast solver on ticks with active limits
# (qp.py), and writes the tables in docs/performance.md. Needs a C and a C++ compiler; what else it needs it installs
# below target/. From the workspace's root:
#
#     bash tests/peers/qp.sh
#
# Half a minute once everything is built. PASSES=4 is how often each problem is solved by each.
set -euo pipefail
cd "$(dirname "$0")/../.."

work=${WORK:-target/peers-qp}
python=${PYTHON:-python3}
daqp=0.11.0
mkdir -p "$work"

if ! cmp -s tests/peers/requirements_qp.txt "$work/venv/requirements.txt"; then
    "$python" -m venv --clear "$work/venv"
    "$work/venv/bin/pip" install -q --no-deps -r tests/peers/requirements_qp.txt
    cp tests/peers/requirements_qp.txt "$work/venv/requirements.txt"
fi
prefix=$("$work/venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib") + "/cmeel.prefix")')
sources="$work/daqp-$daqp/csrc"
if [ ! -d "$sources" ]; then
    "$work/venv/bin/pip" download -q --no-deps --no-binary :all: -d "$work" "daqp==$daqp"
    tar xzf "$work/daqp-$daqp.tar.gz" -C "$work"
fi

# Portable, like wbqp: no -march. DAQP twice: the second time with what its package adds.
build() { # program flags…
    local program=$1 objects
    shift
    objects=$(mktemp -d)
    for source in "$sources"/src/*.c; do
        "${CC:-cc}" -O3 "$@" -I"$sources/include" -c "$source" -o "$objects/$(basename "$source" .c).o"
    done
    "${CXX:-c++}" -std=c++17 -O3 -DNDEBUG -I"$sources/include" -I"$prefix/include" -I"$prefix/include/eigen3" \
        tests/peers/qp_peer.cpp "$objects"/*.o -L"$prefix/lib" -leiquadprog -Wl,-rpath,"$(realpath "$prefix/lib")" \
        -o "$work/$program"
    rm -r "$objects"
}
build qp_peer
build qp_peer_own -fassociative-math -fno-signed-zeros -fno-trapping-math

cargo build --release --locked -p wbqp-tests --bin wbqp_qp --bin qp_ticks
target/release/qp_ticks "$work"
files=()
for name in drifting_12 drifting_30 drifting_60 aerial_12 quadruped_30 aerial_12_swelling humanoid_60_swelling \
    push_away quadruped_slip humanoid_slip; do
    files+=("$work/$name.ticks")
done
"$work/venv/bin/python" tests/peers/qp.py --wbqp target/release/wbqp_qp \
    --peer "$work/qp_peer" --own "$work/qp_peer_own" --passes "${PASSES:-4}" \
    --json "$work/qp.json" --page docs/performance.md "${files[@]}"
