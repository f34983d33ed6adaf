#!/usr/bin/env bash
# Builds for wasm32-unknown-unknown what can run in a browser, and looks at what the linked engine imports. No part of
# check.sh, because the target is not there everywhere. Needs python3, and one of
# - rustup, which has the target or can get it: rustup target add wasm32-unknown-unknown
# - Debian's packages rustc-web, cargo-web, rust-web-src and lld-19; the standard library is built from its source.
# WASM_WITH=rustup or WASM_WITH=debian decides which. The target directory is not the one of other builds.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

target=wasm32-unknown-unknown
directory=${CARGO_TARGET_DIR:-target/wasm}
packages=(lemons-plane lemons-files lemons-xml lemons-trial crowd-mechanics lemons-people lemons-picture lemons-record
    lemons-ssp lemons-decision)

fail() {
    printf 'wasm-check.sh: %s\n' "$*" >&2
    exit 1
}

by_rustup() {
    command -v rustup >/dev/null || return
    rustup target list --installed | grep -qx "$target" || rustup target add "$target"
}

by_debian() {
    [[ -x /usr/bin/rustc && -x /usr/bin/cargo && -d /usr/src/rustc-$(/usr/bin/rustc -vV | sed -n 's/^release: //p') ]] &&
        command -v wasm-ld-19 >/dev/null
}

build() {
    # Without default features: SQLite and zstd are C.
    "$@" build --locked --target "$target" --target-dir "$directory" --lib --no-default-features \
        "${packages[@]/#/-p}"
}

case ${WASM_WITH:-any} in
    rustup | any) if by_rustup; then with=rustup; fi ;;&
    debian | any) if [[ -z ${with:-} ]] && by_debian; then with=debian; fi ;;
esac
case ${with:-} in
    rustup) build cargo ;;
    debian)
        # Not those of rustup, whatever is first on the PATH. The standard library is one of Debian's version.
        export RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER=wasm-ld-19
        build env -u RUSTUP_TOOLCHAIN /usr/bin/cargo -Zbuild-std=std,panic_abort
        ;;
    *) fail "neither does rustup have $target, nor are rustc-web, cargo-web, rust-web-src and lld-19 installed (Debian)" ;;
esac

# What the linked engine imports, whose C functions an importer calls. Only what wasm-bindgen leaves is known: zip asks
# for random bytes through getrandom, which has it as a dependency. Nothing calls these functions; a page gives them as
# empty ones. The import section has the number 2; a length is an LEB128.
python3 - "$directory/$target/debug/crowd_mechanics.wasm" <<'END'
import sys

data = open(sys.argv[1], "rb").read()
place = 8


def number():
    global place
    value = shift = 0
    while True:
        byte = data[place]
        place += 1
        value |= (byte & 0x7F) << shift
        shift += 7
        if byte < 0x80:
            return value


def name():
    global place
    size = number()
    place += size
    return data[place - size:place].decode()


while place < len(data):
    kind = data[place]
    place += 1
    size = number()
    end = place + size
    if kind == 2:
        for _ in range(number()):
            module, function = name(), name()
            if data[place] != 0 or not module.startswith("__wbindgen_"):
                sys.exit(f"wasm-check.sh: {sys.argv[1]} imports {module} {function}")
            place += 1
            number()
    place = end
END
printf 'wasm-check.sh: %s build for %s\n' "${packages[*]}" "$target"
