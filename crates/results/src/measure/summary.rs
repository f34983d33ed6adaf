//! Summary of lines and areas: numbers that do not depend on time.

use crate::measure::crossing::Way;
use crate::measure::flow::Flow;
use crate::measure::passages::Passages;
use serde::Serialize;

/// Crossings of a line in a direction. What is not known is `None`. The names of the fields are those of the numbers in
/// files.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Crossings {
    /// Its name.
    pub direction: &'static str,
    /// People who crossed at least once.
    pub people: usize,
    /// All crossings, also of people who came back and crossed again.
    pub crossings: usize,
    /// \[s\] When the first of these people crossed.
    pub first: Option<f64>,
    /// \[s\] When the last of these people crossed for the first time.
    pub last: Option<f64>,
    /// \[1/s\] Between the first and the last of them.
    pub flow: Option<f64>,
    /// \[1/(m s)\] The flow over a width.
    pub specific_flow: Option<f64>,
    /// \[s\] Time gaps between successive people: 10 % quantile.
    pub gap_10: Option<f64>,
    /// \[s\] Their median.
    pub gap_median: Option<f64>,
    /// \[s\] Their 90 % quantile.
    pub gap_90: Option<f64>,
    /// People who crossed and did not come back.
    pub across: usize,
    /// All others.
    pub not_across: usize,
    /// \[s\] When the last of all people was across for good.
    pub evacuation_time: Option<f64>,
}

impl Crossings {
    /// Sums up what was seen of so many people; `width` \[m\] is that of the specific flow.
    pub fn of(seen: &Passages, way: Way, width: f64, people: usize) -> Crossings {
        let (passages, stayed) = (seen.first(way), seen.stayed(way));
        let flow = Flow::of(&passages);
        Crossings {
            direction: way.name(),
            people: passages.len(),
            crossings: seen.crossings(way),
            first: passages.first().map(|passage| passage.time),
            last: passages.last().map(|passage| passage.time),
            flow: flow.rate,
            specific_flow: flow.rate.map(|rate| rate / width),
            gap_10: flow.gap(0.1),
            gap_median: flow.gap(0.5),
            gap_90: flow.gap(0.9),
            across: stayed.len(),
            not_across: people - stayed.len(),
            evacuation_time: stayed.last().copied().filter(|_| stayed.len() == people),
        }
    }
}

/// Mean and greatest of values over time.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct MeanMax {
    /// All values count the same.
    pub mean: f64,
    /// The greatest.
    pub max: f64,
}

impl MeanMax {
    /// Sums up values; `None` without any.
    pub fn of(values: impl Iterator<Item = f64>) -> Option<MeanMax> {
        let values: Vec<f64> = values.collect();
        let max = values.iter().copied().reduce(f64::max)?;
        Some(MeanMax { mean: values.iter().sum::<f64>() / values.len() as f64, max })
    }
}
