//! Legs of everybody: when it is decided who stands, and what the outputs say of them.

use super::Decision;
use crate::balance::{BalanceModel, Legs, OwnMotion, STILL};
use lemons_core::plane::Vec2;
use lemons_fmi::Answer;

/// Legs of an agent, as the outputs say them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stance {
    /// Whether it stands; else the feet are under the body.
    pub stands: bool,
    /// \[m\] Middle of the feet.
    pub feet: Vec2,
    /// Number of steps to keep the balance.
    pub steps: u32,
    /// Whether it needs no step.
    pub balanced: bool,
    /// Whether it could not be saved from a fall, at some time.
    pub fallen: bool,
}

impl Decision {
    /// Returns everybody's legs, as the outputs say them; `None` if people have none.
    pub fn stances(&self) -> Option<Vec<Stance>> {
        self.plan.balance.map(|_| (0..self.agents.len()).map(|i| self.stance(i)).collect())
    }

    /// Returns the legs of an agent as they were at the last step; before the first one, as they will be, once decided.
    fn stance(&self, i: usize) -> Stance {
        let agent = &self.agents[i];
        let decided = self.legs.as_ref().and_then(|legs| legs[i]);
        let legs = if agent.last.is_some() { agent.legs } else { decided.unwrap_or_default() };
        let Legs { stands, at, steps, fallen, .. } = legs;
        let stands = stands && !agent.left;
        let balanced = |balance: BalanceModel| balance.is_balanced(&legs, &agent.motion());
        let balanced = !stands || self.plan.balance.is_none_or(balanced);
        Stance { stands, feet: if stands { at } else { agent.at() }, steps, balanced, fallen }
    }

    /// Returns the same, decided.
    pub(super) fn seen_stance(&mut self, i: usize) -> Answer<Stance> {
        if let Some(balance) = self.plan.balance.filter(|_| self.agents[i].last.is_none()) {
            self.find_ways()?;
            self.decide_legs(&balance);
        }
        Ok(self.stance(i))
    }

    /// Decides who stands, unless that was done at these poses.
    pub(super) fn decide_legs(&mut self, balance: &BalanceModel) {
        if self.legs.is_none() {
            if !self.plan.groups.is_empty() || self.plan.counts() {
                self.find_aims();
            }
            self.legs = Some((0..self.agents.len()).map(|i| self.decided_legs(i, balance)).collect());
        }
    }

    /// Returns the legs of an agent that has not left: whether it stands follows from where it wants to go.
    fn decided_legs(&mut self, i: usize, balance: &BalanceModel) -> Option<Legs> {
        if self.is_away(i) {
            return None;
        }
        let wants = self.intent(i).speed > STILL;
        let agent = &self.agents[i];
        Some(match agent.last {
            Some(_) => balance.decided(agent.legs, &agent.motion(), wants),
            None => agent.legs.under(&agent.motion(), !wants),
        })
    }

    /// A step \[s\] passes for everybody's legs, if people have any.
    pub(super) fn pass_legs(&mut self, step: f64) {
        let Some(balance) = self.plan.balance else { return };
        self.decide_legs(&balance);
        self.find_leans();
        let legs = self.legs.take().unwrap_or_default().into_iter().zip(&self.agents);
        let mut people: Vec<Option<(Legs, OwnMotion)>> =
            legs.enumerate().map(|(i, (legs, _))| Some((legs?, self.leaning(i)))).collect();
        balance.pass(&mut people, &self.faces, step);
        for (agent, (legs, _)) in
            self.agents.iter_mut().zip(people).filter_map(|(agent, one)| Some((agent, one?)))
        {
            agent.legs = legs;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{DecisionQuantity, tests::decision};
    use super::*;
    use crate::WalkingModelName;
    use lemons_core::plane::{Motion, Pose, Twist, vec2};
    use lemons_fmi::Model;
    use lemons_fmi::variables::{Dependencies, Known};

    /// Somebody at x \[m\] with a velocity along x \[m/s\].
    fn moving(x: f64, velocity: f64) -> Motion {
        let twist = Twist { velocity: vec2(velocity, 0.0), ..Twist::default() };
        Motion { pose: Pose::new(x, 0.0, 0.0), twist }
    }

    /// Sees person 0 here with a velocity along x \[m/s\], and passes a step \[s\].
    fn step(decision: &mut Decision, x: f64, velocity: f64, step: f64) -> f64 {
        let far = moving(50.0, 0.0);
        decision.see([moving(x, velocity), far].into_iter());
        let force = decision.acts().unwrap()[0].drive.force[0];
        decision.pass(step).unwrap();
        force
    }

    /// Walks towards a way-point and on behind it, hit there by nobody.
    #[test]
    fn who_arrives_brakes_as_without_legs_and_then_stands() {
        let way = "waypoints = [{ x = 1, y = 0 }]\n";
        for balance in ["pendulum", "two-level"] {
            let [mut legs, mut none] =
                [balance, "none"].map(|name| decision(&format!("balance = {name:?}\n{way}")));
            let (mut x, mut v, mut stood) = (0.0, 1.34, f64::INFINITY);
            for _ in 0..500 {
                let force = step(&mut legs, x, v, 0.01);
                let before = step(&mut none, x, v, 0.01);
                if legs.agents[0].legs.stands {
                    stood = f64::min(stood, v);
                }
                assert!(stood < 1.0 || force == before, "{x} {v}");
                // The floor takes 2 /s.
                v += (force / 70.0 - 2.0 * v) * 0.01;
                x += v * 0.01;
            }
            let at_rest = legs.agents[0].legs.steps == 0 && !legs.agents[0].legs.fallen && v.abs() < 0.05;
            assert!(stood < 0.4 && at_rest, "{balance}: {v} {:?}", legs.agents[0].legs);
        }
    }

    #[test]
    fn who_stands_at_a_goal_or_wants_no_speed_has_legs_until_the_balance_is_regained() {
        let goal = "goals = [{ polygon = [[-1, -1], [1, -1], [1, 1], [-1, 1]] }]";
        let slow = "waypoints = [{ x = 9, y = 0 }]\n[agents.0]\ndesired_speed = 0.05";
        let stays = "exits = [{ line = [[9, -5], [9, 5]] }]\n[agents.0]\nwaypoints = []";
        for (model, config) in WalkingModelName::ALL
            .iter()
            .map(|model| model.name())
            .flat_map(|model| [goal, slow, stays].map(|config| (model, config)))
        {
            let balance = if model == "straight" { "two-level" } else { "pendulum" };
            let config = format!("model = {model:?}\nbalance = {balance:?}\n{config}");
            let mut decision = decision(&config);
            // As long as a sway to and fro takes.
            for _ in 0..300 {
                step(&mut decision, 0.0, 0.0, 0.01);
                assert!(decision.agents[0].legs.stands && !decision.agents[1].legs.stands, "{config}");
            }
            // Hit: the ground holds only what legs can. Without legs, this person would brake with 210 N.
            for k in 0..5 {
                let force = step(&mut decision, 0.4 + 0.01 * f64::from(k), 1.5, 0.01);
                assert!(force > 90.0 && decision.agents[0].legs.stands, "{config}: {force}");
            }
            // A run that goes on from a state does the same.
            let mut other = decision.anew();
            other.restore(&decision.save()).unwrap();
            for k in 0..50 {
                let x = 0.5 + 0.001 * f64::from(k);
                let forces = [&mut decision, &mut other].map(|decision| step(decision, x, 0.1, 0.01));
                assert_eq!(forces[0].to_bits(), forces[1].to_bits());
            }
            assert_eq!(decision.save(), other.save());
        }
    }

    #[test]
    fn legs_are_known_before_the_first_step_and_under_who_has_left() {
        let mut decision = decision(
            "balance = \"pendulum\"\nexits = [{ line = [[1, -5], [1, 5]] }]\n[agents.0]\nwaypoints = []\n[agents.1]\ndesired_speed = 0",
        );
        let still = Motion::default();
        decision.see([moving(0.0, 1.0), still].into_iter());
        assert_eq!([0, 1].map(|i| decision.number(DecisionQuantity::Balanced, i).unwrap()), [0.0, 1.0]);
        // Person 1 is pushed out.
        for x in [0.5, 0.9, 1.3, 1.5] {
            decision.see([still, moving(x, 2.0)].into_iter());
            decision.acts().unwrap();
            decision.pass(0.1).unwrap();
        }
        let [lean, balanced] = [DecisionQuantity::Lean, DecisionQuantity::Balanced]
            .map(|quantity| decision.number(quantity, 1).unwrap());
        assert!(decision.agents[1].left && lean == 0.0 && balanced == 1.0);
    }

    #[test]
    fn legs_depend_on_the_own_motion_only() {
        let decision =
            decision("balance = \"pendulum\"\nmodel = \"rotational\"\nwaypoints = [{ x = 9, y = 0 }]");
        let known = |output: DecisionQuantity| match decision.dependencies(output, Known::Inputs) {
            Dependencies::All(on) => (true, on),
            Dependencies::Elements(elements) => {
                let first = elements.iter().filter(|of| of.dependent == 0);
                (false, first.map(|of| of.on).collect())
            }
        };
        use DecisionQuantity::*;
        assert_eq!(known(Lean), (false, vec![Position; 2]));
        assert_eq!(known(Balanced), (false, vec![Position, Position, Velocity, Velocity]));
        assert!(known(Steps).1.is_empty() && known(Fallen).1.is_empty());
        let (all, on) = known(Fp);
        assert!(all && on.contains(&Velocity));
    }

    /// A person who waits for others stands, so that a speed is too much for the balance.
    #[test]
    fn before_the_first_step_legs_depend_on_the_whole_group() {
        let mut decision = decision(
            "balance = \"pendulum\"\nwaypoints = [{ x = 90, y = 0 }]\ngroups.members = [[\"0\", \"1\"]]",
        );
        let mut balanced = |x: f64| {
            let other = Motion { pose: Pose::new(x, 0.9, 0.0), ..Motion::default() };
            decision.see([moving(0.0, 1.0), other].into_iter());
            decision.number(DecisionQuantity::Balanced, 0).unwrap()
        };
        assert_eq!([0.0, -5.0].map(&mut balanced), [1.0, 0.0]);
        for output in [DecisionQuantity::Legs, DecisionQuantity::Lean, DecisionQuantity::Balanced] {
            for (known, also) in [(Known::Inputs, None), (Known::Starts, Some(DecisionQuantity::Waypoint))] {
                let Dependencies::All(on) = decision.dependencies(output, known) else {
                    panic!("{output:?}: not on all")
                };
                assert!(
                    also.into_iter().chain([DecisionQuantity::Position]).all(|needed| on.contains(&needed))
                );
            }
        }
    }
}
