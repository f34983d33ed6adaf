"""Puts the command of each platform into an archive, with the libraries of all platforms and the licences; and the lab's
page for web hosts.

    archives.py DIST PLATFORM…

writes DIST/lemons-VERSION-PLATFORM.tar.gz, for Windows .zip, and DIST/lemons-VERSION-lab.zip (lab/dist, with the crowd's
libraries). The same files give the same bytes.

    archives.py --binaries DIST PAGE PLATFORM…

copies the libraries to the page in the directory PAGE instead.
"""

import gzip
import io
import json
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
            if path.name.split(".")[0] not in ("lemons", "_native"):
                files[f"{directory.name}/{path.name}"] = path
    ours = ("LICENSE-APACHE", "LICENSE-MIT", "include/crowd_mechanics.h")
    for path in (dist / "THIRD-PARTY.txt", *(ROOT / name for name in ours)):
        files[path.name] = path
    return files


def libraries(dist: Path, platforms: list[str]) -> dict[str, bytes]:
    """The crowd's libraries for a page: the files, and binaries.json, which names them."""
    places = {platform: next((dist / platform).glob("*crowd_mechanics.*")) for platform in sorted(platforms)}
    places["THIRD-PARTY.txt"] = dist / "THIRD-PARTY.txt"
    here = {
        name: f"binaries/{name}/{path.name}" if name in platforms else f"binaries/{name}"
        for name, path in places.items()
        if path.exists()
    }
    files = {place: places[name].read_bytes() for name, place in here.items()}
    return files | {"binaries.json": json.dumps(here, separators=(",", ":")).encode()}


def page(dist: Path, platforms: list[str]) -> dict[str, bytes]:
    """The lab's page, with libraries of a release."""
    built = ROOT / "lab" / "dist"
    files = {path.name: path.read_bytes() for path in sorted(built.iterdir()) if path.is_file()}
    return files | libraries(dist, platforms)


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


def write_zip(to: Path, files: dict[str, tuple[bytes, int]], epoch: int) -> None:
    """Files with their modes."""
    with zipfile.ZipFile(to, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, (data, permissions) in files.items():
            entry = zipfile.ZipInfo(name, time.gmtime(epoch)[:6])
            entry.compress_type, entry.create_system = zipfile.ZIP_DEFLATED, 3
            entry.external_attr = (0o100000 | permissions) << 16
            archive.writestr(entry, data)


def main() -> None:
    if sys.argv[1] == "--binaries":
        dist, to = Path(sys.argv[2]), Path(sys.argv[3])
        for name, data in libraries(dist, sys.argv[4:]).items():
            (to / name).parent.mkdir(parents=True, exist_ok=True)
            (to / name).write_bytes(data)
        return
    dist, platforms, epoch = Path(sys.argv[1]), sys.argv[2:], int(os.environ["SOURCE_DATE_EPOCH"])
    version = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
    for platform in PROGRAMS:
        if platform in platforms:
            top = f"lemons-{version}-{platform}"
            files = content(dist, platform, platforms)
            if platform == "win64":
                packed = {f"{top}/{name}": (path.read_bytes(), mode(name, path)) for name, path in files.items()}
                write_zip(dist / f"{top}.zip", packed, epoch)
            else:
                write_tar(dist / f"{top}.tar.gz", top, files, epoch)
    site = {name: (data, 0o644) for name, data in page(dist, platforms).items()}
    write_zip(dist / f"lemons-{version}-lab.zip", site, epoch)
    for path in sorted(dist.glob(f"lemons-{version}-*")):
        print(f"{path.name}: {path.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
