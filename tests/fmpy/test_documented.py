"""docs/fmi.md says what the tests saw; conftest.py compares the rows of its table of tools."""

import xml.etree.ElementTree as ElementTree
import zipfile

import documented

# The attributes of <CoSimulation> that FMI 2.0 has, with their defaults.
FLAGS = {
    "needsExecutionTool": "false",
    "canHandleVariableCommunicationStepSize": "false",
    "canInterpolateInputs": "false",
    "maxOutputDerivativeOrder": "0",
    "canRunAsynchronuously": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canNotUseMemoryManagementFunctions": "false",
    "canGetAndSetFMUstate": "false",
    "canSerializeFMUstate": "false",
    "providesDirectionalDerivative": "false",
}
# Read by hand from BouncingBall/FMI2.xml, VanDerPol/FMI2.xml and Feedthrough/FMI2.xml of modelica/Reference-FMUs at commit
# 5fc4622d6fd0be90d017811f62e51bae60765d92: the same attributes in all three.
REFERENCE = {
    "canHandleVariableCommunicationStepSize": "true",
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
}


def flags(fmu, identifier):
    with zipfile.ZipFile(fmu) as archive, archive.open("modelDescription.xml") as description:
        flags = dict(ElementTree.parse(description).find("CoSimulation").items())
    assert flags.pop("modelIdentifier") == identifier
    assert flags.keys() <= FLAGS.keys()
    return flags


def test_flags(push_fmu, decide):
    columns = {
        "`CrowdMechanics`": flags(push_fmu, "CrowdMechanics"),
        "`Decision`": flags(decide(), "Decision"),
        "Reference-FMUs": REFERENCE,
    }
    rows = [
        [f"`{flag}`", *(column.get(flag, default) for column in columns.values())] for flag, default in FLAGS.items()
    ]
    documented.check("flags", ["attribute of `CoSimulation`", *columns], rows)
