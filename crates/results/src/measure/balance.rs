//! How people who have legs keep their balance.

use crate::measure::present;
use crate::{Frame, OfLegs};
use serde::Serialize;

/// How a person kept the balance. The names of the fields are those of the numbers in files.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Kept {
    /// \[s\] In communication steps at whose end the person needed a step.
    pub time_unbalanced: f64,
    /// Number of steps since the first frame.
    pub steps: u32,
    /// 1 for who could not be saved from a fall, until the last frame, and 0 for others.
    pub falls: u32,
    /// \[m\] Largest distance of the centre of mass from the middle of the feet, at the frames.
    pub lean: f64,
}

/// Sums up how people keep their balance. It is given all communication points in the order of time.
#[derive(Debug, Clone)]
pub struct BalanceOverTime {
    people: Vec<Kept>,
    /// Steps of each at the first frame.
    begun: Vec<u32>,
    /// \[s\] Of the frame before.
    before: Option<f64>,
    known: bool,
}

impl BalanceOverTime {
    /// Begins, with so many people.
    pub fn of(people: usize) -> BalanceOverTime {
        BalanceOverTime {
            people: vec![Kept::default(); people],
            begun: Vec::new(),
            before: None,
            known: true,
        }
    }

    /// Adds the next frame.
    pub fn add(&mut self, frame: &Frame) {
        let Some(legs) = &frame.legs else {
            self.known = false;
            return;
        };
        if self.before.is_none() {
            self.begun = legs.iter().map(|legs| legs.steps).collect();
        }
        let step = self.before.map_or(0.0, |before| frame.time - before);
        self.before = Some(frame.time);
        let people = self.people.iter_mut().zip(legs).zip(&self.begun).enumerate();
        for (agent, ((one, OfLegs { feet, steps, balanced, fallen }), begun)) in people {
            (one.steps, one.falls) = (steps.saturating_sub(*begun), (*fallen).into());
            if let Some(motion) = present(frame, agent) {
                one.time_unbalanced += if *balanced { 0.0 } else { step };
                one.lean = one.lean.max((motion.pose.position - *feet).norm());
            }
        }
    }

    /// Returns how each person kept the balance until the last frame.
    pub fn seen(&self) -> &[Kept] {
        &self.people
    }

    /// Returns the same; `None` if frames do not say it, or there are none.
    pub fn finish(self) -> Option<Vec<Kept>> {
        (self.known && self.before.is_some()).then_some(self.people)
    }
}
