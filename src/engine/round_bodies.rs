//! Round bodies connected only by springs, for tests.

use super::{BodySpec, DiskSpec, LawTable, PairLaw, Scene, Vec2};

/// One disk about the centre of mass, with a moment of inertia of 1 kg.m².
pub(super) struct RoundBody {
    /// \[kg\] mass.
    pub(super) mass: f64,
    /// \[m\] radius.
    pub(super) radius: f64,
    /// \[1/s\] relaxation rate of the velocity.
    pub(super) relaxation: f64,
    /// \[N/m\] stiffness of both springs.
    pub(super) stiffness: f64,
}

impl RoundBody {
    /// Makes a scene of `count` bodies without walls.
    pub(super) fn scene(&self, count: usize) -> Scene {
        let mut laws = LawTable::new(1);
        let law = PairLaw {
            normal_stiffness: self.stiffness,
            tangential_stiffness: self.stiffness,
            normal_damping: 0.0,
            tangential_damping: 0.0,
            friction: 0.0,
        };
        laws.set(0, 0, law);
        let body = BodySpec {
            mass: self.mass,
            inertia: 1.0,
            translation_rate: self.relaxation,
            across_rate: None,
            rotation_rate: 0.0,
            disks: vec![DiskSpec { radius: self.radius, position: Vec2::zeros(), material: 0 }],
        };
        Scene::new(&vec![body; count], &[], laws)
    }
}
