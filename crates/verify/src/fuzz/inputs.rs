//! Any bytes as what runs, sweeps and crowds read.

use crate::fuzz::files::{archive_of, directory};
use crate::fuzz::models::small_trial;
use crate::fuzz::show_panics;
use lemons_core::files::Staged;
use lemons_core::plane::{Motion, Pose, Twist};
use lemons_core::trial::{DriveChoice, DriveTable};
use lemons_master::{Error, Saved};
use lemons_people::{LightAgent, LightDisk, LightRectangle, LightShapes};
use lemons_people::{light_xml as write_light_xml, read_light_xml};
use lemons_results::columns::Groups;
use lemons_results::{
    Content, Format, FrameWriter, Observed, Record, RecordError, Run, TableWriter, Totals, chaos,
    chaos_files, pedpy,
};
use lemons_sim::Clock;
use lemons_sweep::{Finished, Measured, Points, Spec, Table, Values};
use std::collections::HashSet;
use std::fs::File;
use std::path::Path;

/// A drive file: refused in words, or pushes between those of its rows, nothing outside of them, which read back from
/// columns in another order. From a file the same is said, with its name.
pub fn drive_csv(data: &[u8]) {
    show_panics();
    let directory = directory();
    let path = directory.path().join("drive.csv");
    std::fs::write(&path, data).expect("a file");
    let mut trial = small_trial();
    let drive = match DriveTable::from_csv(data) {
        Ok(drive) => drive,
        Err(error) => {
            let of_file =
                DriveTable::of(Some(&trial), &DriveChoice::File(path.clone())).expect_err("as its content");
            return assert_eq!(of_file, error.of_file(&path));
        }
    };
    let mut agents: Vec<&str> = drive.agents().collect();
    agents.sort_unstable();
    let records = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(data).into_byte_records().count();
    let rows = || agents.iter().flat_map(|agent| drive.rows(agent).expect("an agent of the drive has rows"));
    assert_eq!(rows().count(), records, "each row is somebody's");
    assert_eq!(drive.end(), rows().map(|row| row.0).reduce(f64::max));
    agents.iter().for_each(|agent| drives(&drive, agent));

    let mut text = csv::Writer::from_writer(Vec::new());
    text.write_record(["\u{feff}Mp", "agent", "Fp.y", "t", "more", "Fp.x"]).expect("written into memory");
    for agent in &agents {
        for (time, [x, y, m]) in drive.rows(agent).unwrap_or_default() {
            let [time, x, y, m] = [time, x, y, m].map(|value| format!("{value:?}"));
            text.write_record([m.as_str(), agent, &y, &time, "", &x]).expect("written into memory");
        }
    }
    let text = text.into_inner().expect("written into memory");
    let again = DriveTable::from_csv(&text[..]).expect("what was read is written and read back");
    assert_eq!(again.fingerprint(), drive.fingerprint(), "{}", String::from_utf8_lossy(&text));

    for (agent, id) in trial.agents.iter_mut().zip(&agents) {
        (*id).clone_into(&mut agent.id);
    }
    match DriveTable::of(Some(&trial), &DriveChoice::File(path.clone())) {
        Ok(of_file) => {
            assert!(agents.len() <= trial.agents.len(), "pushes nobody: {agents:?}");
            assert_eq!(of_file.fingerprint(), drive.fingerprint());
        }
        Err(error) => {
            let error = Error::from(error).whole();
            assert!(agents.len() > trial.agents.len(), "{error}");
            assert!(error.starts_with(&format!("{}:", path.display())), "{error}");
            assert!(error.contains(": there is no agent "), "{error}");
        }
    }
}

/// What an agent of a drive is pushed by, at its rows and between them.
fn drives(drive: &DriveTable, agent: &str) {
    let rows = drive.rows(agent).expect("an agent of the drive has rows");
    let at = |time: f64| drive.at(agent, time).expect("a push");
    let ((first, _), (last, _)) = (rows[0], rows[rows.len() - 1]);
    for outside in [first.next_down(), last.next_up(), f64::NEG_INFINITY, f64::INFINITY] {
        assert_eq!(at(outside), [0.0; 3], "at {outside:?} of {rows:?}");
    }
    for (time, push) in rows {
        assert_eq!(at(*time), *push, "at a row is what the row says");
    }
    for pair in rows.windows(2) {
        let [(t0, a), (t1, b)] = [pair[0], pair[1]];
        assert!(t0 < t1, "the rows of {agent:?} go forward");
        let shares = [0.25, 0.5, 0.75].map(|share| (1.0 - share) * t0 + share * t1);
        for time in shares.into_iter().chain([t0.next_up(), t1.next_down()]) {
            if !(t0..=t1).contains(&time) {
                // Lost in rounding.
                continue;
            }
            for ((push, a), b) in at(time).into_iter().zip(a).zip(b) {
                let slack = 1e-12 * a.abs().max(b.abs());
                let between = (a.min(b) - slack..=a.max(b) + slack).contains(&push);
                assert!(between && push.is_finite(), "{push:?} at {time:?} of {pair:?}");
            }
        }
    }
}

/// A table as text. Parquet is read by a crate of its own.
pub fn table_csv(data: &[u8]) {
    if !data.starts_with(b"PAR1") {
        table(data);
    }
}

/// What `lemons plot` and `export` read: refused in words, or a run that reads back from a table in either format, and
/// that PedPy and ChAOS can be given.
fn table(data: &[u8]) {
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
    for row in content(&run) {
        assert!(numbers(row).iter().all(|value| value.is_finite()), "{row:?}");
        let forces = row.2.map(|seen| (seen.normal_force, of_step(seen)));
        let (now, step) = forces.unwrap_or_default();
        assert!(
            [&[now], &step[..]].concat().iter().all(|value| (0.0..f64::INFINITY).contains(value)),
            "{row:?}"
        );
    }
    let ways: [fn(&Run, &Path) -> bool; 3] = [as_csv, as_csv_with_units, as_parquet];
    for write in ways {
        let again = directory.path().join("again");
        if !write(&run, &again) {
            continue;
        }
        let back = Run::read_table(&again).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(back.ids, run.ids);
        assert!(content(&back).eq(content(&run)), "{back:?}\n{run:?}");
    }
    let record = Record::table(&path).unwrap_or_else(|error| panic!("{error}"));
    exported(&record, &run, directory.path());
}

fn names_file(error: &RecordError, path: &Path) -> bool {
    error.to_string().starts_with(&format!("{}: ", path.display()))
}

/// What other tools are given has the positions of the run, at a frame rate that is a number.
fn exported(record: &Record, run: &Run, directory: &Path) {
    assert_eq!(record.ids(), run.ids);
    assert!(record.times().eq(run.frames.iter().map(|frame| frame.time)), "{run:?}");
    let positions: Vec<[f64; 2]> = run.frames.iter().flat_map(|frame| &frame.agents).map(place).collect();
    let names = record.names();
    let path = directory.join("pedpy.txt");
    match pedpy(record, &path) {
        Ok(()) => {
            let text = std::fs::read_to_string(&path).expect("a text");
            let mut lines = text.lines();
            let rate = lines.next().and_then(|line| line.strip_prefix("# framerate: ")?.strip_suffix(" fps"));
            let rate = rate.and_then(|rate| rate.parse().ok());
            assert!(rate.is_some_and(|rate: f64| rate > 0.0 && rate.is_finite()), "{text}");
            assert_eq!(lines.next(), Some("# id frame x/m y/m z/m"));
            let rows: Vec<Vec<f64>> = lines.map(|line| floats(line, ' ')).collect();
            let places = rows.iter().map(|row| [row[2], row[3]]);
            assert!(places.eq(positions.iter().copied()), "{text}\n{run:?}");
            for (k, row) in rows.iter().enumerate() {
                let (frame, agent) = (k / run.ids.len(), k % run.ids.len());
                assert_eq!(&row[..2], [names.numbers[agent] as f64, frame as f64]);
            }
        }
        Err(error) => {
            assert!(names_file(&error, &run.source), "{error}");
            assert!(!path.exists(), "half of a file");
        }
    }
    if run.ids.len() > 4 {
        return;
    }
    let directory = directory.join("chaos");
    chaos(record, &directory).unwrap_or_else(|error| panic!("{error}"));
    for (agent, file) in chaos_files(record).iter().enumerate() {
        let text = std::fs::read_to_string(directory.join(file)).expect("a text");
        let rows = text.lines().map(|line| floats(line, ','));
        let expected = run.frames.iter().zip(positions.chunks(run.ids.len()));
        let expected =
            expected.map(|(frame, places)| vec![frame.time, places[agent][0], places[agent][1], 0.0]);
        assert!(rows.eq(expected), "{text}\n{run:?}");
    }
}

fn place(agent: &Motion) -> [f64; 2] {
    [agent.pose.position.x, agent.pose.position.y]
}

fn floats(line: &str, between: char) -> Vec<f64> {
    let number = |text: &str| text.parse().unwrap_or_else(|_| panic!("{text:?} of {line:?} is no number"));
    line.split(between).map(number).collect()
}

type Row<'a> = (u64, &'a Motion, Option<&'a Observed>, Option<Totals>);

fn content(run: &Run) -> impl Iterator<Item = Row<'_>> {
    run.frames.iter().flat_map(|frame| {
        let seen = |k: usize| frame.observed.as_ref().map(|observed| &observed[k]);
        // -0.0 and 0.0 are one time.
        let time = (frame.time + 0.0).to_bits();
        frame.agents.iter().enumerate().map(move |(k, agent)| (time, agent, seen(k), frame.totals))
    })
}

/// Time and motion.
fn numbers((time, agent, ..): Row<'_>) -> [f64; 7] {
    let Motion { pose: Pose { position, orientation }, twist: Twist { velocity, angular_velocity } } = agent;
    [f64::from_bits(time), position.x, position.y, velocity.x, velocity.y, *orientation, *angular_velocity]
}

fn of_step(seen: &Observed) -> [f64; 3] {
    let step = seen.of_step.unwrap_or_default();
    [step.mean_normal_force, step.peak_normal_force, step.peak_overlap]
}

fn as_csv(run: &Run, path: &Path) -> bool {
    written(run, path, Format::Csv)
}

/// As earlier versions wrote the header.
fn as_csv_with_units(run: &Run, path: &Path) -> bool {
    if !written(run, path, Format::Csv) {
        return false;
    }
    let heads = groups_of(run).columns().into_iter().map(|column| match column.unit {
        Some(unit) => format!("{} [{unit}]", column.name),
        None => column.name,
    });
    let text = std::fs::read_to_string(path).expect("a text");
    let (_, rows) = text.split_once('\n').expect("a header");
    std::fs::write(path, format!("{}\n{rows}", heads.collect::<Vec<_>>().join(","))).expect("a file");
    true
}

fn as_parquet(run: &Run, path: &Path) -> bool {
    written(run, path, Format::Parquet)
}

fn groups_of(run: &Run) -> Groups {
    let first = &run.frames[0];
    let seen = first.observed.as_ref().map(|all| all[0]);
    Groups {
        contacts: seen.is_some(),
        of_step: seen.is_some_and(|seen| seen.of_step.is_some()),
        active: first.active.is_some(),
        totals: first.totals.is_some(),
    }
}

/// Whether it could be written: other programs may have counted more contacts than the tables hold.
fn written(run: &Run, path: &Path, format: Format) -> bool {
    let groups = groups_of(run);
    let content = Content { columns: groups.columns(), about: Vec::new() };
    let file = File::create(path).expect("a file");
    let table = TableWriter::create(file, path, format, &content).expect("a table");
    let mut writer = FrameWriter::new(table, run.ids.clone(), groups).expect("its columns");
    for frame in &run.frames {
        if let Err(error) = writer.frame(frame) {
            assert!(error.to_string().contains("too many"), "{error}");
            return false;
        }
    }
    writer.finish().expect("a file");
    true
}

/// A `sweep.toml`, or, after an odd byte, the table of points that one names: refused in words, or points that can
/// be simulated: finite, of different names, no more than the memory takes. They read back from a table of points,
/// and from the tables of their results.
pub fn sweep_toml(data: &[u8]) {
    const CELLS: usize = 100_000_000;
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
    let Spec { until, step, points, measures, .. } = match Spec::read(&path) {
        Ok(spec) => spec,
        Err(error) => {
            let error = error.whole();
            assert!(error.contains(path.to_str().expect("UTF-8")), "{error}");
            let of_table = error.contains(table.to_str().expect("UTF-8"))
                || error.ends_with("the table already has a column with this name");
            return assert!(way % 2 == 0 || of_table, "{error}");
        }
    };
    assert!(
        until.latest() > 0.0
            && until.latest().is_finite()
            && step.is_none_or(|step| step > 0.0 && step.is_finite())
    );
    assert!(points.count > 0 && points.count * points.columns.len() <= CELLS);
    let measures: Vec<String> = measures.into_iter().map(|(name, _)| name).collect();
    let mut names: Vec<&String> = points.columns.iter().map(|(name, _)| name).chain(&measures).collect();
    let all = names.len();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), all, "{names:?}");
    for (name, values) in &points.columns {
        assert_eq!(values.len(), points.count, "{name}");
        for point in (0..points.count).step_by((points.count / 100).max(1)) {
            let text = values.text(point);
            match values {
                Values::Integers(values) => assert_eq!(text.parse(), Ok(values[point])),
                Values::Reals(values) => {
                    assert!(values[point].is_finite(), "{name}: {text}");
                    assert_eq!(text.parse::<f64>().map(f64::to_bits), Ok(values[point].to_bits()));
                }
                Values::Texts(values) => assert_eq!(text, values[point]),
            }
        }
    }
    if points.count <= 1000 {
        assert_eq!(points.sha256().len(), 64);
        // In a table a text that looks like a number is one, and blanks around it are not seen.
        let texts = points.columns.iter().any(|(_, values)| matches!(values, Values::Texts(_)));
        let plain = |name: &str| name.trim() == name && !name.starts_with('\u{feff}');
        if (way % 2 == 1 || !texts) && points.columns.iter().all(|(name, _)| plain(name)) {
            as_points(&points, &table);
            std::fs::write(&path, OF_A_TABLE).expect("a file");
            match Spec::read(&path) {
                Ok(back) => assert_eq!(back.points, points),
                Err(error) => {
                    let far = points.columns.iter().any(|(name, _)| name == FAR);
                    assert!(far, "{error:?}");
                }
            }
        }
    }
    if points.count <= 20 {
        kept(&points, &measures, &directory.path().join("results"));
    }
}

/// Of a sweep, in its directory.
const TABLE: &str = "points.csv";
const OF_A_TABLE: &str = "fmu = 'x.fmu'\nuntil = 1\ntable = 'points.csv'\n[measures]\n\
                          far = { of = 'x', take = 'max' }\n";
/// Its measure.
const FAR: &str = "far";

fn as_points(points: &Points, path: &Path) {
    let file = File::create(path).expect("a file");
    let mut out = csv::WriterBuilder::new().comment(Some(b'#')).from_writer(file);
    out.write_record(points.columns.iter().map(|(name, _)| name)).expect("a row");
    for point in 0..points.count {
        out.write_record(points.columns.iter().map(|(_, values)| values.text(point))).expect("a row");
    }
    out.flush().expect("a file");
}

/// What such a sweep measures stays in its table, and when it is opened again.
fn kept(points: &Points, measures: &[String], path: &Path) {
    let outcome = |point: usize| match point % 3 {
        2 => Err("it \"fell\", badly".to_owned()),
        way => {
            let number = Measured::Number(point as f64 / 3.0);
            Ok((0..measures.len()).map(|k| (k % 2 == way).then(|| number.clone())).collect())
        }
    };
    let rows: Vec<Finished> =
        (0..points.count).map(|point| Finished { point, outcome: outcome(point) }).collect();
    let open = || {
        let table = Table::open(path, &Default::default(), points, Some(measures));
        table.unwrap_or_else(|error| panic!("{error:?}"))
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
    let (saved, states) = match Saved::read(&path) {
        Ok(read) => read,
        Err(error) => {
            let error = error.whole();
            return assert!(error.starts_with(&format!("saved run {}: ", path.display())), "{error}");
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
            .write(&states, Staged::beside(&again).expect("a file"))
            .unwrap_or_else(|error| panic!("{error:?}"));
        std::fs::read(&again).expect("a file")
    };
    let first = write();
    let (back, same) = Saved::read(&again).unwrap_or_else(|error| panic!("{error:?}"));
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

/// What a run goes on from.
fn sound(saved: &Saved) {
    let Saved { start, step, until, index, time, every, .. } = *saved;
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

/// A light XML file: refused in words that name the line, or agents that can be, are written and read back, to the same
/// text.
pub fn light_xml(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    show_panics();
    let agents = match read_light_xml(text) {
        Ok(agents) => agents,
        Err(error) => {
            return assert!(error.to_string().starts_with("line "), "{error}");
        }
    };
    let ids: HashSet<u64> = agents.iter().map(|agent| agent.id).collect();
    assert_eq!(ids.len(), agents.len(), "{agents:?}");
    agents.iter().for_each(possible);
    let written = write_light_xml(&agents).unwrap_or_else(|error| panic!("{error} of {agents:?}"));
    let back = read_light_xml(&written);
    assert_eq!(back.as_ref(), Ok(&agents), "{written}");
    assert_eq!(write_light_xml(&agents), Ok(written));
}

fn possible(agent: &LightAgent) {
    let positive = |value: f64| value > 0.0 && value.is_finite();
    let dampings = [agent.floor_damping, agent.angular_damping];
    assert!(dampings.iter().all(|value| (0.0..f64::INFINITY).contains(value)), "{agent:?}");
    assert!(positive(agent.moment_of_inertia), "{agent:?}");
    match &agent.shapes {
        LightShapes::Pedestrian(disks) => {
            assert!(!disks.is_empty());
            for LightDisk { disk, material } in disks {
                assert!(positive(disk.radius), "{agent:?}");
                assert!(disk.centre.x.is_finite() && disk.centre.y.is_finite(), "{agent:?}");
                assert!(!material.is_empty() && material.trim() == material);
            }
        }
        LightShapes::Bicycle { bike, rider } => {
            for LightRectangle { min, max, .. } in [bike, rider] {
                assert!([min.x, min.y, max.x, max.y].into_iter().all(f64::is_finite), "{agent:?}");
                assert!(min.x < max.x && min.y < max.y, "{agent:?}");
            }
        }
    }
}
