//! Where a crowd stands: the region, the placer, its progress.

use crate::error::{Misused, TrialHasErrors};
use crate::interrupt::{Interrupt, Interrupted};
use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use lemons_people::placing::{
    Dense, Ended, Grid, Measure, Orientation, Packing, Paper, Progress, Region, Stage, dense, grid, measure,
    paper, placing_seed, wider,
};
use lemons_people::{Shape, walls};
use lemons_plane::{Vec2, vec2};
use lemons_trial::Geometry;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Duration;

#[derive(clap::Args)]
#[command(next_help_heading = "Region and packing")]
pub struct PlacingArguments {
    /// Place people in a box with walls, in m, for example 4.56x4.56; its lower left corner is the
    /// origin
    #[arg(long = "box", value_name = "LXxLY", value_parser = sides, allow_hyphen_values = true, group = "region")]
    sides: Option<Vec2>,
    /// Place people inside the closed walls of this Geometry.xml: the largest wall is the outline, the
    /// others are holes
    #[arg(long, value_name = "FILE.xml", group = "region")]
    geometry: Option<PathBuf>,
    /// Place people in the open, without walls (default)
    #[arg(long, group = "region")]
    open: bool,
    /// Packing algorithm. dense: our own, without overlap; paper: that of the paper's appendix D; grid:
    /// rows
    #[arg(long, value_enum, default_value_t = PackingArgument::Dense)]
    packing: PackingArgument,
    /// Which way people face. free: any way; fixed: exactly along --direction; towards: first along
    /// --direction, then turned by their neighbours. Default: fixed in a crowd with bicycles; else
    /// towards if --direction is given, and free if not
    #[arg(long, value_enum)]
    orientation: Option<OrientationArgument>,
    /// Direction people face, in degrees counter-clockwise from the x axis. Default: 0
    #[arg(long, value_name = "DEGREES", value_parser = degrees, allow_negative_numbers = true)]
    direction: Option<f64>,
    /// Write the crowd even if some people overlap
    #[arg(long)]
    allow_overlap: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PackingArgument {
    Dense,
    Paper,
    Grid,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum OrientationArgument {
    Free,
    Fixed,
    Towards,
}

fn sides(text: &str) -> Result<Vec2, String> {
    let wanted = || "must be two lengths in m with an x between them, as in 4.56x4.56".to_owned();
    let (along, across) = text.split_once(['x', 'X', '×']).ok_or_else(wanted)?;
    let side = |text: &str| text.trim().parse::<f64>().ok().filter(|side| (0.1..=1e4).contains(side));
    match (side(along), side(across)) {
        (Some(along), Some(across)) => Ok(vec2(along, across)),
        _ => Err(format!("{}, each from 0.1 to 10000", wanted())),
    }
}

fn degrees(text: &str) -> Result<f64, String> {
    super::within(text, -360.0, 360.0, " (degrees)")
}

/// Where people may stand, and its walls.
pub struct Place {
    pub region: Region,
    pub geometry: Geometry,
    /// As the user named it.
    pub name: String,
}

/// How many there are, and how dense they are in the open.
#[derive(Debug, Clone, Copy)]
pub struct Wanted {
    pub number: usize,
    /// \[1/m²\] in the open.
    pub density: Option<f64>,
}

/// More are a mistake.
const MOST: f64 = 1e6;

impl PlacingArguments {
    pub fn place(&self) -> Result<Place> {
        if let Some(sides) = self.sides {
            let region = Region::rectangle(Vec2::ZERO, sides).context("--box")?;
            let geometry = walls(region.rings(), "concrete");
            return Ok(Place { region, geometry, name: format!("a box of {} m x {} m", sides.x, sides.y) });
        }
        if let Some(path) = &self.geometry {
            let (geometry, warnings) = match Geometry::read(path) {
                Ok(read) => read,
                Err(problems) => {
                    note!("{problems}");
                    return Err(TrialHasErrors.into());
                }
            };
            for warning in warnings.iter() {
                note!("{warning}");
            }
            let name = path.display().to_string();
            let region = Region::from_walls(&geometry).with_context(|| format!("--geometry {name}"))?;
            return Ok(Place { region, geometry, name });
        }
        Ok(Place { region: Region::plane(), geometry: walls(&[], ""), name: "the open".into() })
    }

    /// From --number and --density.
    pub fn wanted(&self, place: &Place, number: Option<u32>, density: Option<f64>) -> Result<Wanted> {
        match (number, density) {
            (Some(number), density) if place.region.is_plane() => {
                if let Some(density) = density
                    && self.packing != PackingArgument::Dense
                {
                    let option = self.option();
                    let message =
                        format!("--density {density} in the open is for --packing dense, not {option}");
                    return Err(Misused(message).into());
                }
                Ok(Wanted { number: number as usize, density })
            }
            (Some(number), None) => Ok(Wanted { number: number as usize, density: None }),
            (Some(_), Some(_)) => Err(Misused(format!(
                "--number and --density: one of them follows from the other in {}",
                place.name
            ))
            .into()),
            (None, None) => Err(Misused(
                "the number of people is missing: give --number N, or --density D with --box or --geometry"
                    .into(),
            )
            .into()),
            (None, Some(density)) if place.region.is_plane() => Err(Misused(format!(
                "--density {density} in the open needs --number, or --box or --geometry"
            ))
            .into()),
            (None, Some(density)) => {
                let area = place.region.area();
                let number = (density * area).round();
                if number < 1.0 {
                    bail!("--density {density}: nobody on the {area:.3} m² of {}", place.name);
                }
                if number > MOST {
                    bail!(
                        "--density {density}: {number} people on the {area:.3} m² of {}, at most {MOST} are placed",
                        place.name
                    );
                }
                Ok(Wanted { number: number as usize, density: None })
            }
        }
    }

    pub fn direction(&self) -> f64 {
        self.direction.unwrap_or(0.0)
    }

    /// In a mixed crowd all face one way unless it is said otherwise.
    pub fn default_to_fixed(&mut self) {
        self.orientation.get_or_insert(OrientationArgument::Fixed);
    }

    /// Whether all face one way of the axes.
    pub fn along_an_axis(&self) -> bool {
        self.orientation == Some(OrientationArgument::Fixed) && self.direction() % 90.0 == 0.0
    }

    fn orientation(&self) -> Orientation {
        let angle = self.direction().to_radians();
        match self.orientation {
            Some(OrientationArgument::Free) => Orientation::Free,
            Some(OrientationArgument::Fixed) => Orientation::Fixed(angle),
            Some(OrientationArgument::Towards) => Orientation::Towards(angle),
            None if self.direction.is_some() => Orientation::Towards(angle),
            None => Orientation::Free,
        }
    }

    /// Places the shapes; a placing with overlaps is an error unless it was allowed.
    pub fn run(
        &self,
        shapes: &[Shape],
        place: &Place,
        wanted: Wanted,
        seed: u64,
        interrupt: &Interrupt,
    ) -> Result<Packing> {
        let bar = Bar::new()?;
        let mut watch = |progress: &Progress| {
            bar.show(progress);
            if interrupt.pressed() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let seed = placing_seed(seed);
        let orientation = self.orientation();
        let region = &place.region;
        let packing = match self.packing {
            PackingArgument::Dense => {
                let settings = Dense { density: wanted.density, orientation, seed, ..Dense::default() };
                dense(&wider(shapes), region, &settings, &mut watch)
            }
            PackingArgument::Paper => {
                let settings = Paper { orientation, seed, ..Paper::default() };
                paper(&wider(shapes), region, &settings, &mut watch)
            }
            PackingArgument::Grid => grid(shapes, region, &Grid { orientation, seed, ..Grid::default() }),
        };
        bar.0.finish_and_clear();
        let count = shapes.len();
        let option = self.option();
        let packing = packing.with_context(|| format!("{count} people in {}, {option}", place.name))?;
        if packing.ended == Ended::Cancelled {
            return Err(Interrupted::given_up().into());
        }
        let Measure { density, clear_density, largest_overlap, .. } = measure(shapes, region, &packing.poses);
        let clear_density = clear_density.max(packing.clear_density);
        let packing = Packing { density, clear_density, largest_overlap, ..packing };
        if packing.complete || self.allow_overlap {
            return Ok(packing);
        }
        let clear = packing.clear_density;
        let overlap = 1e3 * packing.largest_overlap;
        let density = packing.density;
        let other =
            if self.packing == PackingArgument::Paper { "; --packing dense reaches more" } else { "" };
        if region.is_plane() {
            let wanted = wanted.density.map_or(String::new(), |density| format!(" at --density {density}"));
            bail!(
                "{count} in the open{wanted}, {option}: reached {density:.2} /m², largest overlap {overlap:.2} mm{other}"
            );
        }
        bail!(
            "{count} people in {}, {option}: that is {density:.2} /m², of which {clear:.2} /m² ({:.0}) were placed without overlap, \
             the others overlap by up to {overlap:.2} mm (--allow-overlap writes it so){other}",
            place.name,
            clear * region.area()
        );
    }

    fn option(&self) -> String {
        let name =
            self.packing.to_possible_value().map_or(String::new(), |value| value.get_name().to_owned());
        format!("--packing {name}")
    }

    /// In words, for the summary.
    pub fn manner(&self) -> String {
        let packing = match self.packing {
            PackingArgument::Dense => "dense",
            PackingArgument::Paper => "the paper's",
            PackingArgument::Grid => "rows",
        };
        let way = match self.orientation() {
            Orientation::Free => "facing any way".to_owned(),
            Orientation::Fixed(_) => format!("facing {}°", self.direction()),
            Orientation::Towards(_) => format!("turned from {}°", self.direction()),
        };
        format!("{packing}, {way}")
    }
}

/// On a terminal, once a placing takes a moment.
struct Bar(ProgressBar);

impl Bar {
    fn new() -> Result<Bar> {
        let style = ProgressStyle::with_template("{spinner} {elapsed:>4}  {msg}")?;
        let bar = ProgressBar::new_spinner().with_style(style);
        bar.enable_steady_tick(Duration::from_millis(100));
        Ok(Bar(bar))
    }

    fn show(&self, progress: &Progress) {
        let stage = match progress.stage {
            Stage::Growing => "growing",
            Stage::Spreading => "spreading",
            Stage::Shaking => "shaking",
            Stage::Pressing => "pressing",
            Stage::Thinning => "too many: thinning",
        };
        let (density, overlap) = (progress.density, 1e3 * progress.overlap);
        let iteration = progress.iteration;
        self.0.set_message(format!(
            "{stage}: {density:.2} /m², overlap {overlap:.2} mm, iteration {iteration} (Ctrl-C gives up)"
        ));
    }
}
