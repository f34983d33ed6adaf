#!/usr/bin/env bash
# Makes lab/dist: the lab as static files, for any web host. Needs Node.js >= 18 with npm, python3 >= 3.11, and a
# compiler for wasm32 as packaging/lib.sh says. FMUs that the page makes hold the libraries that packaging/build.sh has
# made for the platforms that are named (`lab/build.sh linux64 win64`); without names, the one of `cargo build --release`.
# LEMONS_PROFILE names another profile than dist and release: check.sh compiles with its own.
named=("$@")
source "$(dirname "${BASH_SOURCE[0]}")/../packaging/lib.sh"

target_directory=${CARGO_TARGET_DIR:-$root/target}
profile=${LEMONS_PROFILE:-dist}
compile_wasm --profile "$profile" --target-dir "$target_directory/wasm" -p lemons-lab
cd lab
# Only what package-lock.json names, by its hashes.
npm ci --no-audit --no-fund --loglevel=error
npm run --silent check
mkdir -p "$target_directory/wasm/licences"
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-0} python3 ../packaging/licences.py "$target_directory/wasm/licences" wasm32-unknown-unknown
node build.mjs "$target_directory/wasm/wasm32-unknown-unknown/$profile/lemons_lab.wasm" \
    "$target_directory/wasm/licences/THIRD-PARTY.txt"

own=$target_directory/${LEMONS_PROFILE:-release}/libcrowd_mechanics.so
if ((${#named[@]})); then
    python3 ../packaging/archives.py --binaries "$dist" dist "${named[@]}"
elif [[ -f $own && $(uname -m) == x86_64 ]]; then
    mkdir -p dist/binaries/linux64
    cp "$own" dist/binaries/linux64/
    printf '{"linux64":"binaries/linux64/%s"}\n' "$(basename -- "$own")" >dist/binaries.json
else
    note "no libraries: the page will make no FMUs (packaging/build.sh makes them)"
fi
printf 'lab/build.sh: %s, %s bytes compressed\n' "$root/lab/dist" \
    "$(cat dist/*.js dist/*.css dist/*.html dist/*.wasm | gzip -9 | wc -c)"
