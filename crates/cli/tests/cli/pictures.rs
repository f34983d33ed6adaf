//! `lemons plot` and `lemons movie`: what is in the pictures is what was in the run.

use crate::common::{assert_code, command, default_trial, done, err, lemons};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// The default push until 1 s, as a table, and as the XML series of the FMU.
fn push() -> TempDir {
    let directory = TempDir::new().unwrap();
    let (at, trial) = (directory.path(), default_trial());
    let trial = trial.to_str().unwrap();
    done(at, &["run", trial, "--until", "1", "--set", "OutputDirectory=series"]);
    std::os::unix::fs::symlink(trial, at.join("push")).unwrap();
    directory
}

fn svg(at: &Path, arguments: &[&str]) -> String {
    let output = done(at, &[&["plot"], arguments, &["-o", "plot.svg", "--force"]].concat());
    assert!(output.stderr.is_empty(), "{}", err(&output));
    fs::read_to_string(at.join("plot.svg")).unwrap()
}

/// The rows of a table at a time, as t, id and numbers in the columns' order.
fn rows_at(at: &Path, time: f64) -> Vec<Vec<f64>> {
    let table = fs::read_to_string(at.join("trajectories.csv")).unwrap();
    let rows = table.lines().skip(1).map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect());
    rows.filter(|row: &Vec<f64>| (row[0] - time).abs() < 1e-9).collect()
}

/// The place of a column of the table.
fn column(at: &Path, name: &str) -> usize {
    let table = fs::read_to_string(at.join("trajectories.csv")).unwrap();
    table.lines().next().unwrap().split(',').position(|column| column == name).unwrap()
}

/// The labels of everything that is lettered.
fn labels(svg: &str) -> Vec<&str> {
    svg.split("aria-label=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect()
}

/// Centres of the bodies, in the order of the picture.
fn places(svg: &str) -> Vec<(f64, f64)> {
    let bodies = svg.split("<g transform=\"translate(").skip(1);
    let pairs = bodies.map(|rest| rest.split(')').next().unwrap());
    let number = |text: &str| text.parse::<f64>().unwrap();
    pairs
        .map(|pair| {
            let cut = pair.find(' ').unwrap_or_else(|| 1 + pair[1..].find('-').unwrap());
            (number(&pair[..cut]), number(pair[cut..].trim()))
        })
        .collect()
}

/// Without a table in between: the same numbers, so the same picture but for the name of its source.
#[test]
fn a_run_that_is_made_to_be_shown_is_the_run_of_the_table() {
    let directory = push();
    let at = directory.path();
    for what in [
        &["--at", "0.33,0.7,1", "--forces"][..],
        &["--at", "0,1", "--trails=0.5"],
        &["--series", "x,speed,squeeze", "--until", "1"],
    ] {
        let made = svg(at, &[&["push"], what].concat());
        let read = svg(at, &[&["trajectories.csv", "--trial", "push"], what].concat());
        let nameless = |svg: &str| svg.replace("trajectories.csv", "push");
        assert!(nameless(&made) == nameless(&read), "{what:?}");
    }
}

/// Where nobody touches anybody a bar from 0 to 1 N stood below.
#[test]
fn a_picture_without_a_contact_says_so_instead_of_a_bar() {
    let directory = push();
    let at = directory.path();
    for (arguments, said) in [
        (&["push", "--at", "0,0.05", "--fill", "squeeze"][..], "mean squeeze over a step: 0 N everywhere"),
        (&["push", "--at", "0,0.05", "--fill", "contacts"], "contacts: 0 everywhere"),
        (&["push", "--at", "0", "--fill", "speed"], "speed: 0 m/s everywhere"),
    ] {
        let text = svg(at, arguments);
        assert!(labels(&text).contains(&said), "{:?}", labels(&text));
        assert!(!text.contains("colour-bar"), "{arguments:?}");
    }
    let text = svg(at, &["push", "--at", "0,0.4", "--fill", "squeeze"]);
    assert!(text.contains("colour-bar") && !text.contains("everywhere"));
}

#[test]
fn a_scene_is_where_the_run_was() {
    let directory = push();
    let at = directory.path();
    let text = svg(at, &["trajectories.csv", "--trial", "push", "--at", "0.4", "--fill", "squeeze"]);
    let (rows, drawn) = (rows_at(at, 0.4), places(&text));
    assert_eq!(drawn.len(), 5);
    for (row, place) in rows.iter().zip(drawn) {
        assert!((row[2] - place.0).abs() < 6e-5 && (row[3] - place.1).abs() < 6e-5, "{row:?} {place:?}");
    }
    let greatest = rows.iter().map(|row| row[column(at, "mean_normal_force")]).fold(0.0, f64::max);
    let labels = labels(&text);
    assert!(greatest > 10.0);
    assert!(labels.contains(&"t = 0.40 s") && labels.contains(&"mean squeeze over a step (N)"), "{labels:?}");
    let high = labels[labels.iter().position(|l| *l == "mean squeeze over a step (N)").unwrap() - 1];
    let high: f64 = high.parse().unwrap();
    assert!((high / greatest - 1.0).abs() < 0.01, "{labels:?}, {greatest} N");
}

/// The last step was shortened so that it ended at the last time; its mean squeeze was that of a shorter step.
#[test]
fn a_time_between_communication_points_does_not_shorten_the_last_step() {
    let directory = TempDir::new().unwrap();
    let (at, trial) = (directory.path(), default_trial());
    let scenes = |times: &str| {
        let plot = ["plot", trial.to_str().unwrap(), "--at", times, "--set", "TimeStepMechanical=1e-4"];
        done(at, &[&plot[..], &["--fill", "squeeze", "-o", "plot.svg", "--force"]].concat());
        fs::read_to_string(at.join("plot.svg")).unwrap()
    };
    assert!(scenes("0.38") == scenes("0.4"));
    assert!(scenes("0.36,0.38") == scenes("0.35,0.4"));
}

#[test]
fn a_trial_its_table_and_its_series_give_one_picture() {
    let directory = push();
    let at = directory.path();
    for look in [&["--fill", "speed", "--forces", "--trails"][..], &["--fill", "contacts", "--ids"]] {
        let times = ["--at", "0.2,0.4,1"];
        let of_table = svg(at, &[&["trajectories.csv", "--trial", "push"], &times[..], look].concat());
        assert_eq!(labels(&of_table).iter().filter(|label| label.contains("t = ")).count(), 3);
        assert!(of_table == svg(at, &[&["push"], &times[..], look].concat()));
        // A series has no frame at the start, where a trail begins.
        let without = |text: &str| text.lines().filter(|line| !line.contains("=\"halo\"")).count();
        let of_series = svg(at, &[&["series", "--trial", "push"], &times[..], look].concat());
        assert_eq!(places(&of_table), places(&of_series));
        assert_eq!(without(&of_table), without(&of_series));
    }
    assert!(svg(at, &["push"]) == svg(at, &["push", "--at", "0"]));
}

#[test]
fn forces_of_other_parameters_are_told() {
    let directory = push();
    let (at, setting) = (directory.path(), ["--set", "contact.human_naked.human_naked.GammaNormal=5000"]);
    done(at, &[&["run", "push", "--until", "0.5"], &setting[..]].concat());
    let plot = ["plot", "trajectories.csv", "--trial", "push", "--at", "0.25", "--forces", "-o", "a.svg"];
    let told = done(at, &plot);
    assert!(err(&told).contains("the forces shown are not the run's"), "{}", err(&told));
    let told = done(at, &[&plot, &setting[..]].concat());
    assert!(told.stderr.is_empty(), "{}", err(&told));
    let text = fs::read_to_string(at.join("a.svg")).unwrap();
    assert!(text.contains("class=\"forces\"") && labels(&text).iter().any(|label| label.ends_with('N')));
}

#[test]
fn measured_beside_simulated() {
    let directory = push();
    let at = directory.path();
    fs::write(at.join("seen.csv"), "t,id,x,y\n0,0,0,0\n0.25,0,0.1,0\n0.5,0,0.3,0.1\n0.9,0,9,9\n").unwrap();
    let look = ["--measured", "seen.csv", "--measured-from", "start"];
    let text = svg(at, &[&["push", "--at", "0.5"], &look[..]].concat());
    let labels = labels(&text);
    assert!(labels.contains(&"measured") && labels.contains(&"simulated"), "{labels:?}");
    assert_eq!(text.matches("stroke-dasharray").count(), 3, "one line and its casing, one legend");
    let start = &rows_at(at, 0.0)[0];
    let line = text.lines().find(|line| line.contains("class=\"measured\"")).unwrap();
    let d = line.split(" d=\"M").nth(1).unwrap();
    let x: f64 = d.split([' ', 'L']).next().unwrap().parse().unwrap();
    assert!((x - start[2]).abs() < 6e-5, "{line}");
    assert!(!line.contains("9."), "what is seen later is not yet there");
    let series = svg(at, &[&["trajectories.csv", "--series", "x,speed"], &look[..]].concat());
    assert_eq!(series.matches("class=\"chart-panel\"").count(), 2);
    assert!(series.contains("stroke-dasharray"));
}

#[test]
fn time_series_and_maps() {
    let directory = push();
    let at = directory.path();
    let all = svg(at, &["trajectories.csv", "--series", "x,speed,squeeze,peak-squeeze,contacts"]);
    assert_eq!(all.matches("class=\"chart-panel\"").count(), 5);
    let shown = labels(&all);
    for label in ["mean squeeze over a step (N)", "peak squeeze (N)", "agent 4"] {
        assert!(shown.contains(&label), "{shown:?}");
    }
    assert!(all == svg(at, &["push", "--series", "x,speed,squeeze,peak-squeeze,contacts", "--until", "1"]));
    let one = svg(at, &["trajectories.csv", "--series", "speed", "--agents", "3", "--from", "0.5"]);
    assert!(one.contains("<title>agent 3</title>") && !one.contains("<title>agent 2</title>"));
    let said = done(at, &["plot", "trajectories.csv", "--trial", "push", "--density", "-o", "map.svg"]);
    assert!(err(&said).contains("Gaussian with a standard deviation of 0.3 m"), "{}", err(&said));
    assert!(err(&said).contains("not through walls"), "{}", err(&said));
    let map = fs::read_to_string(at.join("map.svg")).unwrap();
    assert!(map.contains("<desc>each person is spread as a Gaussian"));
    assert!(map.contains("class=\"density\"") && places(&map).is_empty());
    assert!(labels(&map).iter().any(|label| label.contains("density")), "{:?}", labels(&map));
}

/// The greatest squeeze of a step hung on the step: a sample at its end, where the peak was long over.
#[test]
fn squeeze_is_the_mean_of_a_step_and_peak_its_largest() {
    let directory = push();
    let at = directory.path();
    let high = |text: &str, title: &str| -> f64 {
        let labels = labels(text);
        let place = labels.iter().position(|label| *label == title);
        let place = place.unwrap_or_else(|| panic!("no {title} in {labels:?}"));
        labels[place - 1].parse().unwrap()
    };
    let rows = rows_at(at, 0.4);
    let greatest = |name: &str| rows.iter().map(|row| row[column(at, name)]).fold(0.0, f64::max);
    let table = |fill: &str| svg(at, &["trajectories.csv", "--trial", "push", "--at", "0.4", "--fill", fill]);
    let mean = high(&table("squeeze"), "mean squeeze over a step (N)");
    let peak = high(&table("peak-squeeze"), "peak squeeze (N)");
    assert!((mean / greatest("mean_normal_force") - 1.0).abs() < 0.01, "{mean}");
    assert!((peak / greatest("peak_normal_force") - 1.0).abs() < 0.01 && peak > mean, "{peak}, {mean}");
    // A series does not say them.
    for fill in ["squeeze", "peak-squeeze"] {
        let plot =
            ["plot", "series", "--trial", "push", "--at", "0.4", "--fill", fill, "-o", "a.svg", "--force"];
        let told = done(at, &plot);
        assert!(err(&told).contains("the squeeze at this time is shown instead"), "{}", err(&told));
        let text = fs::read_to_string(at.join("a.svg")).unwrap();
        let sample = high(&text, "squeeze at the time (N)");
        assert!((sample / greatest("normal_force") - 1.0).abs() < 0.01, "{sample}");
    }
    let plot =
        ["plot", "series", "--trial", "push", "--series", "squeeze,peak-squeeze", "-o", "a.svg", "--force"];
    let told = done(at, &plot);
    assert!(err(&told).contains("peak squeeze over communication steps"), "{}", err(&told));
    let text = fs::read_to_string(at.join("a.svg")).unwrap();
    assert_eq!(text.matches("class=\"chart-panel\"").count(), 1, "the same is shown once");
    assert!(labels(&text).contains(&"squeeze at the time (N)"), "{:?}", labels(&text));
}

/// One step in two hundred is a spike: all others had the colour of nothing.
#[test]
fn a_spike_does_not_set_the_scale() {
    let directory = push();
    let at = directory.path();
    let (place, table) =
        (column(at, "mean_normal_force"), fs::read_to_string(at.join("trajectories.csv")).unwrap());
    let rows: Vec<String> = table
        .lines()
        .enumerate()
        .map(|(k, row)| {
            let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
            if k > 0 {
                cells[place] = if k == 40 { "90000".into() } else { format!("{}", 100 + k) };
            }
            cells.join(",")
        })
        .collect();
    fs::write(at.join("spike.csv"), rows.join("\n") + "\n").unwrap();
    let count = rows.len() - 1;
    assert!(count > 100, "{count} rows");
    let times: Vec<String> = (0..=20).map(|k| format!("{}", f64::from(k) * 0.05)).collect();
    let text = svg(at, &["spike.csv", "--trial", "push", "--at", &times.join(","), "--fill", "squeeze"]);
    let labels = labels(&text);
    assert!(labels.contains(&"mean squeeze over a step (N), to the 98 % quantile"), "{labels:?}");
    let high = labels.iter().find_map(|label| label.strip_prefix("≥ ")).unwrap().parse::<f64>().unwrap();
    // The spike is the last of them; the others are 101, 102, ….
    let rank = (0.98 * count as f64).ceil();
    assert!((high - (100.0 + rank)).abs() <= 2.0, "{high} N of {count} rows");
    let asked =
        svg(at, &["spike.csv", "--trial", "push", "--at", "0,1", "--fill", "squeeze", "--range", "0,50"]);
    assert!(asked.contains("≥ 50") && !asked.contains("quantile"));
    let room =
        svg(at, &["spike.csv", "--trial", "push", "--at", "0,1", "--fill", "squeeze", "--range", "0,90000"]);
    assert!(!room.contains('≥'));
}

#[test]
fn a_plot_can_be_a_pdf() {
    let directory = push();
    let at = directory.path();
    for more in [
        &["--at", "0.2,0.4", "--fill", "squeeze", "--forces", "--ids"][..],
        &["--series", "x,speed"],
        &["--density"],
    ] {
        done(
            at,
            &[&["plot", "trajectories.csv", "--trial", "push", "-o", "a.pdf", "--force"], more].concat(),
        );
        let made = fs::read(at.join("a.pdf")).unwrap();
        assert!(made.starts_with(b"%PDF-") && made.ends_with(b"%%EOF"), "{more:?}");
        assert!(!made.windows(5).any(|part| part == b"/Font"), "{more:?}");
    }
}

#[test]
fn mistakes_have_clear_messages() {
    let directory = push();
    let at = directory.path();
    fs::write(at.join("strangers.csv"), "t,id,x,y\n0,nobody,0,0\n").unwrap();
    let table = fs::read_to_string(at.join("trajectories.csv")).unwrap();
    let bare: String =
        table.lines().map(|row| row.split(',').take(8).collect::<Vec<_>>().join(",") + "\n").collect();
    fs::write(at.join("bare.csv"), bare).unwrap();
    for (arguments, code, expected) in [
        (&["plot", "push", "-o", "a.jpg"][..], 2, "a.jpg: pictures are .png, .svg or .pdf"),
        (&["plot", "trajectories.csv"], 1, "give the Trial or FMU of the run"),
        (
            &["plot", "trajectories.csv", "--trial", "push", "--at", "2"],
            1,
            "t = 2.0 s is not in it: it goes from 0.0 to 1.0 s",
        ),
        (&["plot", "push", "--at", "-1"], 2, "--at"),
        (
            &["plot", "push", "--fill", "mood"],
            2,
            "area, speed, contacts, squeeze, greatest-squeeze, peak-squeeze",
        ),
        (&["plot", "push", "--over", "1"], 2, "--over is for squeeze and greatest-squeeze"),
        (
            &["plot", "trajectories.csv", "--trial", "push", "--series", "squeeze", "--over", "0.01"],
            2,
            "--over 0.01: shorter than the time between two frames, 0.050000 s",
        ),
        (&["plot", "push", "--view", "1,1,0,0"], 2, "lower left"),
        (&["plot", "push", "--series", "x", "--density"], 2, "cannot be used"),
        (&["plot", "push", "--set", "agent[0].Mass=-3"], 1, "must be positive"),
        (&["plot", "push", "--set", "agent[0].Speed=3"], 1, "no variable \"agent[0].Speed\""),
        (&["plot", "trajectories.csv", "--trial", "push", "--step", "0.1"], 2, "--step"),
        (&["plot", "push", "--measured", "strangers.csv"], 1, "there is no agent \"nobody\""),
        (&["plot", "bare.csv", "--series", "squeeze"], 1, "does not contain the mean squeeze"),
        (&["plot", "trajectories.csv", "--series", "x", "--agents", "9"], 1, "no agent \"9\""),
        (
            &["plot", "trajectories.csv", "--trial", "push", "--density", "--from", "3"],
            1,
            "no frame from 3.0",
        ),
        (&["movie", "push", "-o", "a.avi"], 2, "movies are .mp4, .png or .gif"),
        (&["movie", "push", "--speed-up", "1000", "-o", "a.gif"], 1, "frames: a movie has from 2"),
    ] {
        let output = lemons(at, arguments);
        assert_code(&output, code);
        assert!(err(&output).contains(expected), "{arguments:?}: {}", err(&output));
    }
    let left = |name: &str| at.join(name).exists();
    assert!(!left("plot.png") && !left("a.gif") && !left("a.svg"), "nothing half-written");
    // What is recorded by the bodies at the table's poses.
    done(at, &["plot", "bare.csv", "--trial", "push", "--series", "squeeze"]);
}

#[test]
fn movies() {
    let directory = push();
    let at = directory.path();
    let small = ["--width", "120", "--frame-rate", "10"];
    let movie = |name: &str, more: &[&str]| {
        done(at, &[&["movie", "trajectories.csv", "--trial", "push", "-o", name], &small[..], more].concat());
        fs::read(at.join(name)).unwrap()
    };
    let frames = |bytes: Vec<u8>| {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let control = *reader.info().animation_control().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        (0..control.num_frames).for_each(|_| {
            reader.next_frame(&mut pixels).unwrap();
        });
        control.num_frames
    };
    assert_eq!(frames(movie("a.png", &[])), 11);
    assert_eq!(frames(movie("b.png", &["--speed-up", "0.5", "--from", "0.2", "--until", "0.6"])), 9);
    assert!(movie("c.gif", &["--fill", "speed"]).starts_with(b"GIF89a"));
    // Without ffmpeg it is a GIF, and MP4 says what it needs.
    let without = |arguments: &[&str]| {
        let arguments = [&["movie", "trajectories.csv", "--trial", "push"], &small[..], arguments].concat();
        command(at, &arguments).env("PATH", "").output().unwrap()
    };
    assert_code(&without(&[]), 0);
    assert!(at.join("movie.gif").is_file());
    let refused = without(&["-o", "d.mp4"]);
    assert_code(&refused, 1);
    assert!(err(&refused).contains("MP4 needs the program ffmpeg") && !at.join("d.mp4").exists());
}

/// A program of that name that keeps the frames it is given.
#[test]
fn ffmpeg_is_given_every_frame() {
    let directory = push();
    let at = directory.path();
    fs::create_dir(at.join("bin")).unwrap();
    let script = "#!/bin/sh\n[ \"$1\" = -version ] && exit\necho \"$@\" >arguments\nfor last; do :; done\ncat >\"$last\"\n";
    let program = at.join("bin/ffmpeg");
    fs::write(&program, script).unwrap();
    fs::set_permissions(&program, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    let path = format!("{}:{}", at.join("bin").display(), std::env::var("PATH").unwrap());
    let movie = |more: &[&str]| {
        let look = ["movie", "trajectories.csv", "--trial", "push", "--width", "121", "--frame-rate", "10"];
        command(at, &[&look, more].concat()).env("PATH", &path).output().unwrap()
    };
    assert_code(&movie(&[]), 0);
    let arguments = fs::read_to_string(at.join("arguments")).unwrap();
    let size = arguments.split("-s ").nth(1).unwrap().split(' ').next().unwrap();
    let (width, height) = size.split_once('x').unwrap();
    let (width, height): (usize, usize) = (width.parse().unwrap(), height.parse().unwrap());
    assert!(width == 122 && height % 2 == 0, "{arguments}");
    assert!(arguments.contains("-pix_fmt rgba") && arguments.contains("-r 10 "), "{arguments}");
    let frames = fs::read(at.join("movie.mp4")).unwrap();
    assert_eq!(frames.len(), 11 * 4 * width * height);
    // What it says when it fails.
    fs::write(&program, "#!/bin/sh\n[ \"$1\" = -version ] && exit\necho no such codec >&2\nexit 1\n")
        .unwrap();
    let output = movie(&["-o", "b.mp4"]);
    assert_code(&output, 1);
    assert!(
        err(&output).contains("b.mp4: ffmpeg") && err(&output).contains("no such codec"),
        "{}",
        err(&output)
    );
    assert!(!at.join("b.mp4").exists());
}

#[test]
fn an_interrupted_movie_leaves_nothing() {
    let directory = push();
    let at = directory.path();
    let names = || {
        let mut names: Vec<_> = fs::read_dir(at).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names
    };
    let temporary = TempDir::new().unwrap();
    let before = names();
    let long = ["--speed-up", "0.001", "-o", "a.gif", "--forces"];
    let mut running = command(at, &[&["movie", "trajectories.csv", "--trial", "push"], &long[..]].concat())
        .env("TMPDIR", temporary.path())
        .spawn()
        .unwrap();
    // The movie is begun when its hidden file is there.
    while names() == before && running.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let signal = std::process::Command::new("kill").args(["-INT", &running.id().to_string()]).status();
    assert!(signal.unwrap().success());
    assert_eq!(running.wait().unwrap().code(), Some(130));
    assert_eq!(names(), before);
    assert_eq!(fs::read_dir(temporary.path()).unwrap().count(), 0);
}

/// One who is pushed for half a second and stands soon after, in a run of 8 s.
#[test]
fn a_movie_of_standing_bodies_can_end_where_they_stand() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    done(at, &["crowd", "-n", "1", "--box", "4x4", "-o", "one"]);
    let still = ["movie", "one", "--step", "0.05", "--width", "64", "--frame-rate", "10"];
    let nothing = lemons(at, &[&still[..], &["--until", "still", "-o", "0.png"]].concat());
    assert_code(&nothing, 1);
    assert!(err(&nothing).contains("nobody moves after t = 0.0 s"), "{}", err(&nothing));
    fs::write(at.join("one/drive.csv"), "t,agent,Fp.x,Fp.y,Mp\n2,0,0,0,0\n2.1,0,200,0,0\n2.5,0,0,0,0\n")
        .unwrap();
    done(at, &["run", "one", "--step", "0.05", "--until", "8"]);
    // From the frame after the last one that moves.
    let table = fs::read_to_string(at.join("trajectories.csv")).unwrap();
    let rows: Vec<Vec<f64>> =
        table.lines().skip(1).map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    let moving = rows.iter().rposition(|row| row[4].hypot(row[5]) > 0.01 || row[7].abs() > 0.05).unwrap();
    let stands = rows[moving + 1][0];
    assert!(stands > 2.5 && stands < 6.0, "{stands}");
    let told = format!(
        "nobody moves after t = {:?} s: to end the movie there, use --until still",
        (stands * 1e6).round() / 1e6
    );
    let frames = |name: &str| {
        let reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(at.join(name)).unwrap()));
        reader.read_info().unwrap().info().animation_control().unwrap().num_frames
    };
    let expected = (10.0 * stands + 1e-6).floor() as u32 + 1;
    let record = ["movie", "trajectories.csv", "--trial", "one", "--width", "64", "--frame-rate", "10"];
    for source in [&still[..], &record] {
        let whole = done(at, &[source, &["--until", "8", "-o", "whole.png", "--force"]].concat());
        assert!(err(&whole).contains(&told), "{}", err(&whole));
        assert_eq!(frames("whole.png"), 81);
        let short = done(at, &[source, &["--until", "still", "-o", "short.png", "--force"]].concat());
        assert!(short.stderr.is_empty(), "{}", err(&short));
        assert_eq!(frames("short.png"), expected, "{stands}");
    }
    // Somebody moves all the time.
    let moving = done(at, &[&record[..], &["--until", "2.4", "-o", "a.png"]].concat());
    assert!(moving.stderr.is_empty(), "{}", err(&moving));
    let wrong = lemons(at, &[&still[..], &["--until", "stil"]].concat());
    assert_code(&wrong, 2);
    assert!(err(&wrong).contains("number of seconds, or still"), "{}", err(&wrong));
}
