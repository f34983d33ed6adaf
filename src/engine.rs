//! Pure mechanics: no files, no FMI, no unsafe code.
//!
//! A [`World`] owns a [`Scene`] (bodies, walls, laws: immutable), a drive and a [`State`] (poses, twists,
//! springs). It advances them by one communication step at a time, during which the drive is constant or changes
//! linearly. A communication step is divided into mechanical steps. Each of these predicts the motion, evaluates the
//! contact forces once, and corrects. Bodies that can touch nothing are moved by the closed-form solution. All
//! quantities are in SI units; angles are in radians, positive counter-clockwise.
//!
//! A person of 100 kg meets one of 50 kg who stands, head-on, without friction and damping. For elastic bodies, mechanics
//! says 1/3 m/s and 4/3 m/s afterwards:
//!
//! ```
//! use crowd_mechanics::engine::*;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let person = |mass| BodySpec {
//!     mass,                  // [kg]
//!     inertia: 1.5,          // [kg.m2]
//!     across_rate: None,     // the same across the gaze
//!     translation_rate: 0.0, // [1/s] a floor without friction; about 4.5 for people
//!     rotation_rate: 0.0,
//!     disks: vec![DiskSpec { radius: 0.2, position: vec2(0.0, 0.0), material: 0 }], // [m]; five for a person's shape
//! };
//! let mut laws = LawTable::new(1);
//! let law = PairLaw { normal_stiffness: 3e5, tangential_stiffness: 3e5, // [N/m]
//!                     normal_damping: 0.0, tangential_damping: 0.0,     // [kg/s]
//!                     friction: 0.0 };
//! laws.set(0, 0, law);
//! let scene = Scene::new(&[person(100.0), person(50.0)], &[], laws);
//!
//! let at = |x| Pose { position: vec2(x, 0.0), orientation: 0.0 };
//! let moving = |vx| Twist { velocity: vec2(vx, 0.0), angular_velocity: 0.0 };
//! let state = State::new(vec![at(0.0), at(0.5)], vec![moving(1.0), moving(0.0)]);
//! let mut world = World::new(scene, state, 1e-5)?; // [s] mechanical step
//!
//! for _ in 0..30 {
//!     world.advance(0.01)?; // [s] communication step
//! }
//! let speed = |body: usize| world.state().twists[body].velocity.x;
//! assert!((speed(0) - 1.0 / 3.0).abs() < 1e-6 && (speed(1) - 4.0 / 3.0).abs() < 1e-6);
//! assert_eq!(world.contacts().bodies[0].squeeze, 0.0); // they have parted
//! # Ok(())
//! # }
//! ```
//!
//! [`World::drive`] is what people want (a force and a torque of each), [`World::exposures`] how hard each was squeezed
//! in the last step. `examples/engine_direct.rs` reads a Trial.

mod blocks;
mod body_kinematics;
mod broad_phase;
mod circle;
mod compression;
mod contact_events;
mod contact_geometry;
pub mod contact_law;
mod contacts;
mod corner_transition;
mod exposure;
mod face;
mod face_grid;
mod free_flight;
mod ids;
mod levels;
mod mechanical_step;
mod near_pairs;
mod overlap;
mod pair_forces;
mod panels;
mod report;
#[cfg(test)]
mod round_bodies;
mod scene;
mod shortlist;
mod slope;
mod springs;
mod state;
mod threads;
mod wall_contacts;
mod world;

pub use broad_phase::Crowded;
pub use compression::{Compression, ForceMoments};
pub use contact_law::Regime;
pub use contacts::Work;
pub use exposure::{Exposure, Exposures, FaceExposure};
pub use face::{Continuation, Face};
pub use free_flight::{BodyFlight, FreeFlight};
pub use ids::{BodyId, CornerId, DiskId, FaceId, LineId, PanelId, WallId};
pub use lemons_core::plane::{InPlane, Pose, Rotation, Twist, Vec2, rotation, vec2};
pub use levels::{ChestExposure, Levels};
pub use overlap::{Overlap, Proximity};
pub use pair_forces::PairForce;
pub use report::{BodyContacts, Contact, ContactReport, Pair};
pub use scene::{Body, BodySpec, ContactDisk, Corner, DiskSpec, LawTable, PairLaw, Scene, WallSpec};
pub use shortlist::Shortlisting;
pub use springs::elongation_vector;
pub use state::{DiskSpring, FacePart, FaceSpring, State, Wrench};
use threads::Threads;
pub use threads::ThreadsError;
pub use world::{AdvanceError, MOST_THREADS, World, step_count};
