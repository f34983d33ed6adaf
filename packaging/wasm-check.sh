#!/usr/bin/env bash
# Builds for wasm32-unknown-unknown what can run in a browser, and looks at what the linked engine imports. No part of
# check.sh, because the target is not there everywhere. What it needs is named in lib.sh.
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

target=wasm32-unknown-unknown
directory=${CARGO_TARGET_DIR:-target/wasm}
packages=(lemons-core crowd-mechanics lemons-people lemons-scenario lemons-picture lemons-results lemons-decision lemons-sim lemons-report lemons-lab)

compile_wasm --target-dir "$directory" "${packages[@]/#/-p}"

# What the linked engine imports, whose C functions an importer calls. Only what wasm-bindgen leaves is known: zip asks
# for random bytes through getrandom, which has it as a dependency. Nothing calls these functions; a page gives them as
# empty ones. The import section has the number 2; a length is an LEB128.
python3 - "$directory/$target/debug/crowd_mechanics.wasm" <<'END'
import sys

data = open(sys.argv[1], "rb").read()
place = 8


def number():
    global place
    value = shift = 0
    while True:
        byte = data[place]
        place += 1
        value |= (byte & 0x7F) << shift
        shift += 7
        if byte < 0x80:
            return value


def name():
    global place
    size = number()
    place += size
    return data[place - size:place].decode()


while place < len(data):
    kind = data[place]
    place += 1
    size = number()
    end = place + size
    if kind == 2:
        for _ in range(number()):
            module, function = name(), name()
            if data[place] != 0 or not module.startswith("__wbindgen_"):
                sys.exit(f"wasm-check.sh: {sys.argv[1]} imports {module} {function}")
            place += 1
            number()
    place = end
END
printf 'wasm-check.sh: %s build for %s\n' "${packages[*]}" "$target"
