#!/usr/bin/env bash
# Makes all that is released (release.sh) and tests it: sizes, symbols, what is imported; the Windows command under wine
# and that for aarch64 under qemu against the one for Linux, bit for bit; wheels in fresh environments; the same bytes
# again.
# Prepares a fresh Debian for it, if root runs it. Rust itself is expected there only if rustup has all targets.
# `check.sh linux64 win64` leaves out other platforms. BUILT=1 takes the libraries that are in dist/.
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

begin=$SECONDS
given=("$@")
has() {
    [[ " ${given[*]} " == *" $1 "* ]]
}

packages=()
want() {
    command -v "$1" >/dev/null || packages+=("${@:2}")
}
want git git
want script bsdutils
want objdump binutils
want python3 python3
want npm npm nodejs
python3 -c 'import ensurepip, venv' 2>/dev/null || packages+=(python3-venv)
! has win64 || want x86_64-w64-mingw32-gcc gcc-mingw-w64-x86-64
want cc build-essential
! has win64 || [[ -x /usr/lib/wine/wine64 ]] || packages+=(wine64)
! has aarch64-linux || want qemu-aarch64 qemu-user libc6-arm64-cross
if [[ -z ${PACKAGING_WITH:-} ]] && have_rustup "${all[@]}" "$page"; then export PACKAGING_WITH=rustup; fi
[[ ${PACKAGING_WITH:-} == rustup ]] || have_debian "${all[@]}" "$page" || packages+=("${debian_packages[@]}")
if ((${#packages[@]})); then
    [[ $(id -u) == 0 ]] && command -v apt-get >/dev/null ||
        fail "missing: ${packages[*]} (only root can install them, with apt-get)"
    export DEBIAN_FRONTEND=noninteractive
    apt-get update -qq
    apt-get install -qq -y --no-install-recommends "${packages[@]}" </dev/null
fi

choose_compiler "${all[@]}" "$page"
packaging/release.sh "$@"
note "made after $((SECONDS - begin)) s"
ls -l "$dist" "$dist"/*/ | awk 'NF > 8 { printf "%12d  %s\n", $5, $9 }'
(cd "$dist" && sha256sum --quiet -c SHA256SUMS)
# FMUs hold the licences of what is in their libraries: `licensed FILE…`
licensed() {
    python3 - "$dist/THIRD-PARTY.txt" "$@" <<'END'
import sys, zipfile

licences = open(sys.argv[1], "rb").read()
for name in sys.argv[2:]:
    with zipfile.ZipFile(name) as fmu:
        assert fmu.read("documentation/licenses/THIRD-PARTY.txt") == licences, name
END
}
licensed "$dist"/*_fmi?.fmu

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# `at_most MEGABYTES FILE…`
at_most() {
    local file
    for file in "${@:2}"; do
        (($(stat -c %s "$file") <= $1 * 1000000)) || fail "$file has more than $1 MB"
    done
}

note "what is in the files"
for platform; do
    for file in $(libraries "$platform"); do
        # Of Macs, for two processors, with all symbols.
        at_most "$([[ $platform == darwin64 ]] && echo 18 || echo 8)" "$dist/$platform/$file"
        python3 packaging/symbols.py "$dist/$platform/$file"
    done
    for file in $(program "$platform") $(module "$platform"); do
        at_most 25 "$dist/$platform/$file"
        python3 packaging/symbols.py "$dist/$platform/$file"
    done
    # Nothing tells on which machine it was made.
    for place in "$root" "${CARGO_HOME:-$HOME/.cargo}"; do
        ! grep -qrF "$place" "$dist/$platform" || fail "$dist/$platform: contains the path $place"
    done
done

note "the same numbers"
lemons=$dist/linux64/lemons
"$lemons" info "$dist/push_fmi2.fmu" --only "no such" >"$work/info"
for platform; do
    grep -q "\b$platform\b" "$work/info" || fail "push_fmi2.fmu has no $platform: $(<"$work/info")"
done
# What is compared: the push and the thirty people at the door, from FMUs of both versions and coupled; a crowd that is
# made, packed and run; ends of lines as Windows has them. Directories have spaces and letters of other languages.
mkdir -p "$work/Jürgen 試"
cp "$dist"/*_fmi?.fmu "$work/Jürgen 試"
cp -r resources/Trial_push "$work/Jürgen 試/Trial_CRLF"
find "$work/Jürgen 試/Trial_CRLF" -type f -exec sed -i 's/$/\r/' {} +
scenes=(
    "run push_fmi2.fmu -o push2.csv"
    "run push_fmi3.fmu -o push3.csv"
    "run door_fmi2.fmu --until 1 -o door2.csv"
    "run door_fmi3.fmu --until 1 -o door3.csv"
    "connect decision_fmi2.fmu door_fmi2.fmu -o coupled.ssp"
    "run coupled.ssp --until 0.5 -o coupled.csv --outputs none.csv"
    "crowd --number 150 --box 4.56x4.56 --speed 0.5 -o Menge"
    "run Menge --until 0.2 -o dense.csv"
    "check Trial_CRLF"
    "run Trial_CRLF --until 0.5 -o crlf.csv"
    "plot push2.csv --trial push_fmi2.fmu --at 1 -o picture.svg"
    # To the bits of the machine that has packed them.
    "replay push_fmi2.fmu"
    "replay door_fmi3.fmu"
    "replay decision_fmi2.fmu"
    "replay summary_fmi2.fmu"
)
compared=(push2.csv push3.csv door2.csv door3.csv coupled.csv dense.csv crlf.csv picture.svg Menge/static/Agents.xml)
# `play DIRECTORY COMMAND…`
play() {
    local line words to=$work/$1
    shift
    cp -r "$work/Jürgen 試" "$to"
    for line in "${scenes[@]}"; do
        read -ra words <<<"$line"
        (cd "$to" && "$@" "${words[@]}" >said.txt 2>&1 </dev/null) || fail "$* $line: $(tail -n 5 "$to/said.txt")"
    done
}
compare() {
    local file
    for file in "${compared[@]}"; do
        cmp "$work/Linux ä/$file" "$work/$1/$file" || fail "$1: $file differs from that of Linux"
    done
    note "$1: the same bits in ${#compared[@]} files"
}
play "Linux ä" "$lemons"
qemu=(qemu-aarch64 -L /usr/aarch64-linux-gnu)
if has aarch64-linux; then
    play "aarch64 ä" "${qemu[@]}" "$dist/aarch64-linux/lemons"
    compare "aarch64 ä"
fi
if has win64; then
    export WINEPREFIX=$work/wine WINEDEBUG=-all
    cp "$dist/win64/lemons.exe" "$dist"/win64/*.dll "$work"
    wine=$(command -v /usr/lib/wine/wine64 wine64 wine | head -n 1)
    "$wine" wineboot --init
    # Wine 8 has no bcryptprimitives.dll.
    x86_64-w64-mingw32-gcc -shared -O2 -o "$WINEPREFIX/drive_c/windows/system32/bcryptprimitives.dll" \
        packaging/bcryptprimitives.c -ladvapi32
    play "Windows ä" "$wine" "$work/lemons.exe"
    compare "Windows ä"
    # A drive, backslashes.
    (cd / && "$wine" "$work/lemons.exe" run "Z:${work//\//\\}\\Windows ä\\push_fmi2.fmu" \
        -o "Z:${work//\//\\}\\Windows ä\\drive letter.csv" >/dev/null)
    cmp "$work/Linux ä/push2.csv" "$work/Windows ä/drive letter.csv"
    # Ctrl-C needs a console, which wine has where it has a terminal. Complete steps stay, as on Linux.
    x86_64-w64-mingw32-gcc -O2 -o "$work/interrupt.exe" packaging/interrupt.c
    said=0
    line="'$wine' ../interrupt.exe '.lemons-*' ../lemons.exe run push_fmi2.fmu --until 10000 -o interrupted.csv"
    (cd "$work/Windows ä" && script -qec "$line" /dev/null </dev/null >/dev/null) || said=$?
    ((said == 130)) || fail "Windows: Ctrl-C gives the exit code $said"
    rows=$(wc -l <"$work/Windows ä/interrupted.csv")
    ((rows > 5 && rows % 5 == 1)) || fail "Windows: Ctrl-C leaves $rows rows of five people"
    cmp <(head -n 501 "$work/Windows ä/interrupted.csv") <(head -n "$rows" "$work/Linux ä/push2.csv" | head -n 501)
    note "Windows: Ctrl-C leaves $((rows / 5)) complete times"
    # Closed forms, the ledger, golden bits.
    (cd "$work" && "$wine" "$work/lemons.exe" verify >"$work/verify.txt") || fail "$(grep -v ' ok' "$work/verify.txt")"
    tail -n 1 "$work/verify.txt" >&2
fi

# An importer that knows nothing of the project; on Windows, the resources have a drive and percent signs.
unpacked=$work/"Jürgen 試"/unpacked
python3 -m zipfile -e "$dist/push_fmi2.fmu" "$unpacked"
guid=$(sed -n 's/.*guid="\([^"]*\)".*/\1/p' "$unpacked/modelDescription.xml" | head -n 1)
uri=$(python3 -c 'import sys, urllib.parse; print(urllib.parse.quote(sys.argv[1]))' "$unpacked/resources")
# References of variables, by their names.
references() {
    python3 - "$unpacked/modelDescription.xml" "$@" <<'END'
import sys
import xml.etree.ElementTree as xml

variables = xml.parse(sys.argv[1]).iter("ScalarVariable")
known = {variable.get("name"): variable.get("valueReference") for variable in variables}
print(*(known[name] for name in sys.argv[2:]))
END
}
# A force on the first person; x and y of everybody, after each of 40 steps.
force=$(references "agent[0].Fp.x")
read -ra outputs <<<"$(references "agent["{0..4}"].Position."{x,y})"
run=("$guid" 40 0.05 "$force" 1000 "${outputs[@]}")
cc -O2 -o "$work/importer" packaging/importer.c -ldl
"$work/importer" "$unpacked/binaries/linux64/CrowdMechanics.so" "file://$uri" "${run[@]}" >"$work/importer.linux64"
(($(wc -w <"$work/importer.linux64") == 400)) || fail "the importer got no results"
(($(cut -d ' ' -f 9 "$work/importer.linux64" | sort -u | wc -l) > 10)) ||
    fail "the push did not reach the last person"
if has aarch64-linux; then
    tools
    "$directory/tools/bin/python" -m ziglang cc -target aarch64-linux-gnu.$glibc -O2 -o "$work/importer.arm" \
        packaging/importer.c -ldl
    "${qemu[@]}" "$work/importer.arm" \
        "$unpacked/binaries/aarch64-linux/CrowdMechanics.so" "file://$uri" "${run[@]}" >"$work/importer.aarch64-linux"
fi
if has win64; then
    x86_64-w64-mingw32-gcc -O2 -o "$work/importer.exe" packaging/importer.c
    "$wine" "$work/importer.exe" "Z:${unpacked//\//\\}\\binaries\\win64\\CrowdMechanics.dll" "file:///Z:$uri" \
        "${run[@]}" | tr -d '\r' >"$work/importer.win64"
fi
for platform; do
    [[ $platform == darwin64 ]] || cmp "$work/importer.linux64" "$work/importer.$platform"
done
note "an importer in C: the same bits in 400 numbers of $*"

note "wheels and archives"
python3 -m venv "$work/venv"
wheel=$(echo "$dist"/lemons_fmu-"$version"-*manylinux_2_17_x86_64*.whl)
"$work/venv/bin/python" -m pip install --quiet --disable-pip-version-check --only-binary :all: "${wheel}[examples]"
(cd "$work" && env -u LEMONS MPLBACKEND=Agg PATH="$work/venv/bin:/usr/bin:/bin" \
    "$work/venv/bin/python" "$root/packaging/wheel_test.py" "$root" "$@")

# The command in a directory packs FMUs for all platforms: `packs PLATFORM DIRECTORY HOW…`
packs() {
    (cd "$work" && "${@:3}" "$2/$(program "$1")" pack "$root/resources/Trial_push" --force -o "$1.fmu")
    (cd "$work" && "${@:3}" "$2/$(program "$1")" decide "$root/resources/Trial_door" --force -o "$1_decision.fmu")
    (cd "$work" && "${@:3}" "$2/$(program "$1")" pack "$root/resources/Trial_door" --interface summary --force -o "$1_summary.fmu")
    licensed "$work/$1.fmu" "$work/$1_decision.fmu" "$work/$1_summary.fmu"
    "$lemons" info "$work/$1.fmu" --only "no such" >"$work/info"
    local platform
    for platform in "${given[@]}"; do
        grep -q "\b$platform\b" "$work/info" || fail "$2 packs no library for $platform"
    done
}
# pip takes the wheels of other systems apart as it would there; what is in them runs under wine and qemu.
other() {
    local to=$work/wheel\ of\ $1
    "$work/venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-deps --only-binary :all: \
        --platform "$2" --target "$to" "$dist"/lemons_fmu-"$version"-*"$2"*.whl
    packs "$1" "$to/lemons_command" "${@:3}"
}
mkdir "$work/archives"
tar -xzf "$dist/lemons-$version-linux64.tar.gz" -C "$work/archives"
packs linux64 "$work/archives/lemons-$version-linux64"
if has aarch64-linux; then
    other aarch64-linux manylinux_2_17_aarch64 "${qemu[@]}"
    tar -xzf "$dist/lemons-$version-aarch64-linux.tar.gz" -C "$work/archives"
    packs aarch64-linux "$work/archives/lemons-$version-aarch64-linux" "${qemu[@]}"
fi
if has win64; then
    python3 -m zipfile -e "$dist/lemons-$version-win64.zip" "$work/archives"
    other win64 win_amd64 "$wine"
    packs win64 "$work/archives/lemons-$version-win64" "$wine"
fi

# `serves COMMAND…`: the lab, to this machine.
serves() {
    "$@" lab --no-browser >"$work/lab" 2>&1 </dev/null &
    local server=$! asked=0
    python3 - "$work/lab" "$dist/lemons-$version-lab.zip" "${given[@]}" <<'END' || asked=$?
import gzip, json, re, sys, time, urllib.request, zipfile

said, archive, *platforms = sys.argv[1:]
for _ in range(300):
    found = re.search(r"http://127\.0\.0\.1:\d+/", open(said, errors="replace").read())
    if found:
        break
    time.sleep(0.1)
else:
    sys.exit("the lab does not start: " + open(said, errors="replace").read())
address = found.group()
ask = lambda path: urllib.request.urlopen(address + path, timeout=30).read()
# The command gives the files that the archive for web hosts has.
with zipfile.ZipFile(archive) as site:
    names = site.namelist()
    assert json.loads(ask("binaries.json")) == json.loads(site.read("binaries.json"))
    assert {"index.html", "page.js", "worker.js", "lemons_lab.wasm", "licences.txt"} < set(names), names
    for name in names:
        if name.endswith(".gz"):
            # For hosts that give them in place of the others.
            assert gzip.decompress(site.read(name)) == site.read(name.removesuffix(".gz")), name
        else:
            assert ask(name) == site.read(name) or name == "binaries.json", name
    assert set(platforms) < set(json.loads(site.read("binaries.json")))
END
    kill "$server" 2>/dev/null
    wait "$server" 2>/dev/null || true
    ((asked == 0)) || fail "$* lab: not the page that it should give"
}
serves "$work/archives/lemons-$version-linux64/lemons"
! has aarch64-linux || serves "${qemu[@]}" "$work/archives/lemons-$version-aarch64-linux/lemons"
! has win64 || serves "$wine" "$work/archives/lemons-$version-win64/lemons.exe"
note "the lab, served by the commands of $*"

note "the same bytes again"
made_of=$("$lemons" --version | sed -n 's/^commit //p')
if git diff --quiet HEAD && [[ $made_of == "$(git rev-parse HEAD)" ]]; then
    # In another place.
    git clone -q . "$work/elsewhere"
    (cd "$work/elsewhere" && DIST=$work/again PACKAGING_TARGET_DIR=$work/target packaging/build.sh linux64) >/dev/null
    for file in $(libraries linux64) $(program linux64) $(module linux64); do
        cmp "$work/again/linux64/$file" "$dist/linux64/$file"
    done
else
    note "libraries are not compared: files have changed since they were built, or since the commit"
fi
cp "$dist/SHA256SUMS" "$work"
BUILT=1 packaging/release.sh "$@" >/dev/null
cmp "$dist/SHA256SUMS" "$work/SHA256SUMS"
note "all passed after $((SECONDS - begin)) s"
