//! Tables of runs: what is read, what is refused, what is written of them.

use crowd_mechanics::setup;
use lemons_core::files::Staged;
use lemons_core::plane::Vec2;
use lemons_results::columns::Effect;
use lemons_results::{KeptFrames, Record, Run, chaos, jupedsim, pedpy, walkable_area};
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const HEADER: &str = "t,id,x,y,vx,vy,theta,omega,agent_contacts";

fn table(directory: &TempDir, text: &str) -> PathBuf {
    let path = directory.path().join("run.csv");
    fs::write(&path, text).unwrap();
    path
}

/// Two people, three times.
fn good(directory: &TempDir) -> Run {
    let row = |t: &str, id: &str, x: f64| format!("{t},{id},{x:?},0.5,1,0,0.25,0,0\n");
    let times = ["0.0", "0.1", "0.2"].iter().enumerate();
    let rows: String =
        times.map(|(k, t)| row(t, "7", k as f64 / 3.0) + &row(t, "3", 1.0 + k as f64 / 3.0)).collect();
    Run::read_table(&table(directory, &format!("{HEADER}\n{rows}"))).unwrap()
}

#[test]
fn groups_of_columns_are_read_where_all_are_there() {
    let directory = TempDir::new().unwrap();
    assert!(good(&directory).frames.iter().all(|frame| !frame.effects.knows(Effect::AgentContacts)));
    let of_step = "mean_normal_force,peak_normal_force,peak_overlap [m]";
    let read = |more: &str, row: &str| {
        let head = format!("{HEADER},wall_contacts,contacting_agents,normal_force{more}");
        Run::read_table(&table(&directory, &format!("{head}\n0.0,a,1,2,0,0,0,0,{row}\n")))
    };
    let seen = |more: &str, row: &str| {
        let run = read(more, row).unwrap();
        Effect::ALL.map(|effect| run.frames[0].effects.get(effect, 0))
    };
    let known = |numbers: &[f64]| std::array::from_fn(|place| numbers.get(place).copied());
    assert_eq!(seen("", "3,1,2,125.5"), known(&[3.0, 1.0, 2.0, 125.5]));
    let step = [3.0, 1.0, 2.0, 0.0, 80.5, 1000.0, 0.002, 30.5];
    assert_eq!(seen(&format!(",{of_step}"), "3,1,2,0.0,80.5,1e3,0.002"), known(&step[..7]));
    let all = format!(",{of_step},mean_wall_force");
    assert_eq!(seen(&all, "3,1,2,0.0,80.5,1e3,0.002,30.5"), known(&step));
    for (more, row, expected) in [
        ("", "3,-1,2,0.0", "wall_contacts: \"-1\" is not a valid number"),
        ("", "3,2147483648,2,0.0", "wall_contacts: \"2147483648\" is not a valid number"),
        ("", "3,1.5,2,0.0", "wall_contacts: \"1.5\" is not a valid number"),
        ("", "3,1,2,-1.0", "normal_force: \"-1.0\" is not a finite number from 0 on"),
        (of_step, "3,1,2,0.0,80.5,inf,0.002", "peak_normal_force: \"inf\" is not a finite number from 0 on"),
        (of_step, "3,1,2,0.0,80.5,1e3,-1.0", "peak_overlap: \"-1.0\" is not a finite number from 0 on"),
        ("active", "3,1,2,0.0,2", "active: \"2\" is not 1 or 0"),
    ] {
        let more = if more.is_empty() { String::new() } else { format!(",{more}") };
        let message = read(&more, row).unwrap_err().to_string();
        assert!(message.contains(&format!("line 2: column {expected}")), "{message}");
    }
}

#[test]
fn mistakes_name_file_line_and_column() {
    let directory = TempDir::new().unwrap();
    let message = |text: &str| {
        let message = Run::read_table(&table(&directory, text)).unwrap_err().to_string();
        assert!(message.contains("run.csv: "), "{message}");
        message
    };
    let row = "0.1,a,1,2,0,0,0,0,0";
    for (rows, expected) in [
        ("", "the run is empty"),
        ("0.1,a,1,two,0,0,0,0,0", "line 2: column y: \"two\" is not a finite number"),
        ("0.1,a,1,2,0,0,0,inf,0", "line 2: column omega: \"inf\""),
        ("0.1,a,1,2", "line 2: has 4 columns, the header 9"),
        ("0.1,,1,2,0,0,0,0,0", "line 2: column id: is empty"),
        (&format!("{row}\n{row}"), "line 3: column id: agent \"a\" stands twice at t = 0.1 s"),
        (&format!("{row}\n0,a,1,2,0,0,0,0,0"), "line 3: column t: t = 0.0 s must not come after t = 0.1 s"),
        (&format!("{row}\n0.2,b,1,2,0,0,0,0,0"), "line 3: column id: agent \"b\" was not there"),
        (
            &format!("{row}\n0.1,b,1,2,0,0,0,0,0\n0.2,b,1,2,0,0,0,0,0"),
            "line 4: at t = 0.2 s agent \"a\" is missing",
        ),
    ] {
        let message = message(&format!("{HEADER}\n{rows}\n"));
        assert!(message.contains(expected), "{message}");
    }
    for (text, expected) in [
        ("t,id,x,y,vx,vy,omega\n", "line 1: there is no column \"theta\""),
        ("t,id,x,y,vx,vy,theta,omega,x\n", "two columns \"x\""),
        ("", "there is no column \"t\""),
    ] {
        assert!(message(text).contains(expected), "{}", message(text));
    }
    let path = directory.path().join("run.csv");
    fs::write(&path, [HEADER.as_bytes(), b"\n0,a,\xff,0,0,0,0,0,0\n"].concat()).unwrap();
    let message = Run::read_table(&path).unwrap_err().to_string();
    assert!(message.contains("line 2: column 3: is not UTF-8"), "{message}");
    fs::remove_file(&path).unwrap();
    let missing = Run::read_table(&path).unwrap_err().to_string();
    assert!(missing.contains("run.csv: cannot be read"), "{missing}");
}

#[test]
fn times_must_be_even() {
    let directory = TempDir::new().unwrap();
    let run = |times: &[f64]| {
        let rows: String = times.iter().map(|t| format!("{t:?},0,0,0,0,0,0,0,0\n")).collect();
        Record::table(&table(&directory, &format!("{HEADER}\n{rows}"))).unwrap()
    };
    let from = |first: f64, step: f64| (0..8).map(|k| first + f64::from(k) * step).collect::<Vec<f64>>();
    let uneven = [0.0, 0.1, 0.2, 0.25];
    for (times, every, rate) in [
        (&from(10.0, 0.2)[..], 1, 5.0),
        (&from(10.0, 0.2), 2, 2.5),
        (&from(0.0, 1.0 / 3.0), 1, 3.0),
        (&from(0.3, 1.6), 1, 0.625),
        (&uneven, 2, 5.0),
    ] {
        assert_eq!(run(times).every(every).frame_rate().unwrap(), rate);
    }
    let nowhere = walkable_area(&[], std::iter::once(Vec2::zeros()));
    let path = directory.path().join("out");
    for message in [
        pedpy(&run(&uneven), Staged::beside(&path).unwrap(), &path).unwrap_err().to_string(),
        jupedsim(&run(&uneven), &nowhere, &path).unwrap_err().to_string(),
    ] {
        assert!(
            message.contains("run.csv: line 5: column t: t = 0.25 s comes 0.050000 s after"),
            "{message}"
        );
        assert!(!path.exists());
    }
    for (times, expected) in [
        (&[1.0][..], "one frame only"),
        // PedPy was told "inf fps" and "0.0 fps".
        (&[0.0, 5e-324], "the time between its frames is 5e-324 s, which gives no usable frame rate"),
        (&[-1e308, 1e308], "the time between its frames is inf s, which gives no usable frame rate"),
    ] {
        let message = run(times).frame_rate().unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
    chaos(&run(&uneven), &path).unwrap();
}

#[test]
fn formats_are_as_their_readers_want_them() {
    let directory = TempDir::new().unwrap();
    let at = |name: &str| directory.path().join(name);
    let run = Record::from(good(&directory));
    pedpy(&run, Staged::beside(&at("t.txt")).unwrap(), &at("t.txt")).unwrap();
    let text = fs::read_to_string(at("t.txt")).unwrap();
    let expected = "# framerate: 10.0 fps\n# id frame x/m y/m z/m\n7 0 0.0 0.5 0.0\n3 0 1.0 0.5 0.0\n\
                    7 1 0.3333333333333333 0.5 0.0\n";
    assert!(text.starts_with(expected), "{text}");
    assert_eq!(text.lines().count(), 8);

    chaos(&run, &at("chaos")).unwrap();
    chaos(&run, &at("chaos")).unwrap();
    let text = fs::read_to_string(at("chaos/traj001.csv")).unwrap();
    assert_eq!(text, "0.0,1.0,0.5,0.0\n0.1,1.3333333333333333,0.5,0.0\n0.2,1.6666666666666665,0.5,0.0\n");
    fs::write(at("chaos/traj002.csv"), "").unwrap();
    let message = chaos(&run, &at("chaos")).unwrap_err().to_string();
    assert!(message.contains("traj002.csv: is of another run"), "{message}");

    fs::write(at("t.sqlite"), "what was there before").unwrap();
    let positions = run.positions().unwrap();
    jupedsim(&run, &walkable_area(&[], positions.into_iter()), &at("t.sqlite")).unwrap();
    let database = rusqlite::Connection::open(at("t.sqlite")).unwrap();
    let one = |query: &str| database.query_row(query, [], |row| row.get::<_, String>(0)).unwrap();
    for (key, value) in [("version", "2"), ("fps", "10.0"), ("xmin", "-0.5")] {
        assert_eq!(one(&format!("SELECT value FROM metadata WHERE key = '{key}'")), value);
    }
    assert!(one("SELECT value FROM metadata WHERE key = 'walkable_area'").contains("bounding box"));
    assert_eq!(one("SELECT count(*) || '' FROM trajectory_data"), "6");
    assert_eq!(one("SELECT count(*) || '' FROM frame_data, geometry WHERE geometry_hash = hash"), "3");
    let query = "SELECT pos_x, ori_x, ori_y FROM trajectory_data WHERE frame = 2 AND id = 3";
    let seen: (f64, f64, f64) =
        database.query_row(query, [], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?))).unwrap();
    assert_eq!(seen.0, 1.0 + 2.0 / 3.0);
    assert!((seen.1 - 0.968_912_421_710_644_8).abs() < 1e-15, "cos 0.25: {}", seen.1);
    assert!((seen.2 - 0.247_403_959_254_522_93).abs() < 1e-15, "sin 0.25: {}", seen.2);
    let left: Vec<_> =
        fs::read_dir(directory.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left.len(), 4, "no temporary file is left: {left:?}");
}

#[test]
fn agents_are_those_of_the_trial() {
    let directory = TempDir::new().unwrap();
    let resources = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../resources/Trial_push");
    let (mut trial, _) = setup::read(&resources).unwrap();
    let message = Record::from(good(&directory)).of_trial(&trial).err().unwrap().to_string();
    assert!(message.contains("column id: there is no agent \"7\" in the Trial \"Trial_push\""), "{message}");
    trial.agents[0].id = "3".into();
    trial.agents[1].id = "7".into();
    trial.agents[2].id = "2b".into();
    let message = Record::from(good(&directory)).of_trial(&trial).err().unwrap().to_string();
    assert!(message.contains("has no agent \"2b\""), "{message}");
    trial.agents.truncate(2);
    let run = Record::from(good(&directory)).of_trial(&trial).unwrap().read_wanted(KeptFrames::All).unwrap();
    assert_eq!((run.ids[0].as_str(), run.frames[0].agents[0].pose.position.x), ("3", 1.0));
    assert_eq!(Record::from(run.clone()).numeric_ids(), Some(vec![3, 7]));
    let named = Record::from(Run { ids: vec!["3".into(), "b".into()], ..run });
    assert_eq!((named.numbers(), named.numeric_ids()), (vec![0, 1], None));
}
