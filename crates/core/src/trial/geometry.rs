//! `Geometry.xml`.

use crate::files::source::FileSource;
use crate::plane::{InPlane, Vec2, vec2};
use crate::trial::ground::{self, GROUND, Ground, MOST_GROUNDS};
use crate::trial::heights::{HEIGHTS, Heights};
use crate::trial::link::{LINK, Link, MOST_LINKS};
use crate::trial::opening::OpeningTimes;
use crate::trial::panels::MOST_PANELS;
use crate::trial::schema::{AttributeValue, Schema};
use crate::trial::xml::{Checked, Element, Ids, document, empty, read_alone, read_id, vector};
use crate::xml::{XmlWriter, number, quoted};
use std::collections::HashMap;
use std::iter;
use std::path::Path;

/// `Geometry.xml`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Geometry {
    /// \[m\] `<Dimensions Lx Ly>`: the size of the drawn area; not used by the mechanics.
    pub dimensions: Option<Vec2>,
    /// In file order.
    pub walls: Vec<Wall>,
    /// Slopes and stairs, in file order; elsewhere the plan is level.
    pub grounds: Vec<Ground>,
    /// Lines that are one, in file order.
    pub links: Vec<Link>,
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

    /// Returns the walls that open at some times, each with its place among all walls.
    pub fn doors(&self) -> impl Iterator<Item = (usize, &Wall)> {
        self.walls.iter().enumerate().filter(|(_, wall)| wall.open.is_some())
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
    /// Where it is above the floor.
    pub heights: Heights,
}

impl Wall {
    /// Makes a wall that never opens, through at least two corners \[m\].
    pub fn new(id: impl Into<String>, material_id: impl Into<String>, corners: Vec<Vec2>) -> Wall {
        Wall {
            id: id.into(),
            material_id: material_id.into(),
            corners,
            open: None,
            panel_length: None,
            heights: Heights::default(),
        }
    }

    /// Returns its straight pieces: their ends \[m\].
    pub fn sides(&self) -> impl Iterator<Item = [Vec2; 2]> {
        self.corners.windows(2).map(|ends| [ends[0], ends[1]])
    }

    /// Returns whether it is open at a time \[s\].
    pub fn is_open(&self, time: f64) -> bool {
        self.open.as_ref().is_some_and(|open| open.is_open(time))
    }
}

pub(crate) static GEOMETRY: Schema =
    Schema { name: "Geometry", attributes: &[], children: &[&DIMENSIONS, &WALL, &GROUND, &LINK] };
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
        HEIGHTS[0],
        HEIGHTS[1],
    ],
    children: &[&CORNER],
};
pub(crate) static CORNER: Schema =
    Schema { name: "Corner", attributes: &[("Coordinates", AttributeValue::Point)], children: &[] };

/// Reads the geometry; `materials` is `None` where they could not be read.
pub(crate) fn read(root: Element<'_>, materials: Option<&Ids<'_>>) -> Geometry {
    let dimensions =
        root.at_most_one("Dimensions").map(|element| vec2(element.number("Lx"), element.number("Ly")));
    let (mut walls, mut lines, mut panels) = (Vec::new(), HashMap::new(), 0);
    for element in root.children("Wall") {
        let id = read_id(element, &mut lines);
        let (material_id, _) = element.reference("MaterialId", materials);
        let corners = read_corners(element, "wall", &id, 2);
        let open = element.times("Open");
        let panel_length = element.node.has("PanelLength").then(|| element.number("PanelLength"));
        let heights = Heights::read(element);
        let wall = Wall { id, material_id, corners, open, panel_length, heights };
        let before = panels;
        panels = wall.stretches().iter().map(|of| of.panels).fold(panels, usize::saturating_add);
        if before <= MOST_PANELS && panels > MOST_PANELS {
            element.wrong("PanelLength", format!("makes more than {MOST_PANELS} panels in all"));
        }
        walls.push(wall);
    }
    let mut lines = HashMap::new();
    let grounds = root.children("Ground").filter_map(|element| {
        let id = read_id(element, &mut lines);
        let corners = read_corners(element, "ground", &id, 3);
        ground::read(element, id, corners)
    });
    let grounds: Vec<Ground> = grounds.collect();
    if grounds.len() > MOST_GROUNDS {
        root.error(format!("{} grounds; at most {MOST_GROUNDS} are allowed", grounds.len()));
    }
    let mut lines = HashMap::new();
    let links = root.children("Link").filter_map(|element| {
        let id = read_id(element, &mut lines);
        let corners: Vec<Vec2> =
            element.children("Corner").map(|corner| corner.vector("Coordinates")).collect();
        let [a, b, c, d] = corners[..] else {
            let (name, count) = (quoted(&id), corners.len());
            element.error(format!("link {name} has {count} corners: it needs four, the ends of two lines"));
            return None;
        };
        let link = Link { id, lines: [[a, b], [c, d]] };
        let said = link.lines.as_flattened().iter().any(|end| !end.is_finite());
        if let (false, Err(why)) = (said, link.check()) {
            element.error(format!("link {}: {why}", quoted(&link.id)));
        }
        Some(link)
    });
    let links: Vec<Link> = links.collect();
    if links.len() > MOST_LINKS {
        root.error(format!("{} links; at most {MOST_LINKS} are allowed", links.len()));
    }
    Geometry { dimensions, walls, grounds, links }
}

/// Reads the corners of a wall or a ground: two, or more, in different places.
fn read_corners(of: Element<'_>, what: &str, id: &str, least: usize) -> Vec<Vec2> {
    let mut corners: Vec<Vec2> = Vec::new();
    for element in of.children("Corner") {
        let corner = element.vector("Coordinates");
        let place = corners.len();
        if corners.last().is_some_and(|&before| (corner - before).norm() == 0.0) {
            let before = place - 1;
            let message = format!("corner {place} of {what} {} is where corner {before} is", quoted(id));
            element.wrong("Coordinates", message);
        }
        corners.push(corner);
    }
    if corners.len() < least {
        let words = if least == 2 { "two" } else { "three" };
        of.error(format!("{what} {} has {} corners: it needs {words}", quoted(id), corners.len()));
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
            let [bottom, top] = wall.heights.values();
            let values =
                [Some(wall.id.clone()), Some(wall.material_id.clone()), open, panel_length, bottom, top];
            let values = values.each_ref().map(Option::as_deref);
            out.element("Wall", &WALL.values(&values), |out| write_corners(out, &wall.corners));
        }
        for ground in &geometry.grounds {
            let numbers = ground::values(ground).map(|value| value.map(number));
            let values = iter::once(Some(&*ground.id)).chain(numbers.iter().map(Option::as_deref));
            let values: Vec<_> = values.collect();
            out.element("Ground", &GROUND.values(&values), |out| write_corners(out, ground.area.corners()));
        }
        for link in &geometry.links {
            out.element("Link", &LINK.values(&[Some(&link.id)]), |out| {
                write_corners(out, link.lines.as_flattened());
            });
        }
    })
}

fn write_corners(out: &mut XmlWriter, corners: &[Vec2]) {
    for &corner in corners {
        empty(out, &CORNER, &[&vector(corner)]);
    }
}
