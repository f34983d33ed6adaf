//! Pure mechanics: no files, no FMI, no unsafe code.
//!
//! A [`World`] owns a [`Scene`] (bodies, walls, laws: immutable), a drive and a [`State`] (poses, twists,
//! springs) and advances them by one communication step at a time, over which the drive is held or changes
//! evenly. Inside, a mechanical step predicts, evaluates the contact forces once, and corrects; bodies that
//! can touch nothing are moved by the closed form. SI units throughout; angles in radians, counter-clockwise positive.

mod blocks;
pub mod contact_law;
mod contacts;
mod exposure;
mod face_grid;
mod free_flight;
mod ids;
mod mechanical_step;
mod neighbours;
mod overlap;
mod pairs;
mod scene;
mod shortlist;
mod springs;
mod state;
mod threads;
mod vec2;
mod world;

pub use contact_law::Regime;
pub use contacts::{BodyContacts, Contact, ContactReport, Pair, Work};
pub use exposure::Exposure;
pub use free_flight::{BodyFlight, FreeFlight};
pub use ids::{BodyId, CornerId, DiskId, FaceId, LineId, WallId};
pub use neighbours::Crowded;
pub use overlap::{Meeting, Overlap};
pub use scene::{
    Body, BodySpec, Corner, Disk, DiskSpec, Face, LawTable, PairLaw, Scene, SceneError, WallSpec,
    shown_orientation,
};
pub use shortlist::Shortlisting;
pub use springs::elongation_vector;
pub use state::{DiskSpring, FacePart, FaceSpring, Pose, State, Twist, Wrench};
use threads::Threads;
pub use threads::ThreadsError;
pub use vec2::{Rotation, Vec2, vec2};
pub use world::{AdvanceError, MOST_THREADS, World, step_count};
