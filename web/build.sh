#!/usr/bin/env bash
# Builds the WebAssembly module of the page into web/page/pkg, from which Vite takes it.
# Ends with 3 where there is no toolchain for it and none can be had.
set -euo pipefail
cd "$(dirname "$0")/.."

# JavaScript around the module: the tool must be of the library's version. Its own lock file may name packages that a
# mirror does not have yet. Before the toolchain, which sets how cargo compiles.
version=$(sed -n '/^name = "wasm-bindgen"$/{n;s/version = "\(.*\)"/\1/p}' Cargo.lock)
bindgen=target/tools/bin/wasm-bindgen
if ! test -x $bindgen || test "$($bindgen --version)" != "wasm-bindgen $version"; then
    # It runs for seconds: fully optimised it would take minutes longer to compile.
    install=(env CARGO_INCREMENTAL=0 CARGO_PROFILE_RELEASE_OPT_LEVEL=1 CARGO_PROFILE_RELEASE_DEBUG=false
        cargo install wasm-bindgen-cli --version "$version" --bin wasm-bindgen
        --root target/tools --target-dir target/tools-build)
    "${install[@]}" --locked || "${install[@]}" || {
        echo "web: \`${install[*]}\` does not work here" >&2
        exit 3
    }
    rm -rf target/tools-build
fi

. web/toolchain.sh
"${cargo[@]}" rustc -p wbqp-web --lib --crate-type cdylib "${options[@]}"
# Names of functions are a tenth of its size, and nobody reads them.
$bindgen --remove-name-section --remove-producers-section --target web --out-dir web/page/pkg --out-name wbqp \
    "$folder/$target/release/wbqp_web.wasm"
ls -l web/page/pkg/wbqp_bg.wasm
