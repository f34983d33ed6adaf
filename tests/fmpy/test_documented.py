"""docs/fmi.md says what the tests saw."""

import xml.etree.ElementTree as ElementTree

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
# BouncingBall/FMI2.xml, VanDerPol/FMI2.xml and Feedthrough/FMI2.xml of modelica/Reference-FMUs at commit 5fc4622d6fd0:
# the same attributes in all three.
REFERENCE = {
    "canHandleVariableCommunicationStepSize": "true",
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
}


def test_flags(push_directory):
    ours = dict(ElementTree.parse(push_directory / "modelDescription.xml").find("CoSimulation").items())
    assert ours.pop("modelIdentifier") == "CrowdMechanics"
    assert ours.keys() <= FLAGS.keys()
    rows = [[f"`{flag}`", ours.get(flag, default), REFERENCE.get(flag, default)] for flag, default in FLAGS.items()]
    documented.check("flags", ["attribute of `CoSimulation`", "`CrowdMechanics`", "Reference-FMUs"], rows)


def test_rows(rows_of_tools):
    rows, whole = rows_of_tools
    documented.check("tools", ["tool", "tried", "result", "test in `tests/fmpy`"], rows, whole)
