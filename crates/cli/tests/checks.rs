//! What is refused before it is begun, and what `lemons check` warns of.

mod common;

use common::*;
use crowd_mechanics::engine::vec2;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A copy of the default Trial.
fn copy_trial(to: &Path) {
    for part in [
        "Parameters.xml",
        "static/Agents.xml",
        "static/Geometry.xml",
        "static/Materials.xml",
        "dynamic/AgentDynamics.xml",
        "drive.csv",
    ] {
        let target = to.join(part);
        fs::create_dir_all(target.parent().unwrap()).unwrap();
        fs::copy(default_trial().join(part), target).unwrap();
    }
}

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
    let of = |arguments: &[&str]| out(&done(at, arguments));
    let check = of(&["check", "box.zip"]);
    assert!(check.starts_with("box.zip: 5 agents"), "{check}");
    assert_eq!(of(&["describe", "box.zip"]), of(&["describe", "box"]));
    for (from, to) in [("box.zip", "a"), ("box", "b")] {
        done(at, &["run", from, "--until", "0.2", "-o", &format!("{to}.csv")]);
        done(at, &["pack", from, "-o", &format!("{to}.fmu")]);
        done(at, &["plot", from, "--at", "0.1", "-o", &format!("{to}.svg")]);
        let (table, base) = (format!("{to}.csv"), format!("{to}.sqlite"));
        done(at, &["export", &table, &base, "--to", "jupedsim", "--trial", from]);
    }
    for end in [".csv", ".fmu", ".svg"] {
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
        out(&output)
            .starts_with("README.md: is a text file, not a Trial directory or a zip of one\nbox.zip: 5"),
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
    let output = check("waypoints = [{ x = 6, y = 2 }]\n[agents.nobody]");
    assert_code(&output, 3);
    assert!(out(&output).contains("there is no agent with this Id"), "{}", out(&output));
}

/// What a call answers that must not wait for ever, nor read without end.
#[cfg(unix)]
#[track_caller]
fn at_last(directory: &Path, arguments: &[&str]) -> std::process::Output {
    use std::process::Stdio;
    let mut command = command(directory, arguments);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let begun = std::time::Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed().as_secs() > 120 {
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
        (vec!["sweep", "sweep.toml", "-o", "out"], ["sweep.toml", "larger than 64 MB"]),
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
