//! People who leave: from an empty room to nobody there.

use crate::common::{Row, decision_library, done, number, out, read_csv};
use tempfile::TempDir;

#[test]
fn everybody_leaves_and_the_tables_say_when() {
    decision_library();
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    // A room with a door of 1 m, and ten people who leave.
    done(at, &["crowd", "-n", "10", "--box", "4x3", "--door", "4,1.5,1", "--leave", "-o", "room"]);
    let run = ["run", "room", "--until", "left", "-o", "run.csv", "--outputs", "run_outputs.csv"];
    let said = out(&done(at, &run));
    assert!(said.contains("simulated time"), "{said}");
    let table = read_csv(&at.join("run.csv"));
    let last = &table[table.len() - 1];
    let there = |row: &&Row| row["active"] == "1";
    assert!(there(&&table[0]) && !there(&last));
    for id in 0..10 {
        let own: Vec<&Row> = table.iter().filter(|row| row["id"] == id.to_string()).collect();
        let left = own.iter().take_while(|row| there(row)).count();
        assert!(!own[left..].iter().any(there), "nobody comes back");
        // Beyond the door, and from then on they stand and touch nothing.
        assert!(number(own[left - 1], "x") > 4.5, "agent {id}: {:?}", own[left - 1]);
        for row in &own[(left + 1).min(own.len())..] {
            assert_eq!(row["x"], own[own.len() - 1]["x"]);
            assert_eq!((number(row, "vx"), number(row, "mean_normal_force")), (0.0, 0.0));
        }
    }
    // The last row is of the first time at which nobody is there.
    assert_ne!(table.iter().rfind(there).unwrap()["t"], last["t"]);
    assert_eq!(read_csv(&at.join("run_outputs.csv")).last().unwrap()["decision.Arrived"], "10");
}
