//! `lemons crowd` and `lemons person` as their users meet them.

use crate::common::{assert_code, err, lemons, out};
use lemons_people::{LightShapes, read_light_xml};
use std::fs;
use std::process::Command;
use tempfile::TempDir;

fn narrow(text: &str) {
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
}

#[test]
fn mixed_crowds_go_into_the_light_file_and_pictures() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let mixed = ["crowd", "-n", "9", "--pedestrians", "0.5", "--box", "6x6", "--direction", "90"];
    let made = lemons(at, &[&mixed[..], &["--light-xml", "light.xml", "--sections", "1.3,torso"]].concat());
    assert_code(&made, 0);
    narrow(&out(&made));
    assert!(out(&made).contains("bicycle: ") && out(&made).contains("handlebar"), "{}", out(&made));
    assert!(!out(&made).contains("mechanical step"), "{}", out(&made));
    let table = out(&made);
    let (_, table) = table.split_once("of the ground\n").unwrap();
    let rows: Vec<Vec<&str>> = table.lines().take(4).map(|row| row.split_whitespace().collect()).collect();
    let altitudes: Vec<f64> = rows.iter().map(|row| row[0].parse().unwrap()).collect();
    assert!(
        altitudes[0] == 1.3 && altitudes[1] < altitudes[2] && altitudes[2] < altitudes[3],
        "{altitudes:?}"
    );
    assert!(table.contains("bicycles have no three-dimensional bodies"), "{table}");
    let agents = read_light_xml(&fs::read_to_string(at.join("light.xml")).unwrap()).unwrap();
    assert_eq!(agents.len(), 9);
    // Each within the box; rectangles of two bicycles do not overlap.
    let mut rectangles = Vec::new();
    for agent in &agents {
        match &agent.shapes {
            LightShapes::Pedestrian(disks) => assert_eq!(disks.len(), 5),
            LightShapes::Bicycle { bike, rider } => {
                assert!(bike.max.y - bike.min.y > bike.max.x - bike.min.x, "along y");
                rectangles.push([bike.clone(), rider.clone()]);
            }
        }
    }
    assert!(rectangles.len() >= 2 && rectangles.len() < 9);
    for (place, one) in rectangles.iter().enumerate() {
        for a in one {
            assert!(a.min.x > 0.0 && a.min.y > 0.0 && a.max.x < 6.0 && a.max.y < 6.0);
            for b in rectangles[..place].iter().flatten() {
                let apart = a.max.x < b.min.x || b.max.x < a.min.x || a.max.y < b.min.y || b.max.y < a.min.y;
                assert!(apart, "{a:?} {b:?}");
            }
        }
    }
    // The picture has both, where the light file has them: a bicycle's wheels lie along its gaze, which is up.
    let drawn = lemons(at, &[&mixed[..], &["--svg", "m.svg", "--png", "m.png", "--pdf", "m.pdf"]].concat());
    assert_code(&drawn, 0);
    let picture = fs::read_to_string(at.join("m.svg")).unwrap();
    assert!(picture.contains("aria-label=\"bicycle with rider\""), "a legend");
    let (bodies, bicycles) = picture.split_once("<g class=\"bicycles\"").unwrap();
    assert_eq!(bodies.matches("<title>").count() - 1, 9 - rectangles.len());
    let drawn: Vec<&str> = bicycles.split("<g transform=\"translate(").skip(1).collect();
    assert_eq!(drawn.len(), rectangles.len());
    for (text, rectangles) in drawn.iter().zip(&rectangles) {
        assert!(text.contains(")rotate(90)"), "{text}");
        for (class, rectangle) in [("wheels", &rectangles[0]), ("rider", &rectangles[1])] {
            let element = text.split(&format!("class=\"{class}\"")).nth(1).unwrap();
            let number = |name: &str| -> f64 {
                element
                    .split(&format!(" {name}=\""))
                    .nth(1)
                    .unwrap()
                    .split('"')
                    .next()
                    .unwrap()
                    .parse()
                    .unwrap()
            };
            let (length, breadth) = (rectangle.max.y - rectangle.min.y, rectangle.max.x - rectangle.min.x);
            assert!((number("width") - length).abs() < 2e-4, "{class} {text}");
            assert!((number("height") - breadth).abs() < 2e-4, "{class} {text}");
        }
        let bike = &rectangles[0];
        let place = text.split(')').next().unwrap();
        let cut = place.find([' ', '-']).unwrap();
        let (x, y): (f64, f64) = (place[..cut].parse().unwrap(), place[cut..].trim().parse().unwrap());
        let (centre_x, centre_y) = (0.5 * (bike.min.x + bike.max.x), 0.5 * (bike.min.y + bike.max.y));
        assert!((x - centre_x).abs() < 2e-4 && (y - centre_y).abs() < 2e-4, "{text}");
    }
    assert!(fs::read(at.join("m.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(fs::read(at.join("m.pdf")).unwrap().starts_with(b"%PDF-"));
    for (option, file) in [("-o", "T"), ("--zip", "t.zip"), ("--fmu", "t.fmu")] {
        let refused = lemons(at, &[&mixed[..], &[option, file]].concat());
        assert_code(&refused, 2);
        let said = err(&refused);
        assert!(said.contains(option) && said.contains("the mechanics takes pedestrians only"), "{said}");
        assert!(!at.join(file).exists());
    }
    let askew = lemons(at, &["crowd", "-n", "9", "--pedestrians", "0.5", "--direction", "45"]);
    assert_code(&askew, 2);
    assert!(err(&askew).contains("--direction 0, 90, 180 or 270"), "{}", err(&askew));
}

/// A crowd that cannot be placed for long: Ctrl-C ends it, and nothing is left.
#[test]
#[cfg(unix)]
fn an_interrupt_leaves_nothing_behind() {
    let directory = TempDir::new().unwrap();
    let arguments =
        ["crowd", "-n", "3000", "--box", "17.2x17.2", "-o", "T", "--population", "p.csv", "--obj", "b.obj"];
    let mut child = Command::new(env!("CARGO_BIN_EXE_lemons"))
        .args(arguments)
        .current_dir(directory.path())
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // Once its files are open it watches for the signal, and is at work.
    let begun = || fs::read_dir(directory.path()).unwrap().count() == 2;
    while !begun() {
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    std::thread::sleep(std::time::Duration::from_millis(300));
    assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_code(&output, 130);
    assert!(err(&output).contains("interrupted: nothing was written"), "{}", err(&output));
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
}
