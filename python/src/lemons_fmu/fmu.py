"""Packed crowds."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from . import columns
from .arrays import of_materials
from .columns import INPUTS
from .drive import Drive, read
from .errors import FmuError
from .loaded import Loaded, Source, loaded

DRIVE_FILE = "drive.csv"


class Fmu(Loaded):
    """A packed crowd that this process has loaded, returned by `load`. Threads may share it."""

    def _take(self, description: Any) -> None:
        super()._take(description)
        #: Communication step of the default Trial [s].
        self.step: float = self.own_step or 0.05
        #: Name of the default Trial, which is simulated unless the parameter `Trial` names another.
        self.trial = str(next((v.start for v in description.modelVariables if v.name == "Trial"), ""))
        agents = 0
        while f"agent[{agents}].Mp" in self.variables:
            agents += 1
        if agents == 0:
            raise FmuError(f"{self.model_name!r} is not a packed crowd: it has no variable agent[0].Mp")
        #: Number of people.
        self.agents = agents
        self._of_materials: dict[str, list[str]] = {}
        #: Ids of the agents in Agents.xml.
        self.ids: list[str]
        if self.arrays:
            self.ids, materials = self._read_ids()
            self._of_materials = of_materials(self.arrays, materials)
        else:
            words = {v.name: v.description or "" for v in description.modelVariables}
            self.ids = [_id_in(words[f"agent[{i}].Mp"], i) for i in range(agents)]
        self.inputs = self.references(INPUTS)
        of_step = [quantity.variable for quantity in columns.OF_STEP]
        #: Whether the FMU has the outputs `columns.OF_STEP`.
        self.has_means = all(f"agent[0].{name}" in self.variables for name in of_step)
        reals = [quantity.variable for quantity in columns.REALS]
        self.reals = self.references(reals + of_step if self.has_means else reals)
        self.counts = self.references([quantity.variable for quantity in columns.CONTACTS])
        present = columns.ACTIVE.variable
        #: The inputs that say who is there; None in FMUs of earlier versions.
        self.active = self.references([present])[:, 0].copy() if f"agent[0].{present}" in self.variables else None
        self._drives: dict[str, Drive | None] = {}
        self._steps: dict[str, float] = {}

    def __repr__(self) -> str:
        return f"<Fmu {self.model_name!r}, {self.agents} agents, {self.sha256[:12]}>"

    def __reduce__(self) -> tuple[Any, tuple[bytes]]:
        return load, (self.data,)

    def _packed(self, trial: str, file: str) -> Path | None:
        """Returns the path of a file of a packed Trial, if it exists; for whoever keeps it unpacked."""
        path = self.directory / "resources" / trial / file
        return path if trial and Path(trial).name == trial and path.is_file() else None

    def has(self, trial: str) -> bool:
        """Returns whether a Trial with this name is packed."""
        with self.unpacked():
            return self._packed(trial, "Parameters.xml") is not None

    def directory_of(self, trial: str) -> Path:
        """Returns the directory of a packed Trial; for whoever keeps it unpacked.

        Raises:
            FmuError: there is none with this name.
        """
        path = self._packed(trial, "Parameters.xml")
        if path is None:
            raise FmuError(f"the FMU has no Trial {trial!r}")
        return path.parent

    def drive(self, trial: str) -> Drive | None:
        """Returns the drive in the drive.csv of a packed Trial; None if it has none.

        Raises:
            ValueError: the file is not valid.
        """
        with self._lock, self.unpacked():
            if trial not in self._drives:
                path = self._packed(trial, DRIVE_FILE)
                # The temporary path of the unpacked FMU would be of no use in messages.
                name = f"{trial}/{DRIVE_FILE} in the FMU"
                self._drives[trial] = None if path is None else read(path.read_bytes(), name, self.ids)
            return self._drives[trial]

    def step_of(self, trial: str) -> float:
        """Returns the communication step of a packed Trial [s]."""
        if trial == self.trial:
            return self.step
        with self._lock, self.unpacked():
            if trial not in self._steps:
                path = self._packed(trial, "Parameters.xml")
                times = None if path is None else ElementTree.parse(path).getroot().find("Times")
                if times is None:
                    raise FmuError(f"the FMU has no Trial {trial!r}")
                self._steps[trial] = float(times.attrib["TimeStep"])
            return self._steps[trial]

    def references(self, names: Sequence[str], agents: Sequence[int] | None = None) -> NDArray[np.uint32]:
        """Returns the value references of `agent[i].<name>`, as an array with one row for each agent."""
        chosen = range(self.agents) if agents is None else agents
        try:
            rows = [[self.variables[f"agent[{i}].{name}"].reference for name in names] for i in chosen]
        except KeyError as missing:
            raise FmuError(f"the FMU has no variable {missing}") from None
        return np.array(rows, dtype=np.uint32).reshape(len(rows), len(names))

    def expand(self, name: str) -> list[str]:
        return self._of_materials.get(name) or super().expand(name)

    def _read_ids(self) -> tuple[list[str], list[str]]:
        """Returns the Ids of agents and of materials, which an instance of FMI 3.0 tells."""
        instance = self.borrow()
        try:
            with instance.calls() as slave:
                slave.enterInitializationMode()
                ids = [
                    [str(text) for text in slave.getString([array.reference], array.size)]
                    for name in ("AgentId", "MaterialId")
                    for array in self.arrays
                    if array.name == name
                ]
        finally:
            self.give_back(instance)
        if len(ids) != 2 or len(ids[0]) != self.agents:
            raise FmuError(f"{self.model_name!r} is not a packed crowd: it has no Ids of its agents and materials")
        return ids[0], ids[1]


def _id_in(description: str, place: int) -> str:
    """Returns the Id in "agent Id 7: propulsion torque", or the index if the description has none."""
    head, colon, _ = description.rpartition(": ")
    return head.removeprefix("agent Id ") if colon and head.startswith("agent Id ") else str(place)


def load(fmu: Source | Fmu) -> Fmu:
    """Loads a packed crowd from a file or from its bytes. A process unpacks and loads the same bytes only once.

    Raises:
        FmuError: the file cannot be read, or is not a packed crowd.
    """
    if isinstance(fmu, Fmu):
        return fmu
    if not isinstance(fmu, bytes) and os.path.isdir(fmu):
        raise FmuError(
            f"{os.fspath(fmu)}: is a Trial's directory, not an FMU: Crowd, simulate and sweep take it as it is, and "
            "lemons_fmu.pack makes the FMU of its crowd"
        )
    return loaded(fmu, Fmu)
