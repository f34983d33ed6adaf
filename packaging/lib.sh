# For the scripts of this directory: where things are, and how a platform is compiled for. Sourced, not run. Gives a
# script without arguments those of all platforms, and the list of their targets, `all`.
#
# A platform has FMI's name. Needed are python3 >= 3.11 with venv (zig's linker and cargo-zigbuild come from PyPI),
# for commands Node.js >= 18 with npm (the lab's page), and one of
# - rustup, which has the targets or can get them (and mingw-w64 for win64);
# - Debian's packages in `debian_packages` (for wasm32 alone in `debian_packages_wasm`): the standard library is then built
#   from its source.
# PACKAGING_WITH=rustup or PACKAGING_WITH=debian decides which. The target directory is not the one of other builds.
# shellcheck shell=bash disable=SC2034
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
dist=${DIST:-$root/dist}
directory=${PACKAGING_TARGET_DIR:-$root/target/packaging}
version=$(sed -n '/^\[workspace.package\]/,/^$/s/^version = "\(.*\)"/\1/p' Cargo.toml)
# What has a time has that of the commit.
[[ -n ${SOURCE_DATE_EPOCH:-} ]] || SOURCE_DATE_EPOCH=$(git log -1 --format=%ct 2>/dev/null) || SOURCE_DATE_EPOCH=
export SOURCE_DATE_EPOCH
export LC_ALL=C.UTF-8 TZ=UTC CARGO_INCREMENTAL=0

# darwin64 (libraries only) is built when it is named: nobody has tried it yet, and no Mac was there to load the result.
platforms=(linux64 aarch64-linux win64)
debian_packages=(rustc-web cargo-web rust-web-src gcc-mingw-w64-x86-64 lld-19)
debian_packages_wasm=(rustc-web cargo-web rust-web-src lld-19)
# The lab's page, which commands hold.
page=wasm32-unknown-unknown
# The oldest glibc that is served: that of manylinux_2_17.
glibc=2.17

fail() {
    printf '%s: %s\n' "$(basename -- "$0")" "$*" >&2
    exit 1
}

note() {
    printf '== %s\n' "$*" >&2
}

# The targets of a platform; darwin64 holds two processors.
targets() {
    case $1 in
        linux64) echo x86_64-unknown-linux-gnu ;;
        aarch64-linux) echo aarch64-unknown-linux-gnu ;;
        win64) echo x86_64-pc-windows-gnu ;;
        darwin64) echo x86_64-apple-darwin aarch64-apple-darwin ;;
        *) fail "$1: no such platform; there are ${platforms[*]} darwin64" ;;
    esac
}

# The libraries of the crowd, the decision and the summary, as they are called there.
libraries() {
    case $1 in
        win64) echo crowd_mechanics.dll lemons_decision_fmu.dll lemons_summary_fmu.dll ;;
        darwin64) echo libcrowd_mechanics.dylib liblemons_decision_fmu.dylib liblemons_summary_fmu.dylib ;;
        *) echo libcrowd_mechanics.so liblemons_decision_fmu.so liblemons_summary_fmu.so ;;
    esac
}

# The command's name there; none for a Mac, whose frameworks it would be linked with.
program() {
    case $1 in
        win64) echo lemons.exe ;;
        darwin64) ;;
        *) echo lemons ;;
    esac
}

# The extension of the Python package, as cargo calls it there; none where there is no command.
extension() {
    case $1 in
        win64) echo lemons_native.dll ;;
        darwin64) ;;
        *) echo liblemons_native.so ;;
    esac
}

# The same, as Python wants it.
module() {
    case $1 in
        win64) echo _native.pyd ;;
        darwin64) ;;
        *) echo _native.abi3.so ;;
    esac
}

# A Python with zig and cargo-zigbuild, and what else is asked for in tools.txt.
tools() {
    local stamp=$directory/tools/stamp wanted
    wanted=$(sha256sum packaging/tools.txt)
    [[ -f $stamp && $(<"$stamp") == "$wanted" ]] && return
    rm -rf "$directory/tools"
    mkdir -p "$directory"
    "${PYTHON:-python3}" -m venv "$directory/tools"
    "$directory/tools/bin/python" -m pip install --quiet --disable-pip-version-check --only-binary :all: \
        --require-hashes -r packaging/tools.txt
    printf '%s\n' "$wanted" >"$stamp"
}

# `have_rustup TARGET…`
have_rustup() {
    command -v rustup >/dev/null || return
    local target installed
    installed=$(rustup target list --installed)
    for target; do
        # A mirror may have no targets and not say so.
        grep -qx "$target" <<<"$installed" || timeout 120 rustup target add "$target" >&2 || return
    done
}

have_debian() {
    [[ -x /usr/bin/rustc && -x /usr/bin/cargo && -d $(debian_source) ]] &&
        { [[ $* != *wasm32* ]] || command -v wasm-ld-19 >/dev/null; }
}

# Where the source of Debian's standard library is.
debian_source() {
    echo "/usr/src/rustc-$(/usr/bin/rustc -vV | sed -n 's/^release: //p')"
}

# One compiler for all targets that are named: sets `with`.
choose_compiler() {
    local needed=("${debian_packages[@]}")
    [[ $* != wasm32* ]] || needed=("${debian_packages_wasm[@]}")
    case ${PACKAGING_WITH:-any} in
        rustup | any) if have_rustup "$@"; then with=rustup; fi ;;&
        debian | any) if [[ -z ${with:-} ]] && have_debian "$@"; then with=debian; fi ;;
    esac
    [[ -n ${with:-} ]] ||
        fail "neither does rustup have $*, nor are ${needed[*]} installed (Debian)"
    export PACKAGING_WITH=$with
    if [[ $with == debian ]]; then
        # Not those of rustup, whatever is first on the PATH.
        export RUSTC=/usr/bin/rustc CARGO=/usr/bin/cargo RUSTC_BOOTSTRAP=1
        unset RUSTUP_TOOLCHAIN
    else
        CARGO=$(rustup which cargo)
        RUSTC=$(rustup which rustc)
        export CARGO RUSTC
    fi
}

# No place of this machine gets into a binary: sets `flags`, for a target directory.
without_places() {
    local home=${CARGO_HOME:-${HOME:-/root}/.cargo}
    flags=(--remap-path-prefix="$1"=target --remap-path-prefix="$root"=lemons --remap-path-prefix="$home"=cargo)
    if [[ $with == debian ]]; then flags+=(--remap-path-prefix="$(debian_source)"=rust); fi
}

# Builds for a target: `compile TARGET ARGUMENTS…`, with cargo's arguments.
compile() {
    local target=$1 cargo=("$CARGO") flags places home=${CARGO_HOME:-${HOME:-/root}/.cargo}
    shift
    without_places "$directory"
    # Quoted, because directories may have spaces; the crate cc reads them so with CC_SHELL_ESCAPED_FLAGS.
    places=("-ffile-prefix-map=$root=lemons" "-ffile-prefix-map=$home=cargo")
    # zig's linker strips and signs; what rustc would start afterwards may be missing, and would break the signature. The
    # name of a library in itself would be where it was made; FMUs are loaded by their paths.
    [[ $target != *-apple-darwin ]] ||
        flags+=(-Cstrip=none -Clink-arg=-Wl,-S -Clink-arg=-Wl,-x -Clink-arg=-Wl,-install_name,@rpath/lemons.dylib)
    local arguments=(build --locked --profile dist --target-dir "$directory" "$@")
    if [[ $with == debian && $target != x86_64-unknown-linux-gnu ]]; then
        arguments+=(-Zbuild-std=std,panic_unwind)
    fi
    case $target in
        *-windows-gnu) export CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER=x86_64-w64-mingw32-gcc ;;
        *) cargo=("$directory/tools/bin/cargo-zigbuild") arguments[0]=zigbuild ;;
    esac
    [[ $target == *-linux-gnu ]] && target=$target.$glibc
    # The separator of arguments that may contain spaces.
    CARGO_ENCODED_RUSTFLAGS=$(IFS=$'\x1f' && printf %s "${flags[*]}") CFLAGS=${places[*]@Q} CC_SHELL_ESCAPED_FLAGS=1 \
        PATH=$directory/tools/bin:$PATH nice "${cargo[@]}" "${arguments[@]}" --target "$target"
}

# Builds for a page: `compile_wasm ARGUMENTS…`, with cargo's arguments.
compile_wasm() {
    local target=wasm32-unknown-unknown flags
    local arguments=(build --locked --target "$target" --lib "$@")
    choose_compiler "$target"
    without_places "${CARGO_TARGET_DIR:-$root/target}/wasm"
    if [[ $with == debian ]]; then
        export CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER=wasm-ld-19
        arguments+=(-Zbuild-std=std,panic_abort)
    fi
    CARGO_ENCODED_RUSTFLAGS=$(IFS=$'\x1f' && printf %s "${flags[*]}") "$CARGO" "${arguments[@]}"
}

# For those who make files of a release, which have the time of the commit.
need_time() {
    [[ $SOURCE_DATE_EPOCH =~ ^[0-9]+$ ]] || fail "git tells no time of the commit: set SOURCE_DATE_EPOCH"
}

(($#)) || set -- "${platforms[@]}"
all=()
for platform; do
    list=$(targets "$platform")
    read -ra of_platform <<<"$list"
    all+=("${of_platform[@]}")
done
