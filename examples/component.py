"""Pushes agent 0 of a crowd, which is a WebAssembly component, for 0.6 s. Prints how far each person moves.

    python examples/component.py crowd.fmu

`component/build.sh crowd.wasm` and `lemons pack resources/Trial_push --fmi 3 --binary wasm32-wasip2=crowd.wasm -o
crowd.fmu` make such a crowd.fmu. Needs fmpy and wasmtime. FMI-LS-WASM, which says what a component is, is a draft.
"""

import argparse
import functools
import zipfile
from math import pi, sin

import wasmtime
import wasmtime.component
from fmpy import read_model_description

PLATFORM = "binaries/wasm32-wasip2"
INTERFACE = "fmi:fmi3/co-simulation@3.0.0"


@functools.cache
def compiled(code: bytes):
    """An engine and its machine code of a component: seconds, which further instances need not take."""
    engine = wasmtime.Engine()
    return engine, wasmtime.component.Component(engine, code)


class Component:
    """The component in an FMU: `crowd("do-step", t, dt, True)` calls a function of an instance.

    `log` gets its messages: the instance's name, the status, the category, the message.
    """

    def __init__(self, fmu: str, log=print, read_file=None):
        self.archive = zipfile.ZipFile(fmu)
        identifier = read_model_description(fmu).coSimulation.modelIdentifier
        engine, code = compiled(self.archive.read(f"{PLATFORM}/{identifier}.wasm"))
        self.imports = list(code.type.imports(engine))
        self.store = wasmtime.Store(engine)
        linker = wasmtime.component.Linker(engine)
        functions = {
            "types": {},
            "callbacks": {
                "log-message": lambda _, *message: log(*message),
                "clock-update": lambda _: None,
                "lock-preemption": lambda _: None,
                "unlock-preemption": lambda _: None,
            },
            "resource-dir-callbacks": {"read-file": read_file or self.read_file},
        }
        with linker.root() as root:
            for name, functions_of in functions.items():
                with root.add_instance(f"fmi:fmi3/{name}@3.0.0") as interface:
                    for function, body in functions_of.items():
                        interface.add_func(function, body)
        self.component = linker.instantiate(self.store, code)
        self.interface = self.component.get_export_index(self.store, INTERFACE)
        self.instance = None

    def read_file(self, _, path: str):
        """Returns the content of a file of `resources`, or as a text why there is none."""
        try:
            return self.archive.read(f"resources/{path}")
        except KeyError as missing:
            return str(missing)

    def function(self, name: str):
        place = self.component.get_export_index(self.store, name, self.interface)
        return self.component.get_func(self.store, place)

    def call(self, name: str, *arguments):
        function = self.function(name)
        result = function(self.store, *arguments)
        function.post_return(self.store)
        return result

    def instantiate(self, name: str, token: str, logging_on=False, event_mode_used=False) -> bool:
        create = "[static]co-simulation-instance.instantiate-co-simulation"
        self.instance = self.call(create, name, token, False, logging_on, event_mode_used, False, [])
        return self.instance is not None

    def __call__(self, name: str, *arguments):
        return self.call(f"[method]co-simulation-instance.{name}", self.instance, *arguments)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("crowd", metavar="crowd.fmu", help="made by `lemons pack`")
    fmu = parser.parse_args().crowd
    description = read_model_description(fmu)
    reference = {variable.name: variable.valueReference for variable in description.modelVariables}

    crowd = Component(fmu)
    if not crowd.instantiate("crowd", description.instantiationToken):
        raise SystemExit(1)
    crowd("enter-initialization-mode", None, 0.0, None)
    crowd("exit-initialization-mode")
    [people] = crowd("get-uint64", [reference["Agents"]])

    start = crowd("get-float64", [reference["Position"]])
    peak, duration, step, end = 1200.0, 0.6, 0.02, 2.0  # N, s, s, s
    force = [0.0] * (2 * people)
    for k in range(round(end / step)):
        t = k * step
        force[0] = peak * sin(pi * t / duration) if t < duration else 0.0
        crowd("set-float64", [reference["Fp"]], force)
        crowd("do-step", t, step, True)
    moved = [now - before for now, before in zip(crowd("get-float64", [reference["Position"]]), start)]
    for agent in range(people):
        print(f"agent {agent}: {moved[2 * agent]:+.3f} m, {moved[2 * agent + 1]:+.3f} m")


if __name__ == "__main__":
    main()
