#!/usr/bin/env bash
# Makes the crowd as a WebAssembly component of FMI-LS-WASM (a draft): component/build.sh FILE [TRIAL]
# Without a Trial, the importer reads the one that an FMU has packed; with one, it is built in, and the importer need
# read nothing. `lemons pack --fmi 3 --binary wasm32-wasip2=FILE` makes an FMU of it. Needs a compiler for wasm32, as
# packaging/lib.sh says; rustc >= 1.89.
usage="usage: component/build.sh FILE [TRIAL]"
file=$(realpath -m -- "${1:?$usage}") TRIAL=${2:+$(realpath -- "$2")}
export TRIAL
set --
source "$(dirname "${BASH_SOURCE[0]}")/../packaging/lib.sh"

target_directory=${CARGO_TARGET_DIR:-$root/target}/component
own=(--manifest-path component/Cargo.toml --target-dir "$target_directory")
compile_wasm "${own[@]}" --profile dist
# The compiler of this machine, whatever `compile_wasm` has chosen.
env -u RUSTC -u RUSTC_BOOTSTRAP cargo run --quiet --locked "${own[@]}" -p encode-component -- \
    "$target_directory/wasm32-unknown-unknown/dist/lemons_component.wasm" "$file"
printf 'component/build.sh: %s, %s bytes\n' "$file" "$(wc -c <"$file")"
