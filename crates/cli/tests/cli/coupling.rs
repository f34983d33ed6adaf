//! The controller that the pages couple with a crowd.

#[path = "../../../../tests/coupling/controller.rs"]
pub mod controller;
