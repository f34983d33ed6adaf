//! The walkable area that walls enclose.

use crowd_mechanics::engine::{Vec2, vec2};
use crowd_mechanics::trial::Wall;
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::single::SingleFloatOverlay;
use std::collections::BTreeMap;
use std::fmt::Write;

/// \[m\] of a bounding box around people and walls: more than half of a person's breadth.
pub const MARGIN: f64 = 0.5;
/// \[m\] of a wall that parts the area: walls have no thickness, but a polygon cannot have a line for a wall.
pub const THICKNESS: f64 = 0.02;
/// More open walls than these have their own ends joined, not those of each other.
const MOST_OPEN: usize = 200;
/// \[1/m\] A calculated corner is given to one part in so many of a metre.
const GRAINS: f64 = 1e6;

/// Where people can be.
#[derive(Debug, Clone, PartialEq)]
pub struct Area {
    /// \[m\] a `POLYGON` in well-known text.
    pub wkt: String,
    /// \[m\] the lowest x and y.
    pub low: Vec2,
    /// \[m\] the highest x and y.
    pub high: Vec2,
    /// What it was made of, and what could not be used: sentences for the user.
    pub said: Vec<String>,
}

/// A closed wall, or walls whose ends meet or are joined.
struct Ring {
    /// \[m\] the first stands again at the end.
    corners: Vec<Vec2>,
    /// For messages.
    name: String,
    /// \[m\] the straight lines that close its openings.
    bridges: Vec<(Vec2, Vec2)>,
}

/// An outline and what is not in it.
struct Polygon {
    outer: Ring,
    holes: Vec<Ring>,
}

/// The area of people who were at these positions \[m\], one polygon as PedPy and JuPedSim want it:
///
/// 1. the inside of the smallest closed wall around them all;
/// 2. else the inside of open walls whose ends, the nearest first, straight lines join, if that is around them all;
/// 3. else, where people left such a room, the room and beside each of its openings the convex hull of where they
///    were and a [`MARGIN`];
/// 4. else the bounding box of them and the walls with a [`MARGIN`].
///
/// Without the closed walls in it that nobody was in; open walls in it are taken out with a [`THICKNESS`].
pub fn walkable_area(walls: &[Wall], positions: impl Iterator<Item = Vec2> + Clone) -> Area {
    let Walls { mut rings, open, mut joined } = Walls::new(walls);
    let mut said = Vec::new();
    rings.retain(|ring| {
        let simple = ring.is_simple();
        if !simple {
            said.push(format!("{} crosses itself: it bounds no area", ring.name));
        }
        simple
    });
    // The smallest one first.
    rings.sort_by(|a, b| a.area().total_cmp(&b.area()));
    joined.retain(Ring::is_simple);
    joined.sort_by(|a, b| a.area().total_cmp(&b.area()));
    let around = |ring: &Ring| positions.clone().all(|position| ring.contains(position));
    let closed = rings.iter().position(&around);
    let opened = || joined.iter().position(&around);
    let outer = if let Some(place) = closed {
        let ring = rings.remove(place);
        said.push(format!("walkable area: inside of {}", ring.name));
        ring
    } else if let Some(place) = opened() {
        let ring = joined.remove(place);
        said.push(format!("walkable area: inside of {}", ring.described()));
        ring
    } else if let Some(ring) = with_yards(&rings, &joined, positions.clone(), &mut said) {
        ring
    } else {
        said.push(format!(
            "walkable area: no wall is around everybody: the bounding box of people and walls and {MARGIN} m more \
             (a polygon of your own: --area)"
        ));
        bounding_box(walls.iter().flat_map(|wall| wall.corners.iter().copied()).chain(positions.clone()))
    };
    // From the largest one down, so that what lies in a hole is found too.
    let mut holes: Vec<Ring> = Vec::new();
    for ring in rings.into_iter().rev() {
        if !outer.contains(ring.corners[0]) && !outer.touches(&ring)
            || holes.iter().any(|hole| hole.contains(ring.corners[0]) && !hole.touches(&ring))
            || ring.contains(outer.corners[0])
        {
            continue;
        }
        if positions.clone().any(|position| ring.contains(position)) {
            said.push(format!("{} has people inside and outside: not taken out", ring.name));
        } else if let Some(other) = std::iter::once(&outer).chain(&holes).find(|other| other.touches(&ring)) {
            said.push(format!("{} touches {}: not taken out", ring.name, other.name));
        } else {
            said.push(format!("{} is taken out", ring.name));
            holes.push(ring);
        }
    }
    let mut polygon = Polygon { outer, holes };
    // The walls that are the outline itself, or lie outside of it or in a hole, take nothing away.
    let own: Vec<[[u64; 2]; 2]> = polygon.outer.sides().map(|(a, b)| [bits(a), bits(b)]).collect();
    let is_outline = |a, b| own.contains(&[bits(a), bits(b)]) || own.contains(&[bits(b), bits(a)]);
    let parting: Vec<(Vec2, Vec2)> = open
        .iter()
        .flat_map(|corners| corners.windows(2).map(|side| (side[0], side[1])))
        .filter(|&(a, b)| !is_outline(a, b) && polygon.meets(a, b))
        .collect();
    if !parting.is_empty() {
        match polygon.parted(&parting, positions) {
            Some(parted) => {
                said.push(format!("open walls in it are taken out, {THICKNESS} m thick"));
                polygon = parted;
            }
            None => said.push(
                "open walls in it are not taken out: they part people, and the area must be one polygon \
                 (of your own: --area)"
                    .into(),
            ),
        }
    }
    polygon.area(said)
}

/// The area that a user gives as well-known text, `POLYGON ((x y, …), (hole), …)` in m.
///
/// # Errors
/// It is no such polygon, a ring crosses itself or another one, or somebody was outside of it.
pub fn given_area(wkt: &str, positions: impl Iterator<Item = Vec2>) -> Result<Area, String> {
    let rings = rings_of_wkt(wkt)?;
    let name = |k: usize| if k == 0 { "the outer ring".to_owned() } else { format!("hole {k}") };
    let mut rings = rings.into_iter().enumerate().map(|(k, corners)| Ring {
        corners,
        name: name(k),
        bridges: Vec::new(),
    });
    let outer = rings.next().ok_or("POLYGON has no ring")?;
    let holes: Vec<Ring> = rings.collect();
    for ring in std::iter::once(&outer).chain(&holes) {
        if !ring.is_simple() {
            return Err(format!("{} crosses itself or has no area", ring.name));
        }
    }
    for (k, hole) in holes.iter().enumerate() {
        let before = &holes[..k];
        if !outer.contains(hole.corners[0]) || outer.touches(hole) {
            return Err(format!("{} is not inside of the outer ring", hole.name));
        }
        let meets = |other: &&Ring| {
            other.touches(hole) || other.contains(hole.corners[0]) || hole.contains(other.corners[0])
        };
        if let Some(other) = before.iter().find(meets) {
            return Err(format!("{} meets {}", hole.name, other.name));
        }
    }
    let polygon = Polygon { outer, holes };
    let outside: Vec<Vec2> = positions.filter(|position| !polygon.contains(*position)).collect();
    if let Some(first) = outside.first() {
        let count = outside.len();
        return Err(format!(
            "{count} positions of people are not in it, the first at x = {:?}, y = {:?} m",
            first.x, first.y
        ));
    }
    Ok(polygon.area(vec!["walkable area: the polygon given; walls are not looked at".into()]))
}

/// Rings of `POLYGON ((x y, …), …)`, each closed.
fn rings_of_wkt(wkt: &str) -> Result<Vec<Vec<Vec2>>, String> {
    let text = wkt.trim().trim_start_matches('\u{feff}');
    let keyword = text.get(..7).filter(|word| word.eq_ignore_ascii_case("POLYGON"));
    let inside = keyword.and_then(|_| text[7..].trim().strip_prefix('(')?.strip_suffix(')'));
    let inside = inside.ok_or("is no POLYGON in well-known text, as in POLYGON ((0 0, 4 0, 4 3, 0 0))")?;
    let mut rings = Vec::new();
    let mut rest = inside.trim();
    while !rest.is_empty() {
        let ring = rest.strip_prefix('(').and_then(|rest| rest.split_once(')'));
        let (ring, after) = ring.ok_or("each ring of a POLYGON stands in parentheses of its own")?;
        let corners: Vec<Vec2> = ring.split(',').map(corner_of_wkt).collect::<Result<_, _>>()?;
        match &corners[..] {
            [first, _, _, .., last] if bits(*first) == bits(*last) => rings.push(corners),
            [.., last] => {
                return Err(format!(
                    "the ring that ends at {} {} is not closed: its first corner must stand again at its end",
                    last.x, last.y
                ));
            }
            [] => return Err("a ring has no corner".into()),
        }
        rest = after.trim_start();
        rest = match rest.strip_prefix(',') {
            Some(more) => more.trim_start(),
            None if rest.is_empty() => rest,
            None => return Err("rings of a POLYGON are parted by commas".into()),
        };
    }
    Ok(rings)
}

fn corner_of_wkt(text: &str) -> Result<Vec2, String> {
    let numbers: Option<Vec<f64>> =
        text.split_whitespace().map(|word| word.parse().ok().filter(|x: &f64| x.is_finite())).collect();
    match numbers.as_deref() {
        Some([x, y]) => Ok(vec2(*x, *y)),
        _ => Err(format!("{:?} is no corner: two numbers in m, x and y", text.trim())),
    }
}

/// The rooms that people were in, and beside each opening the convex hull of where they were outside. `None` if
/// nobody was in a room, or if this is not one polygon around everybody.
fn with_yards(
    rings: &[Ring],
    joined: &[Ring],
    positions: impl Iterator<Item = Vec2> + Clone,
    said: &mut Vec<String>,
) -> Option<Ring> {
    let peopled = |ring: &&Ring| positions.clone().any(|position| ring.contains(position));
    let rooms: Vec<&Ring> = joined.iter().filter(peopled).collect();
    let bridges: Vec<(Vec2, Vec2)> = rooms.iter().flat_map(|ring| ring.bridges.iter().copied()).collect();
    if bridges.is_empty() {
        return None;
    }
    let known = || rings.iter().chain(rooms.iter().copied());
    let mut yards: Vec<Vec<Vec2>> = vec![Vec::new(); bridges.len()];
    for p in positions.clone().filter(|p| !known().any(|ring| ring.contains(*p))) {
        let off = |&(a, b): &(Vec2, Vec2)| (p - (a + b) * 0.5).norm_squared();
        let nearest = (0..bridges.len()).min_by(|&a, &b| off(&bridges[a]).total_cmp(&off(&bridges[b])))?;
        yards[nearest].extend(
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| p + vec2(x, y) * MARGIN),
        );
    }
    let mut shapes: Vec<Vec<[f64; 2]>> = rooms.iter().map(|ring| counter_clockwise(&ring.corners)).collect();
    let mut beyond = 0;
    for (mut yard, (a, b)) in yards.into_iter().zip(&bridges) {
        if !yard.is_empty() {
            yard.extend([*a, *b]);
            shapes.push(counter_clockwise(&convex_hull(yard)));
            beyond += 1;
        }
    }
    let nothing: Vec<Vec<[f64; 2]>> = Vec::new();
    let union = shapes.overlay(&nothing, OverlayRule::Subject, FillRule::NonZero);
    let polygon = of_people(union, positions)?;
    let mut all: Vec<String> = rooms.iter().map(|ring| ring.described()).collect();
    let openings = if beyond == 1 { "the opening" } else { "each opening" };
    all.push(format!("beyond {openings} the convex hull of where people were and {MARGIN} m more"));
    said.push(format!("walkable area: inside of {}", all.join("; ")));
    Some(Ring { name: "the outline".into(), ..polygon.outer })
}

/// The one polygon that has everybody in it.
fn of_people(shapes: Vec<Vec<Vec<[f64; 2]>>>, mut positions: impl Iterator<Item = Vec2>) -> Option<Polygon> {
    let ring = |contour: Vec<[f64; 2]>| {
        let whole = |x: f64| libm::round(x * GRAINS) / GRAINS;
        let mut corners: Vec<Vec2> = contour.iter().map(|[x, y]| vec2(whole(*x), whole(*y))).collect();
        corners.extend(corners.first().copied());
        Ring { corners, name: "a hole".into(), bridges: Vec::new() }
    };
    let polygons = shapes.into_iter().filter_map(|shape| {
        let mut rings = shape.into_iter().map(ring);
        Some(Polygon { outer: rings.next()?, holes: rings.collect() })
    });
    let polygons: Vec<Polygon> = polygons.collect();
    let first = positions.next()?;
    let polygon = polygons.into_iter().find(|polygon| polygon.contains(first))?;
    (polygon.outer.is_simple() && positions.all(|p| polygon.contains(p))).then_some(polygon)
}

/// Without the corner that closes it.
fn counter_clockwise(ring: &[Vec2]) -> Vec<[f64; 2]> {
    let mut corners: Vec<[f64; 2]> = ring[..ring.len() - 1].iter().map(|p| [p.x, p.y]).collect();
    let twice: f64 = ring.windows(2).map(|side| turn(ring[0], side[0], side[1])).sum();
    if twice < 0.0 {
        corners.reverse();
    }
    corners
}

/// Closed and counter-clockwise (A. M. Andrew 1979).
fn convex_hull(mut points: Vec<Vec2>) -> Vec<Vec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let half = |points: &mut dyn Iterator<Item = Vec2>| {
        let mut hull: Vec<Vec2> = Vec::new();
        for p in points {
            while let [.., a, b] = hull[..]
                && turn(a, b, p) <= 0.0
            {
                hull.pop();
            }
            hull.push(p);
        }
        hull
    };
    let mut hull = half(&mut points.iter().copied());
    hull.pop();
    hull.extend(half(&mut points.iter().rev().copied()));
    hull
}

impl Polygon {
    fn contains(&self, p: Vec2) -> bool {
        self.outer.contains(p) && !self.holes.iter().any(|hole| hole.contains(p))
    }

    /// Whether part of a line may be in it.
    fn meets(&self, a: Vec2, b: Vec2) -> bool {
        self.contains((a + b) * 0.5) || self.contains(a) || self.contains(b) || {
            let mut rings = std::iter::once(&self.outer).chain(&self.holes);
            rings.any(|ring| ring.sides().any(|(c, d)| touch(a, b, c, d)))
        }
    }

    /// Without walls; `None` if everybody is not in one piece then.
    fn parted(&self, walls: &[(Vec2, Vec2)], positions: impl Iterator<Item = Vec2>) -> Option<Polygon> {
        let rings = std::iter::once(&self.outer).chain(&self.holes);
        let mut subject: Vec<Vec<[f64; 2]>> = rings.map(|ring| counter_clockwise(&ring.corners)).collect();
        subject[1..].iter_mut().for_each(|hole| hole.reverse());
        let strips: Vec<Vec<[f64; 2]>> = walls
            .iter()
            .filter(|(a, b)| a != b)
            .map(|&(a, b)| {
                let along = (b - a) * (0.5 * THICKNESS / (b - a).norm());
                let aside = vec2(-along.y, along.x);
                let (a, b) = (a - along, b + along);
                [a - aside, b - aside, b + aside, a + aside].map(|p| [p.x, p.y]).to_vec()
            })
            .collect();
        of_people(subject.overlay(&strips, OverlayRule::Difference, FillRule::NonZero), positions)
    }

    fn area(&self, said: Vec<String>) -> Area {
        let (low, high) = bounds(self.outer.corners.iter().copied());
        let rings: Vec<String> = std::iter::once(&self.outer).chain(&self.holes).map(Ring::wkt).collect();
        Area { wkt: format!("POLYGON ({})", rings.join(", ")), low, high, said }
    }
}

fn bounds(points: impl Iterator<Item = Vec2>) -> (Vec2, Vec2) {
    let (nowhere, everywhere) =
        (vec2(f64::INFINITY, f64::INFINITY), vec2(f64::NEG_INFINITY, f64::NEG_INFINITY));
    points.fold((nowhere, everywhere), |(low, high), p| {
        (vec2(low.x.min(p.x), low.y.min(p.y)), vec2(high.x.max(p.x), high.y.max(p.y)))
    })
}

fn bounding_box(points: impl Iterator<Item = Vec2>) -> Ring {
    let (low, high) = bounds(points);
    let (low, high) = (low - vec2(MARGIN, MARGIN), high + vec2(MARGIN, MARGIN));
    let corners = vec![low, vec2(high.x, low.y), high, vec2(low.x, high.y), low];
    Ring { corners, name: "the bounding box".into(), bridges: Vec::new() }
}

/// Equal for equal points: the sum turns −0 into 0.
fn bits(point: Vec2) -> [u64; 2] {
    [(point.x + 0.0).to_bits(), (point.y + 0.0).to_bits()]
}

/// Walls sorted by whether they enclose something.
struct Walls {
    /// Closed walls, and those that open walls make where just two ends meet.
    rings: Vec<Ring>,
    /// \[m\] the corners of walls that are in none of these, joined where just two ends meet.
    open: Vec<Vec<Vec2>>,
    /// What they make when straight lines join their ends.
    joined: Vec<Ring>,
}

/// Walls one after the other.
#[derive(Clone)]
struct Chain {
    corners: Vec<Vec2>,
    /// Of the walls.
    ids: Vec<String>,
}

impl Chain {
    fn ends(&self) -> [Vec2; 2] {
        [self.corners[0], self.corners[self.corners.len() - 1]]
    }

    fn turned(mut self) -> Chain {
        self.corners.reverse();
        self.ids.reverse();
        self
    }

    fn name(&self) -> String {
        let ids: Vec<String> = self.ids.iter().map(|id| format!("{id:?}")).collect();
        format!("{} {}", if ids.len() == 1 { "wall" } else { "walls" }, ids.join(", "))
    }
}

impl Walls {
    fn new(walls: &[Wall]) -> Walls {
        let (mut rings, mut pieces) = (Vec::new(), Vec::new());
        for wall in walls {
            let [first, .., last] = &wall.corners[..] else { continue };
            let chain = Chain { corners: wall.corners.clone(), ids: vec![wall.id.clone()] };
            if bits(*first) == bits(*last) {
                rings.push(Ring { name: chain.name(), corners: chain.corners, bridges: Vec::new() });
            } else {
                pieces.push(chain);
            }
        }
        let chains = chained(&pieces);
        let (closed, open): (Vec<Chain>, Vec<Chain>) =
            chains.into_iter().partition(|chain| chain.ends().map(bits)[0] == chain.ends().map(bits)[1]);
        let ring = |chain: Chain| Ring { name: chain.name(), corners: chain.corners, bridges: Vec::new() };
        rings.extend(closed.into_iter().map(ring));
        let joined = joined(&open, walls);
        Walls { rings, open: open.into_iter().map(|chain| chain.corners).collect(), joined }
    }
}

/// Open walls put together where just two ends meet.
fn chained(pieces: &[Chain]) -> Vec<Chain> {
    let mut ends: BTreeMap<[u64; 2], Vec<usize>> = BTreeMap::new();
    for (place, piece) in pieces.iter().enumerate() {
        piece.ends().into_iter().for_each(|end| ends.entry(bits(end)).or_default().push(place));
    }
    let mut used = vec![false; pieces.len()];
    let mut chains = Vec::new();
    for start in 0..pieces.len() {
        if used[start] {
            continue;
        }
        used[start] = true;
        let mut chain = pieces[start].clone();
        // Forwards, then, unless it is closed, from its beginning backwards.
        for _ in 0..2 {
            loop {
                let [first, end] = chain.ends().map(bits);
                let next = match &ends[&end][..] {
                    [a, b] if end != first => [*a, *b].into_iter().find(|place| !used[*place]),
                    _ => None,
                };
                let Some(next) = next else { break };
                used[next] = true;
                let mut piece = pieces[next].clone();
                if bits(piece.ends()[0]) != end {
                    piece = piece.turned();
                }
                chain.corners.extend(&piece.corners[1..]);
                chain.ids.extend(piece.ids);
            }
            let [first, end] = chain.ends().map(bits);
            if first == end {
                break;
            }
            chain = chain.turned();
        }
        chains.push(chain);
    }
    chains
}

/// Rings of open walls: straight lines join their ends, the nearest first, where no wall is in between.
fn joined(chains: &[Chain], walls: &[Wall]) -> Vec<Ring> {
    let end = |k: usize| chains[k / 2].ends()[k % 2];
    let length = |&(a, b): &(usize, usize)| (end(a) - end(b)).norm_squared();
    let own = |k: usize| (2 * k, 2 * k + 1);
    let mut pairs: Vec<(usize, usize)> = if chains.len() <= MOST_OPEN {
        (0..2 * chains.len()).flat_map(|b| (0..b).map(move |a| (a, b))).collect()
    } else {
        (0..chains.len()).map(own).collect()
    };
    // Of a straight wall there is nothing inside.
    pairs.retain(|&(a, b)| a / 2 != b / 2 || chains[a / 2].corners.len() > 2);
    pairs.sort_by(|a, b| length(a).total_cmp(&length(b)));
    let mut partner: Vec<Option<usize>> = vec![None; 2 * chains.len()];
    for (a, b) in pairs {
        if partner[a].is_some() || partner[b].is_some() {
            continue;
        }
        let (from, to) = (end(a), end(b));
        let at = |p: Vec2| bits(p) == bits(from) || bits(p) == bits(to);
        let mut sides = walls.iter().flat_map(|wall| wall.corners.windows(2));
        if !sides.any(|side| !at(side[0]) && !at(side[1]) && touch(from, to, side[0], side[1])) {
            (partner[a], partner[b]) = (Some(b), Some(a));
        }
    }
    let mut used = vec![false; chains.len()];
    let mut rings = Vec::new();
    for start in 0..chains.len() {
        let mut all = Chain { corners: Vec::new(), ids: Vec::new() };
        let (mut bridges, mut at, mut whole) = (Vec::new(), 2 * start, false);
        while !used[at / 2] {
            used[at / 2] = true;
            let chain = chains[at / 2].clone();
            let chain = if at % 2 == 0 { chain } else { chain.turned() };
            all.corners.extend(chain.corners);
            all.ids.extend(chain.ids);
            let out = at ^ 1;
            let Some(next) = partner[out] else { break };
            bridges.push((end(out), end(next)));
            at = next;
            whole = next == 2 * start;
        }
        if whole {
            all.corners.push(all.corners[0]);
            all.corners.dedup();
            rings.push(Ring { name: all.name(), corners: all.corners, bridges });
        }
    }
    rings
}

/// Twice the area \[m²\] of a triangle, positive to the left.
fn turn(a: Vec2, b: Vec2, c: Vec2) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

fn touch(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> bool {
    let on = |p: Vec2, q: Vec2, r: Vec2| {
        turn(p, q, r) == 0.0
            && r.x >= p.x.min(q.x)
            && r.x <= p.x.max(q.x)
            && r.y >= p.y.min(q.y)
            && r.y <= p.y.max(q.y)
    };
    let (c_side, d_side) = (turn(a, b, c), turn(a, b, d));
    let (a_side, b_side) = (turn(c, d, a), turn(c, d, b));
    (c_side * d_side < 0.0 && a_side * b_side < 0.0)
        || on(a, b, c)
        || on(a, b, d)
        || on(c, d, a)
        || on(c, d, b)
}

impl Ring {
    /// With its openings.
    fn described(&self) -> String {
        let widths: Vec<String> =
            self.bridges.iter().map(|(a, b)| format!("{:.3}", (*b - *a).norm())).collect();
        let widths: Vec<&str> =
            widths.iter().map(|text| text.trim_end_matches('0').trim_end_matches('.')).collect();
        let (noun, lines) =
            if widths.len() == 1 { ("opening", "a straight line") } else { ("openings", "straight lines") };
        format!("{}, its {noun} of {} m closed by {lines}", self.name, widths.join(", "))
    }

    fn sides(&self) -> impl Iterator<Item = (Vec2, Vec2)> + Clone {
        self.corners.windows(2).map(|side| (side[0], side[1]))
    }

    /// \[m²\]
    fn area(&self) -> f64 {
        let origin = self.corners[0];
        self.sides().map(|(a, b)| turn(origin, a, b)).sum::<f64>().abs() / 2.0
    }

    /// By how often a ray to the right crosses the ring.
    fn contains(&self, p: Vec2) -> bool {
        let crossed = self.sides().filter(|(a, b)| {
            (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
        });
        crossed.count() % 2 == 1
    }

    fn touches(&self, other: &Ring) -> bool {
        self.sides().any(|(a, b)| other.sides().any(|(c, d)| touch(a, b, c, d)))
    }

    /// Whether it has an area and meets itself nowhere but where one side goes over into the next.
    fn is_simple(&self) -> bool {
        let sides: Vec<_> = self.sides().collect();
        let n = sides.len();
        let meet = |i: usize, j: usize| {
            let ((a, b), (c, d)) = (sides[i], sides[j]);
            if j == i + 1 || (i == 0 && j + 1 == n) {
                // They share a corner; more only if the one turns back on the other.
                let (from, over, to) = if j == i + 1 { (a, b, d) } else { (c, a, b) };
                turn(from, over, to) == 0.0 && (from - over).dot(to - over) > 0.0
            } else {
                touch(a, b, c, d)
            }
        };
        n >= 3 && !(0..n).any(|i| (i + 1..n).any(|j| meet(i, j)))
    }

    /// The text reads back to the same doubles and has no exponents.
    fn wkt(&self) -> String {
        let mut text = String::from("(");
        for (k, corner) in self.corners.iter().enumerate() {
            let comma = if k > 0 { ", " } else { "" };
            let _ = write!(text, "{comma}{} {}", corner.x, corner.y);
        }
        text + ")"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall(id: &str, corners: &[(f64, f64)]) -> Wall {
        let corners = corners.iter().map(|&(x, y)| vec2(x, y)).collect();
        Wall { id: id.into(), material_id: "stone".into(), corners }
    }

    fn square(id: &str, x: f64, y: f64, side: f64) -> Wall {
        wall(id, &[(x, y), (x + side, y), (x + side, y + side), (x, y + side), (x, y)])
    }

    fn area(walls: &[Wall], people: &[(f64, f64)]) -> Area {
        walkable_area(walls, people.iter().map(|&(x, y)| vec2(x, y)))
    }

    #[test]
    fn a_room_with_pillars() {
        let walls = [
            square("pillar", 4.0, 4.0, 1.0),
            square("room", 0.0, 0.0, 10.0),
            square("in it", 4.25, 4.25, 0.5),
        ];
        let area = area(&walls, &[(1.0, 1.0), (9.0, 9.5)]);
        assert_eq!(area.wkt, "POLYGON ((0 0, 10 0, 10 10, 0 10, 0 0), (4 4, 5 4, 5 5, 4 5, 4 4))");
        assert_eq!((area.low, area.high), (vec2(0.0, 0.0), vec2(10.0, 10.0)));
        assert_eq!(area.said, ["walkable area: inside of wall \"room\"", "wall \"pillar\" is taken out"]);
    }

    #[test]
    fn the_smallest_ring_around_everybody() {
        let walls = [
            square("site", -5.0, -5.0, 30.0),
            square("room", 0.0, 0.0, 10.0),
            square("next", 12.0, 0.0, 5.0),
        ];
        assert!(area(&walls, &[(1.0, 1.0)]).wkt.starts_with("POLYGON ((0 0, 10 0, 10 10, 0 10, 0 0))"));
        let both = area(&walls, &[(1.0, 1.0), (13.0, 1.0)]);
        assert_eq!(both.wkt, "POLYGON ((-5 -5, 25 -5, 25 25, -5 25, -5 -5))");
        assert_eq!(both.said.iter().filter(|text| text.contains("people inside and outside")).count(), 2);
    }

    #[test]
    fn open_walls_have_a_box_around_them() {
        let walls = [wall("long", &[(0.0, 0.0), (8.0, 0.0)]), square("pillar", 4.0, 1.0, 1.0)];
        let area = area(&walls, &[(1.0, 2.0), (2.0, 3.5)]);
        // The wall and the pillar are taken out.
        let expected = "POLYGON ((-0.5 4, -0.5 -0.5, 8.5 -0.5, 8.5 4, -0.5 4), \
            (-0.01 -0.01, -0.01 0.01, 8.01 0.01, 8.01 -0.01, -0.01 -0.01), (4 1, 4 2, 5 2, 5 1, 4 1))";
        assert_eq!(area.wkt, expected);
        assert!(area.said[0].contains("bounding box"), "{:?}", area.said);
        assert_eq!(
            self::area(&[], &[(1.0, 2.0)]).wkt,
            "POLYGON ((0.5 1.5, 1.5 1.5, 1.5 2.5, 0.5 2.5, 0.5 1.5))"
        );
    }

    #[test]
    fn walls_whose_ends_meet_are_a_ring() {
        let sides = [
            wall("w", &[(0.0, 3.0), (0.0, 0.0)]),
            wall("s", &[(0.0, 0.0), (4.0, 0.0)]),
            wall("n", &[(0.0, 3.0), (4.0, 3.0)]),
            wall("e", &[(4.0, 3.0), (4.0, 0.0)]),
            wall("open", &[(1.0, 1.0), (2.0, 1.0)]),
        ];
        let area = area(&sides, &[(1.0, 2.0)]);
        assert_eq!(
            area.said,
            [
                "walkable area: inside of walls \"w\", \"s\", \"e\", \"n\"",
                "open walls in it are taken out, 0.02 m thick"
            ]
        );
        assert_eq!(area.wkt.matches("), (").count(), 1, "{}", area.wkt);
        let whole = self::area(&sides[..4], &[(1.0, 2.0)]);
        assert_eq!(whole.wkt, "POLYGON ((0 3, 0 0, 4 0, 4 3, 0 3))");
        let gap = self::area(&sides[..3], &[(1.0, 2.0)]);
        assert!(gap.said[0].ends_with("its opening of 3 m closed by a straight line"), "{:?}", gap.said);
        assert_eq!(inside(&gap, &[(1.0, 2.0), (4.1, 2.0)]), [true, false]);
    }

    #[test]
    fn a_room_with_a_way_out() {
        let room = [(4.0, 2.0), (4.0, 3.0), (0.0, 3.0), (0.0, 0.0), (4.0, 0.0), (4.0, 1.0)];
        let open = area(&[wall("room", &room)], &[(1.0, 2.0)]);
        assert_eq!(open.wkt, "POLYGON ((4 2, 4 3, 0 3, 0 0, 4 0, 4 1, 4 2))");
        let said = "walkable area: inside of wall \"room\", its opening of 1 m closed by a straight line";
        assert_eq!(open.said, [said]);
    }

    /// Whether points are in an area.
    fn inside(area: &Area, points: &[(f64, f64)]) -> Vec<bool> {
        let ring = |corners| Ring { corners, name: String::new(), bridges: Vec::new() };
        let mut rings = rings_of_wkt(&area.wkt).unwrap().into_iter().map(ring);
        let polygon = Polygon { outer: rings.next().unwrap(), holes: rings.collect() };
        points.iter().map(|&(x, y)| polygon.contains(vec2(x, y))).collect()
    }

    #[test]
    fn whoever_left_the_room_does_not_open_its_walls() {
        let room = [(4.0, 2.0), (4.0, 3.0), (0.0, 3.0), (0.0, 0.0), (4.0, 0.0), (4.0, 1.0)];
        let people = [(1.0, 2.0), (3.9, 1.5), (4.6, 1.5), (6.0, 2.5)];
        let area = area(&[wall("room", &room)], &people);
        assert!(area.said[0].contains("beyond the opening the convex hull"), "{:?}", area.said);
        assert_eq!(inside(&area, &people), [true; 4]);
        // Behind the walls, in the walls beside the opening, in the opening itself.
        let points = [(-0.1, 1.0), (2.0, 3.1), (2.0, -0.1), (4.0, 2.1), (4.0, 0.95), (4.0, 1.5), (8.0, 2.5)];
        assert_eq!(inside(&area, &points), [false, false, false, false, false, true, false]);
    }

    #[test]
    fn a_room_of_several_walls_with_two_doors() {
        let walls = [
            wall("south", &[(0.0, 1.0), (0.0, 0.0), (8.0, 0.0), (8.0, 1.0)]),
            wall("north", &[(8.0, 2.0), (8.0, 4.0), (0.0, 4.0), (0.0, 2.2)]),
            wall("screen", &[(5.0, 4.0), (5.0, 1.5)]),
        ];
        let area = area(&walls, &[(1.0, 2.0), (7.0, 1.0)]);
        assert_eq!(
            area.said[0],
            "walkable area: inside of walls \"south\", \"north\", its openings of 1, 1.2 m closed by straight lines"
        );
        let points = [(5.0, 3.0), (5.0, 1.0), (-0.1, 2.0), (7.0, 3.0)];
        assert_eq!(inside(&area, &points), [false, true, false, true]);
        assert_eq!(area.wkt.matches("), (").count(), 0, "the screen stands at the wall: {}", area.wkt);
        // A screen from wall to wall parts people: one polygon cannot say it.
        let through = wall("through", &[(5.0, 4.0), (5.0, 0.0)]);
        let parted = self::area(&[&walls[..2], &[through]].concat(), &[(1.0, 2.0), (7.0, 1.0)]);
        assert!(parted.said.iter().any(|text| text.contains("they part people")), "{:?}", parted.said);
    }

    #[test]
    fn a_polygon_of_the_users_own() {
        let people = || [vec2(1.0, 1.0), vec2(3.0, 1.0)].into_iter();
        let area =
            given_area(" polygon((0 0, 4 0, 4 3, 0 3, 0 0), (2 2, 2.5 2, 2 2.5, 2 2))\n", people()).unwrap();
        assert_eq!(area.wkt, "POLYGON ((0 0, 4 0, 4 3, 0 3, 0 0), (2 2, 2.5 2, 2 2.5, 2 2))");
        assert_eq!((area.low, area.high), (vec2(0.0, 0.0), vec2(4.0, 3.0)));
        for (text, expected) in [
            ("", "no POLYGON"),
            ("POLYGON", "no POLYGON"),
            ("POLYGON ()", "no ring"),
            ("POLYGON EMPTY", "no POLYGON"),
            ("POLYGONE ((0 0, 4 0, 4 3, 0 0))", "no POLYGON"),
            ("POINT (0 0)", "no POLYGON"),
            ("POLYGON ((0 0, 4 0, 4 3))", "is not closed"),
            ("POLYGON ((0 0, 4 0, 4 inf, 0 0))", "\"4 inf\" is no corner"),
            ("POLYGON ((0 0, 4 4, 4 0, 0 4, 0 0))", "the outer ring crosses itself"),
            ("POLYGON ((0 0, 4 0, 4 3, 0 3, 0 0), (5 5, 6 5, 5 6, 5 5))", "hole 1 is not inside"),
            (
                "POLYGON ((0 0, 2 0, 2 3, 0 3, 0 0))",
                "1 positions of people are not in it, the first at x = 3.0",
            ),
            ("POLYGON ((0 0, 4 0, 4 3, 0 3, 0 0) (2 2, 3 2, 2 3, 2 2))", "parted by commas"),
            ("POLYGON ((0 0, é", "no POLYGON"),
        ] {
            let said = given_area(text, people()).unwrap_err();
            assert!(said.contains(expected), "{text}: {said}");
        }
    }

    #[test]
    fn what_is_no_valid_hole_stays() {
        let room = square("room", 0.0, 0.0, 10.0);
        let bow = wall("bow", &[(1.0, 1.0), (3.0, 3.0), (3.0, 1.0), (1.0, 3.0), (1.0, 1.0)]);
        let thin = wall("thin", &[(5.0, 1.0), (7.0, 1.0), (5.0, 1.0)]);
        let walls = [room, bow, thin, square("niche", 0.0, 5.0, 1.0), square("through", 9.0, 5.0, 3.0)];
        let area = area(&walls, &[(5.0, 5.0)]);
        assert_eq!(area.wkt, "POLYGON ((0 0, 10 0, 10 10, 0 10, 0 0))");
        for text in
            ["\"bow\" crosses itself", "\"thin\" crosses itself", "\"niche\" touches", "\"through\" touches"]
        {
            assert!(area.said.iter().any(|said| said.contains(text)), "{text}: {:?}", area.said);
        }
    }
}
