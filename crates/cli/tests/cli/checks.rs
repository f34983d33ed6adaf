//! What is refused before it is begun, and what `lemons check` warns of.

use crate::common::*;
use lemons_plane::vec2;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// An FMU of `trials.txt/` could not be loaded, one of `box\n/` held no such Trial.
#[test]
fn trials_that_could_not_be_loaded_from_an_fmu_are_not_packed() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    for name in ["trials.txt", "Trials.TXT", "box\n", "two\nlines", "a\\b", "bell\u{7}", " ", "C:"] {
        copy_trial(&at.join(name));
        let output = lemons(at, &["pack", &format!("./{name}"), "-o", "x.fmu"]);
        assert_code(&output, 1);
        let said = err(&output);
        assert!(said.contains(&format!("{name:?}, which cannot be a directory's name in an FMU")), "{said}");
        assert!(!at.join("x.fmu").exists());
    }
    for name in ["trials", "my trials.txt", "Größe 1", "box.d"] {
        copy_trial(&at.join(name));
        done(at, &["pack", name, "-o", "x.fmu", "--force"]);
        let info = out(&done(at, &["info", "x.fmu", "--only", "no such"]));
        assert!(info.contains(&format!("Trials    {name}\n")), "{info}");
    }
}

/// 100 000 took 28 s and 1.4 GB, and no command read the FMU.
#[test]
fn crowds_too_large_for_a_model_description_are_refused_before_the_work() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    lemons_bench::fmu::write_trial(60_000, vec2(0.5, 0.5), &at.join("large")).unwrap();
    let output = lemons(at, &["pack", "large", "-o", "x.fmu"]);
    assert_code(&output, 1);
    let said = err(&output);
    let words = ["60000 agents are too many for an FMU", "MB, and at most 256 MB can be read"];
    assert!(words.iter().all(|word| said.contains(word)), "{said}");
    assert!(!at.join("x.fmu").exists());
}

#[test]
fn a_decision_is_described_as_it_is_packed() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    decision_library();
    let door = lemons_testing::trial_door();
    let door = door.to_str().unwrap();
    let plan = format!("{door}/decision.toml");
    for (version, words) in [("2", "agent[29].Waypoint[1].x"), ("3", "WaypointCount")] {
        let described = out(&done(at, &["describe", door, "--fmi", version, "--plan", &plan]));
        done(at, &["decide", door, "--fmi", version, "-o", &format!("{version}.fmu")]);
        let file = fs::File::open(at.join(format!("{version}.fmu"))).unwrap();
        let mut archive = zip::ZipArchive::new(file).unwrap();
        let packed = std::io::read_to_string(archive.by_name("modelDescription.xml").unwrap()).unwrap();
        assert!(packed == described && packed.contains(words), "{described}");
    }
}

/// `lemons crowd --zip` wrote what no command read.
#[test]
fn a_zip_of_a_trial_serves_wherever_a_trial_does() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let crowd = ["crowd", "-n", "5", "--seed", "3", "-o", "box", "--zip", "box.zip"];
    done(at, &crowd);
    // It has no wishes: the Trial is read before these are missed.
    let decide = err(&lemons(at, &["decide", "box.zip", "-o", "d.fmu"]));
    assert!(decide.starts_with("lemons: there is no box.zip/decision.toml"), "{decide}");
    decision_library();
    fs::write(at.join("wishes.toml"), "waypoints = [{ x = 6.0, y = 2.5 }]\n").unwrap();
    let of = |arguments: &[&str]| out(&done(at, arguments));
    let check = of(&["check", "box.zip"]);
    assert!(check.starts_with("note: box.zip/Parameters.xml: TimeStepMechanical"), "{check}");
    assert!(check.contains("\nbox.zip: 5 agents"), "{check}");
    assert_eq!(of(&["describe", "box.zip"]), of(&["describe", "box"]));
    for (from, to) in [("box.zip", "a"), ("box", "b")] {
        done(at, &["run", from, "--until", "0.2", "-o", &format!("{to}.csv")]);
        done(at, &["pack", from, "-o", &format!("{to}.fmu")]);
        done(at, &["plot", from, "--at", "0.1", "-o", &format!("{to}.svg")]);
        done(at, &["movie", from, "--until", "0.1", "-o", &format!("{to}.gif")]);
        done(at, &["decide", from, "--plan", "wishes.toml", "-o", &format!("{to}_decides.fmu")]);
        let sweep = format!(
            "trial = {from:?}\nuntil = 0.05\n[parameters]\n\"agent[*].Mass\" = [70.0, 80.0]\n\
             [measures]\nreach = {{ of = \"x\", take = \"reach\", agents = [\"4\"] }}\n"
        );
        fs::write(at.join(format!("{to}.toml")), sweep).unwrap();
        done(at, &["sweep", &format!("{to}.toml"), "-o", &format!("{to}_swept.csv")]);
        let (table, base) = (format!("{to}.csv"), format!("{to}.sqlite"));
        done(at, &["export", &table, &base, "--to", "jupedsim", "--trial", from]);
    }
    for end in [".csv", ".fmu", ".svg", ".gif", "_decides.fmu", "_swept.csv"] {
        assert!(
            fs::read(at.join(format!("a{end}"))).unwrap() == fs::read(at.join(format!("b{end}"))).unwrap(),
            "{end}"
        );
    }
    // Messages name the file in the zip, not where it was unpacked.
    fs::write(at.join("README.md"), "text").unwrap();
    let output = lemons(at, &["check", "README.md", "box.zip"]);
    assert_code(&output, 3);
    assert!(
        out(&output).starts_with(
            "README.md: is a text file, not a Trial directory or a zip of one\nnote: box.zip/Parameters"
        ),
        "{}",
        out(&output)
    );
}

/// A wish of nobody was found by `lemons decide` only.
#[test]
fn a_misspelt_key_of_decision_toml_is_an_error_with_the_right_one() {
    let directory = TempDir::new().unwrap();
    let trial = directory.path().join("T");
    copy_trial(&trial);
    let check = |wishes: &str| {
        fs::write(trial.join("decision.toml"), wishes).unwrap();
        lemons(directory.path(), &["check", "T"])
    };
    assert_code(&check("waypoints = [{ x = 6, y = 2 }]"), 0);
    for (wishes, right) in [
        ("waypoint = [{ x = 6, y = 2 }]", "waypoints"),
        ("desiredspeed = 1\nwaypoints = [{ x = 6, y = 2 }]", "desired_speed"),
        ("waypoints = [{ x = 6, y = 2, raduis = 1 }]", "radius"),
    ] {
        let output = check(wishes);
        assert_code(&output, 3);
        let said = out(&output);
        assert!(
            said.contains("T/decision.toml: ") && said.contains(&format!("did you mean `{right}`?")),
            "{said}"
        );
    }
    // Kilometres per hour, for instance.
    let output =
        check("desired_speed = 2.9\nwaypoints = [{ x = 6, y = 2 }]\n[agents.1]\ndesired_speed = 5.5");
    assert_code(&output, 0);
    let said = out(&output);
    assert!(said.contains("warning: T/decision.toml: agent \"1\" wants 5.5 m/s: people walk"), "{said}");
    assert!(said.contains(": 1 warning"), "{said}");
    let said = out(&check("desired_speed = 48\nwaypoints = [{ x = 6, y = 2 }]"));
    assert!(said.contains("agent \"0\" wants 48.0 m/s, and 4 others more than 3.0 m/s:"), "{said}");
    // No force for it is a number; a message showed all 300 digits of a place.
    for (wishes, words) in [
        (
            "desired_speed = 1e308\nwaypoints = [{ x = 6, y = 2 }]",
            "desired_speed = 1e308: must be from 0 to 1e9",
        ),
        ("exits = [{ line = [[1e300, 0], [1e300, 9]] }]", "corner = 1e300: must be from -1e9 to 1e9 m"),
    ] {
        let output = check(wishes);
        assert_code(&output, 3);
        assert!(out(&output).contains(words), "{}", out(&output));
    }
    let output = check("waypoints = [{ x = 6, y = 2 }]\n[agents.nobody]");
    assert_code(&output, 3);
    assert!(out(&output).contains("there is no agent with this Id"), "{}", out(&output));
}

/// What `lemons check` says of a Trial.
fn checked(at: &Path, trial: &str) -> String {
    out(&done(at, &["check", trial]))
}

/// Nobody saw that somebody stood within a pillar.
#[test]
fn an_agent_in_a_pillar_is_warned_of_by_the_names_of_both() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    copy_trial(&at.join("T"));
    let geometry = at.join("T/static/Geometry.xml");
    let text = fs::read_to_string(&geometry).unwrap();
    let corners = [(0.95, 0.1), (1.25, 0.1), (1.25, -0.1), (0.95, -0.1), (0.95, 0.1)];
    let corners: String = corners.iter().map(|(x, y)| format!("<Corner Coordinates=\"{x},{y}\"/>")).collect();
    let pillar = format!("<Wall Id=\"pillar\" MaterialId=\"concrete\">{corners}</Wall></Geometry>");
    fs::write(&geometry, text.replace("</Geometry>", &pillar)).unwrap();
    let said = checked(at, "T");
    let words = "AgentDynamics.xml: agent \"3\" stands inside the closed wall \"pillar\", around which 4 others stand";
    assert!(said.contains(words), "{said}");
}

/// A misspelt `<Dynamics>` left an agent without a drive in silence.
#[test]
fn what_is_not_read_of_a_trial_is_warned_of() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    copy_trial(&at.join("T"));
    let file = at.join("T/dynamic/AgentDynamics.xml");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, text.replace("<Dynamics ", "<Dynamcs ")).unwrap();
    let said = checked(at, "T");
    assert!(said.contains("<Dynamcs>: is not read in <Agent> (5 times); is <Dynamics> meant?"), "{said}");
    assert!(said.ends_with(": 1 warning\n"), "{said}");
}

/// With a TimeStep of 50 s the push of 0.6 s moved nobody, in silence.
#[test]
fn a_drive_between_two_communication_points_is_warned_of() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    copy_trial(&at.join("T"));
    let parameters = at.join("T/Parameters.xml");
    let text = fs::read_to_string(&parameters).unwrap();
    fs::write(&parameters, text.replace("TimeStep=\"0.05\"", "TimeStep=\"1.5\"")).unwrap();
    // In mN.
    let drive = fs::read_to_string(at.join("T/drive.csv")).unwrap();
    fs::write(at.join("T/drive.csv"), "t,agent,Fp.x,Fp.y,Mp\n0,0,0,0,0\n0.05,0,1.2e6,0,0\n").unwrap();
    let said = checked(at, "T");
    let doubt = "warning: T/drive.csv: Fp=\"1200000.0,0.0\": agent \"0\": at most 30000 N is usual";
    assert!(said.contains(doubt), "{said}");
    fs::write(at.join("T/drive.csv"), drive).unwrap();
    let words = [
        "drive",
        "30 of 31 rows come between communication points, which are 1.5 s apart",
        "at t = 0.3 s agent \"0\" has Fp.x = 1200.0",
        "of 2.000e-2 s applies all rows",
    ];
    let said = checked(at, "T");
    assert!(words.iter().all(|word| said.contains(word)) && said.ends_with(": 2 warnings\n"), "{said}");
    assert!(said.contains("TimeStep=\"1.5\": 1e-5 s to 1 s is usual, because drives are constant"), "{said}");
    // As the Trial is made, only that the push is sampled.
    let said = checked(at, default_trial().to_str().unwrap());
    let note = "drive.csv: 24 of 31 rows are between communication points: the drive is interpolated at each";
    assert!(said.starts_with("note: ") && said.contains(note) && said.ends_with(": no problem\n"), "{said}");
    assert!(said.contains(": 5 agents, 1 wall, "), "{said}");
    let run = ["run", "T", "--until", "3", "--set", "TimeStepMechanical=1e-4", "-o", "a.csv"];
    let said = err(&done(at, &run));
    assert!(words.iter().all(|word| said.contains(word)), "{said}");
    // As the Trial is made, with a finer step, and without the push.
    for more in [["--step", "0.05"], ["--step", "0.01"], ["--until", "0.1"]] {
        let mut run = vec!["run", "T", "--set", "TimeStepMechanical=1e-4", "-o", "b.csv", "--force"];
        run.extend(if more[0] == "--until" {
            vec!["--no-drive", "--until", "3"]
        } else {
            vec![more[0], more[1], "--until", "0.1"]
        });
        let said = err(&done(at, &run));
        assert!(!said.contains("rows come between"), "{said}");
    }
}

/// The walking force is Mass · FloorDamping · speed: none without a floor. It was checked without a word.
#[test]
fn people_who_cannot_walk_are_warned_of() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    crate::walking::copy(&root().join("resources/Trial_door"), &at.join("T"));
    let agents = at.join("T/static/Agents.xml");
    let text = fs::read_to_string(&agents).unwrap();
    let mut rates = text.split("FloorDamping=\"").skip(1).map(|rest| rest.split('"').next().unwrap());
    let rate = rates.next().unwrap();
    let number = 1 + rates.count();
    let own = format!("FloorDamping=\"{rate}\"");
    assert_eq!(text.matches(&own).count(), number);
    fs::write(&agents, text.replace(&own, "FloorDamping=\"0\"")).unwrap();
    let said = checked(at, "T");
    let words = format!("warning: T/decision.toml: {number} of {number} agents cannot walk (first \"");
    assert!(said.contains(&words) && said.ends_with(": 1 warning\n"), "{said}");
    // A force of the Trial is not used.
    let dynamics = at.join("T/dynamic/AgentDynamics.xml");
    let still = fs::read_to_string(&dynamics).unwrap();
    fs::write(&dynamics, still.replacen("Mp=\"0", "Mp=\"7", 1)).unwrap();
    let words = "warning: T/decision.toml: Fp and Mp in AgentDynamics.xml of agent \"0\" are not used, because people walk";
    let said = checked(at, "T");
    assert!(said.contains(words) && said.ends_with(": 2 warnings\n"), "{said}");
    fs::write(&dynamics, still).unwrap();
    // Without somebody who wants to walk, it is what is meant.
    fs::remove_file(at.join("T/decision.toml")).unwrap();
    assert!(checked(at, "T").ends_with(": no problem\n"));
    // The file is named, which a unit test cannot see.
    fs::write(&agents, text.replacen(&own, "FloorDamping=\"450\"", 1)).unwrap();
    let said = checked(at, "T");
    assert!(
        said.contains("T/static/Agents.xml: <Agent> FloorDamping=\"450.0\": agent \"0\": at most 50 1/s"),
        "{said}"
    );
}

/// Trials that are as they are meant.
#[test]
fn nothing_is_said_of_trials_that_are_in_order() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut trials = vec![root.join("resources/Trial_push"), root.join("resources/Trial_door")];
    // A crowd is made around the pillar.
    let wall = |id: &str, corners: &[(i32, i32)]| {
        let corners = corners.iter().map(|(x, y)| format!("<Corner Coordinates=\"{x},{y}\"/>"));
        format!("<Wall Id=\"{id}\" MaterialId=\"concrete\">{}</Wall>", corners.collect::<String>())
    };
    let hall = wall("hall", &[(0, 0), (6, 0), (6, 6), (0, 6), (0, 0)]);
    let pillar = wall("pillar", &[(2, 2), (3, 2), (3, 4), (2, 4), (2, 2)]);
    fs::write(at.join("hall.xml"), format!("<Geometry>{hall}{pillar}</Geometry>")).unwrap();
    for (name, arguments) in [
        ("open", &["-n", "20", "--density", "3"][..]),
        ("box", &["-n", "20", "--box", "4x4", "--speed", "0.5"]),
        ("hall", &["-n", "20", "--geometry", "hall.xml"]),
    ] {
        let made = at.join(name);
        done(at, &[&["crowd", "--seed", "3", "-o", made.to_str().unwrap()], arguments].concat());
        trials.push(made);
    }
    for trial in trials {
        let said = checked(at, trial.to_str().unwrap());
        assert!(said.ends_with(": no problem\n"), "{said}");
    }
    // Crowds of others: some of their people overlap at the start, and nothing else is said.
    let shared = root.join("../shared/data");
    for name in ["crowds/dense_100", "crowds/dense_1000", "crowds/sparse_100", "push_wed/Trial"] {
        let trial = shared.join(name);
        if !trial.is_dir() {
            eprintln!("skipped: {} is not there", trial.display());
            continue;
        }
        let said = checked(at, trial.to_str().unwrap());
        let mut warnings = said.lines().filter(|line| line.starts_with("warning: "));
        assert!(warnings.all(|line| line.contains("overlap at the start")), "{said}");
    }
}

/// The output of a call that must not wait for ever, nor read without end.
#[cfg(unix)]
#[track_caller]
fn at_last(directory: &Path, arguments: &[&str]) -> std::process::Output {
    use std::process::Stdio;
    let mut command = command(directory, arguments);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let begun = std::time::Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed().as_secs() > 1200 {
            child.kill().unwrap();
            panic!("{arguments:?} does not end");
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    child.wait_with_output().unwrap()
}

/// A FIFO blocked for ever, a link to the endless device took all memory.
#[cfg(unix)]
#[test]
fn pipes_and_devices_in_the_place_of_files_are_refused() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let pipe = |path: &Path| {
        assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
    };
    let zero = |path: &Path| std::os::unix::fs::symlink("/dev/zero", path).unwrap();
    for file in ["static/Agents.xml", "static/Materials.xml", "drive.csv", "decision.toml"] {
        for (what, put) in [("a pipe", &pipe as &dyn Fn(&Path)), ("a device", &zero)] {
            let trial = at.join("T");
            copy_trial(&trial);
            let _ = fs::remove_file(trial.join(file));
            put(&trial.join(file));
            let mut calls = vec![vec!["check", "T"]];
            calls.push(match file {
                "decision.toml" => vec!["decide", "T", "-o", "x.fmu"],
                _ => vec!["run", "T", "--until", "0.1", "-o", "x.csv"],
            });
            if file != "decision.toml" {
                calls.push(vec!["pack", "T", "-o", "x.fmu"]);
            }
            for call in calls {
                let output = at_last(at, &call);
                assert!(matches!(output.status.code(), Some(1 | 3)), "{call:?} {file} {what}: {output:?}");
                let said = out(&output) + &err(&output);
                let words = [format!("T/{file}"), format!("it is {what}, not a regular file")];
                assert!(words.iter().all(|word| said.contains(word)), "{call:?} {file} {what}: {said}");
            }
            fs::remove_dir_all(trial).unwrap();
        }
    }
    for name in ["x.fmu", "x.ssp", "x.run"] {
        pipe(&at.join(name));
    }
    zero(&at.join("sweep.toml"));
    zero(&at.join("zero"));
    copy_trial(&at.join("T"));
    for (call, words) in [
        (vec!["sweep", "sweep.toml", "-o", "out.csv"], ["sweep.toml", "larger than 64 MB"]),
        (vec!["crowd", "--custom", "zero", "--population", "x.csv"], ["zero", "larger than 64 MB"]),
        (vec!["run", "T", "--until", "0.1", "--drive", "zero"], ["zero", "larger than 500 MB"]),
        (vec!["run", "x.fmu", "--until", "0.1"], ["x.fmu", "it is a pipe, not a regular file"]),
        (vec!["run", "x.ssp", "--until", "0.1"], ["x.ssp", "it is a pipe, not a regular file"]),
        (
            vec!["run", "T", "--resume", "x.run", "--until", "1"],
            ["x.run", "is a pipe or a device, not a saved run"],
        ),
    ] {
        let output = at_last(at, &call);
        assert_code(&output, 1);
        let said = err(&output);
        assert!(words.iter().all(|word| said.contains(word)), "{call:?}: {said}");
    }
    // What a user names may be a pipe.
    let drive = at.join("drive pipe");
    pipe(&drive);
    let content = fs::read(default_trial().join("drive.csv")).unwrap();
    let writer = std::thread::spawn(move || fs::write(drive, content).unwrap());
    let run = ["run", "T", "--until", "0.1", "--drive", "drive pipe", "-o", "run.csv"];
    assert_code(&at_last(at, &run), 0);
    writer.join().unwrap();
}

/// They named a file in a scratch directory, one at a time, and `pack` took the Trial.
#[test]
fn errors_of_a_drive_name_the_file_that_was_given_and_all_lines() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    copy_trial(&at.join("T"));
    fs::write(
        at.join("sweep.toml"),
        "trial = 'T'\nuntil = 0.1\n[parameters]\n\"agent[0].Mass\" = [70]\n\
                                      [measures]\nx = { of = \"x\", take = \"max\" }\n",
    )
    .unwrap();
    let header = "t,agent,Fp.x,Fp.y,Mp\n";
    let drives = [
        ("0,0,many,0,0\n1,0,0,0,inf\n", vec![":2: Fp.x=\"many\": not a", ":3: Mp=\"inf\": not a"]),
        ("0,0,0,0,0\n0,77,0,0,0\n", vec![":3: there is no agent \"77\" in Agents.xml"]),
    ];
    for (rows, expected) in drives {
        fs::write(at.join("T/drive.csv"), format!("{header}{rows}")).unwrap();
        let calls = [
            &["check", "T"][..],
            &["pack", "T", "-o", "x.fmu"],
            &["run", "T", "--until", "0.1", "-o", "x.csv"],
            &["sweep", "sweep.toml", "-o", "results"],
        ];
        for call in calls {
            let output = lemons(at, call);
            assert_code(&output, 3);
            let said = out(&output) + &err(&output);
            let named = |words: &&str| said.contains(&format!("T/drive.csv{words}"));
            assert!(expected.iter().all(named) && !said.contains("scratch"), "{call:?}: {said}");
        }
        assert!(!at.join("x.fmu").exists());
        // Its own drive does not matter then.
        done(at, &["run", "T", "--until", "0.05", "-o", "y.csv", "--no-drive", "--force"]);
        // Of an FMU that another program packed.
        let given = lemons_master::Given::open(&at.join("T")).unwrap();
        let binary = lemons_master::own_binary().unwrap();
        lemons_master::pack(
            &[given],
            vec![binary],
            crowd_mechanics::pack::Format::default(),
            None,
            false,
            &at.join("made.fmu"),
        )
        .unwrap();
        let output = lemons(at, &["run", "made.fmu", "--until", "0.1", "-o", "x.csv"]);
        assert_code(&output, 1);
        let said = err(&output);
        let named = |words: &&str| said.contains(&format!("made.fmu/resources/T/drive.csv{words}"));
        assert!(expected.iter().all(named) && !said.contains("scratch"), "{said}");
    }
}
