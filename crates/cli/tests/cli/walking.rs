//! Runs of a Trial whose people walk by its `decision.toml`.

use crate::common::{assert_code, command, decision_library, done, err, joined, lemons, out, root, waits};
use crate::walked_sweep::{number, read_csv};
use crowd_mechanics::setup;
use lemons_record::Run;
use lemons_testing::trial_push;
use lemons_trial::Trial;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::Stdio;
use tempfile::TempDir;

/// A copy of the shipped Trial, and its two FMUs coupled by hand.
pub fn door() -> TempDir {
    decision_library();
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    copy(&root().join("resources/Trial_door"), &at.join("T"));
    done(at, &["decide", "T", "-o", "decision.fmu"]);
    done(at, &["pack", "T", "-o", "crowd.fmu"]);
    done(at, &["connect", "decision.fmu", "crowd.fmu", "-o", "x.ssp"]);
    directory
}

pub fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let place = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &place)
        } else {
            fs::copy(entry.path(), place).unwrap();
        }
    }
}

/// A zip of a Trial's files.
fn zipped(trial: &Path, to: &Path) {
    let mut zip = zip::ZipWriter::new(fs::File::create(to).unwrap());
    let mut left = vec![trial.to_owned()];
    while let Some(directory) = left.pop() {
        for entry in fs::read_dir(directory).unwrap().map(Result::unwrap) {
            if entry.path().is_dir() {
                left.push(entry.path());
                continue;
            }
            let name = entry.path().strip_prefix(trial).unwrap().to_str().unwrap().to_owned();
            zip.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
            zip.write_all(&fs::read(entry.path()).unwrap()).unwrap();
        }
    }
    zip.finish().unwrap();
}

/// What a run writes: both tables.
fn tables(at: &Path, input: &str, options: &[&str]) -> [Vec<u8>; 2] {
    let run = ["run", input, "-o", "poses.csv", "--outputs", "drives.csv", "--force"];
    done(at, &[&run[..], options].concat());
    ["poses.csv", "drives.csv"].map(|name| fs::read(at.join(name)).unwrap())
}

#[test]
fn one_command_is_what_the_coupled_fmus_are() {
    let directory = door();
    let at = directory.path();
    let both =
        ["--until", "1", "--set", "decision.agent[3].DesiredSpeed=0.5", "--set", "crowd.agent[0].Mass=90"];
    for (options, of_ssp) in [
        (&["--until", "3"][..], &["--until", "3"][..]),
        (&["--until", "1", "--algorithm", "gauss-seidel"], &["--until", "1", "--algorithm", "gauss-seidel"]),
        (
            &["--until", "1", "--set", "TimeStepMechanical=5e-5", "--threads", "2"],
            &["--until", "1", "--set", "crowd.TimeStepMechanical=5e-5", "--set", "crowd.Threads=2"],
        ),
        (&both, &both),
    ] {
        assert!(tables(at, "T", options) == tables(at, "x.ssp", of_ssp), "{options:?}");
    }
    // A zip of the Trial is the Trial.
    zipped(&at.join("T"), &at.join("T.zip"));
    assert!(tables(at, "T.zip", &["--until", "1"]) == tables(at, "x.ssp", &["--until", "1"]));
    // They go through the door, at 5 m.
    let poses = String::from_utf8(tables(at, "T", &["--until", "6"])[0].clone()).unwrap();
    let last = poses.lines().filter(|line| line.starts_with("6.0,"));
    let beyond = last.filter(|line| line.split(',').nth(2).unwrap().parse::<f64>().unwrap() > 5.2).count();
    assert!(beyond >= 8, "{beyond} of 30");
}

#[test]
fn a_walk_is_saved_and_goes_on() {
    let directory = door();
    let at = directory.path();
    let whole = tables(at, "T", &["--until", "2"]);
    tables(at, "T", &["--until", "1", "--state", "half.run"]);
    // Way-points belong to the run.
    let wishes = fs::read_to_string(at.join("T/decision.toml")).unwrap();
    fs::write(at.join("T/decision.toml"), wishes.replace("x = 30.0", "x = -30.0")).unwrap();
    let rest =
        ["run", "T", "-o", "rest.csv", "--outputs", "drives_2.csv", "--resume", "half.run", "--until", "2"];
    let other = lemons(at, &rest);
    assert_code(&other, 1);
    assert!(err(&other).contains("another plan"), "{}", err(&other));
    fs::write(at.join("T/decision.toml"), wishes).unwrap();
    // Whether people walk, too, in words that say how to go on.
    let other = lemons(at, &[&rest[..], &["--no-plan"]].concat());
    assert_code(&other, 1);
    assert!(
        err(&other).contains("people walked by a file") && err(&other).contains("without --no-plan"),
        "{}",
        err(&other)
    );
    done(at, &rest);
    let now = [["poses.csv", "rest.csv"], ["drives.csv", "drives_2.csv"]].map(|parts| joined(at, &parts));
    assert!(now == whole);
    // A run in which nobody walked goes on so.
    let still = ["run", "T", "--set", "agent[2].Fp.x=90", "--no-plan", "--until", "0.4", "-o", "whole.csv"];
    done(at, &still);
    done(at, &[&still[..5], &["--until", "0.2", "-o", "still.csv", "--state", "still.run"]].concat());
    let rest = ["run", "T", "--resume", "still.run", "--until", "0.4", "-o", "still_2.csv"];
    let other = lemons(at, &rest);
    assert_code(&other, 1);
    let said = "now people would walk (T/decision.toml): give --no-plan to go on as before";
    assert!(err(&other).contains(said), "{}", err(&other));
    done(at, &[&rest[..], &["--no-plan"]].concat());
    assert!(joined(at, &["still.csv", "still_2.csv"]) == fs::read(at.join("whole.csv")).unwrap());
}

/// The finer of both runs, with its step, is the run of the coupled FMUs with this step.
#[test]
fn two_runs_of_a_walk_are_compared() {
    let directory = door();
    let at = directory.path();
    let run = ["run", "T", "--until", "0.5", "--accuracy", "1e-3", "-o", "a.csv", "--outputs", "b.csv"];
    let said = out(&done(at, &run));
    let (_, half) = said.split_once("s and ").unwrap();
    let (half, rest) = half.split_once(" s").unwrap();
    assert!(rest.starts_with(" of crowd: the results are of the second run"), "{said}");
    assert!(said.contains("is met"), "{said}");
    let step = format!("crowd.TimeStepMechanical={half}");
    let [poses, drives] = tables(at, "x.ssp", &["--until", "0.5", "--set", &step]);
    assert!(fs::read(at.join("a.csv")).unwrap() == poses && fs::read(at.join("b.csv")).unwrap() == drives);
}

/// The second run found it empty and waited for ever.
#[test]
#[cfg(unix)]
fn a_pipe_is_read_once_and_a_run_that_waits_for_it_can_be_stopped() {
    let directory = door();
    let at = directory.path();
    assert!(std::process::Command::new("mkfifo").arg(at.join("pipe")).status().unwrap().success());
    for (option, trial) in [("--plan", "T"), ("--drive", "T")] {
        let output = lemons(at, &["run", trial, option, "pipe", "--accuracy", "1e-3"]);
        assert_code(&output, 2);
        let said = format!("{option} pipe: --accuracy runs twice, and a pipe can be read only once");
        assert!(err(&output).contains(&said), "{}", err(&output));
    }
    let mut command = command(at, &["run", "T", "--plan", "pipe", "-o", "never.csv"]);
    let running = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    waits(&running);
    let signal = std::process::Command::new("kill").args(["-TERM", &running.id().to_string()]).status();
    assert!(signal.unwrap().success());
    let output = running.wait_with_output().unwrap();
    assert_code(&output, 130);
    assert!(!at.join("never.csv").exists());
    assert!(err(&output).contains("interrupted: nothing was written"), "{}", err(&output));
    // Somebody writes it: it is the file.
    let plan = fs::read(at.join("T/decision.toml")).unwrap();
    let pipe = at.join("pipe");
    let writer = std::thread::spawn(move || fs::write(pipe, plan).unwrap());
    let piped = tables(at, "T", &["--until", "0.5", "--plan", "pipe"]);
    writer.join().unwrap();
    assert!(piped == tables(at, "T", &["--until", "0.5"]));
}

/// A link that leads nowhere is a file with an error, and not a Trial in which nobody walks.
#[test]
#[cfg(unix)]
fn all_commands_know_a_plan_that_is_a_broken_link() {
    let directory = door();
    let at = directory.path();
    fs::remove_file(at.join("T/decision.toml")).unwrap();
    std::os::unix::fs::symlink("nowhere.toml", at.join("T/decision.toml")).unwrap();
    sweep_of(at, "");
    for (arguments, code) in [
        (&["run", "T"][..], 1),
        (&["check", "T"], 3),
        (&["decide", "T", "-o", "new.fmu"], 1),
        (&["sweep", "sweep.toml"], 1),
    ] {
        let output = lemons(at, arguments);
        assert_code(&output, code);
        let said = out(&output) + &err(&output);
        assert!(said.contains("T/decision.toml: cannot be read: "), "{arguments:?}: {said}");
    }
}

/// Masses and dampings are in both FMUs: a name set those of one, and walkers reached 5.6 m/s.
#[test]
fn a_name_without_a_component_sets_what_both_have() {
    let directory = door();
    let at = directory.path();
    // Everybody walks on without meeting anybody: the speed is the desired one, whatever mass and damping are.
    fs::write(at.join("T/decision.toml"), "desired_speed = 1.25\nwaypoints = [{ x = 500, y = 2.5 }]\n")
        .unwrap();
    let agents = fs::read_to_string(at.join("T/static/Agents.xml")).unwrap();
    let first = agents.find("</Agent>").unwrap() + "</Agent>".len();
    let one = agents[..first].to_owned() + "\n</Agents>\n";
    fs::create_dir(at.join("edited")).unwrap();
    copy(&at.join("T"), &at.join("edited/T"));
    let dynamics = fs::read_to_string(at.join("T/dynamic/AgentDynamics.xml")).unwrap();
    let first = dynamics.find("</Agent>").unwrap() + "</Agent>".len();
    let edited = one.replace("Mass=\"78.0\"", "Mass=\"40\"").replace("Damping=\"4.50\"", "Damping=\"1\"");
    for (trial, agents) in [("T", &one), ("edited/T", &edited)] {
        fs::write(at.join(trial).join("static/Agents.xml"), agents).unwrap();
        let dynamics = dynamics[..first].to_owned() + "\n</Agents>\n";
        fs::write(at.join(trial).join("dynamic/AgentDynamics.xml"), dynamics).unwrap();
        fs::write(at.join(trial).join("static/Geometry.xml"), GEOMETRY).unwrap();
    }
    let set = [
        "--set",
        "agent[*].Mass=40",
        "--set",
        "agent[*].FloorDamping=1",
        "--set",
        "agent[0].AngularDamping=1",
    ];
    let until = ["--until", "9"];
    let both = done(at, &[&["run", "T", "-o", "poses.csv"][..], &until, &set].concat());
    assert_eq!(err(&both), "");
    let poses = read_csv(&at.join("poses.csv"));
    let last = poses.last().unwrap();
    let speed = number(last, "vx").hypot(number(last, "vy"));
    assert!((speed - 1.25).abs() < 0.001, "{speed}");
    // As an edited Trial; also in a picture and a sweep.
    done(at, &[&["run", "edited/T", "-o", "edited.csv"][..], &until].concat());
    assert!(fs::read(at.join("poses.csv")).unwrap() == fs::read(at.join("edited.csv")).unwrap());
    let plot = |trial: &str, options: &[&str]| {
        done(at, &[&["plot", trial, "-o", "x.svg", "--force", "--at", "9"][..], options].concat());
        fs::read(at.join("x.svg")).unwrap()
    };
    assert!(plot("T", &set) == plot("edited/T", &[]) && plot("T", &[]) != plot("edited/T", &[]));
    let spec = "trial = \"T\"\nuntil = 9\n[parameters]\n\"agent[*].Mass\" = [40]\n\"agent[*].FloorDamping\" = [1]\n\
                \"agent[0].AngularDamping\" = [1]\n[measures]\nx = { of = \"x\", take = \"last\", across = \"max\" }\n";
    fs::write(at.join("sweep.toml"), spec).unwrap();
    done(at, &["sweep", "sweep.toml", "-o", "table.csv"]);
    assert_eq!(number(&read_csv(&at.join("table.csv"))[0], "x"), number(last, "x"));
    // Who names a component means it, and is told.
    done(at, &["decide", "T", "-o", "decision.fmu", "--force"]);
    done(at, &["pack", "T", "-o", "crowd.fmu", "--force"]);
    done(at, &["connect", "decision.fmu", "crowd.fmu", "-o", "x.ssp", "--force"]);
    for input in ["T", "x.ssp"] {
        let one = ["run", input, "--until", "0.1", "--force", "--set", "crowd.agent[*].Mass=40"];
        let said =
            "warning: agent[0].Mass is 78.0 in decision, but 40.0 in crowd (of 1 person): set it in both\n";
        assert_eq!(err(&done(at, &one)), said);
        assert_eq!(err(&done(at, &[&one[..], &["--set", "decision.agent[*].Mass=40"]].concat())), "");
    }
}

const GEOMETRY: &str = "<Geometry><Dimensions Lx=\"10\" Ly=\"10\"/></Geometry>";

/// A sweep of one point.
fn sweep_of(at: &Path, more: &str) {
    let text = "until = 0.1\n[parameters]\n\"agent[0].Mass\" = [60.0]\n[measures]\n\
                x = { of = \"x\", take = \"last\", across = \"max\" }\n";
    fs::write(at.join("sweep.toml"), format!("trial = \"T\"\n{more}\n{text}")).unwrap();
}

#[test]
fn another_plan_or_none_can_be_chosen() {
    let directory = door();
    let at = directory.path();
    fs::write(at.join("back.toml"), "waypoints = [{ x = -9, y = 2 }]").unwrap();
    done(at, &["decide", "T", "--plan", "back.toml", "-o", "decision.fmu", "--force"]);
    done(at, &["connect", "decision.fmu", "crowd.fmu", "-o", "back.ssp"]);
    let back = tables(at, "back.ssp", &["--until", "0.5"]);
    assert!(tables(at, "T", &["--until", "0.5", "--plan", "back.toml"]) == back);
    // Nobody moves, and that is said.
    let still = done(at, &["run", "T", "--no-plan", "--until", "0.5", "-o", "still.csv"]);
    assert!(err(&still).contains("note: nobody is driven: neither decision.toml"), "{}", err(&still));
    assert!(!out(&still).contains("components"));
    let driven =
        done(at, &["run", "T", "--no-plan", "--set", "agent[2].Fp.x=9", "--until", "0.5", "-o", "still.csv"]);
    assert_eq!(err(&driven), "");
    // A drive of the Trial is not added in silence.
    fs::write(at.join("T/drive.csv"), "t,agent,Fp.x,Fp.y,Mp\n0,2,100,0,0\n1,2,100,0,0\n").unwrap();
    let both = done(at, &["run", "T", "--plan", "back.toml", "--until", "0.5", "-o", "both.csv"]);
    let note = |plan: &str| {
        format!("note: the forces of drive.csv are added to those with which people walk ({plan})")
    };
    assert!(err(&both).contains(&note("back.toml")), "{}", err(&both));
    assert!(fs::read(at.join("both.csv")).unwrap() != back[0]);
    assert!(tables(at, "T", &["--until", "0.5", "--plan", "back.toml", "--no-drive"]) == back);
    // `check` says it, and what the drive does.
    fs::write(at.join("T/drive.csv"), "t,agent,Fp.x,Fp.y,Mp\n0.01,2,100,0,0\n0.02,2,100,0,0\n").unwrap();
    let checked = out(&done(at, &["check", "T"]));
    assert!(checked.contains(&note("T/decision.toml")), "{checked}");
    assert!(checked.contains("warning: T/drive.csv: ") && checked.contains("1 warning"), "{checked}");
    let packed = done(at, &["pack", "T", "-o", "again.fmu"]);
    let said =
        "note: T/decision.toml is not in this FMU, which is the crowd alone: lemons decide T -o FILE.fmu";
    assert!(err(&packed).contains(said), "{}", err(&packed));
    fs::write(at.join("T/drive.csv"), "t,agent,Fp.x,Fp.y,Mp\n0,2,100,0,0\n1,2,100,0,0\n").unwrap();
    let driven = done(at, &["run", "T", "--no-plan", "--until", "0.5", "-o", "still.csv"]);
    assert_eq!(err(&driven), "");
    // A picture shows them walk, too.
    let plot = |name: &str, options: &[&str]| {
        done(at, &[&["plot", "T", "-o", name, "--at", "2"][..], options].concat());
        fs::read(at.join(name)).unwrap()
    };
    let walk = plot("walk.svg", &[]);
    assert!(walk != plot("stand.svg", &["--no-plan", "--no-drive"]));
    // With the parameters of a run, whose names are those of `lemons run`: as the table of that run shows it.
    let slow = ["--set", "decision.agent[3].DesiredSpeed=0.1", "--set", "crowd.TimeStepMechanical=2e-4"];
    done(at, &[&["run", "T", "--until", "2", "-o", "slow.csv"][..], &slow].concat());
    let picture = plot("slow.svg", &slow);
    done(at, &["plot", "slow.csv", "--trial", "T", "-o", "of_table.svg", "--at", "2"]);
    assert!(picture == fs::read(at.join("of_table.svg")).unwrap() && picture != walk);
}

/// One person in the open.
fn alone(at: &Path, plan: &str) -> Trial {
    decision_library();
    let (mut trial, _) = setup::read(&trial_push()).unwrap();
    trial.agents.truncate(1);
    trial.dynamics.truncate(1);
    trial.geometry.walls.clear();
    trial.write(&at.join("T")).unwrap();
    fs::write(at.join("T/decision.toml"), plan).unwrap();
    trial
}

/// A walker with eq. 4 alone has the force m v0 γ. With a constant force F beside it, and the floor's friction, the way is
/// (v0 + F / (m γ)) (t − (1 − exp(−γ t)) / γ): of both algorithms, in a run, in a run that goes on, and in a sweep.
#[test]
fn a_drive_is_added_to_how_people_walk() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let trial = alone(at, "desired_speed = 1.3\nwaypoints = [{ x = 1000, y = 0 }]");
    fs::write(at.join("push.csv"), "t,agent,Fp.x,Fp.y,Mp\n0,0,120,0,0\n9,0,120,0,0\n").unwrap();
    let (mass, rate, until) = (trial.agents[0].mass, trial.agents[0].floor_damping, 2.0);
    let way = |force: f64| (1.3 + force / (mass * rate)) * (until - (1.0 - (-rate * until).exp()) / rate);
    let end = |name: &str| {
        Run::read_table(&at.join(name)).unwrap().frames.last().unwrap().agents[0].pose.position.x
    };
    let near =
        |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    assert!(way(120.0) > 1.2 * way(0.0));
    let run = |options: &[&str]| {
        let run = ["run", "T", "--until", "2", "-o", "x.parquet", "--force"];
        done(at, &[&run[..], options].concat());
        end("x.parquet")
    };
    near(run(&[]), way(0.0));
    for algorithm in ["jacobi", "gauss-seidel"] {
        near(run(&["--drive", "push.csv", "--algorithm", algorithm]), way(120.0));
    }
    let options = ["--drive", "push.csv", "--algorithm", "gauss-seidel"];
    for part in [
        ["-o", "whole.csv", "--until", "2", "--state", "b.run"],
        ["-o", "1.csv", "--until", "1", "--state", "a.run"],
        ["-o", "2.csv", "--until", "2", "--resume", "a.run"],
    ] {
        done(at, &[&["run", "T"], &part[..], &options].concat());
    }
    assert!(joined(at, &["1.csv", "2.csv"]) == fs::read(at.join("whole.csv")).unwrap());
    let sweep = "trial = \"T\"\nuntil = 2\ndrive = \"push.csv\"\n[parameters]\n\"agent[0].Theta\" = [0.0, 0.0]\n\
                 [measures]\nx = { of = \"x\", take = \"last\", across = \"max\" }\n";
    fs::write(at.join("sweep.toml"), sweep).unwrap();
    done(at, &["sweep", "sweep.toml", "-o", "swept.csv"]);
    let rows = read_csv(&at.join("swept.csv"));
    assert_eq!(rows.len(), 2);
    rows.iter().for_each(|row| near(number(row, "x"), way(120.0)));
}

/// Twelve in a closed room who want to be beyond its wall.
#[test]
fn people_who_press_on_in_vain_are_told_at_the_end() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    decision_library();
    let room = ["--box", "2x2", "--number", "12", "--seed", "1"];
    done(at, &[&["crowd", "-o", "T"], &room[..]].concat());
    let told = |model: &str, until: &str| {
        let plan = format!("model = {model:?}\nwaypoints = [{{ x = 50, y = 1 }}]");
        fs::write(at.join("T/decision.toml"), plan).unwrap();
        err(&done(at, &["run", "T", "--until", until, "-o", "x.csv", "--force"]))
    };
    let words = "of the 12 people who are there press on and get no further (median squeeze ";
    let said = told("straight", "6");
    assert!(said.contains("warning: at t = 6.000 s ") && said.contains(words), "{said}");
    let squeeze: f64 = said.split(words).nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!(squeeze > 50.0, "{said}");
    // They walk first; and of a model that keeps distances it is not told.
    assert!(!told("straight", "0.5").contains("press on"));
    assert!(!told("collision-free-speed", "6").contains("press on"));
}

/// Only a whole name that another component had was ever guessed.
#[test]
fn a_misspelt_variable_is_refused_with_the_right_one() {
    let directory = door();
    let at = directory.path();
    done(at, &["pack", "T", "--fmi", "3", "-o", "crowd_3.fmu"]);
    for (input, name, meant) in [
        ("T", "agent[3].Mas", "agent[3].Mass"),
        ("T", "agent[*].MomentOfinertia", "agent[*].MomentOfInertia"),
        ("T", "TimeStepMechanicl", "TimeStepMechanical"),
        ("T", "crowd.agent[3].Mas", "crowd.agent[3].Mass"),
        ("T", "decision.agent[29].DesiredSped", "decision.agent[29].DesiredSpeed"),
        ("T", "contact.concrete.human_naked.KineticFrictoin", "contact.concrete.human_naked.KineticFriction"),
        ("x.ssp", "decision.agent[3].DesiredSped", "decision.agent[3].DesiredSpeed"),
        ("crowd.fmu", "agent[3].mass", "agent[3].Mass"),
        ("crowd_3.fmu", "agent[3].Positoin.x", "agent[3].Position.x"),
    ] {
        let output = lemons(at, &["run", input, "--set", &format!("{name}=1")]);
        assert_code(&output, 1);
        let said = err(&output);
        assert!(said.contains(&format!("did you mean --set {meant}=1?")), "{input} {name}: {said}");
    }
    let plot = lemons(at, &["plot", "T", "--set", "agent[3].Mas=1", "-o", "x.svg"]);
    assert!(err(&plot).contains("did you mean \"agent[3].Mass\"?"), "{}", err(&plot));
    // There is no such person, or nothing like it.
    for name in ["agent[99].Mass", "colour"] {
        let output = lemons(at, &["run", "T", "--set", &format!("{name}=1")]);
        assert_code(&output, 1);
        assert!(
            !err(&output).contains("did you mean") && err(&output).contains("see lemons info"),
            "{}",
            err(&output)
        );
    }
}

#[test]
fn mistakes_are_refused_with_their_place() {
    let directory = door();
    let at = directory.path();
    fs::write(at.join("T/drive.csv"), "t,agent,Fp.x,Fp.y,Mp\n0,2,100,0,0\n").unwrap();
    fs::write(at.join("wrong.toml"), "waypoint = []").unwrap();
    for (arguments, code, said) in [
        (
            &["run", "crowd.fmu", "--plan", "wrong.toml"][..],
            2,
            "--plan: a file like decision.toml is for a Trial",
        ),
        (&["run", "x.ssp", "--plan", "wrong.toml"], 2, "--plan: a file like decision.toml is for a Trial"),
        (&["run", "T", "--plan", "wrong.toml"], 1, "wrong.toml: "),
        (&["run", "T", "--plan", "nothing.toml"], 1, "nothing.toml: cannot be read: "),
        (&["run", "T", "--set", "crowds.Threads=2"], 1, "crowds.Threads"),
        (&["run", "T", "-o", "T/decision.toml"], 1, "T/decision.toml: lemons run reads it"),
        (&["plot", "x.csv", "--no-plan"], 2, "--no-plan"),
        (
            &["run", "T", "--set", "agent[3].DesiredSpeed=1"],
            1,
            "there is no such variable; did you mean --set decision.agent[3].DesiredSpeed=1?",
        ),
        (
            &[
                "plot",
                "T",
                "--no-plan",
                "--set",
                "decision.agent[3].DesiredSpeed=1",
                "--at",
                "1",
                "-o",
                "x.svg",
            ],
            1,
            "--set decision.agent[3].DesiredSpeed=1: there is no variable",
        ),
    ] {
        let output = lemons(at, arguments);
        assert_code(&output, code);
        assert!(err(&output).contains(said), "{arguments:?}: {}", err(&output));
    }
    // The Trial's own file is named as the user knows it.
    fs::write(at.join("T/decision.toml"), "desired_speed = -1\nwaypoints = [{ x = 1, y = 1 }]").unwrap();
    let output = lemons(at, &["run", "T"]);
    let said = "T/decision.toml: agent \"0\": desired_speed = -1.0: must be from 0 to 1e9";
    assert!(err(&output).contains(said), "{}", err(&output));
}
