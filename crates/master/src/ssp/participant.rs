//! FMUs to connect, and their values as the ends of connections.

use crate::ssp::interface::{Interface, Single};
use crate::ssp::terminals::Terminal;

/// An FMU to connect.
pub struct Participant<'a> {
    /// The component's.
    pub name: String,
    /// Where the archive holds the FMU.
    pub source: String,
    /// Its variables.
    pub interface: &'a Interface,
    /// Its terminals.
    pub terminals: Vec<Terminal>,
}

/// A value of the participant at a place.
pub(super) type End<'a> = (usize, Single<'a>);

/// Returns whose variable it is of, and the name of that.
pub(super) fn owner<'a>((participant, single): &End<'a>) -> (usize, &'a str) {
    (*participant, &single.variable.name)
}

/// Two ends to be connected: single values, or arrays as a whole.
pub(super) struct EndPair<'a> {
    pub(super) from: End<'a>,
    pub(super) to: End<'a>,
    pub(super) whole: bool,
    pub(super) name: String,
}
