//! Propulsion of people: the paper's eq. 4 with way-points, as an FMU, FMI 2.0 or 3.0.
//!
//! Each agent walks from way-point to way-point at its desired speed:
//!
//! ```text
//! Fp = m v₀ e_target / t_transl        Mp = −I δθ / t_rot²
//! ```
//!
//! (Dufour, Stapelle, Nicolas: *LEMONS*, eq. 4). `e_target` is the unit vector to the way-point. `δθ` is the angle from
//! this direction to the gaze, in (−π, π]. After the last way-point the drive is zero.
//!
//! Poses are inputs, drives are outputs. They have the same names as in the crowd's FMU, so that the two can be
//! connected by name. The modules; each imports only from those above it:
//!
//! - [`rule`]: eq. 4 and the way-points
//! - [`plan`]: the data before the start, as TOML
//! - [`decision`]: the model of the FMU; [`decision::arrays`]: the same as arrays (FMI 3.0)
//! - [`pack`]: writes an `.fmu` from a plan and binaries

pub mod decision;
pub mod pack;
pub mod plan;
pub mod rule;

pub use decision::Decision;
pub use plan::{Person, Plan, PlanError, Wishes};
