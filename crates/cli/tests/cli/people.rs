//! `lemons crowd` and `lemons person` as their users meet them.

use crowd_mechanics::setup;
use lemons_people::{LightShapes, read_light_xml};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

fn lemons(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lemons")).args(arguments).current_dir(directory).output().unwrap()
}

fn out(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn err(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn assert_code(output: &Output, code: i32) {
    assert_eq!(output.status.code(), Some(code), "{}{}", out(output), err(output));
}

fn narrow(text: &str) {
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
}

/// The number after a word at a line's beginning.
fn figure(text: &str, what: &str) -> f64 {
    let line = text.lines().find(|line| line.starts_with(what)).unwrap_or_else(|| panic!("{what}: {text}"));
    line[what.len()..].split_whitespace().next().unwrap().parse().unwrap()
}

#[test]
fn a_made_crowd_passes_check_packs_and_runs_without_a_warning() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let made = lemons(
        at,
        &[
            "crowd",
            "--density",
            "7.2",
            "--box",
            "2x1.5",
            "--speed",
            "0.5",
            "-o",
            "Trial_made",
            "--fmu",
            "made.fmu",
        ],
    );
    assert_code(&made, 0);
    assert_eq!(err(&made), "");
    let said = out(&made);
    narrow(&said);
    for words in
        ["male: ", "female: ", "bideltoid breadth", "seed                        1", "Trial_made", "made.fmu"]
    {
        assert!(said.contains(words), "{words}: {said}");
    }
    assert_eq!(figure(&said, "ground"), 3.0);
    assert_eq!(figure(&said, "density"), 7.333, "22 people on 3 m²");
    assert!(figure(&said, "largest overlap") <= 1.0);
    let step = figure(&said, "mechanical step");

    let check = lemons(at, &["check", "Trial_made"]);
    assert_code(&check, 0);
    assert!(
        out(&check).ends_with(": no problem\n") && out(&check).contains("22 agents, 1 wall,"),
        "{}",
        out(&check)
    );
    let (trial, _) = setup::read(&at.join("Trial_made")).unwrap();
    assert_eq!((trial.parameters.time_step_mechanical, trial.parameters.time_step), (step, 0.01));
    // Alone, everybody would walk at 0.5 m/s along x.
    for (agent, moving) in trial.agents.iter().zip(&trial.dynamics) {
        assert!((moving.fp.x / (agent.mass * agent.floor_damping) - 0.5).abs() < 1e-12 && moving.fp.y == 0.0);
    }

    // The FMU is what `pack` makes of the directory, and both run.
    assert_code(&lemons(at, &["pack", "Trial_made", "-o", "packed.fmu"]), 0);
    assert!(fs::read(at.join("made.fmu")).unwrap() == fs::read(at.join("packed.fmu")).unwrap());
    let info = lemons(at, &["info", "made.fmu", "--only", "agent[21].Mass"]);
    assert!(out(&info).contains(&format!("{:?}", trial.agents[21].mass)), "{}", out(&info));
    for input in ["Trial_made", "made.fmu"] {
        let run = lemons(at, &["run", input, "--until", "0.5", "--force"]);
        assert_code(&run, 0);
        assert_eq!(err(&run), "");
        assert!(figure(&out(&run), "greatest peak") > 1.0, "they press against the wall: {}", out(&run));
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let files = [
        "population.csv",
        "light.xml",
        "sections.geojson",
        "sections.wkt",
        "crowd.svg",
        "crowd.png",
        "crowd.zip",
        "crowd.stl",
    ];
    let make = |name: &str, seed: &str| {
        fs::create_dir(at.join(name)).unwrap();
        let arguments = [
            "crowd",
            "--number",
            "8",
            "--open",
            "--seed",
            seed,
            "-o",
            "T",
            "--zip",
            "crowd.zip",
            "--population",
            "population.csv",
            "--light-xml",
            "light.xml",
            "--sections",
            "1.4,0.5",
            "--sections-geojson",
            "sections.geojson",
            "--sections-wkt",
            "sections.wkt",
            "--stl",
            "crowd.stl",
            "--svg",
            "crowd.svg",
            "--png",
            "crowd.png",
            "--obj",
            "crowd.obj",
        ];
        let made = lemons(&at.join(name), &arguments);
        assert_code(&made, 0);
        narrow(&out(&made));
        assert!(out(&made).contains(" 1.400 m "), "{}", out(&made));
        files.map(|file| fs::read(at.join(name).join(file)).unwrap())
    };
    let (first, again, other) = (make("first", "7"), make("again", "7"), make("other", "8"));
    for (place, file) in files.iter().enumerate() {
        assert!(first[place] == again[place], "{file}");
        assert!(first[place] != other[place], "{file}");
    }
    // Each of eight bodies has five closed parts.
    let obj = fs::read_to_string(at.join("first/crowd.obj")).unwrap();
    assert_eq!(
        obj.lines().filter(|line| line.starts_with("g agent_") || line.starts_with("o agent_")).count(),
        40
    );
    // 80 bytes, a count, 50 bytes for each triangle, of which OBJ has as many.
    let triangles = obj.lines().filter(|line| line.starts_with("f ")).count();
    let stl = fs::read(at.join("first/crowd.stl")).unwrap();
    assert_eq!(stl.len(), 84 + 50 * triangles);
    let (trial, _) = setup::read(&at.join("first/T")).unwrap();
    assert!(trial.geometry.walls.is_empty());
    let left: Vec<_> =
        fs::read_dir(at.join("first")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left.len(), files.len() + 2, "nothing else: {left:?}");
}

#[test]
fn every_way_to_place_and_to_choose_people() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let made = |arguments: &[&str]| {
        let made = lemons(at, &[&["crowd", "-o", "T", "--force"], arguments].concat());
        assert_code(&made, 0);
        let said = err(&made);
        assert!(said.lines().all(|line| line.starts_with("note: T was another Trial before")), "{said}");
        narrow(&out(&made));
        let check = lemons(at, &["check", "T"]);
        assert!(out(&check).ends_with(": no problem\n"), "{}", out(&check));
        setup::read(&at.join("T")).unwrap().0
    };
    let rows = made(&[
        "-n",
        "6",
        "--box",
        "3x3",
        "--packing",
        "grid",
        "--orientation",
        "fixed",
        "--direction",
        "90",
    ]);
    let up = std::f64::consts::FRAC_PI_2;
    assert!(rows.dynamics.iter().all(|moving| (moving.theta - up).abs() < 1e-12));
    // The paper's packer stops where nothing overlaps.
    made(&["-n", "6", "--box", "2x2", "--packing", "paper", "--direction", "30"]);

    // A room with a pillar, as another Trial has it; its walls stay as they are.
    let geometry = r#"<Geometry><Wall Id="room" MaterialId="concrete">
        <Corner Coordinates="0,0"/><Corner Coordinates="3,0"/><Corner Coordinates="3,2"/>
        <Corner Coordinates="0,2"/><Corner Coordinates="0,0"/></Wall>
        <Wall Id="pillar" MaterialId="concrete"><Corner Coordinates="1,0.8"/><Corner Coordinates="1.4,0.8"/>
        <Corner Coordinates="1.4,1.2"/><Corner Coordinates="1,1.2"/><Corner Coordinates="1,0.8"/></Wall></Geometry>"#;
    fs::write(at.join("room.xml"), geometry).unwrap();
    let room = made(&["--density", "3", "--geometry", "room.xml", "--fixed", "45,24,1.63,67,female"]);
    assert_eq!(room.agents.len(), 18, "3 per m² on 5.84 m²");
    assert!(room.agents.iter().all(|agent| agent.mass == 67.0 && agent.height == Some(1.63)));
    assert_eq!(room.geometry.walls.iter().map(|wall| &*wall.id).collect::<Vec<_>>(), ["room", "pillar"]);

    let custom = "men = 1.0\n[male]\nmass = { mean = 100, sd = 1, min = 95, max = 105 }\n";
    fs::write(at.join("custom.toml"), custom).unwrap();
    let heavy = made(&["-n", "5", "--custom", "custom.toml", "--material", "human_clothes"]);
    assert!(heavy.agents.iter().all(|agent| (95.0..=105.0).contains(&agent.mass)));
    assert!(heavy.agents.iter().all(|agent| agent.shapes[0].material_id == "human_clothes"));

    let table =
        "subjectid,bideltoidbreadth,chestdepth,stature,weightkg\n1,491,250,1750,700\n2,455,240,1650,605\n";
    fs::write(at.join("women.csv"), table).unwrap();
    let real = made(&["-n", "5", "--ansur-female", "women.csv"]);
    assert!(real.agents.iter().all(|agent| [70.0, 60.5].contains(&agent.mass)), "{:?}", real.agents);
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

#[test]
fn mistakes_name_the_option_and_the_value() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    fs::write(at.join("letter"), "mine").unwrap();
    fs::create_dir(at.join("letters")).unwrap();
    fs::write(at.join("letters/letter"), "mine").unwrap();
    fs::write(at.join("bad.toml"), "[male]\nmass = { mean = 'heavy' }\n").unwrap();
    fs::write(at.join("worse.toml"), "[female]\nbreadth = { sd = -1 }\n").unwrap();
    let metres = "[male]\nstature = { mean = 1.78, sd = 0.08, min = 1.4, max = 2.4 }\n";
    fs::write(at.join("metres.toml"), metres).unwrap();
    let open = r#"<Geometry><Wall Id="w" MaterialId="concrete"><Corner Coordinates="0,0"/><Corner Coordinates="3,0"/></Wall></Geometry>"#;
    fs::write(at.join("open.xml"), open).unwrap();
    let cheese = open
        .replace("concrete", "cheese")
        .replace("</Wall>", r#"<Corner Coordinates="0,3"/><Corner Coordinates="0,0"/></Wall>"#);
    fs::write(at.join("cheese.xml"), cheese).unwrap();
    let person = ["person", "--breadth", "49", "--depth", "25", "--stature", "1.75", "--mass", "70"];
    let cases: [(&[&str], i32, &[&str]); 34] = [
        (
            &["person", "--breadth", "25", "--depth", "49", "--stature", "1.75", "--mass", "70"],
            2,
            &["--depth 49", "--breadth 25"],
        ),
        (
            &["person", "--breadth", "49", "--depth", "25", "--stature", "1.75", "--mass", "-70"],
            2,
            &["--mass", "-70"],
        ),
        (
            &["person", "--breadth", "49", "--depth", "25", "--stature", "175", "--mass", "70"],
            2,
            &["--stature", "175", "(m)"],
        ),
        (
            &["person", "--breadth", "0.49", "--depth", "25", "--stature", "1.75", "--mass", "70"],
            2,
            &["--breadth", "0.49", "(cm)"],
        ),
        (&[&person[..], &["--obj", "no/such.obj"]].concat(), 1, &["no/such.obj"]),
        (
            &[&person[..], &["--obj", "same", "--stl", "same"]].concat(),
            1,
            &["cannot write same: another result goes there"],
        ),
        (&["crowd"], 2, &["--number", "--density"]),
        (&["crowd", "-n", "0"], 2, &["--number", "0"]),
        (&["crowd", "-n", "-3"], 2, &["--number", "-3"]),
        (&["crowd", "--density", "6"], 2, &["--density 6", "--number"]),
        (&["crowd", "-n", "5", "--density", "6", "--box", "2x2"], 2, &["--number and --density"]),
        (&["crowd", "-n", "5", "--density", "-6"], 2, &["--density", "-6"]),
        (&["crowd", "--density", "0.1", "--box", "1x1"], 1, &["--density 0.1", "nobody"]),
        (&["crowd", "--density", "20", "--box", "2x2"], 1, &["80", "a box of 2 m x 2 m", "cannot hold them"]),
        (
            &["crowd", "--density", "10.25", "--box", "2x2"],
            1,
            &["41 people in a box of 2 m x 2 m", "10.25 /m²", "placed without overlap", "--allow-overlap"],
        ),
        (&["crowd", "--density", "11.5", "--box", "2x1"], 1, &["23", "a box of 2 m x 1 m"]),
        (&["crowd", "-n", "9", "--density", "30"], 1, &["9", "cannot hold them"]),
        (
            &["crowd", "-n", "9", "--density", "5", "--packing", "paper"],
            2,
            &["--density 5", "--packing paper"],
        ),
        (&["crowd", "-n", "100", "--box", "3x3", "--packing", "grid"], 1, &["--packing grid", "places"]),
        (&["crowd", "-n", "5", "--box", "2by2"], 2, &["--box", "2by2"]),
        (&["crowd", "-n", "5", "--box", "-2x2"], 2, &["--box", "-2x2"]),
        (&["crowd", "-n", "5", "--box", "2x2", "--open"], 2, &["--box", "--open"]),
        (&["crowd", "-n", "5", "--men", "1.2"], 2, &["--men", "1.2", "from 0 to 1"]),
        (&["crowd", "-n", "5", "--pedestrians", "-0.1"], 2, &["--pedestrians", "-0.1"]),
        (&["crowd", "-n", "5", "--fixed", "25,49,1.75,70"], 2, &["--fixed", "depth = 49", "breadth = 25"]),
        (&["crowd", "-n", "5", "--fixed", "49,25,1.75,-70"], 2, &["--fixed", "mass"]),
        (&["crowd", "-n", "5", "--custom", "bad.toml"], 1, &["--custom bad.toml", "line 2"]),
        (
            &["crowd", "-n", "5", "--custom", "worse.toml"],
            1,
            &["worse.toml", "female statistics, bideltoid breadth", "must be positive"],
        ),
        (
            &["crowd", "-n", "5", "--custom", "metres.toml"],
            1,
            &["metres.toml", "male statistics, stature: min = 0.014", "measures of people are 0.3 to 3 m"],
        ),
        (
            &["crowd", "-n", "5", "--geometry", "open.xml"],
            1,
            &["--geometry open.xml", "wall w is not closed"],
        ),
        (
            &["crowd", "-n", "5", "--geometry", "cheese.xml", "-o", "T"],
            1,
            &["wall w", "\"cheese\"", "concrete"],
        ),
        (&["crowd", "-n", "5", "-o", "letters"], 1, &["letters", "not a Trial", "--force"]),
        (&["crowd", "-n", "5", "-o", "letter"], 1, &["letter", "not a directory"]),
        (&["crowd", "-n", "5", "--sections", "1.2,9", "--population", "p.csv"], 2, &["--sections", "9"]),
    ];
    for (arguments, code, words) in cases {
        let output = lemons(at, arguments);
        assert_code(&output, code);
        let said = err(&output);
        assert!(
            !said.contains("panicked") && words.iter().all(|word| said.contains(word)),
            "{arguments:?}: {said}"
        );
    }
    let mut left: Vec<_> = fs::read_dir(at).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(
        left,
        ["bad.toml", "cheese.xml", "letter", "letters", "metres.toml", "open.xml", "worse.toml"]
    );
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
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_code(&output, 130);
    assert!(err(&output).contains("interrupted: nothing was written"), "{}", err(&output));
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
}

#[test]
fn a_person_is_told_and_drawn() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let arguments = [
        "person",
        "--breadth",
        "49",
        "--depth",
        "25",
        "--stature",
        "1.75",
        "--mass",
        "70",
        "--sex",
        "female",
        "--obj",
        "p.obj",
        "--stl",
        "p.stl",
        "--geojson",
        "p.geojson",
        "--wkt",
        "p.wkt",
        "--slice-height",
        "10",
        "--svg",
        "p.svg",
    ];
    let output = lemons(at, &arguments);
    assert_code(&output, 0);
    let said = out(&output);
    narrow(&said);
    assert_eq!((figure(&said, "breadth"), figure(&said, "depth")), (49.0, 25.0));
    // The template scaled in both directions: 1458.8 cm² · 49·25/(61.718·30), to the 1 % that disks lose by it.
    let scaled = 1458.8 * 49.0 * 25.0 / (61.718 * 30.0);
    assert!((figure(&said, "area") / scaled - 1.0).abs() < 0.01, "{said}");
    // A rectangle of these sides has m (a² + b²)/12 = 1.77, an ellipse m (a² + b²)/16 = 1.32.
    assert!((1.3..1.5).contains(&figure(&said, "moment of inertia")), "{said}");
    assert!((figure(&said, "volume of the body") * 0.985 / 70.0 - 1.0).abs() < 0.1, "{said}");
    // 50 bytes a triangle after the header of 84.
    assert_eq!((fs::metadata(at.join("p.stl")).unwrap().len() - 84) % 50, 0);
    assert_eq!(fs::read_to_string(at.join("p.wkt")).unwrap().lines().count(), 18, "10 cm in 1.75 m");
    assert!(fs::read_to_string(at.join("p.geojson")).unwrap().contains("FeatureCollection"));
    assert!(fs::read_to_string(at.join("p.svg")).unwrap().starts_with("<svg"));
}

#[test]
fn a_trial_replaces_a_trial_and_keeps_what_else_is_there() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    assert_code(&lemons(at, &["crowd", "-n", "3", "-o", "T"]), 0);
    fs::write(at.join("T/decision.toml"), "mine").unwrap();
    assert_code(&lemons(at, &["crowd", "-n", "4", "-o", "T/"]), 0);
    assert_eq!(setup::read(&at.join("T")).unwrap().0.agents.len(), 4);
    assert_eq!(fs::read_to_string(at.join("T/decision.toml")).unwrap(), "mine");
}

#[test]
fn a_crowd_that_is_written_nowhere_says_so() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let said = out(&lemons(at, &["crowd", "-n", "3"]));
    assert!(said.lines().last().unwrap().starts_with("nothing was written: give -o TRIAL"), "{said}");
    assert_eq!(std::fs::read_dir(at).unwrap().count(), 0);
    for option in [["-o", "trial"], ["--population", "people.csv"]] {
        let said = out(&lemons(at, &[&["crowd", "-n", "3"], &option[..]].concat()));
        assert!(!said.contains("nothing was written"), "{said}");
    }
}
