//! The eight scenarios of the paper's section 4.2, through the packed FMU, each compared with the quantity that it
//! demonstrates.

use crate::checks::two_disks::TwoDisks;
use crate::checks::{Figure, Oscillator, Result, largest};
use anyhow::Context;
use crowd_mechanics::engine::{PairLaw, Wrench};
use crowd_mechanics::pack::Package;
use crowd_mechanics::scenes::motion;
use crowd_mechanics::setup::{self, Setup};
use lemons_core::files::Scratch;
use lemons_core::files::source::Memory;
use lemons_core::plane::{Motion, Vec2, vec2};
use lemons_core::trial::{FileNames, Trial};
use lemons_master::{Fmu, own_binary};
use std::path::Path;

/// Paths and contents of the files of a Trial that is part of this program.
pub(crate) type Files = [(&'static str, &'static [u8])];

/// The [`Files`] of the Trial in a directory of the repository.
macro_rules! files_of {
    ($trial:literal) => {
        files_of!($trial: "Parameters.xml", "static/Agents.xml", "static/Geometry.xml", "static/Materials.xml",
            "dynamic/AgentDynamics.xml")
    };
    ($trial:literal: $($file:literal),*) => {
        &[$(($file, include_bytes!(concat!("../../../../", $trial, "/", $file)).as_slice())),*]
    };
}
#[cfg(feature = "bench")]
pub(crate) use files_of;

const SCENARIOS: [(&str, &Files); 8] = [
    ("push_agent_agent", files_of!("tests/scenarios/push_agent_agent")),
    ("push_agent_wall", files_of!("tests/scenarios/push_agent_wall")),
    ("slip_agent_agent", files_of!("tests/scenarios/slip_agent_agent")),
    ("slip_agent_wall", files_of!("tests/scenarios/slip_agent_wall")),
    ("translation", files_of!("tests/scenarios/translation")),
    ("rotation", files_of!("tests/scenarios/rotation")),
    ("rolling_agent_agent", files_of!("tests/scenarios/rolling_agent_agent")),
    ("rolling_agent_wall", files_of!("tests/scenarios/rolling_agent_wall")),
];

pub(crate) const FIGURES: &[Figure] = &[
    || scenario("push_agent_agent", 20, two_disks),
    || scenario("push_agent_wall", 20, push_agent_wall),
    || scenario("slip_agent_agent", 20, two_disks),
    || scenario("slip_agent_wall", 20, slip_agent_wall),
    || scenario("translation", 20, relaxing),
    || scenario("rotation", 20, relaxing),
    || scenario("rolling_agent_agent", 20, two_disks),
    || scenario("rolling_agent_wall", 5, rolling_agent_wall),
];

/// Reads the Trial of a scenario.
pub(crate) fn open(name: &str) -> Result<Trial> {
    let scenario = SCENARIOS.iter().find(|scenario| scenario.0 == name);
    read(scenario.context("there is no such scenario")?.1)
}

/// Reads a Trial from memory.
pub(crate) fn read(files: &[(&str, &[u8])]) -> Result<Trial> {
    let mut memory = Memory::default();
    files.iter().for_each(|(path, content)| memory.put(Path::new(path), content.to_vec()));
    Ok(setup::read_from(&memory, Path::new(""), &FileNames::default())?.0)
}

/// The difference that `difference` finds after `steps` TimeSteps of the FMU, which is packed and loaded as any master
/// does.
fn scenario(name: &str, steps: u32, difference: fn(&Trial, f64, &[Motion]) -> f64) -> Result<f64> {
    let trial = open(name)?;
    let step = trial.parameters.time_step;
    let directory = Scratch::new()?;
    let (place, path) = (directory.path().join("Trial"), directory.path().join("crowd.fmu"));
    trial.write(&place)?;
    Package { trials: vec![place], binaries: vec![own_binary()?], ..Package::default() }.write(&path)?;
    let fmu = Fmu::open(&path)?;
    let instance = fmu.instantiate("verify")?;
    instance.initialize()?;
    for k in 0..steps {
        instance.step(f64::from(k) * step, step)?;
    }
    let names = ["Position.x", "Position.y", "Theta", "Velocity.x", "Velocity.y", "Omega"];
    let names =
        (0..trial.agents.len()).flat_map(|i| names.iter().map(move |name| format!("agent[{i}].{name}")));
    let variables = instance.select(names)?;
    let values: Vec<f64> = instance.values(&variables)?;
    let after: Vec<Motion> = values.as_chunks().0.iter().map(motion).collect();
    Ok(difference(&trial, f64::from(steps) * step, &after))
}

/// The law of the first agent's material with that of the wall, if there is one, or of the other agent.
fn law(trial: &Trial) -> PairLaw {
    let scene = Setup::of(trial).scene().expect("a scenario is in order");
    let other = scene.faces.first().map_or(scene.disks[scene.disks.len() - 1].material, |face| face.material);
    *scene.law(scene.disks[0].material, other)
}

fn push_agent_wall(trial: &Trial, _: f64, after: &[Motion]) -> f64 {
    let law = law(trial);
    let e = Oscillator::new(law.normal_stiffness, law.normal_damping, trial.agents[0].mass).restitution();
    (after[0].twist.velocity + trial.dynamics[0].velocity * e).norm()
}

fn slip_agent_wall(trial: &Trial, time: f64, after: &[Motion]) -> f64 {
    let PairLaw { normal_stiffness: kn, friction: mu, .. } = law(trial);
    let (agent, radius) = (&trial.agents[0], trial.agents[0].shapes[0].radius);
    let pressed = -trial.dynamics[0].fp.y;
    let arm = radius - 0.5 * pressed / kn;
    let velocity = trial.dynamics[0].velocity.x - mu * pressed / agent.mass * time;
    let omega = -mu * pressed * arm / agent.moment_of_inertia * time;
    let twist = after[0].twist;
    largest([(twist.velocity.x - velocity).abs(), (twist.angular_velocity - omega).abs() * radius])
}

fn rolling_agent_wall(trial: &Trial, time: f64, after: &[Motion]) -> f64 {
    // u = v + ω a of the contact point obeys u' = −(1/m + a²/I)(k_t s + γ_t u), s' = u, s(0) = 0.
    let law = law(trial);
    let (agent, radius) = (&trial.agents[0], trial.agents[0].shapes[0].radius);
    let arm = radius + 0.5 * trial.dynamics[0].fp.y / law.normal_stiffness;
    let lightness = 1.0 / agent.mass + arm * arm / agent.moment_of_inertia;
    let before = trial.dynamics[0].velocity.x;
    let slip = Oscillator::new(law.tangential_stiffness, law.tangential_damping, 1.0 / lightness)
        .speed(before, time);
    // Both are driven by the same impulse J: v = v₀ − J/m, ω = −J a/I.
    let impulse = (before - slip) / lightness;
    let twist = after[0].twist;
    largest([
        (twist.velocity.x - (before - impulse / agent.mass)).abs(),
        (twist.angular_velocity + impulse * arm / agent.moment_of_inertia).abs() * radius,
    ])
}

fn relaxing(trial: &Trial, time: f64, after: &[Motion]) -> f64 {
    let (agent, start) = (&trial.agents[0], &trial.dynamics[0]);
    let kept = (-agent.floor_damping * time).exp();
    let turning = (-agent.angular_damping * time).exp();
    let Motion { pose, twist } = after[0];
    let stopped_after = start.velocity * ((1.0 - kept) / agent.floor_damping);
    largest([
        (pose.position - start.position - stopped_after).norm(),
        (twist.velocity - start.velocity * kept).norm(),
        (pose.orientation - start.omega * (1.0 - turning) / agent.angular_damping).abs(),
        (twist.angular_velocity - start.omega * turning).abs(),
    ])
}

/// Two one-disk agents without relaxation, by another integrator with steps of 1e-7 s: velocities and rim speeds at the
/// end.
fn two_disks(trial: &Trial, time: f64, after: &[Motion]) -> f64 {
    let agents = [&trial.agents[0], &trial.agents[1]];
    let [first, second] = [0, 1].map(|i| trial.dynamics[i].motion());
    let disks = TwoDisks {
        masses: agents.map(|agent| agent.mass),
        inertias: agents.map(|agent| agent.moment_of_inertia),
        radii: agents.map(|agent| agent.shapes[0].radius),
        law: law(trial),
        drive_rates: [Wrench::default(); 2],
        relaxation_rate: 0.0,
    };
    let place = first.pose.position - second.pose.position;
    let velocity = first.twist.velocity - second.twist.velocity;
    let steps = (time / 1e-7).round() as u32;
    let start = [place.x, place.y, velocity.x, velocity.y, 0.0, 0.0, 0.0];
    let [_, _, vx, vy, w1, w2, _] = disks.after(start, steps, 1e-7);
    // The momentum stays.
    let [m1, m2] = disks.masses;
    let mean = (first.twist.velocity * m1 + second.twist.velocity * m2) * (1.0 / (m1 + m2));
    let velocities: [Vec2; 2] = [m2, -m1].map(|mass| mean + vec2(vx, vy) * (mass / (m1 + m2)));
    largest([w1, w2].into_iter().enumerate().flat_map(|(i, omega)| {
        let twist = after[i].twist;
        let rim = (twist.angular_velocity - omega).abs() * disks.radii[i];
        [(twist.velocity - velocities[i]).norm(), rim]
    }))
}
