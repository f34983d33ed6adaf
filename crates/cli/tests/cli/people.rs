//! `lemons crowd` and `lemons person` as their users meet them.

use crate::common::{assert_code, err, lemons, names, out, signalled, started};
use lemons_core::xml::{Document, Element};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

fn narrow(text: &str) {
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
}

fn child<'a>(element: Element<'a>, name: &str) -> Element<'a> {
    element.elements().find(|child| child.name() == name).unwrap()
}

fn text<'a>(element: Element<'a>, name: &str) -> &'a str {
    child(element, name).texts().next().unwrap().0
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
    let light = fs::read(at.join("light.xml")).unwrap();
    let light = Document::parse(Path::new("light.xml"), &light, u32::MAX).unwrap();
    let agents: Vec<Element> = light.any_root().elements().collect();
    assert_eq!(agents.len(), 9);
    // Each within the box; rectangles of two bicycles do not overlap.
    let mut rectangles = Vec::new();
    for agent in agents {
        let shapes: Vec<Element> = child(agent, "Shapes").elements().collect();
        if text(agent, "type") == "pedestrian" {
            assert_eq!(shapes.len(), 5);
            continue;
        }
        let [bike, rider] = [shapes[0], shapes[1]].map(|shape| {
            ["min_x", "min_y", "max_x", "max_y"].map(|name| text(shape, name).parse::<f64>().unwrap())
        });
        assert!(bike[3] - bike[1] > bike[2] - bike[0], "along y");
        rectangles.push([bike, rider]);
    }
    assert!(rectangles.len() >= 2 && rectangles.len() < 9);
    for (place, one) in rectangles.iter().enumerate() {
        for a in one {
            assert!(a.iter().all(|place| (0.0..6.0).contains(place)));
            for b in rectangles[..place].iter().flatten() {
                let apart = a[2] < b[0] || b[2] < a[0] || a[3] < b[1] || b[3] < a[1];
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
            let (length, breadth) = (rectangle[3] - rectangle[1], rectangle[2] - rectangle[0]);
            assert!((number("width") - length).abs() < 2e-4, "{class} {text}");
            assert!((number("height") - breadth).abs() < 2e-4, "{class} {text}");
        }
        let bike = &rectangles[0];
        let place = text.split(')').next().unwrap();
        let cut = place.find([' ', '-']).unwrap();
        let (x, y): (f64, f64) = (place[..cut].parse().unwrap(), place[cut..].trim().parse().unwrap());
        let (centre_x, centre_y) = (0.5 * (bike[0] + bike[2]), 0.5 * (bike[1] + bike[3]));
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
    let at = directory.path();
    // Once its files are open it watches for the signal, and is at work.
    let output = signalled(started(at, &arguments), "-TERM", || {
        let begun = names(at).len() == 2;
        std::thread::sleep(std::time::Duration::from_millis(if begun { 300 } else { 5 }));
        begun
    });
    assert_code(&output, 130);
    assert!(err(&output).contains("interrupted: nothing was written"), "{}", err(&output));
    assert_eq!(names(at), [""; 0]);
}
