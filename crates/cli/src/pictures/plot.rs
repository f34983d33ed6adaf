//! `lemons plot`: scenes, time series, a map of density.

use super::quantity::{DrawnQuantity, DrawnValues};
use super::source::{KeptFrames, Opened, RunSource};
use super::style::{Scenes, StyleArguments};
use super::trial_run::{Bodies, TrialRun, nothing_between};
use crate::error::Misused;
use crate::files::ForceOption;
use crate::interrupt::Interrupt;
use crate::output::Output;
use crate::run::until;
use crate::values::{seconds, within as number_within};
use anyhow::{Context, Result, bail};
use lemons_core::plane::Vec2;
use lemons_core::trial::PanelChoice;
use lemons_picture::{
    Chart, ChartPanel, ChartStyle, ColourMap, Curve, DENSITY_KERNEL, DensityMap, LoadMap, PictureScene,
    Style, Values, chart_svg, pdf, png, sheet, svg, titled,
};
use lemons_results::Frame;
use lemons_results::columns::Effect;
use lemons_results::measure::{LoadsOverTime, WallLoad, within};
use lemons_sim::Until;
use std::io::Write;
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    pub source: RunSource,
    /// File for the picture: PNG, or the vector formats SVG and PDF
    #[arg(short, long, default_value = "plot.png", value_name = "FILE.png, .svg or .pdf")]
    output: PathBuf,
    /// Draw scenes at the communication points nearest to these times, in seconds. Default: the start of
    /// a Trial or FMU; the end of earlier results
    #[arg(long, value_name = "T,T,…", value_delimiter = ',', allow_hyphen_values = true, conflicts_with_all = ["series", "density"])]
    at: Vec<f64>,
    /// Number of scenes in a row. Default: chosen by their shape
    #[arg(long, value_name = "N", requires = "at", value_parser = clap::value_parser!(u32).range(1..))]
    columns: Option<u32>,
    /// Draw these quantities over time for each agent, instead of scenes. Curves of contacts are drawn
    /// slightly apart; equal curves are drawn in dashes of all their colours
    #[arg(long, value_name = "QUANTITY,…", value_delimiter = ',', conflicts_with = "density")]
    series: Vec<DrawnQuantity>,
    /// Draw time series of these agents only, by Id. Default: all
    #[arg(long, value_name = "ID,…", value_delimiter = ',', requires = "series")]
    agents: Vec<String>,
    /// Draw a map of people per square metre, averaged over all frames, instead of scenes. Density does
    /// not spread through walls
    #[arg(long)]
    density: bool,
    /// Draw the loads on the panels of walls: the greatest means over 1 s in kN/m, as lemons measure --walls
    /// gives them; of a Trial or an FMU, which is simulated first
    #[arg(long, conflicts_with_all = ["at", "series", "density"])]
    walls: bool,
    // Narrower ones need more cells than a picture has pixels.
    /// Standard deviation of the Gaussian of each person in the density map, in metres
    #[arg(long, value_name = "METRES", requires = "density", default_value_t = DENSITY_KERNEL, value_parser = number_within(0.02, 100.0, " (m)"))]
    kernel: f64,
    /// Start of time series and of maps of density and loads, in seconds
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    from: Option<f64>,
    /// End of time series and of maps, in seconds. With the word left, a Trial in which people walk is
    /// run until everybody has left, as by lemons run. Default: the end of earlier results; 5 for a
    /// Trial or FMU
    #[arg(long, value_name = "SECONDS|left", value_parser = until)]
    until: Option<Until>,
    #[command(flatten)]
    _force: ForceOption,
    #[command(flatten)]
    style: StyleArguments,
}

pub fn plot(arguments: &mut Arguments) -> Result<()> {
    arguments.check()?;
    let output = &arguments.output;
    // Before there is anything that would be left.
    let interrupt = Interrupt::watch();
    let mut file = Output::open(output)?;
    let bytes = arguments.draw(&interrupt)?;
    file.fill(|out| out.write_all(&bytes))?;
    file.persist()?;
    say!("{}", output.display())?;
    Ok(())
}

/// Draws without writing.
pub fn drawn(arguments: &mut Arguments) -> Result<Vec<u8>> {
    arguments.check()?;
    arguments.draw(&Interrupt::watch())
}

impl Arguments {
    /// Checks that the options belong together.
    fn check(&mut self) -> Result<()> {
        PictureFormat::of(&self.output)?;
        self.source.panels = self.walls.then_some(PanelChoice::Missing);
        if self.at.iter().any(|time| !(*time >= 0.0 && time.is_finite())) {
            bail!(Misused("--at: times are numbers of seconds, not below 0".into()));
        }
        self.style.check(&self.series)
    }

    /// \[s\] `--from` and `--until`, if they are given as times.
    fn times(&self) -> (Option<f64>, Option<f64>) {
        (self.from, self.until.and_then(Until::time))
    }

    /// Returns the picture, in the format of its file.
    fn draw(&self, interrupt: &Interrupt) -> Result<Vec<u8>> {
        let text = if !self.series.is_empty() {
            series(self, interrupt)?
        } else if self.density {
            density(self, interrupt)?
        } else if self.walls {
            loads(self, interrupt)?
        } else {
            scenes(self, interrupt)?
        };
        PictureFormat::of(&self.output)?.bytes(text, self.style.width)
    }
}

/// Format of a picture.
#[derive(Clone, Copy)]
pub enum PictureFormat {
    Svg,
    Png,
    Pdf,
}

impl PictureFormat {
    /// Returns the format of a file's name.
    pub fn of(path: &Path) -> Result<PictureFormat> {
        match path.extension().and_then(|end| end.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("svg") => Ok(PictureFormat::Svg),
            Some("png") => Ok(PictureFormat::Png),
            Some("pdf") => Ok(PictureFormat::Pdf),
            _ => bail!(Misused(format!("{}: pictures are .png, .svg or .pdf", path.display()))),
        }
    }

    /// Returns a picture in SVG in this format.
    pub fn bytes(self, svg: String, width: u32) -> Result<Vec<u8>> {
        Ok(match self {
            PictureFormat::Svg => svg.into_bytes(),
            PictureFormat::Png => png(&svg, width)?,
            PictureFormat::Pdf => pdf(&svg)?,
        })
    }
}

fn scenes(arguments: &Arguments, interrupt: &Interrupt) -> Result<String> {
    let Arguments { source, at, style, .. } = arguments;
    let latest = at.iter().copied().reduce(f64::max).filter(|time| *time > 0.0);
    let wanted = if style.needs_all() { KeptFrames::All } else { KeptFrames::Around(at.clone()) };
    let run = source.trial_run(latest.map(Until::Point), wanted, interrupt)?;
    at.iter().try_for_each(|time| run.check(*time))?;
    // Poses between two frames would stand beside forces of one of them.
    let asked = if at.is_empty() { vec![run.run.times().1] } else { at.clone() };
    let times: Vec<f64> = asked.iter().map(|time| run.run.frames[run.nearest(*time)].time).collect();
    let mut all = Scenes::new(style, &run, &times, interrupt)?;
    let drawn: Vec<(PictureScene, Style)> = times.iter().map(|time| all.at(*time)).collect();
    let panels: Vec<(&PictureScene, &Style)> = drawn.iter().map(|(scene, style)| (scene, style)).collect();
    let size = drawn[0].0.view.unwrap_or_else(|| drawn[0].0.extent()).size();
    let columns = arguments.columns.map_or_else(|| columns(panels.len(), size.x / size.y), |n| n as usize);
    Ok(sheet(&panels, columns))
}

/// Returns the number of columns with which a sheet is about as wide as a page is.
fn columns(panels: usize, aspect: f64) -> usize {
    /// Width of a sheet over its height.
    const WIDE: f64 = 1.3;
    let badness = |columns: &usize| {
        let rows = panels.div_ceil(*columns);
        let empty = (rows * columns - panels) as f64;
        ((*columns as f64 * aspect) / (rows as f64 * WIDE)).ln().abs() + 0.3 * empty
    };
    (1..=panels).min_by(|a, b| badness(a).total_cmp(&badness(b))).unwrap_or(1)
}

fn density(arguments: &Arguments, interrupt: &Interrupt) -> Result<String> {
    let Arguments { source, style, .. } = arguments;
    let run = source.trial_run(source.end(arguments.until)?, KeptFrames::All, interrupt)?;
    let (from, until) = arguments.times();
    let frames: Vec<&Frame> = run.run.frames.iter().filter(|frame| within(frame.time, from, until)).collect();
    let times: Vec<f64> = frames.iter().map(|frame| frame.time).collect();
    let Some(&last) = times.last() else { bail!(nothing_between(&run.run, from, until)) };
    let mut scenes = Scenes::new(style, &run, &times, interrupt)?;
    let (mut scene, style_then) = scenes.at(last);
    let one = times.len() == 1;
    if !one {
        // Bodies, forces and trails are of one time.
        (scene.poses, scene.forces, scene.trails) = (Vec::new(), Vec::new(), Vec::new());
    }
    let view = scene.view.unwrap_or_else(|| scene.extent());
    let mut map = DensityMap::new(view, arguments.kernel, &run.trial.geometry.walls);
    for frame in frames {
        map.add(frame.present().map(|(_, agent)| agent.pose.position));
    }
    note!("density: {}", map.described());
    (scene.density, scene.feet) = (Some(map), Vec::new());
    let time = one.then_some(last);
    Ok(svg(&scene, &Style { time, range: style.range, ..style_then }))
}

/// Draws the greatest mean loads over 1 s, and the people at the end.
fn loads(arguments: &Arguments, interrupt: &Interrupt) -> Result<String> {
    let Arguments { source, style, .. } = arguments;
    let run = source.trial_run(source.end(arguments.until)?, KeptFrames::All, interrupt)?;
    let (from, until) = arguments.times();
    let mut loads = LoadsOverTime::of(&run.trial.geometry);
    let frames = run.run.frames.iter().filter(|frame| within(frame.time, from, until));
    let times: Vec<f64> = frames
        .map(|frame| {
            loads.add(frame);
            frame.time
        })
        .collect();
    let Some(&last) = times.last() else { bail!(nothing_between(&run.run, from, until)) };
    let Some(seen) = loads.finish() else {
        bail!("--walls: {}: the results do not contain the forces on walls", run.run.source.display());
    };
    if seen.panels.iter().all(|(_, load)| load.load_1.is_none()) {
        bail!(
            "--walls: the time is shorter than 1 s, or a communication step is longer, so there is no mean over 1 s"
        );
    }
    let mut scenes = Scenes::new(style, &run, &[last], interrupt)?;
    let (mut scene, style_then) = scenes.at(last);
    let value = |load: &WallLoad| load.load_1.map_or(f64::NAN, |load| load / 1e3);
    let values = seen.panels.iter().map(|(_, load)| value(load)).collect();
    let values =
        Values { map: ColourMap::FromPaper, ..Values::of(values, "greatest mean load over 1 s", "kN/m") };
    let panels = seen.panels.iter().map(|(panel, _)| panel.ends()).collect();
    scene.loads = Some(LoadMap { panels, values });
    Ok(svg(&scene, &Style { time: Some(last), range: style.range, ..style_then }))
}

/// Draws one panel for each quantity, one line for each agent; measured positions beside simulated ones.
fn series(arguments: &Arguments, interrupt: &Interrupt) -> Result<String> {
    let Arguments { source, style, .. } = arguments;
    let Opened { trial, run, bodies } =
        source.open(source.end(arguments.until)?, KeptFrames::All, interrupt)?;
    // What contacts do is recorded, or computed from the Trial's bodies.
    let run = match trial {
        Some(trial) => TrialRun::new(trial, run, bodies)?.run,
        None => run,
    };
    let recorded = run.frames.iter().all(|frame| frame.effects.knows(Effect::NormalForce));
    let mut of_contacts = arguments.series.iter().filter(|quantity| quantity.is_of_contacts());
    if let Some(quantity) = of_contacts.next().filter(|_| !recorded && bodies == Bodies::Known) {
        let (name, _) = quantity.label();
        bail!(
            "{}: it does not contain the {name}: give the Trial or FMU of the run with --trial",
            run.source.display()
        );
    }
    let place = |id: &String| {
        let place = run.ids.iter().position(|known| known == id);
        place.with_context(|| format!("{}: there is no agent {id:?}", run.source.display()))
    };
    let agents = if arguments.agents.is_empty() { &run.ids } else { &arguments.agents };
    let places = agents.iter().map(place).collect::<Result<Vec<usize>>>()?;
    let (from, until) = arguments.times();
    let within = |time: f64| within(time, from, until);
    if !run.frames.iter().any(|frame| within(frame.time)) {
        bail!(nothing_between(&run, from, until));
    }
    let measured = style.measured(&run)?;
    let mut quantities: Vec<DrawnValues> = Vec::new();
    for quantity in &arguments.series {
        let shown = DrawnValues::of(*quantity, &run, style.over)?;
        // Mean and peak may have become the same.
        if !quantities.iter().any(|known| known.quantity == shown.quantity) {
            quantities.push(shown);
        }
    }
    let line = |place: usize, dashed: bool, points: &mut dyn Iterator<Item = (f64, f64)>| Curve {
        name: run.ids[place].clone(),
        points: points.filter(|point| within(point.0)).collect(),
        group: place,
        dashed,
    };
    let panels = quantities.into_iter().map(|shown| {
        let simulated = places.iter().map(|&place| {
            let frames = run.frames.iter().enumerate();
            line(place, false, &mut frames.map(|(k, frame)| (frame.time, shown.of_one(&run, k, place))))
        });
        let mut lines: Vec<Curve> = simulated.collect();
        let axis: Option<fn(Vec2) -> f64> = match shown.quantity {
            DrawnQuantity::X => Some(|at| at.x),
            DrawnQuantity::Y => Some(|at| at.y),
            _ => None,
        };
        if let (Some(measured), Some(axis)) = (&measured, axis) {
            lines.extend(places.iter().map(|&place| {
                let rows = measured.of(&run.ids[place]).iter();
                line(place, true, &mut rows.map(|(time, at)| (*time, axis(*at))))
            }));
        }
        let steps = shown.quantity == DrawnQuantity::Contacts;
        ChartPanel { y: titled(&shown.label(), shown.unit()), lines, steps }
    });
    let chart = Chart { x: "time (s)".to_owned(), panels: panels.collect(), noun: "agent".to_owned() };
    let (width, theme) = (f64::from(style.width), style.theme());
    Ok(chart_svg(&chart, &ChartStyle { width, theme, ..ChartStyle::default() }))
}
