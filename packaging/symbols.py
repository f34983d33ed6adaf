"""Looks at what a binary needs of its system, and what it shows to others. Fails if that is not what docs/install.md
says.

    symbols.py FILE…

ELF: no function is newer than glibc 2.17, and only libraries of glibc are needed (readelf of binutils). PE: only DLLs
of Windows are needed, and not what opens a console window (objdump of mingw-w64's binutils). Mach-O: only libraries
of the system. Libraries show the functions of FMI and CrowdMechanics, commands none; the extension of the Python package
shows what Python asks for, too, and needs Python on Windows. In ELF and PE there are no other symbols. In Mach-O there
are: zig's linker cannot hide them, and a Mac binds a symbol to the library that it was linked with. Both processors must
show the functions.
"""

import re
import struct
import subprocess
import sys
from pathlib import Path

GLIBC = (2, 17)
ELF_NEEDS = re.compile(r"lib(c|m|dl|pthread|rt|util)\.so\.\d|ld-linux-.*\.so\.\d")
#: Of every Windows since 7; the last is that of Rust's standard library, for random bytes.
PE_NEEDS = {
    "advapi32.dll", "api-ms-win-core-synch-l1-2-0.dll", "bcrypt.dll", "bcryptprimitives.dll", "kernel32.dll",
    "msvcrt.dll", "ntdll.dll", "ole32.dll", "oleaut32.dll", "psapi.dll", "shell32.dll", "user32.dll", "userenv.dll",
    "ws2_32.dll",
}
MACH_NEEDS = {f"/usr/lib/{name}.dylib" for name in ("libSystem.B", "libcharset.1", "libiconv.2")}
SHOWN = re.compile(r"fmi[23][A-Z]\w*|CrowdMechanics")
EXTENSION, PYTHON = "PyInit__native", "python3.dll"


def of_tool(*command: str) -> str:
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def elf(path: Path) -> tuple[set[str], set[str], str]:
    lines = of_tool("readelf", "--wide", "--dyn-syms", str(path)).splitlines()
    rows = [line.split() for line in lines if re.match(r"\s+\d+:", line)]
    shown = {row[7].split("@")[0] for row in rows if len(row) > 7 and row[4] in ("GLOBAL", "WEAK") and row[6] != "UND"}
    asked = re.findall(r"GLIBC_([\d.]+)", of_tool("readelf", "--wide", "-V", str(path)))
    versions = {tuple(map(int, version.split("."))) for version in asked}
    if ".symtab" in of_tool("readelf", "--wide", "-S", str(path)):
        sys.exit(f"{path}: has symbols beside what is exported")
    newest = max(versions)
    if newest > GLIBC:
        sys.exit(f"{path}: needs glibc {'.'.join(map(str, newest))}")
    needed = set(re.findall(r"\(NEEDED\).*\[(.*)\]", of_tool("readelf", "--wide", "-d", str(path))))
    return {name for name in needed if not ELF_NEEDS.fullmatch(name)}, shown, f"glibc {'.'.join(map(str, newest))}"


def pe(path: Path) -> tuple[set[str], set[str], str]:
    if "no symbols" not in of_tool("x86_64-w64-mingw32-objdump", "-t", str(path)):
        sys.exit(f"{path}: has symbols")
    text = of_tool("x86_64-w64-mingw32-objdump", "-p", str(path))
    needed = {name.lower() for name in re.findall(r"DLL Name: (\S+)", text)}
    # It opens a console window.
    needed |= set(re.findall(r"\bAllocConsole\b", text))
    _, _, table = text.partition("[Ordinal/Name Pointer] Table")
    shown = set(re.findall(r"^\s*\[\s*\d+\](?: \+base\[\s*\d+\])?\s+(?:[0-9a-f]+ )?(\S+)$", table, re.MULTILINE))
    return needed - PE_NEEDS, shown, f"{len(needed)} DLLs of Windows"


def mach(path: Path) -> tuple[set[str], set[str], str]:
    data = path.read_bytes()
    places = [0]
    if data[:4] == b"\xca\xfe\xba\xbe":
        (count,) = struct.unpack_from(">I", data, 4)
        places = [struct.unpack_from(">5I", data, 8 + 20 * k)[2] for k in range(count)]
    needed, of_all = set(), []
    for place in places:
        shown = set()
        commands, at = struct.unpack_from("<I", data, place + 16)[0], place + 32
        for _ in range(commands):
            kind, size = struct.unpack_from("<2I", data, at)
            if kind == 0xC:  # LC_LOAD_DYLIB
                begin = at + struct.unpack_from("<I", data, at + 8)[0]
                needed.add(data[begin : data.index(b"\0", begin)].decode())
            if kind == 2:  # LC_SYMTAB
                symbols, count, strings, _ = struct.unpack_from("<4I", data, at + 8)
                for k in range(count):
                    name, flags = struct.unpack_from("<IB", data, place + symbols + 16 * k)
                    if flags & 0x01 and flags & 0x0E:  # external and defined
                        begin = place + strings + name
                        shown.add(data[begin : data.index(b"\0", begin)].decode().removeprefix("_"))
            at += size
        of_all.append({name for name in shown if SHOWN.fullmatch(name)})
    if any(shown != of_all[0] for shown in of_all):
        sys.exit(f"{path}: its processors show different functions")
    return needed - MACH_NEEDS, of_all[0], f"{len(places)} processors"


def main() -> None:
    for name in sys.argv[1:]:
        path = Path(name)
        magic = path.read_bytes()[:4]
        look = elf if magic == b"\x7fELF" else pe if magic[:2] == b"MZ" else mach
        foreign, shown, what = look(path)
        others = {each for each in shown if not SHOWN.fullmatch(each)}
        if path.name.startswith("_native."):
            if foreign - {PYTHON} or others != {EXTENSION}:
                sys.exit(f"{path}: needs {sorted(foreign)}; shows {sorted(others)}")
            print(f"{path.parent.name}/{path.name}: {what}")
            continue
        is_library = path.stem != "lemons"
        # A program shows what its start needs.
        if foreign or (is_library and others) or (is_library and not {"fmi2DoStep", "fmi3DoStep"} <= shown):
            sys.exit(f"{path}: needs {sorted(foreign)}; shows {sorted(others)} and {len(shown)} in all")
        print(f"{path.parent.name}/{path.name}: {what}, {len(shown)} functions")


if __name__ == "__main__":
    main()
