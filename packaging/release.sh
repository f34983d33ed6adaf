#!/usr/bin/env bash
# Makes everything that is released, in dist/: libraries and commands (build.sh), what is in them (licences.py), FMUs of
# the shipped Trials for all platforms, wheels, archives, checksums. `release.sh linux64 win64` leaves out other
# platforms.
# The same commit and the same compiler give the same bytes. BUILT=1 takes the libraries that are in dist/.
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

need_time
choose_compiler "${all[@]}"
[[ -n ${BUILT:-} ]] || packaging/build.sh "$@"

# The command of this machine.
case $(uname -m) in
    x86_64) host=linux64 ;;
    aarch64) host=aarch64-linux ;;
    *) fail "$(uname -m): no command for this machine" ;;
esac
lemons=$dist/$host/lemons
[[ -x $lemons ]] || fail "$lemons is missing: build.sh $host"

python3 packaging/licences.py "$dist" "${all[@]}"

crowd=() decision=()
for platform; do
    read -r one other <<<"$(libraries "$platform")"
    crowd+=(--binary "$platform=$dist/$platform/$one")
    decision+=(--binary "$platform=$dist/$platform/$other")
done
for fmi in 2 3; do
    for trial in push door; do
        "$lemons" pack "resources/Trial_$trial" --fmi $fmi "${crowd[@]}" --force -o "$dist/${trial}_fmi$fmi.fmu"
    done
    "$lemons" decide resources/Trial_door --fmi $fmi "${decision[@]}" --force -o "$dist/decision_fmi$fmi.fmu"
done

# What else is in their libraries, with the licences. A fixed date: the same bytes.
python3 - "$dist" <<'END'
import pathlib, sys, zipfile

dist = pathlib.Path(sys.argv[1])
for path in sorted(dist.glob("*_fmi?.fmu")):
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED, compresslevel=9) as fmu:
        entry = zipfile.ZipInfo("documentation/licenses/THIRD-PARTY.txt")
        entry.compress_type, entry.create_system, entry.external_attr = zipfile.ZIP_DEFLATED, 3, 0o100644 << 16
        fmu.writestr(entry, (dist / "THIRD-PARTY.txt").read_bytes())
END

rm -f "$dist"/*.whl "$dist"/*.tar.gz "$dist"/*.zip
python3 packaging/wheels.py "$dist" "$@"
python3 packaging/archives.py "$dist" "$@"
cd "$dist"
find . -maxdepth 1 -type f ! -name SHA256SUMS -printf '%P\n' | sort | xargs sha256sum >SHA256SUMS
