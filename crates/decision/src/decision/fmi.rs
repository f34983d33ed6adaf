//! The crowd as the model of an FMU: poses are inputs, drives are outputs.

use super::openings::Shut;
use super::quantities::{self, DecisionQuantity};
use super::{AgentState, Decision, Influence};
use crate::config::DECISION_FILE;
use crate::plan::Plan;
use crate::walking_model::DesiredMotion;
use lemons_core::plane::InPlane;
use lemons_fmi::location::Location;
use lemons_fmi::variables::{Dependencies, Known, Role, Scalar, Size, Variable};
use lemons_fmi::{Answer, Model, Phase, Refusal, Step, StepError, damaged, refuse};
use serde::{Deserialize, Serialize};

/// The saved state, without the location of the resources.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedDecision {
    /// Fingerprint of the plan.
    fingerprint: u128,
    pub(super) agents: Vec<AgentState>,
    /// \[s\] Time since the start.
    time: f64,
    /// See [`Decision`].
    passed: Vec<usize>,
    influence: Influence,
    ahead: Vec<f64>,
    shut: Shut,
    wanted: Option<Vec<DesiredMotion>>,
}

fn finite(i: usize, name: &'static str, value: f64) -> Answer<f64> {
    if value.is_finite() {
        return Ok(value);
    }
    refuse(format!("agent[{i}]: {name} is not finite: check mass, desired speed, damping and way-points"))
}

impl Model for Decision {
    type Quantity = DecisionQuantity;
    type Saved = SavedDecision;

    const NAME: &'static str = "LEMONS decision";
    const IDENTIFIER: &'static str = "Decision";
    const DESCRIPTION: &'static str =
        "where people want to go: desired speed towards way-points (LEMONS, eq. 4)";
    const STOP_TIME: f64 = 30.0;
    const STATE_VERSION: u32 = 14;
    const SIZES: &'static [Size] = &quantities::SIZES;
    const VARIABLES: &'static [Variable<DecisionQuantity>] = &quantities::QUANTITIES;

    fn load(location: Location<'_>) -> Answer<Decision> {
        let candidates = location.directories()?;
        let Some(directory) = candidates.iter().find(|directory| directory.join(DECISION_FILE).exists())
        else {
            let (location, path) = (location.text(), &candidates[0]);
            return refuse(format!(
                "the resource location {location:?} is {path:?}, which has no {DECISION_FILE}"
            ));
        };
        Plan::read(directory).map(Decision::new).map_err(Refusal::new)
    }

    fn size(&self, place: usize) -> u64 {
        let operable = |quantity| self.operable(quantity).unwrap_or(0);
        let [doors, exits] = [DecisionQuantity::DoorOpen, DecisionQuantity::ExitOpen].map(operable);
        [self.agents.len(), self.most_waypoints, doors, exits][place] as u64
    }

    fn scalars(&self) -> Vec<Scalar<DecisionQuantity>> {
        self.scalars_of_plan()
    }

    fn step_size(&self) -> f64 {
        self.plan.time_step
    }

    fn number(&mut self, quantity: DecisionQuantity, element: usize) -> Answer<f64> {
        if let Some(open) = self.may_open(quantity, element) {
            return Ok(open.into());
        }
        if let Some(field) = self.field(quantity, element) {
            return Ok(*field);
        }
        let i = element / self.elements_of_each(quantity);
        Ok(match quantity {
            DecisionQuantity::Fp => {
                let axis = element % 2;
                finite(i, ["Fp.x", "Fp.y"][axis], self.drive(i)?.force[axis])?
            }
            DecisionQuantity::Mp => finite(i, "Mp", self.drive(i)?.torque)?,
            DecisionQuantity::Active => {
                self.find_ways()?;
                if self.plan.counts() {
                    self.find_aims();
                }
                f64::from(!self.is_away(i))
            }
            DecisionQuantity::Arrived => self.arrived()? as f64,
            DecisionQuantity::NextWaypoint => self.agents[i].next() as f64,
            DecisionQuantity::Legs
            | DecisionQuantity::Lean
            | DecisionQuantity::Steps
            | DecisionQuantity::Balanced
            | DecisionQuantity::Fallen => {
                let stance = self.seen_stance(i)?;
                match quantity {
                    DecisionQuantity::Legs => <[f64; 2]>::from(stance.feet)[element % 2],
                    DecisionQuantity::Lean => (self.agents[i].at() - stance.feet).norm(),
                    DecisionQuantity::Steps => stance.steps.into(),
                    DecisionQuantity::Balanced => stance.balanced.into(),
                    _ => stance.fallen.into(),
                }
            }
            DecisionQuantity::WaypointCount => self.agents[i].walker.waypoints.len() as f64,
            _ => 0.0,
        })
    }

    fn text(&self, _: DecisionQuantity, element: usize) -> &str {
        &self.plan.agents[element].id
    }

    /// Checks that way-points which nobody has are 0.
    fn check(&self, quantity: DecisionQuantity, values: &[f64]) -> Answer<()> {
        let beyond = |k: &usize| values[*k] != 0.0 && !self.has(quantity, *k);
        let Some(k) = (0..values.len()).find(beyond) else { return Ok(()) };
        let i = k / self.elements_of_each(quantity);
        let (agent, count) = (&self.plan.agents[i].id, self.agents[i].walker.waypoints.len());
        refuse(format!("agent {agent:?} has only {count} way-points: what is beyond them must be 0"))
    }

    fn set(&mut self, quantity: DecisionQuantity, element: usize, value: f64, _: Phase) {
        if self.operate(quantity, element, value != 0.0) {
            return;
        }
        if let Some(field) = self.field(quantity, element) {
            *field = value;
            self.forget();
        }
    }

    fn dependencies(&self, computed: DecisionQuantity, known: Known) -> Dependencies<DecisionQuantity> {
        self.dependencies_of(computed, known)
    }

    fn initialize(&mut self, start: f64) -> Answer<()> {
        self.time = start;
        self.motivate_since(f64::NEG_INFINITY);
        self.find_ways()
    }

    /// The poses are those at the beginning of the step.
    fn advance(&mut self, step: Step) -> Result<(), StepError> {
        self.pass(step.length).map_err(StepError::Refused)
    }

    fn reset(&mut self) -> Answer<()> {
        *self = self.anew();
        Ok(())
    }

    fn save(&self) -> SavedDecision {
        SavedDecision {
            fingerprint: self.fingerprint,
            time: self.time,
            passed: self.passed.clone(),
            influence: self.influence,
            ahead: self.ahead.clone(),
            shut: self.shut.clone(),
            agents: self.agents.clone(),
            wanted: self.wanted.clone(),
        }
    }

    fn restore(&mut self, saved: &SavedDecision) -> Answer<()> {
        const IMPOSSIBLE: &str = "it has other agents or way-points, or impossible values";
        let SavedDecision { fingerprint, agents: saved, time, passed, influence, ahead, shut, wanted } =
            saved;
        if *fingerprint != self.fingerprint {
            return refuse("the state belongs to another model, with another Trial or decision.toml");
        }
        let alike = |(a, b): (&AgentState, &AgentState)| {
            let count = b.walker.waypoints.len();
            let last = a.last.is_none_or(|at| at.is_finite());
            let own = [a.steering, a.noise, a.phase, a.choice.wait, a.choice.turn]
                .iter()
                .all(|number| number.is_finite());
            let exit =
                a.choice.exit.is_none_or(|k| self.plan.targets.get(k).is_some_and(|target| !target.stay));
            exit && a.walker.waypoints.len() == count
                && a.next <= count
                && last
                && own
                && a.stuck.is_sound()
                && a.legs.is_sound()
                && a.queue.is_sound()
        };
        if !time.is_finite()
            || passed.len() != self.passed.len()
            || !influence.is_sound()
            || ahead.len() != self.ahead.len()
            || !ahead.iter().all(|ahead| ahead.is_finite())
            || !shut.fits(&self.plan)
            || wanted.as_ref().is_some_and(|wanted| wanted.len() != saved.len())
        {
            return damaged(IMPOSSIBLE);
        }
        if saved.len() != self.agents.len() || !saved.iter().zip(&self.agents).all(alike) {
            return damaged(IMPOSSIBLE);
        }
        let mut restored = Decision { agents: saved.clone(), ..self.anew() };
        for row in Self::VARIABLES.iter().filter(|row| row.role == Role::Input || row.role.is_parameter()) {
            for element in 0..self.agents.len() * self.elements_of_each(row.quantity) {
                let field = restored.field(row.quantity, element);
                if field.is_some_and(|value| row.domain.check(*value).is_err()) {
                    return damaged(IMPOSSIBLE);
                }
            }
        }
        (self.agents, self.time) = (restored.agents, *time);
        self.passed.clone_from(passed);
        self.influence = *influence;
        self.ahead.clone_from(ahead);
        self.restore_shut(shut);
        self.forget();
        self.wanted.clone_from(wanted);
        Ok(())
    }
}
