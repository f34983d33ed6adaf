//! The style of scenes: options that `lemons plot` and `lemons movie` share, and the scenes of a run in it.

use super::measured::{CoordinateOrigin, MeasuredPaths};
use super::quantity::{DrawnQuantity, DrawnValues, longest_gap};
use super::trial_run::{Bodies, CrowdState, TrialRun};
use crate::error::Misused;
use crate::interrupt::Interrupt;
use crate::values::{array, number, positive};
use anyhow::{Result, bail};
use clap::ValueEnum;
use crowd_mechanics::engine::PairForce;
use lemons_core::plane::{Vec2, vec2};
use lemons_core::trial::carried_from;
use lemons_picture::{
    Bounds, Colour, DrawnForce, Fill, PictureScene, Style, Theme, Trail, Values, ids_without_room,
};
use lemons_results::columns::Effect;
use lemons_results::{Frame, Run};
use lemons_sim::Replay;
use std::path::PathBuf;

/// Colour of circles that stand for bodies.
const PLAIN: Colour = Colour(0x8c, 0xb4, 0xde);
/// \[m\] A trail's points are not nearer than this to each other.
const TRAIL_STEP: f64 = 0.005;
/// \[1\], \[N\] Recorded and computed squeezes agree to this.
const AGREEMENT: (f64, f64) = (1e-3, 1.0);
/// The colour bar ends at this quantile of the values that are not zero.
const CLIP: f64 = 0.98;
/// \[N\] Up to how much squeeze people are grey, and what the upper end does not go below.
const NOTHING: (f64, f64) = (200.0, 400.0);

#[derive(clap::Args)]
#[command(next_help_heading = "Look")]
pub struct StyleArguments {
    /// Colour of the bodies: area, kind, speed, contacts, squeeze (mean over the communication step that ends
    /// at this time, or --over), greatest-squeeze (the greatest such mean until this time), peak-squeeze
    /// (largest value within that step), one colour such as #8cb4de; where people have legs also lean,
    /// unbalanced (for how long until this time), steps, fallen
    #[arg(long, value_name = "FILL", default_value = "area", value_parser = filling)]
    pub fill: Filling,
    /// Show squeeze and greatest-squeeze as means over so many seconds before the time, which are not known
    /// at first. Default: over one communication step, in which single collisions count
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub over: Option<f64>,
    /// Values at the two ends of the colour bar. Default: 0 and the 98 % quantile
    /// of the values that are not 0 (the bar says ≥ if there are greater ones); of squeeze, 200 N, up to
    /// which bodies are grey, and this quantile or 400 N if it is less; for areas, the least and the
    /// greatest
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, allow_hyphen_values = true)]
    pub range: Option<(f64, f64)>,
    /// Draw contacts as lines whose width shows the normal force
    #[arg(long)]
    forces: bool,
    /// Force of the widest line, in newtons. Default: the greatest force that is drawn
    #[arg(long, value_name = "NEWTONS", requires = "forces", value_parser = positive)]
    widest: Option<f64>,
    /// Draw the path of everybody; --trails=2: the path of the last two seconds
    #[arg(long, value_name = "SECONDS", num_args = 0..=1, require_equals = true, default_missing_value = "inf", value_parser = number(|value| value > 0.0, "a positive number of seconds"))]
    trails: Option<f64>,
    /// Draw measured trajectories, dashed: a CSV file with columns t,id,x,y; id is the Id in Agents.xml
    #[arg(long, value_name = "FILE.csv")]
    measured: Option<PathBuf>,
    /// Meaning of x and y of the measured trajectories
    #[arg(long, value_name = "ORIGIN", default_value = "plane", requires = "measured")]
    measured_from: CoordinateOrigin,
    /// Draw only the disks and walls at this height, in metres: of people in levels
    #[arg(long, value_name = "METRES", conflicts_with = "forces", value_parser = number(|height| (0.0..1e3).contains(&height), "a height in metres, not below 0"))]
    height: Option<f64>,
    /// Draw the agents' Ids on the bodies
    #[arg(long)]
    ids: bool,
    /// Do not mark which way each body faces
    #[arg(long)]
    no_orientation: bool,
    /// Do not draw the feet of people who have legs, and how far their bodies lean
    #[arg(long)]
    no_legs: bool,
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

/// Meaning of the colour of a body.
#[derive(Clone)]
pub enum Filling {
    Of(DrawnQuantity),
    Other(Fill),
}

fn filling(text: &str) -> Result<Filling, String> {
    match text {
        "area" => return Ok(Filling::Other(Fill::BodyArea)),
        "kind" => return Ok(Filling::Other(Fill::Kind)),
        _ => {}
    }
    if let Some(colour) = colour(text) {
        return Ok(Filling::Other(Fill::Single(colour)));
    }
    match DrawnQuantity::from_str(text, false) {
        Ok(quantity) if !matches!(quantity, DrawnQuantity::X | DrawnQuantity::Y) => Ok(Filling::Of(quantity)),
        _ => Err("must be area, kind, speed, contacts, squeeze, greatest-squeeze, peak-squeeze, lean, unbalanced, steps, fallen or a \
                colour as in #8cb4de"
            .into()),
    }
}

fn colour(text: &str) -> Option<Colour> {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6 && digits.is_ascii())?;
    let part = |k: usize| u8::from_str_radix(&digits[k..k + 2], 16).ok();
    Some(Colour(part(0)?, part(2)?, part(4)?))
}

fn range(text: &str) -> Result<(f64, f64), String> {
    match array(text) {
        Some([low, high]) if low < high => Ok((low, high)),
        _ => Err("must be two numbers, the lower first, as in 0,500".into()),
    }
}

fn view(text: &str) -> Result<Bounds, String> {
    match array(text) {
        Some([x0, y0, x1, y1]) if x0 < x1 && y0 < y1 => Ok(Bounds { low: vec2(x0, y0), high: vec2(x1, y1) }),
        _ => Err("must be the lower left and the upper right corner, as in -1,0,4,2.5".into()),
    }
}

/// The scenes of one run: all in one view, their colours and widths on one scale.
pub struct Scenes<'r> {
    arguments: &'r StyleArguments,
    run: &'r TrialRun,
    measured: Option<MeasuredPaths>,
    /// If forces are shown.
    replay: Option<Replay<'r>>,
    /// A scene without poses, trails and forces.
    scene: PictureScene<'r>,
    /// A style without values and time.
    style: Style,
    /// The quantity that colours show, unless they are of areas or a single one.
    shown: Option<DrawnValues>,
    /// True if it was told that the run had other parameters than the Trial.
    told: bool,
}

/// Returns how many decimals it takes to tell the times, from 2 to 4.
fn decimals(times: &[f64]) -> usize {
    let exact = |places: &usize| {
        let unit = 10f64.powi(-(*places as i32));
        times.iter().all(|time| ((time / unit).round() * unit - time).abs() < 1e-6)
    };
    (2..4).find(exact).unwrap_or(4)
}

impl StyleArguments {
    pub fn theme(&self) -> Theme {
        if self.dark { Theme::Dark } else { Theme::Light }
    }

    /// Returns whether scenes show where people were before.
    pub fn shows_trails(&self) -> bool {
        self.trails.is_some() || self.measured.is_some()
    }

    /// \[m\] Returns the feet that are drawn.
    fn feet(&self, state: &CrowdState) -> Vec<Vec2> {
        if self.no_legs { Vec::new() } else { state.feet() }
    }

    /// Returns whether scenes depend on all that was before.
    pub fn needs_all(&self) -> bool {
        self.shows_trails()
            || self.over.is_some()
            || self.quantity().is_some_and(DrawnQuantity::is_of_the_past)
    }

    /// Says so if colours are of single steps, and those between two pictures of a movie \[s\] are not shown.
    pub fn note_sampled(&self, run: &Run, between: f64) {
        let of_step = match self.quantity() {
            Some(DrawnQuantity::Squeeze) => self.over.is_none(),
            quantity => quantity == Some(DrawnQuantity::PeakSqueeze),
        };
        let longest = longest_gap(run);
        if of_step && longest > 0.0 && between > 1.5 * longest {
            note!(
                "note: each picture shows one step of {longest:.6} s, and the next picture is {between:.6} s later: what \
                 is between is not shown (--fill squeeze --over 1: means over the last second)"
            );
        }
    }

    /// Returns the quantity that colours show, if they do.
    fn quantity(&self) -> Option<DrawnQuantity> {
        if let Filling::Of(quantity) = self.fill { Some(quantity) } else { None }
    }

    /// Checks that means over a time are shown where they are asked for: as colours, or in `series`.
    pub fn check(&self, series: &[DrawnQuantity]) -> Result<()> {
        let colours = self.quantity();
        if self.over.is_some() && !series.iter().chain(&colours).any(|quantity| quantity.is_mean()) {
            bail!(Misused(
                "--over is for squeeze and greatest-squeeze (--fill, --series), and neither is shown".into()
            ));
        }
        Ok(())
    }

    /// Reads the measured trajectories that are drawn beside a run.
    pub fn measured(&self, run: &Run) -> Result<Option<MeasuredPaths>> {
        let placed = |path: &PathBuf| MeasuredPaths::read(path)?.placed(self.measured_from, run);
        self.measured.as_ref().map(placed).transpose()
    }
}

impl<'r> Scenes<'r> {
    /// Prepares scenes at these times.
    pub fn new(
        arguments: &'r StyleArguments,
        run: &'r TrialRun,
        times: &[f64],
        interrupt: &Interrupt,
    ) -> Result<Scenes<'r>> {
        if arguments.forces && run.bodies != Bodies::Known {
            bail!(
                "{}: --forces: these are positions only, without bodies and forces",
                run.run.source.display()
            );
        }
        let shown =
            arguments.quantity().map(|of| DrawnValues::of(of, &run.run, arguments.over)).transpose()?;
        let mut scenes = Scenes {
            arguments,
            run,
            measured: arguments.measured(&run.run)?,
            replay: arguments.forces.then(|| Replay::new(&run.trial)).transpose()?,
            scene: PictureScene::at_start(&run.trial).at_height(arguments.height),
            style: Style::default(),
            shown,
            told: false,
        };
        // One time after the other: states of a long movie would not go into memory together.
        let (mut spread, mut widest, mut extent) = (Vec::new(), arguments.widest, None::<Bounds>);
        let mut extend =
            |own: Bounds| extent = Bounds::of(extent.into_iter().chain([own]).flat_map(|b| [b.low, b.high]));
        let mut beyond = false;
        for time in times {
            interrupt.check()?;
            let state = run.at(*time);
            for value in scenes.shown.iter().flat_map(|shown| shown.of_all(&state)) {
                match arguments.range {
                    Some((_, high)) => beyond |= value > high,
                    None => spread.push(value),
                }
            }
            if arguments.widest.is_none() {
                let forces = scenes.forces(&state).into_iter().map(|force| force.normal_force);
                widest = forces.chain(widest).reduce(f64::max);
            }
            scenes.scene.poses = state.poses();
            scenes.scene.feet = arguments.feet(&state);
            extend(scenes.scene.extent());
        }
        if let Some(last) = times.last().filter(|_| arguments.shows_trails()) {
            scenes.scene.trails = scenes.trails(&run.at(*last), f64::INFINITY);
            extend(scenes.scene.extent());
        }
        scenes.scene.view = arguments.view.or(extent);
        // A spike of a millisecond would leave all others at the low end. Without any but zeros the picture says so.
        let clipped = clipped(spread);
        scenes.style = Style {
            width: f64::from(arguments.width),
            fill: match (&arguments.fill, &scenes.shown) {
                // All circles have the same area.
                (Filling::Other(Fill::BodyArea), _) if run.bodies != Bodies::Known => Fill::Single(PLAIN),
                (Filling::Other(fill), _) => fill.clone(),
                (Filling::Of(_), None) => Fill::BodyArea,
                (Filling::Of(_), Some(shown)) => {
                    let quantile = clipped.and_then(|(_, beyond)| beyond.then_some(CLIP));
                    let values = Values::of(Vec::new(), &shown.label(), shown.unit());
                    Fill::Values(Values { quantile, beyond, map: shown.map(), ..values })
                }
            },
            range: arguments.range.or(clipped.map(|(high, _)| match &scenes.shown {
                Some(shown) if shown.quantity.is_squeeze() => (NOTHING.0, high.max(NOTHING.1)),
                _ => (0.0, high),
            })),
            theme: arguments.theme(),
            ids: arguments.ids,
            orientation: !arguments.no_orientation && run.bodies != (Bodies::Assumed { oriented: false }),
            forces: widest,
            time_decimals: decimals(times),
            ..Style::default()
        };
        let without = if arguments.ids { ids_without_room(&scenes.scene) } else { Vec::new() };
        if !without.is_empty() {
            note!("--ids: left out, as their bodies have no room for them: {}", without.join(", "));
        }
        Ok(scenes)
    }

    /// Returns the scene at a time \[s\], and its style.
    pub fn at(&mut self, time: f64) -> (PictureScene<'r>, Style) {
        let (run, length) = (self.run, self.arguments.trails.unwrap_or(f64::INFINITY));
        let state = &run.at(time);
        let mut scene = self.scene.clone();
        (scene.poses, scene.forces) = (state.poses(), self.forces(state));
        scene.feet = self.arguments.feet(state);
        scene.trails = if self.arguments.shows_trails() { self.trails(state, length) } else { Vec::new() };
        let mut style = Style { time: Some(state.time), ..self.style.clone() };
        if let (Some(shown), Fill::Values(values)) = (&self.shown, &mut style.fill) {
            values.values = shown.of_all(state);
        }
        (scene, style)
    }

    /// Returns the normal forces at the nearest frame: for each two that touch, their contacts together, from body to body;
    /// for each wall, from the body to where it touches.
    fn forces(&mut self, state: &CrowdState) -> Vec<DrawnForce> {
        let Some(replay) = &mut self.replay else { return Vec::new() };
        // No run of this Trial has too many in one place.
        let put = replay.put(state.frame).is_ok();
        let mut computed = Frame::default();
        replay.record(&mut computed);
        let squeeze = |frame: &Frame, agent| frame.effects.get(Effect::NormalForce, agent);
        let known = |agent| squeeze(&computed, agent).zip(squeeze(state.frame, agent));
        let agrees = put && (0..state.agents.len()).filter_map(known).all(agree);
        if !(agrees || self.told) {
            self.told = true;
            note!(
                "warning: with the Trial's parameters the contacts would not have the squeeze that the run recorded: the \
                 forces shown are not the run's (give what was set: --set)"
            );
        }
        if !put {
            return Vec::new();
        }
        let force = |PairForce { from, to, normal_force }| DrawnForce { from, to, normal_force };
        replay.forces(&state.poses()).into_iter().map(force).collect()
    }

    /// Simulated ones, then measured ones, of so many seconds until then.
    fn trails(&self, state: &CrowdState, length: f64) -> Vec<Trail> {
        let (from, to) = (state.time - length, state.time);
        let within = |time: f64| (from..=to).contains(&time);
        let run = &self.run.run;
        let frames = || run.frames.iter().filter(|frame| within(frame.time));
        let there = (0..state.agents.len()).filter(|agent| state.frame.is_there(*agent));
        let simulated = there.map(|agent| {
            let past = frames().map(|frame| frame.agents[agent].pose.position);
            let mut ways: Vec<Vec2> = past.chain([state.agents[agent].pose.position]).collect();
            // On the floor where somebody is.
            let links = &self.run.trial.geometry.links;
            let carried = ways.windows(2).rposition(|two| carried_from(links, two[0], two[1]).is_some());
            ways.drain(..carried.map_or(0, |before| before + 1));
            let points = thinned(ways.into_iter());
            Trail { agent, measured: false, points }
        });
        let measured = self.measured.iter().flat_map(|measured| {
            run.ids.iter().enumerate().map(|(agent, id)| {
                let past = measured.of(id).iter().filter(|(time, _)| within(*time)).map(|row| row.1);
                Trail { agent, measured: true, points: thinned(past) }
            })
        });
        simulated.chain(measured).filter(|trail| trail.points.len() > 1).collect()
    }
}

/// Returns the quantile [`CLIP`] of the positive values by nearest rank, and whether any is beyond it. Values that agree to
/// a thousandth count together, as the largest of them.
fn clipped(mut values: Vec<f64>) -> Option<(f64, bool)> {
    /// Bits of a number that are left out: ten bits of its mantissa remain.
    const FINE: u32 = 42;
    values.retain(|value| *value > 0.0 && value.is_finite());
    values.sort_by(f64::total_cmp);
    // The rounding of 0.98 · 50 is not a rank.
    let rank = (CLIP * values.len() as f64 - 1e-6).ceil().max(1.0) as usize;
    let bin = values.get(rank - 1)?.to_bits() >> FINE;
    let upto = values.partition_point(|value| value.to_bits() >> FINE <= bin);
    Some((values[upto - 1], upto < values.len()))
}

/// Returns whether computed and recorded squeeze agree, or the run had other parameters.
fn agree((computed, recorded): (f64, f64)) -> bool {
    let (relative, absolute) = AGREEMENT;
    (computed - recorded).abs() <= absolute + relative * recorded.max(computed)
}

/// Returns points without those nearer than this to the one before.
fn thinned(points: impl Iterator<Item = Vec2>) -> Vec<Vec2> {
    let mut kept: Vec<Vec2> = Vec::new();
    for point in points {
        if kept.last().is_none_or(|last| (point - *last).norm() >= TRAIL_STEP) {
            kept.push(point);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_is_that_of_the_nearest_rank() {
        assert_eq!(clipped(vec![0.0, -3.0, f64::NAN, f64::INFINITY]), None);
        assert_eq!(clipped((0..=50).rev().map(f64::from).collect()), Some((49.0, true)));
        assert_eq!(clipped(vec![2.0, 2.0 + 1e-9]), Some((2.0 + 1e-9, false)));
    }
}
