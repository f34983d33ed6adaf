#!/usr/bin/env bash
# Everything that must hold before a change is done; CI runs nothing else.
# Needs cargo, a C compiler and python3 >= 3.10 with venv. PYTHON names another Python.
# With names of stages only those: ./check.sh clippy test. The stage pytest uses what the stage release has built.
set -euo pipefail

# Relative to where this is started, like cargo does it.
if [[ -n ${CARGO_TARGET_DIR:-} ]]; then
    CARGO_TARGET_DIR=$(realpath -m -- "$CARGO_TARGET_DIR")
    export CARGO_TARGET_DIR
fi
cd "$(dirname "${BASH_SOURCE[0]}")"
python=${PYTHON:-python3}

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
    cp "${CARGO_TARGET_DIR:-target}/release/liblemons_native.so" python/src/lemons_fmu/_native.abi3.so
}

# Tests send signals. What a shell starts in the background ignores some of them, and its children do.
signals=()
env --default-signal true 2>/dev/null && signals=(env --default-signal)

# The lab needs what is not everywhere: then it is left out, and that is said at the end too.
left_out=
lab() {
    local missing=()
    command -v npm >/dev/null || missing+=("Node.js with npm")
    command -v chromium >/dev/null || missing+=(chromium)
    python3 -c "import tomllib" 2>/dev/null || missing+=("python3 >= 3.11")
    (source packaging/lib.sh && choose_compiler wasm32-unknown-unknown) >/dev/null 2>&1 ||
        missing+=("a compiler for wasm32 (packaging/lib.sh)")
    if ((${#missing[@]})); then
        left_out=" The lab was left out: missing $(IFS=, && printf %s "${missing[*]}")."
        printf '\n==%s\n' "$left_out"
        return
    fi
    stage lab/build.sh
    # Which takes the page in.
    stage cargo build --release "${formats[@]}" "${packages[@]}"
    stage python_environment
    stage .venv/bin/python -m pytest tests/lab -q -n 2 --dist loadfile
}

packages=(-p crowd-mechanics -p lemons-cli -p lemons-decision-fmu -p lemons-python)
formats=(--features lemons-cli/parquet,lemons-cli/sqlite)
stages=(format clippy test doc release pytest lab)

run() {
    case $1 in
        format)
            stage cargo fmt --all --check
            stage cargo fmt --manifest-path component/Cargo.toml --all --check
            ;;
        clippy)
            stage cargo clippy --locked --workspace --all-targets --all-features -- -D warnings
            # Without C, as the first command of README.md builds it.
            stage cargo clippy --locked -p lemons-cli -- -D warnings
            ;;
        test) stage "${signals[@]}" cargo test --workspace --all-features ;;
        doc) stage env RUSTDOCFLAGS="-D warnings" cargo doc --workspace --all-features --no-deps ;;
        # With Parquet and SQLite, like wheels; in one go, which builds what all need once.
        release) stage cargo build --release "${formats[@]}" "${packages[@]}" ;;
        pytest)
            stage python_environment
            stage extension
            # Two processes; the tests of a file share what they build.
            stage "${signals[@]}" .venv/bin/python -m pytest tests/fmpy -q -n 2 --dist loadfile
            ;;
        lab) lab ;;
    esac
}

for name; do
    [[ " ${stages[*]} " == *" $name "* ]] || fail "$name: no such stage; there are ${stages[*]}"
done
if (($#)); then
    for name; do
        run "$name"
    done
    printf '\ncheck.sh: %s passed.%s\n' "$*" "$left_out"
    exit
fi

# Two at a time: each of them leaves a processor idle now and then. What the second one prints follows at the end.
run format
second=$(mktemp)
trap 'rm -f "$second"' EXIT
"${signals[@]}" ./check.sh release pytest lab >"$second" 2>&1 &
failed=0
./check.sh clippy test doc || failed=1
wait $! || failed=1
cat "$second"
((failed)) && fail "not all passed"
printf '\ncheck.sh: all passed.\n'
