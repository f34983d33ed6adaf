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
