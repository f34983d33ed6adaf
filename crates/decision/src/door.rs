//! Walls that open and close, as people see them: where one is closed, they stop in front of it.

use crate::source::{placed, reach};
use crate::target::share_before_closed;
use lemons_core::plane::{Pose, Vec2, body_meets, nearest_on_segment};
use lemons_core::trial::Wall;

/// \[m\] Who is so far in a door that closes walks on at the desired speed.
const IN_IT: f64 = 0.05;
/// The least part of the desired speed of who is in a door that closes.
const OUT_OF_IT: f64 = 0.1;

/// \[m\] Returns how far it is along a direction, a unit vector, to the door; infinite if that leads past it.
pub(crate) fn distance(door: &Wall, at: Vec2, direction: Vec2) -> f64 {
    let meets = door.sides().map(|ends| ends.map(|end| end - at)).filter_map(|[from, to]| {
        let (left, right) = (direction.perp(&from), direction.perp(&to));
        // The point between the ends that lies straight ahead.
        let ahead = (from * right - to * left) * (1.0 / (right - left));
        (left * right <= 0.0 && left != right).then(|| ahead.dot(&direction)).filter(|&far| far >= 0.0)
    });
    meets.fold(f64::INFINITY, f64::min)
}

/// Returns the part of the desired speed with which somebody, a body of disks each with its place and radius at a gaze
/// along x, walks towards the door, which is closed. The wall waits for who is in it, also between the disks: that one
/// walks on.
pub(crate) fn share(door: &Wall, pose: Pose, disks: &[[f64; 3]]) -> f64 {
    let at = pose.position;
    let far = |place: Vec2| {
        let all = door.sides().map(|[a, b]| (nearest_on_segment(a, b, place) - place).norm());
        all.fold(f64::INFINITY, f64::min)
    };
    let before = share_before_closed(far(at));
    if far(at) > reach(disks) {
        return before;
    }
    let disks: Vec<(Vec2, f64)> = placed(disks, pose).collect();
    if !door.sides().any(|[a, b]| body_meets(&disks, a, b)) {
        return before;
    }
    let depths = disks.iter().map(|&(centre, radius)| radius - far(centre));
    let overlap = depths.fold(f64::NEG_INFINITY, f64::max);
    if overlap > 0.0 { (overlap / IN_IT).clamp(OUT_OF_IT, 1.0) } else { 1.0 }
}
