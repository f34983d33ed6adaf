//! Frames that are written to a table and read again are the same to the bit, in every format, in one table or several.

use lemons_results::columns::{ALL, Column, Group, Groups};
use lemons_results::{
    Cell, CellType, Frame, FrameWriter, KeptFrames, Record, Run, TableContent, TableFormat, TableWriter,
};
use std::fs::File;
use std::path::Path;
use tempfile::TempDir;

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

fn frames(count: usize, groups: Groups) -> Vec<Frame> {
    let row = |k: usize, i: usize| {
        std::array::from_fn(|place| match place {
            0..6 => number(10 * k + i + place),
            6..9 => f64::from(i32::MAX) - (7 * k + i + place) as f64,
            9..16 => number(7 * k + i + place).abs(),
            19 | 23 | 24 => f64::from(k + place < 21 + i),
            16..19 | 20 | 21 => number(5 * k + i + place),
            _ => k as f64,
        })
    };
    let rows = |k| [row(k, 0), row(k, 1), row(k, 2)];
    (0..count).map(|k| groups.frame_of_rows(k as f64 * 0.1, &rows(k))).collect()
}

fn begin(path: &Path, format: TableFormat, columns: Vec<Column>) -> TableWriter<File> {
    let content = TableContent { columns, about: vec![("component", "crowd".into())] };
    TableWriter::create(File::create(path).unwrap(), path, format, &content).unwrap()
}

fn write(path: &Path, format: TableFormat, groups: Groups, frames: &[Frame]) {
    let mut writer = FrameWriter::new(begin(path, format, groups.columns()), ids(), groups);
    frames.iter().for_each(|frame| writer.frame(frame).unwrap());
    writer.finish().unwrap();
}

/// `{:?}` of a double reads back to the same double, so that equal texts are equal bits; NaN is not written.
fn text(frame: &Frame) -> String {
    let Frame { time, agents, effects, active, legs, totals, .. } = frame;
    format!("{time:?} {agents:?} {effects:?} {active:?} {legs:?} {totals:?}")
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
    let none = Groups::default();
    for format in TableFormat::ALL {
        let path = directory.path().join("run").with_extension(format.extension());
        assert_eq!(TableFormat::of(&path), Some(format));
        // More rows than a group of Parquet has: some two million cells.
        let most = if format == TableFormat::Parquet { 42_000 } else { 100 };
        for (count, groups) in [
            (most, ALL),
            (1, ALL),
            (3, none),
            (3, none.with(Group::Contacts, true)),
            (3, ALL.with(Group::Totals, false)),
            (3, ALL.with(Group::Later, false)),
            (3, none.with(Group::Contacts, true).with(Group::Totals, true)),
            (3, none.with(Group::Active, true)),
            (3, none.with(Group::Legs, true)),
            (3, none.with(Group::Totals, true)),
        ] {
            let frames = frames(count, groups);
            write(&path, format, groups, &frames);
            same(&Run::read_table(&path).unwrap(), &frames);
        }
        let bytes = std::fs::read(&path).unwrap();
        let totals = none.with(Group::Totals, true);
        write(&path, format, totals, &frames(3, totals));
        assert!(std::fs::read(&path).unwrap() == bytes, "the same rows give the same bytes");
    }
}

/// A run that was resumed twice: the tables of its parts are read as one, whether the frame where a part begins is the
/// last one of the part before or not.
#[test]
fn tables_of_parts_are_one_run() {
    let directory = TempDir::new().unwrap();
    let frames = frames(50, ALL);
    let at = |name: &str| directory.path().join(name);
    let written = |name: &str, format, part: &[Frame]| {
        write(&at(name), format, ALL, part);
        at(name)
    };
    let first = written("1.csv", TableFormat::Csv, &frames[..20]);
    let second = written("2.parquet", TableFormat::Parquet, &frames[19..21]);
    let third = written("3.csv", TableFormat::Csv, &frames[21..]);
    let record = Record::tables(&[first.clone(), second.clone(), third.clone()]).unwrap();
    same(&record.read_wanted(KeptFrames::All).unwrap(), &frames);
    let message = Record::tables(&[first.clone(), third, second]).err().unwrap().to_string();
    let expected =
        format!("2.parquet: begins at t = {:?} s, before the end of the table before it", 19.0 * 0.1);
    assert!(message.contains(&expected), "{message}");
    let text = std::fs::read_to_string(at("3.csv")).unwrap();
    std::fs::write(at("4.csv"), text.replace(",7,", ",8,")).unwrap();
    let message = Record::tables(&[first, at("4.csv")]).err().unwrap().to_string();
    assert!(message.contains("4.csv: its agents are not those of the first table"), "{message}");
}

#[test]
fn cut_off_parquet_is_refused() {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("run.parquet");
    write(&path, TableFormat::Parquet, ALL, &frames(20, ALL));
    let bytes = std::fs::read(&path).unwrap();
    for length in [4, 12, bytes.len() / 2, bytes.len() - 1] {
        std::fs::write(&path, &bytes[..length]).unwrap();
        let message = Run::read_table(&path).unwrap_err().to_string();
        assert!(message.contains("run.parquet: cannot be read as Parquet: "), "{message}");
    }
}

/// Tables of other models than a crowd have other columns.
#[test]
fn tables_of_other_columns() {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("outputs.csv");
    let column = |(name, kind): (&str, CellType)| Column { name: name.into(), kind, ..Column::time() };
    let others = [("on", CellType::Boolean), ("many", CellType::Integer), ("what", CellType::Text)];
    let columns = || [Column::time()].into_iter().chain(others.map(column)).collect();
    let mut table = begin(&path, TableFormat::Csv, columns());
    table.row(0.5, [Cell::Boolean(true), Cell::Integer(-3), Cell::Text("a,b")]).unwrap();
    table.finish().unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!(text, "t,on,many,what\n0.5,true,-3,\"a,b\"\n");
    for (format, row) in [
        (TableFormat::Csv, vec![Cell::Boolean(true)]),
        (TableFormat::Parquet, vec![Cell::Boolean(true), Cell::Integer(1), Cell::Real(0.0)]),
    ] {
        let mut table = begin(&path, format, columns());
        table.row(0.5, [Cell::Boolean(true), Cell::Integer(1), Cell::Text("")]).unwrap();
        let error = table.row(0.5, row).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{}: cannot be written", path.display())), "{error}");
    }
}

/// An FMU of somebody else counted in millimetres: the table in CSV was read as metres.
#[test]
fn a_table_in_another_unit_is_not_read_as_ours() {
    let directory = TempDir::new().unwrap();
    for format in TableFormat::ALL {
        let mut columns = ALL.columns();
        columns.iter_mut().find(|column| column.name == "x").unwrap().unit = Some("mm".to_owned());
        let path = directory.path().join("table");
        let mut writer = FrameWriter::new(begin(&path, format, columns), ids(), ALL);
        frames(2, ALL).iter().for_each(|frame| writer.frame(frame).unwrap());
        writer.finish().unwrap();
        let message = Run::read_table(&path).unwrap_err().to_string();
        assert!(message.contains("column x: is in \"mm\", it must be in \"m\""), "{message}");
    }
}
