"""Compiles turnstile.c with a C compiler (cc, or CC), and packs it as an FMU for so many people.

    python examples/controllers/pack_turnstile.py 80 -o turnstile.fmu
"""

import argparse
import os
import platform
import subprocess
import tempfile
import zipfile
from pathlib import Path

OPTIONS = ["-shared", "-fPIC", "-O2", "-ffp-contract=off"]  # without contraction: the same bits on every machine


def build(agents, fmu):
    source = Path(__file__).with_name("turnstile.c")
    system, ending = {"Darwin": ("darwin", "dylib")}.get(platform.system(), ("linux", "so"))
    machine = platform.machine().replace("arm64", "aarch64")
    with tempfile.TemporaryDirectory() as directory:
        library = Path(directory) / f"turnstile.{ending}"
        compiler = os.environ.get("CC") or "cc"
        subprocess.run([compiler, *OPTIONS, f"-DAGENTS={agents}", source, "-o", library, "-lm"], check=True)
        with zipfile.ZipFile(fmu, "w", zipfile.ZIP_DEFLATED) as archive:
            description = source.with_suffix(".xml").read_text(encoding="utf-8")
            archive.writestr("modelDescription.xml", description.replace('"AGENTS"', f'"{agents}"'))
            archive.write(library, f"binaries/{machine}-{system}/{library.name}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("agents", type=int, help="number of people")
    parser.add_argument("-o", "--output", required=True, help="the FMU to write")
    arguments = parser.parse_args()
    build(arguments.agents, arguments.output)
