//! Ground where people stand: the walls of the room, its doors, and the ground that walls leave.

use crate::error::{OUTSIDE, Of, Result, ScenarioError, fits, impossible, require};
use crate::forms::{RegionForm, TwoNumbers};
use crate::{Scenario, WALLS};
use lemons_core::files::source::FileSource;
use lemons_core::message::message;
use lemons_core::plane::{Bounds, Ring, Vec2, vec2};
use lemons_core::trial::{Geometry, Wall};
use lemons_people::drawing::outside::inside;
use lemons_people::drawing::{DrawingFormat, LARGEST_DRAWING, NamedPlace, Read};
use lemons_people::placing::{FreeSpace, Packing, Region};
use lemons_people::room::Room;
use lemons_people::{Door, PeopleError, closed_walls, cut_doors, walls};

pub(crate) const NO_WAY_OUT: &str =
    "`leave`: there is no way out: give `doors` X,Y,WIDTH, or `exits` X1,Y1,X2,Y2";

/// Advice about doors where walls have openings.
const DOORS: &str = "a door is in a closed wall of the room where people stand (`box`, `geometry`): close the wall, and \
                     give its opening as `doors`, too; or leave out `doors`: `regions` takes walls with \
                     openings, and with `leave`, `exits` says where people leave";
/// \[m\] About how broad people are across the shoulders.
const NARROW: f64 = 0.5;

/// Ground on which people stand together.
#[derive(Debug, Clone)]
pub struct StandingArea {
    /// Ground that walls leave.
    pub free: FreeSpace,
    /// Name in messages.
    pub name: String,
    /// Number of people, or their density \[1/m²\]; neither: as the scenario says.
    pub amount: (Option<u32>, Option<f64>),
}

/// Room in which people may stand, with its walls.
#[derive(Debug, Clone)]
pub struct WalkableRoom {
    /// Grounds, at least one.
    pub grounds: Vec<StandingArea>,
    /// Walls, with doors.
    pub geometry: Geometry,
    /// \[m\] The walls that doors were cut into, without them.
    pub lines: Vec<Vec<Vec2>>,
    /// Name that the user gave it.
    pub name: String,
    /// Whether the grounds are regions.
    pub has_regions: bool,
    /// The drawing that it is from; exits on its walls are doors.
    pub drawn: Option<Read>,
    /// Doors that were cut.
    pub doors: Vec<Door>,
    /// Notes of what was chosen, and of what is probably not meant.
    pub notes: Vec<String>,
}

impl WalkableRoom {
    /// Returns whether people stand in the open.
    pub fn is_plane(&self) -> bool {
        self.grounds[0].free.region.is_plane()
    }

    /// Returns the area \[m²\] of all grounds; in the open, of the convex hull of who was placed.
    pub fn area_of(&self, packing: &Packing) -> f64 {
        if self.is_plane() { packing.poses.len() as f64 / packing.density } else { self.area() }
    }

    /// Refuses doors by which people would walk into a pillar, and notes those in which they may get stuck.
    fn check_doors(&mut self, uncut: &Geometry, closed: &[Ring]) -> Result<()> {
        let free = || self.grounds.iter().map(|ground| &ground.free);
        for (number, door) in self.doors.iter().enumerate() {
            if let Some(Wall { id, .. }) = door.wall(uncut)
                && free().any(|free| free.obstacles.contains(id))
                && !free().any(|free| free.rooms.contains(id))
            {
                let ([x, y], width): ([f64; 2], f64) = (door.at.into(), door.width);
                return Err(impossible(format!(
                    "`doors` {x},{y},{width}: the nearest closed wall is {id}, an obstacle: nobody stands inside it; {DOORS}"
                )));
            }
            if door.width < NARROW {
                self.notes.push(format!(
                    "note: `doors`: door {number} is {} m wide: people are about {NARROW} m broad, and may get stuck",
                    (door.width * 1e6).round() / 1e6
                ));
            }
            // A corner lies between the ends of the gap.
            if door.course(closed).len() > 2 {
                self.notes.push(format!(
                    "note: `doors`: door {number} goes round a corner of its wall, because the corner is nearer than half \
                     the width"
                ));
            }
        }
        Ok(())
    }

    /// Returns the area of all grounds \[m²\].
    pub fn area(&self) -> f64 {
        self.grounds.iter().map(|ground| ground.free.region.area()).sum()
    }
}

/// Walls without doors, what they enclose, and what they are called.
type Walls = (Geometry, Result<Region, PeopleError>, String);

impl Scenario {
    /// Reads the drawing of the room, if it is one.
    ///
    /// # Errors
    /// It cannot be read, or there are no walls in it; or it is no drawing, and is to be read as one.
    pub fn drawn(&self, files: &dyn FileSource) -> Result<Option<Read>> {
        let Some((path, format)) =
            self.geometry.as_ref().and_then(|path| Some((path, DrawingFormat::of(path)?)))
        else {
            let usual = Scenario::default();
            let keys = toml::Table::try_from(&self.drawing).unwrap_or_default().into_iter();
            let mut keys = keys.map(|(key, _)| format!("drawing.{key}"));
            let given = keys.find(|key| self.differs(&usual, key));
            return given.map_or(Ok(None), |key| {
                let drawings = "`geometry` FILE.dxf, .geojson, .wkt or .svg";
                Err(ScenarioError::Misused(format!("`{key}` is for drawings: {drawings}")))
            });
        };
        let named = path.display();
        let bytes = files.read(path, LARGEST_DRAWING);
        let bytes = bytes.map_err(|error| impossible(format!("{named}: {error}")))?;
        Read::of(format, &bytes, &self.drawing.reading(), &self.drawing.settings()).of(named).map(Some)
    }

    fn walls(&self, files: &dyn FileSource, drawn: Option<&Read>, notes: &mut Vec<String>) -> Result<Walls> {
        if let Some(TwoNumbers([width, height])) = self.sides {
            let region = Region::rectangle(Vec2::zeros(), vec2(width, height)).of("`box`")?;
            let name = format!("a box of {width} m x {height} m");
            return Ok((walls(region.rings(), WALLS), Ok(region), name));
        }
        if let Some(room) = &self.room {
            let (whole, geometry) = room.uncut(WALLS).of("`room`")?;
            return Ok((geometry, Ok(whole), "the room".into()));
        }
        let Some(path) = &self.geometry else {
            return Ok((walls(&[], ""), Ok(Region::plane()), "the open".into()));
        };
        let geometry = match drawn {
            Some(read) => read.plan.geometry(WALLS),
            None => {
                let (geometry, warnings) = Geometry::read_from(files, path).map_err(ScenarioError::Files)?;
                notes.extend(warnings.iter().map(ToString::to_string));
                geometry
            }
        };
        let whole = Region::from_walls(&geometry);
        Ok((geometry, whole, path.display().to_string()))
    }

    /// Returns where people stand. `drawn` is what [`drawn`](Scenario::drawn) returned.
    ///
    /// # Errors
    /// Walls do not bound a region, a region has no ground, or a door is not at a wall.
    pub fn place(&self, files: &dyn FileSource, mut drawn: Option<Read>) -> Result<WalkableRoom> {
        let mut notes = Vec::new();
        let (geometry, whole, name) = self.walls(files, drawn.as_ref(), &mut notes)?;
        let regions = self.regions_of(drawn.as_ref(), &mut notes)?;
        if let Some(doubt) =
            drawn.as_ref().and_then(|drawn| drawn.doubt.as_ref()).filter(|_| regions.is_empty())
        {
            return Err(impossible(format!(
                "`geometry` {name}: where is the room? {doubt}. lemons room {name} --propose shows what the plan may be, \
                 and the options that take it; `regions` says where people stand in the walls as they are drawn"
            )));
        }
        let of_room = if self.room.is_some() { "`room`".to_owned() } else { format!("`geometry` {name}") };
        // A drawing has open walls, too.
        let outline = drawn.as_ref().and_then(|drawn| Some(&drawn.plan.walls[drawn.plan.outline?]));
        let grounds = if let (Some(outline), Err(_), true) = (outline, &whole, regions.is_empty()) {
            let free = Region::free_space(outline, &geometry, &[]).of(&of_room)?;
            vec![StandingArea { free, name: name.clone(), amount: (None, None) }]
        } else if regions.is_empty() {
            let region = whole.map_err(|error| {
                let open = matches!(error, PeopleError::OpenWall { .. });
                let advice = if open { format!("; {}", self.advice(&geometry)) } else { String::new() };
                impossible(format!("{of_room}: {error}{advice}"))
            })?;
            // All walls are closed; the others are within the outline.
            let is_outline = |wall: &Wall| Bounds::of(wall.corners.iter().copied()) == region.bounds();
            let ids = |outline: bool| {
                let walls = geometry.fixed_walls().filter(|wall| is_outline(wall) == outline);
                walls.map(|wall| wall.id.clone()).collect()
            };
            let (rooms, obstacles) = (ids(true), ids(false));
            let free = FreeSpace { region, rooms, obstacles, walls: Vec::new() };
            vec![StandingArea { free, name: name.clone(), amount: (None, None) }]
        } else {
            grounds(&regions, &geometry, &name)?
        };
        let has_regions = !regions.is_empty();
        let doors = self.all_doors(drawn.as_mut());
        let drawn_exits = drawn.as_ref().map_or(0, |drawn| drawn.plan.exits.len());
        fits(self.ways_out() + doors.len() + drawn_exits > 0, || NO_WAY_OUT.into())?;
        if let Some(room) = &self.room {
            let within = grounds.iter().all(|ground| !has_regions || !ground.free.rooms.is_empty());
            require(within, || message!(OUTSIDE))?;
            let lines = room.lines().of("`room`")?;
            let geometry = Room { doors: doors.clone(), ..room.clone() }.with_doors(geometry).of("`room`")?;
            return Ok(WalkableRoom { grounds, geometry, lines, name, has_regions, drawn, doors, notes });
        }
        let closed = closed_walls(&geometry);
        fits(doors.is_empty() || !closed.is_empty(), || {
            format!("`doors`: there is no closed wall in {name}: {DOORS}")
        })?;
        let cut = cut_doors(geometry.clone(), &doors).of("`doors`")?;
        let lines = closed.iter().map(|ring| ring.closed().to_vec()).collect();
        let mut place =
            WalkableRoom { grounds, geometry: cut, lines, name, has_regions, drawn, doors, notes };
        place.check_doors(&geometry, &closed)?;
        Ok(place)
    }

    /// The doors that were given, and those for the exits of a drawing that lie on its walls.
    fn all_doors(&self, drawn: Option<&mut Read>) -> Vec<Door> {
        let of_room = self.room.iter().flat_map(|room| &room.doors);
        let mut doors: Vec<Door> = of_room.chain(self.doors.iter().map(|door| &door.0)).cloned().collect();
        let Some(Read { plan, .. }) = drawn else { return doors };
        let new = plan.doors();
        doors.extend(new.iter().map(|(_, door)| door.clone()));
        for (exit, _) in new.iter().rev() {
            plan.exits.remove(*exit);
        }
        doors
    }

    /// The regions that were given, else those of the drawing.
    fn regions_of(&self, drawn: Option<&Read>, notes: &mut Vec<String>) -> Result<Vec<RegionForm>> {
        let Some(drawn) = drawn.filter(|_| self.regions.is_empty()) else { return Ok(self.regions.clone()) };
        let placed = |place: &&NamedPlace| inside(&drawn.plan, &place.corners).is_some();
        for (k, place) in drawn.plan.distributions.iter().filter(placed).enumerate() {
            notes.push(format!("region {k}: distribution {:?} of the drawing", place.name));
        }
        // Outside the walls nobody stands.
        let cut = drawn.plan.distributions.iter().map(|place| inside(&drawn.plan, &place.corners));
        let cut: Vec<_> = cut.flatten().map(|corners| RegionForm::of(&corners)).collect();
        match drawn.plan.distributions.first() {
            Some(first) if cut.is_empty() => Err(impossible(format!(
                "distribution {:?} of the drawing is not on the ground: nobody can be placed there (`regions`)",
                first.name
            ))),
            _ => Ok(cut),
        }
    }

    /// Returns what to do about a wall that is open.
    fn advice(&self, geometry: &Geometry) -> String {
        match Bounds::of(geometry.walls.iter().flat_map(|wall| wall.corners.iter().copied())) {
            Some(Bounds { low, high }) if self.doors.is_empty() => format!(
                "`regions` says where people stand among walls with openings, for example `regions` {},{},{},{}",
                low.x, low.y, high.x, high.y
            ),
            _ => DOORS.to_owned(),
        }
    }
}

/// The ground of each region, in their order, among walls. `place` is as the user named the whole.
fn grounds(regions: &[RegionForm], geometry: &Geometry, place: &str) -> Result<Vec<StandingArea>> {
    let mut drawn: Vec<Region> = Vec::new();
    let mut grounds = Vec::new();
    for (k, region) in regions.iter().enumerate() {
        let (name, corners) = (format!("region {k} of {place}"), region.corners());
        let free = Region::free_space(&corners, geometry, &drawn).of(format_args!("`regions`: {name}"))?;
        drawn.push(Region::polygon(&corners, &[]).of("`regions`")?);
        grounds.push(StandingArea { free, name, amount: (region.number, region.density) });
    }
    Ok(grounds)
}
