//! People who leave: from an empty room to nobody there.

use crate::common::{assert_code, decision_library, done, err, joined, lemons, out};
use lemons_record::Run;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A room with a door of 1 m, and ten people who leave.
fn room() -> TempDir {
    decision_library();
    let directory = TempDir::new().unwrap();
    let crowd = ["crowd", "-n", "10", "--box", "4x3", "--door", "4,1.5,1", "--leave", "-o", "room"];
    done(directory.path(), &crowd);
    directory
}

/// The rows of a table: cells by name.
fn rows(at: &Path, name: &str) -> Vec<Vec<(String, String)>> {
    let text = fs::read_to_string(at.join(name)).unwrap();
    // A sweep says of what it is.
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    lines
        .map(|line| {
            names.iter().map(|name| (*name).to_owned()).zip(line.split(',').map(str::to_owned)).collect()
        })
        .collect()
}

fn cell<'a>(row: &'a [(String, String)], name: &str) -> &'a str {
    &row.iter().find(|(column, _)| column == name).unwrap().1
}

#[test]
fn everybody_leaves_and_the_tables_say_when() {
    let directory = room();
    let at = directory.path();
    let said = out(&done(at, &["run", "room", "--until", "left", "-o", "run.csv"]));
    assert!(said.contains("simulated time"), "{said}");
    let table = rows(at, "run.csv");
    let (first, last) = (table[0].clone(), table.last().unwrap().clone());
    assert_eq!((cell(&first, "active"), cell(&last, "active")), ("1", "0"));
    for id in 0..10 {
        let own: Vec<_> = table.iter().filter(|row| cell(row, "id") == id.to_string()).collect();
        let there = own.iter().take_while(|row| cell(row, "active") == "1").count();
        assert!(own[there..].iter().all(|row| cell(row, "active") == "0"), "nobody comes back");
        // Beyond the door, and from then on they stand and touch nothing.
        let x: f64 = cell(own[there - 1], "x").parse().unwrap();
        assert!(x > 4.5, "agent {id} left at x = {x}");
        for row in &own[(there + 1).min(own.len())..] {
            assert_eq!(cell(row, "x"), cell(own.last().unwrap(), "x"));
            assert_eq!((cell(row, "vx"), cell(row, "mean_normal_force")), ("0.0", "0.0"));
        }
    }
    // The last row is of the first time at which nobody is there.
    let end = cell(&last, "t");
    let left = table.iter().filter(|row| cell(row, "active") == "1").map(|row| cell(row, "t")).next_back();
    assert_ne!(left, Some(end));
    let outputs = rows(at, "run_outputs.csv");
    assert_eq!(cell(outputs.last().unwrap(), "decision.Arrived"), "10");
}

#[test]
fn both_versions_of_fmi_threads_and_a_break_give_the_same_bytes() {
    let directory = room();
    let at = directory.path();
    done(at, &["run", "room", "--until", "8", "-o", "run.csv"]);
    let wanted = fs::read(at.join("run.csv")).unwrap();
    let same = |name: &str| assert!(fs::read(at.join(name)).unwrap() == wanted, "{name}");
    for version in ["2", "3"] {
        done(at, &["decide", "--fmi", version, "room", "-o", "decision.fmu", "--force"]);
        done(at, &["pack", "--fmi", version, "room", "-o", "crowd.fmu", "--force"]);
        done(at, &["connect", "decision.fmu", "crowd.fmu", "-o", "both.ssp", "--force"]);
        let name = format!("fmi{version}.csv");
        done(at, &["run", "both.ssp", "--until", "8", "-o", &name, "--outputs", "o.csv", "--force"]);
        same(&name);
    }
    done(at, &["run", "room", "--until", "8", "--threads", "2", "-o", "threads.csv", "--outputs", "p.csv"]);
    same("threads.csv");
    // In the middle some have left.
    let half =
        ["run", "room", "--until", "4", "-o", "broken.csv", "--outputs", "q.csv", "--state", "half.run"];
    done(at, &half);
    let gone = rows(at, "broken.csv").iter().filter(|row| cell(row, "active") == "0").count();
    assert!(gone > 0, "somebody has left before the break");
    let rest =
        ["run", "room", "--until", "8", "-o", "rest.csv", "--outputs", "r.csv", "--resume", "half.run"];
    done(at, &rest);
    assert!(joined(at, &["broken.csv", "rest.csv"]) == wanted);
}

#[test]
fn pictures_and_exports_leave_out_who_has_left() {
    let directory = room();
    let at = directory.path();
    done(at, &["run", "room", "--until", "6", "-o", "run.csv"]);
    let table = rows(at, "run.csv");
    let there = |row: &&Vec<(String, String)>| cell(row, "active") == "1";
    done(at, &["export", "--to", "pedpy", "run.csv", "run.txt"]);
    let exported = fs::read_to_string(at.join("run.txt")).unwrap();
    let exported = exported.lines().filter(|line| !line.starts_with('#')).count();
    assert_eq!(exported, table.iter().filter(there).count());
    assert!(exported < table.len());
    // Each body of a picture names its person.
    let shown = |time: &str| {
        done(at, &["plot", "run.csv", "--trial", "room", "--at", time, "-o", "scene.svg", "--force"]);
        let picture = fs::read_to_string(at.join("scene.svg")).unwrap();
        (0..10).filter(|id| picture.contains(&format!("<title>{id}</title>"))).collect::<BTreeSet<i32>>()
    };
    let end = table.iter().filter(|row| cell(row, "t") == "6.0");
    let present: BTreeSet<i32> = end.filter(there).map(|row| cell(row, "id").parse().unwrap()).collect();
    assert!(present.len() < 10, "somebody has left");
    assert_eq!((shown("0").len(), shown("6")), (10, present));
}

#[test]
fn movies_and_plots_end_when_everybody_has_left() {
    let directory = room();
    let at = directory.path();
    done(at, &["run", "room", "--until", "left", "-o", "run.csv"]);
    let end: f64 = cell(rows(at, "run.csv").last().unwrap(), "t").parse().unwrap();
    let longer = format!("{:?}", end + 2.0);
    done(at, &["run", "room", "--until", &longer, "-o", "longer.csv", "--outputs", "o.csv"]);
    let movie = |source: &[&str]| {
        let look = ["--until", "left", "--width", "64", "--frame-rate", "10", "-o", "left.png", "--force"];
        lemons(at, &[&["movie"], source, &look].concat())
    };
    for source in [&["room"][..], &["run.csv", "--trial", "room"], &["longer.csv", "--trial", "room"]] {
        let made = movie(source);
        assert!(made.status.success() && made.stderr.is_empty(), "{source:?}: {}", err(&made));
        let file = std::io::BufReader::new(fs::File::open(at.join("left.png")).unwrap());
        let frames =
            png::Decoder::new(file).read_info().unwrap().info().animation_control().unwrap().num_frames;
        assert_eq!(frames, (10.0 * end + 1e-6).floor() as u32 + 1, "{source:?}");
    }
    let plotted = |source: &[&str], kind: &[&str]| {
        done(at, &[&["plot"], source, kind, &["-o", "plot.svg", "--force"]].concat());
        fs::read_to_string(at.join("plot.svg")).unwrap()
    };
    for kind in [&["--density"][..], &["--series", "speed"]] {
        let made = plotted(&["room", "--until", "left"], kind);
        assert!(made == plotted(&["run.csv", "--trial", "room"], kind), "{kind:?}");
        // Without it, 5 s are shown: nobody has left then.
        assert!(made != plotted(&["room"], kind), "{kind:?}");
    }
    let earlier = lemons(at, &["plot", "run.csv", "--series", "speed", "--until", "left"]);
    assert_code(&earlier, 2);
    assert!(err(&earlier).contains("earlier results have an end"), "{}", err(&earlier));
    done(at, &["run", "room", "--no-plan", "--until", "0.5", "-o", "stay.csv"]);
    let stay = movie(&["stay.csv", "--trial", "room"]);
    assert_code(&stay, 1);
    assert!(err(&stay).contains("stay.csv: nobody leaves"), "{}", err(&stay));
    let stay = movie(&["room", "--no-plan"]);
    assert!(err(&stay).contains("--until left: nobody can leave"), "{}", err(&stay));
    // Two who stay at a goal.
    let wishes = fs::read_to_string(at.join("room/decision.toml")).unwrap();
    let goal = "goals = [{ name = \"here\", line = [[0.5, 1.0], [0.5, 2.0]] }]\n";
    let who = "[agents.0]\ngoal = \"here\"\n[agents.1]\ngoal = \"here\"\n";
    fs::write(at.join("room/decision.toml"), format!("{goal}{wishes}{who}")).unwrap();
    let some = movie(&["room"]);
    assert_code(&some, 0);
    assert!(err(&some).contains("2 of 10 people stay: the movie ends at t = "), "{}", err(&some));
}

#[test]
fn a_run_that_nobody_can_leave_says_so() {
    let directory = room();
    let at = directory.path();
    let said = err(&lemons(at, &["run", "room", "--no-plan", "--until", "left"]));
    assert!(said.contains("--until left: nobody can leave"), "{said}");
    let output = lemons(at, &["run", "room", "--until", "soon"]);
    assert_code(&output, 2);
    assert!(String::from_utf8_lossy(&output.stderr).contains("or the word left"));
    // A wall in the door.
    let geometry = at.join("room/static/Geometry.xml");
    let text = fs::read_to_string(&geometry).unwrap();
    let wall = "<Wall Id=\"shut\" MaterialId=\"concrete\"><Corner Coordinates=\"4,0\"/><Corner Coordinates=\"4,3\"/></Wall></Geometry>";
    fs::write(&geometry, text.replace("</Geometry>", wall)).unwrap();
    for command in ["run", "check"] {
        let output = lemons(at, &[command, "room"]);
        let said = out(&output) + &err(&output);
        assert!(
            said.contains("decision.toml") && said.contains("no way leads to any exit"),
            "{command}: {said}"
        );
    }
}

/// Without `Active`, everything is as before: it is true unless somebody says otherwise.
#[test]
fn somebody_may_be_taken_out_by_hand() {
    let directory = room();
    let at = directory.path();
    done(at, &["run", "room", "--no-plan", "--until", "0.5", "-o", "all.csv"]);
    done(
        at,
        &["run", "room", "--no-plan", "--until", "0.5", "--set", "agent[3].Active=false", "-o", "nine.csv"],
    );
    let (all, nine) = (rows(at, "all.csv"), rows(at, "nine.csv"));
    assert!(nine.iter().all(|row| cell(row, "id") != "3" || cell(row, "agent_contacts") == "0"));
    assert_eq!(all.len(), nine.len());
}

/// Three broad people, and a door that Decision takes for a way and nobody fits through.
#[test]
fn a_run_in_which_nobody_gets_out_ends_and_says_so() {
    decision_library();
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let crowd =
        ["crowd", "-n", "3", "--box", "3x2", "--door", "3,1,0.31", "--fixed", "60,33,1.9,110", "--leave"];
    done(at, &[&crowd[..], &["-o", "shut"]].concat());
    let output =
        done(at, &["run", "shut", "--until", "left", "--step", "0.1", "--every", "50", "-o", "run.csv"]);
    let said = err(&output);
    let expected = "warning: 3 of 3 people have not left: in the last 300 s nobody has left or got further than 5 m; the \
                    run ends at t = 300.000 s (still there: 0, 1, 2)";
    assert!(said.contains(expected), "{said}");
    assert!(out(&output).contains("left                        0     (of 3 people)"), "{}", out(&output));
    assert_eq!(cell(rows(at, "run.csv").last().unwrap(), "t"), "300.0");
    // A sweep of it ends there, too, and does not take it for empty.
    let sweep = "trial = \"shut\"\nuntil = \"left\"\nstep = 0.1\n[parameters]\n\"crowd.Threads\" = [1]\n[measures]\n\
                 there = { of = \"agent[*].Position.x\", take = \"last\", across = \"max\" }\n\
                 time = { squeeze = \"time\", across = \"min\" }";
    fs::write(at.join("sweep.toml"), sweep).unwrap();
    let said = out(&done(at, &["sweep", "sweep.toml", "-o", "table.csv"]));
    assert!(said.contains("without an end              1     (people stayed"), "{said}");
    let table = rows(at, "table.csv");
    let number = |name: &str| cell(&table[0], name).parse::<f64>().unwrap();
    assert_eq!((cell(&table[0], "ended"), cell(&table[0], "status")), ("", "ok"));
    assert!((number("time") - 300.0).abs() < 1e-6 && number("there") < 3.5, "{table:?}");
}

/// The Trial at the end of a run has those who are there, and what they do: it went on with nobody who walked, told all who
/// had ever been there, and could be empty.
#[test]
fn a_trial_at_the_end_has_who_is_there_and_what_they_do() {
    let directory = room();
    let at = directory.path();
    let plan = fs::read_to_string(at.join("room/decision.toml")).unwrap();
    done(at, &["run", "room", "--until", "6", "-o", "run.csv"]);
    let run = Run::read_table(&at.join("run.csv")).unwrap();
    let last = run.frames.last().unwrap();
    let there: Vec<&str> = last.present().map(|(place, _)| run.ids[place].as_str()).collect();
    let gone: Vec<&str> = run.ids.iter().map(String::as_str).filter(|id| !there.contains(id)).collect();
    assert!(there.len() > 2 && gone.len() > 2, "{there:?} {gone:?}");
    let export =
        |table: &str, to: &str| lemons(at, &["export", table, to, "--to", "trial", "--trial", "room"]);
    let output = export("run.csv", "end");
    assert_code(&output, 0);
    // A series of files does not say who is there.
    assert!(!err(&output).contains("OutputDirectory"), "{}", err(&output));
    done(at, &["run", "room", "--until", "0.1", "--set", "OutputDirectory=series", "-o", "s.csv"]);
    let refused = export("series", "back");
    assert_code(&refused, 1);
    assert!(
        err(&refused).contains("series: an OutputDirectory does not say who has left"),
        "{}",
        err(&refused)
    );
    assert!(!at.join("back").exists());
    assert_eq!(out(&output), format!("end: {} agents as at t = 6.0 s\n", there.len()));
    assert_eq!(fs::read_to_string(at.join("end/decision.toml")).unwrap(), plan, "nobody of its own");
    // It goes on: more have left in the end than before.
    done(at, &["run", "end", "--until", "4", "-o", "on.csv"]);
    let on = Run::read_table(&at.join("on.csv")).unwrap();
    assert_eq!(on.ids, there);
    assert!(on.frames.last().unwrap().present().count() < there.len());
    // Wishes of those who have left are left out, and those of the others kept.
    let own = format!(
        "{plan}\n\n[agents.{}]\ndesired_speed = 0.9\n[agents.{}]\ndesired_speed = 1.1\n",
        gone[0], there[0]
    );
    fs::write(at.join("room/decision.toml"), own).unwrap();
    assert_code(&export("run.csv", "fewer"), 0);
    let fewer = fs::read_to_string(at.join("fewer/decision.toml")).unwrap();
    assert!(
        fewer.contains(&format!("[agents.{}]", there[0])) && fewer.contains("desired_speed = 1.1"),
        "{fewer}"
    );
    assert!(!fewer.contains("0.9"), "{fewer}");
    done(at, &["check", "fewer"]);
    // Nobody is left.
    fs::write(at.join("room/decision.toml"), &plan).unwrap();
    done(at, &["run", "room", "--until", "left", "-o", "left.csv"]);
    let output = export("left.csv", "empty");
    assert_code(&output, 1);
    assert!(err(&output).contains("left.csv: nobody is there at its end, t = "), "{}", err(&output));
    assert!(!at.join("empty").exists());
}
