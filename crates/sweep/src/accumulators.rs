//! The measures of a point while it runs.

use crate::error::{Error, Result};
use crate::loaded::{LoadedModel, Reads};
use crate::measure::Measure;
use crate::measure::area::InArea;
use crate::measure::line::LineAccumulator;
use crate::measure::output::OutputAccumulator;
use crate::measure::squeeze::SqueezeAccumulator;
use crate::output::Reading;
use crate::places::Places;
use crate::spec::Spec;
use lemons_core::plane::Vec2;
use lemons_core::trial::Wall;
use lemons_results::Frame;
use lemons_results::measure::Density;
use lemons_sim::Simulation;
use std::collections::HashMap;

/// All measures of a point.
pub struct Accumulators<'a> {
    places: &'a Places,
    of_each: Vec<Accumulator<'a>>,
    /// Whether a measure needs to know where people could be, which is known at the end.
    needs_room: bool,
    /// Frames in which areas are measured at the end.
    frames: Vec<Frame>,
    /// \[m\] Of everybody, at all times.
    positions: Vec<Vec2>,
}

enum Accumulator<'a> {
    Output(OutputAccumulator<'a>, &'a Reading),
    Line(LineAccumulator<'a>),
    Area(&'a InArea, Vec<Density>),
    /// What is measured at the end, in the frames that are kept.
    AreaOfRoom(&'a InArea),
    Squeeze(SqueezeAccumulator<'a>),
}

impl<'a> Accumulators<'a> {
    /// Before the point begins.
    ///
    /// # Errors
    /// Its parameters are no possible width.
    pub fn begin(spec: &'a Spec, model: &'a LoadedModel, point: usize) -> Result<Accumulators<'a>> {
        let (people, places) = (model.documents.trial.agents.len(), &spec.places);
        let begin = |((_, measure), reads): (&'a (String, Measure), &'a Reads)| {
            Ok(match (measure, reads) {
                (Measure::Output(of), Reads::Output(reading)) => {
                    Accumulator::Output(OutputAccumulator::new(of), reading)
                }
                (Measure::Squeeze(of), Reads::Agents(agents)) => {
                    Accumulator::Squeeze(SqueezeAccumulator::new(of, agents))
                }
                (Measure::Line(of), _) => {
                    Accumulator::Line(LineAccumulator::new(of, places, &spec.points, point, people)?)
                }
                (Measure::Area(of), _) if of.needs_room() => Accumulator::AreaOfRoom(of),
                (Measure::Area(of), _) => Accumulator::Area(of, Vec::new()),
                (Measure::Output(_) | Measure::Squeeze(_), _) => {
                    unreachable!("a loaded model reads what is measured")
                }
            })
        };
        let of_each =
            spec.measures.iter().zip(&model.measures).map(begin).collect::<Result<Vec<_>, String>>();
        let of_each = of_each.map_err(Error::Spec)?;
        let of_room = of_each.iter().any(|of| matches!(of, Accumulator::AreaOfRoom(_)));
        // Nobody may be outside of what is walkable.
        let needs_room = of_room || places.walkable.is_some();
        Ok(Accumulators { places, of_each, needs_room, frames: Vec::new(), positions: Vec::new() })
    }

    /// Adds a communication point.
    ///
    /// # Errors
    /// A variable cannot be read.
    pub fn add(&mut self, simulation: &mut Simulation, frame: Frame) -> Result<()> {
        let mut kept = false;
        for accumulator in &mut self.of_each {
            match accumulator {
                Accumulator::Output(of, reading) => of.add(frame.time, &reading.read(simulation, &frame)?),
                Accumulator::Line(of) => of.add(&frame),
                Accumulator::Squeeze(of) => of.add(&frame),
                Accumulator::Area(of, seen) if of.span().has(frame.time) => {
                    seen.push(self.places.area(&of.area).map_err(Error::Spec)?.measure(&frame, None));
                }
                Accumulator::AreaOfRoom(of) => kept |= of.span().has(frame.time),
                Accumulator::Area(..) => {}
            }
        }
        if self.needs_room {
            self.positions.extend(frame.present().map(|(_, motion)| motion.pose.position));
        }
        if kept {
            self.frames.push(Frame { observed: None, ..frame });
        }
        Ok(())
    }

    /// Returns the measures of the point, within these walls.
    ///
    /// # Errors
    /// Somebody was outside of the given walkable area.
    pub fn finish(self, walls: &[Wall]) -> Result<Vec<Option<f64>>, String> {
        let Accumulators { places, of_each, needs_room, frames, positions } = self;
        let room = needs_room.then(|| places.room(walls, &positions)).transpose()?;
        let mut densities: HashMap<&str, Vec<Density>> = HashMap::new();
        let values = of_each.into_iter().map(|accumulator| {
            Ok(match accumulator {
                Accumulator::Output(of, _) => of.value(),
                Accumulator::Line(of) => of.value(),
                Accumulator::Squeeze(of) => of.value(),
                Accumulator::Area(of, seen) => of.value(&seen),
                Accumulator::AreaOfRoom(of) => {
                    let area = places.area(&of.area)?;
                    let all = || frames.iter().map(|frame| area.measure(frame, room.as_ref())).collect();
                    of.value(densities.entry(&of.area).or_insert_with(all))
                }
            })
        });
        values.collect()
    }
}
