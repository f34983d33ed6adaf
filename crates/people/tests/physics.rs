//! The numbers and charts of docs/guide/physics.md are those of the engine.
//!
//! `PICTURES=$PWD/docs/guide cargo test -p lemons-people --test physics` makes the charts again.

use crowd_mechanics::engine::World;
use crowd_mechanics::setup::Setup;
use lemons_core::plane::{Pose, Vec2, rotation, vec2};
use lemons_core::trial::{ContactCoefficients, Geometry, Material, Trial, Wall, stiffness};
use lemons_people::{CrowdMember, Person, Sex, Shape, TrialSettings, crowd_trial, paper_materials};
use lemons_picture::{Chart, ChartPanel, ChartStyle, Curve, chart_svg, titled};
use std::f64::consts::PI;
use std::fmt::Write;
use std::path::PathBuf;

/// The person of the page: 49 cm broad, 25 cm deep, 80 kg.
const PERSON: Person = Person { sex: Sex::Male, breadth: 0.49, depth: 0.25, stature: 1.75, mass: 80.0 };
/// \[1/s\] 1/t_transl and 1/t_rot of the shipped Trial.
const FLOOR: f64 = 4.5;
/// \[m/s\] Speed at which two people meet.
const CLOSING: f64 = 1.0;
/// \[N\], \[s\] A push, and how long it lasts.
const PUSH: (f64, f64) = (482.4, 1.2);
/// \[m\], \[rad\], \[m/s\] Where people in a passage are, and in which direction and how fast they walk.
const WALKERS: [(f64, f64, f64, f64); 13] = [
    (0.55, 2.25, 0.0, 1.3),
    (0.70, 1.00, 0.3, 1.1),
    (1.55, 0.36, 0.1, 1.2),
    (1.80, 1.75, -0.2, 1.4),
    (2.75, 2.25, 0.15, 1.2),
    (2.75, 1.10, 0.0, 1.5),
    (3.55, 1.15, PI, 1.3),
    (3.3, 2.05, 0.5, 0.8),
    (4.45, 2.25, 0.1, 1.3),
    (4.60, 1.35, 2.9, 1.2),
    (4.55, 0.45, -0.1, 1.4),
    (5.50, 1.80, -0.2, 1.3),
    (5.55, 0.85, 0.2, 1.1),
];
/// \[m\] The passage.
const PASSAGE: Vec2 = vec2(6.2, 2.7);

/// A Trial of such people at these poses with these velocities \[m/s\], on a floor with this rate \[1/s\].
fn trial(people: &[(Pose, Vec2)], floor: f64) -> Trial {
    let crowd: Vec<(CrowdMember, Pose)> =
        people.iter().map(|(pose, _)| (CrowdMember::Pedestrian(PERSON), *pose)).collect();
    let open = Geometry::default();
    let mut trial = crowd_trial("physics", &crowd, open, &TrialSettings::default()).unwrap();
    for agent in &mut trial.agents {
        (agent.floor_damping, agent.angular_damping) = (floor, floor);
    }
    for (dynamics, (_, velocity)) in trial.dynamics.iter_mut().zip(people) {
        dynamics.velocity = *velocity;
        // Who walks at a steady speed pushes as much as the floor brakes.
        dynamics.fp = *velocity * (PERSON.mass * floor);
    }
    trial
}

fn at(x: f64, y: f64, orientation: f64) -> Pose {
    Pose { position: vec2(x, y), orientation }
}

/// People without clothes: the material, and its contact with itself.
fn skin() -> (Material, ContactCoefficients) {
    let materials = paper_materials();
    let skin = materials.intrinsic.into_iter().find(|m| m.id == "human_naked").unwrap();
    let contact = materials.binary.into_iter().find(|c| c.id1 == skin.id && c.id2 == skin.id).unwrap();
    (skin, contact)
}

/// A head-on collision.
#[derive(Default)]
struct Collision {
    /// \[s\], \[m\] overlap, \[m/s\] normal speed, \[N\] normal force by the engine: while they touch.
    instants: Vec<[f64; 4]>,
    /// \[m/s\] Speed at which they part.
    parting: f64,
    /// \[N\] Peak squeeze.
    peak: f64,
    /// \[m\] Deepest overlap.
    deepest: f64,
}

/// Two people walk into each other, front to front, without a floor. They touch at time zero.
fn collision() -> Collision {
    /// \[s\] Time between two instants.
    const APART: f64 = 1e-5;
    let shape = Shape::of(&PERSON).unwrap();
    let front = shape.disks.iter().map(|disk| disk.centre.x + disk.radius).fold(0.0, f64::max);
    let half = vec2(0.5 * CLOSING, 0.0);
    let trial = trial(&[(at(-front, 0.0, 0.0), half), (at(front, 0.0, PI), -half)], 0.0);
    let mut world = Setup::of(&trial).world().unwrap();
    world.mechanical_step = 1e-6;
    let mut found = Collision::default();
    for k in 1..=1500 {
        world.advance(APART).unwrap();
        if let [contact] = &world.contacts().contacts[..] {
            let time = APART * f64::from(k);
            found.instants.push([time, contact.depth, contact.normal_speed, contact.normal_force]);
        }
        found.peak = found.peak.max(world.exposures()[0].peak_force);
        found.deepest = found.deepest.max(world.largest_overlap());
    }
    let twists = &world.state().twists;
    found.parting = twists[1].velocity.x - twists[0].velocity.x;
    found
}

/// Times \[s\] and speeds \[m/s\] of a person who is alone, and is pushed from rest.
fn pushed() -> Vec<(f64, f64)> {
    let trial = trial(&[(at(0.0, 0.0, 0.0), Vec2::zeros())], FLOOR);
    let mut world = Setup::of(&trial).world().unwrap();
    let mut speeds = vec![(0.0, 0.0)];
    for k in 1..=240 {
        let time = 0.01 * f64::from(k);
        world.drive[0].force.x = if time <= PUSH.1 + 1e-9 { PUSH.0 } else { 0.0 };
        world.advance(0.01).unwrap();
        speeds.push((time, world.state().twists[0].velocity.x));
    }
    speeds
}

fn passage() -> Trial {
    let walker =
        |&(x, y, way, speed): &(f64, f64, f64, f64)| (at(x, y, way), rotation(way) * vec2(speed, 0.0));
    let mut trial = trial(&WALKERS.iter().map(walker).collect::<Vec<_>>(), FLOOR);
    let wall = |y: f64| {
        let corners = vec![vec2(0.0, y), vec2(PASSAGE.x, y)];
        Wall::new(y.to_string(), "concrete", corners)
    };
    trial.geometry = Geometry {
        dimensions: Some(PASSAGE),
        walls: vec![wall(0.0), wall(PASSAGE.y)],
        ..Geometry::default()
    };
    trial
}

/// The numbers of the page as text.
fn numbers() -> Result<String, std::fmt::Error> {
    let mut out = String::new();
    let shape = Shape::of(&PERSON).unwrap();
    writeln!(out, "body of 49 cm × 25 cm, 80 kg")?;
    writeln!(out, "  area                          {:.4} m²", shape.moments().area)?;
    writeln!(out, "  moment of inertia             {:.3} kg m²", shape.inertia(PERSON.mass))?;

    let (skin, contact) = skin();
    let (normal, tangential) = stiffness(&skin, &skin);
    writeln!(out, "two people, human_naked")?;
    let soft = (4.0 * skin.shear_modulus - skin.young_modulus) / (4.0 * skin.shear_modulus.powi(2));
    writeln!(out, "  (4G − E)/(4G²)                {soft:.3e} m/N")?;
    writeln!(out, "  k_n                           {:.3} MN/m", 1e-6 * normal)?;
    writeln!(out, "  k_t                           {:.3} MN/m", 1e-6 * tangential)?;
    let pressed = 200.0;
    let slips = contact.kinetic_friction * pressed;
    writeln!(out, "  pressed with 200 N: overlap   {:.3} mm", 1e3 * pressed / normal)?;
    writeln!(out, "    slips above                 {slips:.0} N")?;
    writeln!(out, "    elongation there            {:.3} mm", 1e3 * slips / tangential)?;

    let found = collision();
    let reduced = 0.5 * PERSON.mass;
    let decay = contact.gamma_normal / (2.0 * reduced);
    let duration = PI / (normal / reduced - decay * decay).sqrt();
    let kept = (-decay * duration).exp();
    let force = CLOSING * (normal * reduced).sqrt();
    let deepest = CLOSING * (reduced / normal).sqrt();
    let lasts = found.instants.last().map_or(f64::NAN, |now| now[0]);
    writeln!(out, "they collide at 1 m/s           formula     engine")?;
    writeln!(out, "  lasts [ms]                    {:<11.2} {:.2}", 1e3 * duration, 1e3 * lasts)?;
    writeln!(out, "  parts at [m/s]                {kept:<11.3} {:.3}", found.parting)?;
    writeln!(out, "  greatest force [kN]           {:<11.2} {:.2}", 1e-3 * force, 1e-3 * found.peak)?;
    writeln!(out, "  deepest overlap [mm]          {:<11.2} {:.2}", 1e3 * deepest, 1e3 * found.deepest)?;

    let speeds = pushed();
    let at = |time: f64| speeds.iter().find(|(t, _)| (*t - time).abs() < 1e-6).map_or(f64::NAN, |p| p.1);
    let end = PUSH.0 / (PERSON.mass * FLOOR);
    let after = |time: f64| end * (1.0 - (-FLOOR * time).exp());
    writeln!(out, "alone, pushed with 482.4 N      formula     engine")?;
    for time in [0.22, 0.5, 1.2] {
        writeln!(out, "  speed after {time:.2} s [m/s]      {:<11.3} {:.3}", after(time), at(time))?;
    }

    let passage = passage();
    let setup = Setup::of(&passage);
    let steps = setup.steps().unwrap();
    writeln!(out, "mechanical step")?;
    writeln!(out, "  stable up to [s]              {:.1e}", steps.stable())?;
    writeln!(out, "  for an accuracy of 1 mm [s]   {:.1e}", steps.accurate_to(1e-3).unwrap())?;
    let mut world: World = setup.world().unwrap();
    world.advance(0.2).unwrap();
    let free = world.work().shortlisted;
    writeln!(out, "in the passage                  {free} of {} people fly", WALKERS.len())?;
    Ok(out)
}

fn panel(label: &str, unit: &str, lines: Vec<Curve>) -> ChartPanel {
    ChartPanel { y: titled(label, unit), lines, steps: false }
}

fn curve(group: usize, name: &str, points: Vec<(f64, f64)>) -> Curve {
    Curve { name: name.into(), points, group, dashed: false }
}

fn chart(time: &str, unit: &str, panels: Vec<ChartPanel>, aspect: Option<f64>) -> String {
    let x = titled(time, unit);
    let style = ChartStyle { width: 760.0, aspect, ..ChartStyle::default() };
    chart_svg(&Chart { x, panels, noun: String::new() }, &style)
}

/// Section 3: the forces of a collision.
fn forces() -> String {
    let (skin, contact) = skin();
    let (stiffness, damping) = (stiffness(&skin, &skin).0, contact.gamma_normal);
    let found = collision();
    let of = |scale: f64, value: &dyn Fn(&[f64; 4]) -> f64| -> Vec<(f64, f64)> {
        found.instants.iter().map(|now| (1e3 * now[0], scale * value(now))).collect()
    };
    let lines = vec![
        curve(0, "spring", of(1e-3, &|[_, depth, ..]| stiffness * depth)),
        curve(1, "damper", of(1e-3, &|[_, _, speed, _]| -damping * speed)),
        curve(2, "sum", of(1e-3, &|[.., force]| *force)),
    ];
    let overlap = vec![curve(6, "h", of(1e3, &|[_, depth, ..]| *depth))];
    let panels = vec![panel("normal force", "kN", lines), panel("overlap", "mm", overlap)];
    chart("time since they touch", "ms", panels, None)
}

/// Section 4: floor and drive.
fn speed() -> String {
    let speeds = pushed();
    let end = speeds.last().unwrap().0;
    let drive = vec![(0.0, PUSH.0), (PUSH.1, PUSH.0), (PUSH.1, 0.0), (end, 0.0)];
    let panels = vec![
        panel("drive", "N", vec![curve(1, "", drive)]),
        panel("speed", "m/s", vec![curve(0, "", speeds)]),
    ];
    chart("time", "s", panels, Some(0.18))
}

fn guide() -> PathBuf {
    lemons_testing::repository().join("docs/guide")
}

#[test]
fn the_page_shows_these_numbers() {
    let page = std::fs::read_to_string(guide().join("physics.md")).unwrap();
    let text = numbers().unwrap();
    assert!(page.contains(&text), "docs/guide/physics.md must contain\n{text}");
}

#[test]
fn the_charts_are_these() {
    for (name, svg) in [("physics_collision.svg", forces()), ("physics_speed.svg", speed())] {
        if let Some(directory) = std::env::var_os("PICTURES") {
            std::fs::write(PathBuf::from(directory).join(name), &svg).unwrap();
        } else {
            let again = "docs/pictures.sh docs physics makes it again";
            assert!(std::fs::read_to_string(guide().join(name)).unwrap() == svg, "{name} differs: {again}");
        }
    }
}
