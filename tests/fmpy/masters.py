"""One co-simulation of FMUs, done by FMPy, libcosim or ecos.

All go the same way, Jacobi's: in initialization mode the outputs are passed on to the inputs they are connected with; then,
at each communication point, the inputs that the job sets are set, every FMU does the step, and the outputs are passed on.
FMPy's own `simulate_ssp` starts with zeros: `by_fmpy` is this algorithm in so many words. The others' are their fixed-step algorithms.

Each runs in a process of its own, `python masters.py TOOL`: a crash of a tool is not one of the test suite, and ecos
finds its libraries only through an LD_LIBRARY_PATH that is there from the start. The job comes in and the numbers go out as JSON,
whose shortest decimal digits are read back to the same double.
"""

import json
import os
import signal
import subprocess
import sys
import sysconfig
import warnings
from dataclasses import asdict, dataclass, field
from tempfile import TemporaryDirectory
from zipfile import ZipFile


@dataclass
class Job:
    """What to simulate; a variable is [instance, name]."""

    fmus: dict  # instance -> path
    steps: int
    watch: list  # variables to be seen after each step
    step: float = 1 / 16  # s: sums of it are exact, so that all tools have the same times
    nanoseconds: bool = False  # FMPy's times as libcosim's are, which counts nanoseconds: steps differ by rounding
    connections: list = field(default_factory=list)  # [output, input], all Real
    parameters: list = field(default_factory=list)  # [variable, value], all Real
    inputs: list = field(default_factory=list)  # for each step: [variable, value], all Real
    sequential: bool = False  # FMPy only: Gauss–Seidel, each FMU gets the newest outputs just before its step
    zeros: bool = False  # FMPy only: the first values of connected inputs are zero, as in its `simulate_ssp`
    ssp: str = ""  # libcosim and ecos: an archive that connects these FMUs, instead of the connections above
    resets: int = 0  # ecos only: how many times to reset and do it all again


def run(tool, job):
    """What is seen after each step, and what the tool said: warnings and errors, if there are any."""
    libraries = [os.path.join(sysconfig.get_path("data"), "lib"), os.environ.get("LD_LIBRARY_PATH")]
    environment = {**os.environ, "LD_LIBRARY_PATH": os.pathsep.join(filter(None, libraries))}
    command = [sys.executable, __file__, tool]

    def once():
        return subprocess.run(command, input=json.dumps(asdict(job)), capture_output=True, text=True, env=environment)

    done = once()
    if tool == "ecos" and done.returncode == -signal.SIGSEGV and done.stdout.endswith("]\n"):
        # One of some 300 runs of ecos crashed at the end of its process, after all numbers; two in turn fail.
        warnings.warn("ecos crashed after its last number", stacklevel=1)
        done = once()
    assert done.returncode == 0, f"{tool}: exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
    *said, seen = done.stdout.splitlines()
    return json.loads(seen), "\n".join([*said, *done.stderr.splitlines()])


def describe(job):
    """Of each [instance, name]: type and value reference."""
    from fmpy import read_model_description

    return {
        (instance, variable.name): (variable.type, variable.valueReference)
        for instance, path in job.fmus.items()
        for variable in read_model_description(path, validate=False).modelVariables
    }


def by_fmpy(job):
    from fmpy import extract, instantiate_fmu, read_model_description

    variables = describe(job)
    with TemporaryDirectory() as directory:
        fmus = {
            instance: instantiate_fmu(
                extract(path, os.path.join(directory, instance)), read_model_description(path, validate=False)
            )
            for instance, path in job.fmus.items()
        }

        def get(variable):
            kind, reference = variables[variable]
            return getattr(fmus[variable[0]], f"get{kind}")([reference])[0]

        def put(pairs):
            for variable, value in pairs:
                fmus[variable[0]].setReal([variables[variable][1]], [value])

        def pass_on():
            put([(sink, get(source)) for source, sink in job.connections])

        for fmu in fmus.values():
            fmu.setupExperiment(startTime=0.0)
        put(job.parameters)
        for fmu in fmus.values():
            fmu.enterInitializationMode()
        if not job.zeros:
            pass_on()
        for fmu in fmus.values():
            fmu.exitInitializationMode()
        if job.zeros:
            put([(sink, 0.0) for _, sink in job.connections])
        for k in range(job.steps):
            time, step = k * job.step, job.step
            if job.nanoseconds:
                time = k * round(job.step * 1e9) / 1e9
                step = (k + 1) * round(job.step * 1e9) / 1e9 - time
            if job.inputs:
                put(job.inputs[k])
            for instance, fmu in fmus.items():
                if job.sequential:
                    put([(sink, get(source)) for source, sink in job.connections if sink[0] == instance])
                fmu.doStep(time, step)
            if not job.sequential:
                pass_on()
            yield [get(variable) for variable in job.watch]
        for fmu in fmus.values():
            fmu.terminate()
            fmu.freeInstance()


def by_libcosim(job):
    from libcosimpy import CosimConstants
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.WARNING)
    variables = describe(job)
    nanoseconds = round(job.step * 1e9)
    assert nanoseconds / 1e9 == job.step, "libcosim's times are whole nanoseconds"
    with TemporaryDirectory() as directory:
        if job.ssp:
            with ZipFile(job.ssp) as archive:
                archive.extractall(directory)
            execution = CosimExecution.from_ssp_file(directory, nanoseconds)
            indices = {info.name.decode(): info.index for info in execution.slave_infos()}
        else:
            execution = CosimExecution.from_step_size(nanoseconds)
            slaves = {instance: CosimLocalSlave(path, instance) for instance, path in job.fmus.items()}
            indices = {instance: execution.add_local_slave(slave) for instance, slave in slaves.items()}

    def place(variable):
        return indices[variable[0]], variables[variable][1]

    for variable, value in job.parameters:
        assert execution.real_initial_value(*place(variable), value)
    for source, sink in job.connections:
        assert execution.connect_real_variables(*place(source), *place(sink)) == CosimConstants.success
    observer, manipulator = CosimObserver.create_last_value(), CosimManipulator.create_override()
    assert execution.add_observer(observer) and execution.add_manipulator(manipulator)

    def get(variable):
        index, reference = place(variable)
        kind = variables[variable][0]
        return getattr(observer, f"last_{kind.lower()}_values")(index, [reference])[0]

    for k in range(job.steps):
        for variable, value in job.inputs[k] if job.inputs else []:
            index, reference = place(variable)
            assert manipulator.slave_real_values(index, [reference], [value])
        assert execution.step(), execution.status()
        yield [get(variable) for variable in job.watch]


def by_ecos(job):
    from ecospy import EcosSimulation, EcosSimulationStructure
    from ecospy.lib import EcosLib

    EcosLib.set_log_level("warn")
    variables = describe(job)
    name = "::".join
    with EcosSimulationStructure() as structure:
        system = {"ssp_path": job.ssp} if job.ssp else {"structure": structure}
        for instance, path in job.fmus.items():
            structure.add_model(instance, path)
        for source, sink in job.connections:
            structure.make_real_connection(name(source), name(sink))
        structure.add_parameter_set("job", {name(variable): float(value) for variable, value in job.parameters})
        with EcosSimulation(**system, step_size=job.step) as simulation:
            for again in range(1 + job.resets):
                if again:
                    simulation.reset()
                simulation.init(parameter_set=None if job.ssp else "job")
                for k in range(job.steps):
                    for variable, value in job.inputs[k] if job.inputs else []:
                        simulation.set_real(name(variable), value)
                    simulation.step()
                    yield [
                        getattr(simulation, f"get_{variables[variable][0].lower()}".replace("boolean", "bool"))(name(variable))
                        for variable in job.watch
                    ]
            simulation.terminate()


def main(tool):
    job = Job(**json.load(sys.stdin))
    job.watch = [tuple(variable) for variable in job.watch]
    job.connections = [(tuple(source), tuple(sink)) for source, sink in job.connections]
    job.parameters = [(tuple(variable), value) for variable, value in job.parameters]
    job.inputs = [[(tuple(variable), value) for variable, value in pairs] for pairs in job.inputs]
    seen = list({"fmpy": by_fmpy, "libcosim": by_libcosim, "ecos": by_ecos}[tool](job))
    print(json.dumps(seen))


if __name__ == "__main__":
    main(sys.argv[1])
