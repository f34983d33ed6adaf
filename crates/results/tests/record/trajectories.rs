//! Trajectories of others: what is read of texts and databases, and what is refused.

use lemons_core::files::Staged;
use lemons_results::columns::Effect;
use lemons_results::{
    Area, Frame, KeptFrames, Record, RecordError, Run, Told, given_area, holds_trajectories, jupedsim, pedpy,
};
use rusqlite::Connection;
use std::fs::write;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use tempfile::TempDir;

fn directory() -> TempDir {
    tempfile::tempdir().unwrap()
}

fn file(at: &TempDir, text: &str) -> PathBuf {
    let path = at.path().join("walk.txt");
    write(&path, text).unwrap();
    path
}

fn read(path: &Path, told: &Told) -> Result<(Record, Run), String> {
    let record = Record::of_others(path, told).map_err(|error| error.to_string())?;
    let run = record.read_wanted(KeptFrames::All).map_err(|error| error.to_string())?;
    Ok((record, run))
}

fn x(frame: &Frame, agent: usize) -> Option<f64> {
    frame.is_there(agent).then(|| frame.agents[agent].pose.position.x)
}

/// x = 1 + 2 t + t² of id 7 from frame 2 to 8, at 4 frames per second; id 3 stands in frames 0, 1, 4 and 5.
const TWO: &str = "\u{feff}# framerate: 4.00 fps\n# id frame x/cm y/cm z/cm\n\
    7\t2\t225\t0 170\n7 3 306.25 0 170\n7 4 400 0\n7 5 506.25 0\n7 6 625 0\n7 7 756.25 0\n7 8 900 0\n\n\
    # seen twice\n3 0 5e2 -10 0\n3 1 500 -10 0\n3 5.0 510 -10 # left\n3 4 510 -10 0\n";

#[test]
fn people_appear_and_vanish_and_velocities_are_central_differences() {
    let at = directory();
    let path = file(&at, TWO);
    assert!(holds_trajectories(&path).unwrap());
    let (record, run) = read(&path, &Told { velocity_over: 1.0, ..Told::default() }).unwrap();
    let about = record.trajectories().unwrap();
    assert_eq!(
        (about.rate, about.velocity_frames, about.velocity_over(), about.oriented),
        (4.0, 2, 1.0, false)
    );
    assert_eq!(run.ids, ["3", "7"]);
    assert_eq!(record.times().collect::<Vec<_>>(), (0..9).map(|k| f64::from(k) / 4.0).collect::<Vec<_>>());
    let there = |agent: usize| run.frames.iter().map(|frame| x(frame, agent)).collect::<Vec<_>>();
    let some = Some;
    assert_eq!(there(0), [some(5.0), some(5.0), None, None, some(5.1), some(5.1), None, None, None]);
    assert_eq!(there(1)[..3], [None, None, some(2.25)]);
    // Of x = 1 + 2 t + t² the central difference is the derivative; at the ends it is that of the middle of the half.
    for (frame, time) in [(2, 0.75), (3, 1.0), (4, 1.0), (5, 1.25), (6, 1.5), (7, 1.5), (8, 1.75)] {
        let velocity = run.frames[frame].agents[1].twist.velocity;
        assert!((velocity.x - 2.0 - 2.0 * time).abs() < 1e-12 && velocity.y == 0.0, "{frame}: {velocity:?}");
    }
    // Nobody was seen for long enough, and no difference goes over the gap.
    assert!([0, 1, 4, 5].iter().all(|k| run.frames[*k].agents[0].twist.velocity.x.is_nan()));
    assert_eq!(run.frames[2].agents[0].twist.velocity.x, 0.0);
    let (_, run) = read(&path, &Told { velocity_over: 0.5, ..Told::default() }).unwrap();
    let velocities = [0, 1, 4, 5].map(|k| run.frames[k].agents[0].twist.velocity.x);
    assert_eq!(velocities, [0.0; 4]);
    assert!(run.frames.iter().all(|frame| !Effect::ALL.iter().any(|of| frame.effects.knows(*of))));
}

#[test]
fn a_text_without_a_head_is_told_its_unit_and_rate() {
    let at = directory();
    let path = file(&at, "1 10 1.5 2\n1 15 2 2\n1 20 2.5 2\n");
    let told = Told { per_metre: Some(1.0), rate: Some(25.0), ..Told::default() };
    let (record, run) = read(&path, &told).unwrap();
    // Every fifth frame is there.
    assert_eq!(record.times().collect::<Vec<_>>(), [0.4, 0.6, 0.8]);
    assert_eq!((record.frame_rate().unwrap(), run.frames[1].agents[0].twist.velocity.x), (5.0, 2.5));
    assert!(run.frames[0].active.is_none(), "all are always there");
    let message = |told: &Told| read(&path, told).err().unwrap();
    assert!(
        message(&Told { per_metre: None, ..told })
            .contains("walk.txt: line 1: x = 1.5: no comment before it says the unit")
    );
    assert!(message(&Told { rate: None, ..told }).contains("does not say how many frames per second"));
    assert!(
        message(&Told { rate: Some(f64::NAN), ..told }).contains("NaN frames per second: must be from 1e-6")
    );
    let path = file(&at, TWO);
    let message = |told: &Told| read(&path, told).err().unwrap();
    assert!(message(&told).contains("another unit than is told"));
    assert!(message(&Told { per_metre: None, ..told }).contains("says 4.0 frames per second, not 25.0"));
}

#[test]
fn a_text_says_what_is_wrong_in_it() {
    let at = directory();
    let head = "# framerate: 10\n# x/m y/m\n";
    for (rows, expected) in [
        ("1 1 nan 0", "line 3: column x: \"nan\" is not a finite number"),
        ("1 1 0 inf", "line 3: column y: \"inf\" is not a finite number"),
        ("1 1 0 1e7", "line 3: column y: 10000000.0 m is not a number up to 1e6 m"),
        ("1.5 1 0 0", "line 3: column id: \"1.5\" is not a whole number"),
        ("1 0\n", "line 3: has 2 columns"),
        ("-1 1 0 0", "line 3: column id: -1 is below 0"),
        ("1 -1 0 0", "line 3: column frame: -1 is below 0"),
        ("1 1000000000001 0 0", "line 3: column frame: 1000000000001 is above 1e12"),
        ("99999999999999999999 1 0 0", "line 3: column id: \"99999999999999999999\" is not a whole number"),
        ("1 1 0 0\n2 1 0 0\n1 1 0 1", "line 5: id 1 stands twice in frame 1, also in line 3"),
        (
            "1 1 0 0\n1 2 0 0\n1 1000000000 0 0",
            "from frame 1 to 1000000000 there are 1000000000 frames, with places for 1",
        ),
        ("", "holds no trajectories"),
        ("# framerate: 12\n1 1 0 0", "line 3: there are two frame rates"),
        ("# in cm\n1 1 0 0", "line 3: there are two units"),
        ("# framerate: fast\n1 1 0 0", "begins with no plain number"),
        ("# framerate: 30000/1001\n1 1 0 0", "framerate: \"30000/1001\" begins with no plain number"),
        ("# framerate: 12,5\n1 1 0 0", "begins with no plain number"),
    ] {
        let message = read(&file(&at, &format!("{head}{rows}")), &Told::default()).err().unwrap();
        assert!(
            message.starts_with(&at.path().display().to_string()) && message.contains(expected),
            "{rows:?}: {message}"
        );
    }
    let message = |text: &[u8]| {
        let path = at.path().join("bytes");
        write(&path, text).unwrap();
        read(&path, &Told::default()).err().unwrap()
    };
    assert!(message(b"# x/m\n1 1 \xff 0\n").contains("line 2: is not UTF-8 text"));
    assert!(message(&[b'1'; 100_000]).contains("line 1: is longer than 65536 bytes"));
    assert!(message(b"t,id,x,y\n").contains("holds no trajectories"));
    assert!(
        message(b"# framerate: -25\n# x/m\n1 1 0 0\n").contains("-25.0 frames per second: must be from 1e-6")
    );
    // A frame far away is no many frames.
    let alone = file(&at, &format!("{head}9000000000000000000 1000000000 0 0\n"));
    assert_eq!(read(&alone, &Told::default()).unwrap().0.times().collect::<Vec<_>>(), [1e8]);
}

const TABLES: &str = "
    CREATE TABLE trajectory_data (frame INTEGER, id INTEGER, pos_x REAL, pos_y REAL, ori_x REAL, ori_y REAL);
    CREATE TABLE metadata (key TEXT NOT NULL UNIQUE PRIMARY KEY, value TEXT NOT NULL);
    INSERT INTO metadata VALUES ('version', '1'), ('fps', '8.0');
    CREATE TABLE geometry (wkt TEXT NOT NULL);
    INSERT INTO geometry VALUES ('POLYGON ((0 0, 9 0, 9 9, 0 9, 0 0))');
    INSERT INTO trajectory_data VALUES (2, 4, 1.0, 1, 0, 2), (3, 4, 1.5, 1, -1, 0), (3, 5, 2.0, 2, 1, 0);";

fn database(at: &TempDir, change: &str) -> PathBuf {
    let path = at.path().join("walk ?#%.sqlite");
    let _ = std::fs::remove_file(&path);
    let database = Connection::open(&path).unwrap();
    database.execute_batch(TABLES).unwrap();
    database.execute_batch(change).unwrap();
    path
}

#[test]
fn databases_of_both_versions_are_read() {
    let at = directory();
    let (record, run) = read(&database(&at, ""), &Told::default()).unwrap();
    assert_eq!(run.ids, ["4", "5"]);
    assert_eq!(record.times().collect::<Vec<_>>(), [0.25, 0.375]);
    let orientation = |frame: usize| run.frames[frame].agents[0].pose.orientation;
    assert_eq!([orientation(0), orientation(1)], [0.5, 1.0].map(|turns: f64| turns * std::f64::consts::PI));
    assert_eq!(x(&run.frames[0], 1), None);
    let about = record.trajectories().unwrap();
    assert!(about.oriented && about.geometry == ["POLYGON ((0 0, 9 0, 9 9, 0 9, 0 0))"]);
    // Version 2 names frames in which nobody is, and may have several geometries.
    let second = "UPDATE metadata SET value = '2' WHERE key = 'version'; DROP TABLE geometry;
        CREATE TABLE geometry (hash INTEGER, wkt TEXT); INSERT INTO geometry VALUES (1, 'A'), (2, 'B'), (3, 'A');
        CREATE TABLE frame_data (frame INTEGER, geometry_hash INTEGER); INSERT INTO frame_data VALUES (1, 1), (6, 2);
        UPDATE trajectory_data SET ori_x = 0.0 WHERE id = 5;";
    let (record, run) = read(&database(&at, second), &Told::default()).unwrap();
    assert_eq!((run.frames.len(), run.frames[5].present().count()), (6, 0));
    let about = record.trajectories().unwrap();
    assert!(!about.oriented && about.geometry == ["A", "B"]);
    // People may be in every second frame only.
    let spaced = "CREATE TABLE frame_data (frame INTEGER, geometry_hash INTEGER); INSERT INTO frame_data VALUES (2, 1),
        (6, 1), (10, 1), (14, 1), (18, 1); UPDATE trajectory_data SET frame = 10 WHERE frame = 3;";
    let (record, run) = read(&database(&at, spaced), &Told::default()).unwrap();
    assert_eq!(record.times().collect::<Vec<_>>(), [0.25, 0.75, 1.25, 1.75, 2.25]);
    assert_eq!(run.frames.iter().map(|frame| frame.present().count()).collect::<Vec<_>>(), [1, 0, 2, 0, 0]);
    // Nothing is left beside it.
    assert_eq!(std::fs::read_dir(at.path()).unwrap().count(), 1);
}

#[test]
fn a_database_says_what_is_wrong_in_it() {
    let at = directory();
    for (change, expected) in [
        (
            "DROP TABLE trajectory_data",
            "is a database, but not of JuPedSim: it has no table \"trajectory_data\"",
        ),
        ("DROP TABLE metadata", "it has no table \"metadata\""),
        (
            "UPDATE metadata SET value = '3' WHERE key = 'version'",
            "metadata: version is \"3\": versions 1 and 2",
        ),
        ("DELETE FROM metadata WHERE key = 'version'", "metadata: there is no version"),
        ("DELETE FROM metadata WHERE key = 'fps'", "does not say how many frames per second"),
        (
            "UPDATE metadata SET value = 'x' WHERE key = 'fps'",
            "metadata: fps is \"x\", which is not a number",
        ),
        ("UPDATE metadata SET value = '0' WHERE key = 'fps'", "0.0 frames per second: must be from 1e-6"),
        ("DELETE FROM trajectory_data", "holds no row"),
        ("UPDATE trajectory_data SET pos_x = NULL WHERE id = 5", "row 3: column pos_x: NULL is not a number"),
        (
            "UPDATE trajectory_data SET pos_y = 1e300 WHERE id = 5",
            "row 3: column y: 1e300 m is not a number up to",
        ),
        (
            "UPDATE trajectory_data SET id = 'Ann' WHERE id = 5",
            "row 3: column id: \"Ann\" is not a whole number",
        ),
        ("UPDATE trajectory_data SET id = -2 WHERE id = 5", "row 3: column id: -2 is below 0"),
        (
            "UPDATE trajectory_data SET id = 4",
            "row 3: id 4 stands twice in frame 3, also in trajectory_data: row 2",
        ),
        ("ALTER TABLE trajectory_data DROP COLUMN ori_y", "there is no column \"ori_y\""),
        (
            "DROP TABLE trajectory_data; CREATE VIEW trajectory_data AS WITH RECURSIVE n(k) AS (SELECT 1 UNION ALL \
             SELECT k + 1 FROM n) SELECT k AS frame, 1 AS id, 0.0 AS pos_x, 0.0 AS pos_y, 0.0 AS ori_x, 0.0 AS ori_y FROM n",
            "it has no table \"trajectory_data\"",
        ),
        (
            "CREATE TABLE frame_data (frame INTEGER, geometry_hash INTEGER); INSERT INTO frame_data VALUES (-1, 1)",
            "frame_data: column frame: from -1 to -1: must be from 0",
        ),
        (
            "CREATE TABLE frame_data (frame INTEGER); INSERT INTO frame_data VALUES (-9223372036854775808), (9223372036854775807)",
            "frame_data: column frame: from -9223372036854775808 to 9223372036854775807: must be from 0",
        ),
        (
            "WITH RECURSIVE n(k) AS (SELECT 1 UNION ALL SELECT k + 1 FROM n WHERE k < 5) \
             INSERT INTO geometry SELECT printf('%.*c', 16000000, char(64 + k)) FROM n",
            "their texts are larger than 67108864 bytes",
        ),
        (
            "WITH RECURSIVE n(k) AS (SELECT 1 UNION ALL SELECT k + 1 FROM n WHERE k < 1001) \
             INSERT INTO geometry SELECT k FROM n",
            "has more than 1000 geometries",
        ),
    ] {
        let message = read(&database(&at, change), &Told::default()).err().unwrap();
        assert!(message.contains(expected), "{change}: {message}");
    }
    let path = database(&at, "");
    let whole = std::fs::read(&path).unwrap();
    // Cut off anywhere, it is refused; or what is there is sound.
    for size in [16, 100, 1000, 4096, 5000, 8192, whole.len() - 4096] {
        write(&path, &whole[..size]).unwrap();
        let message = read(&path, &Told::default()).err().unwrap();
        assert!(
            message.contains("is no sound database") || message.contains("not of JuPedSim"),
            "{size}: {message}"
        );
    }
    write(&path, &whole).unwrap();
    let journal = at.path().join("walk ?#%.sqlite-wal");
    write(&journal, "not empty").unwrap();
    assert!(read(&path, &Told::default()).err().unwrap().contains("there is a file -wal beside it"));
}

#[test]
fn frames_without_anybody_do_not_fill_the_memory() {
    let at = directory();
    let path = file(&at, "# framerate: 10\n# x/m\n1 0 0 0\n1 1 0 0\n1 6999999 0 0");
    let record = Record::of_others(&path, &Told::default()).unwrap();
    assert_eq!(record.frames(), 7_000_000);
    let message = record.read_wanted(KeptFrames::All).unwrap_err().to_string();
    assert!(
        message.contains("7000000 frames with places for 1 people would take more than 2 GB"),
        "{message}"
    );
    let stopped = record.read_unless(&AtomicBool::new(true), KeptFrames::Around(Vec::new())).unwrap_err();
    assert!(matches!(stopped, RecordError::Stopped { .. }));
}

#[test]
fn a_first_frame_without_a_whole_number_is_told() {
    let at = directory();
    let path = file(&at, "# framerate: 10\n# x/m\n1 1001 0 0\n1 1002 0 0\n1 1003 0 0\n");
    let record = Record::of_others(&path, &Told::default()).unwrap();
    let lost = |every: usize| record.clone().every(every).lost_time();
    assert_eq!([1, 2, 7].map(lost), [None, Some(100.1), None]);
    let path = file(&at, TWO);
    assert_eq!(Record::of_others(&path, &Told::default()).unwrap().every(2).lost_time(), None);
}

/// Exports in either format come back, with their times.
#[test]
fn exports_come_back() {
    let at = directory();
    let told = Told { velocity_over: 0.5, ..Told::default() };
    let (record, run) = read(&file(&at, TWO), &told).unwrap();
    let positions = record.positions().unwrap();
    let area: Area =
        given_area("POLYGON ((0 -1, 10 -1, 10 1, 0 1, 0 -1))", positions.iter().copied()).unwrap();
    let (text, sqlite) = (at.path().join("again.txt"), at.path().join("again.sqlite"));
    let later = record.clone().every(2);
    for (record, every) in [(&record, 1), (&later, 2)] {
        pedpy(record, Staged::beside(&text).unwrap(), &text).unwrap();
        jupedsim(record, &area, &sqlite).unwrap();
        for path in [&text, &sqlite] {
            let (again, copy) = read(path, &told).unwrap();
            assert_eq!(again.times().collect::<Vec<_>>(), record.times().collect::<Vec<_>>());
            assert!(!again.trajectories().unwrap().oriented);
            for (frame, own) in copy.frames.iter().zip(run.frames.iter().step_by(every)) {
                assert_eq!([x(frame, 0), x(frame, 1)], [x(own, 0), x(own, 1)]);
            }
        }
    }
    let again = Record::of_others(&sqlite, &told).unwrap();
    assert_eq!(again.trajectories().unwrap().geometry, [area.polygon.to_wkt()]);
}
