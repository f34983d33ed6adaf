//! Any bytes as what runs, sweeps and crowds read.

use crate::fuzz::files::{archive_of, directory};
use crate::fuzz::models::small_trial;
use crate::fuzz::show_panics;
use lemons_core::files::Staged;
use lemons_core::plane::{Motion, Vec2};
use lemons_core::trial::{DriveChoice, DriveTable};
use lemons_master::SavedRun;
use lemons_results::columns::{Effect, Groups};
use lemons_results::{
    FrameWriter, OfLegs, Record, RecordError, Run, TableContent, TableFormat, TableWriter, Told, Totals,
    pedpy,
};
use lemons_sim::Clock;
use lemons_sweep::{Finished, MeasuredValue, Points, Spec, SweepTable};
use std::collections::HashSet;
use std::fs::File;
use std::path::Path;

/// A drive file: refused in words, from a file with its name, or pushes between those of its rows, nothing outside of
/// them, which read back from columns in another order.
pub fn drive_csv(data: &[u8]) {
    show_panics();
    let drive = match DriveTable::from_csv(data) {
        Ok(drive) => drive,
        Err(error) => {
            let directory = directory();
            let path = directory.path().join("drive.csv");
            std::fs::write(&path, data).expect("a file");
            let of_file = DriveTable::of(Some(&small_trial()), &DriveChoice::File(path.clone()));
            return assert_eq!(of_file.expect_err("as its content"), error.of_file(&path));
        }
    };
    let records = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(data).into_byte_records().count();
    let mut text = csv::Writer::from_writer(Vec::new());
    text.write_record(["\u{feff}Mp", "agent", "Fp.y", "t", "more", "Fp.x"]).expect("written into memory");
    let mut rows = 0;
    for agent in drive.agents() {
        drives(&drive, agent);
        for (time, [x, y, m]) in drive.rows(agent).expect("an agent of the drive has rows") {
            let [time, x, y, m] = [time, x, y, m].map(|value| format!("{value:?}"));
            text.write_record([m.as_str(), agent, &y, &time, "", &x]).expect("written into memory");
            rows += 1;
        }
    }
    assert_eq!(rows, records, "each row is somebody's");
    let text = text.into_inner().expect("written into memory");
    let again = DriveTable::from_csv(&text[..]).expect("what was read is written and read back");
    assert_eq!(again.fingerprint(), drive.fingerprint(), "{}", String::from_utf8_lossy(&text));
}

/// An agent is pushed as each of its rows says, and by nothing before the first and after the last.
fn drives(drive: &DriveTable, agent: &str) {
    let rows = drive.rows(agent).expect("an agent of the drive has rows");
    let at = |time: f64| drive.at(agent, time).expect("a push");
    assert!(rows.windows(2).all(|pair| pair[0].0 < pair[1].0), "the rows of {agent:?} go forward");
    assert!(rows.iter().all(|(time, push)| at(*time) == *push), "at a row is what the row says");
    for outside in [rows[0].0.next_down(), rows[rows.len() - 1].0.next_up()] {
        assert_eq!(at(outside), [0.0; 3], "at {outside:?} of {rows:?}");
    }
}

/// A table as text (Parquet is read by a crate of its own) that `lemons plot` and `export` read: refused in words, or a
/// run that reads back from a table in either format, and that PedPy can be given.
pub fn table_csv(data: &[u8]) {
    if data.starts_with(b"PAR1") {
        return;
    }
    show_panics();
    let directory = directory();
    let path = directory.path().join("table");
    std::fs::write(&path, data).expect("a file");
    let run = match Run::read_table(&path) {
        Ok(run) => run,
        Err(error) => {
            let frame_by_frame = Record::table(&path).err().map(|error| error.to_string());
            assert_eq!(frame_by_frame.as_ref(), Some(&error.to_string()));
            return assert!(names_file(&error, &path), "{error}");
        }
    };
    assert!(!run.frames.is_empty() && !run.ids.is_empty());
    assert!(run.frames.windows(2).all(|pair| pair[0].time < pair[1].time), "times go forward");
    assert!(run.frames.iter().all(|frame| frame.agents.len() == run.ids.len()), "everybody at every time");
    let different: HashSet<&String> = run.ids.iter().collect();
    assert_eq!(different.len(), run.ids.len(), "an agent stands twice: {:?}", run.ids);
    for format in [TableFormat::Csv, TableFormat::Parquet] {
        let again = directory.path().join("again");
        write(&run, &again, format);
        let back = Run::read_table(&again).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(back.ids, run.ids);
        assert!(content(&back).eq(content(&run)), "{back:?}\n{run:?}");
    }
    let record = Record::table(&path).unwrap_or_else(|error| panic!("{error}"));
    assert!(record.times().eq(run.frames.iter().map(|frame| frame.time)), "{run:?}");
    let text = directory.path().join("pedpy.txt");
    if let Err(error) = pedpy(&record, Staged::beside(&text).expect("a file"), &text) {
        assert!(names_file(&error, &path) && !text.exists(), "{error}");
    }
}

/// A text with trajectories of others (databases are read by SQLite): refused in words, or frames that are the same after
/// they were written for PedPy and read again.
pub fn trajectories(data: &[u8]) {
    show_panics();
    let directory = directory();
    let (path, again) = (directory.path().join("walk"), directory.path().join("again"));
    std::fs::write(&path, data).expect("a file");
    for told in [Told::default(), Told { per_metre: Some(100.0), rate: Some(12.5), ..Told::default() }] {
        let record = match Record::of_others(&path, &told) {
            Ok(record) => record,
            Err(error) => {
                assert!(names_file(&error, &path), "{error}");
                continue;
            }
        };
        let times: Vec<f64> = record.times().collect();
        assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "times go forward");
        pedpy(&record, Staged::beside(&again).expect("a file"), &again)
            .unwrap_or_else(|error| panic!("{error}"));
        let copy = Record::of_others(&again, &Told { velocity_over: told.velocity_over, ..Told::default() })
            .unwrap_or_else(|error| panic!("{error}"));
        let numbers: Vec<String> = record.numbers().iter().map(i64::to_string).collect();
        assert_eq!(copy.ids(), numbers);
        assert_eq!(places(&copy), places(&record));
    }
}

/// Returns where people were, in the frames with anybody.
fn places(record: &Record) -> Vec<Vec<(usize, Vec2)>> {
    let mut all = Vec::new();
    let read = record.each(|_, frame| {
        let there: Vec<_> = frame.present().map(|(place, agent)| (place, agent.pose.position)).collect();
        all.extend((!there.is_empty()).then_some(there));
        Ok(())
    });
    read.unwrap_or_else(|error| panic!("{error}"));
    all
}

fn names_file(error: &RecordError, path: &Path) -> bool {
    error.to_string().starts_with(&format!("{}: ", path.display()))
}

type Row<'a> = (u64, &'a Motion, [Option<f64>; Effect::ALL.len()], Option<&'a OfLegs>, Option<Totals>);

fn content(run: &Run) -> impl Iterator<Item = Row<'_>> {
    run.frames.iter().flat_map(|frame| {
        let seen = |k: usize| Effect::ALL.map(|effect| frame.effects.get(effect, k));
        let legs = |k: usize| frame.legs.as_ref().map(|legs| &legs[k]);
        // -0.0 and 0.0 are one time.
        let time = (frame.time + 0.0).to_bits();
        frame.agents.iter().enumerate().map(move |(k, agent)| (time, agent, seen(k), legs(k), frame.totals))
    })
}

fn write(run: &Run, path: &Path, format: TableFormat) {
    let groups = Groups::of(&run.frames[0]);
    let content = TableContent { columns: groups.columns(), about: Vec::new() };
    let file = File::create(path).expect("a file");
    let table = TableWriter::create(file, path, format, &content).expect("a table");
    let mut writer = FrameWriter::new(table, run.ids.clone(), groups);
    run.frames.iter().for_each(|frame| writer.frame(frame).expect("a file"));
    writer.finish().expect("a file");
}

/// A `sweep.toml`, or, after an odd byte, the table of points that one names: refused in words, or points that can
/// be simulated: finite, of different names, no more than the memory takes. They read back
/// from the tables of their results.
pub fn sweep_toml(data: &[u8]) {
    let Some((&way, content)) = data.split_first() else { return };
    show_panics();
    let directory = directory();
    let path = directory.path().join("sweep.toml");
    let table = directory.path().join(TABLE);
    if way % 2 == 0 {
        std::fs::write(&path, content).expect("a file");
    } else {
        std::fs::write(&path, OF_A_TABLE).expect("a file");
        std::fs::write(&table, content).expect("a file");
    }
    let spec = match Spec::read(&path) {
        Ok(spec) => spec,
        Err(error) => {
            let error = error.whole();
            assert!(error.contains(path.to_str().expect("UTF-8")), "{error}");
            let of_table = error.contains(table.to_str().expect("UTF-8"))
                || error.ends_with("the table already has a column with this name");
            return assert!(way % 2 == 0 || of_table, "{error}");
        }
    };
    let (measures, Spec { until, step, points, .. }) = (spec.measured(), spec);
    assert!(
        until.latest() > 0.0
            && until.latest().is_finite()
            && step.is_none_or(|step| step > 0.0 && step.is_finite())
    );
    assert!(points.count > 0);
    let mut names: Vec<&String> =
        points.parameters.iter().map(|parameter| &parameter.name).chain(&measures).collect();
    let all = names.len();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), all, "{names:?}");
    if points.count <= 20 {
        kept(&points, &measures, &directory.path().join("results"));
    }
}

/// Table of points of a sweep, in its directory.
const TABLE: &str = "points.csv";
const OF_A_TABLE: &str = "fmu = 'x.fmu'\nuntil = 1\ntable = 'points.csv'\n[measures]\n\
                          far = { of = 'x', take = 'max' }\n";
/// Measures of such a sweep stay in its table, and when it is opened again.
fn kept(points: &Points, measures: &[String], path: &Path) {
    let outcome = |point: usize| match point % 3 {
        2 => Err("it \"fell\", badly".to_owned()),
        way => Ok((0..measures.len())
            .map(|k| (k % 2 == way).then(|| MeasuredValue::Number(point as f64 / 3.0)))
            .collect()),
    };
    let rows: Vec<Finished> =
        (0..points.count).map(|point| Finished { point, outcome: outcome(point) }).collect();
    let open = || {
        let mut table =
            SweepTable::open(path, &Default::default(), points).unwrap_or_else(|error| panic!("{error:?}"));
        table.name_measures(measures).unwrap_or_else(|error| panic!("{error:?}"));
        table
    };
    let mut table = open();
    let (before, after) = rows.split_at(rows.len() / 2);
    for part in [after, before] {
        table.add(part).unwrap_or_else(|error| panic!("{error:?}"));
    }
    drop(table);
    assert!(open().rows().eq(&rows));
    assert_eq!(open().finish().unwrap_or_else(|error| panic!("{error:?}")), rows);
    assert!(open().rows().eq(&rows));
}

/// A `.run` file: the bytes themselves, or, after an odd byte, an archive in which they are `run.toml` and that has the
/// states that they name: refused in words that name the file, or a saved run that is written and reads back, always
/// to the same bytes.
pub fn run_file(data: &[u8]) {
    let Some((&way, content)) = data.split_first() else { return };
    show_panics();
    let directory = directory();
    let path = directory.path().join("x.run");
    let bytes = match way % 2 {
        0 => content.to_vec(),
        _ => with_its_states(content),
    };
    std::fs::write(&path, bytes).expect("a file");
    let (saved, states) = match SavedRun::read(&path) {
        Ok(read) => read,
        Err(error) => {
            let error = error.whole();
            return assert!(error.contains(&path.display().to_string()), "{error}");
        }
    };
    sound(&saved);
    assert_eq!(states.len(), saved.component.len());
    for (component, state) in saved.component.iter().zip(&states) {
        assert_eq!(component.bytes, state.len() as u64);
    }
    let again = directory.path().join("again.run");
    let write = || {
        saved
            .clone()
            .write(&states, Staged::beside(&again).expect("a file"))
            .unwrap_or_else(|error| panic!("{error:?}"));
        std::fs::read(&again).expect("a file")
    };
    let first = write();
    let (back, same) = SavedRun::read(&again).unwrap_or_else(|error| panic!("{error:?}"));
    assert!(back == saved && same == states, "{back:?}\n{saved:?}");
    assert_eq!(write(), first, "the same run gives the same bytes");
}

/// An archive with this `run.toml`, and an entry of the right size for each state that it names.
fn with_its_states(text: &[u8]) -> Vec<u8> {
    const LARGEST: usize = 100;
    let mut files = vec![("run.toml".to_owned(), text.to_vec())];
    let table = std::str::from_utf8(text).ok().and_then(|text| text.parse::<toml::Table>().ok());
    for component in table.iter().filter_map(|table| table.get("component")?.as_array()).flatten() {
        let (name, size) = (component.get("state"), component.get("bytes"));
        if let (Some(name), Some(size)) =
            (name.and_then(toml::Value::as_str), size.and_then(toml::Value::as_integer))
            && files.iter().all(|(other, _)| other != name)
        {
            files.push((name.to_owned(), vec![7; usize::try_from(size).unwrap_or_default().min(LARGEST)]));
        }
    }
    let files: Vec<_> = files.iter().map(|(name, content)| (name.as_str(), &content[..])).collect();
    archive_of(&files)
}

/// Checks what a run goes on from.
fn sound(saved: &SavedRun) {
    let SavedRun { start, step, until, index, time, every, .. } = *saved;
    assert!(start.is_finite() && until.is_finite() && step > 0.0 && step.is_finite() && every > 0);
    assert!(time.is_finite() && time >= start, "{saved:?}");
    assert!(saved.crowd.iter().all(|crowd| crowd.extremes.are_possible() && crowd.since.is_possible()));
    if let Ok(clock) = Clock::new(start, step, until)
        && index < clock.steps
        && until > time
    {
        assert!(clock.end(index) > time, "the next step goes forward: {saved:?}");
    }
}
