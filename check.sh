#!/usr/bin/env bash
# Everything that must hold before a change is done; CI runs nothing else.
# Needs cargo, a C compiler and python3 >= 3.10 with venv. PYTHON names another Python.
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

# .venv as tests/fmpy/requirements.txt says; made anew when that file or the Python changes.
python_environment() {
    local requirements=tests/fmpy/requirements.txt stamp=.venv/requirements.stamp wanted
    command -v "$python" >/dev/null || fail "$python is missing: Python 3.10 or newer is needed"
    "$python" -c 'import sys; sys.exit(sys.version_info < (3, 10))' ||
        fail "Python 3.10 or newer is needed, $python is $("$python" --version)"
    "$python" -c 'import ensurepip, venv' 2>/dev/null ||
        fail "$python cannot make virtual environments: install python3-venv (Debian, Ubuntu)"
    wanted="$("$python" --version) $(sha256sum "$requirements")"
    if [[ -f $stamp && $(<"$stamp") == "$wanted" ]] && .venv/bin/python -c '' 2>/dev/null; then
        return
    fi
    rm -rf .venv
    "$python" -m venv .venv
    .venv/bin/python -m pip install --quiet --disable-pip-version-check --only-binary :all: -r "$requirements"
    printf '%s\n' "$wanted" >"$stamp"
}

stage cargo fmt --all --check
stage cargo clippy --locked --workspace --all-targets -- -D warnings
stage cargo test --workspace
stage env RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps
stage cargo build --release --workspace
stage python_environment
stage .venv/bin/python -m pytest tests/fmpy -q

printf '\ncheck.sh: all passed\n'
