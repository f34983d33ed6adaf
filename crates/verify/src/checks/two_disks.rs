//! Two round bodies that touch, by Runge and Kutta's fourth-order method: formulas of their own.

use crowd_mechanics::engine::{InPlane, PairLaw, Vec2, Wrench};
use lemons_core::plane::vec2;

/// Two round bodies, and what acts on them besides their contact.
pub(crate) struct TwoDisks {
    pub masses: [f64; 2],
    pub inertias: [f64; 2],
    pub radii: [f64; 2],
    pub law: PairLaw,
    /// \[N/s\], \[N.m/s\] Rates at which drives grow from zero.
    pub drive_rates: [Wrench; 2],
    /// \[1/s\] Relaxation rate of velocities and angular velocities.
    pub relaxation_rate: f64,
}

/// Position and velocity of the first relative to the second, both angular velocities, the elongation.
pub(crate) type State = [f64; 7];

impl TwoDisks {
    /// Rates of change at a time \[s\].
    fn rates(&self, time: f64, [rx, ry, vx, vy, w1, w2, s]: State) -> State {
        let (r, v, w) = (vec2(rx, ry), vec2(vx, vy), [w1, w2]);
        let depth = self.radii[0] + self.radii[1] - r.norm();
        let arms = self.radii.map(|radius| radius - 0.5 * depth);
        let n = r * (1.0 / r.norm());
        // The contact point is in direction −n from the first and +n from the second.
        let slip = v.dot(&n.left()) - w1 * arms[0] - w2 * arms[1];
        let (mut force, mut tangential, mut stretching) = (Vec2::zeros(), 0.0, 0.0);
        if depth > 0.0 {
            let law = &self.law;
            stretching = slip;
            let normal = law.normal_stiffness * depth - law.normal_damping * v.dot(&n);
            tangential = -law.tangential_stiffness * s - law.tangential_damping * slip;
            let limit = law.friction * normal.abs();
            if tangential.abs() > limit {
                tangential = limit.copysign(tangential);
                stretching = (-tangential - law.tangential_stiffness * s) / law.tangential_damping;
            }
            force = n * normal + n.left() * tangential;
        }
        let driven = [0, 1].map(|i| self.drive_rates[i].force * (time / self.masses[i]));
        let lightness = 1.0 / self.masses[0] + 1.0 / self.masses[1];
        let a = force * lightness + driven[0] - driven[1] - v * self.relaxation_rate;
        let spin = [0, 1].map(|i| {
            (self.drive_rates[i].torque * time - arms[i] * tangential) / self.inertias[i]
                - self.relaxation_rate * w[i]
        });
        [vx, vy, a.x, a.y, spin[0], spin[1], stretching]
    }

    /// Returns the state after some steps \[s\].
    pub fn after(&self, mut state: State, steps: u32, step: f64) -> State {
        let moved = |state: State, rates: State, by: f64| -> State {
            std::array::from_fn(|k| state[k] + by * rates[k])
        };
        for k in 0..steps {
            let t = f64::from(k) * step;
            let k1 = self.rates(t, state);
            let k2 = self.rates(t + 0.5 * step, moved(state, k1, 0.5 * step));
            let k3 = self.rates(t + 0.5 * step, moved(state, k2, 0.5 * step));
            let k4 = self.rates(t + step, moved(state, k3, step));
            let sum = std::array::from_fn(|k| k1[k] + 2.0 * k2[k] + 2.0 * k3[k] + k4[k]);
            state = moved(state, sum, step / 6.0);
        }
        state
    }
}
