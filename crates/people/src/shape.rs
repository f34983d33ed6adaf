//! Shapes that consist of disks.

use crate::error::Result;
use crate::person::Person;
use lemons_core::plane::{Bounds, Disk, Moments, Pose, rotation, union, vec2};

/// The union of some disks: a pedestrian seen from above, in its own frame. The origin is the centroid of the area, the
/// gaze is along +x, left is +y.
///
/// The paper's files have the mean of the disk centres at the origin instead, 2 to 6 mm behind the centroid. The
/// centroid of the area is the centre of mass of a body of uniform density: it turns about this point, and its moment
/// of inertia is about this point.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// The disks, at least one, from the left shoulder to the right one.
    pub disks: Vec<Disk>,
}

/// \[m\] The paper's five disks over a slice through a man's torso, relative to the centroid of its area: 0.617 18
/// broad, 0.3 deep.
const TEMPLATE: [Disk; 5] = [
    Disk { radius: 0.104_346, centre: vec2(-0.020_143, 0.204_246) },
    Disk { radius: 0.143_492, centre: vec2(0.006_363, 0.089_625) },
    Disk { radius: 0.15, centre: vec2(0.011_674, 0.0) },
    Disk { radius: 0.143_492, centre: vec2(0.006_363, -0.089_625) },
    Disk { radius: 0.104_346, centre: vec2(-0.020_143, -0.204_246) },
];
/// \[m\] Depth of the template: the diameter of the middle disk, which is furthest in front and behind.
const TEMPLATE_DEPTH: f64 = 0.3;

impl Shape {
    /// Returns the five disks of a person.
    ///
    /// # Errors
    /// As those of [`Person::check`].
    pub fn of(person: &Person) -> Result<Shape> {
        person.check()?;
        Ok(Shape::fit(person.breadth, person.depth))
    }

    /// Returns the five disks for a bideltoid breadth \[m\] and a chest depth \[m\], which is positive and not larger; both
    /// are met exactly.
    ///
    /// The depth scales the radii and the forward offsets. Then the lateral offsets are scaled so that the outermost
    /// disk meets the breadth. Up to a depth of 0.86 of the breadth this is the shoulder's disk, as in the paper,
    /// beyond it the next one. Closed forms, no search.
    pub fn fit(breadth: f64, depth: f64) -> Shape {
        let scale = depth / TEMPLATE_DEPTH;
        let reach = |part: &Disk| (0.5 * breadth - part.radius * scale) / part.centre.y;
        let sideways = TEMPLATE[..2].iter().map(reach).fold(f64::INFINITY, f64::min);
        let disks = TEMPLATE.map(|Disk { radius, centre }| Disk {
            radius: radius * scale,
            centre: vec2(centre.x * scale, centre.y * sideways),
        });
        // By symmetry the centroid lies on the axis of the gaze; rounding must not tilt the shape.
        let ahead = union(&disks).centroid.x;
        let centred = |disk: Disk| Disk { centre: vec2(disk.centre.x - ahead, disk.centre.y), ..disk };
        Shape { disks: disks.into_iter().map(centred).collect() }
    }

    /// Returns the distance \[m\] between the leftmost and the rightmost point.
    pub fn breadth(&self) -> f64 {
        bounds(self.disks.iter().copied()).size().y
    }

    /// Returns the distance \[m\] between the hindmost and the foremost point.
    pub fn depth(&self) -> f64 {
        bounds(self.disks.iter().copied()).size().x
    }

    /// Returns how far \[m\] it reaches ahead of the origin, and behind it (negative).
    pub(crate) fn ends(&self) -> (f64, f64) {
        let around = bounds(self.disks.iter().copied());
        (around.high.x, around.low.x)
    }

    /// Returns area, centroid and second moment of the union, exact.
    pub fn moments(&self) -> Moments {
        union(&self.disks)
    }

    /// Returns the moment of inertia \[kg m²\] about the centroid, for a mass \[kg\] spread evenly over the union.
    pub fn inertia(&self, mass: f64) -> f64 {
        let Moments { area, polar, .. } = self.moments();
        mass * polar / area
    }

    /// Returns the disks at a pose of the body.
    pub fn placed(&self, pose: &Pose) -> impl Iterator<Item = Disk> + '_ {
        let (position, turn) = (pose.position, rotation(pose.orientation));
        self.disks.iter().map(move |disk| Disk { centre: position + turn * disk.centre, ..*disk })
    }
}

/// The rectangle \[m\] around disks.
pub(crate) fn bounds(disks: impl Iterator<Item = Disk>) -> Bounds {
    let far = vec2(f64::INFINITY, f64::INFINITY);
    disks.fold(Bounds { low: far, high: -far }, |Bounds { low, high }, Disk { radius, centre }| Bounds {
        low: vec2(low.x.min(centre.x - radius), low.y.min(centre.y - radius)),
        high: vec2(high.x.max(centre.x + radius), high.y.max(centre.y + radius)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::plane::Vec2;
    use lemons_core::trial::Agent;

    fn paper() -> Vec<Agent> {
        crowd_mechanics::setup::read(&lemons_testing::trial_push()).unwrap().0.agents
    }

    fn shape(agent: &Agent) -> Shape {
        let disks = agent.shapes.iter().map(|disk| Disk { radius: disk.radius, centre: disk.position });
        Shape { disks: disks.collect() }
    }

    fn mean_centre(shape: &Shape) -> Vec2 {
        let sum = shape.disks.iter().fold(Vec2::zeros(), |sum, disk| sum + disk.centre);
        sum * (1.0 / shape.disks.len() as f64)
    }

    #[test]
    fn breadth_and_depth_are_met() {
        for k in 0..200 {
            for j in 1..=100 {
                let breadth = 0.2 + 0.003 * f64::from(k);
                let depth = breadth * (f64::from(j) / 100.0);
                let shape = Shape::fit(breadth, depth);
                assert!((shape.breadth() - breadth).abs() < 1e-9 && (shape.depth() - depth).abs() < 1e-9);
                let ys: Vec<f64> = shape.disks.iter().map(|disk| disk.centre.y).collect();
                assert!(ys.is_sorted_by(|left, right| left > right), "{breadth} {depth}: {ys:?}");
                assert!(shape.moments().centroid.norm() < 1e-12, "{breadth} {depth}");
            }
        }
    }

    #[test]
    fn the_papers_agents_are_of_this_form() {
        let mut worst = 0.0f64;
        for agent in paper() {
            let printed = shape(&agent);
            let fitted = Shape::fit(printed.breadth(), printed.depth());
            let (ours, theirs) = (mean_centre(&fitted), mean_centre(&printed));
            for (a, b) in fitted.disks.iter().zip(&printed.disks) {
                worst = worst.max((a.radius - b.radius).abs());
                worst = worst.max(((a.centre - ours) - (b.centre - theirs)).norm());
            }
            // The printed offsets are about the mean of the centres, not about the area's centroid.
            assert!(theirs.norm() < 1e-6 && (0.002..0.004).contains(&-ours.x), "{ours:?} {theirs:?}");
        }
        println!("largest difference {:.4} mm", worst * 1e3);
        assert!(worst < 0.03e-3, "{worst}");
    }

    /// App. C prints moments of inertia 1.1 to 1.9 % above those of its own disks (a count of 10⁶ grid points agrees
    /// with the exact ones to 4 digits): more than its three digits explain.
    #[test]
    fn inertia_of_the_papers_agents() {
        let exact_and_excess =
            [(1.81905, 1.70), (1.00168, 1.83), (1.75996, 1.14), (1.23603, 1.94), (1.60281, 1.70)];
        for (agent, (exact, excess)) in paper().iter().zip(exact_and_excess) {
            let ours = shape(agent).inertia(agent.mass);
            assert!((ours - exact).abs() < 1e-5, "agent {}: {ours}", agent.id);
            let off = 100.0 * (agent.moment_of_inertia / ours - 1.0);
            assert!((off - excess).abs() < 0.01, "agent {}: {off} %", agent.id);
        }
    }
}
