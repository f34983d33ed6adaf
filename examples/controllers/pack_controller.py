"""Compiles a controller in C with a C compiler (cc, or CC), and packs it as an FMU, on Linux and macOS.

    python examples/controllers/pack_controller.py turnstile --agents 80 -o turnstile.fmu
    python examples/controllers/pack_controller.py barrier -o barrier.fmu
"""

import argparse
import os
import platform
import subprocess
import tempfile
import zipfile
from pathlib import Path

OPTIONS = ["-shared", "-fPIC", "-O2", "-ffp-contract=off"]  # the same bits with and without fused operations
#: Directories of libraries: of FMI 2.0, and of FMI 3.0 without the machine.
PLATFORMS = {"Linux": ("linux64", "linux", "so"), "Darwin": ("darwin64", "darwin", "dylib")}


def build(name, agents, fmu):
    source = Path(__file__).with_name(f"{name}.c")
    of_2, of_3, ending = PLATFORMS[platform.system()]
    machine = platform.machine().replace("arm64", "aarch64")
    description = source.with_suffix(".xml").read_text(encoding="utf-8").replace('"AGENTS"', f'"{agents}"')
    directory = of_2 if 'fmiVersion="2.0"' in description else f"{machine}-{of_3}"
    with tempfile.TemporaryDirectory() as temporary:
        library = Path(temporary) / f"{name}.{ending}"
        compiler = os.environ.get("CC") or "cc"
        subprocess.run([compiler, *OPTIONS, f"-DAGENTS={agents}", source, "-o", library, "-lm"], check=True)
        with zipfile.ZipFile(fmu, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("modelDescription.xml", description)
            archive.write(library, f"binaries/{directory}/{library.name}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", choices=["turnstile", "barrier"])
    parser.add_argument("--agents", type=int, default=1, help="number of people that a turnstile sees")
    parser.add_argument("-o", "--output", required=True, help="the FMU to write")
    arguments = parser.parse_args()
    build(arguments.name, arguments.agents, arguments.output)
