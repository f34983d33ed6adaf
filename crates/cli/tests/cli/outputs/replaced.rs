//! Which files that are there are replaced.

use super::{begun, content, copy, ended, mkfifo, piped, send, text, wait_for};
use crate::common::{assert_code, default_trial, done, err, lemons, out, waits};
use std::os::unix::fs::symlink;
use tempfile::TempDir;

#[test]
fn results_of_another_trial_or_changed_ones_are_not_replaced() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    copy(&default_trial(), &place.join("first"));
    copy(&default_trial(), &place.join("second"));
    let run = |trial: &'static str| ["run", trial, "--until", "0.1"];
    let table = || std::fs::read_to_string(place.join("trajectories.csv")).unwrap();
    done(place, &run("first"));
    let written = table();
    // Again and again, however it is called, and with other options.
    done(place, &run("first"));
    done(place, &run("second/../first"));
    done(place, &["run", "first", "--until", "0.2"]);
    assert!(table().starts_with(&written) && table() != written);
    done(place, &run("first"));
    let refused = |trial: &'static str, why: &str| {
        let before = table();
        let said = lemons(place, &run(trial));
        assert_code(&said, 1);
        let expected = format!("lemons: cannot write trajectories.csv: {why}; --force replaces it\n");
        assert_eq!(err(&said), expected);
        assert_eq!(table(), before);
    };
    refused("second", "it was made from something else, by `lemons run first --until 0.1`");
    done(place, &["run", "second", "--until", "0.1", "--force"]);
    // Now it is the second one's.
    done(place, &run("second"));
    refused("first", "it was made from something else, by `lemons run second --until 0.1`");
    std::fs::write(place.join("trajectories.csv"), "my notes").unwrap();
    refused("second", "it was changed after `lemons run second --until 0.1` wrote it");
    std::fs::remove_file(place.join("trajectories.csv")).unwrap();
    done(place, &run("first"));
    assert_eq!(table(), written);
    // A stranger's; an empty one holds nothing.
    for output in ["table.parquet", "plot.png", "made.fmu"] {
        let command = match output {
            "table.parquet" => vec!["run", "first", "--until", "0.1", "-o", output],
            "plot.png" => vec!["plot", "first", "--at", "0"],
            _ => vec!["pack", "first", "-o", output],
        };
        std::fs::write(place.join(output), "not ours").unwrap();
        let said = lemons(place, &command);
        assert_code(&said, 1);
        let expected =
            format!("cannot write {output}: it exists already, and lemons has no record of writing it");
        assert!(err(&said).contains(&expected), "{}", err(&said));
        assert_eq!(std::fs::read_to_string(place.join(output)).unwrap(), "not ours");
        std::fs::write(place.join(output), "").unwrap();
        done(place, &command);
        done(place, &command);
    }
    // What a copy holds is nobody's.
    std::fs::rename(place.join("plot.png"), place.join("kept.png")).unwrap();
    assert_code(&lemons(place, &["plot", "first", "--at", "0", "-o", "kept.png"]), 1);
    done(place, &["plot", "first", "--at", "0"]);
}

#[test]
fn a_trial_that_was_edited_by_hand_is_not_replaced() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    let crowd = ["crowd", "--number", "3", "--box", "3x3", "-o", "T"];
    done(place, &crowd);
    done(place, &crowd);
    let untouched = content(&place.join("T"));
    for file in ["Parameters.xml", "static/Geometry.xml", "dynamic/AgentDynamics.xml"] {
        let path = place.join("T").join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, format!("{text}<!-- mine -->\n")).unwrap();
        let edited = content(&place.join("T"));
        let said = lemons(place, &crowd);
        assert_code(&said, 1);
        let expected =
            format!("lemons: cannot write T/{file}: it was changed after `lemons crowd --number 3");
        assert!(err(&said).starts_with(&expected), "{}", err(&said));
        assert!(content(&place.join("T")) == edited, "decided before any file is written");
        done(place, &[&crowd[..], &["--force"]].concat());
        assert!(content(&place.join("T")) == untouched);
    }
    // Springs of somebody's would go.
    std::fs::write(place.join("T/dynamic/AgentInteractions.xml"), "mine").unwrap();
    let said = lemons(place, &crowd);
    assert_code(&said, 1);
    assert!(err(&said).contains("AgentInteractions.xml"), "{}", err(&said));
    std::fs::remove_file(place.join("T/dynamic/AgentInteractions.xml")).unwrap();
    done(place, &["crowd", "--number", "4", "--box", "3x3", "-o", "T"]);
}

/// The stamps were compared when the run began only: what the user wrote in the hour after was lost.
#[test]
fn results_that_are_edited_while_the_command_runs_are_not_replaced() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    let trial = default_trial();
    let run = ["run", trial.to_str().unwrap(), "--until", "0.1"];
    // The run waits for who reads its state when the trajectories are claimed.
    mkfifo(&place.join("state"));
    let (table, new) = (place.join("trajectories.csv"), place.join("trajectories_new.csv"));
    for before in [false, true] {
        if before {
            done(place, &[&run[..], &["--force"]].concat());
        }
        let child = piped(place, &[&run[..], &["--state", "state"]].concat());
        wait_for(|| !begun(place).is_empty());
        std::fs::write(&table, "my notes").unwrap();
        assert!(std::fs::read(place.join("state")).unwrap().starts_with(b"PK"), "the run is saved");
        let output = ended(child);
        assert_code(&output, 1);
        let expected = "lemons: cannot write trajectories.csv: another program changed it while this command \
                        ran, so it was not replaced; the new content is in trajectories_new.csv\n";
        assert_eq!(err(&output), expected);
        assert!(out(&output).contains("greatest peak"), "what was computed is told: {}", out(&output));
        assert_eq!(text(&table), "my notes");
        let kept = text(&new);
        assert!(begun(place).is_empty());
        // It is nobody's but the user's.
        assert_code(&lemons(place, &run), 1);
        assert_eq!(text(&table), "my notes");
        std::fs::remove_file(&new).unwrap();
        done(place, &[&run[..], &["-o", "again.csv"]].concat());
        assert_eq!(text(&place.join("again.csv")), kept, "nothing of the results is lost");
        if before {
            // Who asks for it gets it.
            let child = piped(place, &[&run[..], &["--state", "state", "--force"]].concat());
            wait_for(|| !begun(place).is_empty());
            std::fs::write(&table, "my notes").unwrap();
            std::fs::read(place.join("state")).unwrap();
            assert_code(&ended(child), 0);
            assert_eq!(text(&table), kept);
        }
    }
}

/// Whatever had another stamp at the end was taken for the run's.
#[test]
fn what_the_user_wrote_during_an_interrupted_run_is_not_taken_for_its_result() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    let trial = default_trial();
    let run = ["run", trial.to_str().unwrap(), "--until", "0.1"];
    mkfifo(&place.join("state"));
    let child = piped(place, &[&run[..], &["--state", "state"]].concat());
    wait_for(|| !begun(place).is_empty());
    std::fs::write(place.join("trajectories.csv"), "my notes").unwrap();
    send("-INT", &child);
    assert_code(&ended(child), 130);
    let output = lemons(place, &run);
    assert_code(&output, 1);
    assert!(err(&output).contains("lemons has no record of writing it"), "{}", err(&output));
    assert_eq!(text(&place.join("trajectories.csv")), "my notes");
}

/// A Trial is replaced as a whole or not at all.
#[test]
fn a_trial_that_is_edited_while_a_crowd_is_made_is_not_replaced() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    let crowd = ["crowd", "--number", "3", "-o", "T"];
    mkfifo(&place.join("people"));
    for there in [true, false] {
        if there {
            done(place, &crowd);
        } else {
            std::fs::remove_dir_all(place.join("T")).unwrap();
        }
        let made = ["--seed", "2", "--zip", "T.zip", "--svg", "T.svg", "--population", "people"];
        let child = piped(place, &[&crowd[..], &made].concat());
        // It waits for who reads the population; all is claimed then.
        waits(&child);
        std::fs::create_dir_all(place.join("T/static")).unwrap();
        std::fs::write(place.join("T/Parameters.xml"), "mine").unwrap();
        let edited = content(&place.join("T"));
        let population = text(&place.join("people"));
        assert!(population.lines().count() == 4, "{population}");
        let output = ended(child);
        assert_code(&output, 1);
        let expected = "T/Parameters.xml: cannot be written: another program changed it while this command ran, \
                        so it was not replaced; \
                        the new content is in T_new\n";
        assert!(err(&output).ends_with(expected), "{}", err(&output));
        assert!(content(&place.join("T")) == edited);
        done(place, &["check", "T_new"]);
        assert_code(&lemons(place, &crowd), 1);
        assert!(content(&place.join("T")) == edited);
        // The others are there.
        done(place, &["check", "T.zip"]);
        for file in ["T.zip", "T.svg"] {
            std::fs::remove_file(place.join(file)).unwrap();
        }
        std::fs::remove_dir_all(place.join("T_new")).unwrap();
        assert!(begun(place).is_empty());
    }
    // What somebody made there meanwhile may be no Trial at all.
    std::fs::remove_dir_all(place.join("T")).unwrap();
    let child = piped(place, &[&crowd[..], &["--population", "people"]].concat());
    waits(&child);
    std::fs::create_dir(place.join("T")).unwrap();
    std::fs::write(place.join("T/notes"), "mine").unwrap();
    text(&place.join("people"));
    let output = ended(child);
    assert_code(&output, 1);
    assert!(err(&output).ends_with("the Trial is in T_new\n"), "{}", err(&output));
    done(place, &["check", "T_new"]);
    assert_eq!(content(&place.join("T")).len(), 1);
}

/// The link was replaced by a file.
#[test]
fn a_link_to_a_file_that_is_yet_to_be_made_leads_there() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    std::fs::create_dir(place.join("disk")).unwrap();
    symlink("disk/run.csv", place.join("link.csv")).unwrap();
    symlink("link.csv", place.join("second.csv")).unwrap();
    symlink(place.join("disk/crowd"), place.join("crowd")).unwrap();
    symlink("circle.csv", place.join("round.csv")).unwrap();
    symlink("round.csv", place.join("circle.csv")).unwrap();
    symlink("nowhere/run.csv", place.join("lost.csv")).unwrap();
    let trial = default_trial();
    let run =
        |to: &'static str| ["run", trial.to_str().unwrap(), "--until", "0.1", "-o", to].map(str::to_owned);
    let run = |to| lemons(place, &run(to).each_ref().map(String::as_str));
    assert_code(&run("second.csv"), 0);
    assert!(text(&place.join("disk/run.csv")).starts_with("t,id,"));
    // By whatever name, it is the file of the same command.
    for name in ["link.csv", "disk/run.csv", "second.csv"] {
        assert_code(&run(name), 0);
    }
    done(place, &["crowd", "-n", "3", "-o", "crowd"]);
    done(place, &["check", "disk/crowd"]);
    for link in ["link.csv", "second.csv", "crowd"] {
        assert!(place.join(link).symlink_metadata().unwrap().is_symlink(), "{link}");
    }
    let both = ["person", "--breadth", "49", "--depth", "25", "--stature", "1.75", "--mass", "70"];
    let both = lemons(place, &[&both[..], &["--wkt", "new.wkt", "--geojson", "new.wkt"]].concat());
    assert!(err(&both).contains("another result goes there"), "{}", err(&both));
    for name in ["round.csv", "lost.csv"] {
        let output = run(name);
        assert_code(&output, 1);
        assert!(err(&output).starts_with(&format!("lemons: cannot write {name}: ")), "{}", err(&output));
        assert!(place.join(name).symlink_metadata().unwrap().is_symlink());
    }
}

/// It spoke of files that stay, and are used, in a Trial that it then did not write.
#[test]
fn a_refused_crowd_says_why_and_nothing_else() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    let crowd = ["crowd", "-n", "3", "-o", "T"];
    done(place, &crowd);
    std::fs::write(place.join("T/decision.toml"), "waypoints = [{ x = 6, y = 2 }]\n").unwrap();
    let kept = "warning: T/decision.toml of the Trial that was there stays, and is used\n";
    assert_eq!(err(&done(place, &crowd)), kept);
    std::fs::write(place.join("T/static/Geometry.xml"), "mine").unwrap();
    let output = lemons(place, &crowd);
    assert_code(&output, 1);
    let said = err(&output);
    assert!(
        said.starts_with("lemons: cannot write T/static/Geometry.xml: ") && said.lines().count() == 1,
        "{said}"
    );
}

/// A table of the crowd before lay beside, and nothing said that it was of another one.
#[test]
fn a_crowd_that_replaces_another_one_says_so() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    let crowd = ["crowd", "-n", "3", "-o", "T"];
    let note =
        "note: T was another Trial before: tables and other results made from that one no longer fit\n";
    for (more, said) in [
        (&[][..], ""),
        (&[], ""),
        (&["--seed", "2"], note),
        (&["--seed", "2"], ""),
        (&["--seed", "2", "--time-step", "0.02", "--force"], note),
    ] {
        assert_eq!(err(&done(place, &[&crowd[..], more].concat())), said, "{more:?}");
    }
}
