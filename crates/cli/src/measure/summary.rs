//! All numbers of a measurement that do not depend on time: what is printed, and what is written as JSON.

use super::Arguments;
use super::pass::{Seen, SeenArea, SeenLine};
use lemons_core::trial::Wall;
use lemons_results::measure::{Crossings, Density, Exposed, Kept, Left, MeanMax, SPANS, Way, quantile};
use lemons_results::{Record, Trajectories};
use serde::Serialize;

/// SI units; null: not known.
#[derive(Serialize)]
pub struct Summary {
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
    /// Who has left, by any exit; null: nobody can leave.
    pub left: Option<Left>,
    pub lines: Vec<OfLine>,
    pub areas: Vec<OfArea>,
    pub exposure: Option<OfSqueeze>,
    pub exposure_left_out: Option<&'static str>,
    /// The straight pieces of walls; null: not asked for.
    pub walls: Option<Vec<Piece>>,
    /// How people kept their balance; null: they have no legs.
    pub balance: Option<OfBalance>,
    /// What the squeezes can mean, and what not.
    pub notes: Vec<String>,
}

/// What is known of trajectories that are not of our runs.
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
    fn of(known: &Trajectories) -> OfTrajectories {
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
    pub directions: Vec<Crossings>,
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
}

/// A straight piece of a wall, and the forces of people on it.
#[derive(Serialize)]
pub struct Piece {
    /// Its place among all, from 0, as in `wall[k].MeanNormalForce`.
    pub segment: usize,
    /// Id of the wall.
    pub wall: String,
    /// \[m\]
    pub from: [f64; 2],
    /// \[m\]
    pub to: [f64; 2],
    /// \[N\] Greatest mean over a communication step.
    pub largest_mean_step: f64,
    /// \[N\] Greatest mean over 1 s; null: the record is shorter, or a communication step is longer.
    pub largest_mean_1: Option<f64>,
    /// \[N\]
    pub peak: f64,
    /// \[N s\]
    pub impulse: f64,
}

impl Piece {
    fn of(
        segment: usize,
        (wall, place): (&Wall, usize),
        (seen, largest_mean_step): &(Exposed, f64),
    ) -> Piece {
        let [from, to] = [wall.corners[place], wall.corners[place + 1]].map(Into::into);
        let [_, largest_mean_1, _] = seen.largest_mean;
        let (wall, largest_mean_step) = (wall.id.clone(), *largest_mean_step);
        let (peak, impulse) = (seen.peak, seen.impulse);
        Piece { segment, wall, from, to, largest_mean_step, largest_mean_1, peak, impulse }
    }
}

#[derive(Serialize)]
pub struct OfBalance {
    /// How many people fell.
    pub fallen: usize,
    /// Of all people together.
    pub steps: u64,
    /// \[s\]
    pub time_unbalanced: OfPeople,
    /// \[m\] The largest of each person.
    pub lean: OfPeople,
}

impl OfBalance {
    /// `None` without people.
    fn of(kept: &[Kept], ids: &[String]) -> Option<OfBalance> {
        let of = |value: fn(&Kept) -> f64| OfPeople::of(&kept.iter().map(value).collect::<Vec<_>>(), ids);
        Some(OfBalance {
            fallen: kept.iter().filter(|one| one.fallen).count(),
            steps: kept.iter().map(|one| u64::from(one.steps)).sum(),
            time_unbalanced: of(|one| one.time_unbalanced)?,
            lean: of(|one| one.lean)?,
        })
    }
}

#[derive(Serialize)]
pub struct OfSqueeze {
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
}

/// The squeeze by people or by walls alone. The means of the two may be greatest at different times.
#[derive(Serialize)]
pub struct OfPart {
    pub largest_mean: Vec<OfSpan>,
    /// \[N s\]
    pub impulse: OfPeople,
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
    /// Who has the greatest value.
    pub max_id: String,
}

impl Summary {
    /// Sums up what was seen of the people of a record.
    pub fn of(
        arguments: &Arguments,
        record: &Record,
        pieces: Vec<(&Wall, usize)>,
        seen: &Seen<'_>,
    ) -> Summary {
        let ids = record.ids();
        let of_walls = |walls: &Vec<(Exposed, f64)>| {
            let each = (0..).zip(pieces).zip(walls);
            each.map(|((segment, piece), seen)| Piece::of(segment, piece, seen)).collect()
        };
        let exposed = seen.exposed.as_deref();
        let line = |SeenLine { name, width, passages }: &SeenLine<'_>| {
            let directions = Way::ALL.map(|way| Crossings::of(passages, way, *width, ids.len())).into();
            let [from, to] = [passages.line().from, passages.line().to].map(Into::into);
            OfLine { name: (*name).to_owned(), from, to, width: *width, directions }
        };
        Summary {
            source: arguments.source.path.display().to_string(),
            from: seen.times.0,
            until: seen.times.1,
            frames: seen.frames,
            people: ids.len(),
            trajectories: record.trajectories().map(OfTrajectories::of),
            left: seen.left,
            lines: seen.lines.iter().map(line).collect(),
            areas: seen.areas.iter().map(area).collect(),
            exposure: exposed.ok().and_then(|all| OfSqueeze::of(all, ids, arguments, seen)),
            exposure_left_out: exposed.err().copied(),
            walls: seen.walls.as_ref().map(of_walls),
            balance: seen.balance.as_ref().and_then(|kept| OfBalance::of(kept, ids)),
            notes: Vec::new(),
        }
    }
}

fn area(SeenArea { name, area, over_time }: &SeenArea<'_>) -> OfArea {
    let of = |value: fn(&Density) -> f64| MeanMax::of(over_time.iter().map(value)).unwrap_or_default();
    OfArea {
        name: (*name).to_owned(),
        area: area.area(),
        people: of(|seen| seen.people as f64),
        density: of(|seen| seen.density),
        voronoi_density: MeanMax::of(over_time.iter().filter_map(|seen| seen.voronoi_density)),
        speed: MeanMax::of(over_time.iter().filter_map(|seen| seen.speed)),
    }
}

impl OfSqueeze {
    /// `None` without people.
    fn of(
        exposed: &[Exposed],
        ids: &[String],
        Arguments { above, over, .. }: &Arguments,
        seen: &Seen<'_>,
    ) -> Option<OfSqueeze> {
        let of = |value: &dyn Fn(&Exposed) -> Option<f64>| spread(exposed, ids, value);
        let level = |(k, &above): (usize, &f64)| {
            let first = exposed.iter().filter_map(|one| one.above[k]?.first);
            let time = of(&|one| one.above[k].map(|above| above.time));
            let people = time.as_ref().map(|_| first.clone().count());
            let longest = of(&|one| one.above[k].map(|above| above.longest));
            OfLevel { above, people, time, longest, first: first.reduce(f64::min) }
        };
        let [by_people, by_walls] = match &seen.exposed_by {
            Some(parts) => parts.each_ref().map(|part| OfPart::of(part, ids)),
            None => [None, None],
        };
        Some(OfSqueeze {
            longest_step: seen.longest_step,
            above_over: *over,
            time_above: above.iter().enumerate().map(level).collect(),
            largest_mean: spans(exposed, ids),
            peak: of(&|one| Some(one.peak))?,
            impulse: of(&|one| Some(one.impulse))?,
            by_people,
            by_walls,
        })
    }
}

impl OfPart {
    fn of(exposed: &[Exposed], ids: &[String]) -> Option<OfPart> {
        let impulse = spread(exposed, ids, &|one| Some(one.impulse))?;
        Some(OfPart { largest_mean: spans(exposed, ids), impulse })
    }
}

/// The greatest means over each of the spans.
fn spans(exposed: &[Exposed], ids: &[String]) -> Vec<OfSpan> {
    let span = |(k, over)| OfSpan { over, mean: spread(exposed, ids, &|one| one.largest_mean[k]) };
    SPANS.into_iter().enumerate().map(span).collect()
}

/// How a number is spread over people; `None` if it is not known of somebody.
fn spread(exposed: &[Exposed], ids: &[String], value: &dyn Fn(&Exposed) -> Option<f64>) -> Option<OfPeople> {
    let values: Option<Vec<f64>> = exposed.iter().map(value).collect();
    OfPeople::of(&values?, ids)
}

impl OfPeople {
    fn of(values: &[f64], ids: &[String]) -> Option<OfPeople> {
        // The first of several.
        let most = (0..values.len()).reduce(|a, b| if values[b] > values[a] { b } else { a })?;
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        Some(OfPeople {
            median: quantile(&sorted, 0.5)?,
            quantile_90: quantile(&sorted, 0.9)?,
            max: values[most],
            max_id: ids[most].clone(),
        })
    }
}
