//! Meaning of the lines of a drawing: walls, exits, where people stand, way-points.

use super::areas::{Areas, MOST_CORNERS, areas, corners};
use super::collinear::without_overlaps;
use super::enclosing::{Enclosing, taken};
use super::join::{Joined, join, without_doubles};
use super::place::NamedPlace;
use super::role::LayerRole;
use super::{Drawing, DrawnLine, is_same, some_of};
use crate::error::{PeopleError, Result, require};
use crate::placing::{FARTHEST, Region};
use crate::{Door, closed_walls};
use lemons_core::plane::{Bounds, Ring, Vec2, nearest_on_segment};
use lemons_core::trial::{Geometry, Wall};
use std::collections::{BTreeMap, BTreeSet};

/// \[m²\] Smallest area of a wall around something.
const SMALLEST_AREA: f64 = 1e-6;
/// Largest number of exits, of distributions, of way-points.
const MOST_PLACES: usize = 1000;
/// \[m\] An exit that is nowhere further from a wall lies on it.
const ON_A_WALL: f64 = 0.05;
/// \[m\] Nor does anybody get to one that is nowhere further from it: no centre of a body does.
const AT_A_WALL: f64 = 0.2;

/// How a drawing becomes a plan.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlanSettings {
    /// \[m\] Ends of lines that are at most so far apart are joined.
    pub close: Option<f64>,
    /// Whether the lower left corner of everything goes to the origin.
    pub to_origin: bool,
    /// Layers whose lines are walls, where none is named as a walkable area; empty: all. See [`Drawing::layers`].
    pub walls: Vec<String>,
    /// Whether the room is what walls enclose, two lines side by side being one wall.
    pub enclosing: Option<Enclosing>,
}

impl PlanSettings {
    /// Returns settings with the layers of a drawing.
    fn parted(&self, drawing: &Drawing) -> PlanSettings {
        let enclosing = self.enclosing.as_ref().map(|how| how.parted(drawing));
        PlanSettings { walls: drawing.layers(&self.walls), enclosing, ..self.clone() }
    }
}

/// A room, and what is in it.
#[derive(Debug, Clone, PartialEq)]
pub struct FloorPlan {
    /// \[m\] Walls; the first corner of a closed one is repeated at its end.
    pub walls: Vec<Vec<Vec2>>,
    /// The wall around the walkable area, or else around most; none where no wall is closed.
    pub outline: Option<usize>,
    /// Lines and areas.
    pub exits: Vec<NamedPlace>,
    /// Areas.
    pub distributions: Vec<NamedPlace>,
    /// Points and areas.
    pub waypoints: Vec<NamedPlace>,
    /// Gaps that were closed.
    pub joined: Joined,
    /// Number of lines that lay on others, and were left out.
    pub doubles: usize,
    /// Number of pieces of walls that lie on pieces of other walls, and stay.
    pub on_others: usize,
    /// \[m\] What was subtracted from all coordinates.
    pub origin: Vec2,
    /// Entities that were left out: layer and kind, with the number of each.
    pub left_out: BTreeMap<(String, String), usize>,
    /// \[m²\] What people can walk on, of all areas, where outlines and obstacles met and it was calculated.
    pub ground: Option<f64>,
    /// Areas that are drawn as ground, and lie within other ground.
    pub within: Vec<String>,
    /// Whether walkable areas or obstacles are drawn: a closed wall within another one is an obstacle then.
    pub has_areas: bool,
}

impl FloorPlan {
    /// Says what the lines of a drawing mean.
    ///
    /// # Errors
    /// There are no walls, or an area crosses itself.
    pub fn of(drawing: Drawing, settings: &PlanSettings) -> Result<FloorPlan> {
        let settings = &settings.parted(&drawing);
        let Drawing { mut lines, mut left_out, .. } = drawing;
        check_layers(&settings.walls, &lines, &left_out)?;
        let mut mended = Vec::new();
        if let Some(how) = &settings.enclosing {
            (lines, mended) = taken(lines, &settings.walls, settings.close, how)?;
        }
        let says = |role: LayerRole| lines.iter().any(|line| line.has(role));
        let named_areas = says(LayerRole::WalkableArea) || says(LayerRole::Obstacle);
        let has_areas = named_areas || lines.iter().any(|line| line.ground);
        let (mut walls, mut places) = (Vec::new(), BTreeMap::<LayerRole, Vec<(String, DrawnLine)>>::new());
        let mut leave_out = |line: &DrawnLine, why: &str| {
            let kind = line.entity.split(" in line").next().unwrap_or("").split(" at ").next().unwrap_or("");
            *left_out.entry((line.layer.clone(), format!("{kind}{why}"))).or_default() += 1;
        };
        for line in lines {
            match &line.role {
                Some((role @ (LayerRole::Exit | LayerRole::Distribution | LayerRole::Waypoint), name)) => {
                    let (role, name) = (*role, line.name.as_ref().unwrap_or(name).clone());
                    places.entry(role).or_default().push((name, line));
                }
                Some((LayerRole::Unused, _)) => leave_out(&line, " (of JuPedSim, not used)"),
                None if named_areas => leave_out(&line, " (layer without a meaning)"),
                None if !settings.walls.is_empty() && !asked_for(&settings.walls, &line.layer) => {
                    leave_out(&line, " (layer not asked for)");
                }
                _ if line.corners.len() < 2 => leave_out(&line, " (no length)"),
                _ => walls.push(line),
            }
        }
        for (role, places) in &places {
            require(places.len() <= MOST_PLACES, || {
                format!("{} {}: at most {MOST_PLACES} are allowed", places.len(), role.layer())
            })?;
        }
        let (walls, doubles, on_others) = without_doubles(walls, has_areas);
        let (walls, mut joined) = join(walls, settings.close)?;
        let (mut walls, overlaps) = without_overlaps(walls, has_areas)?;
        if overlaps > 0 {
            // What was between the ends of others may meet now.
            let (again, rest) = join(walls, None)?;
            (walls, joined.left) = (again, rest.left);
        }
        let doubles = doubles + overlaps;
        joined.gaps += mended.len();
        joined.largest = mended.into_iter().fold(joined.largest, f64::max);
        let named =
            |role: LayerRole, enough: usize, closed: bool, leave_out: &mut dyn FnMut(&DrawnLine, &str)| {
                let lines = places.get(&role).into_iter().flatten();
                let used = lines.filter(|(_, line)| {
                    let used = line.corners.len() >= enough && (line.closed || !closed);
                    if !used {
                        leave_out(line, if closed { " (not closed)" } else { " (no length)" });
                    }
                    if used && line.hole {
                        leave_out(line, " (hole)");
                    }
                    used && !line.hole
                });
                with_unique_names(used)
            };
        let exits = named(LayerRole::Exit, 2, false, &mut leave_out);
        let distributions = named(LayerRole::Distribution, 3, true, &mut leave_out);
        let waypoints = named(LayerRole::Waypoint, 1, false, &mut leave_out);
        require(!walls.is_empty(), || {
            let what: Vec<String> = left_out.iter().map(super::left_out).collect();
            format!("there are no walls in this drawing; left out: {}", what.join(", "))
        })?;
        let Areas { walls, ground, within } = if has_areas {
            areas(walls)?
        } else {
            Areas { walls: walls.into_iter().map(corners).collect(), ..Areas::default() }
        };
        let mut plan = FloorPlan {
            outline: None,
            walls,
            exits,
            distributions,
            waypoints,
            joined,
            doubles,
            on_others,
            origin: Vec2::zeros(),
            left_out,
            ground,
            within,
            has_areas,
        };
        plan.outline = plan.largest();
        if settings.to_origin {
            plan.move_to_origin();
        }
        Ok(plan)
    }

    fn largest(&self) -> Option<usize> {
        let area = |(k, wall): (usize, &Vec<Vec2>)| {
            let area = Ring::of_closed(wall)?.area();
            (area >= SMALLEST_AREA).then_some((k, area))
        };
        let all = self.walls.iter().enumerate().filter_map(area);
        all.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k)
    }

    fn move_to_origin(&mut self) {
        let Some(bounds) = self.bounds() else { return };
        self.origin = bounds.low;
        let places = self.exits.iter_mut().chain(&mut self.distributions).chain(&mut self.waypoints);
        let lists = self.walls.iter_mut().chain(places.map(|place| &mut place.corners));
        lists.flatten().for_each(|corner| *corner -= bounds.low);
    }

    /// Returns the lowest and the highest coordinates of walls \[m\].
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::of(self.walls.iter().flatten().copied())
    }

    /// Returns the walls of a material. Ids count from 0.
    pub fn geometry(&self, material: &str) -> Geometry {
        let wall = |(id, corners): (usize, &Vec<Vec2>)| Wall::new(id.to_string(), material, corners.clone());
        Geometry {
            dimensions: self.bounds().map(|bounds| bounds.size()),
            walls: self.walls.iter().enumerate().map(wall).collect(),
            ..Geometry::default()
        }
    }

    /// Returns the area \[m²\] inside the outline, without the closed walls in it. `None` if there is no outline, or
    /// nothing is left.
    pub fn area(&self) -> Option<f64> {
        let outline = &self.walls[self.outline?];
        if self.ground.is_some() {
            return self.ground;
        }
        if self.walls.iter().map(Vec::len).sum::<usize>() > MOST_CORNERS {
            return None;
        }
        // Far from the origin nobody is placed.
        let low = self.bounds()?.low;
        let near = |line: &mut Vec<Vec2>| line.iter_mut().for_each(|corner| *corner -= low);
        let (mut outline, mut geometry) = (outline.clone(), self.geometry(""));
        if low.amax() > FARTHEST {
            near(&mut outline);
            geometry.walls.iter_mut().for_each(|wall| near(&mut wall.corners));
        }
        if let Ok(region) = Region::from_walls(&geometry) {
            return Some(region.area());
        }
        Some(Region::free_space(&outline, &geometry, &[]).ok()?.region.area())
    }

    /// Makes the plan of the walls of a Trial, with exits.
    pub fn of_geometry(geometry: &Geometry, exits: Vec<NamedPlace>) -> FloorPlan {
        let mut plan = FloorPlan {
            walls: geometry.walls.iter().map(|wall| wall.corners.clone()).collect(),
            outline: None,
            exits,
            distributions: Vec::new(),
            waypoints: Vec::new(),
            joined: Joined::default(),
            doubles: 0,
            on_others: 0,
            origin: Vec2::zeros(),
            left_out: BTreeMap::new(),
            ground: None,
            within: Vec::new(),
            has_areas: false,
        };
        plan.outline = plan.largest();
        plan
    }

    /// Returns doors for the exits that are lines on a closed wall, with the numbers of these exits: nobody gets there if
    /// the wall is not open.
    pub fn doors(&self) -> Vec<(usize, Door)> {
        let closed = closed_walls(&self.geometry(""));
        let on_a_wall = |line: &[Vec2]| match *line {
            [a, b] => {
                let places = [a, (a + b) * 0.5, b];
                closed
                    .iter()
                    .any(|wall| places.iter().all(|place| wall.nearest(*place).distance <= AT_A_WALL))
            }
            _ => false,
        };
        let exits = self.exits.iter().enumerate().filter(|(_, exit)| on_a_wall(&exit.corners));
        let door = |line: &[Vec2]| Door::new((line[0] + line[1]) * 0.5, (line[1] - line[0]).norm());
        exits.map(|(k, exit)| (k, door(&exit.corners))).filter(|(_, door)| door.width > 0.0).collect()
    }

    /// Adds an exit where a door is: the part of the nearest closed wall that it takes, which [`FloorPlan::doors`] finds.
    ///
    /// # Errors
    /// There is no closed wall, it is further away than the door is wide, or the door goes round a corner.
    pub fn add_door(&mut self, door: &Door) -> Result<()> {
        let closed = closed_walls(&self.geometry(""));
        let ([x, y], width) = (<[f64; 2]>::from(door.at), door.width);
        let far = closed.iter().map(|wall| wall.nearest(door.at).distance).fold(f64::INFINITY, f64::min);
        require(far <= width, || format!("door {x},{y},{width}: no closed wall is within {width} m"))?;
        let course = door.course(&closed);
        let ends = course.first().zip(course.last()).map(|(from, to)| [*from, *to]);
        let straight = |[from, to]: &[Vec2; 2]| {
            course.iter().all(|at| (nearest_on_segment(*from, *to, *at) - at).norm() <= ON_A_WALL)
        };
        let line = ends.filter(straight).ok_or_else(|| {
            PeopleError::new(format!("door {x},{y},{width}: it goes round a corner of its wall"))
        })?;
        let name =
            (1..).map(|k| format!("door {k}")).find(|name| !self.exits.iter().any(|exit| exit.name == *name));
        self.exits.push(NamedPlace { name: name.unwrap_or_default(), corners: line.to_vec() });
        Ok(())
    }

    /// Returns the numbers of the exits that lie inside a closed wall, and are no doors: who leaves there is still in the room.
    pub fn inner_exits(&self) -> Vec<usize> {
        let (closed, doors) = (closed_walls(&self.geometry("")), self.doors());
        let inside = |exit: &NamedPlace, wall: &Ring| {
            exit.corners
                .iter()
                .all(|corner| wall.contains(*corner) || wall.nearest(*corner).distance <= ON_A_WALL)
        };
        let is_inner = |(k, exit): (usize, &NamedPlace)| {
            let door = doors.iter().any(|(of, _)| *of == k);
            (!door && closed.iter().any(|wall| inside(exit, wall))).then_some(k)
        };
        self.exits.iter().enumerate().filter_map(is_inner).collect()
    }

    /// Returns the way-points, if their names end in numbers that say their order.
    pub fn way(&self) -> Option<Vec<&NamedPlace>> {
        let number = |place: &NamedPlace| {
            let digits = place.name.len() - place.name.trim_end_matches(|c: char| c.is_ascii_digit()).len();
            place.name[place.name.len() - digits..].parse::<u64>().ok()
        };
        let mut way: Vec<(u64, &NamedPlace)> =
            self.waypoints.iter().map(|place| Some((number(place)?, place))).collect::<Option<_>>()?;
        way.sort_by_key(|(number, _)| *number);
        let differ = way.windows(2).all(|pair| pair[0].0 < pair[1].0);
        (differ && !way.is_empty()).then(|| way.into_iter().map(|(_, place)| place).collect())
    }
}

fn asked_for(walls: &[String], layer: &str) -> bool {
    walls.iter().any(|wall| is_same(wall, layer))
}

/// Refuses layers that are not in the drawing.
fn check_layers(
    walls: &[String],
    lines: &[DrawnLine],
    left_out: &BTreeMap<(String, String), usize>,
) -> Result<()> {
    let there: BTreeSet<&str> =
        lines.iter().map(|line| &*line.layer).chain(left_out.keys().map(|(layer, _)| &**layer)).collect();
    let missing = walls.iter().find(|wall| !there.iter().any(|layer| asked_for(&[(*wall).clone()], layer)));
    match missing {
        None => Ok(()),
        Some(wall) => {
            let named: Vec<String> =
                there.iter().filter(|layer| !layer.is_empty()).map(|layer| format!("{layer:?}")).collect();
            Err(PeopleError::new(format!(
                "there is no layer {wall:?} for walls in this drawing; there are {}",
                if named.is_empty() { "none".to_owned() } else { some_of(&named) }
            )))
        }
    }
}

/// Returns places with names of which no two are equal: those that are, or that are missing, get a number.
fn with_unique_names<'a>(lines: impl Iterator<Item = &'a (String, DrawnLine)>) -> Vec<NamedPlace> {
    let mut places: Vec<NamedPlace> = Vec::new();
    for (name, line) in lines {
        let corners = line.corners.clone();
        let corners = if line.closed || corners.len() < 3 {
            corners
        } else {
            vec![corners[0], corners[corners.len() - 1]]
        };
        let is_new = |name: &String| !places.iter().any(|place| place.name == *name);
        let numbered = |k: usize| if name.is_empty() { k.to_string() } else { format!("{name} {k}") };
        let name = if !name.is_empty() && is_new(name) {
            name.clone()
        } else {
            (places.len()..).map(numbered).find(is_new).unwrap_or_default()
        };
        places.push(NamedPlace { name, corners });
    }
    places
}
