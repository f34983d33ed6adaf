//! People with legs, who are pushed: a pendulum, and ledgers of impulse and energy in which the ground's force is one entry.

use crate::checks::{Figure, Result, ensure, largest};
use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;
use lemons_core::plane::Motion;
use lemons_core::trial::{Agent, AgentDynamics, Trial};
use lemons_decision::{Decision, DecisionConfig, Plan};

pub(crate) const FIGURES: &[Figure] = &[fall, || Ok(pushed_row()?[0]), || Ok(pushed_row()?[1])];

const MASS: f64 = 80.0;
const STATURE: f64 = 1.75;
/// \[1/s\]
const DAMPING: f64 = 4.5;

/// A world with the Decision of its people, who stand.
struct Standing {
    world: World,
    decision: Decision,
}

impl Standing {
    fn new(people: &[PlacedBody], mechanical_step: f64) -> Result<Standing> {
        let person = |(k, placed): (usize, &PlacedBody)| {
            let agent = Agent::new(k.to_string(), placed.body.mass, placed.body.inertia, [DAMPING; 2]);
            (Agent { height: Some(STATURE), ..agent }, AgentDynamics::default())
        };
        let trial = Trial::of(people.iter().enumerate().map(person), Vec::new(), 0.01);
        let plan = Plan::of(&trial, &DecisionConfig::from_toml("balance = \"pendulum\"")?)?;
        Ok(Standing { world: world(people, &[], BODIES, mechanical_step), decision: Decision::new(plan) })
    }

    /// Drives everybody by the own legs \[N\], and person 0 by a push \[N\], too.
    fn drive(&mut self, push: f64) -> Result<()> {
        let state = self.world.state();
        let seen = |(pose, twist): (&Pose, &Twist)| Motion { pose: *pose, twist: *twist };
        self.decision.see(state.poses.iter().zip(&state.twists).map(seen));
        let acts = self.decision.acts().map_err(|refusal| anyhow::anyhow!("{refusal}"))?;
        for (wrench, act) in self.world.drive.iter_mut().zip(acts) {
            *wrench = Wrench { force: act.drive.force.into(), torque: act.drive.torque };
        }
        self.world.drive[0].force.x += push;
        Ok(())
    }

    fn pass(&mut self, step: f64) -> Result<()> {
        self.decision.pass(step).map_err(|refusal| anyhow::anyhow!("{refusal}"))
    }
}

/// Largest difference of way \[m\] and velocity \[m/s\] of somebody who is hit at 1 m/s, until the step, from an inverted
/// pendulum about the edge of the feet.
fn fall() -> Result<f64> {
    const STEP: f64 = 1e-3;
    let mut one = Standing::new(&[pedestrian(MASS, DAMPING).moving(1.0, 0.0)], 1e-4)?;
    let (rate, edge, mut worst) = ((9.81 / (0.56 * STATURE)).sqrt(), 0.25, 0.0);
    for k in 1..=85 {
        one.drive(0.0)?;
        one.world.advance(STEP)?;
        one.pass(STEP)?;
        let (sinh, cosh) = (libm::sinh(rate * STEP * f64::from(k)), libm::cosh(rate * STEP * f64::from(k)));
        let (x, v) = (edge - edge * cosh + sinh / rate, -edge * rate * sinh + cosh);
        let state = one.world.state();
        let apart = [state.poses[0].position.x - x, state.twists[0].velocity.x - v];
        worst = largest([worst, apart[0].abs(), apart[1].abs()]);
    }
    Ok(worst)
}

/// Ledgers of five in a row, of whom the first is pushed with 1800 N for 0.2 s: what is missing of the impulse of push, legs and
/// floor in the momentum, by the impulse of the push; and the energy that contacts have made, by the work that the push would
/// do on a free body.
fn pushed_row() -> Result<[f64; 2]> {
    const PUSH: f64 = 1800.0;
    let people: Vec<PlacedBody> =
        (0..5).map(|k| pedestrian(MASS, DAMPING).at(0.32 * f64::from(k), 0.0)).collect();
    let mut row = Standing::new(&people, 1e-5)?;
    let [mut impulse, mut work, mut made] = [0.0; 3];
    for k in 0..150 {
        row.drive(if k < 20 { PUSH } else { 0.0 })?;
        for _ in 0..100 {
            let before = row.world.state().clone();
            row.world.advance(1e-4)?;
            let after = row.world.state();
            for (i, drive) in row.world.drive.iter().enumerate() {
                let moved = after.poses[i].position - before.poses[i].position;
                let turned = after.poses[i].orientation - before.poses[i].orientation;
                let inertia = people[i].body.inertia;
                // Simpson's rule, with the mean velocity in the middle.
                let mean = |a: f64, middle: f64, b: f64| (a * a + 4.0 * middle * middle + b * b) / 6.0;
                let [a, b] = [&before, after].map(|state| state.twists[i]);
                let middle = |moved: f64, a: f64, b: f64| 1.5 * moved / 1e-4 - 0.25 * (a + b);
                let square = mean(a.velocity.x, middle(moved.x, a.velocity.x, b.velocity.x), b.velocity.x)
                    + mean(a.velocity.y, middle(moved.y, a.velocity.y, b.velocity.y), b.velocity.y);
                let spin = mean(
                    a.angular_velocity,
                    middle(turned, a.angular_velocity, b.angular_velocity),
                    b.angular_velocity,
                );
                impulse += drive.force.x * 1e-4 - MASS * DAMPING * moved.x;
                work += drive.force.dot(&moved) + drive.torque * turned;
                work -= DAMPING * (MASS * square + inertia * spin) * 1e-4;
            }
        }
        row.pass(0.01)?;
        made = largest([made, kinetic_energy(&row.world) - work]);
    }
    let last = row.decision.stances().map(|stances| stances[4].steps);
    ensure!(last > Some(0), "the push goes through, and the last one steps");
    let missing = (momentum(&row.world).x - impulse).abs() / (0.2 * PUSH);
    Ok([missing, made / (0.5 * PUSH * PUSH * 0.04 / MASS)])
}
