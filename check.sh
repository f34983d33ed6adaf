#!/usr/bin/env bash
# What must hold before a change is done. `./check.sh` is the short tier, `./check.sh all` what CI runs. With names of
# stages only those, as they are in the tier: `./check.sh clippy test`, `./check.sh all pytest`.
# Needs cargo, a C compiler and python3 >= 3.10 with venv. PYTHON names another Python.
# Programs and libraries are built once, with the profile `ci` of Cargo.toml: the stages test, pytest and lab use what
# the stage build has built.
set -euo pipefail
# Numbers with a decimal point.
export LC_ALL=C.UTF-8

# Relative to where this is started, like cargo does it.
if [[ -n ${CARGO_TARGET_DIR:-} ]]; then
    CARGO_TARGET_DIR=$(realpath -m -- "$CARGO_TARGET_DIR")
    export CARGO_TARGET_DIR
fi
cd "$(dirname "${BASH_SOURCE[0]}")"
python=${PYTHON:-python3}
# For tests/fmpy, tests/lab and lab/build.sh: the directory below target/ that holds what is tested.
export LEMONS_PROFILE=ci

stage() {
    printf '\n== %s\n' "$*"
    "$@"
}

fail() {
    printf 'check.sh: %s\n' "$*" >&2
    exit 1
}

# .venv as tests/fmpy/requirements*.txt say; made anew when these files or the Python change.
python_environment() {
    local requirements=tests/fmpy/requirements.txt alone=tests/fmpy/requirements-alone.txt
    local stamp=.venv/requirements.stamp wanted pip
    command -v "$python" >/dev/null || fail "$python is missing: Python 3.10 or newer is needed"
    "$python" -c 'import sys; sys.exit(sys.version_info < (3, 10))' ||
        fail "Python 3.10 or newer is needed, $python is $("$python" --version)"
    "$python" -c 'import ensurepip, venv' 2>/dev/null ||
        fail "$python cannot make virtual environments: install python3-venv (Debian, Ubuntu)"
    wanted="$("$python" --version) $(sha256sum "$requirements" "$alone")"
    if [[ -f $stamp && $(<"$stamp") == "$wanted" ]] && .venv/bin/python -c '' 2>/dev/null; then
        return
    fi
    rm -rf .venv
    "$python" -m venv .venv
    pip=(.venv/bin/python -m pip install --quiet --disable-pip-version-check --only-binary :all:)
    "${pip[@]}" -r "$requirements"
    "${pip[@]}" --no-deps -r "$alone"
    printf '%s\n' "$wanted" >"$stamp"
}

# The extension of the Python package, beside its sources.
extension() {
    cp "${CARGO_TARGET_DIR:-target}/$LEMONS_PROFILE/liblemons_native.so" python/src/lemons_fmu/_native.abi3.so
}

# Tests send signals. What a shell starts in the background ignores some of them, and its children do.
signals=()
env --default-signal true 2>/dev/null && signals=(env --default-signal)

# In `all` the tests of Python that are marked `long`, too.
python_tests() {
    local marked=(-m "not long")
    [[ $tier == all ]] && marked=()
    stage python_environment
    stage extension
    # Two processes; the tests of a file share what they build.
    stage "${signals[@]}" .venv/bin/python -m pytest "$1" -q -rs -n 2 --dist loadfile "${marked[@]}"
}

# One command line for all that cargo builds and tests, so that each crate is built once: others would choose other
# features of what they share.
whole=(--locked --profile ci --workspace --all-features)

rust_tests() {
    # Not by nextest: the tests of a program share what they pack.
    stage "${signals[@]}" cargo test "${whole[@]}" --no-fail-fast
    # Its table, optimised.
    stage "${CARGO_TARGET_DIR:-target}/ci/lemons" verify
}

# The page needs what is not everywhere: what is missing.
missing_for_lab() {
    local missing=()
    command -v npm >/dev/null || missing+=("Node.js with npm")
    command -v chromium >/dev/null || missing+=(chromium)
    python3 -c "import tomllib" 2>/dev/null || missing+=("python3 >= 3.11")
    (source packaging/lib.sh && choose_compiler wasm32-unknown-unknown) >/dev/null 2>&1 ||
        missing+=("a compiler for wasm32 (packaging/lib.sh)")
    (IFS=, && printf %s "${missing[*]}")
}

# All that is tested. Nothing is built later: the stages that follow run at the same time.
build() {
    if [[ -z $(missing_for_lab) ]]; then
        # The page holds the engine's library, and the command holds the page. One test, for features that only tests
        # ask for: without it, what they share would be built twice.
        stage cargo build "${whole[@]}" --lib --test memory
        stage lab/build.sh
    fi
    # Not --all-targets, which builds tests of libraries that have none.
    stage cargo test "${whole[@]}" --no-run
}

lab() {
    local missing
    missing=$(missing_for_lab)
    if [[ -n $missing ]]; then
        left_out "The lab: missing $missing."
    else
        python_tests tests/lab
    fi
}

# The instructions of the engine, counted by valgrind: benches/instructions.
instructions() {
    if ! command -v valgrind >/dev/null; then
        left_out "The count of instructions: missing valgrind."
    else
        stage benches/instructions.sh
    fi
}

left_out() {
    printf '\n== Left out. %s\n' "$1"
    printf '%s\n' "$1" >>"$notes/left_out"
}

short=(format clippy build test pytest lab)
long=(format clippy build test doc pytest lab instructions)

run() {
    case $1 in
        format)
            stage cargo fmt --all --check
            stage cargo fmt --manifest-path component/Cargo.toml --all --check
            ;;
        clippy)
            stage cargo clippy "${whole[@]}" --lib --bins --tests --examples -- -D warnings
            if [[ $tier == all ]]; then
                # Without C, as the first command of README.md builds it.
                stage cargo clippy --locked --profile ci -p lemons-cli -- -D warnings
            fi
            ;;
        build) build ;;
        test) rust_tests ;;
        doc) stage env RUSTDOCFLAGS="-D warnings" cargo doc "${whole[@]}" --no-deps ;;
        pytest) python_tests tests/fmpy ;;
        lab) lab ;;
        instructions) instructions ;;
    esac
}

# Microseconds since some time, and those of processor time of this shell's children.
clock() {
    local own children m='^([0-9]+)m([0-9]+)\.([0-9]+)s ([0-9]+)m([0-9]+)\.([0-9]+)s$'
    times >"$notes/times.$BASHPID"
    { read -r own && read -r children; } <"$notes/times.$BASHPID"
    rm -f "$notes/times.$BASHPID"
    [[ $children =~ $m ]]
    wall=${EPOCHREALTIME//[.,]/}
    processor=$(((10#${BASH_REMATCH[1]} + 10#${BASH_REMATCH[4]}) * 60000 + (10#${BASH_REMATCH[2]} + 10#${BASH_REMATCH[5]}) * 1000 +
        10#${BASH_REMATCH[3]} + 10#${BASH_REMATCH[6]}))
}

# Runs a stage, and notes how long it took, also if it fails.
timed() {
    local name=$1 wall processor before
    clock
    before=("$wall" "$processor")
    # -e ends this script when something fails in a stage.
    # shellcheck disable=SC2064
    trap "note $name ${before[*]}" EXIT
    run "$name"
    trap - EXIT
    note "$name" "${before[@]}"
}

note() {
    local wall processor
    clock
    printf '%-14s %8d %10d\n' "$1" $(((wall - $2) / 1000000)) $(((processor - $3) / 1000)) >>"$notes/times"
}

tier=short
if [[ ${1:-} == all ]]; then
    tier=all
    shift
fi
stages=("${short[@]}")
[[ $tier == all ]] && stages=("${long[@]}")
for name; do
    [[ " ${long[*]} " == *" $name "* && $name != *" "* ]] || fail "$name: no such stage; there are ${long[*]}"
done

# Called by another check.sh, which reads the notes.
if [[ -n ${CHECK_NOTES:-} ]]; then
    notes=$CHECK_NOTES
    for name; do
        timed "$name"
    done
    exit
fi
notes=$(mktemp -d)
export CHECK_NOTES=$notes
trap 'rm -rf "$notes"' EXIT

again() {
    if [[ $tier == all ]]; then "$own" all "$@"; else "$own" "$@"; fi
}
own=$PWD/check.sh

failed=0
if (($#)); then
    again "$@" || failed=1
else
    set -- "${stages[@]}"
    # What nobody can do without; then two at a time, because each leaves a processor idle now and then. What the second
    # one prints follows at the end.
    again format clippy build || failed=1
    if ((!failed)); then
        rest=(test)
        [[ $tier == all ]] && rest+=(doc)
        {
            second=0
            again pytest || second=1
            again lab || second=1
            ((!second))
        } >"$notes/second" 2>&1 &
        again "${rest[@]}" || failed=1
        wait $! || failed=1
        cat "$notes/second"
        # Counts depend on no load; what is built for them would wait for others.
        if [[ $tier == all ]]; then again instructions || failed=1; fi
    fi
fi

printf '\n%-14s %8s %10s\n' stage "wall [s]" "CPU [s]"
cat "$notes/times"
awk '{ processor += $3 } END { printf "%-14s %8d %10d\n", "together", '$SECONDS', processor }' "$notes/times"
but=
if [[ -f $notes/left_out ]]; then
    sed 's/^/Left out. /' "$notes/left_out"
    but=", but for what was left out"
fi
((failed)) && fail "not all passed"
printf 'check.sh: %s passed%s.\n' "$*" "$but"
