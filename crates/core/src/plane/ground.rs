//! Ground: polygons that meet, united, without obstacles. Numbers in files are rounded, so sides that are drawn as one are
//! some way apart, and a slit between two areas is a wall.

use super::overlay::{Contour, Polygons, contour, parted};
use super::simple::first_beside;
use super::{Bounds, InPlane, Polygon, Ring, Vec2, nearest_on_segment, segments_cross, sides_that_meet};
use std::collections::HashMap;

/// \[m\] Corners nearer than this are one, and a side goes through them.
const SAME: f64 = 1e-5;
/// \[m\] Slits between obstacles, and between them and a rim, that are no ground.
const SLIT: f64 = 1e-3;
/// \[m\] How far what fills a slit goes into both sides.
const LAP: f64 = 1e-4;
/// Cosine of the largest angle between sides of a slit: 15°.
const ALONG: f64 = 0.966;
/// \[m\] A corner nearer to the line between its neighbours is none.
const STRAIGHT: f64 = 1e-6;
/// \[m²\] Smaller areas are left out.
const SMALLEST: f64 = 1e-6;
/// Rounds in which sides get corners: each may bring others near.
const ROUNDS: usize = 4;
/// How many more places may be where sides cross, with what fills slits: it crosses what it is between, four times.
const OF_SLITS: usize = 5;

/// Returns what is in any of the areas and in none of the obstacles. Holes of a polygon may overlap, and are no part of
/// it. Areas that are at most `gap` \[m\] apart along their sides are one; ground that is narrower everywhere is left out.
/// No ring touches itself. `None` if sides cross at more than `most` places, so many corners lie on sides of others, or so
/// many slits are filled, or what fills them crosses others five times as often: this is counted before polygons are united.
pub fn ground(areas: &[Polygon], obstacles: &[Polygon], gap: f64, most: usize) -> Option<Vec<Polygon>> {
    let united = united_polygons(areas, gap, most)?;
    let taken = united_polygons(obstacles, SLIT, most)?;
    let mut rims = rims_of(&united);
    let of_ground = rims.len();
    rims.extend(rims_of(&taken));
    let left = if taken.is_empty() {
        united
    } else {
        snap(&mut rims, most)?;
        let (ground, taken) = rims.split_at(of_ground);
        let slits = slits(ground, Some(taken), SLIT, most)?;
        let taken: Vec<Contour> = contours(taken).into_iter().chain(slits).collect();
        few_cross(&[contours(ground), taken.clone()].concat(), OF_SLITS * most)?;
        parted(&contours(ground), &taken)
    };
    Some(left.iter().filter_map(|contours| tidied(contours, gap)).collect())
}

/// Returns the parts of a ring that touches itself, or goes back along a side of its own. `None` if it crosses itself, or
/// more than `most` corners lie on its sides.
pub fn parts(ring: &Ring, most: usize) -> Option<Vec<Polygon>> {
    let mut rims = vec![Rim::new(ring, true, 0)];
    snap(&mut rims, most)?;
    let left: Vec<Polygon> =
        parted(&contours(&rims), &[]).iter().filter_map(|contours| tidied(contours, 0.0)).collect();
    // Where it crosses itself, what goes round in one direction counts against the rest.
    let area: f64 = left.iter().map(Polygon::area).sum();
    ((area - ring.area()).abs() <= SAME * ring.bounds().size().sum()).then_some(left)
}

/// A ring, the inside of the polygon to its left.
struct Rim {
    /// The first one is not repeated.
    corners: Vec<Vec2>,
    /// The polygon that it belongs to.
    of: usize,
}

impl Rim {
    fn new(ring: &Ring, left: bool, of: usize) -> Rim {
        let mut corners = ring.corners().to_vec();
        if (ring.signed_area() > 0.0) != left {
            corners.reverse();
        }
        Rim { corners, of }
    }

    fn sides(&self) -> impl Iterator<Item = (Vec2, Vec2)> {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().copied().zip(next.copied())
    }
}

fn contours(rims: &[Rim]) -> Vec<Contour> {
    rims.iter().map(|rim| rim.corners.iter().map(|corner| [corner.x, corner.y]).collect()).collect()
}

fn rims_of(polygons: &[Vec<Contour>]) -> Vec<Rim> {
    let rim = |of: usize, place: usize, contour: &Contour| {
        super::overlay::ring(contour).map(|ring| Rim::new(&ring, place == 0, of))
    };
    let of_polygon = |(of, contours): (usize, &Vec<Contour>)| {
        contours.iter().enumerate().filter_map(|(place, contour)| rim(of, place, contour)).collect::<Vec<_>>()
    };
    polygons.iter().enumerate().flat_map(of_polygon).collect()
}

/// Returns the union of polygons.
fn united_polygons(polygons: &[Polygon], gap: f64, most: usize) -> Option<Polygons> {
    let mut parts = Vec::new();
    for polygon in polygons {
        if holes_are_apart(polygon) {
            parts.push(polygon.rings().map(contour).collect());
        } else {
            // Where holes overlap, no direction of theirs counts right.
            let bare = |ring: &Ring| Polygon { outer: ring.clone(), holes: Vec::new() };
            let holes: Vec<Polygon> = polygon.holes.iter().map(bare).collect();
            let left = ground(&[bare(&polygon.outer)], &holes, gap, most)?;
            parts.extend(left.iter().map(|polygon| polygon.rings().map(contour).collect::<Vec<_>>()));
        }
    }
    let mut rims = rims_of(&parts);
    snap(&mut rims, most)?;
    let slits = slits(&rims, None, gap, most)?;
    let all: Vec<Contour> = contours(&rims).into_iter().chain(slits).collect();
    few_cross(&all, OF_SLITS * most)?;
    Some(parted(&all, &[]))
}

fn holes_are_apart(polygon: &Polygon) -> bool {
    if polygon.holes.is_empty() {
        return true;
    }
    let rings: Vec<Ring> = polygon.rings().cloned().collect();
    let inside = |(k, hole): (usize, &Ring)| {
        let corner = hole.corners()[0];
        let others = polygon.holes.iter().enumerate().filter(|(other, _)| *other != k);
        polygon.outer.contains(corner) && !others.into_iter().any(|(_, other)| other.contains(corner))
    };
    sides_that_meet(&rings).is_none() && polygon.holes.iter().enumerate().all(inside)
}

/// Puts corners at one place that are nearer to each other than [`SAME`], and gives each side the corners on it: what is
/// drawn as one side is one then, bit by bit. `None` if these are more than `most`, or more sides cross then.
fn snap(rims: &mut [Rim], most: usize) -> Option<()> {
    let mut places: HashMap<(i64, i64), Vec<Vec2>> = HashMap::new();
    let cell = |at: Vec2| ((at.x / SAME).floor() as i64, (at.y / SAME).floor() as i64);
    for corner in rims.iter_mut().flat_map(|rim| &mut rim.corners) {
        let (x, y) = cell(*corner);
        let cells = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (x + dx, y + dy)));
        let near = cells.filter_map(|cell| places.get(&cell)).flatten();
        let near = near.copied().find(|place| (place - *corner).norm() <= SAME);
        match near {
            Some(place) => *corner = place,
            None => places.entry((x, y)).or_default().push(*corner),
        }
    }
    let mut places: Vec<Vec2> = places.into_values().flatten().collect();
    let Some(bounds) = Bounds::of(places.iter().copied()) else { return Some(()) };
    let along = bounds.longer();
    places
        .sort_by(|a, b| along(*a).total_cmp(&along(*b)).then(a.x.total_cmp(&b.x)).then(a.y.total_cmp(&b.y)));
    let mut inserted = 0;
    for _ in 0..ROUNDS {
        let last = inserted;
        for rim in rims.iter_mut() {
            let mut corners = Vec::with_capacity(rim.corners.len());
            for (a, b) in rim.sides() {
                corners.push(a);
                let (low, high) = (along(a).min(along(b)) - SAME, along(a).max(along(b)) + SAME);
                let from = places.partition_point(|place| along(*place) < low);
                let near = places[from..].iter().take_while(|place| along(**place) <= high);
                let is_on = |place: &&Vec2| {
                    let place = **place;
                    place != a && place != b && (place - nearest_on_segment(a, b, place)).norm() <= SAME
                };
                let before = corners.len();
                corners.extend(near.filter(is_on));
                corners[before..].sort_by(|p, q| (p - a).norm_squared().total_cmp(&(q - a).norm_squared()));
                inserted += corners.len() - before;
                if inserted > most {
                    return None;
                }
            }
            rim.corners = corners;
        }
        if inserted == last {
            break;
        }
    }
    for rim in rims.iter_mut() {
        rim.corners.dedup();
        while rim.corners.len() > 1 && rim.corners.first() == rim.corners.last() {
            rim.corners.pop();
        }
    }
    few_cross(&contours(rims), most)
}

/// `None` if sides cross at more than `most` places.
fn few_cross(contours: &[Contour], most: usize) -> Option<()> {
    let rings = contours.iter().filter_map(super::overlay::ring);
    let sides: Vec<(Vec2, Vec2)> = rings.flat_map(|ring| ring.sides().collect::<Vec<_>>()).collect();
    let mut crossings = 0;
    let are_too_many = |i: usize, j: usize| {
        let ((a, b), (c, d)) = (sides[i], sides[j]);
        crossings += usize::from(segments_cross(a, b, c, d));
        crossings > most
    };
    first_beside(&sides, are_too_many).is_none().then_some(())
}

/// A side, and the polygon that it belongs to.
type Side = (Vec2, Vec2, usize);

/// Returns what is between sides that go along each other, at most `gap` apart: of two polygons of one list, where they
/// face each other; or of a polygon and one within it.
fn slits(one: &[Rim], other: Option<&[Rim]>, gap: f64, most: usize) -> Option<Vec<Contour>> {
    let sides = |rims: &[Rim]| -> Vec<Side> {
        rims.iter().flat_map(|rim| rim.sides().map(|(a, b)| (a, b, rim.of))).collect()
    };
    let (of_one, mut others) = (sides(one), sides(other.unwrap_or(one)));
    let Some(bounds) = Bounds::of(of_one.iter().map(|side| side.0)) else { return Some(Vec::new()) };
    let along = bounds.longer();
    let low = |side: &Side| along(side.0).min(along(side.1));
    let high = |side: &Side| along(side.0).max(along(side.1));
    others.sort_by(|a, b| low(a).total_cmp(&low(b)));
    let longest = others.iter().map(|side| high(side) - low(side)).fold(0.0, f64::max);
    let mut all = Vec::new();
    for side in &of_one {
        let from = others.partition_point(|other| low(other) < low(side) - gap - longest);
        let near = others[from..].iter().take_while(|other| low(other) <= high(side) + gap);
        for beside in near.filter(|other| high(other) >= low(side) - gap) {
            let facing = other.is_none();
            if !(facing && beside.2 == side.2) {
                all.extend(slit(side, beside, facing, gap));
            }
        }
        if all.len() > most {
            return None;
        }
    }
    Some(all)
}

fn slit(&(a, b, _): &Side, &(c, d, _): &Side, facing: bool, gap: f64) -> Option<Contour> {
    let (u, v) = ((b - a).unit(0.0)?, (d - c).unit(0.0)?);
    let cosine = u.dot(&v);
    if (if facing { -cosine } else { cosine }) < ALONG {
        return None;
    }
    let n = u.left();
    let own = |p: Vec2| ((p - a).dot(&u), (p - a).dot(&n));
    let ((c_along, c_off), (d_along, d_off)) = (own(c), own(d));
    let slope = (d_off - c_off) / (d_along - c_along);
    let off = |along: f64| c_off + (along - c_along) * slope;
    let mut from = c_along.min(d_along).max(0.0);
    let mut to = c_along.max(d_along).min((b - a).norm());
    if slope != 0.0 {
        let ends = [-gap, gap].map(|limit| c_along + (limit - c_off) / slope);
        from = from.max(ends[0].min(ends[1]));
        to = to.min(ends[0].max(ends[1]));
    }
    let (first, last) = (off(from), off(to));
    let is_slit = to - from > SAME && (0.5 * SAME..=gap * 1.001).contains(&first.abs().max(last.abs()));
    let at = |along: f64, off: f64| (a + u * along + n * off).into();
    is_slit.then(|| {
        vec![
            at(from, first.min(0.0) - LAP),
            at(to, last.min(0.0) - LAP),
            at(to, last.max(0.0) + LAP),
            at(from, first.max(0.0) + LAP),
        ]
    })
}

/// The polygon of a rim and its holes without corners that rounding made; none if it is nowhere wider than `least`.
fn tidied(contours: &[Contour], least: f64) -> Option<Polygon> {
    let mut rings = contours.iter().map(|contour| {
        let ring = Ring::through(without_straight(contour.iter().map(|at| Vec2::from(*at)).collect()))?;
        (ring.corners().len() > 2).then_some(ring)
    });
    let width = |ring: &Ring| 2.0 * ring.area() / ring.sides().map(|(a, b)| (b - a).norm()).sum::<f64>();
    let outer = rings.next()?.filter(|ring| ring.area() >= SMALLEST && width(ring) > least)?;
    let holes = rings.flatten().filter(|ring| ring.area() >= SMALLEST && width(ring) > LAP).collect();
    Some(Polygon { outer, holes })
}

fn without_straight(mut corners: Vec<Vec2>) -> Vec<Vec2> {
    loop {
        let before = corners.len();
        let mut kept: Vec<Vec2> = Vec::with_capacity(before);
        for k in 0..before {
            let next =
                if k + 1 < before { corners[k + 1] } else { kept.first().copied().unwrap_or(corners[0]) };
            let last = kept.last().copied().unwrap_or(corners[before - 1]);
            if (corners[k] - nearest_on_segment(last, next, corners[k])).norm() > STRAIGHT {
                kept.push(corners[k]);
            }
        }
        corners = kept;
        if corners.len() == before || corners.len() < 3 {
            return corners;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::{rotation, segments_touch, vec2};
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    const MOST: usize = 20_000;

    /// A rectangle, turned about the origin, shifted, and its coordinates rounded to whole steps.
    fn rectangle([x0, y0, x1, y1]: [f64; 4], angle: f64, shift: Vec2, step: f64) -> Polygon {
        let corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| {
            let at = rotation(angle) * vec2(x, y) + shift;
            if step > 0.0 { at.map(|x| (x / step).round() * step) } else { at }
        });
        Polygon { outer: Ring::through(corners.to_vec()).unwrap(), holes: Vec::new() }
    }

    fn area(polygons: &[Polygon]) -> f64 {
        polygons.iter().map(Polygon::area).sum()
    }

    fn are_simple(polygons: &[Polygon]) -> bool {
        polygons.iter().flat_map(Polygon::rings).all(Ring::is_simple)
    }

    fn is_free(polygons: &[Polygon], a: Vec2, b: Vec2) -> bool {
        let mut sides = polygons.iter().flat_map(Polygon::rings).flat_map(Ring::sides);
        !sides.any(|(c, d)| segments_touch(a, b, c, d))
    }

    fn bare(corners: &[[f64; 2]]) -> Polygon {
        let corners = corners.iter().map(|at| Vec2::from(*at)).collect();
        Polygon { outer: Ring::through(corners).unwrap(), holes: Vec::new() }
    }

    #[test]
    fn overlapping_holes_count_once() {
        let hole = |low: f64, high: f64| bare(&[[low, low], [high, low], [high, high], [low, high]]).outer;
        let with_holes =
            |holes| Polygon { holes, ..rectangle([0.0, 0.0, 10.0, 6.0], 0.0, Vec2::zeros(), 0.0) };
        // In either direction; holes that touch, that lie in each other, and one beyond the rim.
        for (holes, expected) in [
            (vec![hole(1.0, 3.0), hole(2.0, 4.0)], 60.0 - 7.0),
            (vec![hole(1.0, 3.0), hole(2.0, 4.0).reversed()], 60.0 - 7.0),
            (vec![hole(1.0, 4.0), hole(2.0, 3.0)], 60.0 - 9.0),
            (vec![hole(1.0, 2.0), hole(2.0, 3.0)], 60.0 - 2.0),
            (vec![hole(-1.0, 2.0)], 60.0 - 4.0),
            (vec![hole(1.0, 2.0), hole(4.0, 5.0)], 60.0 - 2.0),
        ] {
            let left = ground(&[with_holes(holes)], &[], 0.015, MOST).unwrap();
            assert!((area(&left) - expected).abs() < 1e-6 && are_simple(&left), "{} {expected}", area(&left));
        }
        // What another area covers is no hole.
        let all = [with_holes(vec![hole(1.0, 3.0)]), bare(&[[0.5, 0.5], [2.0, 0.5], [2.0, 3.5], [0.5, 3.5]])];
        assert!((area(&ground(&all, &[], 0.015, MOST).unwrap()) - 58.0).abs() < 1e-6);
    }

    #[test]
    fn rings_that_touch_themselves_have_parts_and_those_that_cross_none() {
        for (corners, expected) in [
            // A repeated corner, a spike, two squares at a corner, a hole that a bridge leads to; a bow.
            (&[[0.0, 0.0], [4.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]][..], Some((1, 12.0))),
            (&[[0.0, 0.0], [4.0, 0.0], [6.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]], Some((1, 12.0))),
            (
                &[
                    [0.0, 0.0],
                    [1.0, 0.0],
                    [1.0, 1.0],
                    [2.0, 1.0],
                    [2.0, 2.0],
                    [1.0, 2.0],
                    [1.0, 1.0],
                    [0.0, 1.0],
                ],
                Some((2, 2.0)),
            ),
            (
                &[
                    [0.0, 0.0],
                    [4.0, 0.0],
                    [4.0, 3.0],
                    [0.0, 3.0],
                    [0.0, 0.0],
                    [1.0, 1.0],
                    [1.0, 2.0],
                    [2.0, 2.0],
                    [2.0, 1.0],
                    [1.0, 1.0],
                ],
                Some((1, 11.0)),
            ),
            (&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]], None),
            (&[[0.0, 0.0], [2.0, 2.0], [3.0, 0.0], [0.0, 2.0]], None),
        ] {
            let found = parts(&bare(corners).outer, MOST);
            let found = found.map(|parts| (parts.len(), (1e6 * area(&parts)).round() / 1e6));
            assert_eq!(found, expected, "{corners:?}");
        }
    }

    #[test]
    fn areas_that_meet_in_a_corner_or_not_at_all_are_apart() {
        let square = |x: f64, y: f64| bare(&[[x, y], [x + 2.0, y], [x + 2.0, y + 2.0], [x, y + 2.0]]);
        for (x, y, number) in
            [(2.0, 2.0, 2), (2.02, 0.0, 2), (2.014, 0.0, 1), (2.0, 1.0, 1), (2.001, -2.0, 2)]
        {
            let left = ground(&[square(0.0, 0.0), square(x, y)], &[], 0.015, MOST).unwrap();
            assert_eq!((left.len(), are_simple(&left)), (number, true), "{x} {y}");
        }
    }

    #[test]
    fn what_makes_too_many_corners_is_refused() {
        let same: Vec<Polygon> = (0..200)
            .map(|k| rectangle([0.0, 1e-4 * f64::from(k), 9.0, 5.0], 0.3, Vec2::zeros(), 0.0))
            .collect();
        assert_eq!(ground(&same, &[], 0.015, MOST), None);
        assert!((area(&ground(&same[..50], &[], 0.015, MOST).unwrap()) - 45.0).abs() < 1e-3);
        // 30 bars across 30 others have 900 places where they cross.
        let bar = |k: u32| {
            let at = f64::from(k / 2);
            let sides =
                if k.is_multiple_of(2) { [at, -1.0, at + 0.5, 31.0] } else { [-1.0, at, 31.0, at + 0.5] };
            rectangle(sides, 0.3, Vec2::zeros(), 0.0)
        };
        let bars: Vec<Polygon> = (0..60).map(bar).collect();
        let lying = |count: u32| (0..count).map(|k| bar(2 * k + 1)).collect::<Vec<_>>();
        let crossed = ground(&bars, &[], 0.015, MOST).unwrap();
        let expected = 2.0 * 30.0 * 0.5 * 32.0 - 900.0 * 0.25;
        assert!((area(&crossed) - expected).abs() < 1e-6, "{}", area(&crossed));
        // Each has four pairs of sides that cross: one more is too many.
        assert!(ground(&bars, &[], 0.015, 3600).is_some());
        assert_eq!(ground(&bars, &[], 0.015, 3599), None);
        // Obstacles across an area, too: its two long sides cross those of 30.
        assert!(ground(&bars[..1], &lying(30), 0.015, 120).is_some());
        assert_eq!(ground(&bars[..1], &lying(30), 0.015, 119), None);
        // 10 rooms on each other beside 10 others: what fills the 200 slits lies over each other.
        let stacked = |k: u32| {
            let off = 5e-5 * f64::from(k / 2);
            let sides = match k % 2 {
                0 => [-off, off, 5.0 - off, 5.0 + off],
                _ => [5.001 + off, 0.01 + off, 10.0 + off, 5.01 + off],
            };
            rectangle(sides, 0.1, Vec2::zeros(), 0.0)
        };
        let stacked: Vec<Polygon> = (0..20).map(stacked).collect();
        assert!(ground(&stacked[..2], &[], 0.015, MOST).is_some());
        assert_eq!(ground(&stacked, &[], 0.015, 400), None);
        // Two combs across each other, of 2400 teeth each, are 23 million: nothing of them is made.
        let tooth = |k: u32| {
            [[0.0, 0.0], [0.2, 2400.0], [0.4, 2400.0], [0.6, 0.0]].map(|[x, y]| [x + f64::from(k), y])
        };
        let upright: Vec<[f64; 2]> = (0..2400).flat_map(tooth).chain([[2400.0, -1.0], [0.0, -1.0]]).collect();
        let turned: Vec<[f64; 2]> = upright.iter().map(|[x, y]| [*y, *x]).collect();
        assert_eq!(ground(&[bare(&upright), bare(&turned)], &[], 0.015, MOST), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 600, rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]

        /// Two rooms with a passage: turned, far from the origin, rounded as files have them, a hair apart or over each
        /// other. People see through, and the area is that of all three.
        #[test]
        fn rooms_with_a_passage_are_one_at_any_angle(
            angle in 0.0..7.0f64, far in 0..4u32, step in 0..4usize, hair in -0.004..0.004f64,
            from in 0.1..2.0f64, width in 0.5..2.5f64, scale in 0.3..30.0f64,
        ) {
            let shift = vec2(10f64.powi(far as i32 * 2) - 1.0, -0.7 * 10f64.powi(far as i32 * 2));
            let step = [0.0, 1e-6, 1e-3, 0.005][step];
            let hair = if step > 1e-3 { 0.2 * hair } else { hair };
            let place = |sides: [f64; 4]| rectangle(sides.map(|x| x * scale), angle, shift, step);
            let hair = hair / scale;
            let rooms = [
                place([0.0, 0.0, 6.0, 5.0]),
                place([6.0 + hair, from, 9.0, from + width]),
                place([9.0 - hair, -1.0, 14.0, 5.5]),
            ];
            let left = ground(&rooms, &[], 0.015, MOST).unwrap();
            let expected = (30.0 + 3.0 * width + 5.0 * 6.5) * scale * scale;
            let rounding = (0.004 + 1.5 * step) * 45.0 * scale + 1e-6;
            prop_assert!(left.len() == 1 && left[0].holes.is_empty(), "{} parts, {} holes", left.len(), left[0].holes.len());
            prop_assert!((area(&left) - expected).abs() < rounding, "{} {expected}", area(&left));
            prop_assert!(are_simple(&left));
            let at = |x: f64, y: f64| rotation(angle) * (vec2(x, y) * scale) + shift;
            for side in [0.1, 0.9] {
                let y = from + side * width;
                prop_assert!(is_free(&left, at(5.0, y), at(10.0, y)), "the passage is shut");
            }
        }

        /// Obstacles beside each other in a row, each on a random part of the last one's side, in a room: none of them has
        /// ground inside, and the area is the room's less theirs.
        #[test]
        fn obstacles_that_touch_are_all_taken_off(
            angle in 0.0..7.0f64,
            sizes in prop::collection::vec((0.3..3.0f64, 0.3..3.0f64, -0.9..0.9f64, 0..4usize), 1..6),
            step in 0..3usize, in_room in any::<bool>(),
        ) {
            let step = [0.0, 1e-9, 1e-6][step];
            let room = rectangle([-20.0, -20.0, 20.0, 20.0], if in_room { angle } else { 0.0 }, Vec2::zeros(), 0.0);
            let mut boxes: Vec<[f64; 4]> = vec![[-20.0, -1.0, -18.0, 1.0]];
            for (w, h, along, _) in sizes {
                let [_, y0, x1, y1] = boxes[boxes.len() - 1];
                let from = 0.5 * (y0 + y1 - h) + along * 0.5 * (y1 - y0 + h);
                boxes.push([x1, from, x1 + w, from + h]);
            }
            let mut obstacles: Vec<Polygon> =
                boxes.iter().map(|sides| rectangle(*sides, angle, Vec2::zeros(), step)).collect();
            // The first one stands at the wall of a room that is turned with them.
            if !in_room {
                obstacles.remove(0);
                boxes.remove(0);
            }
            let left = ground(&[room], &obstacles, 0.015, MOST).unwrap();
            let taken: f64 = boxes.iter().map(|[x0, y0, x1, y1]| (x1 - x0) * (y1 - y0)).sum();
            prop_assert!((area(&left) - (1600.0 - taken)).abs() < 0.01, "{} {}", area(&left), 1600.0 - taken);
            prop_assert!(are_simple(&left) && left.len() == 1, "{left:?}");
            for [x0, y0, x1, y1] in boxes {
                for k in 0..100 {
                    let (u, v) = (f64::from(k % 10) / 9.0, f64::from(k / 10) / 9.0);
                    let inner = |a: f64, b: f64, share: f64| a + 1e-3 + share * (b - a - 2e-3);
                    let at = rotation(angle) * vec2(inner(x0, x1, u), inner(y0, y1, v));
                    prop_assert!(!left.iter().any(|polygon| polygon.contains(at)), "ground at {at:?}");
                }
            }
        }

        /// Rectangles at any angle, over each other: by points all over the plane.
        #[test]
        fn points_are_in_ground_as_they_are_in_areas_and_not_in_obstacles(
            places in prop::collection::vec((-4.0..4.0f64, -4.0..4.0f64, 0.5..3.0f64, 0.5..3.0f64, 0.0..3.2f64, any::<bool>()), 2..10),
        ) {
            let (mut areas, mut obstacles) = (vec![rectangle([-3.0, -3.0, 3.0, 3.0], 0.0, Vec2::zeros(), 0.0)], Vec::new());
            for (x, y, w, h, angle, is_area) in places {
                let sides = [-w, -h, w, h];
                let list = if is_area { &mut areas } else { &mut obstacles };
                list.push(rectangle(sides, angle, vec2(x, y), 0.0));
            }
            let left = ground(&areas, &obstacles, 0.0, MOST).unwrap();
            prop_assert!(are_simple(&left));
            let mut wrong = 0;
            for k in 0..2500 {
                let at = vec2(f64::from(k % 50) * 0.3 - 7.4321, f64::from(k / 50) * 0.3 - 7.4567);
                let within = |all: &[Polygon]| all.iter().any(|polygon| polygon.contains(at));
                let near = areas.iter().chain(&obstacles).any(|polygon| polygon.outer.nearest(at).distance < 0.02);
                wrong += usize::from(!near && within(&left) != (within(&areas) && !within(&obstacles)));
            }
            prop_assert_eq!(wrong, 0);
        }
    }
}
