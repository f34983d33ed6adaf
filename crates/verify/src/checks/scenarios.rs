//! The eight scenarios of the paper's section 4.2, each through the packed FMU and the C entry point. Each is compared
//! with the quantity that it demonstrates.

use crate::checks::error::{Error, Result};
use crate::checks::interfaces::{Motions, through_files, through_fmu};
use crate::checks::{Check, Oscillator, apart, largest};
use crowd_mechanics::setup;
use include_dir::{Dir, include_dir};
use lemons_core::plane::{Vec2, vec2};
use lemons_core::trial::{Trial, stiffness};

static SCENARIOS: Dir = include_dir!("$CARGO_MANIFEST_DIR/../../tests/scenarios");

pub(crate) const CHECKS: &[Check] = &[
    Check::new("agent pushes agent: velocities after", "damped oscillator", "m/s", 1e-4, || {
        scenario("push_agent_agent", 20, push_agent_agent)
    }),
    Check::new("agent meets wall: velocity after", "damped oscillator", "m/s", 1e-4, || {
        scenario("push_agent_wall", 20, push_agent_wall)
    }),
    Check::new("agent slides over agent: v, ω R after", "own integrator, dt 1e-7 s", "m/s", 1e-4, || {
        scenario("slip_agent_agent", 20, two_disks)
    }),
    Check::new("agent slides along wall: v, ω R", "constant force μ |F_n|", "m/s", 1e-4, || {
        scenario("slip_agent_wall", 20, slip_agent_wall)
    }),
    Check::new("translation relaxes: r, v; stops after v₀ τ", "closed form", "SI", 1e-10, || {
        scenario("translation", 20, relaxing)
    }),
    Check::new("rotation relaxes: θ, ω", "closed form", "SI", 1e-10, || scenario("rotation", 20, relaxing)),
    Check::new("agent rolls over agent: v, ω R after", "own integrator, dt 1e-7 s", "m/s", 1e-4, || {
        scenario("rolling_agent_agent", 20, two_disks)
    }),
    Check::new("agent rolls along wall: v, ω R", "damped oscillator of slip", "m/s", 1e-4, || {
        scenario("rolling_agent_wall", 5, rolling_agent_wall)
    }),
    Check::new("all eight: FMU and C entry point apart", "each other", "SI", 1e-12, ways_apart),
];

/// Opens a scenario's Trial, which is on disk as long as the returned directory lives.
pub(crate) fn open(name: &str) -> Result<(tempfile::TempDir, Trial)> {
    let directory = tempfile::tempdir()?;
    let scenario = SCENARIOS.get_dir(name);
    let scenario = scenario.ok_or_else(|| Error::Premise(format!("there is a scenario {name}")))?;
    for part in ["", "static", "dynamic"] {
        std::fs::create_dir_all(directory.path().join(part))?;
    }
    for file in scenario.files().chain(scenario.dirs().flat_map(Dir::files)) {
        let inside = file.path().strip_prefix(name).unwrap_or(file.path());
        std::fs::write(directory.path().join(inside), file.contents())?;
    }
    let (trial, _) = setup::read(directory.path())?;
    Ok((directory, trial))
}

/// The largest of the differences that `difference` finds after `steps` TimeSteps, through both interfaces.
fn scenario(name: &str, steps: u32, difference: fn(&Trial, f64, &Motions) -> f64) -> Result<f64> {
    let (_directory, trial) = open(name)?;
    let time = f64::from(steps) * trial.parameters.time_step;
    let ways = [through_fmu(&trial, None, steps)?, through_files(&trial, steps)?];
    let last = |way: &Vec<Motions>| way.last().map_or(f64::NAN, |motions| difference(&trial, time, motions));
    Ok(largest(ways.iter().map(last)))
}

fn ways_apart() -> Result<f64> {
    let mut worst: f64 = 0.0;
    for name in SCENARIOS.dirs().filter_map(|dir| dir.path().to_str()) {
        let (_directory, trial) = open(name)?;
        let (fmu, files) = (through_fmu(&trial, None, 10)?, through_files(&trial, 10)?);
        let both = fmu.iter().flatten().zip(files.iter().flatten());
        worst = largest([worst, largest(both.map(|(a, b)| apart(a, b)))]);
    }
    Ok(worst)
}

/// k_n, k_t, γ_n, γ_t, μ of the first agent's material with another material.
fn law(trial: &Trial, other: &str) -> [f64; 5] {
    let own = trial.agents[0].shapes[0].material_id.as_str();
    let materials = &trial.materials;
    let find = |id: &str| materials.intrinsic.iter().find(|m| m.id == id);
    let names = [own, other];
    let contact = materials.binary.iter().find(|c| {
        let ids = [c.id1.as_str(), c.id2.as_str()];
        ids == names || ids == [names[1], names[0]]
    });
    match (find(own), find(other), contact) {
        (Some(a), Some(b), Some(c)) => {
            let (kn, kt) = stiffness(a, b);
            [kn, kt, c.gamma_normal, c.gamma_tangential, c.kinetic_friction]
        }
        _ => [f64::NAN; 5],
    }
}

fn push_agent_agent(trial: &Trial, _: f64, after: &Motions) -> f64 {
    let [a, b] = [0, 1].map(|i| trial.agents[i].mass);
    let [kn, _, gamma, ..] = law(trial, "human_naked");
    let e = Oscillator::new(kn, gamma, a * b / (a + b)).restitution();
    let before = trial.dynamics[0].velocity.x;
    let expected = [(a - e * b) / (a + b) * before, (1.0 + e) * a / (a + b) * before];
    largest(after.iter().zip(expected).map(|((_, twist), v)| (twist.velocity - vec2(v, 0.0)).norm()))
}

fn push_agent_wall(trial: &Trial, _: f64, after: &Motions) -> f64 {
    let [kn, _, gamma, ..] = law(trial, "concrete");
    let e = Oscillator::new(kn, gamma, trial.agents[0].mass).restitution();
    (after[0].1.velocity + trial.dynamics[0].velocity * e).norm()
}

fn slip_agent_wall(trial: &Trial, time: f64, after: &Motions) -> f64 {
    let [kn, _, _, _, mu] = law(trial, "concrete");
    let (agent, radius) = (&trial.agents[0], trial.agents[0].shapes[0].radius);
    let pressed = -trial.dynamics[0].fp.y;
    let arm = radius - 0.5 * pressed / kn;
    let velocity = trial.dynamics[0].velocity.x - mu * pressed / agent.mass * time;
    let omega = -mu * pressed * arm / agent.moment_of_inertia * time;
    let twist = after[0].1;
    largest([(twist.velocity.x - velocity).abs(), (twist.angular_velocity - omega).abs() * radius])
}

fn rolling_agent_wall(trial: &Trial, time: f64, after: &Motions) -> f64 {
    // u = v + ω a of the contact point obeys u' = −(1/m + a²/I)(k_t s + γ_t u), s' = u, s(0) = 0.
    let [kn, kt, _, gamma, _] = law(trial, "concrete");
    let (agent, radius) = (&trial.agents[0], trial.agents[0].shapes[0].radius);
    let arm = radius + 0.5 * trial.dynamics[0].fp.y / kn;
    let lightness = 1.0 / agent.mass + arm * arm / agent.moment_of_inertia;
    let before = trial.dynamics[0].velocity.x;
    let slip = Oscillator::new(kt, gamma, 1.0 / lightness).speed(before, time);
    // Both are driven by the same impulse J: v = v₀ − J/m, ω = −J a/I.
    let impulse = (before - slip) / lightness;
    let twist = after[0].1;
    largest([
        (twist.velocity.x - (before - impulse / agent.mass)).abs(),
        (twist.angular_velocity + impulse * arm / agent.moment_of_inertia).abs() * radius,
    ])
}

fn relaxing(trial: &Trial, time: f64, after: &Motions) -> f64 {
    let (agent, start) = (&trial.agents[0], &trial.dynamics[0]);
    let kept = (-agent.floor_damping * time).exp();
    let turning = (-agent.angular_damping * time).exp();
    let (pose, twist) = after[0];
    let stopped_after = start.velocity * ((1.0 - kept) / agent.floor_damping);
    largest([
        (pose.position - start.position - stopped_after).norm(),
        (twist.velocity - start.velocity * kept).norm(),
        (pose.orientation - start.omega * (1.0 - turning) / agent.angular_damping).abs(),
        (twist.angular_velocity - start.omega * turning).abs(),
    ])
}

/// Two one-disk agents without relaxation, by the simplest integrator with steps of 1e-7 s: velocities
/// and rim speeds at the end.
fn two_disks(trial: &Trial, time: f64, after: &Motions) -> f64 {
    let [kn, kt, gn, gt, mu] = law(trial, "human_naked");
    let dt = 1e-7;
    let [a, b] = [0, 1].map(|i| (&trial.agents[i], trial.agents[i].shapes[0].radius));
    let mut r = [trial.dynamics[0].position, trial.dynamics[1].position];
    let mut v = [trial.dynamics[0].velocity, trial.dynamics[1].velocity];
    let mut w = [0.0, 0.0];
    let mut s = 0.0;
    for _ in 0..(time / dt).round() as u64 {
        let between: Vec2 = r[0] - r[1];
        let h = a.1 + b.1 - between.norm();
        if h > 0.0 {
            let n = between * (1.0 / between.norm());
            let t = vec2(-n.y, n.x);
            let arms = [a.1 - 0.5 * h, b.1 - 0.5 * h];
            let relative = v[0] - v[1];
            // The contact point is in direction −n from the first and +n from the second.
            let slip = relative.dot(t) - w[0] * arms[0] - w[1] * arms[1];
            let normal = kn * h - gn * relative.dot(n);
            let mut tangential = -kt * (s + slip * dt) - gt * slip;
            if tangential.abs() > mu * normal.abs() {
                tangential = mu * normal.abs() * tangential.signum();
                s += (-tangential - kt * s) / gt * dt;
            } else {
                s += slip * dt;
            }
            let force = n * normal + t * tangential;
            v[0] += force * (dt / a.0.mass);
            v[1] -= force * (dt / b.0.mass);
            w[0] -= arms[0] * tangential / a.0.moment_of_inertia * dt;
            w[1] -= arms[1] * tangential / b.0.moment_of_inertia * dt;
        } else {
            s = 0.0;
        }
        r[0] += v[0] * dt;
        r[1] += v[1] * dt;
    }
    let radii = [a.1, b.1];
    largest((0..2).flat_map(|i| {
        let twist = after[i].1;
        [(twist.velocity - v[i]).norm(), (twist.angular_velocity - w[i]).abs() * radii[i]]
    }))
}
