//! People who leave: from an empty room to nobody there.

use crate::common::{decision_library, done, out};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A room with a door of 1 m, and ten people who leave.
fn room() -> TempDir {
    decision_library();
    let directory = TempDir::new().unwrap();
    let crowd = ["crowd", "-n", "10", "--box", "4x3", "--door", "4,1.5,1", "--leave", "-o", "room"];
    done(directory.path(), &crowd);
    directory
}

/// The rows of a table: cells by name.
fn rows(at: &Path, name: &str) -> Vec<Vec<(String, String)>> {
    let text = fs::read_to_string(at.join(name)).unwrap();
    // A sweep says of what it is.
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    lines
        .map(|line| {
            names.iter().map(|name| (*name).to_owned()).zip(line.split(',').map(str::to_owned)).collect()
        })
        .collect()
}

fn cell<'a>(row: &'a [(String, String)], name: &str) -> &'a str {
    &row.iter().find(|(column, _)| column == name).unwrap().1
}

#[test]
fn everybody_leaves_and_the_tables_say_when() {
    let directory = room();
    let at = directory.path();
    let said =
        out(&done(at, &["run", "room", "--until", "left", "-o", "run.csv", "--outputs", "run_outputs.csv"]));
    assert!(said.contains("simulated time"), "{said}");
    let table = rows(at, "run.csv");
    let (first, last) = (table[0].clone(), table.last().unwrap().clone());
    assert_eq!((cell(&first, "active"), cell(&last, "active")), ("1", "0"));
    for id in 0..10 {
        let own: Vec<_> = table.iter().filter(|row| cell(row, "id") == id.to_string()).collect();
        let there = own.iter().take_while(|row| cell(row, "active") == "1").count();
        assert!(own[there..].iter().all(|row| cell(row, "active") == "0"), "nobody comes back");
        // Beyond the door, and from then on they stand and touch nothing.
        let x: f64 = cell(own[there - 1], "x").parse().unwrap();
        assert!(x > 4.5, "agent {id} left at x = {x}");
        for row in &own[(there + 1).min(own.len())..] {
            assert_eq!(cell(row, "x"), cell(own.last().unwrap(), "x"));
            assert_eq!((cell(row, "vx"), cell(row, "mean_normal_force")), ("0.0", "0.0"));
        }
    }
    // The last row is of the first time at which nobody is there.
    let end = cell(&last, "t");
    let left = table.iter().filter(|row| cell(row, "active") == "1").map(|row| cell(row, "t")).next_back();
    assert_ne!(left, Some(end));
    let outputs = rows(at, "run_outputs.csv");
    assert_eq!(cell(outputs.last().unwrap(), "decision.Arrived"), "10");
}
