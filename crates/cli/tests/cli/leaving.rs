//! People who leave: from an empty room to nobody there.

use crate::common::{Row, decision_library, done, number, out, read_csv};
use std::collections::BTreeMap;
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

/// Times \[s\] at which people have left, sorted: by the exit on the left of a place, and on the right of it.
fn departures(table: &[Row], middle: f64) -> [Vec<f64>; 2] {
    let mut last: BTreeMap<&str, (f64, bool)> = BTreeMap::new();
    for row in table.iter().filter(|row| row["active"] == "1") {
        last.insert(&row["id"], (number(row, "t"), number(row, "x") > middle));
    }
    [false, true].map(|right| {
        let mut times: Vec<f64> = last.values().filter(|way| way.1 == right).map(|way| way.0).collect();
        times.sort_by(f64::total_cmp);
        times
    })
}

/// The outside: the assignment of people to doors with the least evacuation time, at which the times of all doors are equal,
/// and so the shares those of the widths.
#[test]
fn people_choose_exits_so_that_all_queues_end_at_about_the_same_time() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let doors = |x: &'static str| ["--door", "0,4,0.9", "--door", x, "--leave", "-s", "1"];
    let scene = |name: &str, n: &str, size: &str, region: &str, door: &'static str| {
        let crowd = ["crowd", "-n", n, "--box", size, "--region", region, "-o", name];
        done(at, &[&crowd[..], &doors(door)].concat());
    };
    // At equal distance, and with everybody nearer to the narrow door.
    scene("equal", "120", "10x8", "1,0.5,9,7.5", "10,4,1.4");
    scene("near", "70", "12x8", "0.5,0.5,6,7.5", "12,4,1.4");
    let run = |name: &str, middle: f64| {
        let run = ["run", name, "--until", "left", "--every", "10", "-o", "run.csv", "--force"];
        let output = done(at, &run);
        let noted = String::from_utf8_lossy(&output.stderr).contains("exits are used unevenly");
        (departures(&read_csv(&at.join("run.csv")), middle), noted)
    };
    let mut by_time = 0.0;
    for (name, middle) in [("equal", 5.0), ("near", 6.0)] {
        let ([narrow, wide], noted) = run(name, middle);
        let share = wide.len() as f64 / (narrow.len() + wide.len()) as f64;
        // A longer way takes time, so that fewer go to the further door.
        assert!(name == "near" || (share - 1.4 / 2.3).abs() < 0.05, "{name}: {share}");
        let [a, b] = [narrow, wide].map(|times| times[times.len() - 1]);
        assert!((a - b).abs() < 0.15 * a.max(b) && !noted, "{name}: {a} s and {b} s");
        by_time = a.max(b);
    }
    let settings = at.join("near/decision.toml");
    let text = std::fs::read_to_string(&settings).unwrap();
    assert!(text.contains("exit_choice = \"time\""), "{text}");
    std::fs::write(&settings, text.replace("\"time\"", "\"distance\"")).unwrap();
    let ([narrow, _], noted) = run("near", 6.0);
    let by_distance = narrow[narrow.len() - 1];
    assert!(narrow.len() > 65 && by_distance > 1.8 * by_time && noted, "{by_distance} s, not {by_time} s");
}
