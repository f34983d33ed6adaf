//! What is written is what is read; what is damaged is refused.

use lemons_columns::{Cell, Column, Kind, Reader, TableError, Writer};
use std::fs::File;
use std::io::Write as _;

fn column(name: &str, kind: Kind, optional: bool, repeats: bool) -> Column {
    let about = if kind == Kind::Real { vec![("unit", "m".to_owned())] } else { Vec::new() };
    Column { name: name.into(), kind, optional, repeats, about }
}

fn columns() -> Vec<Column> {
    vec![
        column("t", Kind::Real, false, true),
        column("x", Kind::Real, true, false),
        column("n", Kind::Integer, true, true),
        column("long", Kind::Long, false, true),
        column("good", Kind::Boolean, true, true),
        column("id", Kind::Text, true, true),
    ]
}

/// The k-th row; `text` is what its text may be.
fn row(k: usize, text: &str) -> [Cell<'_>; 6] {
    let missing = |n: usize, cell| if k % n == 1 { Cell::Missing } else { cell };
    // Numbers of all sizes; not a number among them.
    let x = if k % 11 == 2 { f64::NAN } else { f64::from_bits(0x3ff0_0000_0000_0000 | (k as u64) << 30) };
    [
        Cell::Real((k / 5) as f64 * 0.05),
        missing(7, Cell::Real(x)),
        missing(5, Cell::Integer(k as i32 - 50)),
        Cell::Long(i64::MIN + k as i64),
        missing(3, Cell::Boolean(k.is_multiple_of(2))),
        missing(4, Cell::Text(text)),
    ]
}

fn written(rows: usize) -> Vec<u8> {
    let about = [("trial", "push \"é\"".to_owned())];
    let mut writer = Writer::create(Vec::new(), &columns(), &about).unwrap();
    for k in 0..rows {
        writer.row(row(k, &format!("agent {}", k % 13))).unwrap();
    }
    writer.finish().unwrap()
}

fn opened(bytes: &[u8]) -> Result<Reader, TableError> {
    let mut file = tempfile::tempfile().unwrap();
    file.write_all(bytes).unwrap();
    Reader::open(file)
}

/// NaN is a value like any other.
fn same(one: Cell<'_>, other: Cell<'_>) -> bool {
    match (one, other) {
        (Cell::Real(one), Cell::Real(other)) => one.to_bits() == other.to_bits(),
        (one, other) => one == other,
    }
}

#[test]
fn rows_come_back_bit_for_bit() {
    // None, few, a batch and one more, and more than a group of rows, which holds some two million cells.
    for rows in [0, 1, 9, (1 << 13) + 1, 400_000] {
        let bytes = written(rows);
        let reader = opened(&bytes).unwrap();
        assert_eq!((reader.about("trial"), reader.about("other")), (Some("push \"é\""), None));
        for (found, column) in reader.columns().iter().zip(columns()) {
            assert_eq!(
                (&found.name, found.kind, found.optional),
                (&column.name, Some(column.kind), column.optional)
            );
            assert_eq!(found.about("unit"), (column.kind == Kind::Real).then_some("m"));
            assert_eq!(found.about("description"), None);
        }
        let mut k = 0;
        for batch in reader.batches(&[0, 1, 2, 3, 4, 5]) {
            let batch = batch.unwrap();
            for r in 0..batch.rows() {
                let text = format!("agent {}", k % 13);
                assert!(batch.row(r).zip(row(k, &text)).all(|(a, b)| same(a, b)), "row {k}");
                k += 1;
            }
        }
        assert_eq!(k, rows);
        assert!(written(rows) == bytes, "the same rows give the same bytes");
    }
}

#[test]
fn columns_are_read_in_the_order_asked_for() {
    let bytes = written(20);
    let reader = opened(&bytes).unwrap();
    let batch = reader.batches(&[5, 0]).next().unwrap().unwrap();
    assert_eq!(batch.row(12).collect::<Vec<_>>(), [Cell::Text("agent 12"), Cell::Real(0.1)]);
}

#[test]
fn rows_of_another_table_are_refused() {
    let begin = || Writer::create(Vec::new(), &columns(), &[]).unwrap();
    let mut wrong = row(0, "a");
    wrong[3] = Cell::Missing;
    assert_eq!(
        begin().row(wrong).unwrap_err().to_string(),
        "column long: the value Missing has the wrong type"
    );
    wrong[3] = Cell::Real(1.0);
    assert_eq!(
        begin().row(wrong).unwrap_err().to_string(),
        "column long: the value Real(1.0) has the wrong type"
    );
    let short = begin().row(row(0, "a").into_iter().take(2)).unwrap_err();
    assert_eq!(short.to_string(), "a row has no value for column n");
}

/// Read to the end: how many rows, or what is wrong.
fn rows(bytes: &[u8]) -> Result<usize, String> {
    let reader = opened(bytes).map_err(|error| error.to_string())?;
    let kinds: Vec<usize> =
        (0..reader.columns().len()).filter(|&k| reader.columns()[k].kind.is_some()).collect();
    reader.batches(&kinds).map(|batch| Ok(batch.map_err(|error| error.to_string())?.rows())).sum()
}

#[test]
fn damaged_files_are_refused_or_read_whole() {
    let good = written(60);
    assert_eq!(rows(&good), Ok(60));
    for length in [0, 4, 12, good.len() / 2, good.len() - 1] {
        let message = rows(&good[..length]).unwrap_err();
        assert!(message.starts_with("is not valid Parquet: "), "{message}");
    }
    let mut refused = 0;
    for place in 0..good.len() {
        for mask in [0x01, 0x80] {
            let mut bytes = good.clone();
            bytes[place] ^= mask;
            match rows(&bytes) {
                Ok(rows) => assert_eq!(rows, 60, "byte {place}"),
                Err(message) => {
                    assert!(message.contains("is not valid Parquet: "), "{message}");
                    refused += 1;
                }
            }
        }
    }
    assert!(refused > good.len() / 4, "{refused} of {}", good.len());
}

/// They were gone through, each by a call of the system: 1.4 kB could take over ten minutes.
#[test]
fn lists_of_more_elements_than_the_file_has_bytes_are_refused() {
    let said = |bytes: &[u8]| match rows(bytes) {
        Ok(rows) => panic!("{rows} rows"),
        Err(said) => said,
    };
    let good = written(10);
    // A field that nobody knows: a list of 10^6 doubles.
    let mut bytes = good.clone();
    bytes.splice(4..10, [0xf9, 0xf7, 0xc0, 0x84, 0x3d, 0]);
    assert!(
        said(&bytes).ends_with("the header of a page claims more data than the file has"),
        "{}",
        said(&bytes)
    );
    for (element, expected) in [
        (0xf7, "the footer claims more data than the file has"),
        (0xf2, "the footer has a list of booleans"),
        (0xf1, "the footer has a list of booleans"),
        (0xf9, "the footer claims more data than the file has"),
        (0xff, "the footer has a value of an unknown type"),
    ] {
        let mut bytes = good.clone();
        let end = bytes.len() - 8;
        let size = u32::from_le_bytes(bytes[end..end + 4].try_into().unwrap()) + 5;
        bytes[end..end + 4].copy_from_slice(&size.to_le_bytes());
        // Before the end of the last structure.
        bytes.splice(end - 1..end - 1, [0xf9, element, 0xc0, 0x84, 0x3d]);
        assert!(said(&bytes).ends_with(expected), "{}", said(&bytes));
    }
    let mut bytes = good;
    bytes.splice(4..10, [0x99; 6]);
    said(&bytes);
}

#[test]
fn names_are_given_once() {
    let columns = [column("x", Kind::Real, false, false), column("x", Kind::Long, false, false)];
    let refused = Writer::create(Vec::new(), &columns, &[]).err().unwrap();
    assert_eq!(refused.to_string(), "there are two columns \"x\"");
}

#[cfg(unix)]
#[test]
fn what_is_no_file_is_no_table() {
    assert!(matches!(Reader::open(File::open(".").unwrap()), Err(TableError::Unsound { .. })));
}
