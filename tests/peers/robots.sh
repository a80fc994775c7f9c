#!/usr/bin/env bash
# Compares wbqp with TSID and PlaCo on the same robots (robots.py), and writes the tables in docs/performance.md.
# Installs and builds all that is needed on a Debian machine with Rust and Python, below target/; not a part of CI,
# since TSID has to be compiled. From the workspace's root:
#
#     bash tests/peers/robots.sh
#
# As root it installs Debian's packages itself; otherwise it says which are missing. ROUNDS=5 is how often each tick is
# timed.
set -euo pipefail
cd "$(dirname "$0")/../.."

work=${WORK:-target/peers-robots}
python=${PYTHON:-python3}
mkdir -p "$work"

packages=(g++ libeigen3-dev libboost-dev liburdfdom-headers-dev liburdfdom-dev libtinyxml2-dev libconsole-bridge-dev)
missing=()
for package in "${packages[@]}"; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q '^install ok installed' || missing+=("$package")
done
if [ ${#missing[@]} -gt 0 ]; then
    if [ "$(id -u)" != 0 ]; then
        echo "missing: sudo apt-get install ${missing[*]}" >&2
        exit 1
    fi
    apt-get update -qq
    apt-get install -y -qq --no-install-recommends "${missing[@]}"
fi

# Two environments: PlaCo's Pinocchio is another than TSID's. TSID is compiled here, without its own tests.
environment() { # name requirements
    if ! cmp -s "$2" "$work/$1/requirements.txt"; then
        "$python" -m venv --clear "$work/$1"
        "$work/$1/bin/pip" install -q -r "$2"
        [ "$1" != tsid ] || build_tsid
        cp "$2" "$work/$1/requirements.txt"
    fi
}
build_tsid() {
    local prefix
    prefix=$("$work/tsid/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib") + "/cmeel.prefix")')
    CMAKE_PREFIX_PATH=$prefix CMEEL_CMAKE_ARGS=-DBUILD_TESTING=OFF CMEEL_JOBS=$(nproc) \
        "$work/tsid/bin/pip" install -q --no-deps libtsid==1.10.0
}
environment tsid tests/peers/requirements_tsid.txt
environment placo tests/peers/requirements_placo.txt

prefix=$("$work/tsid/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib") + "/cmeel.prefix")')
"$work/tsid/bin/cmake" -S tests/peers -B "$work/build" -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_PREFIX_PATH="$prefix" >"$work/cmake.log"
"$work/tsid/bin/cmake" --build "$work/build" >>"$work/cmake.log" || { cat "$work/cmake.log" >&2; exit 1; }

cargo build --release --locked -p wbqp-tests --bin wbqp_peer

"$work/tsid/bin/python" tests/peers/robots.py --work "$work" --rounds "${ROUNDS:-5}" \
    --wbqp target/release/wbqp_peer --tsid "$work/build/tsid_peer" --placo "$work/placo/bin/python" \
    --json "$work/robots.json" --page docs/performance.md "$@"
