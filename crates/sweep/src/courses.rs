//! The measures of a point while it runs.

use crate::measure::Measure;
use crate::measure::area::InArea;
use crate::measure::line::Crossed;
use crate::measure::output::Watched;
use crate::measure::squeeze::Squeezed;
use crate::places::Places;
use crate::spec::Spec;
use crate::subject::{Reads, Subject};
use lemons_core::plane::Vec2;
use lemons_core::trial::Wall;
use lemons_results::Frame;
use lemons_results::measure::Density;
use std::collections::HashMap;

/// All measures of a point.
pub struct Courses<'a> {
    places: &'a Places,
    of_each: Vec<Course<'a>>,
    kept: Option<Kept>,
}

enum Course<'a> {
    Output(Watched<'a>),
    Line(Crossed<'a>),
    Area(&'a InArea, Vec<Density>),
    /// What is measured at the end, in the frames that are kept.
    AreaOfRoom(&'a InArea),
    Squeeze(Squeezed<'a>),
}

/// What is needed at the end: only then it is known where people could be.
#[derive(Default)]
struct Kept {
    /// In which areas are measured.
    frames: Vec<Frame>,
    /// \[m\] Of everybody, in all other frames.
    positions: Vec<Vec2>,
}

impl<'a> Courses<'a> {
    /// Before the point begins.
    ///
    /// # Errors
    /// A sentence: its parameters are no possible width.
    pub fn begin(spec: &'a Spec, subject: &'a Subject, point: usize) -> Result<Courses<'a>, String> {
        let (people, places) = (subject.documents.trial.agents.len(), &spec.places);
        let of_each = spec.measures.iter().zip(&subject.measures).map(|((_, measure), reads)| {
            Ok(match measure {
                Measure::Output(of) => Course::Output(Watched::new(of)),
                Measure::Line(of) => Course::Line(Crossed::new(of, places, &spec.points, point, people)?),
                Measure::Area(of) if of.needs_room() => Course::AreaOfRoom(of),
                Measure::Area(of) => Course::Area(of, Vec::new()),
                Measure::Squeeze(of) => {
                    let agents = if let Reads::Crowd(agents) = reads { &agents[..] } else { &[] };
                    Course::Squeeze(Squeezed::new(of, agents))
                }
            })
        });
        let of_each: Vec<Course> = of_each.collect::<Result<_, String>>()?;
        let of_room = of_each.iter().any(|course| matches!(course, Course::AreaOfRoom(_)));
        // Nobody may be outside of what is walkable.
        let kept = (of_room || places.has_walkable()).then(Kept::default);
        Ok(Courses { places, of_each, kept })
    }

    /// Shows a measure the values of its output at a time \[s\]; `None` of those who have left.
    pub fn see_values(&mut self, place: usize, time: f64, values: impl Iterator<Item = Option<f64>>) {
        if let Some(Course::Output(watched)) = self.of_each.get_mut(place) {
            watched.look(time, values);
        }
    }

    /// Shows all others the crowd.
    ///
    /// # Errors
    /// A sentence: an area is not known.
    pub fn see_frame(&mut self, frame: Frame) -> Result<(), String> {
        let mut wanted = false;
        for course in &mut self.of_each {
            match course {
                Course::Line(crossed) => crossed.add(&frame),
                Course::Squeeze(squeezed) => squeezed.add(&frame),
                Course::Area(of, seen) if of.span().has(frame.time) => {
                    seen.push(self.places.area(&of.area)?.measure(&frame, None));
                }
                Course::AreaOfRoom(of) => wanted |= of.span().has(frame.time),
                Course::Output(_) | Course::Area(..) => {}
            }
        }
        match &mut self.kept {
            Some(kept) if wanted => kept.frames.push(Frame { observed: None, ..frame }),
            Some(kept) => kept.positions.extend(frame.present().map(|(_, motion)| motion.pose.position)),
            None => {}
        }
        Ok(())
    }

    /// Returns the measures of the point, within these walls.
    ///
    /// # Errors
    /// A sentence: somebody was outside of the given walkable area.
    pub fn finish(self, walls: &[Wall]) -> Result<Vec<Option<f64>>, String> {
        let Courses { places, of_each, kept } = self;
        let room = kept.as_ref().map(|kept| places.room(walls, kept.all_positions())).transpose()?;
        let frames = kept.map(|kept| kept.frames).unwrap_or_default();
        // By the area and the frame.
        let mut seen: HashMap<(&str, usize), Density> = HashMap::new();
        let values = of_each.into_iter().map(|course| {
            Ok(match course {
                Course::Output(watched) => watched.value(),
                Course::Line(crossed) => crossed.value(),
                Course::Squeeze(squeezed) => squeezed.value(),
                Course::Area(of, seen) => of.value(&seen),
                Course::AreaOfRoom(of) => {
                    let area = places.area(&of.area)?;
                    let in_span = frames.iter().enumerate().filter(|(_, frame)| of.span().has(frame.time));
                    let own: Vec<Density> = in_span
                        .map(|(k, frame)| {
                            let measured = || area.measure(frame, room.as_ref());
                            *seen.entry((&of.area, k)).or_insert_with(measured)
                        })
                        .collect();
                    of.value(&own)
                }
            })
        });
        values.collect()
    }
}

impl Kept {
    /// \[m\] Of everybody at all times.
    fn all_positions(&self) -> impl Iterator<Item = Vec2> + Clone {
        let of_frames = self.frames.iter().flat_map(Frame::present).map(|(_, motion)| motion.pose.position);
        of_frames.chain(self.positions.iter().copied())
    }
}
