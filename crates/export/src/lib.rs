//! Runs of crowds in the formats that the field's tools read, and the way back to a Trial.
//!
//! A [`Record`] is the table of `lemons run` ([`Record::table`]) or the XML series of an `OutputDirectory`
//! ([`Record::series`]), read frame by frame; a [`Run`] is frames of it in memory. It goes to [`jupedsim`], [`pedpy`],
//! [`chaos`] or [`series`]; [`trial_at_end`] is the Trial that goes on where it ended.

mod area;
mod error;
mod jupedsim;
mod parquet;
mod record;
mod rows;
mod run;
mod series;
mod table;
mod text;

pub use area::{Area, MARGIN, THICKNESS, given_area, walkable_area};
pub use error::ExportError;
pub use jupedsim::jupedsim;
pub use record::{Positions, Record};
pub use run::{Frame, Names, Observed, OfStep, Run};
pub use series::{series, series_files, trial_at_end};
pub use text::{chaos, chaos_files, pedpy};
