//! Two levels, a body and legs (Chatagnon, Chraibi, Pettré, Seyfried, Tordeux, arXiv 2601.05867).
//!
//! With e the unit vector from the legs to the body, the body is accelerated by λ_u (v_u e − v), the legs by
//! λ_b (v_b e − v_legs); legs of others and walls repel legs. Here λ_u is 1/t_transl of eq. 1, so that the drive is
//! m v_u e/t_transl, as of who walks (eq. 4) towards where the body leans; and contacts of bodies are those of the
//! mechanics. Where the body is above the legs, to within the balanced distance, e is shorter in proportion. Legs come
//! under the body if v_b is larger than v_u; if they are equal, who leans walks on for ever.

use super::{Legs, OwnMotion, at_most};
use crate::cells::{Cells, nearest_points};
use crate::error::{PlanError, moderate, number};
use lemons_core::plane::{InPlane, Vec2};
use serde::{Deserialize, Serialize};

/// \[s\] Longest step of the legs' motion.
const LONGEST: f64 = 0.01;

/// \[s\] Of a longer step only so much moves legs, so that it ends. A body stands still within a step: at the usual speeds
/// its legs are at rest under it by then.
const AT_REST: f64 = 20.0;

/// Constants of the two-level model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TwoLevel {
    /// \[m/s\] Speed v_u of a body that has lost the balance.
    pub speed: f64,
    /// \[m/s\] Speed v_b of its legs.
    pub legs_speed: f64,
    /// \[1/s\] Rate λ_b of the legs' velocity.
    pub legs_rate: f64,
    /// \[m\] Distance of body and legs within which the person is balanced.
    pub balanced: f64,
    /// Greatest distance of body and legs, as a part of the stature.
    pub separation_part: f64,
    /// \[m\] Distance of two people's legs below which they repel each other; half of it from walls.
    pub legs_distance: f64,
    /// \[m/s²\] Repulsion of legs in one place.
    pub repulsion: f64,
}

impl Default for TwoLevel {
    fn default() -> TwoLevel {
        TwoLevel {
            speed: 0.7,
            legs_speed: 2.5,
            legs_rate: 6.0,
            balanced: 0.06,
            separation_part: 0.25,
            legs_distance: 0.3,
            repulsion: 10.0,
        }
    }
}

impl TwoLevel {
    pub(super) fn check(&self) -> Result<(), PlanError> {
        moderate("two-level", "speed", self.speed)?;
        moderate("two-level", "legs_speed", self.legs_speed)?;
        number(
            "two-level",
            "legs_rate",
            self.legs_rate,
            |rate| (0.0..=50.0).contains(&rate),
            "from 0 to 50 /s",
        )?;
        let length = |length: f64| (1e-3..=1.0).contains(&length);
        number("two-level", "balanced", self.balanced, length, "from 0.001 to 1 m")?;
        number("two-level", "separation_part", self.separation_part, length, "from 0.001 to 1")?;
        let far = |far: f64| (0.0..=1.0).contains(&far);
        number("two-level", "legs_distance", self.legs_distance, far, "from 0 to 1 m")?;
        let most = |most: f64| (0.0..=1e3).contains(&most);
        number("two-level", "repulsion", self.repulsion, most, "from 0 to 1000 m/s²")
    }

    pub(super) fn is_balanced(&self, legs: &Legs, motion: &OwnMotion) -> bool {
        (motion.at - legs.at).norm() <= self.balanced
    }

    /// Returns whether somebody is slow enough to stand, above the legs.
    pub(super) fn stops(&self, motion: &OwnMotion) -> bool {
        motion.velocity.norm() <= self.balanced * motion.damping
    }

    /// Returns e.
    fn direction(&self, lean: Vec2) -> Vec2 {
        lean * (1.0 / lean.norm().max(self.balanced))
    }

    /// \[m/s²\] Returns the acceleration of the drive; the rest of λ_u (v_u e − v) is eq. 1's relaxation.
    pub(super) fn drive(&self, legs: &Legs, motion: &OwnMotion) -> Vec2 {
        self.direction(motion.at - legs.at) * (self.speed * motion.damping) + motion.lean
    }

    /// Moves the legs of everybody who stands by a step of time \[s\].
    pub(super) fn pass(&self, people: &mut [Option<(Legs, OwnMotion)>], faces: &[[Vec2; 2]], step: f64) {
        if !people.iter().flatten().any(|(legs, _)| legs.stands) {
            return;
        }
        let step = step.min(AT_REST);
        let parts = libm::ceil(step / LONGEST).max(1.0);
        for _ in 0..parts as usize {
            let repelled = self.repulsions(people, faces);
            let standing = people.iter_mut().zip(repelled).filter_map(|(one, by)| Some((one.as_mut()?, by)));
            for ((legs, motion), by) in standing.filter(|((legs, _), _)| legs.stands) {
                self.move_legs(legs, motion, by, step / parts);
            }
        }
    }

    fn move_legs(&self, legs: &mut Legs, motion: &OwnMotion, repelled: Vec2, part: f64) {
        let lean = motion.at - legs.at;
        let wanted = self.direction(lean) * self.legs_speed;
        legs.velocity += ((wanted - legs.velocity) * self.legs_rate + repelled) * part;
        legs.at += legs.velocity * part;
        let lean = motion.at - legs.at;
        let most = if motion.steps { self.separation_part * motion.stature } else { self.balanced };
        if lean.norm() > most {
            legs.at = motion.at - at_most(lean, most);
            legs.fallen = true;
        }
    }

    /// \[m/s²\] Returns by how much legs of others and walls accelerate everybody's legs.
    fn repulsions(&self, people: &[Option<(Legs, OwnMotion)>], faces: &[[Vec2; 2]]) -> Vec<Vec2> {
        if self.legs_distance == 0.0 || self.repulsion == 0.0 {
            return vec![Vec2::zeros(); people.len()];
        }
        let range = self.legs_distance.max(1e-3);
        let seen = |i: usize, (legs, _): &(Legs, OwnMotion)| (i, legs.at);
        let cells = Cells::new(people, |(legs, _)| legs.at, faces, (range, range), seen);
        let of = |away: Vec2, range: f64| {
            let near = self.repulsion * (1.0 - away.norm() / range).max(0.0);
            away.unit(1e-9).map_or(Vec2::zeros(), |direction| direction * near)
        };
        let one = |(i, person): (usize, &Option<(Legs, OwnMotion)>)| {
            let Some((legs, _)) = person.as_ref().filter(|(legs, _)| legs.stands) else {
                return Vec2::zeros();
            };
            let (mut sum, cell) = (Vec2::zeros(), cells.cell(legs.at));
            cells.block(cell, 1, |&(k, at)| {
                if k != i {
                    sum += of(legs.at - at, range);
                }
            });
            for (point, _) in nearest_points(legs.at, cells.faces(cell), 0.5 * range) {
                sum += of(legs.at - point, 0.5 * range);
            }
            sum
        };
        people.iter().enumerate().map(one).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::plane::vec2;

    const STEP: f64 = 5e-4;
    const DAMPING: f64 = 4.5;

    fn person(x: f64, velocity: f64) -> Option<(Legs, OwnMotion)> {
        let motion = OwnMotion {
            at: vec2(x, 0.0),
            velocity: vec2(velocity, 0.0),
            damping: DAMPING,
            stature: 1.73,
            lean: Vec2::zeros(),
            steps: true,
        };
        Some((Legs::new(motion.at, true), motion))
    }

    /// Moves bodies and legs; the floor takes the velocity of bodies.
    fn pass(model: &TwoLevel, people: &mut [Option<(Legs, OwnMotion)>], faces: &[[Vec2; 2]], time: f64) {
        for _ in 0..(time / STEP).round() as u32 {
            model.pass(people, faces, STEP);
            for (legs, motion) in people.iter_mut().flatten() {
                let a = model.drive(legs, motion) - motion.velocity * DAMPING;
                motion.velocity += a * STEP;
                motion.at += motion.velocity * STEP;
            }
        }
    }

    /// The linear equations close to balance: SciPy's matrix exponential (the numbers below, for 0.4 s).
    #[test]
    fn a_gentle_hit_is_that_of_the_linear_equations() {
        let model = TwoLevel::default();
        let mut people = [person(0.0, 0.1)];
        pass(&model, &mut people, &[], 0.4);
        let (legs, motion) = people[0].unwrap();
        let (x, feet) = (0.02522, 0.02668);
        assert!((motion.at.x - x).abs() < 2e-4 && (legs.at.x - feet).abs() < 2e-4, "{motion:?} {legs:?}");
        assert!(model.is_balanced(&legs, &motion));
    }

    /// The outside: by hand. Legs come under a body that stays where it is, however long the step; it took hours for 1e6 s.
    #[test]
    fn steps_of_any_length_end_with_the_legs_under_the_body() {
        for step in [30.0, 1e5, 1e12, 1e300] {
            let mut people = [person(0.3, 0.0)];
            people[0].as_mut().unwrap().0.at = vec2(0.0, 0.0);
            TwoLevel::default().pass(&mut people, &[], step);
            let (legs, motion) = people[0].unwrap();
            assert!((legs.at - motion.at).norm() < 1e-6 && !legs.fallen, "{step}: {legs:?}");
        }
    }

    #[test]
    fn a_hard_hit_ends_at_the_greatest_separation_and_is_counted() {
        let model = TwoLevel::default();
        let mut people = [person(0.0, 6.0)];
        pass(&model, &mut people, &[], 0.4);
        let (legs, motion) = people[0].unwrap();
        assert!(legs.fallen && !model.is_balanced(&legs, &motion));
        assert!((motion.at - legs.at).norm() < 0.25 * 1.73 + 6.0 * STEP);
    }

    #[test]
    fn legs_repel_each_other_with_opposite_forces_and_keep_off_walls() {
        let model = TwoLevel::default();
        let people = [person(0.0, 0.0), person(0.2, 0.0), None, person(5.0, 0.0)];
        let wall = [vec2(5.05, -1.0), vec2(5.05, 1.0)];
        let by = model.repulsions(&people, &[wall]);
        assert!((by[0].x + 10.0 / 3.0).abs() < 1e-12 && by[0] == by[1] * -1.0, "{by:?}");
        assert!((by[3].x + 10.0 * (1.0 - 0.05 / 0.15)).abs() < 1e-9 && by[2] == Vec2::zeros(), "{by:?}");
    }
}
