//! People who leave.

use crate::common::{NamedCells, done, number, read_csv};
use std::collections::BTreeMap;
use tempfile::TempDir;

/// Times \[s\] at which people have left, sorted: by the exit on the left of a place, and on the right of it.
fn departures(table: &[NamedCells], middle: f64) -> [Vec<f64>; 2] {
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
    // The way to the wide door takes time, too.
    for (name, middle, most) in [("equal", 5.0, 0.05), ("near", 6.0, 0.1)] {
        let ([narrow, wide], noted) = run(name, middle);
        let share = wide.len() as f64 / (narrow.len() + wide.len()) as f64;
        assert!((share - 1.4 / 2.3).abs() < most, "{name}: {share}");
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
