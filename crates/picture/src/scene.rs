//! Scenes: the content of a picture.

use crate::body::{DrawnBody, drawable, near};
use crate::density::DensityMap;
use crate::style::Values;
use lemons_core::plane::{Bounds, Pose, Vec2, vec2};
use lemons_core::trial::{AgentDynamics, Trial};

/// A contact force, drawn as a line whose width is proportional to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrawnForce {
    /// \[m\] Centre of one body.
    pub from: Vec2,
    /// \[m\] Centre of the other body, or the contact point on the wall.
    pub to: Vec2,
    /// \[N\] Normal force. The line is drawn if it is positive and finite.
    pub normal_force: f64,
}

/// The trail of an agent.
#[derive(Debug, Clone, PartialEq)]
pub struct Trail {
    /// Index of the agent; it selects the colour.
    pub agent: usize,
    /// Measured ones are dashed, simulated ones solid. Without a measured trail beside them, simulated ones have one
    /// colour that becomes paler with age.
    pub measured: bool,
    /// \[m\] Points in order of time. Points that are not finite interrupt the line.
    pub points: Vec<Vec2>,
}

/// Kind of a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum MarkKind {
    /// Where people leave.
    Exit,
    /// Where people are placed.
    Distribution,
    /// Where people go to.
    Waypoint,
}

/// A place of a plan, drawn above the walls and below the bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaceMark {
    /// It selects the colour.
    pub kind: MarkKind,
    /// The title of its path.
    pub name: String,
    /// \[m\] One is a point, two are a line, more are an area.
    pub corners: Vec<Vec2>,
}

/// Walls, and bodies at poses.
///
/// For a movie: make one scene, fix [`PictureScene::view`] at the first frame, and set new `poses` for every frame.
#[derive(Debug, Clone)]
pub struct PictureScene<'a> {
    /// Walls and shapes.
    pub trial: &'a Trial,
    /// One pose for each agent, in their order. An agent without a finite pose is not drawn.
    pub poses: Vec<Pose>,
    /// The visible part of the plane; `None`: all walls, bodies and trails.
    pub view: Option<Bounds>,
    /// Forces between bodies, drawn on top of them.
    pub forces: Vec<DrawnForce>,
    /// \[m\] The middle of the feet of each agent, in their order; empty if people have no legs. Feet are drawn through bodies,
    /// with a line to the centre of mass.
    pub feet: Vec<Vec2>,
    /// Trails of the agents.
    pub trails: Vec<Trail>,
    /// People per area, drawn below everything else. Bodies are then outlines, and the colour bar shows the density.
    pub density: Option<DensityMap>,
    /// Loads on walls, drawn on them. The colour bar shows them, and bodies have one colour.
    pub loads: Option<LoadMap>,
    /// Exits, and other places of a plan.
    pub marks: Vec<PlaceMark>,
    /// \[m\] The height of what is drawn; `None`: all heights.
    pub(crate) height: Option<f64>,
    pub(crate) bodies: Vec<DrawnBody>,
}

/// Loads on panels of walls.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadMap {
    /// \[m\] Ends of each panel.
    pub panels: Vec<[Vec2; 2]>,
    /// Load on each.
    pub values: Values,
}

impl<'a> PictureScene<'a> {
    /// Makes a scene of the agents of a Trial at these poses.
    pub fn new(trial: &'a Trial, poses: Vec<Pose>) -> PictureScene<'a> {
        let bodies = trial.agents.iter().map(|agent| DrawnBody::new(agent, None)).collect();
        PictureScene {
            trial,
            poses,
            view: None,
            forces: Vec::new(),
            feet: Vec::new(),
            trails: Vec::new(),
            density: None,
            loads: None,
            marks: Vec::new(),
            height: None,
            bodies,
        }
    }

    /// Returns the scene at a height \[m\]: of the disks and walls that are there.
    #[must_use]
    pub fn at_height(self, height: Option<f64>) -> PictureScene<'a> {
        let bodies = self.trial.agents.iter().map(|agent| DrawnBody::new(agent, height)).collect();
        PictureScene { height, bodies, ..self }
    }

    /// Makes a scene of the Trial as in its files, without those who come later.
    pub fn at_start(trial: &'a Trial) -> PictureScene<'a> {
        let nowhere = vec2(f64::NAN, f64::NAN);
        let pose = |own: &AgentDynamics| Pose {
            position: if own.absent { nowhere } else { own.position },
            orientation: own.theta,
        };
        PictureScene::new(trial, trial.dynamics.iter().map(pose).collect())
    }

    /// Returns the smallest rectangle around all walls, marks, bodies, feet and trails; a metre about the origin if
    /// there are none.
    pub fn extent(&self) -> Bounds {
        let corners = self.trial.geometry.walls.iter().flat_map(|wall| &wall.corners);
        let trails = self.trails.iter().flat_map(|trail| &trail.points);
        let feet = self.drawn_feet().map(|(_, feet)| feet);
        let marks = self.marks.iter().flat_map(|mark| &mark.corners);
        let lines = corners.chain(trails).chain(marks).copied().filter(|p| near(*p)).chain(feet);
        let disks = self.drawn().flat_map(|(_, pose, body)| body.disks_at(pose));
        let rims = disks.flat_map(|d| [-1.0, 1.0].map(|s| d.centre + vec2(d.radius, d.radius) * s));
        Bounds::of(lines.chain(rims)).unwrap_or(Bounds::UNIT)
    }

    /// The feet that can be drawn, with the poses of their bodies.
    pub(crate) fn drawn_feet(&self) -> impl Iterator<Item = (&Pose, Vec2)> + Clone {
        let feet = self.drawn().filter_map(|(agent, pose, _)| Some((pose, *self.feet.get(agent)?)));
        feet.filter(|(_, feet)| near(*feet))
    }

    /// The agents that can be drawn, with their indices.
    pub(crate) fn drawn(&self) -> impl Iterator<Item = (usize, &Pose, &DrawnBody)> + Clone {
        let all = self.poses.iter().zip(&self.bodies).enumerate();
        all.filter(|(_, (pose, body))| drawable(pose) && !body.disks.is_empty())
            .map(|(k, (pose, body))| (k, pose, body))
    }
}
