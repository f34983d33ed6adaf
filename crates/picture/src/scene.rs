//! What is drawn.

use crate::bicycle::Bicycle;
use crate::body::Body;
use crate::density::DensityMap;
use crate::plane::{Pose, View, near};
use crowd_mechanics::engine::{Vec2, vec2};
use crowd_mechanics::trial::Trial;

/// A force in a contact, a line whose width is the force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Force {
    /// \[m\] centre of one body.
    pub from: Vec2,
    /// \[m\] centre of the other, or where the wall is touched.
    pub to: Vec2,
    /// \[N\] not drawn unless it is positive and finite.
    pub normal_force: f64,
}

/// Where somebody has been.
#[derive(Debug, Clone, PartialEq)]
pub struct Trail {
    /// Place among the agents; gives the colour.
    pub agent: Option<usize>,
    /// Solid or dashed.
    pub kind: TrailKind,
    /// \[m\] in the order of time. What is not finite interrupts the line.
    pub points: Vec<Vec2>,
}

/// Where a trail comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrailKind {
    /// Solid. Where there is no measured trail beside it: one colour, paler the longer ago.
    Simulated,
    /// Dashed.
    Measured,
}

/// Walls, and bodies at given poses.
///
/// For a movie: one scene, [`Scene::view`] fixed at the first frame, and new `poses` for every frame.
#[derive(Debug, Clone)]
pub struct Scene<'a> {
    /// Walls and shapes.
    pub trial: &'a Trial,
    /// One per agent, in the order of the agents. An agent without a finite pose is not drawn.
    pub poses: Vec<Pose>,
    /// The part of the plane shown; all walls, bodies, bicycles and trails when `None`.
    pub view: Option<View>,
    /// Forces between bodies, drawn on top of them.
    pub forces: Vec<Force>,
    /// Where the agents have been.
    pub trails: Vec<Trail>,
    /// People per area, drawn below everything else. Bodies are then outlines, and the colour bar is the
    /// density's.
    pub density: Option<DensityMap>,
    /// Drawn beside the agents: a Trial has none.
    pub bicycles: Vec<Bicycle>,
    pub(crate) bodies: Vec<Body>,
}

impl<'a> Scene<'a> {
    /// The agents of the Trial at these poses.
    pub fn new(trial: &'a Trial, poses: Vec<Pose>) -> Scene<'a> {
        let bodies = trial.agents.iter().map(Body::new).collect();
        Scene {
            trial,
            poses,
            view: None,
            forces: Vec::new(),
            trails: Vec::new(),
            density: None,
            bicycles: Vec::new(),
            bodies,
        }
    }

    /// The Trial as its files have it.
    pub fn at_start(trial: &'a Trial) -> Scene<'a> {
        let poses = trial.dynamics.iter().map(|d| Pose { position: d.position, theta: d.theta }).collect();
        Scene::new(trial, poses)
    }

    /// The smallest rectangle around all walls, bodies, bicycles and trails; a metre about the origin when there are none.
    pub fn extent(&self) -> View {
        let mut low = vec2(f64::INFINITY, f64::INFINITY);
        let mut high = -low;
        let mut include = |p: Vec2, r: f64| {
            low = vec2(low.x.min(p.x - r), low.y.min(p.y - r));
            high = vec2(high.x.max(p.x + r), high.y.max(p.y + r));
        };
        for wall in &self.trial.geometry.walls {
            wall.corners.iter().filter(|c| near(**c)).for_each(|c| include(*c, 0.0));
        }
        for trail in &self.trails {
            trail.points.iter().filter(|p| near(**p)).for_each(|p| include(*p, 0.0));
        }
        for (_, pose, body) in self.drawn() {
            body.disks_at(pose).for_each(|(centre, radius)| include(centre, radius));
        }
        for bicycle in self.drawn_bicycles() {
            bicycle.corners().for_each(|corner| include(corner, 0.0));
        }
        if !(low.is_finite() && high.is_finite()) {
            return View { low: vec2(-0.5, -0.5), high: vec2(0.5, 0.5) };
        }
        View { low, high }
    }

    /// The bicycles that can be drawn.
    pub(crate) fn drawn_bicycles(&self) -> impl Iterator<Item = &Bicycle> {
        self.bicycles.iter().filter(|bicycle| bicycle.drawable())
    }

    /// The agents that can be drawn, with their place among the agents.
    pub(crate) fn drawn(&self) -> impl Iterator<Item = (usize, &Pose, &Body)> {
        let all = self.poses.iter().zip(&self.bodies).enumerate();
        all.filter(|(_, (pose, body))| pose.drawable() && !body.disks.is_empty())
            .map(|(k, (pose, body))| (k, pose, body))
    }
}
