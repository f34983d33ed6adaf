"""The arrays of an FMI 3.0 crowd, value by value: the names that FMI 2.0 gives the same values."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

#: The structural parameter that is the number of people.
AGENTS = "Agents"
_AXES = ("x", "y")
_TOTAL = "Total"


@dataclass(frozen=True)
class Array:
    """A variable of FMI 3.0: a single value if its shape is empty."""

    name: str
    reference: int
    shape: tuple[int, ...]
    of_agents: bool
    #: The place of its first value among those of all variables; those of an array follow in row-major order.
    begin: int

    @property
    def size(self) -> int:
        return int(np.prod(self.shape, dtype=np.int64))


def names(array: Array, arrays: Mapping[str, Array]) -> Iterator[str]:
    """Yields the names of the values of an array, as `lemons` has them: those of FMI 2.0 for people, else `Name[i,j]` with
    indices from 1."""
    if not array.shape:
        of = array.name.removeprefix(_TOTAL)
        yield of if of in arrays and of != array.name and arrays[of].of_agents else array.name
        return
    for indices in itertools.product(*map(range, array.shape)):
        if not array.of_agents:
            yield f"{array.name}[{_written(indices)}]"
        elif len(indices) == 1:
            yield f"agent[{indices[0]}].{array.name}"
        elif array.shape[1:] == (len(_AXES),):
            yield f"agent[{indices[0]}].{array.name}.{_AXES[indices[1]]}"
        else:
            yield f"agent[{indices[0]}].{array.name}[{_written(indices[1:])}]"


def _written(indices: Sequence[int]) -> str:
    return ",".join(str(index + 1) for index in indices)


@dataclass(frozen=True)
class Plan:
    """How values are read or set by one call of FMI 3.0."""

    #: Value references of the variables of the call.
    references: NDArray[np.uint32]
    #: The number of values of the call.
    size: int
    #: Of each value its place among those of the call; None if they are the same.
    places: NDArray[np.intp] | None
    #: Whether each value of the call is among them.
    whole: bool


def plan(keys: NDArray[np.uint32], arrays: Sequence[Array]) -> Plan:
    """Returns how the values at these places among those of all variables are read. `arrays` are in order of their places."""
    flat = keys.ravel().astype(np.intp)
    begins = np.array([array.begin for array in arrays], dtype=np.intp)
    of = np.searchsorted(begins, flat, side="right") - 1
    used, first = np.unique(of, return_index=True)
    used = used[np.argsort(first)]
    sizes = np.array([arrays[k].size for k in used], dtype=np.intp)
    starts = np.zeros(len(arrays), dtype=np.intp)
    starts[used] = np.cumsum(sizes) - sizes
    places = starts[of] + flat - begins[of]
    size = int(sizes.sum())
    seen = np.zeros(size, dtype=bool)
    seen[places] = True
    same = len(places) == size and bool((places == np.arange(size)).all())
    references = np.array([arrays[k].reference for k in used], dtype=np.uint32)
    return Plan(references, size, None if same else places, bool(seen.all()))


def quoted(text: str) -> str:
    """Returns an Id as a part of a name of FMI 2.0: itself if it is a plain identifier, else in quotes and with escapes."""
    plain = text.isascii() and text.replace("_", "a").isalnum() and not text[0].isdigit()
    if plain:
        return text
    parts = []
    for byte in text.encode():
        character = chr(byte)
        if character in "'\"\\?":
            parts.append(f"\\{character}")
        elif character == "%" or not " " <= character <= "~" or character == "`":
            parts.append(f"%{byte:02X}")
        else:
            parts.append(character)
    return f"'{''.join(parts)}'"


def of_materials(arrays: Sequence[Array], ids: Sequence[str]) -> dict[str, list[str]]:
    """Returns the names of FMI 2.0 for the quantities of materials, which contain Ids, and the names of their values here. A
    quantity of two materials has two values."""
    count, found = len(ids), {}
    words = [quoted(text) for text in ids]
    for array in arrays:
        if array.of_agents:
            continue
        if array.shape == (count,) and array.name != "MaterialId":
            found.update({f"material.{word}.{array.name}": [f"{array.name}[{k + 1}]"] for k, word in enumerate(words)})
        elif array.shape == (count, count):
            for (i, one), (k, other) in itertools.product(enumerate(words), repeat=2):
                places = dict.fromkeys([(i, k), (k, i)])
                found[f"contact.{one}.{other}.{array.name}"] = [f"{array.name}[{a + 1},{b + 1}]" for a, b in places]
    return found
