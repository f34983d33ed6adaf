#!/usr/bin/env bash
# Fuzzes each target for FUZZ_SECONDS (60), from the committed inputs, and keeps what covers more:
#   fuzz/run.sh [TARGET…]     crashers go to fuzz/artifacts/TARGET
#   fuzz/run.sh --asan        runs the tests of the C boundary under AddressSanitizer and LeakSanitizer instead
# Needs cargo-fuzz and a C++ compiler. The stable toolchain suffices: RUSTC_BOOTSTRAP lets it take -Z flags.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

export RUSTC_BOOTSTRAP=1
host=$(rustc -vV | sed -n 's/^host: //p')

if [[ ${1:-} == --asan ]]; then
    # Tests load the library, which finds the sanitizer in the test's executable: hence -rdynamic.
    export RUSTFLAGS="-Zsanitizer=address -Clink-arg=-rdynamic"
    export ASAN_OPTIONS=detect_leaks=1:detect_stack_use_after_return=1:${ASAN_OPTIONS:-}
    # The sanitizer keeps freed memory for a while, and never forgets a library: the resident set says nothing.
    exec cargo test --locked --target "$host" --target-dir "${CARGO_TARGET_DIR:-target}/asan" -p lemons-crowd --test fmi -- \
        --skip leave_nothing_behind --skip loaded_and_unloaded_without_end
fi

seconds=${FUZZ_SECONDS:-60}
# Of each target's inputs so many are kept: the longest below this size.
files=12 bytes=2000
# Temporary directories of fuzzers that crash stay behind.
# In memory, where there is such a place: each execution writes some files.
[[ -w /dev/shm ]] && export TMPDIR=/dev/shm
TMPDIR=$(mktemp -d)
export TMPDIR
# Beside the fuzzers: cargo-fuzz renames the directory.
mkdir -p fuzz/target
all=$(mktemp -d fuzz/target/corpora.XXXXXX)
trap 'rm -rf "$TMPDIR" "$all"' EXIT

cargo fuzz build --fuzz-dir fuzz
targets=("$@")
((${#targets[@]})) || mapfile -t targets < <(cargo fuzz list --fuzz-dir fuzz)
failed=()
for target in "${targets[@]}"; do
    printf '\n== %s, %s s\n' "$target" "$seconds"
    committed=fuzz/corpus/$target
    grown=$all/$target
    mkdir -p "$committed" "$grown"
    options=(-max_total_time="$seconds" -max_len=8192 -timeout=20 -rss_limit_mb=4096 -print_final_stats=1)
    if [[ -f fuzz/dictionaries/$target ]]; then
        options+=(-dict="fuzz/dictionaries/$target")
    fi
    touch "$all/begin"
    # The first directory takes what is new. What takes ten seconds goes to the crashers, but ends nothing.
    if ! cargo fuzz run --fuzz-dir fuzz "$target" "$grown" "$committed" -- "${options[@]}" ||
        [[ -n $(find "fuzz/artifacts/$target" -type f -newer "$all/begin" 2>/dev/null) ]]; then
        failed+=("$target")
    fi
    cp -n "$committed"/* "$grown" 2>/dev/null || true
    cargo fuzz cmin --fuzz-dir fuzz "$target" "$grown" -- -max_len=8192 -timeout=20 || failed+=("$target")
    # Inputs with a name are seeds and past crashers: they stay.
    find "$committed" -type f -regextype posix-extended -regex '.*/[0-9a-f]{40}' -delete
    # What was kept is named by its content: a seed need not stand there twice.
    find "$committed" -type f -exec sha1sum {} + | cut -c1-40 | while read -r same; do rm -f "$grown/$same"; done
    find "$grown" -type f -size -"${bytes}"c -printf '%s %f\n' | sort -k1,1nr -k2 | sed -n "1,${files}p" |
        while read -r _ file; do cp -n "$grown/$file" "$committed"; done
done
if ((${#failed[@]})); then
    printf 'fuzz/run.sh: crashes, or inputs that take ten seconds, in: %s; the inputs are in fuzz/artifacts\n' "${failed[*]}" >&2
    exit 1
fi
