//! Any bytes as what runs, sweeps and crowds read.

use crate::files::{archive_of, directory};
use crate::show_panics;
use crowd_mechanics::files::Staged;
use crowd_mechanics::trial::AgentDynamics;
use lemons_columns::{Cell, Column, Kind, Writer};
use lemons_crowd::{light_xml as write_light_xml, read_light_xml};
use lemons_export::{Observed, Run};
use lemons_master::{Drive, Saved};
use lemons_sweep::{Spec, Values};
use std::fs::File;
use std::path::Path;

/// A drive file: refused in words, or pushes that are finite at all times and read back from their own rows.
pub fn drive_csv(data: &[u8]) {
    show_panics();
    let drive = match Drive::from_csv(data) {
        Ok(drive) => drive,
        Err(error) => return assert!(!format!("{error:#}").is_empty()),
    };
    let mut text = csv::Writer::from_writer(Vec::new());
    text.write_record(["t", "agent", "Fp.x", "Fp.y", "Mp"]).expect("written into memory");
    for agent in drive.agents() {
        let rows = drive.rows(agent).expect("an agent of the drive has rows");
        assert!(rows.windows(2).all(|pair| pair[0].0 < pair[1].0), "the rows of {agent:?} go forward");
        for (k, (time, push)) in rows.iter().enumerate() {
            assert_eq!(drive.at(agent, *time), Some(*push), "at a row is what the row says");
            let between = rows.get(k + 1).map_or(*time, |next| 0.5 * time + 0.5 * next.0);
            for time in [between, time.next_up(), time.next_down()] {
                let push = drive.at(agent, time).expect("a push");
                assert!(push.iter().all(|value| value.is_finite()), "{push:?} at {time:?} of {rows:?}");
            }
            let [x, y, m] = push;
            let row = [time, x, y, m].map(|value| format!("{value:?}"));
            text.write_record([&row[0], agent, &row[1], &row[2], &row[3]]).expect("written into memory");
        }
    }
    let text = text.into_inner().expect("written into memory");
    let again = Drive::from_csv(&text[..]).expect("what was read is written and read back");
    assert_eq!(again.fingerprint(), drive.fingerprint(), "{}", String::from_utf8_lossy(&text));
}

/// A table as text.
pub fn table_csv(data: &[u8]) {
    if !data.starts_with(b"PAR1") {
        table(data);
    }
}

/// A table in Parquet, whether it begins like one or not.
pub fn table_parquet(data: &[u8]) {
    static ONCE: std::sync::Once = std::sync::Once::new();
    // The reader catches the panics of the crate that it uses; the fuzzer's hook would abort before. A panic that
    // nobody catches still ends the fuzzer.
    ONCE.call_once(|| {
        std::panic::set_hook(Box::new(|panic| {
            if panic.location().is_none_or(|place| !place.file().contains("/parquet-")) {
                eprintln!("{panic}");
            }
        }));
    });
    if data.starts_with(b"PAR1") {
        table(data);
    } else {
        table(&[b"PAR1", data].concat());
    }
}

/// What `lemons plot` and `export` read: refused in words, or a run that reads back from a table in either format.
fn table(data: &[u8]) {
    show_panics();
    let directory = directory();
    let path = directory.path().join("table");
    std::fs::write(&path, data).expect("a file");
    let run = match Run::read_table(&path) {
        Ok(run) => run,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    assert!(!run.frames.is_empty() && !run.ids.is_empty());
    assert!(run.frames.windows(2).all(|pair| pair[0].time < pair[1].time), "times go forward");
    assert!(run.frames.iter().all(|frame| frame.agents.len() == run.ids.len()), "everybody at every time");
    for row in content(&run) {
        assert!(numbers(row).iter().all(|value| value.is_finite()), "{row:?}");
        let forces = row.2.map(|seen| (seen.normal_force, of_step(seen).unwrap_or_default()));
        let (now, step) = forces.unwrap_or_default();
        assert!(
            [&[now], &step[..]].concat().iter().all(|value| (0.0..f64::INFINITY).contains(value)),
            "{row:?}"
        );
    }
    // Text has no blanks around an Id.
    let trimmed = run.ids.iter().all(|id| id.trim() == id);
    let ways: &[fn(&Run, &Path)] = if trimmed { &[as_csv, as_parquet] } else { &[as_parquet] };
    for write in ways {
        let again = directory.path().join("again");
        write(&run, &again);
        let back = Run::read_table(&again).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(back.ids, run.ids);
        assert!(content(&back).eq(content(&run)), "{back:?}\n{run:?}");
    }
}

type Row<'a> = (u64, &'a AgentDynamics, Option<&'a Observed>);

fn content(run: &Run) -> impl Iterator<Item = Row<'_>> {
    run.frames.iter().flat_map(|frame| {
        let seen = |k: usize| frame.observed.as_ref().map(|observed| &observed[k]);
        // -0.0 and 0.0 are one time.
        let time = (frame.time + 0.0).to_bits();
        frame.agents.iter().enumerate().map(move |(k, agent)| (time, agent, seen(k)))
    })
}

const NUMBERS: [&str; 7] = ["t", "x", "y", "vx", "vy", "theta", "omega"];
const COUNTS: [&str; 3] = ["agent_contacts", "wall_contacts", "contacting_agents"];
const FORCE: &str = "normal_force";
const OF_STEP: [&str; 3] = ["mean_normal_force", "peak_normal_force", "peak_overlap"];

/// The numbers of a row, in the order of [`NUMBERS`].
fn numbers((time, agent, _): Row<'_>) -> [f64; 7] {
    let AgentDynamics { position, velocity, theta, omega, .. } = agent;
    [f64::from_bits(time), position.x, position.y, velocity.x, velocity.y, *theta, *omega]
}

fn counts(seen: &Observed) -> [u32; 3] {
    [seen.agent_contacts, seen.wall_contacts, seen.contacting_agents]
}

fn of_step(seen: &Observed) -> Option<[f64; 3]> {
    seen.of_step.map(|step| [step.mean_normal_force, step.peak_normal_force, step.peak_overlap])
}

/// What it has besides the numbers: counts, and other numbers.
fn more(run: &Run) -> (&'static [&'static str], Vec<&'static str>) {
    let seen = run.frames[0].observed.as_ref().map(|all| all[0]);
    let Some(seen) = seen else { return (&[], Vec::new()) };
    let steps: &[&str] = if seen.of_step.is_some() { &OF_STEP } else { &[] };
    (&COUNTS, [&[FORCE], steps].concat())
}

fn as_csv(run: &Run, path: &Path) {
    let mut out = csv::Writer::from_path(path).expect("a file");
    let (counted, measured) = more(run);
    let header = [&["id"], &NUMBERS[..], counted, &measured].concat();
    out.write_record(header).expect("a row");
    for (k, row) in content(run).enumerate() {
        let mut cells = vec![run.ids[k % run.ids.len()].clone()];
        cells.extend(numbers(row).map(|value| format!("{value:?}")));
        if let Some(seen) = row.2 {
            cells.extend(counts(seen).map(|count| count.to_string()));
            cells.push(format!("{:?}", seen.normal_force));
            cells.extend(of_step(seen).into_iter().flatten().map(|value| format!("{value:?}")));
        }
        out.write_record(cells).expect("a row");
    }
    out.flush().expect("a file");
}

fn as_parquet(run: &Run, path: &Path) {
    let column = |name: &str, kind| Column {
        name: name.to_owned(),
        kind,
        optional: false,
        repeats: false,
        about: Vec::new(),
    };
    let mut columns = vec![column("id", Kind::Text)];
    columns.extend(NUMBERS.map(|name| column(name, Kind::Real)));
    let (counted, measured) = more(run);
    columns.extend(counted.iter().map(|name| column(name, Kind::Long)));
    columns.extend(measured.iter().map(|name| column(name, Kind::Real)));
    let mut out = Writer::create(File::create(path).expect("a file"), &columns, &[]).expect("a table");
    for (k, row) in content(run).enumerate() {
        let mut cells = vec![Cell::Text(&run.ids[k % run.ids.len()])];
        cells.extend(numbers(row).map(Cell::Real));
        if let Some(seen) = row.2 {
            cells.extend(counts(seen).map(|count| Cell::Long(count.into())));
            cells.push(Cell::Real(seen.normal_force));
            cells.extend(of_step(seen).into_iter().flatten().map(Cell::Real));
        }
        out.row(cells).expect("a row");
    }
    out.finish().expect("a file");
}

/// A `sweep.toml`, or, after an odd byte, the table of points that one names: refused in words, or points that can
/// be simulated: finite, of different names, no more than the memory takes.
pub fn sweep_toml(data: &[u8]) {
    const OF_A_TABLE: &str = "fmu = 'x.fmu'\nuntil = 1\ntable = 'points.csv'\n[measures]\n\
                              far = { of = 'x', take = 'max' }\n";
    const CELLS: usize = 100_000_000;
    let Some((&way, content)) = data.split_first() else { return };
    show_panics();
    let directory = directory();
    let text = if way % 2 == 0 {
        let Ok(text) = std::str::from_utf8(content) else { return };
        text
    } else {
        std::fs::write(directory.path().join("points.csv"), content).expect("a file");
        OF_A_TABLE
    };
    let Spec { until, step, points, measures, .. } = match Spec::from_toml(text, directory.path()) {
        Ok(spec) => spec,
        Err(error) => return assert!(!format!("{error:#}").is_empty()),
    };
    assert!(until > 0.0 && until.is_finite() && step.is_none_or(|step| step > 0.0 && step.is_finite()));
    assert!(points.count > 0 && points.count * points.columns.len() <= CELLS);
    let mut names: Vec<&String> =
        points.columns.iter().map(|(name, _)| name).chain(measures.iter().map(|(name, _)| name)).collect();
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
    }
}

/// A `.run` file: the bytes themselves, or, after an odd byte, an archive in which they are `run.toml`: refused in
/// words, or a saved run that is written and reads back.
pub fn run_file(data: &[u8]) {
    let Some((&way, content)) = data.split_first() else { return };
    show_panics();
    let directory = directory();
    let path = directory.path().join("x.run");
    let bytes = match way % 2 {
        0 => content.to_vec(),
        _ => archive_of(&[("run.toml", content), ("state-0", b"state"), ("state-1", b"")]),
    };
    std::fs::write(&path, bytes).expect("a file");
    let (saved, states) = match Saved::read(&path) {
        Ok(read) => read,
        Err(error) => return assert!(!format!("{error:#}").is_empty()),
    };
    assert_eq!(states.len(), saved.component.len());
    for (component, state) in saved.component.iter().zip(&states) {
        assert_eq!(component.bytes, state.len() as u64);
    }
    let again = directory.path().join("again.run");
    // Not the one that reads: two components may not share an entry when it is written.
    if saved.write(&states, Staged::beside(&again).expect("a file")).is_ok() {
        let (back, same) = Saved::read(&again).unwrap_or_else(|error| panic!("{error:#}"));
        assert!(back == saved && same == states, "{back:?}\n{saved:?}");
    }
}

/// A light XML file: refused in words, or agents that are written and read back.
pub fn light_xml(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    show_panics();
    match read_light_xml(text) {
        Ok(agents) => {
            let text = write_light_xml(&agents).unwrap_or_else(|error| panic!("{error} of {agents:?}"));
            assert_eq!(read_light_xml(&text).as_ref(), Ok(&agents), "{text}");
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}
