//! Filled parts of a path of several parts: rims and holes.

use crate::error::{Result, require};
use lemons_core::plane::overlay::{self, Contour, InsideRule, contour};
use lemons_core::plane::{Ring, Vec2, sides_that_meet};

/// Largest number of corners of all paths of several parts: some of it takes the square of this.
const MOST_OF_PARTS: usize = 10_000;

/// Says which parts of a path are holes of which: the rim of what is filled. Holes follow what they are in. `looked_at` is
/// the number of corners of all such paths.
pub(super) fn parts_of(
    lines: Vec<(Vec<Vec2>, bool)>,
    even_odd: bool,
    looked_at: &mut usize,
) -> Result<Vec<(Vec<Vec2>, bool, bool)>> {
    let (closed, open): (Vec<_>, Vec<_>) =
        lines.into_iter().partition(|(corners, closed)| *closed && corners.len() > 2);
    let rings: Vec<Ring> = closed.into_iter().filter_map(|(corners, _)| Ring::through(corners)).collect();
    let mut parts: Vec<(Vec<Vec2>, bool, bool)> = Vec::new();
    if rings.len() < 2 {
        parts.extend(rings.iter().map(|ring| (ring.corners().to_vec(), true, false)));
    } else {
        *looked_at += rings.iter().map(|ring| ring.corners().len()).sum::<usize>();
        require(*looked_at <= MOST_OF_PARTS, || {
            format!(
                "paths of several parts have {looked_at} corners so far; at most {MOST_OF_PARTS} are allowed"
            )
        })?;
        let drawn = if sides_that_meet(&rings).is_none() { rims(&rings, even_odd) } else { None };
        let crossed = || {
            let fill = if even_odd { InsideRule::EvenOdd } else { InsideRule::NonZero };
            let contours: Vec<Contour> = rings.iter().map(contour).collect();
            let left = overlay::difference(&contours, &[], fill);
            left.iter().map(|rings| rings.iter().filter_map(overlay::ring).collect()).collect()
        };
        let polygons: Vec<Vec<Ring>> = drawn.unwrap_or_else(crossed);
        let all = polygons.iter().flat_map(|rings| rings.iter().enumerate());
        parts.extend(all.map(|(place, ring)| (ring.corners().to_vec(), true, place > 0)));
    }
    parts.extend(open.into_iter().map(|(corners, closed)| (corners, closed, false)));
    Ok(parts)
}

/// The rims of what is filled, of rings that meet nowhere: each with its holes.
fn rims(rings: &[Ring], even_odd: bool) -> Option<Vec<Vec<Ring>>> {
    let sign = |ring: &Ring| if even_odd || ring.signed_area() > 0.0 { 1 } else { -1 };
    let filled = |winding: i32| if even_odd { winding % 2 != 0 } else { winding != 0 };
    let around: Vec<Vec<usize>> = (0..rings.len())
        .map(|k| {
            let corner = rings[k].corners()[0];
            (0..rings.len()).filter(|&other| other != k && rings[other].contains(corner)).collect()
        })
        .collect();
    let signs: Vec<i32> = rings.iter().map(sign).collect();
    // Whether it is filled outside, and inside.
    let sides = |(k, around): (usize, &Vec<usize>)| {
        let winding = around.iter().map(|&other| signs[other]).sum::<i32>();
        [filled(winding), filled(winding + signs[k])]
    };
    let sides: Vec<[bool; 2]> = around.iter().enumerate().map(sides).collect();
    let is_rim = |k: usize| sides[k] == [false, true];
    let mut polygons: Vec<Option<Vec<Ring>>> =
        (0..rings.len()).map(|k| is_rim(k).then(|| vec![rings[k].clone()])).collect();
    for hole in (0..rings.len()).filter(|&k| sides[k] == [true, false]) {
        // The innermost rim around it is in the most others.
        let of = around[hole].iter().copied().filter(|&k| is_rim(k)).max_by_key(|&k| around[k].len())?;
        polygons[of].as_mut()?.push(rings[hole].clone());
    }
    Some(polygons.into_iter().flatten().collect())
}
