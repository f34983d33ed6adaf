//! A crowd and who decides where its people walk as one FMU with a few scalars, for tools that connect no thousands of
//! variables: FMI 2.0 or 3.0 (docs/summary.md). People are inside, and in the state.
//!
//! It simulates as `lemons run` does ([`lemons_sim::Simulation`], Jacobi), and its outputs are what `lemons measure` says of the
//! same frames. The modules; each imports only from those above it:
//!
//! - [`quantities`]: the table of variables
//! - [`config`]: what of a Trial is in which slot
//! - [`Summary`]: the simulation, and what is seen of it
//! - `fmi`: it as the model of an FMU
//! - [`pack`]: writes an `.fmu`: its resources are a Trial directory with a `decision.toml` and a `summary.toml`

pub mod config;
mod fmi;
pub mod pack;
pub mod quantities;

pub use config::{AreaConfig, SUMMARY_FILE, SummaryConfig, SummaryError};
pub use fmi::SavedSummary;

use config::Slots;
use lemons_decision::decision::Influence;
use lemons_decision::target::nearest_exit;
use lemons_fmi::fingerprint;
use lemons_results::Frame;
use lemons_results::measure::{Across, Departures, LIMIT, MovingMeans, Window, present, quantile, squeeze};
use lemons_sim::{Algorithm, Documents, SimError, Simulation};
use quantities::{FLOW_OVER, QUANTITIES, QUEUE_NEAR, QUEUE_SLOW, SummaryQuantity, What};
use serde::{Deserialize, Serialize};

/// A crowd, and what is seen of it.
pub struct Summary {
    simulation: Simulation,
    slots: Slots,
    /// Of all variables, in the order of the table.
    values: Vec<f64>,
    /// Since initialization.
    seen: Option<Seen>,
    /// Fingerprint of what is in the slots.
    fingerprint: u128,
    /// \[m\] See [`Simulation::begin`].
    tolerance: Option<f64>,
    /// Whether the values of the start are known before initialization.
    peeked: bool,
}

/// What outputs need of earlier communication points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Seen {
    /// \[s\]
    start: f64,
    departures: Departures,
    squeezes: MovingMeans,
}

impl Summary {
    /// Makes it at the start of documents.
    ///
    /// # Errors
    /// [`SummaryError`]
    pub fn new(documents: Documents, config: &SummaryConfig) -> Result<Summary, SummaryError> {
        let slots = config.slots(&documents)?;
        let simulation = Simulation::new(documents, Algorithm::Jacobi)?;
        let values = vec![0.0; QUANTITIES.len()];
        let fingerprint = fingerprint(config.to_toml()?.as_bytes());
        let (seen, tolerance, peeked) = (None, None, false);
        let mut made = Summary { simulation, slots, values, seen, fingerprint, tolerance, peeked };
        made.forget();
        Ok(made)
    }

    /// Returns to the values before initialization.
    fn forget(&mut self) {
        (self.seen, self.tolerance, self.peeked) = (None, None, false);
        let arrivals = self.simulation.plan().and_then(|plan| plan.arrivals());
        for (value, row) in self.values.iter_mut().zip(&QUANTITIES) {
            *value = match row.quantity.what {
                What::SpeedFactor | What::ExitOpen | What::DoorOpen => 1.0,
                What::Arrivals => arrivals.unwrap_or_default(),
                _ => 0.0,
            };
        }
    }

    /// Begins at a time \[s\].
    fn begin(&mut self, start: f64) -> Result<(), SimError> {
        self.pass_inputs()?;
        self.simulation.begin(start, self.tolerance)?;
        let departures = Departures::of(self.simulation.ids().len());
        self.seen = Some(Seen { start, departures, squeezes: MovingMeans::over(LIMIT.1) });
        let means = self.follow();
        let loads = self.loads().collect::<Vec<f64>>();
        self.see(means.as_deref(), &loads)
    }

    /// Steps to a time \[s\] under the present inputs, in steps that are no longer than the Trial's `TimeStep`: where people
    /// walk is decided in each.
    fn step_to(&mut self, time: f64) -> Result<(), SimError> {
        self.pass_inputs()?;
        let (from, steps) = (self.simulation.time(), self.steps_of(time - self.simulation.time()));
        let (mut means, mut loads) = (None, vec![0.0; self.slots.panels.len()]);
        for k in 1..=steps {
            let part = k as f64 / steps as f64;
            self.simulation.step_to(if k == steps { time } else { from + (time - from) * part })?;
            means = self.follow();
            let now: Vec<f64> = self.loads().collect();
            loads.iter_mut().zip(now).for_each(|(sum, load)| *sum += load);
        }
        loads.iter_mut().for_each(|load| *load /= steps as f64);
        self.see(means.as_deref(), &loads)
    }

    /// Returns in how many steps a communication step \[s\] is made.
    fn steps_of(&self, length: f64) -> u64 {
        // A rounding error is no step.
        (length / self.simulation.trial().parameters.time_step - 1e-6).ceil().max(1.0) as u64
    }

    /// \[N/m\] Returns the loads on the panels, means over the last step.
    fn loads(&self) -> impl Iterator<Item = f64> {
        let of = |panel: &usize| self.simulation.world().map_or(0.0, |world| world.panel_loads(*panel).0);
        self.slots.panels.iter().map(of)
    }

    /// Follows who leaves and how everybody is squeezed. Returns the mean squeezes \[N\], once they are known.
    fn follow(&mut self) -> Option<Vec<f64>> {
        let frame = self.simulation.frame();
        let Seen { departures, squeezes, .. } = self.seen.as_mut()?;
        departures.add(&frame);
        let of_step = |agent| squeeze(&frame, agent, None).map(|(mean, _)| mean);
        squeezes.add(frame.time, (0..frame.agents.len()).map(of_step))
    }

    /// Passes the inputs on.
    fn pass_inputs(&mut self) -> Result<(), SimError> {
        let input = |what, slot| self.values[SummaryQuantity { what, slot }.place()];
        let arrivals = self.has(What::Arrivals, 0).then(|| input(What::Arrivals, 0));
        let influence = Influence {
            speed_factor: input(What::SpeedFactor, 0),
            push: input(What::Push, 0),
            stop: input(What::Stop, 0) != 0.0,
            arrivals,
        };
        self.simulation.influence(influence)?;
        for (quantity, name) in &self.slots.operated {
            self.simulation.set_open(name, self.values[quantity.place()] != 0.0);
        }
        Ok(())
    }

    /// Returns whether what is loaded has this.
    fn has(&self, what: What, slot: usize) -> bool {
        let plan = self.simulation.plan();
        match (what, self.slots.names(what)) {
            (_, Some(names)) => slot < names.len(),
            (What::SpeedFactor | What::Push | What::Stop, _) => plan.is_some(),
            (What::Arrivals, _) => plan.is_some_and(|plan| plan.arrivals().is_some()),
            (What::PeopleFallen, _) => plan.is_some_and(|plan| plan.balance.is_some()),
            _ => true,
        }
    }

    /// Sees the present communication point, with the mean squeezes \[N\] and the loads \[N/m\]: outputs follow.
    fn see(&mut self, means: Option<&[f64]>, loads: &[f64]) -> Result<(), SimError> {
        let (frame, heads) = (self.simulation.frame(), self.simulation.heads()?);
        let Some(Seen { start, departures, .. }) = &self.seen else { return Ok(()) };
        let targets = self.simulation.plan().map_or(&[][..], |plan| &plan.targets);
        // When and by which exit people have left.
        let gone: Vec<(f64, Option<usize>)> = departures
            .times()
            .iter()
            .zip(&frame.agents)
            .filter_map(|(time, motion)| Some(((*time)?, nearest_exit(targets, motion.pose.position))))
            .collect();
        let squeezes: Vec<Squeezes> =
            self.slots.areas.iter().map(|area| Squeezes::of(&frame, means, |at| area.contains(at))).collect();
        let queues = |exit: usize| {
            let here = frame.present().filter(|(agent, motion)| {
                heads[*agent] == Some(exit)
                    && motion.twist.velocity.norm() < QUEUE_SLOW
                    && targets[exit].distance(motion.pose.position) <= QUEUE_NEAR
            });
            here.count()
        };
        for (row, value) in QUANTITIES.iter().zip(&mut self.values) {
            let SummaryQuantity { what, slot } = row.quantity;
            let filled = self.slots.names(what).is_none_or(|names| slot < names.len());
            if !filled || row.quantity.is_input() {
                continue;
            }
            let by = |since: f64| {
                let exit = Some(self.slots.exits[slot]);
                gone.iter().filter(|(time, by)| *time > since && *by == exit).count()
            };
            let squeezed = || &squeezes[slot].0;
            *value = match what {
                What::ExitLeft => by(f64::NEG_INFINITY) as f64,
                What::ExitFlow => {
                    let (from, until) = ((frame.time - FLOW_OVER).max(*start), frame.time);
                    let window = Window { from, until, count: by(from) };
                    if until > from { window.flow() } else { 0.0 }
                }
                What::ExitQueue => queues(self.slots.exits[slot]) as f64,
                What::AreaDensity => self.slots.areas[slot].measure(&frame, None).density,
                What::AreaSqueezeMean => Across::Mean.of(squeezed().iter().copied()).unwrap_or_default(),
                What::AreaSqueeze95 => quantile(squeezed(), 0.95).unwrap_or_default(),
                What::AreaSqueezeMax => squeezed().last().copied().unwrap_or_default(),
                What::AreaAbove => {
                    squeezed().iter().filter(|squeeze| **squeeze > self.slots.limit).count() as f64
                }
                What::BarrierLoad => loads[slot],
                What::PeopleLeft => departures.left().map_or(0, |left| left.people) as f64,
                What::PeopleInside => frame.present().count() as f64,
                What::PeopleFallen => frame.legs.iter().flatten().filter(|legs| legs.fallen).count() as f64,
                _ => continue,
            };
        }
        Ok(())
    }
}

/// \[N\] Mean squeezes of those who are in an area, ascending; of nobody before means are known.
struct Squeezes(Vec<f64>);

impl Squeezes {
    fn of(
        frame: &Frame,
        means: Option<&[f64]>,
        is_in: impl Fn(lemons_core::plane::Vec2) -> bool,
    ) -> Squeezes {
        let of_those =
            means.unwrap_or_default().iter().enumerate().filter(|(agent, _)| {
                present(frame, *agent).is_some_and(|motion| is_in(motion.pose.position))
            });
        let mut all: Vec<f64> = of_those.map(|(_, mean)| *mean).collect();
        all.sort_by(f64::total_cmp);
        Squeezes(all)
    }
}

#[cfg(test)]
mod tests;
