"""Solves cases again, and says how well.

    python reference/solve.py [CASE]... [--write]

Each line: the largest difference of the stored solution from the one of now, over the scales; of the closed form, where there is one, from the
integrators of law.py; of both integrators from each other; and the order that the fixed one shows with three steps. `--write` stores them.
"""

import argparse
import importlib.util
import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import law  # noqa: E402


def module(directory):
    specification = importlib.util.spec_from_file_location(f"solution_{directory.name}", directory / "solution.py")
    found = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(found)
    return found


def directories(names=()):
    found = sorted(path.parent for path in HERE.glob("*/solution.py"))
    return [path for path in found if not names or any(path.name.startswith(name) for name in names)]


def examined(directory, quick=False):
    """The solution, the closed form's distance from the adaptive integrator, the distance of both integrators, the order.

    Quick: steps are longer, and where there is a closed form of all, the second integrator is left out.
    """
    case, script = law.description(directory), module(directory)
    solution = script.solution()
    if not case["check_step"]:  # a property that any law must have, or measured
        return solution, math.nan, 0.0, math.nan
    if quick and case["kind"] == "closed form":
        return solution, law.distance(case, solution, law.solved(directory, list(solution), 5e-3, 1e-10)), 0.0, math.nan
    best = solution if case["kind"] == "converged" else None
    values, order, bar = law.certificate(directory, list(solution), case["check_step"] * (2 if quick else 1), best)
    known = script.solution if case["kind"] == "closed form" else getattr(script, "closed", dict)
    return solution, law.distance(case, known(), values), bar, order


def write(directory, solution, bar):
    path = directory / "case.toml"
    before = path.read_text().split("\n[solution]")[0].rstrip("\n")
    rows = "".join(f'"{name}" = {value!r}\n' for name, value in solution.items())
    path.write_text(f"{before}\n\n[solution]  # error bar {bar:.0e} of the scales\n{rows}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("case", nargs="*")
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    print(f"{'case':24}{'stored':>10}{'closed':>10}{'two ways':>10}{'order':>7}")
    for directory in directories(arguments.case):
        solution, closed, bar, order = examined(directory)
        case = law.description(directory)
        if arguments.write:
            bars = {"converged": bar, "measured": case["tolerance"]}
            write(directory, solution, max(bars.get(case["kind"], 0), 1e-12))
            case = law.description(directory)
        print(f"{directory.name:24}{law.distance(case, solution, case['solution']):10.1e}{closed:10.1e}{bar:10.1e}{order:7.2f}", flush=True)


if __name__ == "__main__":
    main()
