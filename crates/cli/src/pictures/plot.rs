//! `lemons plot`: scenes, time series, a map of density.

use super::look::{Look, Looks, seconds};
use super::moment::Moment;
use super::quantity::Quantity;
use super::series::{Selection, chart};
use super::source::{End, KeptFrames, Source};
use crate::error::Misused;
use crate::files::Force;
use crate::interrupt::Interrupt;
use crate::output::Output;
use crate::run::{Until, until};
use anyhow::{Result, bail};
use lemons_picture::{
    ChartStyle, DENSITY_KERNEL, DensityMap, Panel, Scene, Style, chart_svg, pdf, png, sheet, svg,
};
use lemons_results::measure::within;
use std::io::Write;
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    pub source: Source,
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
    series: Vec<Quantity>,
    /// Draw time series of these agents only, by Id. Default: all
    #[arg(long, value_name = "ID,…", value_delimiter = ',', requires = "series")]
    agents: Vec<String>,
    /// Draw a map of people per square metre, averaged over all frames, instead of scenes. Density does
    /// not spread through walls
    #[arg(long)]
    density: bool,
    /// Standard deviation of the Gaussian of each person in the density map, in metres
    #[arg(long, value_name = "METRES", requires = "density", default_value_t = DENSITY_KERNEL, value_parser = kernel)]
    kernel: f64,
    /// Start of time series and density map, in seconds
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    from: Option<f64>,
    /// End of time series and density map, in seconds. With the word left, a Trial in which people walk is
    /// run until everybody has left, as by lemons run. Default: the end of earlier results; 5 for a
    /// Trial or FMU
    #[arg(long, value_name = "SECONDS|left", value_parser = until)]
    until: Option<Until>,
    #[command(flatten)]
    _force: Force,
    #[command(flatten)]
    look: Look,
}

/// \[m\] Narrower ones need more cells than a picture has pixels.
fn kernel(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.02..=100.0).contains(&value) => Ok(value),
        _ => Err("must be a number of metres from 0.02 to 100".into()),
    }
}

pub fn plot(arguments: &Arguments) -> Result<()> {
    let output = &arguments.output;
    arguments.check()?;
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
pub fn drawn(arguments: &Arguments) -> Result<Vec<u8>> {
    arguments.check()?;
    arguments.draw(&Interrupt::watch())
}

impl Arguments {
    /// Whether the options belong together.
    fn check(&self) -> Result<()> {
        Format::of(&self.output)?;
        if self.at.iter().any(|time| !(*time >= 0.0 && time.is_finite())) {
            bail!(Misused("--at: times are numbers of seconds, not below 0".into()));
        }
        self.look.check(&self.series)
    }

    /// The picture, in the format of its file.
    fn draw(&self, interrupt: &Interrupt) -> Result<Vec<u8>> {
        let text = if !self.series.is_empty() {
            series(self, interrupt)?
        } else if self.density {
            density(self, interrupt)?
        } else {
            scenes(self, interrupt)?
        };
        Format::of(&self.output)?.bytes(text, self.look.width)
    }
}

/// What a picture is written as.
#[derive(Clone, Copy)]
pub enum Format {
    Svg,
    Png,
    Pdf,
}

impl Format {
    /// By the end of the file's name.
    pub fn of(path: &Path) -> Result<Format> {
        match path.extension().and_then(|end| end.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("svg") => Ok(Format::Svg),
            Some("png") => Ok(Format::Png),
            Some("pdf") => Ok(Format::Pdf),
            _ => bail!(Misused(format!("{}: pictures are .png, .svg or .pdf", path.display()))),
        }
    }

    /// A picture in SVG, as what it is written.
    pub fn bytes(self, svg: String, width: u32) -> Result<Vec<u8>> {
        Ok(match self {
            Format::Svg => svg.into_bytes(),
            Format::Png => png(&svg, width)?,
            Format::Pdf => pdf(&svg)?,
        })
    }
}

fn scenes(arguments: &Arguments, interrupt: &Interrupt) -> Result<String> {
    let Arguments { source, at, look, .. } = arguments;
    let latest = at.iter().copied().reduce(f64::max).filter(|time| *time > 0.0);
    let wanted = if look.needs_all() { KeptFrames::All } else { KeptFrames::Around(at.clone()) };
    let footage = source.footage(latest.map(End::NotBefore), wanted, interrupt)?;
    at.iter().try_for_each(|time| footage.check(*time))?;
    // Poses between two frames would stand beside forces of one of them.
    let asked = if at.is_empty() { vec![footage.last()] } else { at.clone() };
    let times: Vec<f64> = asked.iter().map(|time| footage.run.frames[footage.nearest(*time)].time).collect();
    let mut looks = Looks::new(look, &footage, &times, interrupt)?;
    let moments: Vec<Moment> = times.iter().map(|time| footage.at(*time)).collect();
    let scenes: Vec<Scene> = moments.iter().map(|moment| looks.scene(moment)).collect();
    if looks.other_parameters() {
        note!("{OTHER_PARAMETERS}");
    }
    if let ([scene], [moment]) = (&scenes[..], &moments[..]) {
        return Ok(svg(scene, &looks.style(moment)));
    }
    let panels: Vec<Panel> = scenes
        .iter()
        .zip(&moments)
        .map(|(scene, moment)| Panel { scene, time: Some(moment.time), fill: Some(looks.style(moment).fill) })
        .collect();
    let view = scenes[0].view.unwrap_or_else(|| scenes[0].extent());
    let size = view.high - view.low;
    let columns = arguments.columns.map_or_else(|| columns(panels.len(), size.x / size.y), |n| n as usize);
    Ok(sheet(&panels, columns, &looks.style(&moments[0])))
}

/// Said of forces.
pub const OTHER_PARAMETERS: &str = "warning: with the Trial's parameters the contacts would not have the squeeze that \
    the run recorded: the forces shown are not the run's (give what was set: --set)";

/// So that the sheet is about as wide as a page is.
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

fn series(arguments: &Arguments, interrupt: &Interrupt) -> Result<String> {
    let Arguments { source, look, .. } = arguments;
    let opened = source.open(source.end(arguments.until)?, KeptFrames::All, interrupt)?;
    let (from, until) = (arguments.from, arguments.until.and_then(Until::time));
    let selection = Selection { quantities: &arguments.series, agents: &arguments.agents, from, until };
    let chart = chart(opened, look, &selection)?;
    let theme = look.theme();
    Ok(chart_svg(&chart, &ChartStyle { width: f64::from(look.width), theme, ..ChartStyle::default() }))
}

fn density(arguments: &Arguments, interrupt: &Interrupt) -> Result<String> {
    let Arguments { source, look, .. } = arguments;
    let footage = source.footage(source.end(arguments.until)?, KeptFrames::All, interrupt)?;
    let until = arguments.until.and_then(Until::time);
    let within = |time: f64| within(time, arguments.from, until);
    let places: Vec<usize> =
        (0..footage.run.frames.len()).filter(|&k| within(footage.run.frames[k].time)).collect();
    let Some(&last) = places.last() else { bail!(footage.nothing_between(arguments.from, until)) };
    let times: Vec<f64> = places.iter().map(|&place| footage.run.frames[place].time).collect();
    let mut looks = Looks::new(look, &footage, &times, interrupt)?;
    let moment = footage.frame(last);
    let mut scene = looks.scene(&moment);
    let view = scene.view.unwrap_or_else(|| scene.extent());
    let one = places.len() == 1;
    if !one {
        // They are of one time.
        (scene.forces, scene.trails) = (Vec::new(), Vec::new());
    }
    let mut map = DensityMap::new(view, arguments.kernel, &footage.trial.geometry.walls);
    for place in &places {
        map.add(footage.run.frames[*place].present().map(|(_, agent)| agent.pose.position));
    }
    map.range = look.range();
    note!("density: {}", map.described());
    scene.density = Some(map);
    let time = one.then_some(moment.time);
    Ok(svg(&scene, &Style { bodies: one, time, ..looks.style(&moment) }))
}
