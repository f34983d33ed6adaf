//! FMI 3.0: what an FMU of arrays gives is what the FMU 2.0 of the same Trial gives, byte for byte.

use crate::common::{assert_code, decision_library, default_trial, done, err, joined, lemons, out, root};
use crate::coupling::controller::{DESCRIPTION, write_controller};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// `2.fmu` and `3.fmu` of the default Trial.
fn packed(at: &Path) {
    let trial = default_trial();
    let trial = trial.to_str().unwrap();
    done(at, &["pack", trial, "-o", "2.fmu"]);
    done(at, &["pack", "--fmi", "3", trial, "-o", "3.fmu"]);
}

/// The bytes of a file of each version, which are the same. `VERSION` in an argument is 2 or 3.
#[track_caller]
fn same(at: &Path, arguments: &[&str], file: &str) -> Vec<u8> {
    let [two, three] = ["2", "3"].map(|version| {
        let arguments: Vec<String> = arguments.iter().map(|word| word.replace("VERSION", version)).collect();
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        done(at, &arguments);
        fs::read(at.join(file.replace("VERSION", version))).unwrap()
    });
    assert!(two == three, "{arguments:?}: {file} differs");
    two
}

#[test]
fn a_crowd_of_arrays_runs_to_the_bytes_of_fmi_2() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    packed(at);
    let run = ["run", "VERSION.fmu", "--until", "0.6", "-o", "VERSION.csv"];
    let plain = same(at, &run, "VERSION.csv");
    assert_eq!(plain.iter().filter(|byte| **byte == b'\n').count(), 1 + 5 * 13);
    // Elements of arrays, whole arrays, and the one of two that comes later; pairs of materials have two elements.
    let pair = "contact.human_naked.human_naked.KineticFriction=0.1";
    let walls = "contact.concrete.human_naked.GammaNormal=900";
    let settings = [
        "agent[3].Mass=70",
        "agent[*].Mass=90",
        "agent[2].Mass=55",
        "material.concrete.YoungModulus=9e8",
        "TimeStepMechanical=1e-5",
        pair,
        walls,
        "agent[1].Velocity.x=0.5",
    ];
    let settings: Vec<&str> = settings.iter().flat_map(|setting| ["--set", setting]).collect();
    let set = same(at, &[&run[..], &settings].concat(), "VERSION.csv");
    assert!(set != plain);
    // A drive of some of the people only.
    fs::write(
        at.join("d.csv"),
        "t,agent,Fp.x,Fp.y,Mp\n0,3,-300,20,1\n0.5,3,-300,40,1\n0.1,1,50,0,0\n0.6,1,50,0,0\n",
    )
    .unwrap();
    let driven = same(at, &[&run[..], &["--drive", "d.csv", "--every", "2"]].concat(), "VERSION.csv");
    assert!(driven != plain && driven.len() < plain.len());
    // A saved run goes on where it was.
    let first = ["run", "3.fmu", "--until", "0.3", "-o", "goes_on.csv", "--state", "s.run"];
    done(at, &first);
    done(at, &["run", "3.fmu", "--until", "0.6", "-o", "goes_on_2.csv", "--resume", "s.run"]);
    assert!(joined(at, &["goes_on.csv", "goes_on_2.csv"]) == plain);
    let other = lemons(at, &["run", "2.fmu", "--until", "0.6", "-o", "x.csv", "--resume", "s.run"]);
    assert_code(&other, 1);
    assert!(err(&other).contains("the saved run is of \"LEMONS crowd mechanics\""), "{}", err(&other));
    same(at, &["plot", "VERSION.fmu", "--at", "0.5", "-o", "VERSION.svg"], "VERSION.svg");
}

#[test]
fn a_sweep_of_arrays_has_the_rows_of_fmi_2() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    packed(at);
    for version in [2, 3] {
        let text = format!(
            "fmu = \"{version}.fmu\"\nuntil = 0.5\n[parameters]\n\"agent[*].Mass\" = [60, 90]\n\
             \"contact.human_naked.human_naked.KineticFriction\" = [0.1, 0.4]\n\"agent[0].Mass\" = [50]\n[measures]\n\
             moved = {{ of = \"x\", take = \"change\", agents = [\"4\"] }}\nfast = {{ of = \"speed\", take = \"max\" }}\n\
             peak_squeeze = {{ of = \"peak_squeeze\", take = \"max\" }}\n\
             contacts = {{ of = \"agent_contacts\", take = \"max\" }}\n"
        );
        fs::write(at.join(format!("{version}.toml")), text).unwrap();
    }
    // The first line says of which FMU it is.
    let [two, three] = ["2", "3"].map(|version| {
        done(at, &["sweep", &format!("{version}.toml")]);
        let text = fs::read_to_string(at.join(format!("{version}.csv"))).unwrap();
        text.split_once('\n').unwrap().1.to_owned()
    });
    assert_eq!(two, three);
    assert_eq!(two.lines().count(), 1 + 4);
}

#[test]
fn trials_of_different_sizes_are_chosen() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let trials = [default_trial(), root().join("resources/Trial_door")];
    let [push, door] = trials.each_ref().map(|trial| trial.to_str().unwrap());
    done(at, &["pack", "--fmi", "3", push, door, "-o", "both.fmu"]);
    let run = ["--until", "0.2", "--set", "agent[29].Mass=80", "-o"];
    done(at, &[&["run", door, "--no-plan"][..], &run, &["door.csv"]].concat());
    // The sizes are chosen first.
    done(at, &[&["run", "both.fmu"][..], &run, &["both.csv", "--set", "Trial=Trial_door"]].concat());
    let read = |name: &str| fs::read(at.join(name)).unwrap();
    assert!(read("door.csv") == read("both.csv"));
    // A saved run knows which it was.
    let first = ["run", "both.fmu", "--set", "Trial=Trial_door", "--until", "0.1", "-o", "saved.csv"];
    done(at, &[&first[..], &["--set", "agent[29].Mass=80", "--state", "s.run"]].concat());
    done(at, &["run", "both.fmu", "--resume", "s.run", "--until", "0.2", "-o", "saved_2.csv"]);
    assert!(joined(at, &["saved.csv", "saved_2.csv"]) == read("both.csv"));
    let said = |settings: &[&str]| {
        let output = lemons(at, &[&["run", "both.fmu", "-o", "x.csv", "--set"][..], settings].concat());
        assert_code(&output, 1);
        err(&output)
    };
    assert!(said(&["agent[29].Mass=80"]).contains("the FMU has no variable \"agent[29].Mass\""));
    assert!(said(&["Agents=6"]).contains("Agents is 6, but what is loaded has 5"));
    let large = said(&["Agents=900000000"]);
    assert!(
        large.contains("Agents=900000000: the variables would have more than 8000000 values in all"),
        "{large}"
    );
    let negative = said(&["agent[2].Mass=-3"]);
    assert!(negative.contains("fmi3SetFloat64: Mass[2] = -3.0: must be positive"), "{negative}");
}

/// An FMU 2.0 that decides and a crowd of arrays: single values to elements.
#[test]
#[cfg(unix)]
fn a_controller_of_fmi_2_couples_with_arrays_to_the_last_bit() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    packed(at);
    write_controller(&at.join("controller.fmu"), DESCRIPTION, true);
    let mut structures = Vec::new();
    for version in ["2", "3"] {
        fs::copy(at.join(format!("{version}.fmu")), at.join("crowd.fmu")).unwrap();
        let said =
            out(&done(at, &["connect", "controller.fmu", "crowd.fmu", "-o", &format!("{version}.ssp")]));
        let expected = "controller -> crowd: 15 connected: agent[0].Fp.x, agent[0].Fp.y, agent[0].Mp, …";
        assert_eq!(said.lines().filter(|line| line.starts_with("controller -> ")).count(), 1);
        assert!(version == "3" || said.starts_with(expected), "{said}");
        let mut archive =
            zip::ZipArchive::new(fs::File::open(at.join(format!("{version}.ssp"))).unwrap()).unwrap();
        structures.push(std::io::read_to_string(archive.by_name("SystemStructure.ssd").unwrap()).unwrap());
    }
    assert!(structures[0].contains("version=\"1.0\"") && !structures[0].contains("Dimension"));
    let element =
        "startConnector=\"agent[4].Fp.y\" endElement=\"crowd\" endConnector=\"Fp\" endIndices=\"5 2\"";
    assert!(
        structures[1].contains("version=\"2.0\"") && structures[1].contains(element),
        "{}",
        structures[1]
    );
    for algorithm in ["jacobi", "gauss-seidel"] {
        let run = ["run", "VERSION.ssp", "--until", "0.5", "--step", "0.03125", "--algorithm", algorithm];
        let run = [&run[..], &["--set", "crowd.agent[1].Velocity.x=2", "--outputs", "VERSIONo.csv"]].concat();
        same(at, &[&run[..], &["-o", "VERSION.csv"]].concat(), "VERSION.csv");
        let outputs = ["2o.csv", "3o.csv"].map(|name| fs::read(at.join(name)).unwrap());
        assert!(outputs[0] == outputs[1]);
    }
}

#[test]
fn info_tells_arrays_by_their_elements() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    packed(at);
    let names = |version: &str| {
        let said = out(&done(at, &["info", &format!("{version}.fmu")]));
        let rows = said.lines().skip_while(|line| !line.starts_with("name"));
        let outputs = rows.filter(|line| line.contains(" output ") || line.contains(" input "));
        let mut rows: Vec<String> =
            outputs.map(|row| row.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
        rows.sort();
        (said, rows)
    };
    let ((_, two), (said, three)) = (names("2"), names("3"));
    assert_eq!(two, three, "the same inputs and outputs, with units and start values");
    assert!(said.contains("FMI 3.0   39 variables, token {"), "{said}");
    assert!(said.contains("values    20 inputs, 69 outputs,"), "{said}");
    let size = said.lines().find(|line| line.starts_with("Agents ")).unwrap();
    assert_eq!(size.split_whitespace().collect::<Vec<_>>(), ["Agents", "size", "Integer", "5"]);
}

/// Arrays to arrays, values to elements, and elements to values.
#[test]
fn decisions_and_crowds_of_both_versions_couple_to_the_same_bytes() {
    decision_library();
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let door = root().join("resources/Trial_door");
    let door = door.to_str().unwrap();
    for version in ["2", "3"] {
        done(at, &["decide", "--fmi", version, door, "-o", &format!("decision{version}.fmu")]);
        done(at, &["pack", "--fmi", version, door, "-o", &format!("crowd{version}.fmu")]);
    }
    let mut tables = Vec::new();
    for (decision, crowd) in [("2", "2"), ("2", "3"), ("3", "2"), ("3", "3")] {
        fs::copy(at.join(format!("decision{decision}.fmu")), at.join("decision.fmu")).unwrap();
        fs::copy(at.join(format!("crowd{crowd}.fmu")), at.join("crowd.fmu")).unwrap();
        let said = out(&done(at, &["connect", "decision.fmu", "crowd.fmu", "-o", "x.ssp"]));
        let whole = said.contains("decision -> crowd: 3 connected: Fp, Mp, Active");
        assert_eq!(whole, (decision, crowd) == ("3", "3"), "{said}");
        let run = ["run", "x.ssp", "--until", "0.5", "--algorithm", "gauss-seidel", "-o", "x.csv"];
        done(at, &[&run[..], &["--outputs", "wishes.csv"]].concat());
        tables.push(fs::read(at.join("x.csv")).unwrap());
    }
    assert!(tables.iter().all(|table| *table == tables[0]), "to the last bit");
    assert!(String::from_utf8_lossy(&tables[0]).contains("\n0.5,29,"));
}
