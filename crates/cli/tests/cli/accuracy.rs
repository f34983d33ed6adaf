//! `lemons run --accuracy`, and what `lemons check` says of the mechanical step.

use crate::common::*;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A line of the summary, without its first word.
#[track_caller]
fn line(said: &str, what: &str) -> String {
    let line = said.lines().find_map(|line| line.strip_prefix(what));
    line.unwrap_or_else(|| panic!("{what}: {said}")).trim().to_owned()
}

/// x, y and theta in the rows of a table.
fn poses(path: &Path) -> Vec<[f64; 3]> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let heads: Vec<&str> = lines.next().unwrap().split(',').collect();
    let places = ["x", "y", "theta"].map(|name| heads.iter().position(|head| *head == name).unwrap());
    let row = |line: &str| {
        let values: Vec<&str> = line.split(',').collect();
        places.map(|place| values[place].parse().unwrap())
    };
    lines.map(row).collect()
}

#[test]
fn two_runs_for_an_accuracy_are_compared_and_the_finer_one_is_written() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    copy_trial(&at.join("T"));
    let said = out(&done(at, &["run", "T", "--until", "0.6", "--accuracy", "1e-3", "-o", "a.csv"]));
    let steps = line(&said, "mechanical steps");
    let (coarse, rest) = steps.split_once(" s and ").unwrap();
    let half = rest.split_once(' ').unwrap().0;
    // 1/71 of the shortest period, 10.9 ms.
    assert_eq!(coarse, "1.5e-4");
    // The tables of both steps by themselves.
    for (step, name) in [(coarse, "coarse.csv"), (half, "fine.csv")] {
        let set = format!("TimeStepMechanical={step}");
        done(at, &["run", "T", "--until", "0.6", "--set", &set, "-o", name]);
    }
    assert!(fs::read(at.join("a.csv")).unwrap() == fs::read(at.join("fine.csv")).unwrap());
    let (coarse, fine) = (poses(&at.join("coarse.csv")), poses(&at.join("fine.csv")));
    let apart = |rim: f64| {
        let pairs = coarse.iter().zip(&fine);
        let of = |(one, other): (&[f64; 3], &[f64; 3])| {
            let [x, y, turn] = [0, 1, 2].map(|k| one[k] - other[k]);
            x.hypot(y) + rim * turn.abs()
        };
        1e3 * pairs.map(of).fold(0.0, f64::max)
    };
    let told = line(&said, "they differ by");
    let millimetres: f64 = told.split_whitespace().next().unwrap().parse().unwrap();
    // Bodies are 0.2 to 0.3 m long from the centre of mass.
    assert!((apart(0.2)..=apart(0.3)).contains(&millimetres), "{told}: {} {}", apart(0.2), apart(0.3));
    assert!(millimetres > 1e-4 && told.contains("a point of agent") && told.contains("t = 0."), "{told}");
    assert!(line(&said, "accuracy").ends_with("is met"), "{said}");

    // The same by FMUs of both versions.
    for version in ["2", "3"] {
        done(at, &["pack", "T", "--fmi", version, "-o", "t.fmu", "--force"]);
        let run = [
            "run",
            "t.fmu",
            "--until",
            "0.6",
            "--drive",
            "T/drive.csv",
            "--accuracy",
            "1e-3",
            "-o",
            "b.csv",
            "--force",
        ];
        assert_eq!(line(&out(&done(at, &run)), "they differ by"), told);
        assert!(fs::read(at.join("a.csv")).unwrap() == fs::read(at.join("b.csv")).unwrap());
    }
}

#[test]
fn an_accuracy_that_is_not_met_is_told_with_agent_and_time() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    copy_trial(&at.join("T"));
    // Much faster than the 1 m/s of the rule.
    let fast = ["run", "T", "--until", "0.3", "--set", "agent[0].Velocity.x=40", "--accuracy", "1e-3"];
    let said = out(&done(at, &fast));
    let told = line(&said, "accuracy");
    assert!(
        told.contains("1.000e0 mm") && told.contains("is not met: agent ") && told.contains("from t = 0."),
        "{said}"
    );
}

#[test]
fn coupled_crowds_are_run_for_an_accuracy_too() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    copy_trial(&at.join("T"));
    done(at, &["pack", "T", "-o", "one.fmu"]);
    crate::coupling::controller::write_controller(
        &at.join("controller.fmu"),
        crate::coupling::controller::DESCRIPTION,
        true,
    );
    done(at, &["connect", "controller.fmu", "one.fmu", "-o", "c.ssp"]);
    let said = out(&done(at, &["run", "c.ssp", "--until", "0.2", "--accuracy", "1e-3", "-o", "c.csv"]));
    let steps = line(&said, "mechanical steps");
    assert!(steps.contains("of one") && steps.starts_with("1.5e-4 s and 7.5e-5 s"), "{said}");
    assert!(said.contains("is met"), "{said}");
    // Alone, the controller has no mechanical step.
    let refused =
        lemons(at, &["run", "controller.fmu", "--until", "0.2", "--accuracy", "1e-3", "-o", "d.csv"]);
    assert_code(&refused, 1);
    assert!(err(&refused).contains("nothing here has a parameter TimeStepMechanical"), "{}", err(&refused));
    assert!(!at.join("d.csv").exists());
}

#[test]
fn accuracies_that_make_no_sense_are_refused() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    copy_trial(&at.join("T"));
    for accuracy in ["0", "-1", "nan", "inf", "fine"] {
        let refused = lemons(at, &["run", "T", &format!("--accuracy={accuracy}")]);
        assert_code(&refused, 2);
        assert!(err(&refused).contains("positive number of metres"), "{}", err(&refused));
    }
    let refused = lemons(at, &["run", "T", "--accuracy", "1e-4", "--set", "TimeStepMechanical=1e-5"]);
    assert_code(&refused, 2);
    assert!(err(&refused).contains("--accuracy chooses the mechanical step"), "{}", err(&refused));
    let refused = lemons(at, &["run", "T", "--accuracy", "1e-4", "--resume", "x.run"]);
    assert_code(&refused, 2);
    assert!(err(&refused).contains("cannot be used with"), "{}", err(&refused));
    assert!(!at.join("trajectories.csv").exists());
}

#[test]
fn check_tells_stable_from_accurate() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    copy_trial(&at.join("T"));
    let note = |at: &Path| {
        let said = out(&done(at, &["check", "T"]));
        let note = said
            .lines()
            .find(|line| line.contains("Parameters.xml: TimeStepMechanical") && line.starts_with("note"));
        note.unwrap_or_else(|| panic!("{said}")).to_owned()
    };
    // T = 10.9 ms: 5 m (2e-6/T)² = 0.17 µm. Eight contacts of agent 1 on concrete: 1/m* = 0.0644/kg, k = 5.0e6 N/m,
    // γ = 1230 kg/s, κ/4 + g = 1 at 8.4e-4 s.
    let told = note(at);
    let words = [
        "stable (up to 8.4e-4 s), with an error of about 0.17 µm in",
        "a step of 4.8e-5 s has an error of about 0.1 mm",
    ];
    assert!(words.iter().all(|word| told.contains(word)), "{told}");
    let parameters = at.join("T/Parameters.xml");
    let text = fs::read_to_string(&parameters).unwrap();
    fs::write(&parameters, text.replace("2e-6", "2e-4")).unwrap();
    assert!(
        note(at).contains("2e-4 s: stable (up to 8.4e-4 s), with an error of about 1.7 mm"),
        "{}",
        note(at)
    );
    fs::write(&parameters, text.replace("2e-6", "1e-3")).unwrap();
    assert!(note(at).contains("1e-3 s: not stable (up to 8.4e-4 s)"), "{}", note(at));
}
