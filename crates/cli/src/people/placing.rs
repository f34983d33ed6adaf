//! Where a crowd stands: the region, the placer, its progress.

use super::regions::{Ground, RegionArgument, door, grounds, numbers, region};
use super::room::{self, DrawingArguments, MATERIAL};
use super::{named, read};
use crate::error::Misused;
use crate::interrupt::{Interrupt, Interrupted};
use crate::numbers::within;
use crate::print;
use anyhow::{Context, Result, anyhow, bail};
use clap::ValueEnum;
use lemons_core::files::source::Disk;
use lemons_core::plane::{Bounds, Pose, Ring, Vec2, vec2};
use lemons_core::trial::{Geometry, Wall};
use lemons_people::drawing::{Format, Place as DrawnPlace, Read};
use lemons_people::places::inside;
use lemons_people::placing::{
    Ended, FreeSpace, Method, Orientation, Packing, Progress, Region, Settings, Stage,
};
use lemons_people::{Agent, Door, PeopleError, Shape, closed_walls, cut_doors, walls};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Duration;

#[derive(clap::Args)]
#[command(next_help_heading = "Region and packing")]
pub struct PlacingArguments {
    /// Place people in a box with walls, in m, for example 4.56x4.56; its lower left corner is the
    /// origin
    #[arg(long = "box", value_name = "LXxLY", value_parser = sides, allow_hyphen_values = true, group = "region")]
    sides: Option<Vec2>,
    /// Place people inside the closed walls of this Geometry.xml, or of a drawing (.dxf, .geojson, .wkt,
    /// .svg: see lemons room): the largest wall is the outline, the others are holes. With --region, its
    /// walls may have openings. Without --region, people stand on the distributions of a drawing
    #[arg(long, value_name = "FILE", group = "region")]
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
    /// Can be given several times. With times in s it is a door that opens and closes, as in 8,3,1,20,60;
    /// without the last time it stays open, as in 8,3,1,20
    #[arg(long = "door", value_name = "X,Y,WIDTH[,FROM,TO...]", value_parser = door, allow_hyphen_values = true)]
    pub doors: Vec<Door>,
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
    #[arg(long, value_name = "DEGREES", value_parser = within(-360.0, 360.0, " (degrees)"))]
    direction: Option<f64>,
    /// Write the crowd even if some people overlap
    #[arg(long)]
    allow_overlap: bool,
    #[command(flatten)]
    drawing: DrawingArguments,
}

/// A line \[m\], and the times \[s\] at which people can leave there; none: always.
pub type WayOut = ([Vec2; 2], Vec<[f64; 2]>);

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum OrientationArgument {
    Free,
    Fixed,
    Towards,
}

fn sides(text: &str) -> Result<Vec2, String> {
    let side = |text: &str| within(0.1, 1e4, "")(text).ok();
    let sides = text.split_once(['x', 'X', '×']).and_then(|(along, across)| side(along).zip(side(across)));
    let must = "must be two lengths in m with an x between them, as in 4.56x4.56, each from 0.1 to 10000";
    sides.map(|(along, across)| vec2(along, across)).ok_or_else(|| must.into())
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
    /// Whether the grounds are regions.
    pub has_regions: bool,
    /// The drawing that it is from; exits on its walls are doors.
    pub drawn: Option<Read>,
    /// Doors that were cut.
    pub doors: Vec<Door>,
}

impl Place {
    /// The number of doors, and of exits in the drawing.
    pub fn ways_out(&self) -> usize {
        self.doors.len() + self.drawn.as_ref().map_or(0, |drawn| drawn.plan.exits.len())
    }

    pub fn is_plane(&self) -> bool {
        self.grounds[0].free.region.is_plane()
    }

    /// \[m²\]
    pub fn area(&self) -> f64 {
        self.grounds.iter().map(|ground| ground.free.region.area()).sum()
    }
}

/// What to do about doors where walls have openings.
const DOORS: &str = "a door is in a closed wall of the room where people stand (--box, --geometry): close the wall, and \
                     give its opening as a --door, too; or leave out --door: --region takes walls with openings, and \
                     with --leave, --exit says where people leave";
/// \[m\] About how broad people are across the shoulders.
const NARROW: f64 = 0.5;

impl PlacingArguments {
    /// Whether the geometry is a drawing.
    pub fn is_drawing(&self) -> bool {
        self.geometry.as_deref().and_then(Format::of).is_some()
    }

    /// Reads the drawing, and says what was understood.
    fn drawn(&self, path: &Path) -> Result<Read> {
        let read = self.drawing.read(path)?;
        let said = room::said(&read, path);
        let (left_out, said): (Vec<_>, Vec<_>) = said.into_iter().partition(|(what, _)| *what == "left out");
        said.iter().for_each(|(what, how)| note!("{what}: {how}"));
        if !left_out.is_empty() {
            let path = path.display();
            note!(
                "left out: {} kinds of lines, texts and others (lemons room {path} lists them)",
                left_out.len()
            );
        }
        Ok(read)
    }

    pub fn place(&self) -> Result<Place> {
        if let Some(option) = self.drawing.given().filter(|_| !self.is_drawing()) {
            bail!(Misused(format!("{option} is for drawings: --geometry FILE.dxf, .geojson, .wkt or .svg")));
        }
        let mut drawn = None;
        let (geometry, name, whole) = match (self.sides, &self.geometry) {
            (Some(sides), _) => {
                let region = Region::rectangle(Vec2::zeros(), sides).context("--box")?;
                let name = format!("a box of {} m x {} m", sides.x, sides.y);
                (walls(region.rings(), "concrete"), name, Ok(region))
            }
            (None, Some(path)) if self.is_drawing() => {
                let read = drawn.insert(self.drawn(path)?);
                let geometry = read.plan.geometry(MATERIAL);
                let region = Region::from_walls(&geometry);
                (geometry, path.display().to_string(), region)
            }
            (None, Some(path)) => {
                let geometry = read(Geometry::read_from(&Disk, path))?;
                let region = Region::from_walls(&geometry);
                (geometry, path.display().to_string(), region)
            }
            (None, None) => (walls(&[], ""), "the open".to_owned(), Ok(Region::plane())),
        };
        let regions = self.regions_of(drawn.as_ref())?;
        if let Some(doubt) =
            drawn.as_ref().and_then(|drawn| drawn.doubt.as_ref()).filter(|_| regions.is_empty())
        {
            bail!(
                "--geometry {name}: where is the room? {doubt}. lemons room {name} --propose shows what the plan may be, \
                 and the options that take it; --region says where people stand in the walls as they are drawn"
            );
        }
        // A drawing has open walls, too.
        let outline = drawn.as_ref().and_then(|drawn| Some(&drawn.plan.walls[drawn.plan.outline?]));
        let grounds = if let (Some(outline), Err(_), true) = (outline, &whole, regions.is_empty()) {
            let free =
                Region::free_space(outline, &geometry, &[]).with_context(|| format!("--geometry {name}"))?;
            vec![Ground { free, name: name.clone(), amount: (None, None) }]
        } else if regions.is_empty() {
            let region = whole.map_err(|error| match error {
                PeopleError::OpenWall { .. } => anyhow!("{error}; {}", self.advice(&geometry)),
                error => error.into(),
            });
            let region = region.with_context(|| format!("--geometry {name}"))?;
            // All walls are closed; the others are within the outline.
            let is_outline = |wall: &Wall| Bounds::of(wall.corners.iter().copied()) == region.bounds();
            let ids = |outline: bool| {
                let walls = geometry.fixed_walls().filter(|wall| is_outline(wall) == outline);
                walls.map(|wall| wall.id.clone()).collect()
            };
            let (rooms, obstacles) = (ids(true), ids(false));
            let free = FreeSpace { region, rooms, obstacles, walls: Vec::new() };
            vec![Ground { free, name: name.clone(), amount: (None, None) }]
        } else {
            grounds(&regions, &geometry, &name)?
        };
        let closed = closed_walls(&geometry);
        let doors = self.all_doors(drawn.as_mut());
        if !doors.is_empty() && closed.is_empty() {
            bail!(Misused(format!("--door: there is no closed wall in {name}: {DOORS}")));
        }
        let uncut = geometry.clone();
        let geometry = cut_doors(geometry, &doors).context("--door")?;
        let free = || grounds.iter().map(|ground| &ground.free);
        for (number, door) in doors.iter().enumerate() {
            // People would walk into a pillar.
            if let Some(Wall { id, .. }) = door.wall(&uncut)
                && free().any(|free| free.obstacles.contains(id))
                && !free().any(|free| free.rooms.contains(id))
            {
                let ([x, y], width): ([f64; 2], f64) = (door.at.into(), door.width);
                bail!(
                    "--door {x},{y},{width}: the nearest closed wall is {id}, an obstacle: nobody stands inside it; {DOORS}"
                );
            }
            if door.width < NARROW {
                note!(
                    "note: --door: door {number} is {} m wide: people are about {NARROW} m broad, and may get stuck",
                    (door.width * 1e6).round() / 1e6
                );
            }
            // A corner lies between the ends of the gap.
            if door.course(&closed).len() > 2 {
                note!(
                    "note: --door: door {number} goes round a corner of its wall, because the corner is nearer than half \
                     the width"
                );
            }
        }
        Ok(Place { grounds, geometry, closed, name, has_regions: !regions.is_empty(), drawn, doors })
    }

    /// Those that were given, and those for the exits of a drawing that lie on its walls.
    fn all_doors(&self, drawn: Option<&mut Read>) -> Vec<Door> {
        let mut doors = self.doors.clone();
        let Some(Read { plan, .. }) = drawn else { return doors };
        let new = plan.doors();
        doors.extend(new.iter().map(|(_, door)| door.clone()));
        for (exit, _) in new.iter().rev() {
            plan.exits.remove(*exit);
        }
        doors
    }

    /// The regions that were given, else those of the drawing.
    fn regions_of(&self, drawn: Option<&Read>) -> Result<Vec<RegionArgument>> {
        let Some(drawn) = drawn.filter(|_| self.regions.is_empty()) else { return Ok(self.regions.clone()) };
        let placed = |place: &&DrawnPlace| inside(&drawn.plan, &place.corners).is_some();
        for (k, place) in drawn.plan.distributions.iter().filter(placed).enumerate() {
            note!("region {k}: distribution {:?} of the drawing", place.name);
        }
        // Outside the walls nobody stands.
        let cut = drawn.plan.distributions.iter().map(|place| inside(&drawn.plan, &place.corners));
        let cut: Vec<_> = cut.flatten().map(RegionArgument::of).collect();
        if let (true, Some(first)) = (cut.is_empty(), drawn.plan.distributions.first()) {
            bail!(
                "distribution {:?} of the drawing is not on the ground: nobody can be placed there (--region)",
                first.name
            );
        }
        Ok(cut)
    }

    /// What to do about a wall that is open.
    fn advice(&self, geometry: &Geometry) -> String {
        match Bounds::of(geometry.walls.iter().flat_map(|wall| wall.corners.iter().copied())) {
            Some(Bounds { low, high }) if self.doors.is_empty() => format!(
                "--region says where people stand among walls with openings, for example --region {},{},{},{}",
                low.x, low.y, high.x, high.y
            ),
            _ => DOORS.to_owned(),
        }
    }

    /// Lines \[m\] behind the doors, where people \[m\] have left, and the times \[s\] at which they can.
    pub fn ways_out(&self, place: &Place, crowd: &[(Agent, Pose)]) -> Vec<WayOut> {
        let people = crowd.iter().map(|(_, pose)| pose.position);
        let way_out = |door: &Door| Some((door.exit(&place.closed, people.clone())?, door.exit_times()));
        place.doors.iter().filter_map(way_out).collect()
    }

    /// How many stand on each ground, from --number and --density.
    pub fn numbers(&self, place: &Place, number: Option<u32>, density: Option<f64>) -> Result<Vec<usize>> {
        let misused = match (number, density) {
            (Some(_), Some(density)) if place.is_plane() && self.packing != Method::Dense => {
                format!("--density {density} in the open is for --packing dense, not {}", self.option())
            }
            (None, Some(density)) if place.is_plane() => {
                format!("--density {density} in the open needs --number, or --box or --geometry")
            }
            (Some(number), _) if place.is_plane() => return Ok(vec![number as usize]),
            _ => return numbers(&place.grounds, number, density),
        };
        Err(Misused(misused).into())
    }

    pub fn direction(&self) -> f64 {
        self.direction.unwrap_or(0.0)
    }

    /// Lets all face one way, as a mixed crowd does unless it is said otherwise; returns whether they do, along an axis.
    pub fn fixed_along_an_axis(&mut self) -> bool {
        let orientation = *self.orientation.get_or_insert(OrientationArgument::Fixed);
        orientation == OrientationArgument::Fixed && self.direction() % 90.0 == 0.0
    }

    fn orientation(&self) -> Orientation {
        let angle = self.direction().to_radians();
        let turned =
            if self.direction.is_some() { OrientationArgument::Towards } else { OrientationArgument::Free };
        match self.orientation.unwrap_or(turned) {
            OrientationArgument::Free => Orientation::Free,
            OrientationArgument::Fixed => Orientation::Fixed(angle),
            OrientationArgument::Towards => Orientation::Towards(angle),
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
        let (mut packings, mut rest) = (Vec::new(), shapes);
        for (k, (ground, number)) in place.grounds.iter().zip(numbers).enumerate() {
            let (own, others) = rest.split_at(*number);
            rest = others;
            let Ground { free: FreeSpace { region, .. }, name, .. } = ground;
            // Equal grounds are filled in different ways.
            // On a terminal, once a placing takes a moment.
            let bar = print::bar(0, "{spinner} {elapsed:>4}  {msg}")?;
            bar.enable_steady_tick(Duration::from_millis(100));
            let mut watch = |progress: &Progress| {
                bar.set_message(described_progress(progress));
                if interrupt.pressed() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            let seed = seed.wrapping_add(k as u64);
            let settings = Settings { orientation: self.orientation(), seed, density, limit: None };
            let packing = self.packing.place(own, region, &settings, &mut watch);
            bar.finish_and_clear();
            let count = own.len();
            let option = self.option();
            let packing = packing.with_context(|| format!("{count} people in {name}, {option}"))?;
            if packing.ended == Ended::Cancelled {
                return Err(Interrupted::given_up().into());
            }
            if packing.complete || self.allow_overlap {
                packings.push(packing);
                continue;
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

    fn option(&self) -> String {
        format!("--packing {}", self.packing.name())
    }

    /// In words, for the summary.
    pub fn manner(&self) -> String {
        let way = match self.orientation() {
            Orientation::Free => "facing any way".to_owned(),
            Orientation::Fixed(_) => format!("facing {}°", self.direction()),
            Orientation::Towards(_) => format!("turned from {}°", self.direction()),
        };
        format!("{}, {way}", self.packing.name())
    }
}

fn described_progress(Progress { stage, iteration, density, overlap, .. }: &Progress) -> String {
    let stage = match stage {
        Stage::Growing => "growing",
        Stage::Spreading => "spreading",
        Stage::Shaking => "shaking",
        Stage::Pressing => "pressing",
        Stage::Thinning => "too many: thinning",
    };
    let overlap = 1e3 * overlap;
    format!("{stage}: {density:.2} /m², overlap {overlap:.2} mm, iteration {iteration} (Ctrl-C gives up)")
}
