"""docs/reference/decision.md, sweep.md and scenario.md against their readers: every key with its example, of other types, out of its
range; its default; and that the reader knows these keys and no others, which its message about an unknown key lists."""

import copy
import json
import re
import subprocess
import tomllib

import pages
import pytest
from lemons_fmu import _native
from crowd import REPOSITORY

DECISION, SWEEP, SCENARIO = (f"docs/reference/{name}.md" for name in ("decision", "sweep", "scenario"))
# Values of other types, by the first words of a type.
OTHER = {
    "number": ['"fast"', "true", "nan", "inf", "[1]"],
    "number or distribution": ['"fast"', "true", "nan", "[1]", "{ min = 1.0 }", "{ min = 2.0, max = 1.0 }"],
    "whole number": ['"7"', "1.5", "-1", "true"],
    "text": ["5", "true", "[]"],
    "path": ["5", "[]"],
    "list of tables": ["5", '"x"', "[5]"],
    "list of texts": ["5", '"0"', "[0]"],
    "list of lists": ["5", '"0"', "[0]", '["0", "1"]', "[[0, 1]]", '[["0"]]', '[["0", "0"]]', '[["0", "99"]]'],
    "list of pairs": ["5", "[]", "[5, 6]", "[[5]]", "[[6, 5]]", "[[1, 3], [2, 4]]", "[[-1, 2]]"],
    "list of numbers": ["5", "[]", '["x"]', "[-1]", "[0]"],
    "list of times": ["5", "[]", '["x"]', "[-1]"],
    "table": ["5", '"x"'],
    "tables": ["5", '"x"'],
    "two numbers": ["5", '"x"', "[1.0]", "[1.0, -1.0]"],
    "list of doors": ["5", '"x"', "[5]", "[[1.0, 2.0]]"],
    "switch": ["5", '"x"', "[]"],
    "place": ["5", '"x"', "[1.0]", "[1.0, 2.0, 3.0]"],
    "two places": ["[9, 1]", "[[9, 1]]", '"x"', "5"],
    "three places": ["[[9, 1], [9, 5]]", "[9, 1, 9, 5, 10, 5]", "5"],
}


def toml(value):
    """As an inline value."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(key)} = {toml(each)}" for key, each in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return repr(value) if isinstance(value, float) else json.dumps(value)


def rows(page):
    """Each row of the tables of keys: the heading, and the cells by the names of the columns."""
    found = []
    for heading, header, cells in pages.tables(page):
        if header[0] == "key":
            found += [(heading, dict(zip(header, row, strict=True))) for row in cells]
    return found


def code(cell):
    """What a cell has between backticks; None if it is no single piece of code."""
    match = re.fullmatch(r"`([^`]*)`", cell)
    return match[1] if match else None


def expected(said):
    """The names that a message lists."""
    return re.findall(r"`([^`]*)`", said.split("expected", 1)[1].split("\n")[0])


class Reader:
    """A command, and where in its file the keys of a heading stand."""

    def __init__(self, directory, lemons):
        self.directory = directory
        self.lemons = lemons
        self.count = 0

    def call(self, *words):
        done = subprocess.run([self.lemons, *words], cwd=self.directory, capture_output=True, text=True)
        assert done.returncode in (0, 1), done.stderr
        return done.returncode, done.stderr

    def refusal(self, content, named=True):
        """What is said of a file, whose name is in it; empty if it is taken."""
        self.count += 1
        lines = (f"{json.dumps(key)} = {toml(each)}\n" for key, each in content.items())
        (self.directory / "given.toml").write_text("".join(lines), encoding="utf-8")
        code, said = self.read()
        assert code == 0 or not named or "given.toml" in said, said
        return said if code else ""


class DecisionReader(Reader):
    def __init__(self, directory, lemons):
        super().__init__(directory, lemons)
        crowd = ["--number", "8", "--box", "8x6", "--door", "8,3,1", "--door", "0,3,1", "-o", "Trial"]
        assert self.call("crowd", *crowd)[0] == 0

    def read(self):
        return self.call("run", "Trial", "--decision", "given.toml", "--until", "0.01", "-o", "run.csv", "--force")

    def plan(self):
        """What it says of everybody."""
        return _native.Model.read(str(self.directory / "Trial"), str(self.directory / "given.toml")).planned()

    BASE = {
        "exits": [
            {"name": "door", "line": [[9.0, 1.5], [9.0, 4.5]]},
            {"name": "back", "polygon": [[-1, 0], [-1, 6], [-2, 6], [-2, 0]]},
        ],
        "motivation": [{"time": 5.0}],
        "goals": [{"name": "stage", "polygon": [[3, 4], [5, 4], [4, 5]]}],
        "waypoints": [{"x": 2.0, "y": 2.0}],
        "agents": {"0": {}},
    }
    # By the heading: where its keys stand in a file.
    PLACES = {
        "For everybody": lambda file: file,
        "A change of motivation": lambda file: file["motivation"][0],
        "A way-point": lambda file: file["waypoints"][0],
        "One of several ways": lambda file: file["ways"][0],
        "Groups": lambda file: file.setdefault("groups", {}),
        "queue": lambda file: file.setdefault("queue", {}),
        "An exit or a goal": lambda file: file["exits"][0],
        "A source": lambda file: file["sources"][0],
        "[agents.ID]": lambda file: file["agents"]["0"],
    }
    # Tables of constants, by the keys that choose them.
    CONSTANTS = {
        row["key"].strip("`"): re.findall(r"`([^`]*)`", row["type"])
        for heading, row in rows(DECISION)
        if heading == "For everybody" and row["key"] in ("`model`", "`balance`")
    }
    for _table in sum(CONSTANTS.values(), []):
        PLACES[_table] = lambda file, table=_table: file.setdefault(table, {})

    def base(self, heading, key):
        file = copy.deepcopy(self.BASE)
        for chooses, tables in self.CONSTANTS.items():
            for table in {heading, key} & {*tables}:
                file[chooses] = table
        for exit in file["exits"] if (heading, key) == ("An exit or a goal", "share") else []:
            exit["share"] = 1
        if heading == "A source":
            file["sources"] = [{"people": ["1"], "rate": 1.0}, {"name": "back", "people": ["7"], "rate": 1.0}]
        if key == "push_time":
            file["queue"] = {"push": 100.0}
        if key == "push_sd":
            file["push"] = 100.0
        if heading == "One of several ways" or key == "ways":
            del file["waypoints"]
            file["ways"] = [{"waypoints": [{"x": x, "y": 2.0}]} for x in (2.0, 3.0)]
        if (heading, key) == ("One of several ways", "share"):
            file["ways"][1]["share"] = 1
        if (heading, key) == ("Groups", "sizes"):
            file["groups"] = {"share": 1.0}
        if key == "time_factor":
            file["exit_choice"] = "time"
        if key == "polygon":
            file["exits"].reverse()
        if key in ("exits", "goals"):
            # Nobody names one of them.
            file["agents"] = {}
        return file


class SweepReader(Reader):
    def __init__(self, directory, lemons):
        super().__init__(directory, lemons)
        (directory / "Trial").symlink_to(REPOSITORY / "resources/Trial_door")
        assert self.call("pack", REPOSITORY / "resources/Trial_push", "-o", "push.fmu")[0] == 0
        (directory / "push.csv").write_text("t,agent,Fp.x,Fp.y,Mp\n0,0,100,0,0\n1,0,100,0,0\n")
        (directory / "walk.toml").write_bytes((REPOSITORY / "resources/Trial_door/decision.toml").read_bytes())
        (directory / "crowd.toml").write_text("number = 4\nbox = [5, 5]\n")
        (directory / "points.csv").write_text("TimeStepMechanical\n1e-4\n")
        (directory / "walkable.wkt").write_text("POLYGON ((-1 -1, 50 -1, 50 6, -1 6, -1 -1))")

    def read(self):
        return self.call("sweep", "given.toml", "-o", f"results {self.count}", "--threads", "1")

    BASE = {
        "trial": "Trial",
        "until": 0.1,
        "parameters": {"TimeStepMechanical": [1e-4]},
        "lines": {"door": [5, 2.05, 5, 2.95]},
        "areas": {"front": [3, 1, 5, 4]},
        "measures": {"far": {"of": "speed", "take": "max"}},
    }
    # By the heading and the key that needs another one.
    MEASURES = {
        "Of an output": {"of": "speed", "take": "max"},
        "Over a line": {"line": "door", "direction": "right", "number": "flow"},
        "In an area": {"area": "front", "number": "density", "take": "max"},
        "Squeeze": {"squeeze": "peak", "across": "max"},
        "Balance": {"balance": "falls", "across": "max"},
        "Breathing": {"breathing": "dose", "across": "max"},
        "Load": {"load": "load_step"},
    }
    NEEDED = {
        ("Of an output", "level"): {"take": "first_above", "across": "max"},
        ("Over a line", "width"): {"number": "specific_flow"},
        ("Squeeze", "over"): {"squeeze": "largest_mean"},
        ("Squeeze", "level"): {"squeeze": "time_above"},
        ("Squeeze", "by"): {"squeeze": "impulse"},
    }
    PLACES = dict.fromkeys(MEASURES, lambda file: file["measures"]["far"]) | {
        "The file": lambda file: file,
        "Parameters": lambda file: file["parameters"]["TimeStepMechanical"],
        "stop": lambda file: file["stop"],
    }

    def base(self, heading, key):
        file = copy.deepcopy(self.BASE)
        if heading == "Parameters":
            # Without a count, whole numbers: of threads.
            file["parameters"] = {"TimeStepMechanical": {"from": 1e-5, "to": 1e-4, "count": 2}}
        if heading == "stop":
            file["stop"] = {"of": "speed", "at_least": 1}
        if heading in self.MEASURES:
            file["measures"]["far"] = self.MEASURES[heading] | self.NEEDED.get((heading, key), {})
        if key == "drive":
            file["decision"] = False
        return file


class ScenarioReader(Reader):
    def __init__(self, directory, lemons):
        super().__init__(directory, lemons)
        corners = "".join(f'<Corner Coordinates="{x},{y}"/>' for x, y in [(0, 0), (5, 0), (5, 5), (0, 5), (0, 0)])
        (directory / "Geometry.xml").write_text(f'<Geometry><Wall Id="0" MaterialId="concrete">{corners}</Wall></Geometry>')
        # Two lines, on layers of these names.
        squares = {"walls": (0, 5), "tables": (1, 2)}
        (directory / "room.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [
            {"type": "Feature", "properties": {"layer": layer}, "geometry": {
                "type": "LineString", "coordinates": [[a, a], [b, a], [b, b], [a, b], [a, a]]}}
            for layer, (a, b) in squares.items()
        ]}))

    def read(self):
        return self.call("crowd", "--scenario", "given.toml", "-o", f"crowd {self.count}")

    BASE = {"number": 4, "box": [5.0, 5.0], "doors": [[5.0, 2.5, 1.0]], "leave": True}
    PUSH = {"at": [2.5, 2.5], "radius": 9.0, "direction": 0.0, "force": 100.0, "start": 0.0, "duration": 0.2}
    PLACES = {
        "The file": lambda file: file,
        "A region": lambda file: file["regions"][0],
        "A ground": lambda file: file["grounds"][0],
        "A link": lambda file: file["links"][0],
        "A source": lambda file: file["sources"][0],
        "How a drawing is read": lambda file: file["drawing"],
        "A push": lambda file: file["pushes"][0],
    }

    def base(self, heading, key):
        file = copy.deepcopy(self.BASE)
        if heading == "A region":
            # One of them takes the others.
            left, right = ([[a, 0], [b, 0], [b, 5], [a, 5]] for a, b in [(0, 3), (3, 5)])
            file["regions"] = [{"corners": left}, {"corners": right}]
        if heading == "A ground":
            fall = {"riser": 0.17, "tread": 0.29} if key in ("riser", "tread") else {"angle": 10.0}
            file["grounds"] = [{"corners": [[0, 0], [3, 0], [3, 5]], "downhill": 90.0, **fall}]
        if heading == "A link":
            file["links"] = [{"here": [[3, 0], [3, 2]], "there": [[9, 2], [9, 0]]}]
        if heading == "A source":
            source = {"line": [[1.0, 1.0], [1.0, 4.0]], "number": 2, "rate": 1.0}
            file["sources"] = [source, source | {"name": "back"}]
            file["decision"] = {"goals": [{"name": "stage", "line": [[3, 3], [4, 3]]}]}
            if key == "times":
                del source["number"]
        if heading == "A push":
            file["pushes"] = [dict(self.PUSH)]
        if key in ("box", "geometry", "room"):
            del file["doors"]
        if key in ("box", "geometry", "room", "doors"):
            del file["leave"]
        if key == "drawing" or heading == "How a drawing is read":
            del file["box"]
            file["geometry"] = "room.geojson"
            file["drawing"] = {"enclosed": True} if key in ("obstacles", "widest") else {}
        return file


READERS = {DECISION: DecisionReader, SWEEP: SweepReader, SCENARIO: ScenarioReader}
# Of these two, one must be there, and the other must not.
EITHER = [("number", "density"), ("rate", "every"), ("rate", "times"), ("every", "times"), ("number", "times"), ("line", "polygon"), ("trial", "fmu"), ("parameters", "table"), ("at_least", "at_most"), ("angle", "riser"), ("angle", "tread")]
NOT_BOTH = [*EITHER, ("exit", "goal"), ("trial", "population"), ("fmu", "population"), ("trial", "scenario"), ("box", "geometry"), ("box", "room")]


@pytest.fixture(scope="module")
def readers(lemons, tmp_path_factory):
    return {page: reader(tmp_path_factory.mktemp("toml"), lemons) for page, reader in READERS.items()}


EACH = [(page, pages.plain(heading), row) for page in READERS for heading, row in rows(page)]


@pytest.mark.parametrize(("page", "heading", "row"), EACH, ids=[f"{h} {r['key']}" for _, h, r in EACH])
def test_a_key_is_what_its_row_says(readers, page, heading, row):
    reader, key, missing = readers[page], code(row["key"]), row["if missing"]

    def refusal(value):
        # All exits have a share, or none.
        file = reader.base(heading, None if key == "share" and value is None else key)
        table = reader.PLACES[heading](file)
        if value is None:
            table.pop(key, None)
        else:
            for other in (other for pair in NOT_BOTH if key in pair for other in pair):
                table.pop(other, None)
            table[key] = tomllib.loads(f"x = {value}")["x"]
        return reader.refusal(file)

    example = code(row["example"])
    assert not refusal(example)
    either = next((pair for pair in EITHER if key in pair and f"without `{({*pair} - {key}).pop()}`" in missing), None)
    if missing.startswith("an error"):
        file = reader.base(heading, key)
        table = reader.PLACES[heading](file)
        for each in either or [key]:
            table.pop(each, None)
        if "with several agents" in missing:
            # One agent needs none; what is said of several does not name the file.
            assert not reader.refusal(file | {"measures": {"far": {**table, "agents": ["0"]}}})
            assert reader.refusal(file, named=False)
            return
        assert reader.refusal(file), f"{key} can be left out"
    elif key != "count":
        # Without a count, whole numbers are meant.
        assert not refusal(None), f"{key} must be there"
    default = code(missing)
    assert default is None or not refusal(default)
    if default is not None and page == DECISION:
        said = reader.plan()
        assert not refusal(None) and reader.plan() == said, f"{default} is not the default of {key}"
        # Another value is another plan.
        assert key == "seed" or not refusal(example) and reader.plan() != said, f"{key} changes nothing"
    kind = row["type"]
    if kind.startswith("`"):
        values = re.findall(r"`([^`]*)`", kind)
        for value in values:
            said = refusal(value if re.fullmatch(r"[-+.0-9e]+", value) else json.dumps(value))
            # One of them may need another key.
            assert not said or "needs" in said, said
        said = refusal('"nothing"')
        assert said and refusal("5")
        listed = expected(said) if "unknown variant" in said else values
        assert values == listed
    elif kind != "see below":
        # The longest one that fits.
        type_ = max((each for each in OTHER if kind.startswith(each)), key=len)
        for value in OTHER[type_]:
            if not ("`true`" in kind and value == "true"):
                assert refusal(value), f"{key} = {value} is taken, and is no {kind}"
    bounds = row.get("range", "any")
    if bounds == "≥ 0":
        assert refusal("-1") and (kind == "whole number" or refusal("-1e-9"))
        # All shares together must not be 0.
        assert not refusal("0")
    elif limits := re.fullmatch(r"(\S+) to (\S+)", bounds):
        low, high = map(float, limits.groups())
        assert refusal(str(low - 1)) and refusal(str(high * 1.1)) and not refusal("0" if low == 0 else code(row["example"]))
    elif bounds == "> 0" or "greater than 0" in row["meaning"]:
        assert refusal("0") and refusal("-1e-9")
    elif bounds == "at most 10 000":
        way = "[" + "{ x = 2, y = 2 }, " * 10_000 + "]"
        assert not refusal(way) and refusal(way[:-1] + "{ x = 2, y = 2 }]")
    elif bounds.startswith("the name of"):
        assert refusal('"nowhere"')
    elif bounds == "no other has it":
        assert refusal('"back"')
    elif kind.endswith("2 or more"):
        assert refusal("1") and not refusal("2")


HEADINGS = sorted({(page, heading) for page, heading, _ in EACH}, key=str)


@pytest.mark.parametrize(("page", "heading"), HEADINGS, ids=[heading for _, heading in HEADINGS])
def test_the_page_has_all_keys(readers, page, heading):
    reader = readers[page]
    file = reader.base(heading, None)
    reader.PLACES[heading](file)["nonsense"] = 1
    said = reader.refusal(file)
    if heading == "Parameters":
        # A range is one of several things; its message names its keys in braces.
        known = re.search(r"\{ ([^}]*) \}", said)[1].split(", ")
    else:
        assert "unknown field `nonsense`" in said, said
        known = expected(said)
    assert [code(row["key"]) for where, each, row in EACH if (where, each) == (page, heading)] == known


def test_what_a_measure_may_be_of_and_take(readers, lemons):
    reader = readers[SWEEP]

    def said(**changed):
        file = reader.base("Of an output", None)
        file["measures"]["far"].update(changed)
        return reader.refusal(file)

    tables = {header[0]: [code(row[0]) for row in cells] for _, header, cells in pages.tables(SWEEP)}
    assert tables["take"] == expected(said(take="nonsense"))
    for take in tables["take"]:
        level = {"level": 0.5} if take.startswith("first") else {}
        assert not said(take=take, across="max", **level)
    for of in tables["of"]:
        assert not said(of=of), of
    assert said(of="mood")
    # That there are no more of them the reader does not say, but the help does.
    help = subprocess.run([lemons, "sweep", "--help"], capture_output=True, text=True, check=True).stdout
    listed = re.search(r"\nof: (.*?)\. Or\s+the name", help, re.DOTALL)[1]
    listed = re.sub(r"\([^)]*\)|: (at communication points|of the whole step[^.]*)", "", " ".join(listed.split()))
    assert sorted(name for name in re.split(r"[,; ]+", listed) if name) == sorted(tables["of"])


@pytest.mark.parametrize("page", READERS)
def test_the_example_is_taken(readers, page):
    reader = readers[page]
    files = [tomllib.loads(block.text) for block in pages.blocks(page) if block.language == "toml"]
    assert len(files) == (2 if page == SWEEP else 1)
    for file in files:
        if page == SWEEP:
            file |= {"trial": str(REPOSITORY / file["trial"])} if "trial" in file else {}
            file["until"] = 0.1
        assert not reader.refusal(file)
    if page == DECISION:
        (most,) = map(int, re.findall(r"at most (\d+) exits and goals", pages.text_of(DECISION)))
        exit = {"line": file["exits"][0]["line"]}
        assert not reader.refusal({"exits": [exit] * most}) and reader.refusal({"exits": [exit] * (most + 1)})
