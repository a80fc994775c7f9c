#!/usr/bin/env bash
# Builds the WebAssembly module of the page into web/page/pkg, from which Vite takes it.
# The toolchain is rustup's where it offers the target; else Debian's, which compiles the standard library too.
# Ends with 3 where neither can be had.
set -euo pipefail
cd "$(dirname "$0")/.."

target=wasm32-unknown-unknown
debian=(rustc-web cargo-web rust-web-src)
# What runs a thousand times a second: optimised for speed, and as a whole.
export CARGO_INCREMENTAL=0 CARGO_PROFILE_RELEASE_LTO=fat CARGO_PROFILE_RELEASE_CODEGEN_UNITS=1 \
    CARGO_PROFILE_RELEASE_PANIC=abort CARGO_PROFILE_RELEASE_DEBUG=false CARGO_PROFILE_RELEASE_STRIP=debuginfo

refuse() {
    printf 'web: %s\n' "${@:2}" >&2
    exit "$1"
}

# JavaScript around the module: the tool must be of the library's version. Its own lock file may name packages that a
# mirror does not have yet.
version=$(sed -n '/^name = "wasm-bindgen"$/{n;s/version = "\(.*\)"/\1/p}' Cargo.lock)
bindgen=target/tools/bin/wasm-bindgen
if ! test -x $bindgen || test "$($bindgen --version)" != "wasm-bindgen $version"; then
    # It runs for seconds: fully optimised it would take minutes longer to compile.
    install=(env CARGO_PROFILE_RELEASE_OPT_LEVEL=1 CARGO_PROFILE_RELEASE_LTO=off CARGO_PROFILE_RELEASE_CODEGEN_UNITS=16
        cargo install wasm-bindgen-cli --version "$version" --root target/tools --target-dir target/tools-build)
    "${install[@]}" --locked || "${install[@]}" || refuse 3 "\`${install[*]}\` does not work here"
    rm -rf target/tools-build
fi

if test -d "$(rustc --print sysroot)/lib/rustlib/$target/lib" || timeout 120 rustup target add "$target"; then
    cargo=(cargo)
    folder=target/web
    options=()
else
    echo "web: rustup offers no $target here; Debian's compiler builds it, and its standard library"
    if ! test -x /usr/bin/rustc || ! test -x /usr/bin/cargo || ! test -d /usr/lib/rustlib/src/rust/library; then
        install="apt-get update && apt-get install --no-install-recommends ${debian[*]}"
        test "$(id -u)" = 0 || refuse 3 "Debian's compiler is not installed; as root: \`$install\`"
        apt-get update --quiet=2 && apt-get install --yes --quiet=2 --no-install-recommends "${debian[@]}" ||
            refuse 3 "no toolchain: neither \`rustup target add $target\` nor \`$install\` works here"
    fi
    # The linker: rustup's, which any target's toolchain has, or Debian's.
    linker=$(dirname "$(find "$(rustc --print sysroot)/lib/rustlib" -name rust-lld -type f -print -quit)")
    PATH="$linker:$PATH"
    command -v rust-lld >/dev/null || export CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER=wasm-ld-22
    # Compiling the standard library is an unstable option. Neither of the two compilers sees what the other one keeps.
    export RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 CARGO_HOME="$PWD/target/wasm-debian/home"
    cargo=(/usr/bin/cargo)
    folder=target/web-debian
    options=(-Zbuild-std=std,panic_abort)
fi
# Vector instructions, which browsers have since 2023 at the latest.
export CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS="${WBQP_WEB_RUSTFLAGS--C target-feature=+simd128}"
"${cargo[@]}" rustc --locked --release --no-default-features -p wbqp-web --lib --crate-type cdylib \
    --target "$target" --target-dir "$folder" "${options[@]}"
# Names of functions are a tenth of its size, and nobody reads them.
$bindgen --remove-name-section --remove-producers-section --target web --out-dir web/page/pkg --out-name wbqp \
    "$folder/$target/release/wbqp_web.wasm"
ls -l web/page/pkg/wbqp_bg.wasm
