"""Puts what is built for a platform and the Python package into a wheel, for each platform that has a command.

    wheels.py DIST PLATFORM…

reads DIST/PLATFORM/ of these platforms (build.sh), DIST/THIRD-PARTY.txt and DIST/sbom.cdx.json (licences.py) and writes
DIST/lemons_fmu-VERSION-cp310-abi3-TAG.whl. A wheel holds the packages of python/src with their extension, the command,
and the libraries of all platforms, which `lemons pack` puts into FMUs. The same files give the same bytes. The format: PyPA's "Binary
distribution format".
"""

import base64
import hashlib
import os
import re
import sys
import time
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
#: The tags of a platform whose libraries need glibc 2.17, and of Windows.
TAGS = {
    "linux64": ["manylinux_2_17_x86_64", "manylinux2014_x86_64"],
    "aarch64-linux": ["manylinux_2_17_aarch64", "manylinux2014_aarch64"],
    "win64": ["win_amd64"],
}
COMMAND, PACKAGE = "lemons_command", "lemons_fmu"
ENTRY_POINTS = f"[console_scripts]\nlemons = {COMMAND}:main\n"


def _named(link: re.Match[str]) -> str:
    text, path = link.groups()
    return path if path.endswith(text) else f"{text} ({path})"


def metadata(project: dict) -> str:
    """METADATA from pyproject.toml."""
    lines = [
        "Metadata-Version: 2.4",
        f"Name: {project['name']}",
        f"Version: {project['version']}",
        f"Summary: {project['description']}",
        f"License-Expression: {project['license']}",
        "License-File: LICENSE-APACHE",
        "License-File: LICENSE-MIT",
        "License-File: THIRD-PARTY.txt",
        *(f"Classifier: {classifier}" for classifier in project["classifiers"]),
        f"Requires-Python: {project['requires-python']}",
        *(f"Requires-Dist: {dependency}" for dependency in project["dependencies"]),
    ]
    for extra, dependencies in project.get("optional-dependencies", {}).items():
        lines.append(f"Provides-Extra: {extra}")
        lines += [f'Requires-Dist: {dependency}; extra == "{extra}"' for dependency in dependencies]
    readme = (ROOT / "python" / project["readme"]).read_text(encoding="utf-8")
    # Other pages are not in the wheel: they are named instead.
    readme = re.sub(r"\[([^\]]+)\]\(\.\./([^)#]+)[^)]*\)", _named, readme)
    readme += "\nFiles of docs/ and examples/ are in the repository of the source code.\n"
    return "\n".join(lines) + "\nDescription-Content-Type: text/markdown\n\n" + readme


def content(dist: Path, platform: str, platforms: list[str], project: dict) -> dict[str, tuple[bytes, bool]]:
    """The files of a wheel, by name, and whether each can be executed."""
    files: dict[str, tuple[bytes, bool]] = {}
    source = ROOT / "python" / "src"
    for path in sorted(source.rglob("*")):
        if path.suffix in (".py", ".pyi") or path.name == "py.typed":
            files[path.relative_to(source).as_posix()] = (path.read_bytes(), False)
    for directory in (dist / each for each in sorted(platforms)):
        for path in sorted(directory.iterdir()):
            own = {"lemons": COMMAND, "_native": PACKAGE}.get(path.name.split(".")[0])
            if own and directory.name == platform:
                files[f"{own}/{path.name}"] = (path.read_bytes(), True)
            elif not own:
                files[f"{COMMAND}/{directory.name}/{path.name}"] = (path.read_bytes(), True)
    # FMUs that the command packs hold it, too.
    files[f"{COMMAND}/THIRD-PARTY.txt"] = ((dist / "THIRD-PARTY.txt").read_bytes(), False)
    about = f"lemons_fmu-{project['version']}.dist-info"
    wheel = ["Wheel-Version: 1.0", "Generator: lemons-fmu packaging", "Root-Is-Purelib: false"]
    wheel += [f"Tag: cp310-abi3-{tag}" for tag in TAGS[platform]]
    files[f"{about}/METADATA"] = (metadata(project).encode(), False)
    files[f"{about}/WHEEL"] = (("\n".join(wheel) + "\n").encode(), False)
    files[f"{about}/entry_points.txt"] = (ENTRY_POINTS.encode(), False)
    for licence in (ROOT / "LICENSE-APACHE", ROOT / "LICENSE-MIT", dist / "THIRD-PARTY.txt"):
        files[f"{about}/licenses/{licence.name}"] = (licence.read_bytes(), False)
    files[f"{about}/sboms/sbom.cdx.json"] = ((dist / "sbom.cdx.json").read_bytes(), False)
    rows = []
    for name, (data, _) in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        rows.append(f"{name},sha256={digest},{len(data)}")
    rows.append(f"{about}/RECORD,,")
    files[f"{about}/RECORD"] = (("\n".join(rows) + "\n").encode(), False)
    return files


def write(path: Path, files: dict[str, tuple[bytes, bool]]) -> None:
    date = time.gmtime(int(os.environ["SOURCE_DATE_EPOCH"]))[:6]
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, (data, executable) in files.items():
            entry = zipfile.ZipInfo(name, date)
            entry.compress_type = zipfile.ZIP_DEFLATED
            # As on Unix, wherever this runs.
            entry.create_system = 3
            entry.external_attr = (0o100755 if executable else 0o100644) << 16
            archive.writestr(entry, data)


def main() -> None:
    dist, platforms = Path(sys.argv[1]), sys.argv[2:]
    project = tomllib.loads((ROOT / "python" / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    for platform, tags in TAGS.items():
        if platform not in platforms:
            continue
        path = dist / f"lemons_fmu-{project['version']}-cp310-abi3-{'.'.join(tags)}.whl"
        write(path, content(dist, platform, platforms, project))
        print(f"{path.name}: {path.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
