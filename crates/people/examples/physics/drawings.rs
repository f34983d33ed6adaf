//! The drawings of the page.

use crate::cases::*;
use lemons_people::Shape;
use lemons_picture::{
    Axis, Chart, ChartPanel, ChartStyle, Colour, Fill, Line, Mark, Note, Panel, Scene, SheetStyle, Side,
    Style, View, Visibility, chart_svg, sheet, svg,
};
use lemons_plane::{Disk, Rotation, Vec2, vec2};
use lemons_trial::{Geometry, Trial, Wall};

/// Paler than usual, so that marks and words stand out.
const PALE: Colour = Colour(0xd3, 0xe3, 0xf3);
/// \[px\] Width of the drawings.
const WIDTH: f64 = 760.0;
/// Colours of the series: blue, orange, green.
const BLUE: usize = 0;
const ORANGE: usize = 1;
const GREEN: usize = 2;

/// Returns all drawings, with the names of their files.
pub fn all() -> Result<Vec<(&'static str, String)>> {
    Ok(vec![
        ("physics_body.svg", body()?),
        ("physics_contact.svg", contact()?),
        ("physics_law.svg", law()?),
        ("physics_collision.svg", forces()?),
        ("physics_speed.svg", speed()?),
        ("physics_step.svg", step()?),
        ("physics_shortlist.svg", shortlist()?),
    ])
}

fn plain() -> Style {
    Style {
        width: WIDTH,
        fill: Fill::Single(PALE),
        scale_bar: Visibility::Hidden,
        orientation: Visibility::Hidden,
        ..Style::default()
    }
}

fn view(left: f64, low: f64, right: f64, high: f64) -> Option<View> {
    Some(View { low: vec2(left, low), high: vec2(right, high) })
}

fn words(x: f64, y: f64, side: Side, text: &str) -> Note {
    Mark::words(vec2(x, y), side, text).note()
}

fn arrow(from: Vec2, to: Vec2) -> Note {
    Mark::Arrow { from, to }.note()
}

fn length(from: Vec2, to: Vec2) -> Note {
    Mark::Length { from, to }.note()
}

fn line(points: &[Vec2]) -> Note {
    Mark::Line(points.to_vec()).note()
}

/// Scenes beside and below each other.
fn panels(scenes: &[Scene], columns: usize, style: Style) -> String {
    let panels: Vec<Panel> = scenes.iter().map(|scene| Panel { scene, time: None, fill: None }).collect();
    sheet(&panels, columns, &SheetStyle { style, letters: Visibility::Shown })
}

/// Bodies of one disk each.
fn disks(disks: &[Disk], wall: &[Vec2]) -> Result<Trial> {
    let mut trial = nobody()?;
    let template = trial_of_one()?.agents.remove(0);
    for (id, disk) in disks.iter().enumerate() {
        let mut agent = lemons_trial::Agent { id: id.to_string(), ..template.clone() };
        agent.shapes.truncate(1);
        agent.shapes[0] =
            lemons_trial::Shape { radius: disk.radius, position: Vec2::ZERO, ..agent.shapes[0].clone() };
        trial.agents.push(agent);
        let mut dynamics = trial_of_one()?.dynamics.remove(0);
        dynamics.position = disk.centre;
        trial.dynamics.push(dynamics);
    }
    if !wall.is_empty() {
        let wall = Wall { id: "0".into(), material_id: "concrete".into(), corners: wall.to_vec() };
        trial.geometry = Geometry { dimensions: None, walls: vec![wall] };
    }
    Ok(trial)
}

fn trial_of_one() -> Result<Trial> {
    trial(&[(at(0.0, 0.0, 0.0), Vec2::ZERO)], &[], FLOOR)
}

fn nobody() -> Result<Trial> {
    let mut trial = trial_of_one()?;
    trial.agents.clear();
    trial.dynamics.clear();
    Ok(trial)
}

/// Section 1: the five disks, and where a body is.
fn body() -> Result<String> {
    let shape = Shape::of(&person())?;
    let turned = 0.6;
    let trials = [0.0, turned].map(|angle| trial(&[(at(0.0, 0.0, angle), Vec2::ZERO)], &[], FLOOR));
    let [straight, oblique] = trials;
    let (straight, oblique) = (straight?, oblique?);
    let mut first = Scene::at_start(&straight);
    first.view = view(-0.4, -0.37, 0.4, 0.34);
    for (k, disk) in shape.disks.iter().enumerate() {
        first.notes.push(Mark::Circle { centre: disk.centre, radius: disk.radius }.note().in_series(BLUE));
        first.notes.push(Mark::Dot(disk.centre).note().in_series(BLUE));
        let side = if k == 2 { Side::Left } else { Side::Right };
        first.notes.push(words(disk.centre.x, disk.centre.y, side, &(k + 1).to_string()).in_series(BLUE));
    }
    let (breadth, depth) = (shape.breadth(), shape.depth());
    let front = shape.disks[2].centre.x + shape.disks[2].radius;
    let aside = -0.21;
    for y in [-0.5 * breadth, 0.5 * breadth] {
        first.notes.push(line(&[vec2(aside - 0.02, y), vec2(shape.disks[0].centre.x, y)]).dashed());
    }
    first.notes.push(length(vec2(aside, -0.5 * breadth), vec2(aside, 0.5 * breadth)));
    first.notes.push(words(aside, 0.0, Side::Left, "breadth\n49 cm"));
    let below = -0.30;
    for x in [front - depth, front] {
        first.notes.push(line(&[vec2(x, below - 0.02), vec2(x, shape.disks[2].centre.y)]).dashed());
    }
    first.notes.push(length(vec2(front - depth, below), vec2(front, below)));
    first.notes.push(words(0.5 * (2.0 * front - depth), below, Side::Below, "depth 25 cm"));
    first.notes.push(words(0.145, 0.2, Side::Right, "left shoulder"));
    first.notes.push(words(0.145, -0.2, Side::Right, "right shoulder"));

    let mut second = Scene::at_start(&oblique);
    second.view = first.view;
    let turn = Rotation::by(turned);
    let on_body = |p: Vec2| p.rotated(turn);
    let shoulder = on_body(shape.disks[0].centre);
    second.notes = vec![
        line(&[vec2(0.0, 0.0), vec2(0.35, 0.0)]).dashed(),
        words(0.35, 0.0, Side::Below, "x axis"),
        arrow(Vec2::ZERO, on_body(vec2(0.33, 0.0))).in_series(ORANGE),
        words(on_body(vec2(0.33, 0.0)).x, on_body(vec2(0.33, 0.0)).y, Side::Above, "gaze").in_series(ORANGE),
        Mark::Angle { centre: Vec2::ZERO, radius: 0.24, from: 0.0, to: turned }.note(),
        words(0.235, 0.065, Side::Right, "θ"),
        line(&[on_body(shape.disks[0].centre), on_body(shape.disks[4].centre)]).dashed(),
        arrow(Vec2::ZERO, shoulder).in_series(BLUE),
        words(shoulder.x, shoulder.y + 0.09, Side::Above, "offset of disk 1").in_series(BLUE),
        Mark::Angle { centre: Vec2::ZERO, radius: 0.1, from: 3.4, to: 4.5 }.note().in_series(GREEN),
        words(-0.085, -0.085, Side::Left, "ω").in_series(GREEN),
        Mark::Dot(Vec2::ZERO).note(),
        words(0.0, -0.012, Side::Below, "G"),
    ];
    Ok(panels(&[first, second], 2, plain()))
}

/// Section 2: what a contact is.
fn contact() -> Result<String> {
    let one = |radius: f64, x: f64, y: f64| Disk { radius, centre: vec2(x, y) };
    let seen = view(-0.34, -0.23, 0.34, 0.23);
    // Overlap, radii and contact point. The receiver i is the left one.
    let (i, j) = (one(0.17, -0.14, 0.0), one(0.14, 0.12, 0.0));
    let depth = i.radius + j.radius - (j.centre.x - i.centre.x);
    let point = i.centre.x + i.radius - 0.5 * depth;
    let edges = [j.centre.x - j.radius, i.centre.x + i.radius];
    let outlines = |disks: &[Disk]| -> Vec<Note> {
        disks.iter().map(|d| Mark::Circle { centre: d.centre, radius: d.radius }.note()).collect()
    };
    let pair = disks(&[i, j], &[])?;
    let mut geometry = Scene::at_start(&pair);
    geometry.view = seen;
    geometry.notes = outlines(&[i, j]);
    let up = 0.19;
    for x in edges {
        geometry.notes.push(line(&[vec2(x, 0.0), vec2(x, up + 0.015)]).dashed());
    }
    let rim = |disk: &Disk, angle: f64| disk.centre + vec2(disk.radius, 0.0).rotated(Rotation::by(angle));
    geometry.notes.extend([
        length(vec2(edges[0], up), vec2(edges[1], up)),
        words(edges[1] + 0.04, up, Side::Right, "overlap h"),
        line(&[i.centre, j.centre]).dashed(),
        arrow(i.centre, rim(&i, 3.9)),
        words(-0.225, -0.05, Side::Left, "R_i"),
        arrow(j.centre, rim(&j, -0.75)),
        words(0.185, -0.04, Side::Right, "R_j"),
        Mark::Dot(i.centre).note(),
        Mark::Dot(j.centre).note(),
        arrow(vec2(point, 0.0), vec2(point - 0.085, 0.0)).in_series(ORANGE),
        words(point - 0.06, 0.0, Side::Above, "n").in_series(ORANGE),
        Mark::Dot(vec2(point, 0.0)).note(),
        words(point, -0.01, Side::Below, "C"),
        words(i.centre.x - 0.04, 0.01, Side::Above, "i"),
        words(j.centre.x + 0.03, 0.01, Side::Above, "j"),
    ]);

    // The velocity of i at C, seen from j.
    let c = vec2(point, 0.0);
    let (along, aside) = (vec2(0.13, 0.0), vec2(0.0, 0.09));
    let mut velocity = Scene::at_start(&pair);
    velocity.view = seen;
    velocity.notes = outlines(&[i, j]);
    velocity.notes.extend([
        arrow(c, c + along).in_series(ORANGE),
        words(c.x + 0.09, 0.0, Side::Below, "v_n n").in_series(ORANGE),
        arrow(c, c + aside).in_series(GREEN),
        words(c.x, aside.y - 0.015, Side::Left, "v_t").in_series(GREEN),
        line(&[c + along, c + along + aside]).dashed(),
        line(&[c + aside, c + along + aside]).dashed(),
        arrow(c, c + along + aside),
        words(c.x + along.x, aside.y, Side::Right, "v"),
        Mark::Dot(c).note(),
        words(c.x, -0.01, Side::Below, "C"),
        words(i.centre.x - 0.08, -0.09, Side::On, "i"),
        words(j.centre.x + 0.07, -0.07, Side::On, "j"),
        words(0.0, 0.2, Side::On, "v: of i at C, seen from j"),
    ]);

    let mut forces = Scene::at_start(&pair);
    forces.view = seen;
    forces.notes = outlines(&[i, j]);
    forces.notes.extend([
        arrow(c, c + vec2(-0.15, 0.0)).in_series(ORANGE),
        words(c.x - 0.1, 0.0, Side::Above, "F_n").in_series(ORANGE),
        arrow(c, c - vec2(0.0, 0.1)).in_series(GREEN),
        words(c.x, -0.08, Side::Left, "F_t").in_series(GREEN),
        arrow(c, c + vec2(0.15, 0.0)).in_series(ORANGE).dashed(),
        words(c.x + 0.1, 0.0, Side::Above, "-F_n").in_series(ORANGE),
        arrow(c, c + vec2(0.0, 0.1)).in_series(GREEN).dashed(),
        words(c.x, 0.08, Side::Right, "-F_t").in_series(GREEN),
        Mark::Dot(c).note(),
        words(i.centre.x - 0.08, -0.09, Side::On, "i"),
        words(j.centre.x + 0.07, -0.07, Side::On, "j"),
        words(-0.3, 0.2, Side::Right, "on i: solid"),
        words(0.08, 0.2, Side::Right, "on j: dashed"),
    ]);

    // A wall, and its corner.
    let corner = vec2(0.06, 0.04);
    let wall = vec![vec2(corner.x, -0.215), corner, vec2(0.33, corner.y)];
    let (side, edge) = (one(0.1, -0.01, -0.11), one(0.1, 0.01, 0.105));
    let touching = disks(&[side, edge], &wall)?;
    let mut walls = Scene::at_start(&touching);
    walls.view = seen;
    walls.notes = outlines(&[side, edge]);
    walls.notes.push(line(&[vec2(corner.x, -0.2), corner, vec2(0.15, corner.y)]).dashed());
    for disk in [side, edge] {
        let nearest = if disk == side { vec2(corner.x, disk.centre.y) } else { corner };
        let away = disk.centre - nearest;
        let n = away * (1.0 / away.norm());
        let c = nearest - n * (0.5 * (disk.radius - away.norm()));
        walls.notes.extend([
            line(&[disk.centre, nearest]).dashed(),
            Mark::Dot(disk.centre).note(),
            arrow(c, c + n * 0.06).in_series(ORANGE),
            Mark::Dot(c).note(),
        ]);
        let (beside, name) =
            if disk == side { (vec2(0.035, 0.0), "side") } else { (vec2(0.03, -0.02), "corner") };
        let at = c + n * 0.06 + beside;
        walls.notes.push(words(at.x, at.y, Side::Above, "n").in_series(ORANGE));
        walls.notes.push(words(disk.centre.x - disk.radius, disk.centre.y, Side::Left, name));
    }
    let (low, rim) = (-0.222, side.centre.x + side.radius);
    walls.notes.push(line(&[vec2(rim, side.centre.y), vec2(rim, low)]).dashed());
    walls.notes.push(length(vec2(corner.x, low), vec2(rim, low)));
    walls.notes.push(words(rim + 0.035, low, Side::Right, "h"));
    walls.notes.push(words(rim, side.centre.y, Side::Right, "C"));
    walls.notes.push(words(0.25, corner.y, Side::Below, "wall"));
    Ok(panels(&[geometry, velocity, forces, walls], 2, plain()))
}

/// A spring from one point to another, on a horizontal line.
fn spring(from: Vec2, to: Vec2) -> Note {
    let (turns, part) = (5, 0.2);
    let along = to - from;
    let mut points = vec![from, from + along * part];
    for k in 0..2 * turns {
        let share = part + (1.0 - 2.0 * part) * (f64::from(k) + 0.5) / f64::from(2 * turns);
        let up = if k % 2 == 0 { 0.13 } else { -0.13 };
        points.push(from + along * share + vec2(0.0, up));
    }
    points.extend([from + along * (1.0 - part), to]);
    line(&points)
}

/// A damper: a piston in a cylinder.
fn damper(from: Vec2, to: Vec2) -> Vec<Note> {
    let along = to - from;
    let (back, open, piston) = (from + along * 0.35, from + along * 0.65, from + along * 0.5);
    let up = vec2(0.0, 0.15);
    vec![
        line(&[from, back]),
        line(&[open + up, back + up, back - up, open - up]),
        line(&[piston + up * 0.8, piston - up * 0.8]),
        line(&[piston, to]),
    ]
}

/// Section 3: the elements of the law.
fn law() -> Result<String> {
    let empty = nobody()?;
    let seen = view(-0.1, 0.0, 4.1, 2.15);
    let plate = |x: f64| line(&[vec2(x, 0.1), vec2(x, 1.7)]);
    let mut normal = Scene::at_start(&empty);
    normal.view = seen;
    let (left, right) = (0.5, 3.5);
    normal.notes = vec![
        words(2.0, 2.0, Side::On, "normal"),
        plate(left),
        plate(right),
        words(left, 0.9, Side::Left, "i"),
        words(right, 0.9, Side::Right, "j"),
        spring(vec2(left, 1.35), vec2(right, 1.35)).in_series(BLUE),
        words(2.0, 1.5, Side::Above, "spring k_n").in_series(BLUE),
        words(2.0, 0.3, Side::Below, "damper γ_n").in_series(ORANGE),
    ];
    normal
        .notes
        .extend(damper(vec2(left, 0.5), vec2(right, 0.5)).into_iter().map(|note| note.in_series(ORANGE)));

    let mut tangential = Scene::at_start(&empty);
    tangential.view = seen;
    let joint = 2.5;
    tangential.notes = vec![
        words(2.0, 2.0, Side::On, "tangential"),
        plate(left),
        plate(right),
        words(left, 0.9, Side::Left, "i"),
        words(right, 0.9, Side::Right, "j"),
        spring(vec2(left, 1.35), vec2(joint, 1.35)).in_series(BLUE),
        words(0.5 * (left + joint), 1.5, Side::Above, "spring k_t").in_series(BLUE),
        words(0.5 * (left + joint), 0.3, Side::Below, "damper γ_t").in_series(ORANGE),
        line(&[vec2(joint, 0.5), vec2(joint, 1.35)]),
        // A block on a table.
        line(&[vec2(joint, 0.93), vec2(2.75, 0.93)]).in_series(GREEN),
        line(&[vec2(2.75, 0.83), vec2(2.75, 1.03), vec2(3.05, 1.03), vec2(3.05, 0.83)]).in_series(GREEN),
        line(&[vec2(2.68, 0.83), vec2(3.28, 0.83), vec2(3.28, 0.93), vec2(right, 0.93)]).in_series(GREEN),
        words(3.0, 0.78, Side::Below, "slider μ").in_series(GREEN),
    ];
    tangential
        .notes
        .extend(damper(vec2(left, 0.5), vec2(joint, 0.5)).into_iter().map(|note| note.in_series(ORANGE)));
    Ok(panels(&[normal, tangential], 2, plain()))
}

fn axis(label: &str, unit: &str) -> Axis {
    Axis { label: label.into(), unit: unit.into() }
}

fn curve(group: usize, name: &str, points: Vec<(f64, f64)>) -> Line {
    Line { name: name.into(), points, group, dashed: false }
}

/// Section 3: the forces of a collision.
fn forces() -> Result<String> {
    let trial = trial_of_one()?;
    let skin = trial.materials.intrinsic.iter().find(|m| m.id == "human_naked").ok_or("human_naked")?;
    let law = trial.materials.binary.iter().find(|c| c.id1 == skin.id && c.id2 == skin.id);
    let (stiffness, damping) =
        (lemons_trial::stiffness(skin, skin).0, law.ok_or("its contact")?.gamma_normal);
    let found = collision()?;
    let of = |value: &dyn Fn(&Instant) -> f64| -> Vec<(f64, f64)> {
        found.instants.iter().map(|now| (1e3 * now.time, 1e-3 * value(now))).collect()
    };
    let lines = vec![
        curve(BLUE, "spring", of(&|now| stiffness * now.depth)),
        curve(ORANGE, "damper", of(&|now| -damping * now.normal_speed)),
        curve(GREEN, "sum", of(&|now| now.force)),
    ];
    let overlap = found.instants.iter().map(|now| (1e3 * now.time, 1e3 * now.depth)).collect();
    let chart = Chart {
        x: axis("time since they touch", "ms"),
        panels: vec![
            ChartPanel { y: axis("normal force", "kN"), lines, steps: false },
            ChartPanel { y: axis("overlap", "mm"), lines: vec![curve(6, "h", overlap)], steps: false },
        ],
        noun: String::new(),
    };
    Ok(chart_svg(&chart, &ChartStyle { width: WIDTH, ..ChartStyle::default() }))
}

/// Section 4: floor and drive.
fn speed() -> Result<String> {
    let speeds = pushed()?;
    let drive: Vec<(f64, f64)> =
        vec![(0.0, PUSH.0), (PUSH.1, PUSH.0), (PUSH.1, 0.0), (speeds.last().ok_or("no speed")?.0, 0.0)];
    let chart = Chart {
        x: axis("time", "s"),
        panels: vec![
            ChartPanel { y: axis("drive", "N"), lines: vec![curve(ORANGE, "", drive)], steps: false },
            ChartPanel { y: axis("speed", "m/s"), lines: vec![curve(BLUE, "", speeds)], steps: false },
        ],
        noun: String::new(),
    };
    Ok(chart_svg(&chart, &ChartStyle { width: WIDTH, aspect: Some(0.18), ..ChartStyle::default() }))
}

/// Section 4: communication step and mechanical steps.
fn step() -> Result<String> {
    let empty = nobody()?;
    let mut scene = Scene::at_start(&empty);
    scene.view = view(0.0, -0.35, 12.0, 5.4);
    let notes = &mut scene.notes;
    // Communication steps.
    let upper = 4.1;
    notes.push(arrow(vec2(0.4, upper), vec2(11.8, upper)));
    notes.push(words(11.7, upper, Side::Below, "time"));
    let (start, step) = (1.2, 4.1);
    for k in 0..=18 {
        let x = start + step * f64::from(k) / 9.0;
        let tall = if k % 9 == 0 { 0.2 } else { 0.09 };
        notes.push(line(&[vec2(x, upper - tall), vec2(x, upper + tall)]));
    }
    for (k, name) in ["t", "t + H", "t + 2H"].iter().enumerate() {
        let x = start + step * k as f64;
        notes.push(arrow(vec2(x - 0.12, upper + 0.85), vec2(x - 0.12, upper + 0.25)).in_series(ORANGE));
        notes.push(arrow(vec2(x + 0.12, upper + 0.25), vec2(x + 0.12, upper + 0.85)).in_series(BLUE));
        notes.push(words(x - 0.12, upper + 0.85, Side::Above, "drive in").in_series(ORANGE));
        notes.push(words(x + 0.12, upper + 0.55, Side::Right, "poses,\nsqueeze out").in_series(BLUE));
        notes.push(words(x, upper - 0.2, Side::Below, name));
    }
    // One mechanical step.
    let lower = 1.25;
    let (from, to) = (2.2, 9.4);
    let small = start + step * 3.0 / 9.0;
    for (above, below) in [(small, from), (small + step / 9.0, to)] {
        notes.push(line(&[vec2(above, upper - 0.12), vec2(below, lower + 0.9)]).dashed());
    }
    notes.push(line(&[vec2(0.8, lower), vec2(10.8, lower)]));
    for (x, name) in [(from, "forces\nat this instant"), (to, "forces\nat this instant")] {
        notes.push(Mark::Dot(vec2(x, lower)).note().in_series(GREEN));
        notes.push(line(&[vec2(x, lower - 0.18), vec2(x, lower + 0.18)]).in_series(GREEN));
        notes.push(words(x, lower - 0.15, Side::Below, name).in_series(GREEN));
    }
    notes.push(arrow(vec2(from, lower + 0.35), vec2(from + 1.3, lower + 0.35)).in_series(GREEN));
    notes.push(words(from + 0.65, lower + 0.35, Side::Above, "half kick").in_series(GREEN));
    notes.push(arrow(vec2(from + 1.5, lower + 0.35), vec2(to - 1.5, lower + 0.35)));
    notes.push(words(0.5 * (from + to), lower + 0.35, Side::Above, "free flight, exact"));
    notes.push(arrow(vec2(to - 1.3, lower + 0.35), vec2(to, lower + 0.35)).in_series(GREEN));
    notes.push(words(to - 0.65, lower + 0.35, Side::Above, "half kick").in_series(GREEN));
    notes.push(length(vec2(from, lower - 1.4), vec2(to, lower - 1.4)));
    notes.push(words(0.5 * (from + to), lower - 1.4, Side::Above, "mechanical step dt"));
    Ok(svg(&scene, &plain()))
}

/// Section 5: swept circles.
fn shortlist() -> Result<String> {
    let trial = passage()?;
    let mut scene = Scene::at_start(&trial);
    scene.view = view(-0.05, -0.05, PASSAGE.x + 0.05, PASSAGE.y + 0.05);
    for walker in walkers(&trial)? {
        let series = if walker.free { GREEN } else { ORANGE };
        let circle = Mark::Circle { centre: walker.centre, radius: walker.radius }.note().in_series(series);
        scene.notes.push(if walker.free { circle } else { circle.dashed() });
        let from = walker.pose.position;
        scene.notes.push(arrow(from, from + walker.velocity * STEP).in_series(series));
    }
    scene.notes.push(words(0.12, 0.35, Side::Right, "solid:\nflies").in_series(GREEN));
    scene.notes.push(words(2.3, 0.35, Side::Right, "dashed:\nmechanical steps").in_series(ORANGE));
    Ok(svg(&scene, &Style { scale_bar: Visibility::Shown, ..plain() }))
}
