"""Compiles turnstile.c with a C compiler (cc, or CC), and packs it as an FMU for so many people, on Linux and macOS.

    python examples/controllers/pack_turnstile.py 80 -o turnstile.fmu
"""

import argparse
import os
import platform
import subprocess
import tempfile
import zipfile
from pathlib import Path

OPTIONS = ["-shared", "-fPIC", "-O2", "-ffp-contract=off"]  # the same bits with and without fused operations


def build(agents, fmu):
    source = Path(__file__).with_name("turnstile.c")
    system, ending = {"Linux": ("linux", "so"), "Darwin": ("darwin", "dylib")}[platform.system()]
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
