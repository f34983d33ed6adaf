//! Pure mechanics: no files, no FMI, no unsafe code.
//!
//! A [`World`] owns a [`Scene`] (bodies, walls, laws: immutable), a drive and a [`State`] (poses, twists,
//! springs). It advances them by one communication step at a time, during which the drive is constant or changes
//! linearly. A communication step is divided into mechanical steps. Each of these predicts the motion, evaluates the
//! contact forces once, and corrects. Bodies that can touch nothing are moved by the closed-form solution. All
//! quantities are in SI units; angles are in radians, positive counter-clockwise.

#[cfg(test)]
mod balls;
mod begin_and_end;
mod blocks;
mod chains;
mod circle;
pub mod contact_law;
mod contacts;
mod encounter;
mod exposure;
mod face;
mod face_grid;
mod free_flight;
mod ids;
mod mechanical_step;
mod neighbours;
mod overlap;
mod pairs;
mod passing;
mod report;
mod scene;
mod shortlist;
mod springs;
mod standing;
mod state;
mod threads;
mod world;

pub use chains::Chain;
pub use contact_law::Regime;
pub use contacts::Work;
pub use exposure::Exposure;
pub use face::Face;
pub use free_flight::{BodyFlight, FreeFlight};
pub use ids::{BodyId, CornerId, DiskId, FaceId, LineId, WallId};
pub use lemons_plane::{Pose, Rotation, Twist, Vec2, vec2};
pub use neighbours::Crowded;
pub use overlap::{Meeting, Overlap};
pub use report::{BodyContacts, Contact, ContactReport, Pair};
pub use scene::{Body, BodySpec, Corner, Disk, DiskSpec, LawTable, PairLaw, Scene, SceneError, WallSpec};
pub use shortlist::Shortlisting;
pub use springs::elongation_vector;
pub use state::{DiskSpring, FacePart, FaceSpring, State, Wrench};
use threads::Threads;
pub use threads::ThreadsError;
pub use world::{AdvanceError, MOST_THREADS, World, step_count};
