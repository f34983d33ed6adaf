#!/usr/bin/env bash
# Makes everything that is released, in dist/: libraries and commands (build.sh), what is in them (licences.py), FMUs of
# the shipped Trials for all platforms, with references; the folder of examples for fmi-standard.org (examples.py); wheels,
# archives, checksums. `release.sh linux64 win64` leaves out other platforms.
# The same commit and the same compiler give the same bytes. BUILT=1 takes the libraries that are in dist/.
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

need_time
choose_compiler "${all[@]}" "$page"
[[ -n ${BUILT:-} ]] || packaging/build.sh "$@"

# The command of this machine.
case $(uname -m) in
    x86_64) host=linux64 ;;
    aarch64) host=aarch64-linux ;;
    *) fail "$(uname -m): no command for this machine" ;;
esac
lemons=$dist/$host/lemons
[[ -x $lemons ]] || fail "$lemons is missing: build.sh $host"

[[ -f lab/dist/lemons_lab.wasm ]] || fail "lab/dist is missing: lab/build.sh"

# Before FMUs: they hold THIRD-PARTY.txt, too.
python3 packaging/licences.py "$dist" "${all[@]}" "$page"

crowd=() decision=() summary=()
for platform; do
    read -r one other third <<<"$(libraries "$platform")"
    crowd+=(--binary "$platform=$dist/$platform/$one")
    decision+=(--binary "$platform=$dist/$platform/$other")
    summary+=(--binary "$platform=$dist/$platform/$third")
done
options=(--reference --until 5 --force)
fmus=()
for fmi in 2 3; do
    for trial in push door; do
        fmus+=("$dist/${trial}_fmi$fmi.fmu")
        "$lemons" pack "resources/Trial_$trial" --fmi $fmi "${crowd[@]}" "${options[@]}" -o "${fmus[-1]}"
    done
    fmus+=("$dist/decision_fmi$fmi.fmu")
    "$lemons" decide resources/Trial_door --fmi $fmi "${decision[@]}" "${options[@]}" -o "${fmus[-1]}"
    fmus+=("$dist/summary_fmi$fmi.fmu")
    "$lemons" pack resources/Trial_door --interface summary --area door=3,1,5,4 --fmi $fmi "${summary[@]}" "${options[@]}" \
        -o "${fmus[-1]}"
done
rm -rf "$dist/fmi-examples"
python3 packaging/examples.py "$dist/fmi-examples" "${fmus[@]}"

rm -f "$dist"/*.whl "$dist"/*.tar.gz "$dist"/*.zip
python3 packaging/wheels.py "$dist" "$@"
python3 packaging/archives.py "$dist" "$@"
cd "$dist"
find . -maxdepth 1 -type f ! -name SHA256SUMS -printf '%P\n' | sort | xargs sha256sum >SHA256SUMS
