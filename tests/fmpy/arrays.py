"""FMUs of FMI 3.0 whose variables are set and got by name, arrays whole."""

from math import prod

from fmpy import extract, read_model_description
from fmpy.fmi3 import FMU3Slave


class Fmu:
    """An instance in Initialization Mode. `sizes` are structural parameters, `settings` others: by name."""

    def __init__(self, path, directory, sizes={}, settings={}):
        description = read_model_description(str(path))
        self.variables = {variable.name: variable for variable in description.modelVariables}
        self.sizes = {v.name: int(v.start) for v in description.modelVariables if v.causality == "structuralParameter"} | sizes
        self.slave = FMU3Slave(
            guid=description.guid,
            unzipDirectory=extract(str(path), directory),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=directory.name,
        )
        self.slave.instantiate()
        if sizes:
            self.slave.enterConfigurationMode()
            for name, size in sizes.items():
                self.put(name, [size])
            self.slave.exitConfigurationMode()
        for name, value in settings.items():
            self.put(name, [value])
        self.slave.enterInitializationMode(startTime=0.0)

    def get(self, name):
        """A list, also of a single value."""
        variable = self.variables[name]
        count = prod(int(d.start) if d.start else self.sizes[d.variable.name] for d in variable.dimensions)
        return getattr(self.slave, f"get{variable.type}")([variable.valueReference], nValues=count)

    def put(self, name, values):
        variable = self.variables[name]
        getattr(self.slave, f"set{variable.type}")([variable.valueReference], list(values))

    def free(self):
        self.slave.terminate()
        self.slave.freeInstance()
