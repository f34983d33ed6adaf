//! Contact mechanics of dense crowds.
//!
//! An agent is a rigid body in the plane that carries disks. It moves by
//!
//! ```text
//! m dv/dt = Fp − m v/t_transl + Σ (F_n + F_t)
//! I dω/dt = Mp − I ω/t_rot    + Σ (C − G) × (F_n + F_t)
//! F_n = (k_n h − γ_n v_n) n,    F_t = −k_t s − γ_t v_t   while |F_t| ≤ μ |F_n|, else sliding at μ |F_n|
//! ```
//!
//! (Dufour, Stapelle, Nicolas: *LEMONS*, eq. 1 and App. A). The rooms, each importing only from those above it:
//!
//! - [`engine`]: pure mechanics, no files, no FMI
//! - [`files`]: files written whole or not at all
//! - [`trial`]: the XML *Trial* directory, read, checked and written
//! - [`variables`]: the one table of FMU variables
//! - [`resources`]: from a resource URI to the Trials packed in an FMU
//! - [`model_description`], [`pack`]: the table as XML, a Trial as an FMU
//! - [`crowd`]: what an FMU instance simulates
//! - [`fmi2`]: the FMI 2.0 C functions (their bodies are `lemons_fmi2`'s)
//! - [`c_api`]: the C entry point of the paper's scripts

pub mod c_api;
pub mod crowd;
pub mod engine;
pub mod files;
pub mod fmi2;
pub mod model_description;
pub mod pack;
pub mod resources;
pub mod trial;
pub mod variables;
