//! The report of the runs of a scenario: what it contains, and how its numbers are computed.
//!
//! Runs are [seen](RunSeen::run) one communication point after the other and reduced as they come, by the measures of
//! [`lemons_results::measure`]. [`Report::of`] makes sections of them: sentences with ids, rows, pictures as SVG. The command
//! writes these as [HTML](html) or [PDF](pdf); the page of the lab shows them in its own words.

mod contents;
mod html;
mod pdf;
mod seen;
pub mod sentences;

pub use contents::Told;
pub use html::html;
pub use lemons_results::measure::LIMIT;
pub use pdf::pdf;
pub use seen::{Moment, RunSeen, Settings};
pub use sentences::ALL as SENTENCES;

use lemons_core::message::Message;
use serde::Serialize;

/// Why a run cannot be made.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the sources say it
pub enum ReportError {
    #[error(transparent)]
    Simulation(#[from] lemons_sim::SimError),
    #[error(transparent)]
    Nobody(#[from] lemons_sim::stop::NobodyLeaves),
    #[error(transparent)]
    Clock(#[from] lemons_sim::ClockError),
    #[error("walls: {0}")]
    Panels(String),
}

/// A report: sections in their order.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Report {
    /// Name of the scenario.
    pub title: String,
    /// Notes of what must not be overlooked: before everything else.
    #[cfg_attr(feature = "typescript", ts(type = "Message[]"))]
    pub notices: Vec<Message>,
    /// The sections.
    pub sections: Vec<Section>,
}

/// A section.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Section {
    /// Its heading.
    #[cfg_attr(feature = "typescript", ts(type = "Message"))]
    pub heading: Message,
    /// Its parts.
    pub blocks: Vec<Block>,
}

/// A part of a section.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Block {
    /// A paragraph.
    Text {
        /// What it says.
        #[cfg_attr(feature = "typescript", ts(type = "Message"))]
        text: Message,
    },
    /// Sentences, one below the other.
    List {
        /// The sentences.
        #[cfg_attr(feature = "typescript", ts(type = "Message[]"))]
        items: Vec<Message>,
    },
    /// A table. The first cell of a row is its heading.
    Table {
        /// What it shows.
        #[cfg_attr(feature = "typescript", ts(type = "Message"))]
        caption: Message,
        /// Headings of its columns; none: a name and a value in each row.
        #[cfg_attr(feature = "typescript", ts(type = "Message[]"))]
        head: Vec<Message>,
        /// Its rows, all of one length.
        #[cfg_attr(feature = "typescript", ts(type = "Message[][]"))]
        rows: Vec<Vec<Message>>,
        /// Of each column whether it has numbers.
        numbers: Vec<bool>,
    },
    /// A picture.
    Picture {
        /// What it shows.
        #[cfg_attr(feature = "typescript", ts(type = "Message"))]
        caption: Message,
        /// The picture.
        svg: String,
    },
}

impl Block {
    /// Makes a table.
    fn table(caption: Message, head: Vec<Message>, rows: Vec<Vec<Message>>) -> Block {
        let is_number = |cell: &Message| {
            // An interval is one, too.
            let known = cell.id.is_empty() || cell.id == sentences::TO.id;
            known && cell.text.replace(" to ", "").chars().all(|c| "0123456789.-– ".contains(c))
        };
        let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
        let numbers = |k: usize| k > 0 && !head.is_empty() && rows.iter().all(|row| is_number(&row[k]));
        let numbers = (0..columns).map(numbers).collect();
        Block::Table { caption, head, rows, numbers }
    }
}
