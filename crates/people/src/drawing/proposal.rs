//! Proposals and questions for an architect's plan.
//!
//! [`FloorPlan::of`](super::FloorPlan::of) takes the rims of what walls [enclose](super::enclosing) as walls; [`Proposal`] says what it
//! would take, and asks.

use super::Drawing;
use super::bands::THICKNESS;
use super::enclosing::{Enclosing, FEW, Taken, WIDEST_DOOR, has_areas, seen, take};
use super::gap::{Gap, Leads, number, place};
use super::join::WIDEST_GAP;
use super::sort::{Flight, Layer, Sort, Sorted};
use crate::Door;
use crate::error::{IS_FRAME, Result};
use lemons_core::message::{Message, message};
use lemons_core::plane::overlay;
use lemons_core::plane::{Bounds, Ring, Vec2, segments_touch};

/// More of a kind are only counted.
const MOST_SAID: usize = 100;
/// \[m\] Walls of a room are further away from a frame around it.
const FRAME: f64 = 1.0;

/// Meaning that a plan seems to have.
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
    /// Questions where something is not clear.
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

    pub(super) fn from(
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
    pub(super) fn is_frame(&self, rim: &Ring) -> bool {
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
        asked.extend(rim.first().filter(|rim| self.is_frame(rim)).map(|rim| about_frame(rim).text));
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
    pub fn messages(&self) -> Vec<(&'static str, String)> {
        let mut messages = Vec::new();
        for layer in self.layers.iter().take(MOST_SAID) {
            messages.push(("layer", self.layer(layer)));
        }
        if !self.ground.is_empty() {
            let all = Bounds::of(self.ground.iter().flatten().copied()).unwrap_or(Bounds::UNIT);
            let [x, y] = <[f64; 2]>::from(all.size()).map(number);
            messages.push((
                "outline",
                format!("{x} m x {y} m from {}, {:.3} m² within walls", place(all.low), self.areas[0]),
            ));
            messages.push(("ground", format!("{:.3} m² without obstacles", self.areas[1])));
        }
        for (thickness, length) in self.thicknesses.iter().take(5) {
            messages.push((
                "wall of two lines",
                format!("{} cm thick, {length:.1} m of it", number(100.0 * thickness)),
            ));
        }
        if !self.open.is_empty() {
            let length: f64 = self.open.iter().map(|[a, b]| (b - a).norm()).sum();
            messages.push(("walls of one line", format!("{length:.1} m of it stand in the ground")));
        }
        for (layer, count, area) in &self.obstacles {
            messages.push(("obstacles", format!("{count} on layer {layer:?}, {area:.3} m²")));
        }
        if let Some(close) = self.close {
            let largest = self.closed.iter().copied().fold(0.0, f64::max);
            messages.push((
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
            messages.push((gap.kind(), gap.described().text));
        }
        messages.extend(self.questions.iter().map(|question| ("question", question.clone())));
        messages
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

/// Returns whether a rim is an upright rectangle that no other wall is near.
pub(super) fn is_alone(rim: &Ring, mut walls: impl Iterator<Item = [Vec2; 2]>) -> bool {
    let far = |at: &Vec2| rim.nearest(*at).distance;
    rim.is_upright()
        && walls.all(|ends| {
            let crosses = || rim.sides().any(|(a, b)| segments_touch(a, b, ends[0], ends[1]));
            let (near, away) = (|end| far(end) <= THICKNESS[1], |end| far(end) > FRAME);
            ends.iter().all(near) || (ends.iter().all(away) && !crosses())
        })
}

pub(super) fn about_frame(frame: &Ring) -> Message {
    let size = frame.bounds().size();
    message!(IS_FRAME, width = number(size.x), height = number(size.y))
}
