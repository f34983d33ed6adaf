//! The walkable area that walls enclose.

use crate::measure::VoronoiRoom;
use crate::outlines::{Outline, outlines};
use crate::shapes::check;
use lemons_core::plane::overlay::{Contour, InsideRule, Polygons, contour, difference, ring, union};
use lemons_core::plane::{
    Bounds, Polygon, Ring, Vec2, convex_hull, nearest_on_line, polygon_from_wkt, segments_touch, vec2,
};
use lemons_core::trial::Wall;

/// \[m\] Distance of a bounding box from people and walls: more than half of a person's breadth.
pub const MARGIN: f64 = 0.5;
/// \[m\] Thickness that a wall inside the area gets: a polygon cannot have a line for a wall.
pub const THICKNESS: f64 = 0.02;
/// \[m\] A head that is so near to a wall is not beyond it: people lean over barriers.
pub const LEANING: f64 = 0.5;
/// \[1/m\] A calculated corner is given to one part in so many of a metre.
const GRAINS: f64 = 1e6;

/// The area where people can be.
#[derive(Debug, Clone, PartialEq)]
pub struct Area {
    /// \[m\] The area.
    pub polygon: Polygon,
    /// Messages: of what the area was made, and what could not be used.
    pub messages: Vec<String>,
    /// Whether it is the bounding box of walls and people, as no wall is around everybody.
    pub boxed: bool,
}

/// Returns the area of people who were at these positions \[m\]. PedPy and JuPedSim want one polygon. It is the first of
/// these that is around all positions:
///
/// 1. the inside of the smallest closed wall;
/// 2. the inside of open walls whose ends are joined by straight lines, the nearest ends first;
/// 3. such a room, and beside each of its openings the convex hull of the positions outside and a [`MARGIN`];
/// 4. the bounding box of positions and walls, with a [`MARGIN`].
///
/// Closed walls inside that nobody was in are holes. Open walls inside are taken out with a [`THICKNESS`].
pub fn walkable_area(walls: &[Wall], positions: impl Iterator<Item = Vec2> + Clone) -> Area {
    let (mut outlines, open) = outlines(walls);
    let crossing = outlines.extract_if(.., |outline| !outline.ring.is_simple());
    let crossing = crossing.filter(|outline| outline.bridges.is_empty());
    let mut messages: Vec<String> =
        crossing.map(|outline| format!("{} crosses itself: it bounds no area", outline.name)).collect();
    // Those without openings first, of these the smallest one.
    let opens = |outline: &Outline| !outline.bridges.is_empty();
    outlines.sort_by(|a, b| opens(a).cmp(&opens(b)).then(a.ring.area().total_cmp(&b.ring.area())));
    let around = |outline: &Outline| positions.clone().all(|position| outline.ring.contains(position));
    let mut boxed = false;
    let outer = if let Some(place) = outlines.iter().position(around) {
        messages.push(format!("walkable area: inside of {}", outlines[place].described()));
        outlines.remove(place)
    } else if let Some(outline) = with_outside(&outlines, positions.clone(), &mut messages) {
        outline
    } else {
        boxed = true;
        messages.push(format!(
            "walkable area: no wall is around everybody: the bounding box of people and walls and {MARGIN} m more \
             (a polygon of your own: --area)"
        ));
        bounding_box(walls.iter().flat_map(|wall| wall.corners.iter().copied()).chain(positions.clone()))
    };
    // From the largest one down, so that what lies in a hole is found too.
    let mut holes: Vec<Outline> = Vec::new();
    for outline in outlines.into_iter().filter(|outline| !opens(outline)).rev() {
        let (ring, corner) = (&outline.ring, outline.ring.corners()[0]);
        if !outer.ring.contains(corner) && !outer.ring.touches(ring)
            || holes.iter().any(|hole| hole.ring.contains(corner) && !hole.ring.touches(ring))
            || ring.contains(outer.ring.corners()[0])
        {
            continue;
        }
        if positions.clone().any(|position| ring.contains(position)) {
            messages.push(format!("{} has people inside and outside: not taken out", outline.name));
        } else if let Some(other) =
            std::iter::once(&outer).chain(&holes).find(|other| other.ring.touches(ring))
        {
            messages.push(format!("{} touches {}: not taken out", outline.name, other.name));
        } else {
            messages.push(format!("{} is taken out", outline.name));
            holes.push(outline);
        }
    }
    let holes = holes.into_iter().map(|hole| hole.ring).collect();
    let mut polygon = Polygon { outer: outer.ring, holes };
    // The walls that are the outline itself, or lie outside of it or in a hole, take nothing away.
    let own: Vec<(Vec2, Vec2)> = polygon.outer.sides().collect();
    let is_outline = |a, b| own.contains(&(a, b)) || own.contains(&(b, a));
    let parting = open.into_iter().filter(|&(a, b)| !is_outline(a, b) && meets(&polygon, a, b));
    let parting: Vec<(Vec2, Vec2)> = parting.collect();
    if !parting.is_empty() {
        match parted(&polygon, &parting, positions) {
            Some(parted) => {
                messages.push(format!("open walls in it are taken out, {THICKNESS} m thick"));
                polygon = parted;
            }
            None => messages.push(
                "open walls in it are not taken out: they part people, and the area must be one polygon \
                 (of your own: --area)"
                    .into(),
            ),
        }
    }
    Area { polygon, messages, boxed }
}

/// Returns the area of people whose heads were measured at these positions \[m\]: the [`walkable_area`] of all but those who
/// lean over a wall. `None` if walls are around some of the others only: then no wall would hold anybody back.
pub fn measured_area(walls: &[Wall], positions: &[Vec2]) -> Option<Area> {
    let (known, _) = outlines(walls);
    let is_inside = |p: &Vec2| known.iter().any(|outline| outline.ring.contains(*p));
    let leans = |p: &Vec2| {
        !is_inside(p) && walls.iter().any(|wall| nearest_on_line(&wall.corners, *p).distance <= LEANING)
    };
    let upright: Vec<Vec2> = positions.iter().copied().filter(|p| !leans(p)).collect();
    let area = walkable_area(walls, upright.iter().copied());
    (!area.boxed || !upright.iter().any(is_inside)).then_some(area)
}

/// Returns the area that a user gives as well-known text, `POLYGON ((x y, …), (hole), …)` in m.
///
/// # Errors
/// The text is not such a polygon, a ring crosses itself or another one, or a position \[m\] is outside.
pub fn given_area(wkt: &str, positions: impl Iterator<Item = Vec2>) -> Result<Area, String> {
    let polygon = polygon_from_wkt(wkt)?;
    let name = |k: usize| if k == 0 { "the outer ring".to_owned() } else { format!("hole {k}") };
    for (k, ring) in polygon.rings().enumerate() {
        check(ring).map_err(|what| format!("{} {what}", name(k)))?;
    }
    let Polygon { outer, holes } = &polygon;
    for (k, hole) in holes.iter().enumerate() {
        let corner = hole.corners()[0];
        if !outer.contains(corner) || outer.touches(hole) {
            return Err(format!("{} is not inside of the outer ring", name(k + 1)));
        }
        let meets =
            |other: &Ring| other.touches(hole) || other.contains(corner) || hole.contains(other.corners()[0]);
        if let Some(other) = holes[..k].iter().position(meets) {
            return Err(format!("{} meets {}", name(k + 1), name(other + 1)));
        }
    }
    let outside: Vec<Vec2> = positions.filter(|position| !polygon.contains(*position)).collect();
    if let Some(first) = outside.first() {
        let count = outside.len();
        return Err(format!(
            "{count} positions of people are not in it, the first at x = {:?}, y = {:?} m",
            first.x, first.y
        ));
    }
    let messages = vec!["walkable area: the polygon given; walls are not looked at".into()];
    Ok(Area { polygon, messages, boxed: false })
}

/// Returns the same of people whose heads were measured: those who lean over its rim may be outside.
///
/// # Errors
/// As [`given_area`].
pub fn given_area_of_heads(wkt: &str, positions: &[Vec2]) -> Result<Area, String> {
    let room = VoronoiRoom::of(&polygon_from_wkt(wkt)?);
    let leans = |off: f64| off > 0.0 && off <= LEANING;
    given_area(wkt, positions.iter().copied().filter(|p| !leans(room.nearest(*p).1)))
}

/// Returns the rooms that people were in, and beside each opening the convex hull of where they were outside. `None` if
/// nobody was in a room, or if this is not one polygon around everybody.
fn with_outside(
    outlines: &[Outline],
    positions: impl Iterator<Item = Vec2> + Clone,
    messages: &mut Vec<String>,
) -> Option<Outline> {
    let peopled = |room: &&Outline| positions.clone().any(|position| room.ring.contains(position));
    let (joined, rings): (Vec<&Outline>, Vec<&Outline>) =
        outlines.iter().partition(|outline| !outline.bridges.is_empty());
    let rooms: Vec<&Outline> = joined.into_iter().filter(peopled).collect();
    let bridges: Vec<(Vec2, Vec2)> = rooms.iter().flat_map(|room| room.bridges.iter().copied()).collect();
    let known = || rings.iter().chain(&rooms);
    let mut beyond: Vec<Vec<Vec2>> = vec![Vec::new(); bridges.len()];
    for p in positions.clone().filter(|p| !known().any(|outline| outline.ring.contains(*p))) {
        let off = |&(a, b): &(Vec2, Vec2)| (p - (a + b) * 0.5).norm_squared();
        let nearest = (0..bridges.len()).min_by(|&a, &b| off(&bridges[a]).total_cmp(&off(&bridges[b])))?;
        beyond[nearest].extend(Ring::around(Bounds { low: p, high: p }.grown(MARGIN)).corners());
    }
    let hulls = beyond.into_iter().zip(&bridges).filter(|(places, _)| !places.is_empty());
    let hulls = hulls.map(|(mut places, (a, b))| {
        places.extend([*a, *b]);
        convex_hull(places).iter().map(|p| [p.x, p.y]).collect()
    });
    let mut shapes: Vec<Contour> = hulls.collect();
    let openings = if shapes.len() == 1 { "the opening" } else { "each opening" };
    shapes.splice(..0, rooms.iter().map(|room| counter_clockwise(&room.ring)));
    let polygon = of_people(union(&shapes), positions)?;
    let mut all: Vec<String> = rooms.iter().map(|room| room.described()).collect();
    all.push(format!("beyond {openings} the convex hull of where people were and {MARGIN} m more"));
    messages.push(format!("walkable area: inside of {}", all.join("; ")));
    Some(Outline::new("the outline", polygon.outer))
}

/// Returns the one polygon that has everybody in it.
fn of_people(polygons: Polygons, mut positions: impl Iterator<Item = Vec2>) -> Option<Polygon> {
    let rounded = |contour: Contour| {
        let whole = |x: f64| libm::round(x * GRAINS) / GRAINS;
        ring(&contour.iter().map(|point| point.map(whole)).collect())
    };
    let polygons = polygons.into_iter().filter_map(|polygon| {
        let mut rings = polygon.into_iter().filter_map(rounded);
        Some(Polygon { outer: rings.next()?, holes: rings.collect() })
    });
    let polygons: Vec<Polygon> = polygons.collect();
    let first = positions.next()?;
    let polygon = polygons.into_iter().find(|polygon| polygon.contains(first))?;
    (polygon.outer.is_simple() && positions.all(|p| polygon.contains(p))).then_some(polygon)
}

/// Returns a contour as the rule `NonZero` wants it.
fn counter_clockwise(ring: &Ring) -> Contour {
    let mut corners = contour(ring);
    if ring.signed_area() < 0.0 {
        corners.reverse();
    }
    corners
}

/// Returns whether part of a line may be in a polygon.
fn meets(polygon: &Polygon, a: Vec2, b: Vec2) -> bool {
    let touches = |ring: &Ring| ring.sides().any(|(c, d)| segments_touch(a, b, c, d));
    [(a + b) * 0.5, a, b].into_iter().any(|p| polygon.contains(p)) || polygon.rings().any(touches)
}

/// Returns a polygon without walls; `None` if everybody is not in one piece then.
fn parted(
    polygon: &Polygon,
    walls: &[(Vec2, Vec2)],
    positions: impl Iterator<Item = Vec2>,
) -> Option<Polygon> {
    let mut subject: Vec<Contour> = polygon.rings().map(counter_clockwise).collect();
    subject[1..].iter_mut().for_each(|hole| hole.reverse());
    let strip = |&(a, b): &(Vec2, Vec2)| {
        let along = (b - a) * (0.5 * THICKNESS / (b - a).norm());
        let aside = vec2(-along.y, along.x);
        let (a, b) = (a - along, b + along);
        [a - aside, b - aside, b + aside, a + aside].map(|p| [p.x, p.y]).to_vec()
    };
    let strips: Vec<Contour> = walls.iter().filter(|(a, b)| a != b).map(strip).collect();
    of_people(difference(&subject, &strips, InsideRule::NonZero), positions)
}

fn bounding_box(points: impl Iterator<Item = Vec2>) -> Outline {
    let nothing = Bounds { low: Vec2::zeros(), high: Vec2::zeros() };
    Outline::new("the bounding box", Ring::around(Bounds::of(points).unwrap_or(nothing).grown(MARGIN)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall(id: &str, corners: &[(f64, f64)]) -> Wall {
        let corners = corners.iter().map(|&(x, y)| vec2(x, y)).collect();
        Wall::new(id, "stone", corners)
    }

    fn square(id: &str, x: f64, y: f64, side: f64) -> Wall {
        wall(id, &[(x, y), (x + side, y), (x + side, y + side), (x, y + side), (x, y)])
    }

    fn area(walls: &[Wall], people: &[(f64, f64)]) -> Area {
        walkable_area(walls, people.iter().map(|&(x, y)| vec2(x, y)))
    }

    #[test]
    fn closed_walls_are_rooms_and_pillars() {
        let room = || square("room", 0.0, 0.0, 10.0);
        let pillars = [square("pillar", 4.0, 4.0, 1.0), room(), square("in it", 4.25, 4.25, 0.5)];
        let three = || [square("site", -5.0, -5.0, 30.0), room(), square("next", 12.0, 0.0, 5.0)];
        let bow = wall("bow", &[(1.0, 1.0), (3.0, 3.0), (3.0, 1.0), (1.0, 3.0), (1.0, 1.0)]);
        let thin = wall("thin", &[(5.0, 1.0), (7.0, 1.0), (5.0, 1.0)]);
        let odd = [room(), bow, thin, square("niche", 0.0, 5.0, 1.0), square("through", 9.0, 5.0, 3.0)];
        let whole = "POLYGON ((0 0, 10 0, 10 10, 0 10, 0 0))";
        for (walls, people, polygon, messages) in [
            (
                &pillars[..],
                &[(1.0, 1.0), (9.0, 9.5)][..],
                "POLYGON ((0 0, 10 0, 10 10, 0 10, 0 0), (4 4, 5 4, 5 5, 4 5, 4 4))",
                &["walkable area: inside of wall \"room\"", "wall \"pillar\" is taken out"][..],
            ),
            // The smallest one around everybody.
            (&three(), &[(1.0, 1.0)], whole, &["inside of wall \"room\""]),
            (
                &three(),
                &[(1.0, 1.0), (13.0, 1.0)],
                "POLYGON ((-5 -5, 25 -5, 25 25, -5 25, -5 -5))",
                &["\"room\" has people inside and outside", "\"next\" has people inside and outside"],
            ),
            // What is no valid hole stays.
            (
                &odd,
                &[(5.0, 5.0)],
                whole,
                &[
                    "\"bow\" crosses itself",
                    "\"thin\" crosses itself",
                    "\"niche\" touches",
                    "\"through\" touches",
                ],
            ),
            (
                &[],
                &[(1.0, 2.0)],
                "POLYGON ((0.5 1.5, 1.5 1.5, 1.5 2.5, 0.5 2.5, 0.5 1.5))",
                &["bounding box"],
            ),
            // The wall and the pillar are taken out.
            (
                &[wall("long", &[(0.0, 0.0), (8.0, 0.0)]), square("pillar", 4.0, 1.0, 1.0)],
                &[(1.0, 2.0), (2.0, 3.5)],
                "POLYGON ((-0.5 4, -0.5 -0.5, 8.5 -0.5, 8.5 4, -0.5 4), (-0.01 -0.01, -0.01 0.01, 8.01 0.01, \
                 8.01 -0.01, -0.01 -0.01), (4 1, 4 2, 5 2, 5 1, 4 1))",
                &["bounding box"],
            ),
        ] {
            let area = area(walls, people);
            assert_eq!(area.polygon.to_wkt(), polygon);
            for text in messages {
                assert!(
                    area.messages.iter().any(|message| message.contains(text)),
                    "{text}: {:?}",
                    area.messages
                );
            }
        }
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
            area.messages,
            [
                "walkable area: inside of walls \"w\", \"s\", \"e\", \"n\"",
                "open walls in it are taken out, 0.02 m thick"
            ]
        );
        assert_eq!(area.polygon.to_wkt().matches("), (").count(), 1, "{}", area.polygon.to_wkt());
        let whole = self::area(&sides[..4], &[(1.0, 2.0)]);
        assert_eq!(whole.polygon.to_wkt(), "POLYGON ((0 3, 0 0, 4 0, 4 3, 0 3))");
        let gap = self::area(&sides[..3], &[(1.0, 2.0)]);
        assert!(
            gap.messages[0].ends_with("its opening of 3 m closed by a straight line"),
            "{:?}",
            gap.messages
        );
        assert_eq!(inside(&gap, &[(1.0, 2.0), (4.1, 2.0)]), [true, false]);
    }

    /// Returns whether points are in an area.
    fn inside(area: &Area, points: &[(f64, f64)]) -> Vec<bool> {
        points.iter().map(|&(x, y)| area.polygon.contains(vec2(x, y))).collect()
    }

    #[test]
    fn whoever_left_the_room_does_not_open_its_walls() {
        let room = [(4.0, 2.0), (4.0, 3.0), (0.0, 3.0), (0.0, 0.0), (4.0, 0.0), (4.0, 1.0)];
        let people = [(1.0, 2.0), (3.9, 1.5), (4.6, 1.5), (6.0, 2.5)];
        let area = area(&[wall("room", &room)], &people);
        assert!(area.messages[0].contains("beyond the opening the convex hull"), "{:?}", area.messages);
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
            area.messages[0],
            "walkable area: inside of walls \"south\", \"north\", its openings of 1, 1.2 m closed by straight lines"
        );
        let points = [(5.0, 3.0), (5.0, 1.0), (-0.1, 2.0), (7.0, 3.0)];
        assert_eq!(inside(&area, &points), [false, true, false, true]);
        assert_eq!(
            area.polygon.to_wkt().matches("), (").count(),
            0,
            "the screen stands at the wall: {}",
            area.polygon.to_wkt()
        );
        // A screen from wall to wall parts people: one polygon cannot say it.
        let through = wall("through", &[(5.0, 4.0), (5.0, 0.0)]);
        let parted = self::area(&[&walls[..2], &[through]].concat(), &[(1.0, 2.0), (7.0, 1.0)]);
        assert!(
            parted.messages.iter().any(|text| text.contains("they part people")),
            "{:?}",
            parted.messages
        );
    }

    #[test]
    fn a_polygon_of_the_users_own() {
        let people = || [vec2(1.0, 1.0), vec2(3.0, 1.0)].into_iter();
        let area =
            given_area(" polygon((0 0, 4 0, 4 3, 0 3, 0 0), (2 2, 2.5 2, 2 2.5, 2 2))\n", people()).unwrap();
        assert_eq!(area.polygon.to_wkt(), "POLYGON ((0 0, 4 0, 4 3, 0 3, 0 0), (2 2, 2.5 2, 2 2.5, 2 2))");
        for (text, expected) in [
            ("POLYGONE ((0 0, 4 0, 4 3, 0 0))", "is not a POLYGON"),
            ("POLYGON ((0 0, 4 0, 1e300 3, 0 0))", "the outer ring has a corner further than 1e6 m"),
            ("POLYGON ((0 0, 4 4, 4 0, 0 4, 0 0))", "the outer ring crosses itself"),
            ("POLYGON ((0 0, 4 0, 4 3, 0 3, 0 0), (5 5, 6 5, 5 6, 5 5))", "hole 1 is not inside"),
            (
                "POLYGON ((0 0, 2 0, 2 3, 0 3, 0 0))",
                "1 positions of people are not in it, the first at x = 3.0",
            ),
        ] {
            let message = given_area(text, people()).unwrap_err();
            assert!(message.contains(expected), "{text}: {message}");
        }
    }
}
