//! SSP 1.0 and 2.0 (System Structure and Parameterization): FMUs and the connections between them in one archive.
//!
//! - [`SystemStructure`]: what `SystemStructure.ssd` says, checked: connections lead from an output to an input
//! - [`Interface`]: what an FMU of FMI 2.0 or 3.0 says of itself: its variables and units, its names and abilities
//! - [`connect`]: interfaces -> the structure that connects equal names
//! - [`ArchiveReader`], [`write_archive`]: the `.ssp`
//! - [`Allowance`]: how much an archive may unpack to
//!
//! Served of the standard: components that are FMUs for co-simulation, connections with unit conversion and
//! linear transformation, parameter values (inline or `.ssv`), the default experiment; of SSP 2.0 arrays that are
//! connected whole or by element. Refused, with a message that names the element: nested systems, signal dictionaries,
//! connections from the system's own inputs, parameter mappings, mapping transformations, values of arrays, clocks.

mod archive;
mod choice;
mod connect;
mod document;
mod interface;
mod participant;
mod read;
mod terminals;
mod unit;
mod write;

pub use archive::{Allowance, ArchiveReader, write_archive};
pub(crate) use archive::{ZipFile, entry, open_zip, sound};
pub use connect::{Connected, connect};
pub(crate) use document::wrong_at;
pub use document::{
    Causality, Connection, Connector, Extent, FmiType, Port, STRUCTURE_FILE, SspComponent, SspParameter,
    SystemStructure,
};
pub use interface::{ArrayDimension, CoSimulation, FmuVariable, Interface, Single};
pub(crate) use interface::{place_of, written};
pub use participant::Participant;
pub use terminals::Terminal;
pub(crate) use terminals::{LARGEST_TERMINALS, TERMINALS_FILE};
pub use unit::{Affine, SspUnit, UnitOf, conversion};
