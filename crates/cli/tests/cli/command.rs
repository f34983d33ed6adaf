//! The command as its users meet it: exit codes, messages, files.

use crate::common::{assert_code, copy_trial, default_trial, done, err, lemons, out};
use lemons_master::{Observer, Prepared, Reached, Settings, System};
use std::fs;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// A copy of the default Trial, with some text of one file replaced.
fn trial(directory: &Path, name: &str, file: &str, from: &str, to: &str) -> String {
    copy_trial(&directory.join(name));
    let path = directory.join(name).join(file);
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{file} has no {from}");
    fs::write(path, text.replacen(from, to, 1)).unwrap();
    name.to_owned()
}

#[test]
fn a_push_goes_through_the_row() {
    let directory = TempDir::new().unwrap();
    let output = lemons(directory.path(), &["run", default_trial().to_str().unwrap(), "--until", "2"]);
    assert_code(&output, 0);
    let lines = [
        "simulated time",
        "wall time",
        "real-time factor",
        "largest overlap",
        "greatest step mean",
        "greatest peak",
    ];
    for line in lines {
        assert!(out(&output).contains(line), "{}", out(&output));
    }
    assert!(out(&output).lines().all(|line| line.chars().count() <= 80));
    let csv = fs::read_to_string(directory.path().join("trajectories.csv")).unwrap();
    let mut rows = csv.lines();
    let header = "t,id,x,y,vx,vy,theta,omega,agent_contacts,\
                  wall_contacts,contacting_agents,normal_force,mean_normal_force,peak_normal_force,peak_overlap,\
                  total_agent_contacts,total_wall_contacts";
    assert_eq!(rows.next(), Some(header));
    let rows: Vec<Vec<f64>> =
        rows.map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 41 * 5);
    let moved: Vec<f64> = (0..5).map(|i| rows[40 * 5 + i][2] - rows[i][2]).collect();
    assert!(moved.iter().all(|x| *x > 0.02), "everybody was pushed on: {moved:?}");
    assert_eq!(rows.last().unwrap()[0], 2.0);
}

/// It was 2594 N at a TimeStep of 0.05 s, 9772 at 0.01 and 18 847 at 0.0001: whatever a communication point met.
#[test]
fn the_greatest_squeeze_of_the_push_does_not_depend_on_the_time_step() {
    let directory = TempDir::new().unwrap();
    let said = |step: &str| -> [f64; 2] {
        let trial = default_trial();
        let table = format!("{step}.csv");
        let run = ["run", trial.to_str().unwrap(), "--until", "0.8", "--step", step, "-o", &table];
        let output = lemons(directory.path(), &run);
        assert_code(&output, 0);
        ["largest overlap", "greatest peak"].map(|of| {
            let text = out(&output);
            let line =
                text.lines().find_map(|line| line.strip_prefix(of)).unwrap_or_else(|| panic!("{text}"));
            line.split_whitespace().next().unwrap().parse().unwrap()
        })
    };
    let fine = said("0.0005");
    // The push itself differs: it is linear between the rows of its table, and held over a step.
    for (step, within) in [("0.05", 0.2), ("0.01", 0.01), ("0.002", 0.005)] {
        for (found, fine) in said(step).into_iter().zip(fine) {
            assert!((found / fine - 1.0).abs() < within, "{step} s: {found}, not {fine}");
        }
    }
}

#[test]
fn a_packed_fmu_runs_like_its_trial() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let packed = lemons(at, &["pack", default_trial().to_str().unwrap(), "-o", "push.fmu"]);
    assert_code(&packed, 0);
    let said = format!(" MB, by {}", out(&lemons(at, &["-V"])));
    assert!(out(&packed).starts_with("push.fmu: ") && out(&packed).ends_with(&said), "{}", out(&packed));
    assert_code(&lemons(at, &["pack", default_trial().to_str().unwrap(), "-o", "again.fmu"]), 0);
    assert!(
        fs::read(at.join("push.fmu")).unwrap() == fs::read(at.join("again.fmu")).unwrap(),
        "same input, same bytes"
    );
    assert_code(&lemons(at, &["run", "push.fmu", "--until", "0.5", "-o", "a.csv"]), 0);
    assert_code(&lemons(at, &["run", default_trial().to_str().unwrap(), "--until", "0.5", "-o", "b.csv"]), 0);
    let read = |name: &str| fs::read(at.join(name)).unwrap();
    assert!(read("a.csv") == read("b.csv"));
    // Parameters, steps and drives make a difference.
    let heavier = ["run", "push.fmu", "--until", "0.5", "-o", "c.csv", "--set", "agent[0].Mass=150"];
    assert_code(&lemons(at, &heavier), 0);
    assert!(read("a.csv") != read("c.csv"));
    assert_code(&lemons(at, &["run", "push.fmu", "--until", "0.5", "-o", "d.csv", "--no-drive"]), 0);
    let still = fs::read_to_string(at.join("d.csv")).unwrap();
    assert!(still.lines().last().unwrap().starts_with("0.5,4,1.448,0.012,0.0,0.0,"), "{still}");
    assert_code(&lemons(at, &["run", "push.fmu", "--until", "0.25", "--step", "0.1", "-o", "e.csv"]), 0);
    let steps = fs::read_to_string(at.join("e.csv")).unwrap();
    let times: Vec<&str> =
        steps.lines().skip(1).step_by(5).map(|row| row.split(',').next().unwrap()).collect();
    assert_eq!(times, ["0.0", "0.1", "0.2", "0.25"]);
}

#[test]
fn check_says_all_that_is_wrong_at_once() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    assert_code(&lemons(at, &["check", default_trial().to_str().unwrap()]), 0);
    trial(at, "bad", "static/Agents.xml", "Radius=\"0.09495\"", "Radius=\"-0.1\"");
    let geometry = at.join("bad/static/Geometry.xml");
    let text =
        fs::read_to_string(&geometry).unwrap().replace("MaterialId=\"concrete\"", "MaterialId=\"cheese\"");
    fs::write(geometry, text).unwrap();
    let output = lemons(at, &["check", "bad"]);
    assert_code(&output, 3);
    let said = out(&output);
    assert!(said.contains("bad/static/Agents.xml:4: <Shape> Radius=\"-0.1\": must be positive"), "{said}");
    assert!(said.contains("\"cheese\""), "{said}");
    assert!(said.contains("bad: 2 errors"), "{said}");
    // Every other command refuses it with the same lines.
    for command in [vec!["run", "bad"], vec!["pack", "bad", "-o", "bad.fmu"], vec!["describe", "bad"]] {
        let output = lemons(at, &command);
        assert_code(&output, 3);
        assert!(err(&output).contains("Radius=\"-0.1\": must be positive"), "{}", err(&output));
    }
    assert!(!at.join("bad.fmu").exists() && !at.join("trajectories.csv").exists());
}

#[test]
fn trials_of_different_crowds_do_not_go_into_one_fmu() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let good = default_trial();
    trial(at, "renamed", "static/Agents.xml", "Id=\"3\"", "Id=\"three\"");
    let dynamics = at.join("renamed/dynamic/AgentDynamics.xml");
    let text = fs::read_to_string(&dynamics).unwrap().replace("Id=\"3\"", "Id=\"three\"");
    fs::write(dynamics, text).unwrap();
    let output = lemons(at, &["pack", good.to_str().unwrap(), "renamed", "-o", "two.fmu"]);
    assert_code(&output, 1);
    assert!(err(&output).contains("agent 3 has the Id \"three\" instead of \"3\""), "{}", err(&output));
    assert!(err(&output).contains("share its variables"), "{}", err(&output));
    assert!(!at.join("two.fmu").exists());
    let crowd = ["crowd", "-n", "3", "--seed", "1", "-o", "three"];
    assert_code(&lemons(at, &crowd), 0);
    let output = lemons(at, &["pack", good.to_str().unwrap(), "three", "-o", "two.fmu"]);
    assert_code(&output, 1);
    for words in ["3 agents instead of 5", "they need the same number of agents with the same Ids"] {
        assert!(err(&output).contains(words), "{}", err(&output));
    }
    let help = out(&lemons(at, &["pack", "--help"])).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(help.contains("they need the same number of agents with the same Ids"), "{help}");
    // The same crowd elsewhere does, and the parameter Trial chooses.
    trial(at, "elsewhere", "dynamic/AgentDynamics.xml", "1.448,0.012", "1.348,0.012");
    let output = lemons(at, &["pack", good.to_str().unwrap(), "elsewhere", "-o", "two.fmu"]);
    assert_code(&output, 0);
    let chosen = ["run", "two.fmu", "--until", "0.1", "--set", "Trial=elsewhere", "--no-drive"];
    assert_code(&lemons(at, &chosen), 0);
    let csv = fs::read_to_string(at.join("trajectories.csv")).unwrap();
    assert!(csv.contains("0.0,4,1.348,0.012,"), "{csv}");
    let unknown = lemons(at, &["run", "two.fmu", "--set", "Trial=nowhere"]);
    assert_code(&unknown, 1);
    assert!(err(&unknown).contains("one of the packed Trials: Trial_push, elsewhere"), "{}", err(&unknown));
}

#[test]
fn mistakes_have_clear_messages() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let good = default_trial();
    let good = good.to_str().unwrap();
    let said = |arguments: &[&str], code: i32| {
        let output = lemons(at, arguments);
        assert_code(&output, code);
        assert!(!err(&output).contains("panicked"), "{}", err(&output));
        err(&output)
    };
    said(&["run"], 2);
    said(&["run", good, "--until", "-1"], 2);
    assert!(said(&["run", "nothing.fmu"], 1).contains("nothing.fmu"));
    fs::write(at.join("broken.fmu"), "no zip").unwrap();
    assert!(said(&["info", "broken.fmu"], 1).contains("broken.fmu"));
    assert!(said(&["run", good, "--drive", "nothing.csv"], 1).contains("nothing.csv"));
    fs::write(at.join("drive.csv"), "t,agent,Fp.x,Fp.y,Mp\n0,nobody,1,2,3\n").unwrap();
    assert!(said(&["run", good, "--drive", "drive.csv"], 1).contains("\"nobody\""));
    assert!(said(&["run", good, "--set", "agent[9].Mass=1"], 1).contains("agent[9].Mass"));
    assert!(
        said(&["run", good, "--set", "agent[0].Mass=-1"], 1)
            .contains("agent[0].Mass = -1.0: must be positive")
    );
    assert!(
        said(&["run", good, "--set", "material.human_naked.ShearModulus=1"], 1).contains("\"human_naked\"")
    );
    assert!(said(&["run", good, "-o", "no/such/directory.csv"], 1).contains("no/such/directory.csv"));
    assert!(said(&["pack", good, "-o", "x.fmu", "--binary", "amiga=x"], 1).contains("amiga"));
    assert!(!at.join("trajectories.csv").exists());
}

#[test]
fn a_table_of_nothing_is_a_failure_and_a_setting_without_a_value_a_misuse() {
    let directory = TempDir::new().unwrap();
    for (arguments, code, words) in [
        (&["bench", "--only", "none of them"][..], 1, "no crowd has \"none of them\" in its name"),
        (&["verify", "--only", "none of them"], 1, "no row has \"none of them\" in its name"),
        (&["run", "T", "--set", "agent[0].Mass"], 2, "--set agent[0].Mass: expected NAME=VALUE"),
    ] {
        let output = lemons(directory.path(), arguments);
        assert_code(&output, code);
        assert!(
            err(&output).contains(words) && output.stdout.is_empty() == (arguments[0] != "verify"),
            "{}",
            err(&output)
        );
    }
}

#[test]
fn what_check_accepts_packs_and_runs() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    trial(at, "spaces", "Parameters.xml", "\"./static/\"", "\" ./static/ \"");
    assert_code(&lemons(at, &["check", "spaces"]), 0);
    assert_code(&lemons(at, &["run", "spaces", "--until", "0.1"]), 0);
    trial(at, "outside", "Parameters.xml", "\"./static/\"", "\"../spaces/static/\"");
    assert_code(&lemons(at, &["check", "outside"]), 0);
    let output = lemons(at, &["run", "outside", "--until", "0.1"]);
    assert_code(&output, 1);
    assert!(err(&output).contains("Static=\"../spaces/static/\""), "{}", err(&output));
}

#[test]
fn info_lists_the_variables() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    assert_code(&lemons(at, &["pack", default_trial().to_str().unwrap(), "-o", "push.fmu"]), 0);
    let output = lemons(at, &["info", "push.fmu", "--only", "agent[0]"]);
    assert_code(&output, 0);
    let said = out(&output);
    assert!(said.contains("Trials    Trial_push"), "{said}");
    assert!(said.contains("agent[0].Mass"), "{said}");
    assert!(!said.contains("agent[1].Mass"), "{said}");
    assert!(said.lines().all(|line| line.chars().count() <= 80), "{said}");
}

/// Another packer's FMU may have anything in it.
#[test]
fn info_lists_the_platforms_and_the_glibc_that_they_need() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    done(at, &["pack", default_trial().to_str().unwrap(), "-o", "push.fmu"]);
    let platforms = || {
        let said = out(&done(at, &["info", "push.fmu", "--only", "no such"]));
        let lines = said.lines().skip_while(|line| !line.starts_with("platforms "));
        lines
            .take_while(|line| line.starts_with("platforms ") || line.starts_with(' '))
            .map(|line| line[10..].to_owned())
            .collect::<Vec<_>>()
    };
    let own = platforms();
    assert_eq!(own.len(), 1, "{own:?}");
    if cfg!(all(target_os = "linux", target_arch = "x86_64", target_env = "gnu")) {
        let glibc = own[0].strip_prefix("linux64        glibc 2.").unwrap();
        assert!(glibc.parse::<u32>().unwrap() >= 2, "{own:?}");
    }
    let file = std::fs::File::options().read(true).write(true).open(at.join("push.fmu")).unwrap();
    let mut zip = zip::ZipWriter::new_append(file).unwrap();
    for (name, content) in [
        ("binaries/win64/CrowdMechanics.dll", &b"no library"[..]),
        ("binaries/zx\u{1b}81/CrowdMechanics.bin", b""),
        ("binaries/amiga/other.so", b""),
    ] {
        zip.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        std::io::Write::write_all(&mut zip, content).unwrap();
    }
    zip.finish().unwrap();
    let all = platforms();
    assert_eq!(all[0], own[0]);
    assert!(all[1].starts_with("win64          is not a shared library for win64"), "{all:?}");
    assert!(all.len() == 3 && all[2].starts_with("zx81           is broken: "), "{all:?}");
}

#[test]
fn a_platform_is_chosen_among_those_beside_the_command() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let trial = default_trial();
    let trial = trial.to_str().unwrap();
    let host = crowd_mechanics::pack::host_platform().unwrap();
    done(at, &["pack", trial, "-o", "all.fmu"]);
    done(at, &["pack", trial, "--platform", host, "--platform", host, "-o", "own.fmu"]);
    let bytes = ["all.fmu", "own.fmu"].map(|file| std::fs::read(at.join(file)).unwrap());
    assert_eq!(bytes[0], bytes[1]);
    let said = |arguments: &[&str], code| {
        let all = [&["pack", trial, "-o", "x.fmu"], arguments].concat();
        let output = lemons(at, &all);
        assert_code(&output, code);
        assert!(!at.join("x.fmu").exists());
        err(&output)
    };
    let missing = said(&["--platform", "win32"], 1);
    assert!(missing.contains("crowd_mechanics.dll is not beside this program"), "{missing}");
    assert!(missing.contains("give --binary win32=FILE"), "{missing}");
    let unknown = said(&["--platform", "amiga"], 1);
    assert!(unknown.contains("--platform amiga: no such platform; there are linux64, "), "{unknown}");
    said(&["--platform", host, "--binary", "linux64=x"], 2);
}

#[test]
fn commands_stand_in_the_order_of_their_use() {
    let directory = TempDir::new().unwrap();
    let help = out(&lemons(directory.path(), &["--help"]));
    let words = help.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let words: Vec<&str> = words.filter_map(|line| line.split_whitespace().next()).take(17).collect();
    assert_eq!(
        words,
        [
            "lab", "crowd", "person", "pack", "decide", "connect", "run", "sweep", "plot", "movie",
            "measure", "export", "info", "check", "describe", "verify", "bench"
        ]
    );
}

#[test]
fn export_writes_what_was_run_and_says_what_it_lacks() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let trial = trial(at, "own", "static/Agents.xml", "Id=\"0\"", "Id=\"0\"");
    assert_code(&lemons(at, &["run", &trial, "--until", "0.23"]), 0);
    assert_code(&lemons(at, &["pack", &trial, "-o", "own.fmu"]), 0);

    // 0.2 and 0.23 s: no constant frame rate, but each second frame has one.
    let table = ["export", "trajectories.csv"];
    let export = |more: &[&str]| lemons(at, &[&table[..], more].concat());
    let output = export(&["run.txt", "--to", "pedpy"]);
    assert_code(&output, 1);
    assert!(err(&output).contains("trajectories.csv: line 27: column t: t = 0.23 s"), "{}", err(&output));
    assert!(!at.join("run.txt").exists());
    let output = export(&["run.txt", "--to", "pedpy", "--every", "2"]);
    assert_code(&output, 0);
    assert_eq!(out(&output), "run.txt: 5 agents, 3 frames from 0.0 to 0.2 s\n");
    fs::write(at.join("area.wkt"), "POLYGON ((-9 -9, 9 -9, 9 9, -9 9, -9 -9))").unwrap();
    for walls in [["--trial", "own"], ["--trial", "own.fmu"], ["--area", "area.wkt"]] {
        let output = export(&[&["run.sqlite", "--to", "jupedsim", "--every", "2"][..], &walls].concat());
        assert_code(&output, 0);
        let given = walls[0] == "--area";
        assert_eq!(err(&output).contains("inside of wall"), !given, "{}", err(&output));
    }

    // A table holds no contacts; the series of it lies in the Trial, which is found.
    let output = export(&["own/out", "--to", "series", "--trial", "own"]);
    assert_code(&output, 0);
    assert!(err(&output).contains("no contacts"), "{}", err(&output));
    assert_eq!(fs::read_dir(at.join("own/out")).unwrap().count(), 6);
    let output = lemons(at, &["export", "own/out", "end", "--to", "trial"]);
    assert_code(&output, 0);
    assert_eq!(out(&output), "end: 5 agents as at t = 0.23 s\n");
    assert!(!err(&output).contains("stays, and is used"), "{}", err(&output));
    fs::write(at.join("end/drive.csv"), "t,agent,Fp.x,Fp.y,Mp\n").unwrap();
    let output = lemons(at, &["export", "own/out", "end", "--to", "trial"]);
    assert_code(&output, 0);
    let warning = "warning: end/drive.csv of the Trial that was there stays, and is used\n";
    assert!(err(&output).contains(warning), "{}", err(&output));
    let rows = fs::read_to_string(at.join("trajectories.csv")).unwrap();
    let last: Vec<&str> = rows.lines().last().unwrap().split(',').collect();
    let dynamics = fs::read_to_string(at.join("end/dynamic/AgentDynamics.xml")).unwrap();
    assert!(dynamics.contains(&format!("Position=\"{},{}\"", last[2], last[3])), "{dynamics}");
    assert_code(&lemons(at, &["check", "end"]), 0);

    for (arguments, expected) in [
        (&["none.csv", "x.txt", "--to", "pedpy"][..], "none.csv: "),
        (
            &["trajectories.csv", "x", "--to", "series"],
            "trajectories.csv: give the Trial or FMU of the run with --trial",
        ),
        (&["trajectories.csv", "x", "--to", "chaos", "--trial", "none"], "none"),
        (&["own/static", "x", "--to", "chaos"], "own/static: holds no series"),
        (&["trajectories.csv", "trajectories.csv", "--to", "pedpy"], "lemons export reads it"),
        (&["own/out", "own", "--to", "trial", "--trial", "own"], "lemons export reads it"),
        (&["own/out", "own", "--to", "trial"], "lemons export reads it"),
        (&["own/out", "x", "--to", "trial", "--every", "2"], "--every is not for --to trial"),
        (
            &["trajectories.csv", "x", "--to", "jupedsim", "--every", "2"],
            "walls are not known: give the Trial or FMU of the run with --trial, or the walkable area with --area",
        ),
        (
            &[
                "trajectories.csv",
                "no/such/x.sqlite",
                "--to",
                "jupedsim",
                "--every",
                "2",
                "--area",
                "area.wkt",
            ],
            "no/such/x.sqlite",
        ),
        (
            &["trajectories.csv", "own", "--to", "jupedsim", "--every", "2", "--area", "area.wkt"],
            "cannot write own: ",
        ),
    ] {
        let output = lemons(at, &[&["export"], arguments].concat());
        assert_code(&output, 1);
        assert!(err(&output).contains(expected), "{arguments:?}: {}", err(&output));
        assert!(!at.join("x").exists() && !at.join("x.txt").exists());
    }
    assert_code(&lemons(at, &["export", "trajectories.csv", "x", "--to", "elsewhere"]), 2);
    assert_code(&lemons(at, &["export", "trajectories.csv", "x", "--to", "pedpy", "--every", "0"]), 2);
}

/// The crowd's library, out of its FMU.
fn crowd_library(at: &Path) -> Vec<u8> {
    assert_code(&lemons(at, &["pack", default_trial().to_str().unwrap(), "-o", "push.fmu"]), 0);
    let mut fmu = zip::ZipArchive::new(fs::File::open(at.join("push.fmu")).unwrap()).unwrap();
    let names: Vec<String> = fmu.file_names().map(|name| name.unwrap().into_owned()).collect();
    let name = names.iter().find(|name| name.starts_with("binaries/")).unwrap();
    let mut bytes = Vec::new();
    std::io::copy(&mut fmu.by_name(name).unwrap(), &mut bytes).unwrap();
    bytes
}

/// The loader maps what the headers speak of: the program got SIGBUS.
#[test]
fn a_library_that_is_cut_off_is_refused_and_not_loaded() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let library = crowd_library(at);
    let platform = crowd_mechanics::pack::host_platform().unwrap();
    let trial = default_trial();
    for part in [1, 25, 50, 90, 100] {
        let short = &library[..library.len() * part / 100 - 1];
        let mut from = zip::ZipArchive::new(fs::File::open(at.join("push.fmu")).unwrap()).unwrap();
        let mut zip = zip::ZipWriter::new(fs::File::create(at.join("short.fmu")).unwrap());
        for k in 0..from.len() {
            let entry = from.by_index_raw(k).unwrap();
            if !entry.name().unwrap().starts_with("binaries/") {
                zip.raw_copy_file(entry).unwrap();
                continue;
            }
            let name = entry.name().unwrap().into_owned();
            zip.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
            std::io::Write::write_all(&mut zip, short).unwrap();
        }
        zip.finish().unwrap();
        for words in [["run", "short.fmu"], ["info", "short.fmu"], ["plot", "short.fmu"]] {
            let output = lemons(at, &words);
            assert_code(&output, 1);
            let place = format!("lemons: short.fmu: binaries/{platform}/CrowdMechanics");
            let said = err(&output);
            assert!(said.starts_with(&place), "{part}: {said}");
            let end = format!("the file at byte {}", short.len());
            assert!(said.contains(": is cut off: ") && said.contains(&end), "{part}: {said}");
        }
        fs::write(at.join("short.library"), short).unwrap();
        let binary = format!("{platform}=short.library");
        let output = lemons(at, &["pack", trial.to_str().unwrap(), "-o", "x.fmu", "--binary", &binary]);
        assert_code(&output, 1);
        assert!(
            err(&output).starts_with(&format!("lemons: --binary {binary}: is cut off: ")),
            "{}",
            err(&output)
        );
        assert!(!at.join("x.fmu").exists());
    }
}

/// The library beside the command is packed and loaded without being named.
#[test]
#[cfg(unix)]
fn a_cut_off_library_beside_the_command_is_refused() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let library = crowd_library(at);
    fs::create_dir(at.join("bin")).unwrap();
    fs::copy(env!("CARGO_BIN_EXE_lemons"), at.join("bin/lemons")).unwrap();
    let names = ["libcrowd_mechanics.so", "libcrowd_mechanics.dylib"];
    let name = names[usize::from(cfg!(target_os = "macos"))];
    let place = at.join("bin").join(name);
    let trial = default_trial();
    let trial = trial.to_str().unwrap();
    for part in [1, 50, 100] {
        fs::write(&place, &library[..library.len() * part / 100 - 1]).unwrap();
        for call in [&["pack", trial, "-o", "x.fmu"][..], &["run", trial, "--until", "0.1"]] {
            let output = Command::new(at.join("bin/lemons")).args(call).current_dir(at).output().unwrap();
            assert_code(&output, 1);
            let said = err(&output);
            assert!(said.contains(name) && said.contains(": is cut off: "), "{call:?} {part}: {said}");
            assert!(!at.join("x.fmu").exists() && !at.join("trajectories.csv").exists());
        }
    }
    fs::write(&place, &library).unwrap();
    let mut whole = Command::new(at.join("bin/lemons"));
    assert_code(&whole.args(["pack", trial, "-o", "x.fmu"]).current_dir(at).output().unwrap(), 0);
}

/// Releases have the file beside the libraries' directories.
#[test]
fn an_fmu_holds_the_licences_that_are_beside_its_library_or_above() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let release = at.join("releases/this");
    let from = release.join("win64");
    fs::create_dir_all(&from).unwrap();
    // Small ones: nobody loads them here.
    fs::write(from.join("crowd"), [lemons_testing::pe(), b"CrowdMechanics".to_vec()].concat()).unwrap();
    fs::write(from.join("decision"), [lemons_testing::pe(), b"decision.toml".to_vec()].concat()).unwrap();
    let push = default_trial();
    let door = push.with_file_name("Trial_door");
    // What an FMU holds of them, packed in this directory from a library in that one.
    let held = |working: &Path, place: &str, call: &str, fmi: &str| {
        let (trial, name) = if call == "pack" { (&push, "crowd") } else { (&door, "decision") };
        let binary = format!("win64={place}{name}");
        let fmu = at.join("x.fmu");
        let files = ["--binary", &binary, "--force", "-o", fmu.to_str().unwrap()];
        done(working, &[&[call, trial.to_str().unwrap(), "--fmi", fmi][..], &files].concat());
        let mut fmu = zip::ZipArchive::new(fs::File::open(fmu).unwrap()).unwrap();
        let mut text = String::new();
        let mut entry = fmu.by_name("documentation/licenses/THIRD-PARTY.txt").ok()?;
        std::io::Read::read_to_string(&mut entry, &mut text).unwrap();
        Some(text)
    };
    let each_holds = |expected: Option<&str>| {
        let absolute = from.to_str().unwrap().to_owned() + "/";
        for (working, place) in
            [(at, &*absolute), (&release, "win64/"), (&from, ""), (&from, "./"), (&from, "../win64/")]
        {
            for (call, fmi) in [("pack", "2"), ("pack", "3"), ("decide", "2"), ("decide", "3")] {
                let found = held(working, place, call, fmi);
                assert_eq!(found.as_deref(), expected, "{}, {place:?}, {call}, {fmi}", working.display());
            }
        }
    };
    fs::write(at.join("THIRD-PARTY.txt"), "somebody else's").unwrap();
    fs::write(at.join("releases/THIRD-PARTY.txt"), "of no release").unwrap();
    each_holds(None);
    fs::write(release.join("THIRD-PARTY.txt"), "of all platforms").unwrap();
    each_holds(Some("of all platforms"));
    fs::write(from.join("THIRD-PARTY.txt"), "of this one").unwrap();
    each_holds(Some("of this one"));
    fs::remove_file(release.join("THIRD-PARTY.txt")).unwrap();
    each_holds(Some("of this one"));
}

#[test]
fn decide_says_what_it_needs_and_what_it_doubts() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let help = out(&lemons(at, &["decide", "--help"]));
    // The example of the help is one.
    let example: Vec<&str> = help.split_once("desired_speed").unwrap().1.lines().map(str::trim).collect();
    let wishes = format!("desired_speed{}", example.join("\n")).replace("agents.7", "agents.3");
    assert!(wishes.contains("default 1.34") && wishes.contains("radius 0.3"), "{help}");
    assert!(help.lines().all(|line| line.chars().count() <= 80), "{help}");
    fs::write(at.join("wishes.toml"), wishes).unwrap();

    trial(at, "close", "dynamic/AgentDynamics.xml", "1.448,0.012", "1.3,0.012");
    let output = lemons(at, &["check", "close"]);
    assert_code(&output, 0);
    let warning = out(&output).lines().next().unwrap().to_owned();
    assert!(warning.starts_with("warning: "), "{warning}");

    let output = lemons(at, &["decide", "close", "-o", "x.fmu"]);
    assert_code(&output, 1);
    let said = err(&output);
    for words in
        ["close/decision.toml", "--plan FILE.toml", "\n  desired_speed = 1.34\n  waypoints = [{ x = "]
    {
        assert!(said.contains(words), "{said}");
    }
    let library = crowd_library(at);
    fs::write(at.join("crowd.library"), &library).unwrap();
    fs::write(at.join("decision.library"), [&library[..], b"decision.toml"].concat()).unwrap();
    let binary = |file: &str| format!("--binary={}={file}", crowd_mechanics::pack::host_platform().unwrap());
    let decide = ["decide", "close", "-o", "x.fmu", "--plan", "wishes.toml"];
    let output = lemons(at, &[&decide[..], &[&binary("crowd.library")]].concat());
    assert_code(&output, 1);
    assert!(err(&output).contains("is not the library lemons_decision_fmu"), "{}", err(&output));
    for wrong in ["win64=wishes.toml", "win64=crowd.library", "linux32=decision.library"] {
        let output = lemons(at, &[&decide[..], &["--binary", wrong]].concat());
        assert_code(&output, 1);
        assert!(
            err(&output).contains(&format!("--binary {wrong}: is not a shared library")),
            "{}",
            err(&output)
        );
    }
    assert!(!at.join("x.fmu").exists());
    let output = lemons(at, &[&decide[..], &[&binary("decision.library")]].concat());
    assert_code(&output, 0);
    assert!(err(&output).contains(&warning), "{}", err(&output));
    let good = default_trial();
    assert_code(&lemons(at, &["pack", good.to_str().unwrap(), "-o", "y.fmu", &binary("crowd.library")]), 0);
}

/// Each command with what it does not take.
#[test]
fn wrong_kinds_of_files_are_called_what_they_are() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let good = default_trial();
    let good = good.to_str().unwrap();
    fs::create_dir(at.join("dir")).unwrap();
    fs::write(at.join("text.md"), "# A text\n\nwith words.\n").unwrap();
    fs::write(at.join("empty"), "").unwrap();
    fs::write(at.join("binary"), b"\x01\x00\xff\xfe\x00\x00").unwrap();
    fs::write(at.join("program"), b"\x7fELF\x02\x01\x01").unwrap();
    fs::write(at.join("damaged.zip"), b"PK\x03\x04").unwrap();
    assert_code(&lemons(at, &["pack", good, "-o", "push.fmu"]), 0);
    assert_code(&lemons(at, &["run", good, "--until", "0.1", "--state", "a.run", "-o", "t.parquet"]), 0);
    let kinds = [
        ("none", "there is no such file or directory"),
        ("dir", "is a directory without Parameters.xml"),
        ("text.md", "is a text file"),
        ("empty", "is an empty file"),
        ("binary", "is a binary file"),
        ("program", "is a program or a library"),
        ("a.run", "is a saved run"),
        ("push.fmu", "is an FMU"),
        ("t.parquet", "is a table in Parquet"),
        ("damaged.zip", "damaged"),
    ];
    let table = "a table that lemons run wrote";
    // A zip may be a Trial.
    let shown: &[&str] = &["dir", "text.md", "binary", "push.fmu", "t.parquet", "damaged.zip"];
    // With what it takes, and what is refused for another reason.
    let commands: [(&[&str], i32, &str, &[&str]); 13] = [
        (&["info", "FILE"], 1, "an FMU", &["push.fmu", "a.run"]),
        (&["run", "FILE"], 1, "a Trial directory, an FMU or an SSP", &["push.fmu"]),
        (&["check", "FILE"], 3, "a Trial directory", &[]),
        (&["describe", "FILE"], 1, "a Trial directory", &[]),
        (&["pack", "FILE", "-o", "x.fmu"], 1, "a Trial directory", &[]),
        (&["decide", "FILE", "-o", "x.fmu"], 1, "a Trial directory", &[]),
        (&["connect", "FILE", "push.fmu", "-o", "x.ssp"], 1, "an FMU", &["push.fmu", "a.run"]),
        (&["sweep", "FILE"], 1, "a sweep.toml", &["text.md"]),
        (&["run", good, "--resume", "FILE"], 1, "a saved run", &["a.run"]),
        (&["plot", "FILE"], 1, table, shown),
        (&["movie", "FILE", "-o", "m.gif"], 1, table, shown),
        (&["export", "FILE", "x", "--to", "pedpy"], 1, table, &["dir", "text.md", "binary", "t.parquet"]),
        (&["plot", "t.parquet", "--trial", "FILE"], 1, "an FMU", &["dir", "push.fmu", "a.run"]),
    ];
    for (words, code, wanted, other) in commands {
        for (file, is) in kinds.iter().filter(|(file, _)| !other.contains(file)) {
            let words: Vec<&str> =
                words.iter().map(|word| if *word == "FILE" { file } else { *word }).collect();
            let output = lemons(at, &words);
            let said = out(&output) + &err(&output);
            assert_eq!(output.status.code(), Some(code), "{words:?}: {said}");
            assert!(said.contains(&format!("{file}: ")) && said.contains(is), "{words:?}: {said}");
            assert!(said.contains(wanted) || *file == "none", "{words:?}: {said}");
            for never in ["EOCD", "os error 22", "lemons-", "/tmp"] {
                assert!(!said.contains(never), "{words:?}: {said}");
            }
        }
    }
    let said = err(&lemons(at, &["run", "a.run"]));
    let wanted =
        "a.run: is a saved run, not a Trial directory, an FMU or an SSP; lemons run --resume continues it";
    assert!(said.contains(wanted), "{said}");
    for name in ["x", "x.fmu", "x.ssp", "m.gif", "plot.png", "trajectories.csv"] {
        assert!(!at.join(name).exists(), "{name}");
    }
}

/// What an FMU says of its files names the user's FMU, not where it was unzipped.
#[test]
fn messages_name_no_temporary_path() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    assert_code(&lemons(at, &["pack", default_trial().to_str().unwrap(), "-o", "push.fmu"]), 0);
    let copy = |to: &str, keep: &dyn Fn(&str) -> bool, broken: &str| {
        let mut from = zip::ZipArchive::new(fs::File::open(at.join("push.fmu")).unwrap()).unwrap();
        let mut zip = zip::ZipWriter::new(fs::File::create(at.join(to)).unwrap());
        for k in 0..from.len() {
            let mut entry = from.by_index(k).unwrap();
            let name = entry.name().unwrap().into_owned();
            if !keep(&name) {
                continue;
            }
            zip.start_file(name.as_str(), zip::write::SimpleFileOptions::default()).unwrap();
            if !broken.is_empty() && name.ends_with(broken) {
                std::io::Write::write_all(&mut zip, b"<a>").unwrap();
            } else {
                std::io::copy(&mut entry, &mut zip).unwrap();
            }
        }
        zip.finish().unwrap();
    };
    copy("bare.fmu", &|name| !name.starts_with("resources"), "");
    copy("broken.fmu", &|_| true, "Agents.xml");
    for (words, expected) in [
        (["run", "bare.fmu"], "bare.fmu: has no directory resources, which it may need"),
        (["plot", "bare.fmu"], "bare.fmu: holds no Trial"),
        (["run", "broken.fmu"], "broken.fmu/resources/Trial_push/static/Agents.xml:1: is not well-formed"),
        (["plot", "broken.fmu"], "broken.fmu/resources/Trial_push/static/Agents.xml:1: is not well-formed"),
    ] {
        let output = lemons(at, &words);
        assert_code(&output, 1);
        let said = err(&output);
        assert!(said.contains(expected) && !said.contains("lemons-"), "{said}");
    }
    // A warning of a Trial that runs as an FMU names the Trial's file.
    trial(at, "close", "dynamic/AgentDynamics.xml", "1.448,0.012", "1.3,0.012");
    let output = lemons(at, &["run", "close", "--until", "0.1"]);
    assert_code(&output, 0);
    assert!(err(&output).contains("warning: close/dynamic/AgentDynamics.xml: "), "{}", err(&output));
}

/// The poses of a run, in bits.
struct Poses(Vec<[u64; 4]>);

impl Observer<System> for Poses {
    type Error = lemons_master::Error;

    fn look(&mut self, system: &mut System, reached: Reached) -> Result<(), Self::Error> {
        let crowd = &system.components()[0].instance;
        for i in 0..5 {
            let mut pose = [0.0; 3];
            let names = ["Position.x", "Position.y", "Theta"].map(|name| format!("agent[{i}].{name}"));
            crowd.get_real(&crowd.select(names)?, &mut pose)?;
            self.0.push([reached.time, pose[0], pose[1], pose[2]].map(f64::to_bits));
        }
        Ok(())
    }
}

/// A program that has no command line gets what the command writes.
#[test]
fn settings_give_the_bits_that_the_command_writes() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let good = default_trial();
    let parameter = "contact.human_naked.human_naked.KineticFriction";
    let set = format!("{parameter}=0.2");
    assert_code(
        &lemons(at, &["run", good.to_str().unwrap(), "--until", "1.2", "--set", &set, "-o", "t.csv"]),
        0,
    );
    let table = fs::read_to_string(at.join("t.csv")).unwrap();
    let rows = table.lines().filter(|line| line.starts_with(|first: char| first.is_ascii_digit()));
    let header: Vec<&str> = table.lines().find(|line| line.contains(",x")).unwrap().split(',').collect();
    let columns = ["t", "x", "y", "theta"].map(|name| {
        // Perhaps with its unit.
        let named = |column: &&str| column.split_whitespace().next() == Some(name);
        header.iter().position(named).unwrap_or_else(|| panic!("{name}: {header:?}"))
    });
    let rows = rows.map(|row| {
        let cells: Vec<&str> = row.split(',').collect();
        columns.map(|place| cells[place].parse::<f64>().unwrap().to_bits())
    });
    // The first rows are those of the start.
    let written: Vec<[u64; 4]> = rows.skip(5).collect();
    let parameters = vec![(parameter.to_owned(), "0.2".to_owned())];
    let settings = Settings { parameters, until: Some(1.2), ..Settings::of(good) };
    let mut run = Prepared::of(&settings).unwrap();
    let mut poses = Poses(Vec::new());
    let _ = run.simulate(&mut poses).unwrap();
    assert_eq!(written.len(), 5 * 24);
    assert!(written == poses.0, "other bits");
}
