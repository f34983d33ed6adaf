//! An outline as disks: bodies of any shape for the mechanics, with a stated error.

use crate::error::{Result, require};
use lemons_core::plane::{Bounds, Disk, Moments, Ring, Vec2, union, vec2};
use std::f64::consts::TAU;

/// Most disks of a body.
pub const MOST_COVERING: usize = 50;
/// \[m\] Disks of so similar places are level.
const LEVEL: f64 = 1e-3;
/// About how many places inside are looked at.
const PLACES: f64 = 3000.0;
/// Places on a circle, and on the outline for each of its hundredths, at which distances are measured.
const ON_CIRCLE: usize = 180;
const HUNDREDTHS: usize = 400;

/// Disks in place of an outline.
#[derive(Debug, Clone, PartialEq)]
pub struct Cover {
    /// The disks. Two that are opposite, left and right of the gaze along x, are the first and the last one, if there are
    /// such: bodies look across the line from the first to the last disk.
    pub disks: Vec<Disk>,
    /// Whether there are, or a single disk.
    pub opposite: bool,
    /// \[m²\] Area of the outline, and of the union of the disks.
    pub areas: [f64; 2],
    /// \[m\] Largest distance of the outline from the disks, where they do not reach it.
    pub gap: f64,
    /// \[m\] Largest distance of the disks from the outline, where they reach beyond it.
    pub beyond: f64,
}

/// Covers a closed outline by so many disks: each time the inscribed disk that covers most of what no disk covers; at last
/// all grow by half of the largest gap. Fewer are returned if nothing is left.
///
/// # Errors
/// The number is not 1 to [`MOST_COVERING`], or the outline has no inside.
pub fn cover(outline: &Ring, count: usize) -> Result<Cover> {
    require((1..=MOST_COVERING).contains(&count), || format!("{count} disks: must be 1 to {MOST_COVERING}"))?;
    let inscribed = inscribed(outline);
    require(!inscribed.is_empty(), || "the outline has no inside".to_owned())?;
    let mut uncovered: Vec<Vec2> = inscribed.iter().map(|disk| disk.centre).collect();
    let mut disks: Vec<Disk> = Vec::new();
    while disks.len() < count && !uncovered.is_empty() {
        let covers = |disk: &Disk| {
            let near = |place: &&Vec2| (**place - disk.centre).norm_squared() <= disk.radius * disk.radius;
            uncovered.iter().filter(near).count()
        };
        // Of several that cover as much, the first one.
        let best = inscribed.iter().rev().max_by_key(|disk| covers(disk)).copied();
        let Some(best) = best else { break };
        uncovered.retain(|place| (*place - best.centre).norm() > best.radius);
        disks.push(best);
    }
    let grown = 0.5 * gap(outline, &disks);
    disks.iter_mut().for_each(|disk| disk.radius += grown);
    let (disks, opposite) = with_opposite_at_ends(disks);
    let Moments { area, .. } = union(&disks);
    let (gap, beyond) = (gap(outline, &disks), beyond(outline, &disks));
    Ok(Cover { areas: [outline.area(), area], gap, beyond, disks, opposite })
}

/// Puts the two disks that are furthest apart across the gaze, level along it, first and last. Returns whether there are
/// such, or a single disk.
fn with_opposite_at_ends(disks: Vec<Disk>) -> (Vec<Disk>, bool) {
    let pairs = (0..disks.len()).flat_map(|left| (0..disks.len()).map(move |right| [left, right]));
    let across = |[left, right]: [usize; 2]| disks[left].centre.y - disks[right].centre.y;
    let level = |pair: &[usize; 2]| (disks[pair[0]].centre.x - disks[pair[1]].centre.x).abs() < LEVEL;
    let widest = pairs.filter(level).max_by(|a, b| across(*a).total_cmp(&across(*b)));
    let Some(ends) = widest.filter(|pair| across(*pair) > LEVEL) else {
        let single = disks.len() == 1;
        return (disks, single);
    };
    let between = disks.iter().enumerate().filter(|(place, _)| !ends.contains(place)).map(|(_, disk)| *disk);
    let ordered = std::iter::once(disks[ends[0]]).chain(between).chain([disks[ends[1]]]);
    (ordered.collect(), true)
}

/// Returns the largest disk within the outline about each place of a grid.
fn inscribed(outline: &Ring) -> Vec<Disk> {
    let Bounds { low, high } = outline.bounds();
    let step = (outline.area() / PLACES).sqrt();
    if step <= 0.0 {
        return Vec::new();
    }
    let columns = ((high.x - low.x) / step).min(PLACES) as usize + 1;
    let rows = ((high.y - low.y) / step).min(PLACES) as usize + 1;
    // The grid has the middle of the outline among its places: what is symmetric stays so.
    let at = |k: usize, count: usize, low: f64, high: f64| {
        0.5 * (low + high) + (k as f64 - 0.5 * (count - count % 2) as f64) * step
    };
    let places = (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column)));
    let places =
        places.map(|(row, column)| vec2(at(column, columns, low.x, high.x), at(row, rows, low.y, high.y)));
    let inside = places.filter(|place| outline.contains(*place));
    inside.map(|centre| Disk { centre, radius: outline.nearest(centre).distance }).collect()
}

/// The largest distance \[m\] of the outline from the disks.
fn gap(outline: &Ring, disks: &[Disk]) -> f64 {
    let away = |place: Vec2| {
        let far = disks.iter().map(|disk| (place - disk.centre).norm() - disk.radius);
        far.fold(f64::INFINITY, f64::min).max(0.0)
    };
    let length: f64 = outline.sides().map(|(a, b)| (b - a).norm()).sum();
    let on_side = |(a, b): (Vec2, Vec2)| {
        let pieces = ((b - a).norm() / length * HUNDREDTHS as f64).ceil().max(1.0) as usize;
        (0..=pieces).map(move |k| a + (b - a) * (k as f64 / pieces as f64))
    };
    outline.sides().flat_map(on_side).map(away).fold(0.0, f64::max)
}

/// The largest distance \[m\] of the disks from the outline, outside of it.
fn beyond(outline: &Ring, disks: &[Disk]) -> f64 {
    let circle = |disk: &Disk| {
        let Disk { centre, radius } = *disk;
        (0..ON_CIRCLE).map(move |k| {
            let angle = TAU * k as f64 / ON_CIRCLE as f64;
            centre + vec2(libm::cos(angle), libm::sin(angle)) * radius
        })
    };
    let outside = disks.iter().flat_map(circle).filter(|place| !outline.contains(*place));
    outside.map(|place| outline.nearest(place).distance).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(length: f64, breadth: f64) -> Ring {
        Ring::around(Bounds { low: Vec2::zeros(), high: vec2(length, breadth) })
    }

    #[test]
    fn one_disk_is_the_largest_within_a_square() {
        let one = cover(&rectangle(1.0, 1.0), 1).unwrap();
        // Within half a step of the grid. Grown by half of the gap at a corner, (√2 − 1)/2 m.
        let gap = 0.5f64.sqrt() - 0.5;
        assert!((one.disks[0].radius - 0.5 - 0.5 * gap).abs() < 0.02, "{one:?}");
        assert!((one.gap - 0.5 * gap).abs() < 0.02 && (one.beyond - 0.5 * gap).abs() < 0.02, "{one:?}");
    }

    #[test]
    fn more_disks_are_a_better_cover() {
        // A stadium of two half circles has no error with few disks; the corners of a rectangle have.
        let half = |x: f64, from: f64| {
            (0..=40).map(move |k| {
                let angle = from + std::f64::consts::PI * f64::from(k) / 40.0;
                vec2(x + 0.3 * angle.cos(), 0.3 * angle.sin())
            })
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        let stadium: Vec<Vec2> = half(0.2, -quarter).chain(half(-0.2, quarter)).collect();
        let stadium = Ring::through(stadium.iter().chain(stadium.first()).copied().collect()).unwrap();
        let errors = |ring: &Ring| -> Vec<f64> {
            [1, 3, 5, 10]
                .map(|count| cover(ring, count).unwrap())
                .iter()
                .map(|of| of.gap.max(of.beyond))
                .collect()
        };
        let (round, square) = (errors(&stadium), errors(&rectangle(1.2, 0.7)));
        assert!(round.is_sorted_by(|a, b| a >= b) && round[1] < 0.03, "{round:?}");
        assert!(square.is_sorted_by(|a, b| a >= b) && square[3] < 0.06, "{square:?}");
        // The areas are those of the shapes; disks at both ends reach them.
        let five = cover(&stadium, 5).unwrap();
        let chair = cover(&rectangle(1.2, 0.7), 8).unwrap();
        let [first, .., last] = chair.disks[..] else { panic!("{chair:?}") };
        assert!(chair.opposite && first.centre.y > last.centre.y + 0.3, "{chair:?}");
        assert!((first.centre.x - last.centre.x).abs() < 1e-3 && chair.disks.len() == 8, "{chair:?}");
        let exact = std::f64::consts::PI * 0.09 + 0.4 * 0.6;
        assert!((five.areas[0] / exact - 1.0).abs() < 2e-3, "{five:?}");
        assert!((five.areas[1] / exact - 1.0).abs() < 0.03, "{five:?}");
    }

    #[test]
    fn impossible_covers_are_refused() {
        assert!(cover(&rectangle(1.0, 1.0), 0).unwrap_err().to_string().contains("must be 1 to 50"));
        let flat = Ring::through(vec![Vec2::zeros(), vec2(1.0, 0.0), Vec2::zeros()]);
        assert!(flat.is_none_or(|flat| cover(&flat, 3).is_err()));
    }
}
