//! A Trial's crowd, and who decides where its people walk.

use crate::error::SimError;
use crate::replay::record;
use crate::variables::IndexedModel;
use crowd_mechanics::engine::{FaceExposure, World, Wrench, vec2};
use crowd_mechanics::model::{CrowdModel, SavedCrowd};
use crowd_mechanics::quantities::CrowdQuantity;
use lemons_core::plane::Motion;
use lemons_core::trial::{AgentDynamics, DriveTable, Trial};
use lemons_decision::decision::{Act, DecisionQuantity, Influence, SavedDecision, Stance};
use lemons_decision::{Decision, Plan};
use lemons_fmi::{Model, Phase, Step, fingerprint};
use lemons_results::columns::Group;
use lemons_results::{Effects, Frame, OfLegs, OfWall, Totals};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// Documents with which a simulation begins.
#[derive(Debug, Clone)]
pub struct Documents {
    /// The Trial.
    pub trial: Trial,
    /// Propulsion over time; empty for none. Where people walk, it is added to the forces with which they do.
    pub drive: DriveTable,
    /// Where people walk, if they do.
    pub plan: Option<Plan>,
}

impl Documents {
    /// Makes them. Who comes later is not there at the start, also where the Trial does not say so.
    pub fn new(mut trial: Trial, drive: DriveTable, plan: Option<Plan>) -> Documents {
        plan.iter().for_each(|plan| plan.mark_absent(&mut trial));
        Documents { trial, drive, plan }
    }

    /// Returns of everybody whether they have an exit.
    pub fn leaving(&self) -> Vec<bool> {
        self.plan.as_ref().map(Plan::leaving).unwrap_or_default()
    }
}

/// In which order crowd and Decision exchange values and step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Algorithm {
    /// Both use the values of the last communication point.
    #[default]
    Jacobi,
    /// Decision steps first, and the crowd uses what it has decided.
    GaussSeidel,
}

/// Part of a communication step of a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exchange {
    /// Its inputs get the newest values of the outputs that feed them.
    SetInputs,
    /// It steps.
    Step,
    /// Its outputs are read.
    GetOutputs,
}

impl Algorithm {
    /// Makes a communication step of coupled components, which Gauss-Seidel takes in this order.
    ///
    /// # Errors
    /// The first one of a component.
    pub fn step<C: Copy, E>(
        self,
        components: &[C],
        mut exchange: impl FnMut(C, Exchange) -> Result<(), E>,
    ) -> Result<(), E> {
        let all = [Exchange::SetInputs, Exchange::Step, Exchange::GetOutputs];
        match self {
            Algorithm::Jacobi => {
                all.iter().try_for_each(|what| components.iter().try_for_each(|c| exchange(*c, *what)))
            }
            Algorithm::GaussSeidel => {
                components.iter().try_for_each(|c| all.iter().try_for_each(|what| exchange(*c, *what)))
            }
        }
    }
}

impl fmt::Display for Algorithm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Algorithm::Jacobi => "Jacobi",
            Algorithm::GaussSeidel => "Gauss-Seidel",
        })
    }
}

/// One simulation of a Trial.
pub struct Simulation {
    pub(crate) crowd: IndexedModel<CrowdModel>,
    pub(crate) decision: Option<IndexedModel<Decision>>,
    algorithm: Algorithm,
    ids: Vec<String>,
    /// Added to the forces of those who walk; empty where nobody does, and the crowd is driven by it.
    added: DriveTable,
    /// Whether it is, by the crowd's `PlayDrive`.
    adds: bool,
    /// Pushes from outside of those who walk, by agent: added, too.
    pushes: BTreeMap<usize, Wrench>,
    /// Next acts of those who walk.
    acts: Vec<Act>,
    /// \[s\]
    time: f64,
}

/// Everything on which a simulation's future depends, besides its documents and settings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedSimulation {
    time: f64,
    crowd: SavedCrowd,
    decision: Option<SavedDecision>,
    adds: bool,
}

impl Simulation {
    /// Makes a simulation that has not begun: parameters can be [set](Simulation::set).
    ///
    /// # Errors
    /// None of documents that were read and checked.
    pub fn new(documents: Documents, algorithm: Algorithm) -> Result<Simulation, SimError> {
        let Documents { trial, drive, plan } = documents;
        let ids = trial.agents.iter().map(|agent| agent.id.clone()).collect();
        let (played, added) = match &plan {
            None => (drive, DriveTable::default()),
            Some(_) => (DriveTable::default(), drive),
        };
        Ok(Simulation {
            crowd: IndexedModel::of(CrowdModel::of_trial(trial, played)),
            decision: plan.map(|plan| IndexedModel::of(Decision::new(plan))),
            algorithm,
            ids,
            added,
            adds: true,
            pushes: BTreeMap::new(),
            acts: Vec::new(),
            time: 0.0,
        })
    }

    /// Begins at a time \[s\]. The tolerance \[m\], if there is one, may shorten the mechanical step (docs/step.md).
    ///
    /// # Errors
    /// The values that were set do not fit together, no ways to exits and goals can be found, or the time is not finite.
    pub fn begin(&mut self, start: f64, tolerance: Option<f64>) -> Result<(), SimError> {
        if !start.is_finite() {
            return Err(SimError::Start(start));
        }
        self.time = start;
        let crowd = &mut self.crowd.model;
        crowd.set_tolerance(tolerance);
        self.adds = crowd.number(CrowdQuantity::PlayDrive, 0)? != 0.0;
        if let Some(IndexedModel { model: decision, .. }) = &mut self.decision {
            decision.initialize(start)?;
            decision.see(crowd.trial().dynamics.iter().map(AgentDynamics::motion));
            self.acts = decision.acts()?;
            self.drive_crowd(Phase::Initialization);
        }
        Ok(self.crowd.model.initialize(start)?)
    }

    /// Goes back to before [`Simulation::begin`], without what was set.
    ///
    /// # Errors
    /// None of documents that were read and checked.
    pub fn reset(&mut self) -> Result<(), SimError> {
        self.crowd.model.reset()?;
        if let Some(decision) = &mut self.decision {
            decision.model.reset()?;
        }
        (self.acts, self.time) = (Vec::new(), 0.0);
        self.pushes.clear();
        Ok(())
    }

    /// Pushes an agent from outside (force \[N\], torque \[N.m\]) from now on, until another push. Of who walks, it is
    /// added to the force with which they walk; of anybody else, it is their whole propulsion.
    pub fn push(&mut self, agent: usize, push: Wrench) {
        if self.walks() {
            self.pushes.insert(agent, push);
        } else {
            self.set_drive(agent, push, Phase::StepComplete);
        }
    }

    /// Influences everybody who walks, from now on.
    ///
    /// # Errors
    /// No ways to exits and goals can be found.
    pub fn influence(&mut self, by: Influence) -> Result<(), SimError> {
        if let Some(IndexedModel { model, .. }) = &mut self.decision
            && model.influence(by)
        {
            self.acts = model.acts()?;
        }
        Ok(())
    }

    /// Takes an agent out, or lets it come back where it was. Of people who walk, Decision says it in each step.
    pub fn set_present(&mut self, agent: usize, present: bool) {
        self.crowd.model.set(CrowdQuantity::Active, agent, present.into(), Phase::StepComplete);
    }

    /// Keeps a door (`door[k]`: the k-th of the walls that open) or an exit (`exit[k]`) shut, or lets it be open at its times,
    /// from the next step on. Those who walk know it. Returns whether there is such a door or exit.
    pub fn set_open(&mut self, name: &str, open: bool) -> bool {
        let parts = name.strip_suffix(']').and_then(|name| name.split_once('['));
        let Some((thing, Ok(k))) = parts.map(|(thing, k)| (thing, k.parse::<usize>())) else { return false };
        let doors = self.trial().geometry.doors().count();
        let exits = self.decision.as_ref().map_or(0, |decision| decision.model.exits().count());
        let quantity = match thing {
            "door" if k < doors => DecisionQuantity::DoorOpen,
            "exit" if k < exits => DecisionQuantity::ExitOpen,
            _ => return false,
        };
        if quantity == DecisionQuantity::DoorOpen {
            self.crowd.model.set(CrowdQuantity::DoorOpen, k, open.into(), Phase::StepComplete);
        }
        let Some(IndexedModel { model, .. }) = &mut self.decision else { return true };
        let value = f64::from(open);
        if model.number(quantity, k).is_ok_and(|before| before != value) {
            model.set(quantity, k, value, Phase::StepComplete);
            // They see it at once. If they cannot, the next step says why.
            if let (false, Ok(acts)) = (self.acts.is_empty(), model.acts()) {
                self.acts = acts;
            }
        }
        true
    }

    /// Steps to a communication point \[s\].
    ///
    /// # Errors
    /// The crowd or Decision refuses the step, or fails; the time is not finite, or not after the last one.
    pub fn step_to(&mut self, time: f64) -> Result<(), SimError> {
        if self.world().is_none() {
            return Err(SimError::NotBegun);
        }
        if !(time > self.time && (time - self.time).is_finite()) {
            return Err(SimError::Step { to: time, from: self.time });
        }
        let (from, step) = (self.time, time - self.time);
        // Jacobi gives the same in any order. If the crowd refuses the step, Decision has seen the poses, and has not stepped.
        let order = match self.algorithm {
            Algorithm::Jacobi => [Part::Crowd, Part::Decision],
            Algorithm::GaussSeidel => [Part::Decision, Part::Crowd],
        };
        self.algorithm.step(&order, |part, exchange| self.exchange(part, exchange, Step::of(from, step)))?;
        self.time = time;
        Ok(())
    }

    /// Returns the last communication point \[s\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Returns the Trial, with what was set.
    pub fn trial(&self) -> &Trial {
        self.crowd.model.trial()
    }

    /// Returns whether people walk.
    pub fn walks(&self) -> bool {
        self.decision.is_some()
    }

    /// Returns the Ids of the agents.
    pub fn ids(&self) -> &[String] {
        &self.ids
    }

    /// Returns the engine's world; `None` before the beginning.
    pub fn world(&self) -> Option<&World> {
        self.crowd.model.world()
    }

    /// Returns how many of those who walk have arrived: at their last way-point, at a goal, or have left.
    ///
    /// # Errors
    /// No ways to exits and goals can be found.
    pub fn arrived(&mut self) -> Result<usize, SimError> {
        Ok(self.decision.as_mut().map_or(Ok(0), |decision| decision.model.arrived())?)
    }

    /// Returns who wants to get on now: who walks, has not arrived, and waits for nothing; nobody if nobody walks.
    ///
    /// # Errors
    /// No ways to exits and goals can be found.
    pub fn going(&mut self) -> Result<Vec<bool>, SimError> {
        let nobody = vec![false; self.ids.len()];
        Ok(self.decision.as_mut().map_or(Ok(nobody), |decision| decision.model.going())?)
    }

    /// Returns by which exit everybody wants to leave now ([`Decision::heads`]); nobody if nobody walks.
    ///
    /// # Errors
    /// No ways to exits and goals can be found.
    pub fn heads(&mut self) -> Result<Vec<Option<usize>>, SimError> {
        let nobody = vec![None; self.ids.len()];
        Ok(self.decision.as_mut().map_or(Ok(nobody), |decision| decision.model.heads())?)
    }

    /// Returns what people do who walk.
    pub fn plan(&self) -> Option<&Plan> {
        self.decision.as_ref().map(|decision| decision.model.plan())
    }

    /// Returns the value of a parameter of the crowd that is a text.
    pub fn text(&self, quantity: CrowdQuantity) -> &str {
        self.crowd.model.text(quantity, 0)
    }

    /// Returns the warnings since the last call.
    pub fn take_warnings(&mut self) -> Vec<String> {
        self.crowd.model.take_warnings()
    }

    /// Returns the crowd at the present communication point; empty before the beginning.
    pub fn frame(&self) -> Frame {
        let Some(world) = self.world() else { return Frame::default() };
        let report = world.contacts();
        let mut effects = Effects::default();
        let chests = !world.chest_exposures().is_empty();
        record(world, &mut effects, |of| chests || of.group != Group::Chest);
        let of_wall =
            |of: &FaceExposure| OfWall { mean_normal_force: of.mean_force, peak_normal_force: of.peak_force };
        let may_leave = self.walks() || world.present().contains(&false);
        let agents: Vec<Motion> = motions(world).collect();
        Frame {
            time: self.time,
            legs: self.legs(&agents),
            agents,
            effects,
            totals: Some(Totals {
                agent_contacts: report.agent_contacts,
                wall_contacts: report.wall_contacts,
            }),
            active: may_leave.then(|| world.present().to_vec()),
            walls: Some(world.face_exposures().iter().map(of_wall).collect()),
            panels: Some(world.panel_exposures().iter().map(of_wall).collect()),
            place: format!("t = {:?} s", self.time),
            ..Frame::default()
        }
        .with_outside(self.trial())
    }

    /// Returns the state at the present communication point, as bytes.
    pub fn save(&self) -> Vec<u8> {
        let decision = self.decision.as_ref().map(|decision| decision.model.save());
        let saved =
            SavedSimulation { time: self.time, crowd: self.crowd.model.save(), decision, adds: self.adds };
        let content = postcard::to_stdvec(&saved).expect("a state is plain numbers and text");
        [&fingerprint(&content).to_le_bytes()[..], &content].concat()
    }

    /// Goes to a state that a simulation of the same documents has saved. It has the settings of that one.
    ///
    /// # Errors
    /// The bytes are damaged, or are of other documents.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), SimError> {
        let (sum, content) = bytes.split_at_checked(16).ok_or(SimError::State)?;
        if sum != fingerprint(content).to_le_bytes() {
            return Err(SimError::State);
        }
        let saved: SavedSimulation = postcard::from_bytes(content).map_err(|_| SimError::State)?;
        if !saved.time.is_finite() || saved.decision.is_some() != self.decision.is_some() {
            return Err(SimError::State);
        }
        let Simulation { crowd: IndexedModel { model: crowd, .. }, decision, .. } = self;
        // Of both or of none: what the crowd refuses is taken back.
        if let (Some(IndexedModel { model: decision, .. }), Some(of_decision)) = (decision, &saved.decision) {
            let before = decision.save();
            decision.restore(of_decision)?;
            let acts = decision.acts().and_then(|acts| crowd.restore(&saved.crowd).map(|()| acts));
            self.acts = acts.or_else(|refused| decision.restore(&before).and(Err(refused)))?;
        } else {
            crowd.restore(&saved.crowd)?;
        }
        (self.time, self.adds) = (saved.time, saved.adds);
        self.pushes.clear();
        Ok(())
    }

    /// Returns everybody's legs, as Decision says them, and under who walks; `None` if people have none.
    fn legs(&self, agents: &[Motion]) -> Option<Vec<OfLegs>> {
        let of = |(stance, motion): (Stance, &Motion)| {
            let Stance { stands, feet, steps, balanced, fallen } = stance;
            OfLegs { feet: if stands { feet } else { motion.pose.position }, steps, balanced, fallen }
        };
        Some(self.decision.as_ref()?.model.stances()?.into_iter().zip(agents).map(of).collect())
    }

    /// Drives the crowd as those who walk do, with what is added.
    fn drive_crowd(&mut self, phase: Phase) {
        for i in 0..self.acts.len() {
            let act = self.acts[i];
            let mut drive = Wrench { force: act.drive.force.into(), torque: act.drive.torque };
            if phase == Phase::StepComplete {
                let added = self.added.at(&self.ids[i], self.time).filter(|_| self.adds);
                let added = added.map(|[x, y, torque]| Wrench { force: vec2(x, y), torque });
                for more in added.iter().chain(self.pushes.get(&i)) {
                    drive.force += more.force;
                    drive.torque += more.torque;
                }
            }
            self.set_drive(i, drive, phase);
            self.crowd.model.set(CrowdQuantity::Active, i, act.active.into(), phase);
        }
    }

    fn set_drive(&mut self, agent: usize, Wrench { force, torque }: Wrench, phase: Phase) {
        for (quantity, element, value) in [
            (CrowdQuantity::Fp, 2 * agent, force.x),
            (CrowdQuantity::Fp, 2 * agent + 1, force.y),
            (CrowdQuantity::Mp, agent, torque),
        ] {
            self.crowd.model.set(quantity, element, value, phase);
        }
    }

    fn exchange(&mut self, part: Part, exchange: Exchange, step: Step) -> Result<(), SimError> {
        match (part, exchange, &mut self.decision) {
            (Part::Crowd, Exchange::SetInputs, _) => self.drive_crowd(Phase::StepComplete),
            (Part::Crowd, Exchange::Step, _) => self.crowd.model.advance(step)?,
            (Part::Crowd, Exchange::GetOutputs, _) | (Part::Decision, _, None) => {}
            (Part::Decision, Exchange::SetInputs, Some(IndexedModel { model, .. })) => {
                model.see(self.crowd.model.world().into_iter().flat_map(motions));
            }
            (Part::Decision, Exchange::Step, Some(decision)) => decision.model.pass(step.length)?,
            (Part::Decision, Exchange::GetOutputs, Some(decision)) => self.acts = decision.model.acts()?,
        }
        Ok(())
    }
}

/// A component of a simulation.
#[derive(Debug, Clone, Copy)]
enum Part {
    Crowd,
    Decision,
}

/// Returns where everybody is and how they move.
fn motions(world: &World) -> impl Iterator<Item = Motion> {
    let state = world.state();
    state.poses.iter().zip(&state.twists).map(|(pose, twist)| Motion { pose: *pose, twist: *twist })
}
