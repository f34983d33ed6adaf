"""The examples of docs/reference/trial.md. A test of crates/core holds its tables to the readers."""

import pages
from crowd import TRIAL_PUSH

FILES = ["Parameters.xml", "static/Materials.xml", "static/Geometry.xml", "static/Agents.xml", "dynamic/AgentDynamics.xml"]


def test_the_examples_are_of_the_trial():
    """Each line of an example is one of the file; the last one is of a run, which has contacts."""
    *examples, _ = (block for block in pages.blocks("docs/reference/trial.md") if block.language == "xml")
    for block, name in zip(examples, FILES, strict=True):
        lines = [line.strip() for line in (TRIAL_PUSH / name).read_text(encoding="utf-8").splitlines()]
        missing = [line for line in block.text.splitlines() if line.strip() not in lines]
        assert not missing, f"{block.place}: {name} of resources/Trial_push has no line {missing[0]}"
