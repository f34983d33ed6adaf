//! `lemons measure`: flow over lines, density in areas, exposure to squeeze. docs/measure.md defines each number.

mod chart;
pub(crate) mod options;
mod pass;
mod summary;
mod tables;
mod text;

use crate::error::{Misused, and_then};
use crate::files::{self, ForceOption};
use crate::interrupt::Interrupt;
use crate::output::Output;
use crate::pictures::plot::PictureFormat;
use crate::pictures::source::RunSource;
use crate::print;
use crate::record::{area, area_of_heads};
use crate::run::until;
use crate::values::{number, positive, seconds};
use anyhow::{Context, Result, bail};
use lemons_core::trial::{PanelChoice, Rule, Trial};
use lemons_decision::Plan;
use lemons_results::measure::{CountingLine, MeasuringArea, VoronoiRoom};
use lemons_results::{LEANING, Record};
use lemons_sim::Until;
use options::{Labelled, line, measuring_area, name_all};
use std::collections::BTreeSet;
use std::fs::create_dir_all;
use std::io::Write;
use std::path::PathBuf;
use summary::RunSummary;

/// Names of people that are said.
const MOST_NAMES: usize = 20;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    pub source: RunSource,
    /// Count who crosses this line, in metres; can be given several times. Stand at X1,Y1 and look at X2,Y2:
    /// people cross to your right or to your left. Default NAME: 1, 2, …
    #[arg(long = "line", value_name = "[NAME=]X1,Y1,X2,Y2", value_parser = line, allow_hyphen_values = true)]
    lines: Vec<Labelled<CountingLine>>,
    /// Width for the specific flow, in metres. Default: the length of the line
    #[arg(long, value_name = "METRES", requires = "lines", value_parser = positive)]
    width: Option<f64>,
    /// Length of the windows in which the flow over time is counted, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0, requires = "lines", value_parser = positive)]
    window: f64,
    /// Measure density and speed in this area, in metres; can be given several times. Four numbers are
    /// the lower left and the upper right corner of a rectangle; six or more the corners of a polygon
    #[arg(long = "area", value_name = "[NAME=]X0,Y0,X1,Y1,…", value_parser = measuring_area, allow_hyphen_values = true)]
    areas: Vec<Labelled<MeasuringArea>>,
    /// Where people can be, which bounds Voronoi cells: a file with POLYGON ((x y, …), (hole), …) in
    /// metres. Default: what the walls of the Trial or FMU, or of --geometry, enclose
    #[arg(long, value_name = "FILE.wkt", requires = "areas")]
    walkable: Option<PathBuf>,
    /// For each person, the time with a mean squeeze above these, in newtons
    #[arg(long, value_name = "N,N,…", value_delimiter = ',', value_parser = number(
        |level| level >= 0.0 && level.is_finite(),
        "numbers of newtons, not below 0, as in 1000,2000"
    ))]
    above: Vec<f64>,
    /// Compare means over so many seconds with --above. Default: the mean over each communication step, in
    /// which single collisions count
    #[arg(long, value_name = "SECONDS", requires = "above", value_parser = positive)]
    over: Option<f64>,
    /// Measure how long each person's trunk is pressed so hard that breathing tires: of a Trial whose people have
    /// a ChestHeight, or an FMU of it
    #[arg(long)]
    breathing: bool,
    /// Measure the loads on the walls and on their panels, too: of a Trial or an FMU, which is simulated first
    #[arg(long)]
    walls: bool,
    /// Length of the longest panel of the walls of a Trial, in metres. Default: what its Geometry.xml says,
    /// else 0.5. An FMU has the panels of its own Trial; without any, each straight piece is one
    #[arg(long, value_name = "METRES", requires = "walls", value_parser = positive)]
    panel_length: Option<f64>,
    /// Measure from this time on, in seconds
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    from: Option<f64>,
    /// Measure until this time, in seconds. With the word left, a Trial in which people walk is run until
    /// everybody has left, as by lemons run. Default: the end of earlier results; 5 for a Trial or FMU
    #[arg(long, value_name = "SECONDS|left", value_parser = until)]
    until: Option<Until>,
    /// Write flow.csv, gaps.csv, density.csv, people.csv, walls.csv, panels.csv, breathing.csv and summary.json into this directory
    #[arg(short, long, value_name = "DIRECTORY")]
    output: Option<PathBuf>,
    /// Write the summary as JSON; - is standard output
    #[arg(long, value_name = "FILE.json")]
    summary: Option<PathBuf>,
    /// Draw people across, flow, density and squeeze over time
    #[arg(long, value_name = "FILE.png, .svg or .pdf")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    _force: ForceOption,
}

/// \[N/m\] Young modulus above which bodies are stiffer than chests (`human_soft` has 2.9e4).
const STIFF: f64 = 1e5;
/// Windows of the flow over time.
const MOST_WINDOWS: f64 = 1e6;

pub fn measure(mut arguments: Arguments) -> Result<()> {
    let MeasuredRun { summary, .. } = measured(&mut arguments)?;
    text::print(&summary)?;
    for path in arguments.output.iter().chain(&arguments.plot) {
        say!("{:<18} {}", "written", path.display())?;
    }
    Ok(())
}

/// The measures of a run.
pub struct MeasuredRun {
    summary: RunSummary,
    /// The same as JSON.
    pub json: String,
    /// CSV, by the names of the tables.
    pub tables: Vec<(&'static str, String)>,
}

/// Measures, and writes the files that are asked for.
pub fn measured(arguments: &mut Arguments) -> Result<MeasuredRun> {
    arguments.check()?;
    let arguments = &*arguments;
    let Arguments { source, output, .. } = arguments;
    let format = arguments.plot.as_deref().map(PictureFormat::of).transpose()?;
    let interrupt = Interrupt::watch();
    let picture = arguments.plot.as_ref().zip(format);
    arguments.summary.iter().chain(&arguments.plot).try_for_each(|path| files::claim_and_try(path))?;
    let in_directory = |name: String| output.iter().map(move |directory| directory.join(&name));
    let of_tables = tables::NAMES.into_iter().map(|name| format!("{name}.csv"));
    let paths: Vec<PathBuf> = of_tables.chain(["summary.json".into()]).flat_map(in_directory).collect();
    paths.iter().try_for_each(|path| files::claim(path))?;

    let (trial, record) = source.record_of(source.end(arguments.until)?, &interrupt)?;
    let has_areas = !arguments.areas.is_empty();
    let room = if has_areas { arguments.room(&record, trial.as_ref())? } else { None };
    let mut summary = pass::pass(arguments, &record, room.as_ref(), trial.as_ref(), &interrupt)?;
    let RunSummary { from, until, .. } = summary;
    if !arguments.lines.is_empty() && (until - from) / arguments.window > MOST_WINDOWS {
        bail!(Misused(format!("--window: {} s makes more than a million windows", arguments.window)));
    }
    if let Some(why) = summary.exposure_left_out {
        if !arguments.above.is_empty() {
            bail!("--above: {}: {why}", source.path.display());
        }
        if record.trajectories().is_none() {
            note!("exposure to squeeze is left out: {why}");
        }
    }
    if arguments.walls && summary.walls.is_none() {
        bail!("--walls: {}: the results do not contain the forces on walls", source.path.display());
    }
    if summary.exposure.is_some() {
        summary.notes = arguments.caveats(trial.as_ref());
    }
    let json = serde_json::to_string_pretty(&summary)? + "\n";
    let tables = tables::of(arguments, record.ids(), &summary)?;
    if let Some(directory) = output {
        create_dir_all(directory).with_context(|| format!("cannot write {}", directory.display()))?;
    }
    let text = |path, text: &String| (path, text.clone().into_bytes());
    let texts = tables.iter().map(|(_, table)| table).chain([&json]);
    let mut results: Vec<_> = paths.iter().zip(texts).map(|(path, own)| text(path, own)).collect();
    results.extend(arguments.summary.iter().map(|path| text(path, &json)));
    if let Some((path, format)) = picture {
        results.push((path, format.bytes(chart::svg(arguments, &summary), chart::WIDTH)?));
    }
    let written = results.iter().map(|(path, content)| {
        let mut file = Output::claimed(path)?;
        file.fill(|out| out.write_all(content))?;
        Ok(file)
    });
    let written: Vec<Output> = written.collect::<Result<_>>()?;
    written.into_iter().map(Output::persist).fold(Ok(()), and_then)?;
    Ok(MeasuredRun { summary, json, tables })
}

impl Arguments {
    /// Checks that the options belong together, and numbers lines and areas without names.
    fn check(&mut self) -> Result<()> {
        name_all("--line", &mut self.lines)?;
        name_all("--area", &mut self.areas)?;
        if self.above.windows(2).any(|pair| pair[0] >= pair[1]) {
            bail!(Misused("--above: must be rising numbers of newtons, as in 1000,2000".into()));
        }
        self.source.end(self.until)?;
        let panels = self.panel_length.map_or(PanelChoice::Missing, PanelChoice::Longest);
        self.source.panels = self.walls.then_some(panels);
        if let (Some(from), Some(until)) = (self.from, self.until.and_then(Until::time))
            && from >= until
        {
            bail!(Misused(format!("--from {from} --until {until}: the beginning is not before the end")));
        }
        Ok(())
    }

    /// Returns what squeezes of the people of a Trial can mean, and what not.
    fn caveats(&self, trial: Option<&Trial>) -> Vec<String> {
        let Some(trial) = trial else { return Vec::new() };
        let of_people = |id: &str| {
            let mut shapes = trial.agents.iter().flat_map(|agent| &agent.shapes);
            shapes.any(|shape| shape.material_id == id)
        };
        let mut stiff = trial.materials.intrinsic.iter().filter(|material| material.young_modulus > STIFF);
        let stiff = stiff.find(|material| of_people(&material.id)).map(|material| {
            format!(
                "{} is stiffer than chests: of a single push, means over 0.1 s and more can be compared with \
                 measurements, and peaks cannot; where many people press, stiff chests make larger means, too \
                 (docs/guide/squeeze.md)",
                material.id
            )
        });
        let flat = self.source.plan(trial).filter(Plan::queues).map(|_| Rule::FlatPush.message().text);
        stiff.into_iter().chain(flat).collect()
    }

    /// Returns where people can be; `None` if no walls or polygon say it of measured people.
    fn room(&self, record: &Record, trial: Option<&Trial>) -> Result<Option<VoronoiRoom>> {
        let walls = trial.map_or(&[][..], |trial| &trial.geometry.walls);
        let given = ("--walkable", self.walkable.as_deref());
        let area = if record.trajectories().is_some() {
            match area_of_heads(record, given, walls)? {
                Some(area) => area,
                None => {
                    note!(
                        "no Voronoi density: some people are further than {LEANING} m outside of the walls, which would \
                         hold back nobody (where people can be: --walkable)"
                    );
                    return Ok(None);
                }
            }
        } else {
            area(record, given, walls)?
        };
        for line in &area.messages {
            // Here --area is something else.
            note!("{}", line.replace("--area", "--walkable"));
        }
        let room = VoronoiRoom::of(&area.polygon);
        leaning(record, &room)?.iter().for_each(|line| note!("{line}"));
        Ok(Some(room))
    }
}

/// Says who is outside of a room, and how far.
fn leaning(record: &Record, room: &VoronoiRoom) -> Result<Option<String>> {
    let (mut positions, mut farthest) = (0_usize, 0.0_f64);
    let mut who = BTreeSet::new();
    record.each(|_, frame| {
        for (agent, motion) in frame.present() {
            let (_, off) = room.nearest(motion.pose.position);
            if off > 0.0 {
                positions += 1;
                farthest = farthest.max(off);
                who.insert(agent);
            }
        }
        Ok(())
    })?;
    let names: Vec<&String> = who.iter().map(|agent| &record.ids()[*agent]).collect();
    Ok((positions > 0).then(|| {
        format!(
            "Voronoi density: {positions} positions of {} people are up to {farthest:.2} m outside of the walkable area, \
             and count at the nearest place in it: {}",
            names.len(),
            print::few(&names, MOST_NAMES)
        )
    }))
}
