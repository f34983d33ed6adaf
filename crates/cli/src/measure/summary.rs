//! All numbers of a measurement that do not depend on time: what is printed, and what is written as JSON.

use super::options::Labelled;
use lemons_results::Trajectories;
use lemons_results::measure::BREATHING_LOADS as LOADS;
use lemons_results::measure::{
    Across, Breathing, CountingLine, Crossings, Density, Exposed, Kept, Left, MeanMax, MeasuringArea, Panel,
    Passages, SPANS, SqueezeOverTime, WallLoad, WallLoads, Way,
};
use serde::Serialize;

/// Quantiles of the people, by their squeeze.
pub const QUANTILES: [f64; 3] = [0.5, 0.9, 1.0];

/// SI units; null: not known. What tables and pictures have of each frame and person is beside it, and not in the JSON.
#[derive(Serialize)]
pub struct RunSummary {
    pub source: String,
    /// \[s\]
    pub from: f64,
    /// \[s\]
    pub until: f64,
    pub frames: usize,
    pub people: usize,
    /// How velocities were calculated; not there for our runs, which have some.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trajectories: Option<OfTrajectories>,
    /// People who have left, by any exit; null: nobody can leave.
    pub left: Option<Left>,
    pub lines: Vec<OfLine>,
    pub areas: Vec<OfArea>,
    pub exposure: Option<SqueezeSummary>,
    pub exposure_left_out: Option<&'static str>,
    /// Loads on walls; null: not asked for.
    pub walls: Option<Vec<LoadedWall>>,
    /// The same on their panels.
    pub panels: Option<Vec<LoadedPanel>>,
    /// How people kept their balance; null: they have no legs.
    pub balance: Option<BalanceSummary>,
    /// How long trunks were pressed; null: not asked for.
    pub breathing: Option<BreathingSummary>,
    /// Notes of what the squeezes can mean, and what not.
    pub notes: Vec<String>,
    /// \[s\], \[N\] Of the mean squeezes of all people over the second that ends then: those of [`QUANTILES`].
    #[serde(skip)]
    pub spread: Vec<(f64, [f64; QUANTILES.len()])>,
}

/// Properties of trajectories that are not of our runs.
#[derive(Serialize)]
pub struct OfTrajectories {
    /// \[1/s\]
    pub frame_rate: f64,
    /// \[s\] Time between the positions whose difference is the velocity.
    pub velocity_over: f64,
    /// Half of it in frames, as PedPy wants it.
    pub frame_step: usize,
}

impl OfTrajectories {
    pub fn of(known: &Trajectories) -> OfTrajectories {
        let Trajectories { rate, velocity_frames, .. } = known;
        OfTrajectories {
            frame_rate: *rate,
            velocity_over: known.velocity_over(),
            frame_step: *velocity_frames,
        }
    }
}

#[derive(Serialize)]
pub struct OfLine {
    pub name: String,
    /// \[m\]
    pub from: [f64; 2],
    /// \[m\]
    pub to: [f64; 2],
    /// \[m\] For the specific flow.
    pub width: f64,
    pub directions: [Crossings; 2],
    #[serde(skip)]
    pub passages: Passages,
}

impl OfLine {
    pub fn of(
        Labelled { name, what }: &Labelled<CountingLine>,
        width: Option<f64>,
        passages: Passages,
        people: usize,
    ) -> OfLine {
        let width = width.unwrap_or(what.length());
        let directions = Way::ALL.map(|way| Crossings::of(&passages, way, width, people));
        let (name, [from, to]) = (name.clone(), [what.from, what.to].map(Into::into));
        OfLine { name, from, to, width, directions, passages }
    }
}

#[derive(Serialize)]
pub struct OfArea {
    pub name: String,
    /// \[m²\]
    pub area: f64,
    /// Means of all frames, and the greatest value.
    pub people: MeanMax,
    /// \[1/m²\]
    pub density: MeanMax,
    /// \[1/m²\] null: where people can be is not known.
    pub voronoi_density: Option<MeanMax>,
    /// \[m/s\] Of the frames with anybody.
    pub speed: Option<MeanMax>,
    #[serde(skip)]
    pub over_time: Vec<Density>,
}

impl OfArea {
    pub fn of(Labelled { name, what }: &Labelled<MeasuringArea>, over_time: Vec<Density>) -> OfArea {
        let of = |value: fn(&Density) -> Option<f64>| MeanMax::of(over_time.iter().filter_map(value));
        OfArea {
            name: name.clone(),
            area: what.area(),
            people: of(|seen| Some(seen.people as f64)).unwrap_or_default(),
            density: of(|seen| Some(seen.density)).unwrap_or_default(),
            voronoi_density: of(|seen| seen.voronoi_density),
            speed: of(|seen| seen.speed),
            over_time,
        }
    }
}

/// Load on a wall in all.
#[derive(Serialize)]
pub struct LoadedWall {
    /// Id of the wall.
    pub wall: String,
    #[serde(flatten)]
    pub load: WallLoad,
}

/// Load on a panel.
#[derive(Serialize)]
pub struct LoadedPanel {
    #[serde(flatten)]
    pub place: Panel,
    #[serde(flatten)]
    pub load: WallLoad,
}

/// Returns the loads on walls and on their panels.
pub fn of_walls(loads: WallLoads) -> (Vec<LoadedWall>, Vec<LoadedPanel>) {
    let walls = loads.walls.into_iter().map(|(wall, load)| LoadedWall { wall, load }).collect();
    (walls, loads.panels.into_iter().map(|(place, load)| LoadedPanel { place, load }).collect())
}

#[derive(Serialize)]
pub struct BalanceSummary {
    /// How many people fell.
    pub fallen: usize,
    /// Of all people together.
    pub steps: u64,
    /// \[s\]
    pub time_unbalanced: OfPeople,
    /// \[m\] The largest of each person.
    pub lean: OfPeople,
    #[serde(skip)]
    pub each: Vec<Kept>,
}

impl BalanceSummary {
    /// `None` without people.
    pub fn of(each: Vec<Kept>, ids: &[String]) -> Option<BalanceSummary> {
        Some(BalanceSummary {
            fallen: each.iter().filter(|one| one.falls > 0).count(),
            steps: each.iter().map(|one| u64::from(one.steps)).sum(),
            time_unbalanced: OfPeople::of(&each, ids, |one| Some(one.time_unbalanced))?,
            lean: OfPeople::of(&each, ids, |one| Some(one.lean))?,
            each,
        })
    }
}

#[derive(Serialize)]
pub struct BreathingSummary {
    /// How many would have become critical, if they bear as much as the median.
    pub critical: usize,
    /// The same, as people differ: the sum of their parts.
    pub expected: f64,
    /// \[s\] When the first of them was; null: nobody.
    pub first: Option<f64>,
    pub dose: OfPeople,
    /// \[N\]
    pub front: OfPeople,
    /// \[N\]
    pub side: OfPeople,
    /// \[N\]
    pub least: OfPeople,
    /// \[s\]
    pub above: [(f64, OfPeople); LOADS.len()],
    #[serde(skip)]
    pub each: Vec<Breathing>,
}

impl BreathingSummary {
    /// `None` without people.
    pub fn of(each: Vec<Breathing>, ids: &[String]) -> Option<BreathingSummary> {
        let of = |number: fn(&Breathing) -> f64| OfPeople::of(&each, ids, |one| Some(number(one)));
        let above = [of(|one| one.above_623)?, of(|one| one.above_1112)?, of(|one| one.above_6227)?];
        let mut above = LOADS.into_iter().zip(above);
        Some(BreathingSummary {
            critical: each.iter().filter(|one| one.critical_at.is_some()).count(),
            expected: each.iter().map(|one| one.critical_part).sum(),
            first: each.iter().filter_map(|one| one.critical_at).reduce(f64::min),
            dose: of(|one| one.dose)?,
            front: of(|one| one.front)?,
            side: of(|one| one.side)?,
            least: of(|one| one.least)?,
            above: [above.next()?, above.next()?, above.next()?],
            each,
        })
    }
}

#[derive(Serialize)]
pub struct SqueezeSummary {
    /// \[s\]
    pub longest_step: f64,
    /// \[s\] Of the means that are compared with the levels; null: each communication step.
    pub above_over: Option<f64>,
    pub time_above: Vec<OfLevel>,
    pub largest_mean: Vec<OfSpan>,
    /// \[N\]
    pub peak: OfPeople,
    /// \[N s\]
    pub impulse: OfPeople,
    /// The parts of means and impulse by other people; null: the record does not say.
    pub by_people: Option<OfPart>,
    /// The parts by walls.
    pub by_walls: Option<OfPart>,
    #[serde(skip)]
    pub each: Vec<Exposed>,
}

/// The squeeze by people or by walls alone. The means of the two may be greatest at different times.
#[derive(Serialize)]
pub struct OfPart {
    pub largest_mean: Vec<OfSpan>,
    /// \[N s\]
    pub impulse: OfPeople,
    #[serde(skip)]
    pub each: Vec<Exposed>,
}

#[derive(Serialize)]
pub struct OfLevel {
    /// \[N\]
    pub above: f64,
    /// How many were above it at all; null as `time`.
    pub people: Option<usize>,
    /// \[s\] null: the record is shorter than the means, or a communication step is longer.
    pub time: Option<OfPeople>,
    /// \[s\] The longest time of each person without a break.
    pub longest: Option<OfPeople>,
    /// \[s\] When somebody was above it at first; null: nobody was, or as `time`.
    pub first: Option<f64>,
}

#[derive(Serialize)]
pub struct OfSpan {
    /// \[s\]
    pub over: f64,
    /// \[N\]
    pub mean: Option<OfPeople>,
}

/// How a number is spread over people.
#[derive(Serialize, Clone)]
pub struct OfPeople {
    pub median: f64,
    pub quantile_90: f64,
    pub max: f64,
    /// Id of the person with the greatest value.
    pub max_id: String,
}

impl SqueezeSummary {
    /// Sums up who was squeezed how much, in all and by each of [`By::ALL`](lemons_results::measure::By); `None` without
    /// people.
    ///
    /// # Errors
    /// Why it is not known.
    pub fn of(
        seen: &SqueezeOverTime,
        parts: &[SqueezeOverTime; 2],
        (levels, over): (&[f64], Option<f64>),
        ids: &[String],
    ) -> Result<Option<SqueezeSummary>, &'static str> {
        let each = seen.finish()?;
        let level = |(k, &above): (usize, &f64)| {
            let first = each.iter().filter_map(|one| one.above[k]?.first);
            let time = OfPeople::of(&each, ids, |one| Some(one.above[k]?.time));
            let people = time.as_ref().map(|_| first.clone().count());
            let longest = OfPeople::of(&each, ids, |one| Some(one.above[k]?.longest));
            OfLevel { above, people, time, longest, first: first.reduce(f64::min) }
        };
        let time_above = levels.iter().enumerate().map(level).collect();
        let part = |seen: &SqueezeOverTime| OfPart::of(seen.finish().ok()?, ids);
        let ([by_people, by_walls], whole) = (parts.each_ref().map(part), OfPart::of(each.clone(), ids));
        let peak = OfPeople::of(&each, ids, |one| Some(one.peak));
        Ok(whole.zip(peak).map(|(OfPart { largest_mean, impulse, .. }, peak)| SqueezeSummary {
            longest_step: seen.longest_step(),
            above_over: over,
            time_above,
            largest_mean,
            peak,
            impulse,
            by_people,
            by_walls,
            each,
        }))
    }
}

impl OfPart {
    fn of(each: Vec<Exposed>, ids: &[String]) -> Option<OfPart> {
        let span = |(k, over)| OfSpan { over, mean: OfPeople::of(&each, ids, |one| one.largest_mean[k]) };
        let largest_mean = SPANS.into_iter().enumerate().map(span).collect();
        Some(OfPart { largest_mean, impulse: OfPeople::of(&each, ids, |one| Some(one.impulse))?, each })
    }
}

impl OfPeople {
    /// `None` if the number is not known of somebody, or without people.
    fn of<T>(each: &[T], ids: &[String], number: impl Fn(&T) -> Option<f64>) -> Option<OfPeople> {
        let values: Vec<f64> = each.iter().map(number).collect::<Option<_>>()?;
        // The first of several.
        let most = (0..values.len()).reduce(|a, b| if values[b] > values[a] { b } else { a })?;
        let of = |across: Across| across.of(values.iter().copied());
        Some(OfPeople {
            median: of(Across::Median)?,
            quantile_90: of(Across::Quantile90)?,
            max: values[most],
            max_id: ids[most].clone(),
        })
    }
}
