//! The measures of a point while it runs.

use crate::error::{ErrorPlace, Result};
use crate::measure::balance::BalanceMeasure;
use crate::measure::breathing::BreathingMeasure;
use crate::measure::load::LoadMeasure;
use crate::measure::output::{OfOutput, Statistics};
use crate::measure::places::{InArea, OverLine, Places};
use crate::measure::squeeze::SqueezeMeasure;
use crate::measure::{Measure, MeasureKind, check_across};
use crate::output::{Reading, Stop, agents_named};
use crate::spec::Spec;
use lemons_core::plane::Vec2;
use lemons_core::trial::Trial;
use lemons_results::measure::{
    BalanceOverTime, BreathingOverTime, Density, LoadsOverTime, MeasuringArea, Passages, SqueezeOverTime,
};
use lemons_results::{Effects, Frame};
use lemons_sim::Simulation;
use std::collections::HashMap;

/// All measures of a point.
pub struct Accumulators<'a> {
    places: &'a Places,
    people: usize,
    of_each: Vec<(&'a Measure, Accumulator<'a>)>,
    /// Condition that ends the point before its time.
    stop: Option<(&'a Stop, Reading)>,
    /// Whether a measure needs to know where people could be, which is known at the end.
    needs_room: bool,
    /// Frames in which areas are measured at the end.
    frames: Vec<Frame>,
    /// \[m\] Of everybody, at all times.
    positions: Vec<Vec2>,
}

enum Accumulator<'a> {
    Output(&'a OfOutput, Reading, Vec<Statistics>),
    /// With the width \[m\].
    Line(&'a OverLine, Passages, f64),
    /// Without densities where it needs the room: they are measured at the end, in the frames that are kept.
    Area(&'a InArea, &'a MeasuringArea, Vec<Density>),
    /// And the places of the agents that count.
    Squeeze(&'a SqueezeMeasure, SqueezeOverTime),
    Balance(&'a BalanceMeasure, Vec<usize>, BalanceOverTime),
    Breathing(&'a BreathingMeasure, Vec<usize>, Box<BreathingOverTime>),
    Load(&'a LoadMeasure, Box<LoadsOverTime>),
}

impl<'a> Accumulators<'a> {
    /// Begins, before a point of a simulation of this Trial.
    ///
    /// # Errors
    /// There is no such variable or agent, or something of a measure is missing; the message names it.
    pub fn begin(
        spec: &'a Spec,
        trial: &Trial,
        simulation: &Simulation,
        point: usize,
    ) -> Result<Accumulators<'a>> {
        let (places, people) = (&spec.places, trial.agents.len());
        let agents = |ids: &[String], across| {
            let agents = agents_named(trial, ids)?;
            check_across(across, agents.len()).map(|()| agents)
        };
        let begin = |measure: &'a Measure| -> Result<Accumulator<'a>, String> {
            Ok(match &measure.kind {
                MeasureKind::Output(of) => {
                    let reading = of.of.reading(simulation, trial, &of.agents)?;
                    of.check(reading.values())?;
                    Accumulator::Output(of, reading, Vec::new())
                }
                MeasureKind::Line(of) => {
                    let line = places.line(&of.line)?;
                    let width = of.width_at(point, line, &spec.points)?;
                    let passages = Passages::over(line, people).with_links(&trial.geometry.links);
                    Accumulator::Line(of, passages, width)
                }
                MeasureKind::Area(of) => Accumulator::Area(of, places.area(&of.area)?, Vec::new()),
                MeasureKind::Squeeze(of) => {
                    Accumulator::Squeeze(of, of.begin(agents(&of.agents, of.across)?))
                }
                MeasureKind::Balance(of) => {
                    Accumulator::Balance(of, agents(&of.agents, of.across)?, BalanceOverTime::of(people))
                }
                MeasureKind::Breathing(of) => {
                    let begun = Box::new(BreathingOverTime::of(trial));
                    Accumulator::Breathing(of, agents(&of.agents, of.across)?, begun)
                }
                MeasureKind::Load(of) => Accumulator::Load(of, Box::new(of.begin(&trial.geometry)?)),
            })
        };
        let of_each = spec
            .measures
            .iter()
            .map(|(name, measure)| Ok((measure, begin(measure).place(|| format!("measures: {name}"))?)));
        let reading = |stop: &'a Stop| -> Result<(&'a Stop, Reading), String> {
            Ok((stop, stop.of.reading(simulation, trial, &stop.agents)?))
        };
        let of_room = |(_, measure): &(String, Measure)| matches!(&measure.kind, MeasureKind::Area(of) if of.needs_room());
        Ok(Accumulators {
            places,
            people,
            of_each: of_each.collect::<Result<_>>()?,
            stop: spec.stop.as_ref().map(reading).transpose().place(|| "stop".into())?,
            // Nobody may be outside of what is walkable.
            needs_room: spec.measures.iter().any(of_room) || places.walkable.is_some(),
            frames: Vec::new(),
            positions: Vec::new(),
        })
    }

    /// Adds a communication point; returns whether it is to be the last one.
    ///
    /// # Errors
    /// A variable cannot be read.
    pub fn add(&mut self, simulation: &mut Simulation, frame: Frame) -> Result<bool> {
        let (mut kept, time) = (false, frame.time);
        for (_, accumulator) in self.of_each.iter_mut().filter(|(measure, _)| measure.counts(time)) {
            match accumulator {
                Accumulator::Output(of, reading, agents) => {
                    of.add(agents, time, &reading.read(simulation, &frame)?);
                }
                Accumulator::Line(_, passages, _) => passages.add(&frame),
                Accumulator::Area(of, ..) if of.needs_room() => kept = true,
                Accumulator::Area(_, area, seen) => seen.push(area.measure(&frame, None)),
                Accumulator::Balance(_, _, balance) => balance.add(&frame),
                Accumulator::Breathing(_, _, breathing) => breathing.add(&frame),
                Accumulator::Squeeze(of, exposure) => exposure.see(&frame, of.by),
                Accumulator::Load(_, loads) => loads.add(&frame),
            }
        }
        if self.needs_room {
            self.positions.extend(frame.present().map(|(_, motion)| motion.pose.position));
        }
        let holds = match &self.stop {
            Some((stop, reading)) => stop.holds(&reading.read(simulation, &frame)?),
            None => false,
        };
        if kept {
            self.frames.push(Frame {
                effects: Effects::default(),
                walls: None,
                panels: None,
                legs: None,
                ..frame
            });
        }
        Ok(holds)
    }

    /// Returns the measures of the point of this Trial.
    ///
    /// # Errors
    /// Somebody was outside of the given walkable area.
    pub fn finish(self, trial: &Trial) -> Result<Vec<Option<f64>>, String> {
        let Accumulators { places, people, of_each, needs_room, frames, positions, .. } = self;
        let room = needs_room.then(|| places.room(&trial.geometry.walls, &positions)).transpose()?;
        let mut densities: HashMap<&str, Vec<Density>> = HashMap::new();
        let values = of_each.into_iter().map(|(measure, accumulator)| match accumulator {
            Accumulator::Output(of, _, agents) => of.value(&agents),
            Accumulator::Line(of, passages, width) => of.value(&passages, width, people),
            Accumulator::Area(of, area, _) if of.needs_room() => {
                let all = || frames.iter().map(|frame| area.measure(frame, room.as_ref())).collect();
                let seen = &*densities.entry(&of.area).or_insert_with(all);
                of.value(seen.iter().filter(|seen| measure.counts(seen.time)))
            }
            Accumulator::Area(of, _, seen) => of.value(seen.iter()),
            Accumulator::Squeeze(of, exposure) => of.value(&exposure),
            Accumulator::Balance(of, agents, balance) => of.value(&agents, balance),
            Accumulator::Breathing(of, agents, breathing) => of.value(&agents, *breathing),
            Accumulator::Load(of, loads) => of.value(*loads),
        });
        Ok(values.collect())
    }
}
