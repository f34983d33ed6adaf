"""The house's own rules for Python: no modules of the package import each other in a circle."""

import ast
from collections import deque
from pathlib import Path

from crowd import REPOSITORY

PACKAGE = REPOSITORY / "python" / "src" / "lemons_fmu"


def imports(package: Path):
    """Who imports whom: (module, module, place). A name that a package passes on is followed to where it is from.

    Imports within functions count, and those for types only.
    """
    modules = {}
    for file in sorted(package.rglob("*.py")):
        name = (package.name, *file.relative_to(package).with_suffix("").parts)
        modules[name[:-1] if name[-1] == "__init__" else name] = file
    trees = {module: ast.parse(file.read_text(), str(file)) for module, file in modules.items()}

    def base(module, node):
        """What a `from` names before its names; none if that is another package's."""
        if node.level == 0:
            return tuple(node.module.split("."))
        around = module if modules[module].name == "__init__.py" else module[:-1]
        around = around[: len(around) + 1 - node.level]
        return around + tuple(node.module.split(".") if node.module else ())

    def named(module, name, asked=frozenset()):
        """The modules that a name in a module leads to."""
        if module + (name,) in modules:
            return {module + (name,)}
        found = {module}
        for node in ast.walk(trees[module]) if (module, name) not in asked else ():
            for alias in node.names if isinstance(node, ast.ImportFrom) else ():
                if (alias.asname or alias.name) == name and base(module, node) in modules:
                    found |= named(base(module, node), alias.name, asked | {(module, name)})
        return found

    for module, tree in trees.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                paths = [tuple(alias.name.split(".")) for alias in node.names]
                targets = {path[:k] for path in paths for k in range(1, len(path) + 1)} & modules.keys()
            elif isinstance(node, ast.ImportFrom) and base(module, node) in modules:
                targets = {base(module, node)}.union(*(named(base(module, node), alias.name) for alias in node.names))
            else:
                continue
            for target in sorted(targets):
                place = modules[module].relative_to(package.parent)
                yield module, target, f"{place}:{node.lineno}: {ast.unparse(node)}"


def circles(package: Path):
    """A shortest circle of modules beside each other, a package counted as one with all in it; what a module imports of
    the packages around it makes none."""
    levels = {}
    for module, target, place in imports(package):
        common = next((k for k, (a, b) in enumerate(zip(module, target)) if a != b), None)
        if common is not None:
            graph = levels.setdefault(module[:common], {})
            graph.setdefault(module[common], {}).setdefault(target[common], place)
    for level, graph in sorted(levels.items()):
        ways = [way for start in sorted(graph) if (way := way_back(graph, start))]
        if ways:
            way = min(ways, key=len)
            places = [graph[a][b] for a, b in zip(way, way[1:])]
            yield "\n    ".join([f"{'.'.join(level)}: {' -> '.join(way)}", *places])


def way_back(graph, start):
    """The shortest way from a module to itself."""
    waiting = deque([[start]])
    seen = set()
    while waiting:
        way = waiting.popleft()
        for target in graph.get(way[-1], ()):
            if target == start:
                return [*way, start]
            if target not in seen:
                seen.add(target)
                waiting.append([*way, target])
    return None


def test_no_module_is_in_a_circle():
    assert len({module for module, _, _ in imports(PACKAGE)}) > 5
    assert not list(circles(PACKAGE))


def made(directory, files):
    package = directory / "p"
    for name, text in {"__init__.py": "", **files}.items():
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_text(text)
    return list(circles(package))


def test_circles_are_found_with_their_lines(tmp_path):
    ring = "p: a -> b -> a\n    p/a.py:1: from .b import B\n    p/b.py:2: "
    for k, (text, told) in enumerate(
        {
            "class B:\n  from .a import A": "from .a import A",
            "def f():\n    from p import a": "from p import a",
            "def f():\n    import p.a": "import p.a",
            "if TYPE_CHECKING:\n    from . import a as c": "from . import a as c",
            # Passed on by the package.
            "\nfrom . import A": "from . import A",
            "\nfrom p import Renamed": "from p import Renamed",
        }.items()
    ):
        package = {"__init__.py": "from .a import A, A as Renamed", "a.py": "from .b import B", "b.py": text}
        assert made(tmp_path / str(k), package) == [ring + told]


def test_a_package_is_one_with_what_is_in_it(tmp_path):
    inside = {"q/__init__.py": "from .x import X", "q/x.py": "from . import Y\nfrom .. import Z\nimport os, numpy as np"}
    assert made(tmp_path / "parent", {"__init__.py": "from .q import X", **inside}) == []
    found = made(tmp_path / "outside", {**inside, "q/y.py": "from ..r import R", "r.py": "from .q import x"})
    assert found == ["p: q -> r -> q\n    p/q/y.py:1: from ..r import R\n    p/r.py:1: from .q import x"]
    found = made(tmp_path / "below", {"q/a.py": "from .b import B", "q/b.py": "from .c import C", "q/c.py": "import p.q.a"})
    assert [each.splitlines()[0] for each in found] == ["p.q: a -> b -> c -> a"]
