//! Contact mechanics of dense crowds.
//!
//! An agent is a rigid body in the plane, made of disks. Its equations of motion are
//!
//! ```text
//! m dv/dt = Fp − m v/t_transl + Σ (F_n + F_t)
//! I dω/dt = Mp − I ω/t_rot    + Σ (C − G) × (F_n + F_t)
//! F_n = (k_n h − γ_n v_n) n,    F_t = −k_t s − γ_t v_t   while |F_t| ≤ μ |F_n|, else sliding at μ |F_n|
//! ```
//!
//! (Dufour, Stapelle, Nicolas: *LEMONS*, eq. 1 and App. A); on a slope, m (1 − held) g sin α downhill is added, with
//! lengths in plan. The house, with the way of a Trial through it:
//!
//! ```text
//!    a Trial (XML)                                an importer: FMPy, libcosim, …
//!         │                                            │           ▲
//!         ▼                                   Fp, Mp, parameters   │ poses, velocities,
//!  ┌─────────────┐    ┌───────────┐                    ▼           │ contacts, squeeze
//!  │    setup    │───►│  engine   │            ┌───────────────────────────┐
//!  │ reads, warns│    │  World:   │◄──────────►│ model: an FMU's instance  │
//!  └─────────────┘    │ advance(H)│            │ C functions: crowd-fmu    │
//!         │           └───────────┘            └───────────────────────────┘
//!         ▼                                                  ▲
//!  ┌──────────────────────┐    ┌───────────────────┐         │
//!  │ quantities: names,   │───►│ model_description │──► pack ──► an .fmu
//!  │ units, shapes        │    └───────────────────┘         (resources: its Trials)
//!  └──────────────────────┘
//! ```
//!
//! The modules; each imports only from those above it:
//!
//! - [`engine`]: pure mechanics, no files, no FMI
//! - [`setup`]: from the documents of a Trial (`lemons_core::trial`) to the engine's world, and what to warn of
//! - [`quantities`]: the table of quantities: arrays in FMI 3.0, their elements in FMI 2.0
//! - [`resources`]: from a resource URI to the Trials packed in an FMU
//! - [`model`]: what an FMU instance simulates
//! - [`model_description`], [`pack`]: the table as XML, a Trial as an FMU
//! - [`in_place`]: steps of a Trial in its own files, as the paper's scripts make them
//! - [`scenes`]: small worlds and Trials, for tests, checks and benchmarks
//!
//! crates/crowd-fmu has the C functions.

/// The code of the guide runs as a test.
#[cfg(doctest)]
#[doc = include_str!("../docs/guide/rust.md")]
struct Guide;

pub mod engine;
pub mod in_place;
pub mod model;
pub mod model_description;
#[cfg(feature = "fmu")]
pub mod pack;
pub mod quantities;
pub mod resources;
pub mod scenes;
pub mod setup;
