//! `lemons connect` and `lemons run FILE.ssp` as their users meet them.

#[path = "../../../../tests/coupling/controller.rs"]
pub mod controller;

use controller::{DESCRIPTION, write_controller, write_zip};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

fn lemons(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lemons")).args(arguments).current_dir(directory).output().unwrap()
}

fn out(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn err(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stdout));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!said.contains("panicked"), "{said}");
    said
}

/// `crowd.fmu` of the default Trial, and `controller.fmu`.
fn fmus(binary: bool) -> TempDir {
    let directory = TempDir::new().unwrap();
    let trial = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../resources/Trial_push");
    out(&lemons(directory.path(), &["pack", trial.to_str().unwrap(), "-o", "crowd.fmu"]));
    write_controller(&directory.path().join("controller.fmu"), DESCRIPTION, binary);
    directory
}

const CONNECT: [&str; 5] = ["connect", "controller.fmu", "crowd.fmu", "-o", "coupled.ssp"];

/// The crowd has a drive, and the controller feeds Fp and Mp.
const LOST: &str = "note: crowd: the drive.csv in it does not act on people whose Fp or Mp is connected; of a Trial with \
                    decision.toml, lemons run TRIAL adds it to the forces with which they walk\n";

#[test]
fn connect_says_what_it_did_and_writes_the_same_bytes() {
    let directory = fmus(false);
    let at = directory.path();
    let output = lemons(at, &CONNECT);
    let said = out(&output);
    let expected = [
        "controller -> crowd: 15 connected: agent[0].Fp.x, agent[0].Fp.y, agent[0].Mp, …",
        "crowd -> controller: 15 connected: agent[0].Position.x, agent[0].Position.y, …",
    ];
    assert_eq!(said.lines().take(2).collect::<Vec<_>>(), expected);
    let warning = "warning: controller: 4 inputs not connected: real.in, integer.in, boolean.in, …\n";
    assert_eq!(String::from_utf8_lossy(&output.stderr), format!("{warning}{LOST}"));
    assert!(said.lines().nth(2).unwrap().starts_with("coupled.ssp: "), "{said}");
    assert!(said.lines().all(|line| line.chars().count() <= 80), "{said}");
    let first = fs::read(at.join("coupled.ssp")).unwrap();
    out(&lemons(at, &CONNECT));
    assert!(first == fs::read(at.join("coupled.ssp")).unwrap(), "same input, same bytes");
}

#[test]
fn a_controller_that_wants_nothing_changes_nothing() {
    let directory = fmus(true);
    let at = directory.path();
    out(&lemons(at, &CONNECT));
    let alone = ["run", "crowd.fmu", "--no-drive", "--until", "0.5", "--step", "0.03125"];
    let alone = [&alone[..], &["--set", "agent[1].Velocity.x=2", "-o", "alone.csv"]].concat();
    out(&lemons(at, &alone));
    let run = ["run", "coupled.ssp", "--until", "0.5", "--set", "crowd.agent[1].Velocity.x=2"];
    let idle = [&run[..], &["--set", "controller.Stiffness=0"]].concat();
    let said = out(&lemons(at, &idle));
    let read = |name: &str| fs::read_to_string(at.join(name)).unwrap();
    assert!(read("alone.csv") == read("trajectories.csv"), "to the last bit");
    let expected = [
        "components                  2     (Jacobi algorithm, 30 connections)",
        "communication step    0.03125 s",
        "simulated time          0.500 s",
    ];
    assert_eq!(said.lines().take(3).collect::<Vec<_>>(), expected, "{said}");
    let lines = ["wall time", "real-time factor", "largest overlap", "greatest peak ", "trajectories  "];
    for line in lines {
        assert!(said.contains(line), "{said}");
    }
    assert!(said.contains("\noutputs            outputs.csv   (20 columns)\n"), "{said}");
    assert!(said.lines().all(|line| line.chars().count() <= 80), "{said}");
    let outputs = read("outputs.csv");
    assert!(outputs.starts_with("t,controller.agent[0].Fp.x,controller.agent[0].Fp.y,"), "{outputs}");
    assert_eq!(outputs.lines().count(), 1 + 17);
    assert!(outputs.lines().last().unwrap().ends_with(",1.0,1,true,x"), "{outputs}");
    // One that wants something does, and the algorithms differ.
    out(&lemons(at, &run));
    let jacobi = read("trajectories.csv");
    out(&lemons(at, &[&run[..], &["--algorithm", "gauss-seidel"]].concat()));
    let texts = [read("alone.csv"), jacobi, read("trajectories.csv")];
    assert!(texts[0] != texts[1] && texts[1] != texts[2] && texts[0] != texts[2]);
}

#[test]
fn several_crowds_have_several_files() {
    let directory = fmus(false);
    let at = directory.path();
    let fmu = fs::read(at.join("crowd.fmu")).unwrap();
    let structure = r#"<s:SystemStructureDescription xmlns:s="http://ssp-standard.org/SSP1/SystemStructureDescription"
        version="1.0" name="two"><s:System name="two"><s:Elements>
        <s:Component name="left/hall" source="crowd.fmu"/><s:Component name="right" source="crowd.fmu"/>
        </s:Elements></s:System><s:DefaultExperiment startTime="1" stopTime="1.2"/>
        </s:SystemStructureDescription>"#;
    write_zip(&at.join("two.ssp"), &[("SystemStructure.ssd", structure.as_bytes()), ("crowd.fmu", &fmu)]);
    let said = out(&lemons(at, &["run", "two.ssp", "--set", "right.agent[1].Velocity.x=2", "-o", "t.csv"]));
    assert!(said.contains("simulated time          0.200 s"), "{said}");
    assert!(said.contains("crowd              left/hall\n"), "{said}");
    let read = |name: &str| fs::read_to_string(at.join(name)).unwrap();
    let (left, right) = (read("t_left_hall.csv"), read("t_right.csv"));
    assert!(left.contains("\n1.2,4,") && left != right, "{left}");
    assert!(!at.join("t.csv").exists() && !at.join("t_outputs.csv").exists());
}

#[test]
fn connect_writes_over_no_input() {
    let directory = fmus(false);
    let at = directory.path();
    fs::copy(at.join("crowd.fmu"), at.join("crowd.ssp")).unwrap();
    let before = fs::read(at.join("crowd.fmu")).unwrap();
    let said =
        |crowd: &str, output: &str| err(&lemons(at, &["connect", "controller.fmu", crowd, "-o", output]));
    for output in ["crowd.fmu", "x.fmu", "x"] {
        let said = said("crowd.fmu", output);
        let why = if output == "crowd.fmu" { "lemons connect reads it" } else { "ends in .ssp" };
        assert!(said.contains(output) && said.contains(why), "{said}");
    }
    // However it is spelled.
    for output in ["crowd.ssp", "./crowd.ssp", &format!("{}/crowd.ssp", at.display())] {
        let said = said("crowd.ssp", output);
        assert!(said.contains(output) && said.contains("lemons connect reads it"), "{said}");
    }
    for file in ["crowd.fmu", "crowd.ssp"] {
        assert!(fs::read(at.join(file)).unwrap() == before, "{file} is as it was");
    }
    assert!(!at.join("x.fmu").exists() && !at.join("x").exists());
}

#[test]
fn results_go_into_files_of_their_own() {
    let directory = fmus(true);
    let at = directory.path();
    out(&lemons(at, &CONNECT));
    fs::create_dir(at.join("sub")).unwrap();
    let before = fs::read(at.join("coupled.ssp")).unwrap();
    let absolute = at.join("trajectories.csv");
    for (options, words) in [
        (["--outputs", "./trajectories.csv"], "another result goes there"),
        (["--outputs", "sub/../trajectories.csv"], "another result goes there"),
        (["--outputs", absolute.to_str().unwrap()], "another result goes there"),
        (["--outputs", "./coupled.ssp"], "lemons run reads it"),
        (["-o", "coupled.ssp"], "lemons run reads it"),
    ] {
        let run = ["run", "coupled.ssp", "--until", "0.1", "--format", "csv"];
        let said = err(&lemons(at, &[&run[..], &options].concat()));
        assert!(said.contains(options[1]) && said.contains(words), "{said}");
        assert!(!at.join("trajectories.csv").exists());
    }
    assert!(fs::read(at.join("coupled.ssp")).unwrap() == before);
    // The file of one of several crowds.
    let structure = br#"<SystemStructureDescription version="1.0"><System><Elements>
        <Component name="left" source="crowd.fmu"/><Component name="right" source="crowd.fmu"/>
        <Component name="controller" source="controller.fmu"/></Elements></System>
        </SystemStructureDescription>"#;
    let [crowd, controller] = ["crowd.fmu", "controller.fmu"].map(|name| fs::read(at.join(name)).unwrap());
    let files =
        [("SystemStructure.ssd", &structure[..]), ("crowd.fmu", &crowd), ("controller.fmu", &controller)];
    write_zip(&at.join("three.ssp"), &files);
    let three = ["run", "three.ssp", "--until", "0.1", "-o", "t.csv", "--outputs"];
    let said = err(&lemons(at, &[&three[..], &["./t_right.csv"]].concat()));
    assert!(said.contains("./t_right.csv: another result goes there"), "{said}");
    out(&lemons(at, &[&three[..], &["t.csv"]].concat()));
}

#[test]
fn a_value_that_a_connection_overwrites_is_warned_of() {
    let directory = fmus(true);
    let at = directory.path();
    out(&lemons(at, &CONNECT));
    let warnings = |setting: &str| {
        let output = lemons(at, &["run", "coupled.ssp", "--until", "0.1", "--no-drive", "--set", setting]);
        out(&output);
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert_eq!(
        warnings("crowd.agent[0].Fp.x=3"),
        "warning: --set crowd.agent[0].Fp.x=3: overwritten by the connection that feeds agent[0].Fp.x\n"
    );
    for free in ["crowd.agent[0].Velocity.x=1", "controller.real.in=1", "controller.integer.in=1"] {
        assert_eq!(warnings(free), "", "{free}");
    }
    // The push in the FMU.
    let output = lemons(at, &["run", "coupled.ssp", "--until", "0.1"]);
    assert_eq!(String::from_utf8_lossy(&output.stderr), LOST);
}

#[test]
fn what_is_no_fmu_is_called_what_it_is() {
    let directory = fmus(false);
    let at = directory.path();
    out(&lemons(at, &CONNECT));
    let said = err(&lemons(at, &["info", "coupled.ssp"]));
    assert!(said.contains("coupled.ssp: this is an SSP archive: lemons run FILE.ssp"), "{said}");
    write_zip(&at.join("some.zip"), &[("text", b"")]);
    let said = err(&lemons(at, &["run", "some.zip"]));
    assert!(
        said.contains("some.zip: it contains no Parameters.xml, so it is not a zip of a Trial"),
        "{said}"
    );
}

#[test]
fn mistakes_have_clear_messages() {
    let directory = fmus(true);
    let at = directory.path();
    out(&lemons(at, &CONNECT));
    let said = |arguments: &[&str]| err(&lemons(at, arguments));
    let run = |more: &[&str]| said(&[&["run", "coupled.ssp"], more].concat());
    assert!(
        run(&["--set", "Stiffness=1"]).contains("COMPONENT.NAME=VALUE; components are controller, crowd")
    );
    assert!(run(&["--set", "crowd.nothing=1"]).contains("no variable \"nothing\""));
    assert!(run(&["--drive", "x.csv"]).contains("inputs are fed by connections"));
    assert!(run(&["--until", "0.5", "-o", "no/such/directory.csv"]).contains("no/such/directory.csv"));
    assert!(run(&["-o", "same.csv", "--outputs", "same.csv"]).contains("same.csv"));
    let mass = run(&["--set", "crowd.agent[0].Mass=-1"]);
    assert!(mass.contains("agent[0].Mass = -1.0: must be positive"), "{mass}");
    assert!(said(&["run", "nothing.ssp"]).contains("nothing.ssp"));
    fs::write(at.join("broken.ssp"), "no zip").unwrap();
    assert!(said(&["run", "broken.ssp"]).contains("broken.ssp"));
    let structure = br#"<SystemStructureDescription version="1.0"><System><Elements>
        <Component name="a" source="a.fmu"/></Elements></System></SystemStructureDescription>"#;
    write_zip(&at.join("empty.ssp"), &[("SystemStructure.ssd", structure)]);
    let missing = said(&["run", "empty.ssp"]);
    let place = "empty.ssp: SystemStructure.ssd:2: <Component> source=\"a.fmu\": there is no a.fmu";
    assert!(missing.contains(place), "{missing}");
    write_zip(&at.join("zip.ssp"), &[("SystemStructure.ssd", structure), ("a.fmu", b"no zip")]);
    assert!(said(&["run", "zip.ssp"]).contains("<Component> source=\"a.fmu\""));

    let connect = |fmus: &[&str]| said(&[&["connect", "-o", "bad.ssp"], fmus].concat());
    assert!(connect(&["crowd.fmu", "nothing.fmu"]).contains("nothing.fmu"));
    assert!(
        connect(&["crowd.fmu", "crowd.fmu"])
            .contains("\ncrowd_2: 20 inputs: agent[0].Fp.x, agent[0].Fp.y, …")
    );
    let other =
        DESCRIPTION.replace("<Unit name=\"m\"><BaseUnit m=\"1\"/>", "<Unit name=\"m\"><BaseUnit s=\"1\"/>");
    write_controller(&at.join("other.fmu"), &other, false);
    let units = connect(&["other.fmu", "crowd.fmu"]);
    assert!(units.contains("crowd and other do not mean the same by its unit \"m\""), "{units}");
    let exchange = DESCRIPTION.replace("<CoSimulation", "<ModelExchange");
    write_controller(&at.join("exchange.fmu"), &exchange, false);
    assert!(connect(&["exchange.fmu", "crowd.fmu"]).contains("not for co-simulation"));
    assert!(connect(&["controller.fmu", "crowd.fmu", "controller.fmu"]).contains("is fed by two outputs"));
    assert!(!at.join("bad.ssp").exists() && !at.join("trajectories.csv").exists());
    assert!(
        fs::read_dir(at).unwrap().all(|file| !file.unwrap().file_name().to_string_lossy().starts_with('.'))
    );
}

/// The end of a run comes from the SSP where `--until` does not say it.
#[test]
fn an_ssp_that_never_ends_is_refused_by_its_name() {
    let directory = fmus(true);
    let at = directory.path();
    out(&lemons(at, &CONNECT));
    let mut from = zip::ZipArchive::new(fs::File::open(at.join("coupled.ssp")).unwrap()).unwrap();
    let mut text = String::new();
    let structure = "SystemStructure.ssd";
    std::io::Read::read_to_string(&mut from.by_name(structure).unwrap(), &mut text).unwrap();
    let begin = text.find("<ssd:DefaultExperiment").unwrap();
    let end = begin + text[begin..].find('>').unwrap() + 1;
    for (stop, said) in [
        ("1e300", "coupled.ssp: from 0.0 to 1e300 s there are "),
        ("1e9999", "coupled.ssp: SystemStructure.ssd:"),
        ("nan", "coupled.ssp: SystemStructure.ssd:"),
        ("-1e300", "nothing to simulate: it starts at 0.0 s and stops at -1e300 s"),
    ] {
        let experiment = format!("<ssd:DefaultExperiment startTime=\"0\" stopTime=\"{stop}\"/>");
        let text = format!("{}{experiment}{}", &text[..begin], &text[end..]);
        let mut zip = zip::ZipWriter::new(fs::File::create(at.join("endless.zip")).unwrap());
        for k in 0..from.len() {
            let entry = from.by_index_raw(k).unwrap();
            if entry.name().unwrap() != structure {
                zip.raw_copy_file(entry).unwrap();
            }
        }
        zip.start_file(structure, zip::write::SimpleFileOptions::default()).unwrap();
        std::io::Write::write_all(&mut zip, text.as_bytes()).unwrap();
        zip.finish().unwrap();
        fs::rename(at.join("endless.zip"), at.join("coupled.ssp")).unwrap();
        let refused = err(&lemons(at, &["run", "coupled.ssp"]));
        assert!(refused.contains(said), "{stop}: {refused}");
        assert!(!at.join("trajectories.csv").exists());
    }
}

#[test]
fn a_parameter_of_all_agents_of_a_component() {
    let directory = fmus(true);
    let at = directory.path();
    out(&lemons(at, &CONNECT));
    let run = |file: &str, settings: &[String]| {
        let settings: Vec<&str> = settings.iter().flat_map(|set| ["--set", set]).collect();
        out(&lemons(at, &[&["run", "coupled.ssp", "--until", "0.5", "-o", file], &settings[..]].concat()));
        fs::read(at.join(file)).unwrap()
    };
    let each: Vec<String> = (0..5).map(|i| format!("crowd.agent[{i}].Mass=80")).collect();
    let all = run("all.csv", &["crowd.agent[*].Mass=80".into()]);
    assert!(all == run("each.csv", &each) && all != run("own.csv", &[]));
    let said = err(&lemons(at, &["run", "coupled.ssp", "--set", "crowd.agent[*].Beauty=80"]));
    assert!(said.contains("the FMU has no variable \"agent[*].Beauty\""), "{said}");
}

/// A step of 7.5e8 mechanical ones, which takes minutes: the run ends before it does.
#[test]
#[cfg(unix)]
fn one_long_step_of_coupled_fmus_can_be_interrupted() {
    let directory = fmus(true);
    let at = directory.path();
    out(&lemons(at, &CONNECT));
    let mut child = Command::new(env!("CARGO_BIN_EXE_lemons"))
        .args(["run", "coupled.ssp", "--step", "1500", "--until", "1500"])
        .current_dir(at)
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // The step is under way a moment after the files are begun.
    while fs::read_dir(at).unwrap().count() < 5 {
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    std::thread::sleep(std::time::Duration::from_secs(1));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(said.contains("stopped at t = 0.0 s"), "{said}");
    for file in ["trajectories.csv", "outputs.csv"] {
        assert!(fs::read_to_string(at.join(file)).unwrap().lines().count() > 1);
    }
}

/// Both passed in silence.
#[test]
fn outputs_that_are_no_numbers_and_steps_with_a_warning_are_warned_of_once() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    write_controller(&at.join("controller.fmu"), DESCRIPTION, true);
    let run = |setting: &str| {
        let words =
            ["run", "controller.fmu", "--until", "0.2", "--step", "0.05", "--force", "--set", setting];
        let output = lemons(at, &words);
        out(&output);
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert_eq!(run("real.in=1"), "");
    let said = run("real.in=nan");
    let first = "real.out is NaN for the first time at t = 0.05 s\n";
    assert!(said.starts_with("warning: output ") && said.ends_with(first), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    let steps = "warning: the step from t = 0.0 s returned the status fmi2Warning, and 3 later steps\n";
    assert_eq!(run("real.in=7"), steps);
}
