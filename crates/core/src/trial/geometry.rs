//! `Geometry.xml`.

use crate::files::source::FileSource;
use crate::plane::{Vec2, vec2};
use crate::require;
use crate::trial::opening::OpeningTimes;
use crate::trial::schema::{AttributeValue, Schema};
use crate::trial::xml::{Checked, Element, Ids, document, empty, read_alone, read_id, vector};
use crate::xml::{number, quoted};
use std::collections::HashMap;
use std::path::Path;

/// `Geometry.xml`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Geometry {
    /// \[m\] `<Dimensions Lx Ly>`: the size of the drawn area; not used by the mechanics.
    pub dimensions: Option<Vec2>,
    /// In file order.
    pub walls: Vec<Wall>,
}

impl Geometry {
    /// Reads and checks a single `Geometry.xml`, without its materials. Returns its walls and the warnings.
    ///
    /// # Errors
    /// All errors in the file.
    pub fn read_from(files: &dyn FileSource, path: &Path) -> Checked<Geometry> {
        read_alone(files, path, &GEOMETRY, |root| read(root, None))
    }

    /// Returns the walls that never open.
    pub fn fixed_walls(&self) -> impl Iterator<Item = &Wall> {
        self.walls.iter().filter(|wall| wall.open.is_none())
    }

    /// Divides walls into panels.
    ///
    /// # Errors
    /// A sentence: there would be too many.
    pub fn divide(&mut self, panels: PanelChoice) -> Result<(), String> {
        let longest = match panels {
            PanelChoice::Missing => PANEL_LENGTH,
            PanelChoice::Longest(longest) => longest,
        };
        let stays = |wall: &Wall| panels == PanelChoice::Missing && wall.panel_length.is_some();
        self.walls.iter_mut().filter(|wall| !stays(wall)).for_each(|wall| wall.panel_length = Some(longest));
        let count = self.walls.iter().flat_map(Wall::panel_counts).fold(0, usize::saturating_add);
        require(count <= MOST_PANELS, || {
            format!(
                "panels of at most {longest} m would be {count}; at most {MOST_PANELS} can be: take longer ones"
            )
        })
    }

    /// Returns all panels, in file order: the wall of each, and its ends \[m\].
    pub fn panels(&self) -> impl Iterator<Item = (&Wall, [Vec2; 2])> {
        self.walls.iter().flat_map(|wall| wall.panels().map(move |ends| (wall, ends)))
    }

    /// Returns the text of a `Geometry.xml`. Every number is read back as the same double.
    pub fn to_xml(&self) -> String {
        xml(self)
    }
}

/// `<Wall>`: a polyline without thickness, which acts on both sides.
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    /// Id, unique among the walls.
    pub id: String,
    /// Id of its material.
    pub material_id: String,
    /// \[m\] at least two corners; the wall is closed if the last one is at the place of the first.
    pub corners: Vec<Vec2>,
    /// `Open`: when the wall is open; `None` if it never opens.
    pub open: Option<OpeningTimes>,
    /// \[m\] `PanelLength`: length of the longest of its panels; `None` if it has none.
    pub panel_length: Option<f64>,
}

impl Wall {
    /// Makes a wall that never opens, through at least two corners \[m\].
    pub fn new(id: impl Into<String>, material_id: impl Into<String>, corners: Vec<Vec2>) -> Wall {
        Wall { id: id.into(), material_id: material_id.into(), corners, open: None, panel_length: None }
    }

    /// Returns its straight pieces: their ends \[m\].
    pub fn sides(&self) -> impl Iterator<Item = [Vec2; 2]> {
        self.corners.windows(2).map(|ends| [ends[0], ends[1]])
    }

    /// Returns the ends \[m\] of its panels: of the equal parts of its straight pieces, each for itself, for which loads are
    /// outputs.
    pub fn panels(&self) -> impl Iterator<Item = [Vec2; 2]> {
        self.sides().zip(self.panel_counts()).flat_map(|([start, end], count)| {
            let part = move |k: usize| start + (end - start) * (k as f64 / count as f64);
            // The last one ends at the corner, without rounding.
            let at = move |k: usize| if k == count { end } else { part(k) };
            (0..count).map(move |k| [at(k), at(k + 1)])
        })
    }

    /// Returns how many panels each of its straight pieces has; nothing if it has none.
    fn panel_counts(&self) -> impl Iterator<Item = usize> {
        let count =
            |longest| self.sides().map(move |[start, end]| panel_count((end - start).norm(), longest));
        self.panel_length.into_iter().flat_map(count)
    }

    /// Returns whether it is open at a time \[s\].
    pub fn is_open(&self, time: f64) -> bool {
        self.open.as_ref().is_some_and(|open| open.is_open(time))
    }
}

/// Walls that are divided into panels, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PanelChoice {
    /// Those without panels, into some of at most 0.5 m.
    Missing,
    /// All, into panels of at most so many metres.
    Longest(f64),
}

/// \[m\] Length of the longest panel, if nobody says it.
const PANEL_LENGTH: f64 = 0.5;
/// Most panels of a Trial.
const MOST_PANELS: usize = 20_000;

/// Returns the number of panels of a straight piece of a wall, which are of one length; all \[m\].
pub fn panel_count(length: f64, longest: f64) -> usize {
    // A piece of 2.0000000001 m has four of 0.5 m.
    ((length / longest - 1e-9).ceil() as usize).max(1)
}

pub(crate) static GEOMETRY: Schema =
    Schema { name: "Geometry", attributes: &[], children: &[&DIMENSIONS, &WALL] };
static DIMENSIONS: Schema = Schema {
    name: "Dimensions",
    attributes: &[("Lx", AttributeValue::Number), ("Ly", AttributeValue::Number)],
    children: &[],
};
static WALL: Schema = Schema {
    name: "Wall",
    attributes: &[
        ("Id", AttributeValue::Id),
        ("MaterialId", AttributeValue::IdOf("material")),
        ("Open", AttributeValue::Times),
        ("PanelLength", AttributeValue::Positive),
    ],
    children: &[&CORNER],
};
static CORNER: Schema =
    Schema { name: "Corner", attributes: &[("Coordinates", AttributeValue::Point)], children: &[] };

/// Reads the geometry; `materials` is `None` where they could not be read.
pub(crate) fn read(root: Element<'_>, materials: Option<&Ids<'_>>) -> Geometry {
    let dimensions =
        root.at_most_one("Dimensions").map(|element| vec2(element.number("Lx"), element.number("Ly")));
    let (mut walls, mut lines, mut panels) = (Vec::new(), HashMap::new(), 0);
    for element in root.children("Wall") {
        let id = read_id(element, &mut lines);
        let (material_id, _) = element.reference("MaterialId", materials);
        let corners = read_corners(element, &id);
        let open = element.times("Open");
        let panel_length = element.node.has("PanelLength").then(|| element.number("PanelLength"));
        let wall = Wall { id, material_id, corners, open, panel_length };
        let before = panels;
        panels = wall.panel_counts().fold(panels, usize::saturating_add);
        if before <= MOST_PANELS && panels > MOST_PANELS {
            element.wrong("PanelLength", format!("makes more than {MOST_PANELS} panels in all"));
        }
        walls.push(wall);
    }
    Geometry { dimensions, walls }
}

fn read_corners(wall: Element<'_>, id: &str) -> Vec<Vec2> {
    let mut corners: Vec<Vec2> = Vec::new();
    for element in wall.children("Corner") {
        let corner = element.vector("Coordinates");
        let place = corners.len();
        if corners.last().is_some_and(|&before| (corner - before).norm() == 0.0) {
            let before = place - 1;
            let message = format!("corner {place} of wall {} is where corner {before} is", quoted(id));
            element.wrong("Coordinates", message);
        }
        corners.push(corner);
    }
    if corners.len() < 2 {
        wall.error(format!("wall {} has {} corners: it needs two", quoted(id), corners.len()));
    }
    corners
}

pub(crate) fn xml(geometry: &Geometry) -> String {
    document("Geometry", |out| {
        if let Some(size) = geometry.dimensions {
            empty(out, &DIMENSIONS, &[&number(size.x), &number(size.y)]);
        }
        for wall in &geometry.walls {
            let open = wall.open.as_ref().map(OpeningTimes::text);
            let panel_length = wall.panel_length.map(number);
            let values = [Some(&*wall.id), Some(&wall.material_id), open.as_deref(), panel_length.as_deref()];
            out.element("Wall", &WALL.values(&values), |out| {
                for &corner in &wall.corners {
                    empty(out, &CORNER, &[&vector(corner)]);
                }
            });
        }
    })
}
