//! How scenes look: options that `lemons plot` and `lemons movie` share.

use super::measured::{Measured, Origin};
use super::moment::{Footage, Moment, Shadow};
use super::quantity::{Quantity, Shown, longest_gap};
use super::spread::Spread;
use crate::error::Misused;
use crate::interrupt::Interrupt;
use anyhow::{Result, bail};
use clap::ValueEnum;
use lemons_core::plane::{Vec2, vec2};
use lemons_picture::{
    Bounds, Colour, ColourMap, Fill, Force, Scene, Style, Theme, Trail, TrailKind, Values, body_area,
    ids_without_room,
};
use lemons_results::Run;
use std::path::PathBuf;

/// \[m\] A trail's points are not nearer than this to each other.
const TRAIL_STEP: f64 = 0.005;
/// The colour bar ends at this quantile of the values that are not zero.
const CLIP: f64 = 0.98;

#[derive(clap::Args)]
#[command(next_help_heading = "Look")]
pub struct Look {
    /// Colour of the bodies: area, speed, contacts, squeeze (mean over the communication step that ends
    /// at this time, or --over), greatest-squeeze (the greatest such mean until this time), peak-squeeze
    /// (largest value within that step), or one colour such as #8cb4de
    #[arg(long, value_name = "FILL", default_value = "area", value_parser = filling)]
    pub fill: Filling,
    /// Show squeeze and greatest-squeeze as means over so many seconds before the time, which are not known
    /// at first. Default: over one communication step, in which single collisions count
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    over: Option<f64>,
    /// Values at the two ends of the colour bar. Default: 0 and the 98 % quantile of the values that are
    /// not 0 (the bar says ≥ if there are greater ones); for areas, the least and the greatest
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, allow_hyphen_values = true)]
    range: Option<(f64, f64)>,
    /// Draw contacts as lines whose width shows the normal force
    #[arg(long)]
    forces: bool,
    /// Force of the widest line, in newtons. Default: the greatest force that is drawn
    #[arg(long, value_name = "NEWTONS", requires = "forces", value_parser = positive)]
    widest: Option<f64>,
    /// Draw the path of everybody; --trails=2: the path of the last two seconds
    #[arg(long, value_name = "SECONDS", num_args = 0..=1, require_equals = true, default_missing_value = "inf", value_parser = trail)]
    trails: Option<f64>,
    /// Draw measured trajectories, dashed: a CSV file with columns t,id,x,y; id is the Id in Agents.xml
    #[arg(long, value_name = "FILE.csv")]
    measured: Option<PathBuf>,
    /// Meaning of x and y of the measured trajectories
    #[arg(long, value_name = "ORIGIN", default_value = "plane", requires = "measured")]
    measured_from: Origin,
    /// Draw the agents' Ids on the bodies
    #[arg(long)]
    ids: bool,
    /// Do not mark which way each body faces
    #[arg(long)]
    no_orientation: bool,
    /// Part of the plane that is drawn, in metres. Default: walls, bodies and trails
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = view, allow_hyphen_values = true)]
    view: Option<Bounds>,
    /// Draw light on dark
    #[arg(long)]
    dark: bool,
    /// Width in pixels; the height follows from it
    #[arg(long, value_name = "PIXELS", default_value_t = 800, value_parser = clap::value_parser!(u32).range(64..=8192))]
    pub width: u32,
}

/// What the colour of a body says.
#[derive(Clone, Copy, PartialEq)]
pub enum Filling {
    Area,
    Of(Quantity),
    Single(Colour),
}

fn filling(text: &str) -> Result<Filling, String> {
    if text == "area" {
        return Ok(Filling::Area);
    }
    if let Some(colour) = colour(text) {
        return Ok(Filling::Single(colour));
    }
    match Quantity::from_str(text, false) {
        Ok(quantity) if !matches!(quantity, Quantity::X | Quantity::Y) => Ok(Filling::Of(quantity)),
        _ => Err("must be area, speed, contacts, squeeze, greatest-squeeze, peak-squeeze or a colour as in #8cb4de".into()),
    }
}

fn colour(text: &str) -> Option<Colour> {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6 && digits.is_ascii())?;
    let part = |k: usize| u8::from_str_radix(&digits[k..k + 2], 16).ok();
    Some(Colour(part(0)?, part(2)?, part(4)?))
}

fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let numbers: Vec<f64> = text.split(',').map(|part| part.trim().parse().ok()).collect::<Option<_>>()?;
    let numbers: [f64; N] = numbers.try_into().ok()?;
    numbers.iter().all(|number| number.is_finite()).then_some(numbers)
}

fn range(text: &str) -> Result<(f64, f64), String> {
    match numbers(text) {
        Some([low, high]) if low < high => Ok((low, high)),
        _ => Err("must be two numbers, the lower first, as in 0,500".into()),
    }
}

fn view(text: &str) -> Result<Bounds, String> {
    match numbers(text) {
        Some([x0, y0, x1, y1]) if x0 < x1 && y0 < y1 => Ok(Bounds { low: vec2(x0, y0), high: vec2(x1, y1) }),
        _ => Err("must be the lower left and the upper right corner, as in -1,0,4,2.5".into()),
    }
}

pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("must be a positive number".into()),
    }
}

/// Of a time.
pub fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("must be a number of seconds".into()),
    }
}

fn trail(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 => Ok(value),
        _ => Err("must be a positive number of seconds".into()),
    }
}

/// The scenes of one run: all in one view, their colours and widths on one scale.
pub struct Looks<'f> {
    look: &'f Look,
    footage: &'f Footage,
    measured: Option<Measured>,
    shadow: Option<Shadow>,
    scene: Scene<'f>,
    /// What the colours say, unless they are of areas or a single one.
    shown: Option<Shown>,
    range: Option<(f64, f64)>,
    /// Of the values shown, where some are beyond the range for it.
    quantile: Option<f64>,
    /// Whether any is above the range.
    beyond: bool,
    widest: Option<f64>,
    /// Of the time stamp.
    decimals: usize,
    other_parameters: bool,
}

/// As many as it takes to tell the times, from 2 to 4.
fn decimals(times: &[f64]) -> usize {
    let exact = |places: &usize| {
        let unit = 10f64.powi(-(*places as i32));
        times.iter().all(|time| ((time / unit).round() * unit - time).abs() < 1e-6)
    };
    (2..4).find(exact).unwrap_or(4)
}

impl Look {
    pub fn theme(&self) -> Theme {
        if self.dark { Theme::Dark } else { Theme::Light }
    }

    /// Whether scenes show where people were before.
    pub fn shows_trails(&self) -> bool {
        self.trails.is_some() || self.measured.is_some()
    }

    /// Whether scenes depend on all that was before.
    pub fn needs_all(&self) -> bool {
        self.shows_trails() || self.over.is_some() || self.fill == Filling::Of(Quantity::GreatestSqueeze)
    }

    /// Says so if colours are of single steps, and those between two pictures of a movie \[s\] are not shown.
    pub fn tell_sampled(&self, run: &Run, between: f64) {
        let of_step = match self.fill {
            Filling::Of(Quantity::Squeeze) => self.over.is_none(),
            Filling::Of(quantity) => quantity == Quantity::PeakSqueeze,
            _ => false,
        };
        let longest = longest_gap(run);
        if of_step && longest > 0.0 && between > 1.5 * longest {
            note!(
                "note: each picture shows one step of {longest:.6} s, and the next picture is {between:.6} s later: what \
                 is between is not shown (--fill squeeze --over 1: means over the last second)"
            );
        }
    }

    /// That means over a time are asked for where they are shown: as colours, or in `series`.
    ///
    /// # Errors
    /// They are not.
    pub fn check(&self, series: &[Quantity]) -> Result<()> {
        let colours = if let Filling::Of(quantity) = self.fill { Some(quantity) } else { None };
        if self.over.is_some() && !series.iter().chain(&colours).any(|quantity| quantity.is_mean()) {
            bail!(Misused(
                "--over is for squeeze and greatest-squeeze (--fill, --series), and neither is shown".into()
            ));
        }
        Ok(())
    }

    /// \[s\] `--over`
    pub fn over(&self) -> Option<f64> {
        self.over
    }

    /// `--range`
    pub fn range(&self) -> Option<(f64, f64)> {
        self.range
    }

    /// Beside a run.
    pub fn measured(&self, run: &Run) -> Result<Option<Measured>> {
        let placed = |path: &PathBuf| Measured::read(path)?.placed(self.measured_from, run);
        self.measured.as_ref().map(placed).transpose()
    }
}

impl<'f> Looks<'f> {
    /// Of scenes at these times.
    pub fn new(
        look: &'f Look,
        footage: &'f Footage,
        times: &[f64],
        interrupt: &Interrupt,
    ) -> Result<Looks<'f>> {
        let mut looks = Looks {
            look,
            footage,
            measured: look.measured(&footage.run)?,
            shadow: look.forces.then(|| Shadow::new(&footage.trial)).transpose()?,
            scene: Scene::new(&footage.trial, footage.frame(0).poses()),
            shown: match look.fill {
                Filling::Of(quantity) => Some(Shown::of(quantity, &footage.run, look.over)?),
                _ => None,
            },
            range: look.range,
            quantile: None,
            beyond: false,
            widest: look.widest,
            decimals: decimals(times),
            other_parameters: false,
        };
        // One moment after the other: those of a long movie would not go into memory together.
        let (mut spread, mut widest, mut extent) = (Spread::default(), None, None::<Bounds>);
        for time in times {
            interrupt.check()?;
            let moment = footage.at(*time);
            if let Some(shown) = &looks.shown {
                for value in shown.of_all(&moment) {
                    match look.range {
                        Some((_, high)) => looks.beyond |= value > high,
                        None => spread.add(value),
                    }
                }
            }
            if look.widest.is_none() {
                let forces = looks.forces(&moment).into_iter().map(|force| force.normal_force);
                widest = forces.chain(widest).reduce(f64::max);
            }
            looks.scene.poses = moment.poses();
            let own = looks.scene.extent();
            extent = Some(extent.map_or(own, |all| around(all, own)));
        }
        if looks.shown.is_some() && look.range.is_none() {
            // A spike of a millisecond would leave all others at the low end.
            // Without any but zeros the picture says so.
            if let Some((high, beyond)) = spread.quantile(CLIP) {
                (looks.range, looks.quantile) = (Some((0.0, high)), beyond.then_some(CLIP));
            }
        }
        looks.widest = look.widest.or(widest);
        if let Some(last) = times.last().filter(|_| look.shows_trails()) {
            let moment = footage.at(*last);
            looks.scene.trails = looks.trails(&moment, f64::INFINITY);
            extent = extent.map(|all| around(all, looks.scene.extent()));
        }
        looks.scene.view = look.view.or(extent);
        let without = if look.ids { ids_without_room(&looks.scene) } else { Vec::new() };
        if !without.is_empty() {
            note!("--ids: left out, as their bodies have no room for them: {}", without.join(", "));
        }
        Ok(looks)
    }

    /// What is to be drawn of a moment.
    pub fn scene(&mut self, moment: &Moment) -> Scene<'f> {
        let length = self.look.trails.unwrap_or(f64::INFINITY);
        let trails = if self.look.shows_trails() { self.trails(moment, length) } else { Vec::new() };
        let (poses, forces) = (moment.poses(), self.forces(moment));
        let mut scene = self.scene.clone();
        (scene.poses, scene.trails, scene.forces) = (poses, trails, forces);
        scene
    }

    /// How.
    pub fn style(&self, moment: &Moment) -> Style {
        let values = |values, label: String, unit: &str, map| {
            let (unit, range) = (unit.to_owned(), self.range);
            Fill::Values(Values {
                values,
                label,
                unit,
                range,
                quantile: self.quantile,
                beyond: self.beyond,
                map,
            })
        };
        Style {
            width: f64::from(self.look.width),
            fill: match (&self.shown, self.look.fill) {
                (Some(shown), _) => values(shown.of_all(moment), shown.label(), shown.unit(), shown.map()),
                (None, Filling::Single(colour)) => Fill::Single(colour),
                (None, _) if self.range.is_none() => Fill::BodyArea,
                (None, _) => {
                    let areas = self.footage.trial.agents.iter().map(body_area);
                    values(areas.collect(), "body area".to_owned(), "m²", ColourMap::Viridis)
                }
            },
            theme: self.look.theme(),
            ids: self.look.ids,
            orientation: !self.look.no_orientation,
            time: Some(moment.time),
            forces: self.widest,
            time_decimals: self.decimals,
            ..Style::default()
        }
    }

    /// Whether forces were shown that the run did not have: it had other parameters than the Trial.
    pub fn other_parameters(&self) -> bool {
        self.other_parameters
    }

    fn forces(&mut self, moment: &Moment) -> Vec<Force> {
        let Some(shadow) = &mut self.shadow else { return Vec::new() };
        let (forces, agree) = shadow.forces(self.footage, moment);
        self.other_parameters |= !agree;
        forces
    }

    /// Simulated ones, then measured ones, of so many seconds until the moment.
    fn trails(&self, moment: &Moment, length: f64) -> Vec<Trail> {
        let (from, to) = (moment.time - length, moment.time);
        let within = |time: f64| (from..=to).contains(&time);
        let frames = || self.footage.run.frames.iter().filter(|frame| within(frame.time));
        let there = (0..moment.agents.len()).filter(|agent| moment.there[*agent]);
        let simulated = there.map(|agent| {
            let past = frames().map(|frame| frame.agents[agent].pose.position);
            let points = thinned(past.chain([moment.agents[agent].pose.position]));
            Trail { agent: Some(agent), kind: TrailKind::Simulated, points }
        });
        let measured = self.measured.iter().flat_map(|measured| {
            self.footage.run.ids.iter().enumerate().map(|(agent, id)| {
                let past = measured.of(id).iter().filter(|(time, _)| within(*time)).map(|row| row.1);
                Trail { agent: Some(agent), kind: TrailKind::Measured, points: thinned(past) }
            })
        });
        simulated.chain(measured).filter(|trail| trail.points.len() > 1).collect()
    }
}

/// Without points nearer than this to the one before.
fn thinned(points: impl Iterator<Item = Vec2>) -> Vec<Vec2> {
    let mut kept: Vec<Vec2> = Vec::new();
    for point in points {
        if kept.last().is_none_or(|last| (point - *last).norm() >= TRAIL_STEP) {
            kept.push(point);
        }
    }
    kept
}

fn around(a: Bounds, b: Bounds) -> Bounds {
    Bounds {
        low: vec2(a.low.x.min(b.low.x), a.low.y.min(b.low.y)),
        high: vec2(a.high.x.max(b.high.x), a.high.y.max(b.high.y)),
    }
}
