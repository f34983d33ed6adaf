//! Lines that overlap along each other: one of them stays. Two walls at one place would push twice, and the engine compares
//! all that lie on each other.

use super::DrawnLine;
use super::join::SAME;
use crate::error::{Result, require};
use lemons_core::plane::{Bounds, InPlane, Vec2};

/// \[rad\] Directions of one class are nearer than this. The odd numbers keep round coordinates from its rims.
const SAME_ANGLE: f64 = 1.3e-8;
/// \[m\] Lines of one class are nearer than this.
const SAME_LINE: f64 = 0.73e-6;
/// Where a class begins, as a share of it.
const RIM: f64 = 0.37;
/// More pairs of pieces that lie on each other are a mistake.
const MOST_PAIRS: usize = 1_000_000;

/// A straight piece of a line: the class says on which infinite line.
#[derive(Clone, Copy)]
struct Piece {
    class: [i64; 2],
    /// \[m\] Along it.
    from: f64,
    to: f64,
    ends: [Vec2; 2],
    line: usize,
}

/// Returns the lines, but of those with two corners that overlap along each other only one, as long as they are together,
/// and none that lies on longer lines; and the number of those that are left out. With `areas`, closed lines are not looked
/// at: what is between two of them is no wall.
///
/// # Errors
/// Pieces of longer lines lie on each other at too many places.
pub(super) fn without_overlaps(mut lines: Vec<DrawnLine>, areas: bool) -> Result<(Vec<DrawnLine>, usize)> {
    let is_single = |line: &DrawnLine| !line.closed && line.corners.len() == 2;
    let (single, fixed): (Vec<Piece>, Vec<Piece>) =
        pieces(&lines, areas).into_iter().partition(|piece| is_single(&lines[piece.line]));
    refuse_many(&fixed)?;
    let mut keep = vec![true; lines.len()];
    let longer = together(fixed, |_, _| ());
    let merged = together(single, |first, other| keep[first.max(other)] = false);
    for piece in merged {
        let on =
            longer.partition_point(|other| (other.class, other.from) <= (piece.class, piece.from + SAME));
        let on = on.checked_sub(1).map(|on| &longer[on]);
        if on.is_some_and(|on| on.class == piece.class && piece.to <= on.to + SAME) {
            keep[piece.line] = false;
        }
        let corners = &mut lines[piece.line].corners;
        if !piece.ends.iter().all(|end| corners.contains(end)) {
            *corners = piece.ends.to_vec();
        }
    }
    let left_out = keep.iter().filter(|keep| !**keep).count();
    let kept = lines.into_iter().zip(keep).filter(|(_, keep)| *keep).map(|(line, _)| line).collect();
    Ok((kept, left_out))
}

/// Returns the pieces of all lines, by class and beginning.
fn pieces(lines: &[DrawnLine], areas: bool) -> Vec<Piece> {
    let corners = || lines.iter().flat_map(|line| line.corners.iter().copied());
    let Some(Bounds { low, .. }) = Bounds::of(corners()) else { return Vec::new() };
    let class = |x: f64, width: f64| (x / width + RIM).floor() as i64;
    let piece = |line: usize, (a, b): (Vec2, Vec2)| {
        let u = (b - a).unit(SAME)?;
        let back = u.x < -SAME_ANGLE || (u.x <= SAME_ANGLE && u.y < 0.0);
        let (u, ends) = if back { (-u, [b, a]) } else { (u, [a, b]) };
        let [from, to] = ends.map(|end| (end - low).dot(&u));
        let class =
            [class(libm::atan2(u.y, u.x), SAME_ANGLE), class((ends[0] - low).dot(&u.left()), SAME_LINE)];
        Some(Piece { class, from, to, ends, line })
    };
    let of_line = |(k, line): (usize, &DrawnLine)| {
        let next = line.corners.iter().skip(1).chain(line.corners.first().filter(|_| line.closed));
        let sides = line.corners.iter().copied().zip(next.copied());
        sides.filter_map(|side| piece(k, side)).collect::<Vec<_>>()
    };
    let looked_at = lines.iter().enumerate().filter(|(_, line)| !(areas && line.closed));
    let mut all: Vec<Piece> = looked_at.flat_map(of_line).collect();
    all.sort_by(|a, b| a.class.cmp(&b.class).then(a.from.total_cmp(&b.from)).then(a.line.cmp(&b.line)));
    all
}

/// Puts pieces together that overlap: that of the first line gets longer. Says which two lines they are of.
fn together(pieces: Vec<Piece>, mut says: impl FnMut(usize, usize)) -> Vec<Piece> {
    let mut all: Vec<Piece> = Vec::new();
    for piece in pieces {
        match all.last_mut().filter(|last| last.class == piece.class && piece.from < last.to - SAME) {
            Some(last) => {
                says(last.line, piece.line);
                last.line = last.line.min(piece.line);
                if piece.to > last.to {
                    (last.to, last.ends[1]) = (piece.to, piece.ends[1]);
                }
            }
            None => all.push(piece),
        }
    }
    all
}

fn refuse_many(pieces: &[Piece]) -> Result<()> {
    let mut pairs = 0;
    for (k, piece) in pieces.iter().enumerate() {
        let on = |other: &Piece| (other.class, other.from) < (piece.class, piece.to - SAME);
        pairs += pieces[k + 1..].partition_point(on);
    }
    Ok(require(pairs <= MOST_PAIRS, || {
        format!(
            "pieces of walls lie on each other in {pairs} pairs; at most {MOST_PAIRS} are allowed: draw each wall once"
        )
    })?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::plane::{rotation, vec2};

    fn line(corners: &[[f64; 2]]) -> DrawnLine {
        DrawnLine {
            layer: String::new(),
            role: None,
            name: None,
            entity: String::new(),
            corners: corners.iter().map(|at| Vec2::from(*at)).collect(),
            closed: false,
            hole: false,
            ground: false,
        }
    }

    /// Lines from one place, lines each a little further, and both turned: in the end one wall, 30 000 are none too many.
    #[test]
    fn many_lines_on_each_other_are_one() {
        for (angle, shift) in
            [(0.0, 0.0), (0.5, 0.0), (0.0, 1e-3), (1.2, 1e-3), (std::f64::consts::FRAC_PI_2, 1e-3)]
        {
            let turn = rotation(angle);
            let of = |k: u32| {
                let k = f64::from(k);
                let (from, to) =
                    if shift > 0.0 { (k * shift, 100.0 + k * shift) } else { (0.0, 100.0 - k * 1e-3) };
                let ends = [vec2(from, 7.0), vec2(to, 7.0)].map(|end| turn * end);
                line(&if k % 2.0 == 0.0 { ends } else { [ends[1], ends[0]] }.map(Into::into))
            };
            let (left, out) = without_overlaps((0..30_000).map(of).collect(), false).unwrap();
            assert_eq!((left.len(), out), (1, 29_999), "{angle} {shift}");
            let ends = &left[0].corners;
            let expected = if shift > 0.0 { 100.0 + 29_999.0 * shift } else { 100.0 };
            assert!(((ends[1] - ends[0]).norm() - expected).abs() < 1e-9);
        }
        // Of longer lines it cannot be said which: so many are refused, with their number.
        let bent = |k: u32| line(&[[f64::from(k) * 1e-3, 0.0], [100.0, 0.0], [100.0 + f64::from(k), 5.0]]);
        let refused = without_overlaps((0..2_000).map(bent).collect(), false).unwrap_err().to_string();
        assert!(refused.contains("in 1999000 pairs; at most 1000000"), "{refused}");
    }

    #[test]
    fn only_what_overlaps_is_left_out() {
        let all = [
            line(&[[0.0, 0.0], [4.0, 0.0]]),
            // It goes on, lies beside, stands across, is on the first, lies on a longer line, and is longer than it.
            line(&[[4.0, 0.0], [6.0, 0.0]]),
            line(&[[1.0, 1e-3], [3.0, 1e-3]]),
            line(&[[2.0, -1.0], [2.0, 1.0]]),
            line(&[[3.0, 0.0], [1.0, 0.0]]),
            line(&[[0.0, 9.0], [4.0, 9.0], [4.0, 12.0]]),
            line(&[[4.0, 10.0], [4.0, 11.0]]),
            line(&[[4.0, 10.0], [4.0, 13.0]]),
        ];
        let (left, out) = without_overlaps(all.to_vec(), false).unwrap();
        assert_eq!(out, 2);
        // The last two are one, which is longer than the line that it is on.
        let expected: Vec<DrawnLine> =
            [0, 1, 2, 3, 5].map(|k| all[k].clone()).into_iter().chain([all[7].clone()]).collect();
        assert_eq!(
            left.iter().map(|line| &line.corners).collect::<Vec<_>>(),
            expected.iter().map(|line| &line.corners).collect::<Vec<_>>()
        );
    }
}
