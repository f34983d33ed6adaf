//! Ground that walls and obstacles of an architect's plan enclose, and the lines that are made of it.
//!
//! [`sort`](super::sort) says what layers and lines are, [`pieces`](super::pieces) mends the ends of walls,
//! [`bands`](super::bands) finds gaps and what is enclosed, obstacles are cut out.

use super::bands::{self, THICKNESS};
use super::gap::{DOOR, Gap, number};
use super::pieces::{Mended, Piece, SNAP, mended, pieces_of};
use super::place::NamedPlace;
use super::role::LayerRole;
use super::sort::{Sort, Sorted, of_name, sorted};
use super::swings::{Swing, swings_of};
use super::{Drawing, DrawnLine};
use crate::error::{Result, require};
use lemons_core::plane::overlay::{self, Contour};
use lemons_core::plane::{Ring, Vec2, convex_hull};
use std::collections::BTreeSet;

/// \[m\] Widest gap that is closed if nothing else is said.
pub const WIDEST_DOOR: f64 = DOOR[1];
/// \[m²\] Rooms and parts that are smaller are not mentioned.
const SMALL_ROOM: f64 = 1.0;
/// Of the area around all walls, what encloses less is in doubt.
pub(super) const FEW: f64 = 1.0 / 3.0;
/// \[m\] Two parallel lines at such a distance may be meant as a wall, and are none.
const TOO_THICK: [f64; 2] = [THICKNESS[1] + 0.01, 1.0];

/// How walls enclose a room.
#[derive(Debug, Clone, PartialEq)]
pub struct Enclosing {
    /// Layers whose closed lines are obstacles.
    pub obstacles: Vec<String>,
    /// \[m\] Gaps of walls up to this width are closed, where they do not lead from room to room.
    pub widest: f64,
}

impl Default for Enclosing {
    fn default() -> Enclosing {
        Enclosing { obstacles: Vec::new(), widest: WIDEST_DOOR }
    }
}

impl Enclosing {
    /// Returns it with the layers of a drawing.
    pub(super) fn parted(&self, drawing: &Drawing) -> Enclosing {
        Enclosing { obstacles: drawing.layers(&self.obstacles), ..self.clone() }
    }
}

/// Ground that walls and obstacles of a drawing make.
pub(super) struct Taken {
    /// The ground without obstacles: its rim, then holes.
    pub ground: Vec<Contour>,
    /// \[m²\] The ground with obstacles.
    pub within: f64,
    pub gaps: Vec<Gap>,
    pub wide: Vec<[Vec2; 2]>,
    pub others: Vec<(Vec2, f64)>,
    /// \[m, m²\] What obstacles cut off.
    pub cut_off: Vec<(Vec2, f64)>,
    /// \[m\] Small gaps that were closed.
    pub closed: Vec<f64>,
    pub thicknesses: Vec<(f64, f64)>,
    /// \[m\] The distance of lines that are too far apart for a wall, if more are so than as far as in walls.
    pub thick: Option<f64>,
    /// Outlines of obstacles, by layer.
    pub blobs: Vec<(String, Vec<Contour>)>,
    /// \[m²\] Of the convex hull of all walls.
    pub hull: f64,
    /// Walls of one line that stand in the ground.
    pub open: Vec<[Vec2; 2]>,
    /// Walls as they are drawn.
    pub drawn: Vec<[Vec2; 2]>,
    /// Which lines were looked at as walls or obstacles.
    pub used: BTreeSet<usize>,
    pub sorted: Sorted,
    pub swings: Vec<Swing>,
}

/// Returns the sorts of lines and layers, and the swings, before somebody chooses.
pub(super) fn seen(lines: &[DrawnLine]) -> Result<(Sorted, Vec<Swing>)> {
    let all: Vec<Piece> =
        pieces_of(asked(lines).filter(|(_, line)| of_name(&line.layer) != Some(Sort::Note)))?;
    let swings = swings_of(lines, &all);
    Ok((sorted(lines, &swings, &all)?, swings))
}

/// Lines of which no layer says what they are.
pub(super) fn asked(lines: &[DrawnLine]) -> impl Iterator<Item = (usize, &DrawnLine)> {
    lines.iter().enumerate().filter(|(_, line)| line.role.is_none())
}

pub(super) fn take(
    lines: &[DrawnLine],
    walls: &[String],
    how: &Enclosing,
    close: Option<f64>,
) -> Result<Taken> {
    let (sorted, swings) = seen(lines)?;
    let (taken, mut used) = (how, BTreeSet::new());
    let is_wall = |line: &DrawnLine| {
        if walls.is_empty() { !taken.obstacles.contains(&line.layer) } else { walls.contains(&line.layer) }
    };
    let close = close.unwrap_or(0.0);
    let of_walls: Vec<(usize, &DrawnLine)> = asked(lines).filter(|(_, line)| is_wall(line)).collect();
    used.extend(of_walls.iter().map(|(k, _)| *k));
    let built = of_walls.iter().copied().filter(|(k, _)| !sorted.aside.contains_key(k));
    let drawn = pieces_of(built)?;
    let Mended { pieces, closed, loose } = mended(drawn.clone(), close);
    let thicknesses = bands::thicknesses(&pieces, THICKNESS);
    let length = |all: &[(f64, f64)]| all.first().map_or(0.0, |(_, length)| *length);
    let thick = bands::thicknesses(&pieces, TOO_THICK);
    let thick = thick.first().filter(|_| length(&thick) > length(&thicknesses)).map(|(apart, _)| *apart);
    let hull = convex_hull(pieces.iter().flat_map(|piece| [piece.a, piece.b]));
    let hull = Ring::through(hull).map_or(0.0, |ring| ring.area());
    let may_shut = |line: &DrawnLine| {
        let layer = sorted.layers.iter().find(|layer| layer.name == line.layer);
        layer.is_some_and(|layer| matches!(layer.sort, Sort::Window | Sort::Wall | Sort::Unclear))
    };
    let panes = asked(lines).filter(|(k, line)| may_shut(line) && !sorted.aside.contains_key(k));
    let panes = pieces_of(panes)?;
    let found = bands::enclose(Mended { pieces, closed: Vec::new(), loose }, &swings, &panes, how.widest)?;
    let mut blobs = Vec::new();
    for layer in &how.obstacles {
        let own: Vec<(usize, &DrawnLine)> = asked(lines).filter(|(_, line)| line.layer == *layer).collect();
        used.extend(own.iter().map(|(k, _)| *k));
        blobs.push((layer.clone(), bands::blobs(&mended(pieces_of(own.into_iter())?, close))));
    }
    let all: Vec<Contour> = blobs.iter().flat_map(|(_, blobs)| blobs.iter().map(left)).collect();
    let within = overlay::area(&found.ground);
    let open = standing(&drawn, &found);
    let (ground, cut_off) = bands::without(&found.ground, &all);
    let place = |polygon: &Vec<Contour>| {
        let corners = polygon.first()?.iter().map(|corner| Vec2::from(*corner)).collect();
        Some((NamedPlace { name: String::new(), corners }.middle().0, overlay::area(polygon)))
    };
    let cut_off = cut_off.iter().filter_map(place).filter(|(_, area)| *area >= SMALL_ROOM).collect();
    let bands::Enclosed { gaps, wide, others, .. } = found;
    let others = others.into_iter().filter(|(_, area)| *area >= SMALL_ROOM).collect();
    Ok(Taken {
        ground,
        within,
        gaps,
        wide,
        others,
        cut_off,
        closed,
        thicknesses,
        thick,
        blobs,
        hull,
        open,
        drawn: drawn.iter().map(|piece| [piece.a, piece.b]).collect(),
        used,
        sorted,
        swings,
    })
}

impl Taken {
    /// Says why walls may enclose too little, where gaps up to a width \[m\] are closed.
    pub(super) fn open_by(&self, widest: f64) -> String {
        match self.thick {
            Some(apart) => format!(
                "lines are {} cm apart, and walls are at most {} cm thick: for thicker ones, draw the inner line alone, or the \
                 floor on a layer walkablearea-0",
                number(100.0 * apart),
                number(100.0 * THICKNESS[1])
            ),
            None => format!("perhaps a gap of more than {widest} m is open (--widest)"),
        }
    }
}

pub(super) fn has_areas(lines: &[DrawnLine]) -> bool {
    lines.iter().any(|line| line.has(LayerRole::WalkableArea) || line.has(LayerRole::Obstacle))
}

/// Pieces of walls within the ground, but not in a passage: they are no rim, and stay as they are.
fn standing(pieces: &[Piece], found: &bands::Enclosed) -> Vec<[Vec2; 2]> {
    let rims: Vec<Ring> = found.ground.iter().filter_map(overlay::ring).collect();
    let passages: Vec<Ring> = found.gaps.iter().filter_map(|gap| Ring::through(gap.quad.to_vec())).collect();
    let stands = |piece: &&Piece| {
        let middle = (piece.a + piece.b) * 0.5;
        let inside = rims.iter().filter(|rim| rim.contains(middle)).count() == 1;
        let on = |ring: &Ring| ring.nearest(middle).distance <= SNAP;
        inside && !rims.iter().any(on) && !passages.iter().any(|quad| quad.contains(middle) || on(quad))
    };
    pieces.iter().filter(stands).map(|piece| [piece.a, piece.b]).collect()
}

/// A contour counter-clockwise.
fn left(contour: &Contour) -> Contour {
    match overlay::ring(contour) {
        Some(ring) if ring.signed_area() < 0.0 => overlay::contour(&ring.reversed()),
        _ => contour.clone(),
    }
}

/// Returns lines in which the rims of what walls enclose take the place of walls and obstacles, and the small gaps \[m\] that
/// were closed.
///
/// # Errors
/// Walls enclose nothing, a layer is not there, or there are too many lines.
pub(super) fn taken(
    mut lines: Vec<DrawnLine>,
    walls: &[String],
    close: Option<f64>,
    how: &Enclosing,
) -> Result<(Vec<DrawnLine>, Vec<f64>)> {
    require(!has_areas(&lines), || {
        "its layers say what is a walkable area or an obstacle: walls that enclose a room are not looked for"
            .to_owned()
    })?;
    for layer in walls.iter().chain(&how.obstacles) {
        require(lines.iter().any(|line| line.layer == *layer), || {
            let mut there: Vec<&str> = lines.iter().map(|line| &*line.layer).collect();
            there.sort_unstable();
            there.dedup();
            format!("there are no lines on layer {layer:?}; layers are: {}", there.join(", "))
        })?;
    }
    let taken = take(&lines, walls, how, close)?;
    require(!taken.ground.is_empty(), || match taken.thick {
        Some(_) => format!("the walls enclose nothing: {}", taken.open_by(how.widest)),
        None => format!(
            "the walls enclose nothing: gaps of more than {} m are not closed, nor are small ones without a width to \
             close them",
            how.widest
        ),
    })?;
    require(taken.within >= FEW * taken.hull, || {
        let Taken { within, hull, .. } = taken;
        let why = taken.open_by(how.widest);
        format!("the walls enclose {within:.1} m² of the {hull:.1} m² that they lie around: {why}")
    })?;
    let Taken { ground, used, closed, open, .. } = taken;
    let layer = walls.first().cloned().unwrap_or_default();
    let mut k = 0;
    lines.retain(|_| {
        k += 1;
        !used.contains(&(k - 1))
    });
    let line = |corners: Vec<Vec2>, closed: bool| {
        let (layer, entity) = (layer.clone(), "a rim of the ground".to_owned());
        DrawnLine { layer, role: None, name: None, entity, corners, closed, hole: false, ground: false }
    };
    let rim = |contour: &Contour| contour.iter().map(|corner| Vec2::from(*corner)).collect();
    lines.extend(ground.iter().map(|contour| line(rim(contour), true)));
    lines.extend(open.iter().map(|ends| line(ends.to_vec(), false)));
    Ok((lines, closed))
}
