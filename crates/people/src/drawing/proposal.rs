//! What an architect's plan seems to be: proposals and questions, and what is made of those that are taken.
//!
//! The route of a drawing: [`sort`](super::sort) says what layers and lines are, [`pieces`](super::pieces) mends the ends
//! of walls, [`bands`](super::bands) finds gaps and what is enclosed, obstacles are cut out. [`Plan::of`] takes the rims as
//! walls ([`taken`]); [`Proposal`] says what it would take, and asks.

use super::bands::{self, DOOR, Gap, Leads, THICKNESS};
use super::pieces::{Mended, Piece, SNAP, mended, pieces_of};
use super::sort::{Flight, Layer, Sort, Sorted, of_name, sorted};
use super::swings::{self, Swing, swings_of};
use super::{Drawing, Line, Plan, Role, WIDEST_GAP};
use crate::error::{Result, require};
use crate::{Door, is_closed};
use lemons_core::plane::overlay::{self, Contour};
use lemons_core::plane::{Bounds, Ring, Vec2, convex_hull, segments_touch, vec2};
use std::collections::{BTreeMap, BTreeSet};

/// \[m\] Widest gap that is closed if nothing else is said.
pub const WIDEST_DOOR: f64 = DOOR[1];
/// \[m²\] Rooms and parts that are smaller are not mentioned.
const SMALL_ROOM: f64 = 1.0;
/// Of the area around all walls, what encloses less is in doubt.
const FEW: f64 = 1.0 / 3.0;
/// Of what lies around all walls, an outline that lies around less is in doubt.
const MOST: f64 = 0.7;
/// More of a kind are only counted.
const MOST_SAID: usize = 100;

/// \[m\] Two parallel lines at such a distance may be meant as a wall, and are none.
const TOO_THICK: [f64; 2] = [THICKNESS[1] + 0.01, 1.0];
/// \[m\] Walls of a room are further away from a frame around it.
const FRAME: f64 = 1.0;

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

/// What walls and obstacles of a drawing make.
struct Taken {
    /// The ground without obstacles: its rim, then holes.
    ground: Vec<Contour>,
    /// \[m²\] The ground with obstacles.
    within: f64,
    gaps: Vec<Gap>,
    wide: Vec<[Vec2; 2]>,
    others: Vec<(Vec2, f64)>,
    /// \[m, m²\] What obstacles cut off.
    cut_off: Vec<(Vec2, f64)>,
    /// \[m\] Small gaps that were closed.
    closed: Vec<f64>,
    thicknesses: Vec<(f64, f64)>,
    /// \[m\] The distance of lines that are too far apart for a wall, if more are so than as far as in walls.
    thick: Option<f64>,
    /// Outlines of obstacles, by layer.
    blobs: Vec<(String, Vec<Contour>)>,
    /// \[m²\] Of the convex hull of all walls.
    hull: f64,
    /// Walls of one line that stand in the ground.
    open: Vec<[Vec2; 2]>,
    /// Walls as they are drawn.
    drawn: Vec<[Vec2; 2]>,
    /// Which lines were looked at as walls or obstacles.
    used: BTreeSet<usize>,
    sorted: Sorted,
    swings: Vec<Swing>,
}

/// What a drawing is, before somebody chooses.
fn seen(lines: &[Line]) -> Result<(Sorted, Vec<Swing>)> {
    let all: Vec<Piece> =
        pieces_of(asked(lines).filter(|(_, line)| of_name(&line.layer) != Some(Sort::Note)))?;
    let swings = swings_of(lines, &all);
    Ok((sorted(lines, &swings, &all)?, swings))
}

/// Lines of which no layer says what they are.
fn asked(lines: &[Line]) -> impl Iterator<Item = (usize, &Line)> {
    lines.iter().enumerate().filter(|(_, line)| line.role.is_none())
}

fn take(lines: &[Line], walls: &[String], how: &Enclosing, close: Option<f64>) -> Result<Taken> {
    let (sorted, swings) = seen(lines)?;
    let (taken, mut used) = (how, BTreeSet::new());
    let is_wall = |line: &Line| {
        if walls.is_empty() { !taken.obstacles.contains(&line.layer) } else { walls.contains(&line.layer) }
    };
    let close = close.unwrap_or(0.0);
    let of_walls: Vec<(usize, &Line)> = asked(lines).filter(|(_, line)| is_wall(line)).collect();
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
    let may_shut = |line: &Line| {
        let layer = sorted.layers.iter().find(|layer| layer.name == line.layer);
        layer.is_some_and(|layer| matches!(layer.sort, Sort::Window | Sort::Wall | Sort::Unclear))
    };
    let panes = asked(lines).filter(|(k, line)| may_shut(line) && !sorted.aside.contains_key(k));
    let panes = pieces_of(panes)?;
    let found = bands::enclose(Mended { pieces, closed: Vec::new(), loose }, &swings, &panes, how.widest)?;
    let mut blobs = Vec::new();
    for layer in &how.obstacles {
        let own: Vec<(usize, &Line)> = asked(lines).filter(|(_, line)| line.layer == *layer).collect();
        used.extend(own.iter().map(|(k, _)| *k));
        blobs.push((layer.clone(), bands::blobs(&mended(pieces_of(own.into_iter())?, close))));
    }
    let all: Vec<Contour> = blobs.iter().flat_map(|(_, blobs)| blobs.iter().map(left)).collect();
    let within = overlay::area(&found.ground);
    let open = standing(&drawn, &found);
    let (ground, cut_off) = bands::without(&found.ground, &all);
    let place = |polygon: &Vec<Contour>| {
        let corners = polygon.first()?.iter().map(|corner| Vec2::from(*corner)).collect();
        Some((super::Place { name: String::new(), corners }.middle().0, overlay::area(polygon)))
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
    fn open_by(&self, widest: f64) -> String {
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

fn has_areas(lines: &[Line]) -> bool {
    lines.iter().any(|line| line.has(Role::WalkableArea) || line.has(Role::Obstacle))
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
    mut lines: Vec<Line>,
    walls: &[String],
    close: Option<f64>,
    how: &Enclosing,
) -> Result<(Vec<Line>, Vec<f64>)> {
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
        Line { layer, role: None, name: None, entity, corners, closed, hole: false, ground: false }
    };
    let rim = |contour: &Contour| contour.iter().map(|corner| Vec2::from(*corner)).collect();
    lines.extend(ground.iter().map(|contour| line(rim(contour), true)));
    lines.extend(open.iter().map(|ends| line(ends.to_vec(), false)));
    Ok((lines, closed))
}

/// What a plan seems to be.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// Each layer without a role, and what its lines seem to be.
    pub layers: Vec<Layer>,
    /// Layers with walls.
    pub walls: Vec<String>,
    /// Layers with obstacles, and how far gaps are closed.
    pub enclosing: Enclosing,
    /// \[m\] Up to which width small gaps are closed; none if there are none.
    pub close: Option<f64>,
    /// \[m\] Those small gaps.
    pub closed: Vec<f64>,
    /// \[m\] Thicknesses of walls, each with the length of such walls.
    pub thicknesses: Vec<(f64, f64)>,
    /// \[m\] The rim of the ground without obstacles, then its holes; none where walls enclose nothing.
    pub ground: Vec<Vec<Vec2>>,
    /// \[m\] Walls of one line that stand in the ground.
    pub open: Vec<[Vec2; 2]>,
    /// \[m\] Walls as they are drawn.
    pub drawn: Vec<[Vec2; 2]>,
    /// \[m\] Ends of gaps that are too wide to be closed.
    pub wide: Vec<[Vec2; 2]>,
    /// \[m²\] The area within walls, and that without obstacles.
    pub areas: [f64; 2],
    /// Gaps of its walls.
    pub gaps: Vec<Gap>,
    /// Number of obstacles, by layer, and their area \[m²\].
    pub obstacles: Vec<(String, usize, f64)>,
    /// Stairs.
    pub flights: Vec<Flight>,
    /// Number of swings.
    pub swings: usize,
    /// What is not clear.
    pub questions: Vec<String>,
}

impl Proposal {
    /// Says what a drawing seems to be. What is given is not looked for: layers of walls and of obstacles, and a width up
    /// to which gaps are closed. `None` if layers say what they are.
    ///
    /// # Errors
    /// There are too many lines.
    pub fn of(
        drawing: &Drawing,
        walls: &[String],
        close: Option<f64>,
        given: Option<&Enclosing>,
    ) -> Result<Option<Proposal>> {
        let lines = &drawing.lines;
        if has_areas(lines) {
            return Ok(None);
        }
        let (Sorted { layers, .. }, _) = seen(lines)?;
        let of = |is: fn(Sort) -> bool| -> Vec<String> {
            layers.iter().filter(|layer| is(layer.sort)).map(|layer| layer.name.clone()).collect()
        };
        let walls = if walls.is_empty() { of(|sort| sort == Sort::Wall) } else { drawing.layers(walls) };
        let mut enclosing = given.map(|how| how.parted(drawing)).unwrap_or_default();
        if given.is_none() {
            enclosing.obstacles = of(Sort::is_obstacle);
        }
        enclosing.obstacles.retain(|layer| !walls.contains(layer));
        let mut taken = take(lines, &walls, &enclosing, Some(close.unwrap_or(WIDEST_GAP)))?;
        let largest = taken.closed.iter().copied().fold(0.0, f64::max);
        let mut own = close.filter(|_| largest > 0.0);
        if close.is_none() && largest > 0.0 {
            let steps = [0.005, 0.01, 0.02, 0.03, 0.05, WIDEST_GAP];
            own = steps.into_iter().find(|step| *step >= largest);
            taken = take(lines, &walls, &enclosing, own)?;
        }
        enclosing
            .obstacles
            .retain(|layer| taken.blobs.iter().any(|(of, blobs)| of == layer && !blobs.is_empty()));
        Ok(Some(Proposal::from(taken, layers, walls, enclosing, own)))
    }

    fn from(
        taken: Taken,
        layers: Vec<Layer>,
        walls: Vec<String>,
        enclosing: Enclosing,
        close: Option<f64>,
    ) -> Proposal {
        let mut proposal = Proposal {
            questions: Vec::new(),
            layers,
            walls,
            enclosing,
            close,
            open: taken.open.clone(),
            drawn: taken.drawn.clone(),
            wide: taken.wide.clone(),
            areas: [taken.within, overlay::area(&taken.ground)],
            ground: taken
                .ground
                .iter()
                .map(|contour| contour.iter().map(|corner| Vec2::from(*corner)).collect())
                .collect(),
            obstacles: taken
                .blobs
                .iter()
                .map(|(layer, blobs)| {
                    let areas = blobs.iter().filter_map(overlay::ring).map(|ring| ring.area());
                    (layer.clone(), blobs.len(), areas.sum())
                })
                .collect(),
            flights: taken.sorted.flights.clone(),
            swings: taken.swings.len(),
            closed: taken.closed.clone(),
            thicknesses: taken.thicknesses.clone(),
            gaps: taken.gaps.clone(),
        };
        // In the order of the plan: from left to right, from low to high.
        proposal.gaps.sort_by(|a, b| {
            (a.at().x, a.at().y).partial_cmp(&(b.at().x, b.at().y)).unwrap_or(std::cmp::Ordering::Equal)
        });
        proposal.questions = proposal.asked(&taken);
        proposal
    }

    /// Returns the proposal with the lower left corner of the ground at the origin, where the room's would be.
    #[must_use]
    pub fn at_origin(self) -> Proposal {
        let low = Bounds::of(self.ground.iter().flatten().copied()).map(|bounds| bounds.low);
        match low {
            Some(low) => self.moved(-low),
            None => self,
        }
    }

    /// Moves everything by a vector \[m\].
    fn moved(mut self, by: Vec2) -> Proposal {
        let pieces = [&mut self.open, &mut self.drawn, &mut self.wide].into_iter().flatten().flatten();
        self.ground.iter_mut().flatten().chain(pieces).for_each(|corner| *corner += by);
        self.gaps.iter_mut().for_each(|gap| {
            gap.ends.iter_mut().chain(&mut gap.quad).for_each(|corner| *corner += by);
        });
        self
    }

    /// Returns the doors that it proposes: gaps to the outside that can be one.
    pub fn doors(&self) -> Vec<Door> {
        let doors = self.gaps.iter().filter(|gap| gap.leads == Leads::Outside && gap.is_door());
        doors.map(Gap::door).collect()
    }

    /// Returns whether the rim of the ground may be a frame, and the rest has a way in.
    fn is_frame(&self, rim: &Ring) -> bool {
        let enters = |gap: &Gap| gap.leads == Leads::Inside && rim.nearest(gap.at()).distance > FRAME;
        self.gaps.iter().any(enters) && is_alone(rim, self.drawn.iter().copied())
    }

    fn asked(&self, taken: &Taken) -> Vec<String> {
        let mut asked = Vec::new();
        if self.walls.is_empty() {
            asked.push("which layers have walls? Nothing says it: --walls LAYERS".to_owned());
        }
        if let (true, Some(_)) = (taken.ground.is_empty(), taken.thick) {
            asked.push(format!("where is the room? {}", taken.open_by(self.enclosing.widest)));
        } else if taken.ground.is_empty() {
            asked.push(format!(
                "where is the room? The walls enclose nothing: --close joins small gaps, --widest closes those of more \
                 than {} m",
                self.enclosing.widest
            ));
        } else if taken.within < FEW * taken.hull {
            asked.push(format!(
                "is this the room? It is {:.1} m² of the {:.1} m² that walls lie around: {}",
                taken.within,
                taken.hull,
                taken.open_by(self.enclosing.widest)
            ));
        }
        let rim: Vec<Ring> = self.ground.iter().filter_map(|ring| Ring::through(ring.clone())).collect();
        asked.extend(rim.first().filter(|rim| self.is_frame(rim)).map(about_frame));
        let in_room = |at: Vec2| rim.iter().filter(|ring| ring.contains(at)).count() == 1;
        for [a, b] in taken.wide.iter().filter(|[a, b]| !in_room((a + b) * 0.5)).take(MOST_SAID) {
            let width = number((b - a).norm());
            asked.push(format!(
                "is the gap of {width} m from {} to {} an opening of the room? It is not closed: --widest {width}",
                place(*a),
                place(*b)
            ));
        }
        for (at, area) in taken.others.iter().take(MOST_SAID) {
            asked.push(format!(
                "is the closed area of {area:.1} m² at {} another room? No gap leads there, and nobody is placed in it",
                place(*at)
            ));
        }
        for (at, area) in taken.cut_off.iter().take(MOST_SAID) {
            asked.push(format!(
                "do people get to the ground of {area:.1} m² at {}? Obstacles cut it off, and it is left out",
                place(*at)
            ));
        }
        let has_windows = self.layers.iter().any(|layer| layer.sort == Sort::Window);
        for gap in self.gaps.iter().filter(|gap| gap.leads == Leads::Outside).take(MOST_SAID) {
            let at = format!("{} m wide at {}", number(gap.width()), place(gap.at()));
            if gap.crossed && gap.leaves == 0 && has_windows {
                continue;
            } else if gap.crossed && gap.leaves == 0 {
                asked.push(format!("is the gap {at} a window? Lines run across it, and it stays shut"));
            } else if gap.is_door() && gap.leaves == 0 {
                asked.push(format!("is the gap {at} a door? No swing is drawn"));
            }
        }
        for Layer { name, lines, bounds, .. } in
            self.layers.iter().filter(|layer| layer.sort == Sort::Unclear)
        {
            let size = bounds.size();
            asked.push(format!(
                "what is on layer {name:?}? {lines} lines, {} m x {} m from {}; they are left out: --walls or --obstacles \
                 takes them",
                number(size.x),
                number(size.y),
                place(bounds.low)
            ));
        }
        for Flight { middle, tread, lines } in self.flights.iter().take(MOST_SAID) {
            asked.push(format!(
                "what are the stairs at {} ({} lines, {} m apart)? People walk over them as on the floor: --obstacles \
                 with their layer walls them off, a line on a layer exits-… lets people leave there",
                place(*middle),
                lines.len(),
                number(*tread)
            ));
        }
        asked
    }

    /// Says what it proposes, a line each: what, and how much of it.
    pub fn said(&self) -> Vec<(&'static str, String)> {
        let mut said = Vec::new();
        for layer in self.layers.iter().take(MOST_SAID) {
            said.push(("layer", self.layer(layer)));
        }
        if !self.ground.is_empty() {
            let all = Bounds::of(self.ground.iter().flatten().copied()).unwrap_or(Bounds::UNIT);
            let [x, y] = <[f64; 2]>::from(all.size()).map(number);
            said.push((
                "outline",
                format!("{x} m x {y} m from {}, {:.3} m² within walls", place(all.low), self.areas[0]),
            ));
            said.push(("ground", format!("{:.3} m² without obstacles", self.areas[1])));
        }
        for (thickness, length) in self.thicknesses.iter().take(5) {
            said.push((
                "wall of two lines",
                format!("{} cm thick, {length:.1} m of it", number(100.0 * thickness)),
            ));
        }
        if !self.open.is_empty() {
            let length: f64 = self.open.iter().map(|[a, b]| (b - a).norm()).sum();
            said.push(("walls of one line", format!("{length:.1} m of it stand in the ground")));
        }
        for (layer, count, area) in &self.obstacles {
            said.push(("obstacles", format!("{count} on layer {layer:?}, {area:.3} m²")));
        }
        if let Some(close) = self.close {
            let largest = self.closed.iter().copied().fold(0.0, f64::max);
            said.push((
                "small gaps",
                format!(
                    "{} between ends of lines, the largest {:.1} mm: --close {}cm joins them",
                    self.closed.len(),
                    1e3 * largest,
                    number(100.0 * close)
                ),
            ));
        }
        for gap in &self.gaps {
            said.push((gap.kind(), gap.described()));
        }
        said.extend(self.questions.iter().map(|question| ("question", question.clone())));
        said
    }

    fn layer(&self, Layer { name, sort, by_name, lines, .. }: &Layer) -> String {
        let (walls, obstacles) = (self.walls.contains(name), self.enclosing.obstacles.contains(name));
        let does = match () {
            () if walls => "",
            () if obstacles => ", as obstacles",
            () if *sort == Sort::Door => ", which say where doors are",
            () if *sort == Sort::Window => ", which shut gaps",
            () => ", left out",
        };
        let from = if *by_name { "by its name" } else { "by how its lines lie" };
        let sort = if walls { Sort::Wall } else { *sort };
        let from = if sort == Sort::Unclear { String::new() } else { format!(" ({from})") };
        let plural = if *lines == 1 { "" } else { "s" };
        format!("{name:?}: {}{from}, {lines} line{plural}{does}", sort.name())
    }

    /// Returns the options of the command that take what is proposed.
    pub fn options(&self) -> Vec<String> {
        let mut options = vec!["--enclosed".to_owned()];
        // A name with a comma is an option of its own.
        let mut list = |option: &str, layers: &[String]| {
            let alone = layers.iter().any(|layer| layer.contains(','));
            let lists = if alone { layers.to_vec() } else { vec![layers.join(",")] };
            let given = lists.into_iter().filter(|list| !list.is_empty());
            options.extend(given.flat_map(|list| [option.to_owned(), list]));
        };
        list("--walls", &self.walls);
        list("--obstacles", &self.enclosing.obstacles);
        if let Some(close) = self.close {
            options.extend(["--close".to_owned(), format!("{}cm", number(100.0 * close))]);
        }
        if self.enclosing.widest != WIDEST_DOOR {
            options.extend(["--widest".to_owned(), number(self.enclosing.widest)]);
        }
        for Door { at, width, .. } in self.doors() {
            options.extend(["--door".to_owned(), format!("{},{}", place(at), number(width))]);
        }
        options
    }
}

impl Gap {
    /// Returns it as a door, to the millimetre.
    pub fn door(&self) -> Door {
        let whole = |length: f64| (1e3 * length).round() / 1e3;
        let at = self.at();
        Door::new(vec2(whole(at.x), whole(at.y)), whole(self.width()))
    }

    /// Returns what it seems to be.
    pub fn kind(&self) -> &'static str {
        match self.leads {
            _ if self.crossed && self.leaves == 0 => "window",
            Leads::Outside if self.is_door() => "door",
            Leads::Outside => "gap",
            Leads::Inside => "passage",
            Leads::Elsewhere => "gap",
        }
    }

    /// Says how wide it is, where, and what it is.
    pub fn described(&self) -> String {
        let [a, b] = self.ends.map(place);
        let leaves = match self.leaves {
            0 => String::new(),
            1 => ", 1 leaf".to_owned(),
            count => format!(", {count} leaves"),
        };
        let what = match self.leads {
            _ if self.crossed && self.leaves == 0 => "lines run across it: shut",
            Leads::Outside if self.is_door() && !self.open => {
                "to the outside, drawn on a wall that runs through"
            }
            Leads::Outside if self.is_door() => "to the outside",
            Leads::Outside if self.width() < DOOR[0] => "too narrow for a door: shut",
            Leads::Outside => "too wide for a door: shut",
            Leads::Inside => "between rooms: open",
            Leads::Elsewhere => "to a room that is left out: shut",
        };
        format!("{} m wide at {}, from {a} to {b}; {what}{leaves}", number(self.width()), place(self.at()))
    }
}

/// Returns whether a rim is an upright rectangle that no other wall is near.
fn is_alone(rim: &Ring, mut walls: impl Iterator<Item = [Vec2; 2]>) -> bool {
    let far = |at: &Vec2| rim.nearest(*at).distance;
    rim.is_upright()
        && walls.all(|ends| {
            let crosses = || rim.sides().any(|(a, b)| segments_touch(a, b, ends[0], ends[1]));
            let (near, away) = (|end| far(end) <= THICKNESS[1], |end| far(end) > FRAME);
            ends.iter().all(near) || (ends.iter().all(away) && !crosses())
        })
}

fn about_frame(frame: &Ring) -> String {
    let size = frame.bounds().size();
    format!(
        "is the rectangle of {} m x {} m a frame of the sheet, or a fence? No other wall meets it, and the walls of a room \
         stand in it: --walls without its layer leaves it out",
        number(size.x),
        number(size.y)
    )
}

/// Asks whether the outline of a plan is the frame of a sheet, as a proposal for its walls does.
fn frame(plan: &Plan, outline: &Ring) -> Option<String> {
    let sides = || plan.walls.iter().flat_map(|wall| wall.windows(2).map(|ends| [ends[0], ends[1]]));
    if plan.has_areas || plan.walls.len() < 2 || !is_alone(outline, sides()) {
        return None;
    }
    let line = |corners: &Vec<Vec2>| Line {
        layer: String::new(),
        role: None,
        name: None,
        entity: String::new(),
        corners: corners.clone(),
        closed: false,
        hole: false,
        ground: false,
    };
    let lines: Vec<Line> = plan.walls.iter().map(line).collect();
    // Too many lines are not looked at.
    let taken = take(&lines, &[], &Enclosing::default(), None).ok()?;
    let found = Proposal::from(taken, Vec::new(), Vec::new(), Enclosing::default(), None);
    let rim = Ring::through(found.ground.first()?.clone())?;
    found.is_frame(&rim).then(|| about_frame(&rim))
}

/// Lines of layers, by their corners.
type Layers = BTreeMap<String, Vec<Vec<Vec2>>>;

/// Returns layers that are no walls by their names, such as frames, titles and texts, with their lines.
pub(super) fn notes(lines: &[Line]) -> Layers {
    let mut notes = Layers::new();
    for (_, line) in asked(lines).filter(|(_, line)| of_name(&line.layer) == Some(Sort::Note)) {
        notes.entry(line.layer.clone()).or_default().push(line.corners.clone());
    }
    notes
}

/// Says why the outline of a plan may not be the room; `None` if nothing speaks against it. Without notes, it is no frame.
pub(super) fn doubt(plan: &Plan, notes: Option<&Layers>) -> Option<String> {
    let Some(outline) = plan.outline else {
        return Some("no wall is closed, so nothing is inside".to_owned());
    };
    let swing = |(k, wall): (usize, &Vec<Vec2>)| Some((k, swings::within(wall)?));
    if let Some((k, Swing { hinge, shut, .. })) =
        plan.walls.iter().enumerate().filter(|(_, wall)| is_closed(wall)).find_map(swing)
    {
        return Some(format!(
            "wall {k} is closed by the swing of a door only, {} m wide at {}: its arc and leaf are taken as a wall",
            number((shut - hinge).norm()),
            place((hinge + shut) * 0.5)
        ));
    }
    let ring = Ring::through(plan.walls[outline].clone())?;
    let rim = |ring: &Ring| ring.sides().map(|(a, b)| (b - a).norm()).sum::<f64>();
    let thickest = THICKNESS[1] + 0.005;
    if 2.0 * ring.area() <= thickest * rim(&ring) {
        let thickness = 2.0 * ring.area() / rim(&ring);
        return Some(format!(
            "the outline, wall {outline}, is a band of {:.0} cm: walls are probably drawn as two lines",
            100.0 * thickness
        ));
    }
    let inner = plan.walls.iter().enumerate().filter(|(k, wall)| *k != outline && is_closed(wall));
    let inner = inner.filter_map(|(k, wall)| Some((k, Ring::through(wall.clone())?)));
    let within = inner.filter(|(_, inner)| {
        let between = ring.area() - inner.area();
        inner.area() > 0.5 * ring.area()
            && 2.0 * between <= thickest * (rim(&ring) + rim(inner))
            && inner.corners().first().is_some_and(|corner| ring.contains(*corner))
    });
    if let Some((k, inner)) = within.max_by(|a, b| a.1.area().total_cmp(&b.1.area())) {
        let between = 2.0 * (ring.area() - inner.area()) / (rim(&ring) + rim(&inner));
        return Some(format!(
            "wall {k} lies {:.0} cm inside the outline, wall {outline}: walls are probably drawn as two lines",
            100.0 * between
        ));
    }
    let hull = |corners: Vec<Vec2>| Ring::through(convex_hull(corners)).map_or(0.0, |ring| ring.area());
    let own = hull(ring.corners().to_vec());
    let all = hull(plan.walls.iter().flatten().copied().collect());
    if own < MOST * all {
        return Some(format!(
            "the outline, wall {outline}, lies around {own:.1} m², all walls together around {all:.1} m²: probably a gap \
             in the walls around the room is open"
        ));
    }
    let notes = notes?;
    let is_on = |lines: &[Vec<Vec2>]| {
        let has =
            |line: &[Vec2], at: Vec2| line.iter().any(|corner| (at + plan.origin - corner).norm() <= SNAP);
        let drawn = |(a, b): (Vec2, Vec2)| lines.iter().any(|line| has(line, a) && has(line, b));
        ring.is_upright() && ring.sides().all(drawn)
    };
    if let Some((layer, _)) = notes.iter().find(|(_, lines)| is_on(lines)) {
        return Some(format!(
            "the outline, wall {outline}, is on layer {layer:?}, which has a frame or notes by its name: --walls takes other layers, or \
             this one"
        ));
    }
    frame(plan, &ring)
}

/// A number of at most three digits after the point.
fn number(value: f64) -> String {
    let value = (1e3 * value).round() / 1e3;
    format!("{}", if value == 0.0 { 0.0 } else { value })
}

/// A place, as options have it.
fn place(at: Vec2) -> String {
    format!("{},{}", number(at.x), number(at.y))
}
