//! Where a crowd stands: the region, the placer, its progress.

use super::named;
use super::regions::{Amount, Ground, RegionArgument, door, grounds, numbers, region};
use crate::error::{Misused, TrialHasErrors};
use crate::interrupt::{Interrupt, Interrupted};
use anyhow::{Context, Result, anyhow, bail};
use clap::ValueEnum;
use indicatif::ProgressBar;
use lemons_core::files::source::Disk;
use lemons_core::plane::{Bounds, Pose, Ring, Vec2, vec2};
use lemons_core::trial::{Geometry, Wall};
use lemons_people::placing::{
    Ended, FreeSpace, Method, Orientation, Packing, Progress, Region, Settings, Stage,
};
use lemons_people::{Agent, Door, PeopleError, Shape, closed_walls, cut_doors, nearest_wall, walls};
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
    /// others are holes. With --region, its walls may have openings
    #[arg(long, value_name = "FILE.xml", group = "region")]
    geometry: Option<PathBuf>,
    /// Place people in the open, without walls (default)
    #[arg(long, group = "region")]
    open: bool,
    /// Place people on this part of the ground, in m: two opposite corners of a box, as in 0,0,8,6, or the
    /// corners of a polygon, as in "0,0 8,0 8,6". Can be given several times, each with its own number or
    /// density, as in "0,0,4,6; number=40" and "4,0,8,6; density=3"; see below
    #[arg(long = "region", value_name = "REGION", value_parser = region, allow_hyphen_values = true)]
    regions: Vec<RegionArgument>,
    /// Cut a door into the nearest closed wall: a gap of this width, in m, whose middle is the wall's
    /// nearest point. People are placed before. A door in an obstacle is refused: nobody stands inside it.
    /// Can be given several times
    #[arg(long = "door", value_name = "X,Y,WIDTH", value_parser = door, allow_hyphen_values = true)]
    doors: Vec<Door>,
    /// Packing algorithm. dense: our own, without overlap; paper: that of the paper's appendix D; grid:
    /// rows
    #[arg(long, value_parser = named(&Method::ALL, Method::name), default_value = "dense")]
    packing: Method,
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
    /// At least one.
    pub grounds: Vec<Ground>,
    /// With doors.
    pub geometry: Geometry,
    /// Where doors were cut: the closed walls without them.
    pub closed: Vec<Ring>,
    /// As the user named it.
    pub name: String,
}

impl Place {
    pub fn is_plane(&self) -> bool {
        self.grounds[0].free.region.is_plane()
    }

    /// \[m²\]
    pub fn area(&self) -> f64 {
        self.grounds.iter().map(|ground| ground.free.region.area()).sum()
    }
}

/// After "close the wall": what to do with --door where walls have openings.
const OPENINGS: &str = "give its opening as a --door, too; or leave out --door: --region takes walls with openings, \
                        and with --leave, --exit says where people leave";
/// The same where no wall is closed.
const CLOSE: &str = "close one (repeat its first corner at the end), and ";

/// \[m\] About how broad people are across the shoulders.
const NARROW: f64 = 0.5;

const MISSING: &str =
    "the number of people is missing: give --number N, or --density D with --box or --geometry";

impl PlacingArguments {
    pub fn place(&self) -> Result<Place> {
        let (geometry, name) = self.surroundings()?;
        let grounds = if self.regions.is_empty() {
            let region = match (self.sides, &self.geometry) {
                (Some(sides), _) => Region::rectangle(Vec2::ZERO, sides).context("--box")?,
                (None, Some(_)) => Region::from_walls(&geometry)
                    .map_err(|error| self.with_a_way_out(&error, &geometry))
                    .with_context(|| format!("--geometry {name}"))?,
                (None, None) => Region::plane(),
            };
            // All walls are closed; the others are within the outline.
            let is_outline = |wall: &&Wall| Bounds::of(wall.corners.iter().copied()) == region.bounds();
            let (rooms, obstacles) = geometry.walls.iter().partition::<Vec<_>, _>(is_outline);
            let [rooms, obstacles] =
                [rooms, obstacles].map(|walls| walls.iter().map(|wall| wall.id.clone()).collect());
            let free = FreeSpace { region, rooms, obstacles, walls: Vec::new() };
            vec![Ground { free, name: name.clone(), amount: Amount::AsAll }]
        } else {
            grounds(&self.regions, &geometry, &name)?
        };
        let closed = closed_walls(&geometry);
        if !self.doors.is_empty() && closed.is_empty() {
            let advice = if geometry.walls.is_empty() {
                "--box or --geometry has some".to_owned()
            } else {
                format!("{CLOSE}{OPENINGS}")
            };
            return Err(Misused(format!("--door: there is no closed wall in {name}; {advice}")).into());
        }
        let uncut = geometry.clone();
        let geometry = cut_doors(geometry, &self.doors).context("--door")?;
        self.doors.iter().try_for_each(|door| refuse_obstacle(door, &uncut, &grounds))?;
        for (number, door) in self.doors.iter().enumerate() {
            if door.width < NARROW {
                note!(
                    "note: --door: door {number} is {} m wide: people are about {NARROW} m broad, and may get stuck",
                    door.width
                );
            }
            // A corner lies between the ends of the gap.
            if door.course(&closed).len() > 2 {
                let Door { at, width } = door;
                note!(
                    "note: --door {},{},{width}: door {number} goes round a corner of its wall, because the corner is nearer \
                     than half the width",
                    at.x,
                    at.y
                );
            }
        }
        Ok(Place { grounds, geometry, closed, name })
    }

    /// The walls, and how the user names them.
    fn surroundings(&self) -> Result<(Geometry, String)> {
        if let Some(sides) = self.sides {
            let region = Region::rectangle(Vec2::ZERO, sides).context("--box")?;
            let geometry = walls(region.rings(), "concrete");
            return Ok((geometry, format!("a box of {} m x {} m", sides.x, sides.y)));
        }
        if let Some(path) = &self.geometry {
            let (geometry, warnings) = match Geometry::read_from(&Disk, path) {
                Ok(read) => read,
                Err(problems) => {
                    note!("{problems}");
                    return Err(TrialHasErrors.into());
                }
            };
            for warning in warnings.iter() {
                note!("{warning}");
            }
            return Ok((geometry, path.display().to_string()));
        }
        Ok((walls(&[], ""), "the open".into()))
    }

    /// Adds to the error of an open wall what to do.
    fn with_a_way_out(&self, error: &PeopleError, geometry: &Geometry) -> anyhow::Error {
        let corners = geometry.walls.iter().flat_map(|wall| wall.corners.iter().copied());
        match (error, Bounds::of(corners)) {
            (PeopleError::OpenWall { .. }, _) if !self.doors.is_empty() => {
                anyhow!("{error}; --door needs closed walls: close it, and {OPENINGS}")
            }
            (PeopleError::OpenWall { .. }, Some(Bounds { low, high })) => anyhow!(
                "{error}; --region says where people stand among walls with openings, for example --region {},{},{},{}",
                low.x,
                low.y,
                high.x,
                high.y
            ),
            _ => anyhow!("{error}"),
        }
    }

    /// Lines \[m\] behind the doors, where people \[m\] have left.
    pub fn ways_out(&self, place: &Place, crowd: &[(Agent, Pose)]) -> Vec<[Vec2; 2]> {
        let people = crowd.iter().map(|(_, pose)| pose.position);
        self.doors.iter().filter_map(|door| door.exit(&place.closed, people.clone())).collect()
    }

    /// Returns whether people stand on all the ground there is.
    pub fn is_whole(&self) -> bool {
        self.regions.is_empty()
    }

    pub fn doors(&self) -> usize {
        self.doors.len()
    }

    /// How many stand on each ground, from --number and --density.
    pub fn numbers(&self, place: &Place, number: Option<u32>, density: Option<f64>) -> Result<Vec<usize>> {
        let misused = match (number, density) {
            (None, None) if self.is_whole() => MISSING.into(),
            _ if !place.is_plane() => return numbers(&place.grounds, number, density),
            (Some(_), Some(density)) if self.packing != Method::Dense => {
                format!("--density {density} in the open is for --packing dense, not {}", self.option())
            }
            (Some(number), _) => return Ok(vec![number as usize]),
            (None, density) => {
                let density = density.unwrap_or_default();
                format!("--density {density} in the open needs --number, or --box or --geometry")
            }
        };
        Err(Misused(misused).into())
    }

    pub fn direction(&self) -> f64 {
        self.direction.unwrap_or(0.0)
    }

    /// In a mixed crowd all face one way unless it is said otherwise.
    pub fn default_to_fixed(&mut self) {
        self.orientation.get_or_insert(OrientationArgument::Fixed);
    }

    /// Returns whether all face one way of the axes.
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

    /// Places the shapes, in the open with this density \[1/m²\]; a placing with overlaps is an error unless it was allowed.
    /// Returns the placing of all, and the density \[1/m²\] on each ground.
    pub fn run(
        &self,
        shapes: &[Shape],
        place: &Place,
        numbers: &[usize],
        density: Option<f64>,
        seed: u64,
        interrupt: &Interrupt,
    ) -> Result<(Packing, Vec<f64>)> {
        let (mut packings, mut first) = (Vec::new(), 0);
        for (k, (ground, number)) in place.grounds.iter().zip(numbers).enumerate() {
            let own = &shapes[first..first + number];
            first += number;
            // Equal grounds are filled in different ways.
            let seed = seed.wrapping_add(k as u64);
            packings.push(self.run_one(own, ground, density, seed, interrupt)?);
        }
        let densities = packings.iter().map(|packing| packing.density).collect();
        let mut packings = packings.into_iter();
        let mut all = packings.next().context("there is no ground")?;
        for packing in packings {
            all.poses.extend(packing.poses);
            all.density = all.poses.len() as f64 / place.area();
            all.largest_overlap = all.largest_overlap.max(packing.largest_overlap);
        }
        Ok((all, densities))
    }

    fn run_one(
        &self,
        shapes: &[Shape],
        ground: &Ground,
        density: Option<f64>,
        seed: u64,
        interrupt: &Interrupt,
    ) -> Result<Packing> {
        let Ground { free: FreeSpace { region, .. }, name, .. } = ground;
        let bar = Bar::new()?;
        let mut watch = |progress: &Progress| {
            bar.show(progress);
            if interrupt.pressed() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let settings = Settings { orientation: self.orientation(), seed, density, limit: None };
        let packing = self.packing.place(shapes, region, &settings, &mut watch);
        bar.0.finish_and_clear();
        let count = shapes.len();
        let option = self.option();
        let packing = packing.with_context(|| format!("{count} people in {name}, {option}"))?;
        if packing.ended == Ended::Cancelled {
            return Err(Interrupted::given_up().into());
        }
        if packing.complete || self.allow_overlap {
            return Ok(packing);
        }
        let wanted = density;
        let Packing { density, clear_density: clear, largest_overlap, .. } = packing;
        let overlap = 1e3 * largest_overlap;
        let other = if self.packing == Method::Paper { "; --packing dense reaches more" } else { "" };
        if region.is_plane() {
            let wanted = wanted.map_or(String::new(), |density| format!(" at --density {density}"));
            bail!(
                "{count} in the open{wanted}, {option}: reached {density:.2} /m², largest overlap {overlap:.2} mm{other}"
            );
        }
        bail!(
            "{count} people in {name}, {option}: that is {density:.2} /m², of which {clear:.2} /m² ({:.0}) were placed without overlap, \
             the others overlap by up to {overlap:.2} mm (--allow-overlap writes it so){other}",
            clear * region.area()
        );
    }

    fn option(&self) -> String {
        format!("--packing {}", self.packing.name())
    }

    /// In words, for the summary.
    pub fn manner(&self) -> String {
        let packing = match self.packing {
            Method::Dense => "dense",
            Method::Paper => "the paper's",
            Method::Grid => "rows",
        };
        let way = match self.orientation() {
            Orientation::Free => "facing any way".to_owned(),
            Orientation::Fixed(_) => format!("facing {}°", self.direction()),
            Orientation::Towards(_) => format!("turned from {}°", self.direction()),
        };
        format!("{packing}, {way}")
    }
}

/// A door leads out of the room: people would walk into a pillar.
fn refuse_obstacle(door: &Door, geometry: &Geometry, grounds: &[Ground]) -> Result<()> {
    let is_obstacle = |wall: &Wall| {
        grounds.iter().any(|ground| ground.free.obstacles.contains(&wall.id))
            && !grounds.iter().any(|ground| ground.free.rooms.contains(&wall.id))
    };
    let Some(wall) = door.wall(geometry).filter(|wall| is_obstacle(wall)) else { return Ok(()) };
    let others = geometry.walls.iter().filter(|wall| !is_obstacle(wall)).cloned().collect();
    let others = Geometry { walls: others, ..geometry.clone() };
    let Door { at: Vec2 { x, y }, width } = door;
    let advice = match (door.wall(&others), nearest_wall(&closed_walls(&others), door.at)) {
        (Some(Wall { id, .. }), Some((_, foot))) => {
            let [x, y] = [foot.place.x, foot.place.y].map(|x| (1e3 * x).round() / 1e3 + 0.0);
            format!("in wall {id} it is --door {x},{y},{width}")
        }
        _ => format!("no other wall is closed: {CLOSE}{OPENINGS}"),
    };
    bail!(
        "--door {x},{y},{width}: the nearest closed wall is {}, an obstacle: nobody stands inside it. A door is in a \
         wall of the room where people stand; {advice}",
        wall.id
    );
}

/// On a terminal, once a placing takes a moment.
struct Bar(ProgressBar);

impl Bar {
    fn new() -> Result<Bar> {
        let bar = crate::print::bar(0, "{spinner} {elapsed:>4}  {msg}")?;
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
