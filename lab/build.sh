#!/usr/bin/env bash
# Makes lab/dist: the lab as static files, for any web host. Needs Node.js >= 18 with npm, python3 >= 3.11, and a
# compiler for wasm32 as packaging/lib.sh says. FMUs that the page makes hold the libraries of packaging/build.sh, else the one of
# `cargo build --release`, if there is one.
source "$(dirname "${BASH_SOURCE[0]}")/../packaging/lib.sh"

target_directory=${CARGO_TARGET_DIR:-$root/target}
compile_wasm --profile dist --target-dir "$target_directory/wasm" -p lemons-lab
mkdir -p "$target_directory/wasm/licences"
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-0} python3 packaging/licences.py "$target_directory/wasm/licences" wasm32-unknown-unknown
cd lab
# Only what package-lock.json names, by its hashes.
npm ci --no-audit --no-fund --loglevel=error
npm run --silent check
node build.mjs "$target_directory/wasm/wasm32-unknown-unknown/dist/lemons_lab.wasm" \
    "$target_directory/wasm/licences/THIRD-PARTY.txt"

entries=()
# `add PLATFORM FILE`
add() {
    mkdir -p "dist/binaries/$1"
    cp "$2" "dist/binaries/$1/"
    entries+=("\"$1\":\"binaries/$1/$(basename -- "$2")\"")
}
for platform in "${platforms[@]}"; do
    read -r crowd _ < <(libraries "$platform")
    if [[ -f $dist/$platform/$crowd ]]; then add "$platform" "$dist/$platform/$crowd"; fi
done
own=$target_directory/release/libcrowd_mechanics.so
if ((${#entries[@]} == 0)) && [[ -f $own && $(uname -m) == x86_64 ]]; then add linux64 "$own"; fi
if ((${#entries[@]})); then
    printf '{%s}\n' "$(IFS=, && printf %s "${entries[*]}")" >dist/binaries.json
else
    note "no libraries: the page will make no FMUs (packaging/build.sh makes them)"
fi
printf 'lab/build.sh: %s, %s bytes compressed\n' "$root/lab/dist" \
    "$(cat dist/*.js dist/*.css dist/*.html dist/*.wasm | gzip -9 | wc -c)"
