//! Frames that are written to a table and read again are the same to the bit, in every format, in one go or resumed.

use lemons_plane::{Motion, Pose, Twist, vec2};
use lemons_record::columns::{Column, Groups};
use lemons_record::{
    Cell, Content, Extent, Format, Frame, FrameWriter, Kind, Observed, OfStep, Record, RecordError, Run,
    TableWriter, Totals,
};
use std::fs::File;
use std::path::Path;
use tempfile::TempDir;

const ALL: Groups = Groups { contacts: true, of_step: true, active: true, totals: true };

fn ids() -> Vec<String> {
    ["7", "a, \"quoted\"", "ß"].map(str::to_owned).to_vec()
}

/// Doubles with all kinds of digits, the least and the greatest among them.
fn number(seed: usize) -> f64 {
    match seed % 11 {
        0 => -0.0,
        1 => 5e-324,
        2 => f64::MAX,
        3 => 0.1 + 0.2,
        _ => ((seed * 7919) as f64 / 3.0 - 1e4).sin() * 10_f64.powi(seed as i32 % 9 - 4),
    }
}

fn frames(count: usize) -> Vec<Frame> {
    let of_step = |seed: usize| OfStep {
        mean_normal_force: number(seed).abs(),
        peak_normal_force: number(seed + 1).abs(),
        peak_overlap: number(seed + 2).abs(),
    };
    let observed = |seed: usize| Observed {
        agent_contacts: seed as u32,
        wall_contacts: i32::MAX as u32 - seed as u32,
        contacting_agents: 2,
        normal_force: number(seed).abs(),
        of_step: Some(of_step(seed)),
    };
    let motion = |seed: usize| Motion {
        pose: Pose { position: vec2(number(seed), number(seed + 1)), orientation: number(seed + 2) },
        twist: Twist {
            velocity: vec2(number(seed + 3), number(seed + 4)),
            angular_velocity: number(seed + 5),
        },
    };
    let frame = |k: usize| Frame {
        time: k as f64 * 0.1,
        agents: (0..3).map(|i| motion(10 * k + i)).collect(),
        observed: Some((0..3).map(|i| observed(7 * k + i)).collect()),
        active: Some((0..3).map(|i| k < 2 + i).collect()),
        totals: Some(Totals { agent_contacts: k as u32, wall_contacts: 3 }),
        ..Frame::default()
    };
    (0..count).map(frame).collect()
}

fn content(groups: Groups) -> Content {
    Content { columns: groups.columns(), about: vec![("component", "crowd".into())] }
}

/// Writes frames, after those that are there; returns how much is in the file then.
fn write(path: &Path, format: Format, groups: Groups, kept: Option<Extent>, frames: &[Frame]) -> Extent {
    let new = path.with_extension("new");
    let file = File::create(&new).unwrap();
    let table = match kept {
        Some(kept) => TableWriter::resume(file, path, format, &content(groups), kept),
        None => TableWriter::create(file, path, format, &content(groups)),
    };
    let mut writer = FrameWriter::new(table.unwrap(), ids(), groups).unwrap();
    frames.iter().for_each(|frame| writer.frame(frame).unwrap());
    let extent = writer.extent();
    writer.finish().unwrap();
    std::fs::rename(new, path).unwrap();
    extent
}

/// `{:?}` of a double reads back to the same double, so that equal texts are equal bits; NaN is not written.
fn text(frame: &Frame) -> String {
    let Frame { time, agents, observed, totals, .. } = frame;
    format!("{time:?} {agents:?} {observed:?} {totals:?}")
}

#[track_caller]
fn same(read: &Run, written: &[Frame]) {
    assert_eq!(read.ids, ids());
    assert_eq!(read.frames.len(), written.len());
    for (read, written) in read.frames.iter().zip(written) {
        assert_eq!(text(read), text(written));
    }
}

#[test]
fn frames_come_back_to_the_bit() {
    let directory = TempDir::new().unwrap();
    let frames = frames(40);
    for &format in Format::ALL {
        let path = directory.path().join("run").with_extension(format.extension());
        assert_eq!(Format::of(&path), Some(format));
        let extent = write(&path, format, ALL, None, &frames);
        assert_eq!((extent.rows, extent.last), (120, Some(39.0 * 0.1)));
        same(&Record::table(&path).unwrap().read(|_| true).unwrap(), &frames);
    }
}

#[test]
fn groups_that_are_not_written_are_not_read() {
    let directory = TempDir::new().unwrap();
    for &format in Format::ALL {
        for groups in [
            Groups::default(),
            Groups { contacts: true, ..Groups::default() },
            Groups { contacts: true, of_step: true, active: true, totals: false },
            Groups { contacts: true, of_step: false, active: false, totals: true },
            Groups { active: true, ..Groups::default() },
            Groups { totals: true, ..Groups::default() },
        ] {
            let path = directory.path().join("run");
            let mut frames = frames(3);
            write(&path, format, groups, None, &frames);
            for frame in &mut frames {
                frame.totals = frame.totals.filter(|_| groups.totals);
                frame.observed = frame.observed.take().filter(|_| groups.contacts);
                let seen = frame.observed.iter_mut().flatten();
                seen.for_each(|seen| seen.of_step = seen.of_step.filter(|_| groups.of_step));
            }
            same(&Run::read_table(&path).unwrap(), &frames);
        }
    }
}

#[test]
fn resumed_tables_have_the_same_bytes() {
    let directory = TempDir::new().unwrap();
    let frames = frames(50);
    for &format in Format::ALL {
        let (whole, parts) = (directory.path().join("whole"), directory.path().join("parts"));
        write(&whole, format, ALL, None, &frames);
        let mut kept = None;
        for part in [0..1, 1..20, 20..50] {
            kept = Some(write(&parts, format, ALL, kept, &frames[part]));
        }
        assert!(std::fs::read(&whole).unwrap() == std::fs::read(&parts).unwrap(), "{format:?}");
        same(&Run::read_table(&parts).unwrap(), &frames);
    }
}

#[test]
fn only_the_same_table_is_continued() {
    let directory = TempDir::new().unwrap();
    for &format in Format::ALL {
        let path = directory.path().join("run");
        let right = write(&path, format, ALL, None, &frames(4));
        let said = |groups: Groups, kept: Extent| {
            let file = File::create(directory.path().join("new")).unwrap();
            let error = TableWriter::resume(file, &path, format, &content(groups), kept).err().unwrap();
            assert!(matches!(error, RecordError::NotContinued { .. }), "{error}");
            assert!(error.to_string().starts_with(&path.display().to_string()), "{error}");
            error.to_string()
        };
        let message = said(ALL, Extent { rows: 13, ..right });
        assert!(message.contains("it has 12 rows, not the 13 that were written before"), "{message}");
        let message = said(ALL, Extent { last: Some(0.5), ..right });
        assert!(message.contains("its last row is of t = 0.3"), "{message}");
        let message = said(Groups { totals: false, ..ALL }, right);
        assert!(message.contains("column 17 is \"total_agent_contacts\", not missing"), "{message}");
        // As many rows until the same time, of another run.
        let mut other = frames(4);
        other[1].agents[2].pose.position.x += 1e-9;
        write(&path, format, ALL, None, &other);
        let message = said(ALL, right);
        assert!(message.contains("it is the table of another run, or it was changed since"), "{message}");
        std::fs::write(&path, "").unwrap();
        said(ALL, right);
    }
}

#[test]
fn frames_must_have_what_the_table_has() {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("run.csv");
    let table =
        || TableWriter::create(File::create(&path).unwrap(), &path, Format::Csv, &content(ALL)).unwrap();
    let other = FrameWriter::new(table(), ids(), Groups::default()).err().unwrap().to_string();
    assert!(other.contains("run.csv: column 9 is \"agent_contacts\", not missing"), "{other}");
    let mut writer = FrameWriter::new(table(), ids(), ALL).unwrap();
    type Change = fn(&mut Frame);
    let cases: [(Change, &str); 5] = [
        (|frame| frame.agents.truncate(2), "at t = 0.0 s has 2 agents, the table 3"),
        (|frame| frame.observed = None, "has not the contacts of all agents"),
        (|frame| frame.observed.as_mut().unwrap()[1].of_step = None, "has no means and peaks"),
        (|frame| frame.totals = None, "has no contacts of the whole crowd"),
        (|frame| frame.totals.as_mut().unwrap().wall_contacts = 1 << 31, "has 2147483648 contacts"),
    ];
    for (change, expected) in cases {
        let mut frame = frames(1).remove(0);
        change(&mut frame);
        let error = writer.frame(&frame).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    assert_eq!(writer.extent(), Extent::default());
}

/// What is not a crowd has other columns.
#[test]
fn tables_of_other_columns() {
    let directory = TempDir::new().unwrap();
    let column = |name: &str, kind: Kind| Column {
        name: name.into(),
        kind,
        unit: None,
        variable: name.into(),
        description: String::new(),
    };
    let columns = vec![
        Column::time(),
        column("on", Kind::Boolean),
        column("many", Kind::Long),
        column("what", Kind::Text),
    ];
    let content = Content { columns, about: Vec::new() };
    let path = directory.path().join("outputs.csv");
    let mut table = TableWriter::create(File::create(&path).unwrap(), &path, Format::Csv, &content).unwrap();
    table.row(0.5, [Cell::Boolean(true), Cell::Long(1 << 40), Cell::Text("a,b")]).unwrap();
    assert_eq!((table.extent().rows, table.extent().last), (1, Some(0.5)));
    table.finish().unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!(text, "t,on,many,what\n0.5,true,1099511627776,\"a,b\"\n");
    let mut table = TableWriter::create(File::create(&path).unwrap(), &path, Format::Csv, &content).unwrap();
    table.row(0.5, [Cell::Boolean(true), Cell::Long(1), Cell::Text("")]).unwrap();
    let error = table.row(0.5, [Cell::Boolean(true)]).unwrap_err().to_string();
    assert!(error.starts_with(&format!("{}: cannot be written", path.display())), "{error}");
}

/// An FMU of somebody else counted in millimetres: the table in CSV was read as metres.
#[test]
fn a_table_in_another_unit_is_not_read_as_ours() {
    let directory = TempDir::new().unwrap();
    for format in [Format::Csv, Format::Parquet] {
        let mut content = content(ALL);
        let x = content.columns.iter_mut().find(|column| column.name == "x").unwrap();
        x.unit = Some("mm".to_owned());
        let path = directory.path().join("table").with_extension(format.extension());
        let file = lemons_files::Staged::beside(&path).unwrap();
        let table = TableWriter::create(file, &path, format, &content).unwrap();
        let mut writer = FrameWriter::new(table, ids(), ALL).unwrap();
        frames(2).iter().for_each(|frame| writer.frame(frame).unwrap());
        writer.finish().unwrap().persist().unwrap();
        let message = Run::read_table(&path).unwrap_err().to_string();
        assert!(message.contains("column x: is in \"mm\", it must be in \"m\""), "{message}");
    }
}
