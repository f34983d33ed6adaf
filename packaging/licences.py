"""Names what is in the binaries that are released: sbom.cdx.json (CycloneDX 1.5), and THIRD-PARTY.txt (licences, with
their texts).

    licences.py DIRECTORY TARGET…

These are the packages that cargo links for the targets; with wasm32 among them, also those of npm that the lab's page
is bundled with (lab/package-lock.json, after `npm ci`). Fails if a package has a licence that is not in ALLOWED, or no
file with its text, or comes from elsewhere than crates.io. Where a package has no such file, packaging/licences/
NAME.txt is one: the text of a licence that its Cargo.toml names, with the authors. Says nothing of known
vulnerabilities: `cargo deny --workspace check advisories` (deny.toml) does.
"""

import base64
import hashlib
import json
import os
import re
import subprocess
import sys
import tomllib
import uuid
from datetime import datetime, timezone
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SHIPPED = ["crowd-mechanics", "lemons-decision-fmu", "lemons-summary-fmu", "lemons-cli"]
#: The lab, in the browser.
IN_PAGES = ["lemons-lab"]
#: Licences that ask for no more than their text. deny.toml has the same list.
ALLOWED = set(tomllib.loads((ROOT / "deny.toml").read_text())["licenses"]["allow"])
#: What is linked beside packages.
OTHERS = """\
The standard library of Rust (MIT OR Apache-2.0, https://www.rust-lang.org/policies/licenses) is in all of them. SQLite
(in libsqlite3-sys) is in the public domain. Binaries for Linux and macOS contain compiler-rt and libunwind of zig and
LLVM (MIT, Apache-2.0 WITH LLVM-exception); those for Windows contain startup code of mingw-w64 (ZPL-2.1 and public
domain) and libgcc (GPL-3.0-or-later WITH GCC-exception-3.1).
"""
TEXTS = re.compile(r"(un)?licen[cs]e|copying|copyright|notice", re.IGNORECASE)


def metadata(target: str) -> dict:
    options = ["--format-version=1", "--locked", f"--filter-platform={target}"]
    command = [os.environ.get("CARGO", "cargo"), "metadata", *options]
    return json.loads(subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout)


def linked(target: str) -> dict[str, dict]:
    """The packages that are in the binaries for a target, by their ids: no build scripts, no macros, no tests."""
    known = metadata(target)
    packages = {package["id"]: package for package in known["packages"]}
    nodes = {node["id"]: node for node in known["resolve"]["nodes"]}
    shipped = IN_PAGES if target.startswith("wasm32") else SHIPPED
    waiting = [i for i, package in packages.items() if package["name"] in shipped and package["source"] is None]
    found: dict[str, dict] = {}
    while waiting:
        i = waiting.pop()
        macro = any("proc-macro" in t["kind"] for t in packages[i]["targets"])
        if i in found or macro:
            continue
        found[i] = packages[i]
        for dependency in nodes[i]["deps"]:
            if any(kind["kind"] is None for kind in dependency["dep_kinds"]):
                waiting.append(dependency["pkg"])
    # The metadata have the features of the whole workspace; those of the page alone are fewer.
    if shipped is IN_PAGES:
        there = tree(shipped, target)
        found = {i: package for i, package in found.items() if (package["name"], package["version"]) in there}
    return found


def tree(packages: list[str], target: str) -> set[tuple[str, str]]:
    """Names and versions of what is linked with packages alone."""
    options = ["--locked", f"--target={target}", "--edges=normal,no-proc-macro", "--prefix=none", "--format={p}"]
    command = [os.environ.get("CARGO", "cargo"), "tree", *options, *(f"--package={name}" for name in packages)]
    said = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout
    lines = [line.split() for line in said.splitlines() if line]
    return {(line[0], line[1].removeprefix("v")) for line in lines}


def allowed(expression: str) -> bool:
    """Whether an SPDX expression lets us choose allowed licences only."""
    words = re.findall(r"[()]|[^\s()/]+|/", expression)
    place = 0

    def next_is(*wanted: str) -> bool:
        return place < len(words) and words[place].upper() in wanted

    def either() -> bool:
        nonlocal place
        value = both()
        while next_is("OR", "/"):
            place += 1
            other = both()
            value = value or other
        return value

    def both() -> bool:
        nonlocal place
        value = one()
        while next_is("AND"):
            place += 1
            other = one()
            value = value and other
        return value

    def one() -> bool:
        nonlocal place
        if next_is("("):
            place += 1
            value = either()
            place += 1
            return value
        name = words[place]
        place += 1
        if next_is("WITH"):
            name += f" WITH {words[place + 1]}"
            place += 2
        return name in ALLOWED

    return either() and place == len(words)


def texts(package: dict) -> list[tuple[str, str]]:
    """Its files with licences, those of C sources in it, too; else the one that we have of it."""
    directory = Path(package["manifest_path"]).parent
    files = [file for file in directory.iterdir() if file.is_file()]
    files += [file for file in directory.glob("*/*") if file.is_file()]
    named = [file for file in files if TEXTS.match(file.name) and file.suffix.lower() in ("", ".md", ".txt")]
    ours = ROOT / "packaging" / "licences" / f"{package['name']}.txt"
    if not named and ours.exists():
        directory, named = ours.parent, [ours]
    return sorted((file.relative_to(directory).as_posix(), file.read_text(errors="replace").strip()) for file in named)


def bundled() -> list[dict]:
    """What npm gives the lab's page."""
    lock = json.loads((ROOT / "lab" / "package-lock.json").read_text())["packages"]
    found = []
    for place, package in lock.items():
        if place and not package.get("dev"):
            manifest = str(ROOT / "lab" / place / "package.json")
            name = place.removeprefix("node_modules/")
            found.append({**package, "name": name, "manifest_path": manifest})
    return found


def main() -> None:
    directory, *targets = sys.argv[1:]
    packages = {i: package for target in targets for i, package in linked(target).items()}
    crates = [p for p in packages.values() if p["source"]]
    pages = bundled() if any(target.startswith("wasm32") for target in targets) else []
    others = sorted([*crates, *pages], key=lambda p: (p["name"], p["version"]))
    wrong = []
    for package in others:
        name = f"{package['name']} {package['version']}"
        if not package["license"] or not allowed(package["license"]):
            wrong.append(f"{name}: {package['license']}")
        if not any(text for _, text in texts(package)):
            ours = f"packaging/licences/{package['name']}.txt"
            wrong.append(f"{name}: no text of {package['license']}; {ours} could have it")
        if package not in pages and "crates.io-index" not in package["source"]:
            wrong.append(f"{name}: from {package['source']}")
    if wrong:
        sys.exit("licences.py: not allowed:\n" + "\n".join(wrong))
    lock = tomllib.loads((ROOT / "Cargo.lock").read_text())["package"]
    sums = {(p["name"], p["version"]): p.get("checksum") for p in lock}
    version = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
    components = []
    for package in others:
        name, number = package["name"], package["version"]
        if package in pages:
            # npm's form of hashes: the algorithm, then base64.
            algorithm, _, digest = package["integrity"].partition("-")
            kind, hashed = "npm", (f"SHA-{algorithm.removeprefix('sha')}", base64.b64decode(digest).hex())
        else:
            kind, hashed = "cargo", ("SHA-256", sums[name, number])
        reference = f"pkg:{kind}/{name.replace('@', '%40')}@{number}"
        components.append({
            "type": "library",
            "bom-ref": reference,
            "name": name,
            "version": number,
            "purl": reference,
            "licenses": [{"expression": package["license"].replace("/", " OR ")}],
            "hashes": [dict(zip(("alg", "content"), hashed))],
        })
    epoch = int(os.environ["SOURCE_DATE_EPOCH"])
    about = {
        "timestamp": datetime.fromtimestamp(epoch, timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ"),
        "component": {
            "type": "application",
            "bom-ref": "lemons-fmu",
            "name": "lemons-fmu",
            "version": version,
            "licenses": [{"expression": "MIT OR Apache-2.0"}],
        },
    }
    digest = hashlib.sha256(json.dumps([about, components]).encode()).hexdigest()
    bom = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        # The same content has the same number.
        "serialNumber": f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_URL, digest)}",
        "version": 1,
        "metadata": about,
        "components": components,
    }
    out = Path(directory)
    (out / "sbom.cdx.json").write_text(json.dumps(bom, indent=1, ensure_ascii=False) + "\n")

    # A text that several packages have stands there once.
    by_text: dict[str, list[str]] = {}
    for package in others:
        for name, text in texts(package):
            by_text.setdefault(text, []).append(f"{package['name']} {package['version']} ({name})")
    lines = [f"What is in the binaries of LEMONS-FMU {version}, beside itself (MIT OR Apache-2.0)", "", OTHERS]
    lines += [f"{p['name']} {p['version']}: {p['license']}" for p in others]
    for text, owners in by_text.items():
        lines += ["", "-" * 100, *owners, "", text]
    (out / "THIRD-PARTY.txt").write_text("\n".join(lines) + "\n")
    print(f"licences.py: {len(others)} packages, {len(by_text)} different texts")


if __name__ == "__main__":
    main()
