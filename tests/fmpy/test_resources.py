"""Where the FMU was extracted."""

import pytest
from fmpy import extract

DIRECTORIES = ["two words", "hundred%20percent", "50%", "Zürich ü", "a+b&c#d?e"]


@pytest.mark.parametrize("name", DIRECTORIES)
def test_directory_names(instantiate, push_fmu, tmp_path, name):
    (tmp_path / "hundred percent").mkdir()
    crowd = instantiate(extract(push_fmu, tmp_path / name)).initialize()
    crowd.step(0.05)
    assert crowd["agent[1].Mass"] == 63.0
