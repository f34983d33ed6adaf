//! What a crowd does at a communication point, as a frame: what lines, areas and exposures are measured by.

use crate::error::{Error, Result};
use lemons_master::{Fmu, Instance, Selection, System};
use lemons_plane::{Motion, Pose, Twist, Vec2, vec2};
use lemons_record::columns::{MOTION, OF_STEP, Quantity};
use lemons_record::{Frame, Observed, OfStep};

/// What is wanted of a crowd.
#[derive(Debug, Clone, Copy, Default)]
pub struct Wanted {
    pub motions: bool,
    pub squeezes: bool,
}

/// Reads frames of a crowd.
pub struct Scene {
    /// Of the crowd among the components.
    place: usize,
    people: usize,
    motions: Selection,
    squeezes: Selection,
    /// Whether each agent is there; empty if nobody can leave.
    there: Selection,
}

fn of_each(people: usize, names: &[&str]) -> Vec<String> {
    (0..people).flat_map(|i| names.iter().map(move |name| format!("agent[{i}].{name}"))).collect()
}

impl Wanted {
    fn names(self, people: usize) -> [Vec<String>; 2] {
        let all = |wanted: bool, columns: &[Quantity]| {
            let names: Vec<&str> = columns.iter().map(|column| column.variable).collect();
            if wanted { of_each(people, &names) } else { Vec::new() }
        };
        // Place and velocity; mean and peak of the squeeze.
        [all(self.motions, &MOTION[..4]), all(self.squeezes, &OF_STEP[..2])]
    }

    /// Checks that a crowd's FMU has all of it.
    pub fn check(self, fmu: &Fmu, people: usize) -> Result<()> {
        let missing = self.names(people).into_iter().flatten().find(|name| fmu.kind(name).is_none());
        missing.map_or(Ok(()), |name| Err(Error::Spec(format!("the FMU has no output {name}"))))
    }
}

impl Scene {
    /// Of the last component, with so many people.
    pub fn of(system: &System, wanted: Wanted, people: usize) -> Result<Scene> {
        let place = system.components().len() - 1;
        let instance = &system.components()[place].instance;
        let [motions, squeezes] = wanted.names(people);
        let mut there = of_each(people, &["Active"]);
        if !there.iter().all(|name| system.feeds(place, name)) {
            there.clear();
        }
        Ok(Scene {
            place,
            people,
            motions: instance.select(&motions)?,
            squeezes: instance.select(&squeezes)?,
            there: instance.select(&there)?,
        })
    }

    /// At a time \[s\].
    pub fn frame(&self, system: &System, time: f64) -> lemons_master::Result<Frame> {
        let instance = &system.components()[self.place].instance;
        let motions = reals(instance, &self.motions)?;
        let motion = |values: &[f64; 4]| {
            let [x, y, vx, vy] = *values;
            Motion {
                pose: Pose { position: vec2(x, y), orientation: 0.0 },
                twist: Twist { velocity: vec2(vx, vy), angular_velocity: 0.0 },
            }
        };
        let mut agents: Vec<Motion> = motions.as_chunks().0.iter().map(motion).collect();
        agents.resize(self.people, Motion::default());
        let squeezes = reals(instance, &self.squeezes)?;
        let squeezed = |values: &[f64; 2]| {
            let [mean_normal_force, peak_normal_force] = *values;
            let of_step = Some(OfStep { mean_normal_force, peak_normal_force, peak_overlap: 0.0 });
            Observed { of_step, ..Observed::default() }
        };
        let observed: Vec<Observed> = squeezes.as_chunks().0.iter().map(squeezed).collect();
        let mut there = vec![1; self.there.len()];
        if !there.is_empty() {
            instance.get_boolean(&self.there, &mut there)?;
        }
        Ok(Frame {
            time,
            agents,
            observed: (!observed.is_empty()).then_some(observed),
            active: (!there.is_empty()).then(|| there.into_iter().map(|there| there != 0).collect()),
            ..Frame::default()
        })
    }
}

fn reals(instance: &Instance, selection: &Selection) -> lemons_master::Result<Vec<f64>> {
    let mut values = vec![0.0; selection.len()];
    if !values.is_empty() {
        instance.get_real(selection, &mut values)?;
    }
    Ok(values)
}

/// \[m\] Where everybody is; `None` of those who have left.
pub fn standing(frame: &Frame) -> Vec<Option<Vec2>> {
    let place = |(agent, motion): (usize, &Motion)| frame.is_there(agent).then_some(motion.pose.position);
    frame.agents.iter().enumerate().map(place).collect()
}
