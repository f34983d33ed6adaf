//! The measures of a point while it runs.

use crate::measure::Measure;
use crate::measure::area::InArea;
use crate::measure::line::Crossed;
use crate::measure::output::Watched;
use crate::measure::squeeze::Squeezed;
use crate::places::Places;
use crate::spec::Spec;
use crate::subject::{Reads, Subject};
use lemons_measure::Density;
use lemons_record::Frame;
use lemons_trial::Wall;
use std::collections::HashMap;

/// All measures of a point.
pub struct Courses<'a> {
    of_each: Vec<Course<'a>>,
    /// For areas: where people could be is known at the end.
    frames: Option<Vec<Frame>>,
}

enum Course<'a> {
    Output(Watched<'a>),
    Line(Crossed<'a>),
    Area(&'a InArea),
    Squeeze(Squeezed<'a>),
}

impl<'a> Courses<'a> {
    /// Before the point begins.
    ///
    /// # Errors
    /// A sentence: its parameters are no possible width.
    pub fn begin(spec: &'a Spec, subject: &'a Subject, point: usize) -> Result<Courses<'a>, String> {
        let people = subject.trial.agents.len();
        let of_each = spec.measures.iter().zip(&subject.measures).map(|((_, measure), reads)| {
            Ok(match measure {
                Measure::Output(of) => Course::Output(Watched::new(of)),
                Measure::Line(of) => {
                    Course::Line(Crossed::new(of, &spec.places, &spec.points, point, people)?)
                }
                Measure::Area(of) => Course::Area(of),
                Measure::Squeeze(of) => {
                    let agents = if let Reads::Crowd(agents) = reads { &agents[..] } else { &[] };
                    Course::Squeeze(Squeezed::new(of, agents))
                }
            })
        });
        let of_each: Vec<Course> = of_each.collect::<Result<_, String>>()?;
        let areas = of_each.iter().any(|course| matches!(course, Course::Area(_)));
        Ok(Courses { of_each, frames: areas.then(Vec::new) })
    }

    /// Shows a measure the values of its output at a time \[s\]; `None` of those who have left.
    pub fn see_values(&mut self, place: usize, time: f64, values: impl Iterator<Item = Option<f64>>) {
        if let Some(Course::Output(watched)) = self.of_each.get_mut(place) {
            watched.look(time, values);
        }
    }

    /// Shows all others the crowd.
    pub fn see_frame(&mut self, frame: Frame) {
        for course in &mut self.of_each {
            match course {
                Course::Line(crossed) => crossed.add(&frame),
                Course::Squeeze(squeezed) => squeezed.add(&frame),
                Course::Output(_) | Course::Area(_) => {}
            }
        }
        if let Some(frames) = &mut self.frames {
            frames.push(Frame { observed: None, ..frame });
        }
    }

    /// Returns the measures of the point, within these walls.
    ///
    /// # Errors
    /// A sentence: somebody was outside of the given walkable area.
    pub fn finish(self, places: &Places, walls: &[Wall]) -> Result<Vec<Option<f64>>, String> {
        let frames = self.frames.unwrap_or_default();
        let room = if frames.is_empty() { None } else { Some(places.room(walls, &frames)?) };
        let mut seen: HashMap<usize, Vec<Density>> = HashMap::new();
        let values = self.of_each.into_iter().map(|course| {
            Ok(match course {
                Course::Output(watched) => watched.value(),
                Course::Line(crossed) => crossed.value(),
                Course::Squeeze(squeezed) => squeezed.value(),
                Course::Area(of) => {
                    let area = places.area(&of.area)?;
                    let Some(room) = &room else { return Ok(None) };
                    let measured = || {
                        let of_frame = |frame| places.area_at(area).measure(frame, room);
                        frames.iter().map(of_frame).collect()
                    };
                    of.value(seen.entry(area).or_insert_with(measured))
                }
            })
        });
        values.collect()
    }
}
