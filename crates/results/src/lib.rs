//! The record of a run: the one table of its [`columns`]; written, read and exported to the formats that the field's
//! tools read, and the way back to a Trial.
//!
//! A [`FrameWriter`] writes the [`Frame`]s of a crowd to a table in CSV or Parquet; a [`TableWriter`] writes a table
//! with other columns. A [`Recorder`] keeps frames in memory instead. A [`Record`] reads frames again, one at a time,
//! from a table ([`Record::table`]) or from the XML series of an `OutputDirectory` ([`Record::series`]); a [`Run`] is
//! frames in memory. [`Record::of_others`] reads trajectories of experiments and of other simulators, which have no bodies and
//! no forces. All are exported by [`chaos`], [`pedpy`], [`series`] and `jupedsim`; [`trial_at_end`] is the
//! Trial that continues where a run ended. [`measure`] has what is measured of frames.
//!
//! Features, off by default: `parquet` (tables in Parquet; builds zstd, which is C) and `sqlite` (`jupedsim`; builds
//! SQLite, which is C). Without them, both say so where they are asked for.

mod area;
mod cell;
pub mod columns;
mod error;
#[cfg(feature = "sqlite")]
mod jupedsim;
pub mod measure;
mod number;
mod outlines;
mod record;
mod recorder;
mod run;
mod series;
mod shapes;
mod table;
mod text;
mod trajectories;

pub use area::{
    Area, LEANING, MARGIN, THICKNESS, given_area, given_area_of_heads, measured_area, walkable_area,
};
pub use cell::{Cell, CellType};
pub use error::RecordError;
#[cfg(feature = "sqlite")]
pub use jupedsim::jupedsim;
pub use record::{Record, Trajectories};
pub use recorder::{KeptFrames, Recorder};
pub use run::{Effects, Frame, OfLegs, OfWall, Run, Totals};
pub use series::{series, series_files, series_in, trial_at_end};
pub use table::{FrameWriter, TableContent, TableFormat, TableWriter};
pub use text::{chaos, chaos_files, pedpy};
pub use trajectories::{READ, Told, VELOCITY_OVER, holds_trajectories};

/// As with the feature `sqlite`, without which there is no SQLite.
///
/// # Errors
/// Always.
#[cfg(not(feature = "sqlite"))]
pub fn jupedsim(_: &Record, _: &Area, path: &std::path::Path) -> Result<(), RecordError> {
    Err(RecordError::wrong(path, "this build has no SQLite: build with --features sqlite"))
}
