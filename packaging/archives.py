"""Puts the command of each platform into an archive, with the libraries of all platforms and the licences.

    archives.py DIST PLATFORM…

writes DIST/lemons-VERSION-PLATFORM.tar.gz, for Windows .zip. The same files give the same bytes.
"""

import gzip
import io
import os
import sys
import tarfile
import time
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROGRAMS = {"linux64": "lemons", "aarch64-linux": "lemons", "win64": "lemons.exe"}


def content(dist: Path, platform: str, platforms: list[str]) -> dict[str, Path]:
    """The files of an archive: the command, and beside it a directory with the libraries for each platform."""
    files = {PROGRAMS[platform]: dist / platform / PROGRAMS[platform]}
    for directory in (dist / each for each in sorted(platforms)):
        for path in sorted(directory.iterdir()):
            if path.stem != "lemons":
                files[f"{directory.name}/{path.name}"] = path
    ours = ("LICENSE-APACHE", "LICENSE-MIT", "include/crowd_mechanics.h")
    for path in (dist / "THIRD-PARTY.txt", *(ROOT / name for name in ours)):
        files[path.name] = path
    return files


def mode(name: str, path: Path) -> int:
    return 0o755 if "/" in name or path.stem == "lemons" else 0o644


def write_tar(to: Path, top: str, files: dict[str, Path], epoch: int) -> None:
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w", format=tarfile.PAX_FORMAT) as archive:
        for name, path in files.items():
            data = path.read_bytes()
            entry = tarfile.TarInfo(f"{top}/{name}")
            entry.size, entry.mtime, entry.mode = len(data), epoch, mode(name, path)
            archive.addfile(entry, io.BytesIO(data))
    with open(to, "wb") as file, gzip.GzipFile("", "wb", 9, file, mtime=0) as packed:
        packed.write(buffer.getvalue())


def write_zip(to: Path, top: str, files: dict[str, Path], epoch: int) -> None:
    with zipfile.ZipFile(to, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, path in files.items():
            entry = zipfile.ZipInfo(f"{top}/{name}", time.gmtime(epoch)[:6])
            entry.compress_type, entry.create_system = zipfile.ZIP_DEFLATED, 3
            entry.external_attr = (0o100000 | mode(name, path)) << 16
            archive.writestr(entry, path.read_bytes())


def main() -> None:
    dist, platforms, epoch = Path(sys.argv[1]), sys.argv[2:], int(os.environ["SOURCE_DATE_EPOCH"])
    version = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
    for platform in PROGRAMS:
        if platform in platforms:
            top = f"lemons-{version}-{platform}"
            write, end = (write_zip, "zip") if platform == "win64" else (write_tar, "tar.gz")
            write(dist / f"{top}.{end}", top, content(dist, platform, platforms), epoch)
            print(f"{top}.{end}: {(dist / f'{top}.{end}').stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
