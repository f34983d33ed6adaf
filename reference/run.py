"""Runs engines on the reference cases, and prints how far each is from the solution.

    python reference/run.py [--engine NAME]... [--case NUMBER]... [--write PAGE.md]

An engine is a file in adapters/ with LABEL and a class Engine: `load(trial, refine)` (which may raise CannotExpress(why); `refine` divides the
usual step), `step(t)` to the time t [s], `force(id, Fp, Mp)` for another drive of a body from there on, if it can, `state()` (for each Id its x, y,
theta, vx, vy, omega and, if known, the sum of the normal forces of walls), `close()`, and `cost`, the processor time of `step` [s]. Where RIGID is
true, only quantities that do not depend on the stiffness are compared. An engine that is not installed is left out, and said.
"""

import argparse
import importlib
import math
import sys
import textwrap
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE / "adapters")]

from law import UNITS, description, driven  # noqa: E402
from solve import directories  # noqa: E402

ENGINES = ["lemons", "lammps_granular", "yade", "rapier", "box2d", "jupedsim_social"]
REFINED, RUNS = (1, 2, 4), 3


class CannotExpress(Exception):
    """An engine has no words for a case; the text says for what."""


def error(case, engine, state):
    """The largest error over the scales, and how many quantities are compared."""
    worst, compared = 0.0, 0
    for name, value in case["solution"].items():
        body, component = name.rsplit(".", 1)
        found = state[body] | {"speed": math.hypot(state[body]["vx"], state[body]["vy"])}
        if component not in found or (getattr(engine, "RIGID", False) and name not in case["rigid"]):
            continue
        off = abs(found[component] - value) / case["scale"][UNITS[component]]
        worst, compared = max(worst, off) if off == off else math.inf, compared + 1
    return worst, compared


def finished(module, directory, case, refine):
    """An engine that has gone to the end of a case."""
    engine = module.Engine()
    engine.load(directory, refine)
    if case.get("drive") and not hasattr(engine, "force"):
        raise CannotExpress("our adapter has no drive over time")
    driven(case, engine.step, getattr(engine, "force", None))
    return engine


def measure(module, directory, refined=REFINED, runs=1):
    """Error, order, cost [ms per body and second] and how many of the quantities are compared; or why not.

    The cost is the mean of `runs` runs, or of fewer that take 0.2 s. What was measured is not approached by shorter steps: no order.
    """
    case, errors = description(directory), []
    try:
        for refine in refined[:1] if case["kind"] == "measured" else refined:
            engine = finished(module, directory, case, refine)
            state = engine.state()
            found, compared = error(case, module, state)
            if not compared:
                free = getattr(module, "RIGID", False) and not case["rigid"]
                raise CannotExpress("nothing here is free of the stiffness" if free else "our adapter does not give these quantities")
            errors.append(found)
            engine.close()
            costs = [engine.cost] if refine == 1 else costs
            while refine == 1 and len(costs) < runs and sum(costs) < 0.2:
                engine = finished(module, directory, case, refine)
                engine.close()
                costs.append(engine.cost)
    except CannotExpress as why:
        return {"why": str(why)}
    except Exception as why:  # a program of others stopped: that is a result, too
        return {"why": f"it failed ({type(why).__name__}: {str(why).splitlines()[0][:60] if str(why) else ''})"}
    falls = len(errors) > 2 and errors[-1] > 1e-10 and errors[0] > errors[-1] > 0
    order = math.log2(errors[0] / errors[-1]) / (len(errors) - 1) if falls else None
    part = "" if compared == len(case["solution"]) else f"{compared}/{len(case['solution'])}"
    return {"error": errors[0], "order": order, "cost": 1e3 * sum(costs) / len(costs) / len(state) / case["end"], "part": part, "agrees": errors[0] <= case["tolerance"]}


def installed(names):
    modules = {}
    for name in names:
        try:
            modules[name] = importlib.import_module(name)
        except ImportError as why:
            print(f"without {name}: {why}", file=sys.stderr)
    return modules


def cell(row, what):
    if "why" in row:
        return "-"
    if what == "error":
        return f"{row['error']:.0e}" + ("" if row["agrees"] else "!")
    if what == "order":
        return "" if row["order"] is None else f"{row['order']:.1f}"
    return f"{row['cost']:.2g}"


def table(modules, rows, what, bar="  "):
    lines = [["case", *(module.LABEL for module in modules.values())]]
    lines += [[case, *(cell(found[name], what) for name in modules)] for case, found in rows.items()]
    if bar == "|":
        lines.insert(1, ["---"] * len(lines[0]))
        return "\n".join("| " + " | ".join(line) + " |" for line in lines)
    return "\n".join(f"{line[0]:24}" + "".join(f"{text:>9.9}" for text in line[1:]) for line in lines)


def parts(modules, rows):
    """What is not compared, and why."""
    out = []
    for name, module in modules.items():
        why = {}
        for case, found in rows.items():
            text = found[name].get("why") or (f"{found[name]['part']} of the quantities" if found[name]["part"] else "")
            why.setdefault(text, []).append(case[:2])
        out += [f"- {module.LABEL}: {text}: {', '.join(cases)}" for text, cases in why.items() if text]
    out = [textwrap.fill(line, 100, subsequent_indent="  ") for line in out]
    return "\n".join(out)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--engine", action="append")
    parser.add_argument("--case", action="append", default=[])
    parser.add_argument("--write", type=Path)
    arguments = parser.parse_args()
    unknown = [number for number in arguments.case if not directories([number])]
    if unknown:
        parser.error(f"no case begins with {unknown[0]!r}: they are {', '.join(directory.name for directory in directories())}")
    modules, rows = installed(arguments.engine or ENGINES), {}
    for directory in directories(arguments.case):
        rows[directory.name] = {name: measure(module, directory, runs=RUNS) for name, module in modules.items()}
        print(directory.name, {name: cell(row, "error") for name, row in rows[directory.name].items()}, file=sys.stderr, flush=True)
    for what in ("error", "order", "cost"):
        print(f"\n{what}\n{table(modules, rows, what)}")
    print("\n" + parts(modules, rows))
    if arguments.write:
        text = arguments.write.read_text()
        blocks = {what: table(modules, rows, what, "|") for what in ("error", "order", "cost")} | {"parts": parts(modules, rows)}
        for name, block in blocks.items():
            start, end = f"<!-- {name} -->\n", f"\n<!-- end of {name} -->"
            text = text[: text.index(start) + len(start)] + block + text[text.index(end) :]
        arguments.write.write_text(text)


if __name__ == "__main__":
    # The adapters import CannotExpress from here.
    sys.modules["run"] = sys.modules["__main__"]
    main()
