//! The walkable area that walls enclose.

use crowd_mechanics::engine::{Vec2, vec2};
use crowd_mechanics::trial::Wall;
use std::collections::BTreeMap;
use std::fmt::Write;

/// \[m\] of a bounding box around people and walls: more than half of a person's breadth.
pub const MARGIN: f64 = 0.5;

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

/// A closed wall, or walls whose ends meet.
struct Ring {
    /// \[m\] the first stands again at the end.
    corners: Vec<Vec2>,
    /// For messages.
    name: String,
}

/// The area of people who were at these positions \[m\]: inside of the smallest closed wall around them all, else the
/// inside of an open wall whose ends a straight line joins, if that is around them all; else the bounding box of them
/// and the walls with a [`MARGIN`]. Without the closed walls in it that nobody was in.
///
/// Walls have no thickness: an open one takes nothing away.
pub fn walkable_area(walls: &[Wall], positions: impl Iterator<Item = Vec2> + Clone) -> Area {
    let (mut rings, mut open) = rings(walls);
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
    let around = |ring: &Ring| positions.clone().all(|position| ring.contains(position));
    let closed = rings.iter().position(&around);
    let joined = || open.iter().position(|ring| ring.is_simple() && around(ring));
    let outer = if let Some(place) = closed {
        let ring = rings.remove(place);
        said.push(format!("walkable area: inside of {}", ring.name));
        ring
    } else if let Some(place) = joined() {
        let ring = open.remove(place);
        said.push(format!("walkable area: inside of {}, its ends joined by a straight line", ring.name));
        ring
    } else {
        said.push(format!(
            "walkable area: no wall is around everybody: the bounding box of people and walls and {MARGIN} m more"
        ));
        bounding_box(walls.iter().flat_map(|wall| wall.corners.iter().copied()).chain(positions.clone()))
    };
    if !open.is_empty() {
        let noun = if open.len() == 1 { "wall has" } else { "walls have" };
        said.push(format!("{} open {noun} no area: not taken out", open.len()));
    }
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
    let (low, high) = bounds(outer.corners.iter().copied());
    let rings: Vec<String> = std::iter::once(&outer).chain(&holes).map(Ring::wkt).collect();
    Area { wkt: format!("POLYGON ({})", rings.join(", ")), low, high, said }
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
    Ring { corners, name: "the bounding box".into() }
}

/// Equal for equal points: the sum turns −0 into 0.
fn bits(point: Vec2) -> [u64; 2] {
    [(point.x + 0.0).to_bits(), (point.y + 0.0).to_bits()]
}

/// Closed walls and those that open walls make where just two ends meet; then the walls that are in none, their ends
/// joined.
fn rings(walls: &[Wall]) -> (Vec<Ring>, Vec<Ring>) {
    let (mut rings, mut open) = (Vec::new(), Vec::new());
    for wall in walls {
        let [first, .., last] = &wall.corners[..] else { continue };
        if bits(*first) == bits(*last) {
            rings.push(Ring { corners: wall.corners.clone(), name: format!("wall {:?}", wall.id) });
        } else {
            open.push((wall, bits(*first), bits(*last)));
        }
    }
    let mut ends: BTreeMap<[u64; 2], Vec<usize>> = BTreeMap::new();
    for (place, (_, first, last)) in open.iter().enumerate() {
        ends.entry(*first).or_default().push(place);
        ends.entry(*last).or_default().push(place);
    }
    let mut used = vec![false; open.len()];
    let mut alone = Vec::new();
    for start in 0..open.len() {
        if used[start] {
            continue;
        }
        let (wall, first, mut end) = open[start];
        let (mut chain, mut corners) = (vec![start], wall.corners.clone());
        used[start] = true;
        while end != first {
            let next = match &ends[&end][..] {
                [a, b] => [*a, *b].into_iter().find(|place| !used[*place]),
                _ => None,
            };
            let Some(next) = next else { break };
            used[next] = true;
            chain.push(next);
            let (wall, one, other) = open[next];
            let mut more = wall.corners.clone();
            if one != end {
                more.reverse();
            }
            end = if one == end { other } else { one };
            corners.extend(&more[1..]);
        }
        if end == first && ends[&first].len() == 2 {
            let ids: Vec<String> = chain.iter().map(|&place| format!("{:?}", open[place].0.id)).collect();
            rings.push(Ring { corners, name: format!("walls {}", ids.join(", ")) });
        } else {
            alone.extend(chain.iter().map(|&place| {
                let wall = open[place].0;
                let mut corners = wall.corners.clone();
                corners.push(corners[0]);
                Ring { corners, name: format!("wall {:?}", wall.id) }
            }));
        }
    }
    (rings, alone)
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
        let expected = "POLYGON ((-0.5 -0.5, 8.5 -0.5, 8.5 4, -0.5 4, -0.5 -0.5), (4 1, 5 1, 5 2, 4 2, 4 1))";
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
        assert_eq!(area.wkt, "POLYGON ((0 3, 0 0, 4 0, 4 3, 0 3))");
        assert_eq!(
            area.said,
            [
                "walkable area: inside of walls \"w\", \"s\", \"e\", \"n\"",
                "1 open wall has no area: not taken out"
            ]
        );
        let gap = self::area(&sides[..3], &[(1.0, 2.0)]);
        assert!(gap.said[0].contains("bounding box"), "{:?}", gap.said);
    }

    #[test]
    fn a_room_with_a_way_out() {
        let room = [(4.0, 2.0), (4.0, 3.0), (0.0, 3.0), (0.0, 0.0), (4.0, 0.0), (4.0, 1.0)];
        let open = area(&[wall("room", &room)], &[(1.0, 2.0)]);
        assert_eq!(open.wkt, "POLYGON ((4 2, 4 3, 0 3, 0 0, 4 0, 4 1, 4 2))");
        assert_eq!(open.said, ["walkable area: inside of wall \"room\", its ends joined by a straight line"]);
        let outside = area(&[wall("room", &room)], &[(1.0, 2.0), (4.5, 1.5)]);
        assert!(outside.wkt.starts_with("POLYGON ((-0.5 -0.5, 5 -0.5,"), "{}", outside.wkt);
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
