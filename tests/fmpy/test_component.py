"""The crowd as a WebAssembly component (FMI-LS-WASM, a draft), run by wasmtime: the bits of the shared library."""

import importlib.util
import os
import re
import subprocess
import zipfile
from pathlib import Path

import arrays
import fmpy
import numpy as np
import pytest
from built import BUILT, TARGET
from crowd import REPOSITORY, TRIAL_DOOR, TRIAL_PUSH
from fmpy import read_model_description
from fmpy.validation import validate_fmu
from lxml import etree

pytestmark = pytest.mark.long

OK, PEAK, STEP = "ok", 1200.0, 0.02  # N, s
PLATFORM = "wasm32-wasip2"
# All that the crowd computes or is told, as Float64 and Int32.
NUMBERS = ["Position", "Theta", "Velocity", "Omega", "NormalForce", "PeakNormalForce"]
COUNTS = ["AgentContacts", "WallContacts"]

spec = importlib.util.spec_from_file_location("component", REPOSITORY / "examples" / "component.py")
assert spec and spec.loader
component = importlib.util.module_from_spec(spec)
spec.loader.exec_module(component)


def build(path: Path, *trial: Path) -> Path:
    """A component, if there is a compiler for it that is new enough."""
    asked = 'source packaging/lib.sh && choose_compiler wasm32-unknown-unknown && "$RUSTC" --version'
    compiler = subprocess.run(["bash", "-c", asked], cwd=REPOSITORY, capture_output=True, text=True)
    version = re.search(r"rustc 1\.(\d+)", compiler.stdout)
    if not version or int(version[1]) < 89:
        pytest.skip(f"no rustc >= 1.89 for wasm32: {compiler.stdout}{compiler.stderr}")
    # Without optimisation across crates, which takes minutes twice: the bits do not depend on it.
    quick = {"CARGO_PROFILE_DIST_LTO": "off", "CARGO_PROFILE_DIST_CODEGEN_UNITS": "16"}
    environment = {**os.environ, "CARGO_TARGET_DIR": str(TARGET), **quick}
    command = [REPOSITORY / "component" / "build.sh", path, *trial]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return path


@pytest.fixture(scope="session")
def built(tmp_path_factory):
    """The component that reads the Trials of its FMU."""
    return build(tmp_path_factory.mktemp("component") / "crowd.wasm")


@pytest.fixture
def fmu(pack, built):
    """The FMU with a shared library and a component, of two Trials."""
    library = f"linux64={BUILT / 'libcrowd_mechanics.so'}"
    options = ["--fmi", "3", "--binary", library, "--binary", f"{PLATFORM}={built}"]
    return pack(TRIAL_PUSH, TRIAL_DOOR, options=options)


class Crowd:
    """An instance by the names of variables; `said` is what it told."""

    def __init__(self, fmu, **options):
        self.said = []
        self.description = read_model_description(str(fmu))
        self.references = {variable.name: variable.valueReference for variable in self.description.modelVariables}
        self.call = component.Component(str(fmu), log=lambda *words: self.said.append(words), **options)

    def instantiate(self, **options):
        return self.call.instantiate("crowd", self.description.instantiationToken, **options)

    def initialize(self):
        assert self.instantiate()
        assert self.call("enter-initialization-mode", None, 0.0, None) == OK
        assert self.call("exit-initialization-mode") == OK
        return self

    def get(self, name, of="float64"):
        return self.call(f"get-{of}", [self.references[name]])

    def set(self, name, values, of="float64"):
        return self.call(f"set-{of}", [self.references[name]], values)

    def step(self, k):
        """Step k of a push of the first person."""
        force = np.zeros((self.get("Agents", "uint64")[0], 2))
        force[0] = PEAK * np.sin(0.1 * k), 100.0
        assert self.set("Fp", [float(value) for value in force.flat]) == OK
        done = self.call("do-step", k * STEP, STEP, True)
        reached = getattr(done, "last-successful-time")
        assert (reached, getattr(done, "early-return")) == (k * STEP + STEP, False)

    def look(self):
        return [self.get(name) for name in NUMBERS], [self.get(name, "int32") for name in COUNTS]


class Native(arrays.Fmu):
    """The same of the shared library."""

    def step(self, k):
        force = np.zeros((self.get("Agents")[0], 2))
        force[0] = PEAK * np.sin(0.1 * k), 100.0
        self.put("Fp", force.flat)
        self.slave.doStep(k * STEP, STEP)

    def look(self):
        return [self.get(name) for name in NUMBERS], [self.get(name) for name in COUNTS]


@pytest.mark.parametrize("trial", [TRIAL_PUSH, TRIAL_DOOR], ids=lambda trial: trial.name)
def test_same_bits(pack, built, tmp_path, trial, row):
    library = f"linux64={BUILT / 'libcrowd_mechanics.so'}"
    fmu = pack(trial, options=["--fmi", "3", "--binary", library, "--binary", f"{PLATFORM}={built}"])
    native, crowd = Native(fmu, tmp_path / "unpacked"), Crowd(fmu).initialize()
    native.slave.exitInitializationMode()
    peak = 0.0
    for k in range(60):
        native.step(k)
        crowd.step(k)
        assert repr(crowd.look()) == repr(native.look())
        peak = max(peak, *crowd.get("PeakNormalForce"))
    assert peak > 100.0
    assert crowd.call.imports == [f"fmi:fmi3/{name}@3.0.0" for name in ("types", "callbacks", "resource-dir-callbacks")]
    native.free()
    row("wasmtime", "FMI-LS-WASM (draft): the crowd as a component, 60 steps with inputs", "same bits as the shared library")


def test_built_in(pack, tmp_path):
    """A component with its Trial built in reads nothing."""
    own = build(tmp_path / "own.wasm", TRIAL_PUSH)
    crowd = Crowd(pack(TRIAL_PUSH, options=["--fmi", "3", "--binary", f"{PLATFORM}={own}"]), read_file=None)
    assert crowd.call.imports == ["fmi:fmi3/types@3.0.0", "fmi:fmi3/callbacks@3.0.0"]
    crowd.initialize().step(0)
    assert len(crowd.get("Theta")) == 5


def test_states(fmu, tmp_path, row):
    """A state is the same bytes as those of the shared library, and goes from either to the other."""
    native, crowd, other = Native(fmu, tmp_path / "unpacked"), Crowd(fmu).initialize(), Crowd(fmu).initialize()
    native.slave.exitInitializationMode()
    for k in range(10):
        native.step(k)
        crowd.step(k)
    state = native.slave.getFMUState()
    saved = bytes(native.slave.serializeFMUState(state))
    assert bytes(crowd.call("get-fmu-state")) == saved
    assert other.call("set-fmu-state", saved) == OK
    for k in range(10, 20):
        native.step(k)
        other.step(k)
    assert repr(other.look()) == repr(native.look())

    own = bytes(other.call("get-fmu-state"))
    for place in (0, 20, len(saved) // 2, len(saved) - 1):
        damaged = bytearray(saved)
        damaged[place] ^= 1
        assert other.call("set-fmu-state", bytes(damaged)) == "error"
        assert "damaged" in other.said[-1][3] or "another model" in other.said[-1][3]
    assert bytes(other.call("get-fmu-state")) == own
    native.slave.freeFMUState(state)
    native.free()
    row("wasmtime", "FMI-LS-WASM (draft): a state from the shared library to a component", "the same bytes, the same bits after it")


def test_other_trial(fmu, pack):
    """The importer reads the other Trial of the FMU; sizes are set in Configuration Mode."""
    crowd = Crowd(fmu)
    assert crowd.instantiate()
    assert crowd.call("enter-configuration-mode") == OK
    variables = read_model_description(str(pack(TRIAL_DOOR, options=["--fmi", "3"]))).modelVariables
    for variable in [variable for variable in variables if variable.causality == "structuralParameter"]:
        assert crowd.set(variable.name, [int(variable.start)], "uint64") == OK
    assert crowd.call("exit-configuration-mode") == OK
    assert crowd.set("Trial", ["Trial_door"], "string") == OK
    assert crowd.get("Trial", "string") == ["Trial_door"]
    assert crowd.call("enter-initialization-mode", 1e-4, 0.0, 1.0) == OK
    assert crowd.call("exit-initialization-mode") == OK, crowd.said
    assert len(crowd.get("Theta")) == 30
    assert crowd.call("reset") == OK
    assert crowd.get("Trial", "string") == ["Trial_push"]


def test_refusals(fmu):
    """Each refusal is said by the importer's function, and nothing else happens."""
    crowd = Crowd(fmu)

    def says(result, words, wanted="error"):
        assert result == wanted
        name, status, category, message = crowd.said.pop()
        assert (name, status, category) == ("crowd", wanted, "logStatusError")
        assert words in message, message

    assert not crowd.call.instantiate("crowd", "another")
    says("error", "fmi3InstantiateCoSimulation: the instantiationToken")
    assert not crowd.instantiate(event_mode_used=True)
    says("error", "eventModeUsed: hasEventMode is false")
    assert crowd.instantiate()
    force = crowd.references["NormalForce"]
    dependencies = crowd.call("get-variable-dependencies", force)
    assert crowd.call("get-number-of-variable-dependencies", force) == len(dependencies) > 0
    assert {(of.kind, getattr(of, "dependent-value-reference")) for of in dependencies} == {("dependent", force)}
    crowd.initialize()
    says(crowd.call("do-step", 1.0, STEP, True), "fmi3DoStep: the communication point 1.0 s is not")
    says(crowd.call("enter-event-mode"), "fmi3EnterEventMode: this FMU is for co-simulation without events")
    says(crowd.call("get-float32", [3]), "fmi3GetFloat32: no variable of type Float32")
    says(crowd.call("get-float64", [999]), "no variable of type Float64 has the value reference 999")
    says(crowd.set("Fp", [0.0] * 9), "9 values for variables of 10 elements")
    says(crowd.set("Fp", [float("nan")] * 10), "Fp[0] = NaN: must be", "discard")
    says(crowd.call("get-directional-derivative", [3], [4], [1.0]), "providesDirectionalDerivatives")
    says(crowd.call("set-debug-logging", True, ["log"]), 'no log category "log"')
    assert crowd.call("set-debug-logging", True, []) == OK
    assert crowd.call("terminate") == OK
    says(crowd.call("do-step", 0.0, STEP, True), "not allowed in the state Terminated")
    assert not crowd.said


@pytest.mark.parametrize(
    "files, words",
    [
        (lambda path: "the importer has no files", 'which contains no directory with a Trial'),
        (lambda path: b"..\n", '"trials.txt" line 1: ".." is not a plain directory name'),
        (lambda path: b"\xff", "it is not UTF-8 text"),
        (lambda path: b"Here\n" if path == "trials.txt" else "gone", "Here/Parameters.xml: cannot be read: gone"),
        (lambda path: b"Here\n" if path == "trials.txt" else b"<a>", "Here/Parameters.xml:1"),
    ],
)
def test_hostile_files(fmu, files, words):
    """What an importer answers for files is checked as files are."""
    crowd = Crowd(fmu, read_file=lambda _, path: files(path))
    assert not crowd.instantiate()
    assert words in crowd.said[-1][3], crowd.said


def test_archive(fmu, built, lemons, tmp_path):
    """The FMU is valid, its manifest too; FMI 2.0 has no such platform, and other files are no components."""
    assert validate_fmu(str(fmu)) == []
    with zipfile.ZipFile(fmu) as archive:
        manifest = etree.fromstring(archive.read("extra/org.modelica.fmi-ls-wasm/manifest.xml"))
    schema = etree.parse(Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3LayeredStandardManifest.xsd")
    [namespace] = schema.getroot().xpath("@targetNamespace")
    names = schema.getroot().xpath("/*/*[local-name()='attribute']/@name")
    assert set(manifest.keys()) == {f"{{{namespace}}}{name}" for name in names}
    assert manifest.get(f"{{{namespace}}}fmi-ls-name") == "org.modelica.fmi-ls-wasm"

    def refused(*options):
        command = [lemons, "pack", TRIAL_PUSH, "-o", tmp_path / "not.fmu", *options]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode != 0 and not (tmp_path / "not.fmu").exists()
        return done.stderr

    assert f'"{PLATFORM}" is not a platform of this version of FMI' in refused("--binary", f"{PLATFORM}={built}")
    text = tmp_path / "text.wasm"
    text.write_text("no component")
    said = refused("--fmi", "3", "--binary", f"{PLATFORM}={text}")
    assert "is a text file, not a WebAssembly component" in said
    assert "is a WebAssembly component, not a shared library" in refused("--binary", f"linux64={built}")

    only = tmp_path / "only.fmu"
    subprocess.run([lemons, "pack", TRIAL_PUSH, "--fmi", "3", "--binary", f"{PLATFORM}={built}", "-o", only], check=True)
    ran = subprocess.run([lemons, "run", only], capture_output=True, text=True)
    assert ran.returncode != 0 and PLATFORM in ran.stderr, ran.stderr


def test_example(fmu, capsys, monkeypatch):
    monkeypatch.setattr("sys.argv", ["component.py", str(fmu)])
    component.main()
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 5 and lines[0].startswith("agent 0: +0.4")


def test_one_thread(pack, built, shared):
    """More threads are refused in words; a thousand people are computed by one."""
    crowd = Crowd(pack(shared / "data/crowds/dense_1000", options=["--fmi", "3", "--binary", f"{PLATFORM}={built}"]))
    assert crowd.instantiate()
    assert crowd.set("Threads", [2], "int32") == OK
    assert crowd.call("enter-initialization-mode", None, 0.0, None) == OK
    assert crowd.call("exit-initialization-mode") == "discard"
    assert "fmi3ExitInitializationMode: Threads: cannot start 2 threads" in crowd.said[-1][3]
    assert crowd.set("Threads", [1], "int32") == OK
    assert crowd.call("exit-initialization-mode") == OK
    crowd.step(0)
    assert sum(crowd.get("AgentContacts", "int32")) > 500


def test_versions():
    """The component is built from the versions of the shared library: the bits depend on them."""

    def versions(path):
        packages = re.findall(r'name = "(.*)"\nversion = "(.*)"\nsource', (REPOSITORY / path).read_text())
        return {name: {version for other, version in packages if other == name} for name, _ in packages}

    own, shared = versions("component/Cargo.lock"), versions("Cargo.lock")
    for name in ("csv", "libm", "postcard", "rayon", "rayon-core", "roxmltree", "uuid"):
        assert own[name] == shared[name]
