//! All numbers of a measurement that do not depend on time: what is told, and what is written as JSON.

use super::options::Named;
use super::pass::Passed;
use super::{Arguments, shown};
use anyhow::Result;
use lemons_results::Record;
use lemons_results::measure::{
    Crossings, Density, Exposed, Left, Line, MeanMax, MeasuringArea, Passages, SPANS, Way, quantile,
};
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
    /// Who has left, by any exit; null: nobody can leave.
    pub left: Option<Left>,
    pub lines: Vec<OfLine>,
    pub areas: Vec<OfArea>,
    pub exposure: Option<OfSqueeze>,
    pub exposure_left_out: Option<String>,
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
    /// \[1/m²\]
    pub voronoi_density: MeanMax,
    /// \[m/s\] Of the frames with anybody.
    pub speed: Option<MeanMax>,
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
}

#[derive(Serialize)]
pub struct OfLevel {
    /// \[N\]
    pub above: f64,
    /// How many were above it at all; null as `time`.
    pub people: Option<usize>,
    /// \[s\] null: the record is shorter than the means, or a communication step is longer.
    pub time: Option<OfPeople>,
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
    pub fn of(arguments: &Arguments, record: &Record, passed: &Passed) -> Result<Summary> {
        let lines = arguments.lines.iter().zip(&passed.lines).enumerate();
        let areas = arguments.areas.iter().zip(&passed.areas).enumerate();
        let (exposure, why) = match &passed.exposed {
            None => {
                let why = "the results do not contain the mean squeeze over communication steps";
                (None, Some(why.to_owned()))
            }
            Some(exposed) => {
                let all = OfSqueeze::of(exposed, record.ids(), arguments, passed.longest_step);
                let why =
                    all.is_none().then(|| "there is only one frame, so no communication step".to_owned());
                (all, why)
            }
        };
        Ok(Summary {
            source: shown(&arguments.source.path),
            from: passed.times.0,
            until: passed.times.1,
            frames: passed.frames,
            people: record.ids().len(),
            left: passed.left,
            lines: lines
                .map(|(k, (line, seen))| OfLine::of(line, k, seen, arguments, record.ids().len()))
                .collect(),
            areas: areas.map(|(k, (area, seen))| OfArea::of(area, k, seen)).collect(),
            exposure,
            exposure_left_out: why,
        })
    }

    /// Why there is no exposure.
    pub fn left_out(&self) -> Option<&str> {
        self.exposure_left_out.as_deref()
    }
}

impl OfLine {
    fn of(line: &Named<Line>, k: usize, seen: &Passages, arguments: &Arguments, people: usize) -> OfLine {
        let width = arguments.width_of(&line.what);
        let directions = Way::ALL.map(|way| Crossings::of(seen, way, width, people)).into();
        let [from, to] = [line.what.from, line.what.to].map(|p| [p.x, p.y]);
        OfLine { name: line.called(k), from, to, width, directions }
    }
}

impl OfArea {
    fn of(area: &Named<MeasuringArea>, k: usize, seen: &[Density]) -> OfArea {
        let of = |value: fn(&Density) -> f64| {
            MeanMax::of(seen.iter().map(value)).unwrap_or(MeanMax { mean: 0.0, max: 0.0 })
        };
        OfArea {
            name: area.called(k),
            area: area.what.area(),
            people: of(|seen| seen.people as f64),
            density: of(|seen| seen.density),
            voronoi_density: of(|seen| seen.voronoi_density.unwrap_or(f64::NAN)),
            speed: MeanMax::of(seen.iter().filter_map(|seen| seen.speed)),
        }
    }
}

impl OfSqueeze {
    fn of(
        exposed: &[Exposed],
        ids: &[String],
        Arguments { above, over, .. }: &Arguments,
        longest_step: f64,
    ) -> Option<OfSqueeze> {
        let of = |value: &dyn Fn(&Exposed) -> Option<f64>| {
            let values: Option<Vec<f64>> = exposed.iter().map(value).collect();
            OfPeople::of(&values?, ids)
        };
        let level = |(k, &above): (usize, &f64)| {
            let people = exposed.iter().filter(|one| one.above[k] > Some(0.0)).count();
            let time = of(&|one| one.above[k]);
            OfLevel { above, people: time.as_ref().map(|_| people), time }
        };
        let spans = SPANS.into_iter().enumerate();
        (longest_step > 0.0).then_some(())?;
        Some(OfSqueeze {
            longest_step,
            above_over: *over,
            time_above: above.iter().enumerate().map(level).collect(),
            largest_mean: spans
                .map(|(k, over)| OfSpan { over, mean: of(&|one| one.largest_mean[k]) })
                .collect(),
            peak: of(&|one| Some(one.peak))?,
            impulse: of(&|one| Some(one.impulse))?,
        })
    }
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
