//! Where people want to go: the paper's eq. 4 with way-points, as an FMI 2.0 FMU.
//!
//! Each agent walks from way-point to way-point at its desired speed:
//!
//! ```text
//! Fp = m v₀ e_target / t_transl        Mp = −I δθ / t_rot²
//! ```
//!
//! (Dufour, Stapelle, Nicolas: *LEMONS*, eq. 4). `e_target` is the unit vector to the way-point, `δθ` the angle
//! from there to where the agent looks, in (−π, π]. After the last way-point it drives no more.
//!
//! Poses come in, drives go out under the names that the crowd's FMU has them, so the two connect by name.
//! The rooms, each importing only from those above it:
//!
//! - [`rule`]: eq. 4 and the way-points
//! - [`plan`]: what is known before the start, as TOML
//! - [`decision`]: the model behind the FMU
//! - [`pack`]: a plan and binaries -> an `.fmu`

pub mod decision;
pub mod pack;
pub mod plan;
pub mod rule;

pub use decision::Decision;
pub use plan::{Person, Plan, PlanError, Wishes};
