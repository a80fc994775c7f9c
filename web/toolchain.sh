# Sourced by what compiles for browsers, in the workspace's folder: sets `target`, the command `cargo` with `options`
# and `folder`, where it builds, and what all of it is compiled with, so that nothing is compiled twice.
# The toolchain is rustup's where it offers the target; else Debian's, which compiles the standard library too.
# Ends with 3 where neither can be had.

target=wasm32-unknown-unknown
debian=(rustc-web cargo-web rust-web-src)
# What runs a thousand times a second: optimised for speed, and as a whole.
export CARGO_INCREMENTAL=0 CARGO_PROFILE_RELEASE_LTO=fat CARGO_PROFILE_RELEASE_CODEGEN_UNITS=1 \
    CARGO_PROFILE_RELEASE_PANIC=abort CARGO_PROFILE_RELEASE_DEBUG=false CARGO_PROFILE_RELEASE_STRIP=debuginfo
# Vector instructions, which browsers have since 2023 at the latest.
export CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS="${WBQP_WEB_RUSTFLAGS--C target-feature=+simd128}"

refuse() {
    printf 'wasm: %s\n' "${@:2}" >&2
    exit "$1"
}

# A target that is installed is not asked for again: that would need the network.
if test -d "$(rustc --print sysroot)/lib/rustlib/$target/lib" || timeout 120 rustup target add "$target"; then
    cargo=(cargo)
    folder=target/web
    options=()
else
    echo "wasm: rustup offers no $target here; Debian's compiler builds it, and its standard library"
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
options+=(--locked --release --no-default-features --target "$target" --target-dir "$folder")
"${cargo[@]}" --version
