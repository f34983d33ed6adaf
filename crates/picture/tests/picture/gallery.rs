//! Pictures to look at, in the target directory.

use crate::common::{agent, pedestrian, shared, trial};
use lemons_picture::*;
use lemons_plane::{Vec2, vec2};
use lemons_trial::{Shape, Trial};
use std::path::{Path, PathBuf};

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

fn keep(name: &str, text: &str, width: u32) {
    std::fs::write(path(name).with_extension("svg"), text).unwrap();
    std::fs::write(path(name).with_extension("png"), png(text, width).unwrap()).unwrap();
}

fn show(name: &str, scene: &Scene, style: &Style, width: u32) {
    keep(name, &svg(scene, style), width);
}

fn dark() -> Style {
    Style { theme: Theme::Dark, ..Style::default() }
}

fn speeds(t: &Trial, phase: f64) -> Values {
    let values = (0..t.agents.len()).map(|k| (k as f64 * 0.7 + phase).sin().abs()).collect();
    Values { values, label: "speed".into(), unit: "m/s".into(), range: None, ..Values::default() }
}

/// Bodies whose disks nearly touch push each other, the harder the nearer.
fn pushes(t: &Trial) -> Vec<Force> {
    let mut forces = Vec::new();
    for (i, a) in t.dynamics.iter().enumerate() {
        for b in &t.dynamics[i + 1..] {
            let d = (a.position - b.position).norm();
            if d < 0.42 {
                forces.push(Force { from: a.position, to: b.position, normal_force: 6000.0 * (0.43 - d) });
            }
        }
    }
    forces
}

fn people(n: usize) -> Vec<(lemons_trial::Agent, Vec2, f64)> {
    (0..n).map(|k| (pedestrian(&k.to_string()), vec2(0.55 * k as f64, 0.0), 0.0)).collect()
}

fn box_of(low: Vec2, high: Vec2) -> Vec<Vec2> {
    vec![low, vec2(high.x, low.y), high, vec2(low.x, high.y), low]
}

#[test]
fn scenes() {
    let alphabet = " AaBbCcDdEeFfGgHhIiJjKkLlMm NnOoPpQqRrSsTtUuVvWwXxYyZz 0123456789 .,:·-+=_/()%°²³µθω é";
    let t = trial(vec![(pedestrian("17"), Vec2::ZERO, 0.9)], vec![]);
    let values = Values {
        values: vec![1.0],
        label: alphabet.into(),
        unit: "N/m".into(),
        range: Some((0.0, 2.5)),
        ..Values::default()
    };
    let ids = Style { ids: Visibility::Shown, ..Style::default() };
    show("single", &Scene::at_start(&t), &Style { fill: Fill::Values(values), ..ids.clone() }, 1200);
    // All that there is, on a narrow page.
    let squeeze = Values {
        values: vec![120.0, 800.0, 2594.0, 1200.0, 0.0],
        label: "number of contacts".into(),
        unit: "N".into(),
        range: None,
        ..Values::default()
    };
    for (name, walls, width) in [
        ("narrow-row", box_of(vec2(-0.3, -0.3), vec2(2.7, 0.3)), 400),
        ("corridor", box_of(vec2(-0.3, -6.0), vec2(2.6, 9.0)), 400),
    ] {
        let t = trial(people(5), vec![walls]);
        let mut scene = Scene::at_start(&t);
        scene.forces = (0..4)
            .map(|k| Force {
                from: t.dynamics[k].position,
                to: t.dynamics[k + 1].position,
                normal_force: [300.0, 900.0, 2600.0, 50.0][k],
            })
            .collect();
        for k in 0..5 {
            let at = t.dynamics[k].position;
            let trail = |kind, amount: f64| Trail {
                agent: Some(k),
                kind,
                points: (0..60)
                    .map(|j| at + vec2(0.0, -amount) * (f64::from(j) * 0.05).sin().abs())
                    .collect(),
            };
            scene.trails.push(trail(TrailKind::Simulated, 0.2));
            scene.trails.push(trail(TrailKind::Measured, 0.25));
        }
        let full = Style { time: Some(12.0), fill: Fill::Values(squeeze.clone()), ..ids.clone() };
        show(name, &scene, &full, width);
        show(&format!("{name}-dark"), &scene, &Style { theme: Theme::Dark, ..full }, width);
    }
    if let Some(t) = shared("push_wed/Trial") {
        let scene = Scene::at_start(&t);
        show("row", &scene, &Style::default(), 400);
        let style = Style { time: Some(0.25), fill: Fill::BodyArea, ids: Visibility::Shown, ..dark() };
        show("row-full", &scene, &style, 1000);
    }
    let Some(t) = shared("crowds/dense_100") else { return };
    let mut scene = Scene::at_start(&t);
    show("dense", &scene, &Style::default(), 400);
    let full = Style { time: Some(12.0), fill: Fill::Values(speeds(&t, 0.0)), ..ids.clone() };
    show("dense-full", &scene, &full, 1000);
    show("dense-dark", &scene, &Style { fill: Fill::Values(speeds(&t, 0.0)), ..dark() }, 400);
    scene.forces = pushes(&t);
    show("forces", &scene, &Style { ids: Visibility::Hidden, ..full.clone() }, 400);
    show("forces-ids", &scene, &full, 1000);
    show("forces-dark", &scene, &Style { theme: Theme::Dark, ids: Visibility::Hidden, ..full.clone() }, 800);
    scene.forces.clear();
    for (k, d) in t.dynamics.iter().enumerate() {
        let points = (0..40)
            .map(|j| {
                let s = f64::from(39 - j) * 0.012;
                d.position - vec2(s, 0.08 * (s * 9.0 + k as f64).sin())
            })
            .collect();
        scene.trails.push(Trail { agent: Some(k), kind: TrailKind::Simulated, points });
    }
    show("trails", &scene, &Style { ids: Visibility::Hidden, ..full.clone() }, 800);
    show("trails-dark", &scene, &Style { theme: Theme::Dark, ids: Visibility::Hidden, ..full }, 400);
}

/// The measured displacements, from the start of each in the Trial.
fn measured(t: &Trial) -> Option<Vec<Vec<(f64, Vec2)>>> {
    let path = lemons_testing::shared("push_wed/measured_head_trajectories.csv")?;
    let text = std::fs::read_to_string(path).unwrap();
    let mut all = vec![Vec::new(); t.agents.len()];
    for line in text.lines().skip(1) {
        let n: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        let id = n[1] as usize;
        all[id].push((n[0], vec2(n[2], n[3])));
    }
    Some(all.into_iter().zip(&t.dynamics).map(|(m, d)| from_start(m, d.position)).collect())
}

/// As if it had begun at `start`.
fn from_start(points: Vec<(f64, Vec2)>, start: Vec2) -> Vec<(f64, Vec2)> {
    let first = points.first().map_or(Vec2::ZERO, |p| p.1);
    points.into_iter().map(|(t, p)| (t, start + (p - first))).collect()
}

#[test]
fn measured_beside_simulated() {
    let Some(t) = shared("push_wed/Trial") else { return };
    let Some(measured) = measured(&t) else { return };
    // Not a simulation: the measured ones, a little off.
    let simulated: Vec<Vec<(f64, Vec2)>> = measured
        .iter()
        .map(|m| {
            let start = m[0].1;
            m.iter().map(|(s, p)| (*s, start + (*p - start) * 0.9 + vec2(0.0, 0.01 * s))).collect()
        })
        .collect();
    let upto = |all: &[Vec<(f64, Vec2)>], kind, end: f64| -> Vec<Trail> {
        let points = |m: &Vec<(f64, Vec2)>| m.iter().filter(|p| p.0 <= end).map(|p| p.1).collect();
        all.iter().enumerate().map(|(k, m)| Trail { agent: Some(k), kind, points: points(m) }).collect()
    };
    let scene_at = |end: f64| {
        let at = |m: &Vec<(f64, Vec2)>| m.iter().rfind(|p| p.0 <= end).unwrap().1;
        let poses = simulated.iter().map(|m| Pose { position: at(m), orientation: 0.0 }).collect();
        let mut scene = Scene::new(&t, poses);
        scene.trails = upto(&simulated, TrailKind::Simulated, end);
        scene.trails.extend(upto(&measured, TrailKind::Measured, end));
        scene.forces = (0..4)
            .map(|k| Force {
                from: scene.poses[k].position,
                to: scene.poses[k + 1].position,
                normal_force: 700.0 * (1.0 + (end * 3.0 + k as f64).sin()),
            })
            .collect();
        scene
    };
    let scene = scene_at(6.0);
    let full = Style { time: Some(6.0), ids: Visibility::Shown, ..Style::default() };
    show("measured", &scene, &full, 400);
    show("measured-dark", &scene, &Style { theme: Theme::Dark, ..full.clone() }, 1600);
    let values = |v: Vec<f64>| {
        Some(Fill::Values(Values {
            values: v,
            label: "squeeze".into(),
            unit: "N".into(),
            range: None,
            ..Values::default()
        }))
    };
    let scenes: Vec<Scene> = [0.0, 0.5, 1.0, 2.0, 4.0, 6.0].map(scene_at).into();
    let panels: Vec<Panel> = scenes
        .iter()
        .zip([0.0, 0.5, 1.0, 2.0, 4.0, 6.0])
        .map(|(scene, time)| Panel {
            scene,
            time: Some(time),
            fill: values((0..5).map(|k| 900.0 * (time + f64::from(k)).sin().abs()).collect()),
        })
        .collect();
    let style = SheetStyle { style: Style { width: 800.0, ..Style::default() }, ..SheetStyle::default() };
    keep("sheet", &sheet(&panels, 2, &style), 800);
    keep("sheet-400", &sheet(&panels, 3, &style), 400);
    let night = SheetStyle { style: Style { theme: Theme::Dark, ..style.style }, ..style };
    keep("sheet-dark", &sheet(&panels, 1, &night), 400);

    let axis = |label: &str, unit: &str| Axis { label: label.into(), unit: unit.into() };
    let line = |k: usize, dashed, points| Line { name: k.to_string(), points, group: k, dashed };
    let x = |all: &[Vec<(f64, Vec2)>], dashed| -> Vec<Line> {
        let points = |m: &Vec<(f64, Vec2)>| m.iter().map(|p| (p.0, p.1.x)).collect();
        all.iter().enumerate().map(|(k, m)| line(k, dashed, points(m))).collect()
    };
    let speed = |m: &Vec<(f64, Vec2)>| {
        m.windows(2).map(|w| (w[1].0, (w[1].1 - w[0].1).norm() / 0.04)).collect::<Vec<_>>()
    };
    let speeds = simulated.iter().enumerate().map(|(k, m)| line(k, false, speed(m))).collect();
    let contacts = (0..5)
        .map(|k| {
            let points = (0..150)
                .map(|j| {
                    let s = f64::from(j) * 0.04;
                    (s, (1.4 + 1.4 * (s * 1.5 - k as f64 * 0.4).sin()).round())
                })
                .collect();
            line(k, false, points)
        })
        .collect();
    let mut both = x(&simulated, false);
    both.extend(x(&measured, true));
    let chart = Chart {
        noun: "agent".into(),
        x: axis("time", "s"),
        panels: vec![
            ChartPanel { y: axis("x", "m"), lines: both, steps: false },
            ChartPanel { y: axis("speed", "m/s"), lines: speeds, steps: false },
            ChartPanel { y: axis("contacts", ""), lines: contacts, steps: true },
        ],
    };
    keep("chart-5", &chart_svg(&chart, &ChartStyle::default()), 400);
    keep("chart-5-large", &chart_svg(&chart, &ChartStyle::default()), 1000);
    keep(
        "chart-5-dark",
        &chart_svg(&chart, &ChartStyle { theme: Theme::Dark, ..ChartStyle::default() }),
        600,
    );
}

#[test]
fn charts_of_many() {
    let axis = |label: &str, unit: &str| Axis { label: label.into(), unit: unit.into() };
    let of = |f: &dyn Fn(f64, f64) -> f64| -> Vec<Line> {
        (0..150)
            .map(|k| {
                let r = f64::from(k) * 0.618 % 1.0;
                let points = (0..500).map(|j| (f64::from(j) * 0.02, f(f64::from(j) * 0.02, r))).collect();
                Line { name: k.to_string(), points, group: k as usize, dashed: false }
            })
            .collect()
    };
    let squeeze = of(&|t, r| (2500.0 * r * (t * 2.0 + 9.0 * r).sin()).max(0.0) * (1.0 - (-t).exp()));
    let x = of(&|t, r| 4.0 * r + t * (0.2 + 0.5 * (r * 37.0 % 1.0)));
    let contacts = of(&|t, r| (2.0 + 2.0 * r + 2.0 * (t + 20.0 * r).sin()).floor().max(0.0));
    let chart = Chart {
        noun: "agent".into(),
        x: axis("time", "s"),
        panels: vec![
            ChartPanel { y: axis("x", "m"), lines: x, steps: false },
            ChartPanel { y: axis("squeeze", "N"), lines: squeeze, steps: false },
            ChartPanel { y: axis("contacts", ""), lines: contacts, steps: true },
        ],
    };
    let text = chart_svg(&chart, &ChartStyle::default());
    eprintln!("chart of 150: {} bytes", text.len());
    keep("chart-150", &text, 400);
    keep("chart-150-large", &text, 1000);
    keep(
        "chart-150-dark",
        &chart_svg(&chart, &ChartStyle { theme: Theme::Dark, ..ChartStyle::default() }),
        800,
    );
    let alone = Chart { panels: chart.panels[..1].to_vec(), ..chart.clone() };
    keep("chart-alone", &chart_svg(&alone, &ChartStyle::default()), 400);
}

#[test]
fn density() {
    let Some(t) = shared("crowds/dense_100") else { return };
    let mut scene = Scene::at_start(&t);
    let mut map = DensityMap::new(scene.extent(), DENSITY_KERNEL, &t.geometry.walls);
    map.add(t.dynamics.iter().map(|d| d.position));
    scene.density = Some(map);
    let text = svg(&scene, &Style { time: Some(0.0), ..Style::default() });
    eprintln!("density: {} bytes", text.len());
    keep("density", &text, 800);
    let alone = Style { bodies: Visibility::Hidden, ..dark() };
    show("density-dark", &scene, &alone, 400);
}

#[test]
fn movie() {
    let Some(t) = shared("crowds/dense_100") else { return };
    let mut scene = Scene::at_start(&t);
    scene.view = Some(scene.extent());
    let start = scene.poses.clone();
    let frames = 30;
    for (name, format) in [("movie.apng", AnimationFormat::Apng), ("movie.gif", AnimationFormat::Gif)] {
        let begun = std::time::Instant::now();
        let mut file = std::io::BufWriter::new(std::fs::File::create(path(name)).unwrap());
        let mut movie = Animation::new(&mut file, format, 25.0, frames).unwrap();
        for k in 0..frames {
            let s = f64::from(k) / 25.0;
            for (pose, from) in scene.poses.iter_mut().zip(&start) {
                pose.position = from.position + vec2(0.05 * (from.position.y * 3.0 + s * 6.0).sin(), 0.0);
                pose.orientation = from.orientation + 0.2 * s;
            }
            let values = Values { range: Some((0.0, 1.0)), ..speeds(&t, s) };
            let style = Style { time: Some(s), fill: Fill::Values(values), ..Style::default() };
            movie.add(&pixels(&svg(&scene, &style), 400).unwrap()).unwrap();
        }
        movie.finish().unwrap();
        drop(file);
        let size = std::fs::metadata(path(name)).unwrap().len();
        eprintln!("{name}: {frames} frames, {size} bytes, {:?}", begun.elapsed());
    }
}

#[test]
fn one_disk_far_from_the_rest() {
    let disk = Shape { radius: 0.2, material_id: String::new(), position: vec2(3.0, 0.0) };
    let t = trial(vec![(agent("x", vec![disk]), Vec2::ZERO, 0.0)], vec![]);
    show("disk", &Scene::at_start(&t), &Style { ids: Visibility::Shown, ..Style::default() }, 400);
}
