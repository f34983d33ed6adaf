"""Joins libraries of a Mac for several processors into one file, as `lipo -create` does.

    fat.py OUTPUT DIRECTORY… FILE

joins DIRECTORY/FILE of all directories. The format: a header and a row (processor, its kind, offset, size, alignment)
for each library, big-endian, then the libraries; <mach-o/fat.h>.
"""

import struct
import sys
from pathlib import Path

ALIGNMENT = 14  # as a power of 2: the pages of ARM64


def main() -> None:
    output, *directories, name = sys.argv[1:]
    libraries = [(Path(directory) / name).read_bytes() for directory in directories]
    rows, place = [], 1 << ALIGNMENT
    for library in libraries:
        magic, processor, kind = struct.unpack("<3I", library[:12])
        if magic != 0xFEEDFACF:
            sys.exit(f"fat.py: {name}: no 64-bit Mach-O")
        rows.append((processor, kind, place, len(library), ALIGNMENT))
        place += -(-len(library) >> ALIGNMENT) << ALIGNMENT
    with open(output, "wb") as file:
        file.write(struct.pack(">2I", 0xCAFEBABE, len(rows)))
        for row in rows:
            file.write(struct.pack(">5I", *row))
        for row, library in zip(rows, libraries):
            file.seek(row[2])
            file.write(library)
    Path(output).chmod(0o755)


if __name__ == "__main__":
    main()
