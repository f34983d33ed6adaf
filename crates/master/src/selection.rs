//! Single values that are read or set together.
//!
//! An FMU 2.0 has a value for each type and reference. An FMU 3.0 has arrays, which are read and set whole, by one call for all of
//! one type: which of their elements are meant is found out once, not at each communication point.

use crate::ssp::{Single, Type};
use std::collections::{HashMap, HashSet};

/// Single values of an instance that are read or set together, in an order.
#[derive(Debug, Clone, Default)]
pub struct Selection {
    /// One for each type.
    pub(crate) parts: Vec<Part>,
    /// The part of each value, and its place among the values of the part's call.
    pub(crate) places: Vec<(usize, usize)>,
    /// True if the values are those of one call, in its order.
    pub(crate) is_one_call: bool,
}

/// The values that one call reads or sets.
#[derive(Debug, Clone, Default)]
pub(crate) struct Part {
    pub(crate) of: Type,
    pub(crate) references: Vec<u32>,
    /// The number of values of the call.
    pub(crate) length: usize,
    /// True if each value of the call is a selected one.
    pub(crate) whole: bool,
    /// True if an array is among the variables.
    arrays: bool,
}

impl Selection {
    pub(crate) fn new<'a>(values: impl IntoIterator<Item = Single<'a>>) -> Selection {
        let (mut parts, mut places) = (Vec::<Part>::new(), Vec::new());
        // The part in which the values of a variable are, and where they begin.
        let mut begins: HashMap<(Type, u32), (usize, usize)> = HashMap::new();
        for Single { variable, element } in values {
            let of = variable.of;
            let (at, begin) = *begins.entry((of, variable.reference)).or_insert_with(|| {
                let at = parts.iter().position(|part| part.of == of).unwrap_or_else(|| {
                    parts.push(Part { of, ..Part::default() });
                    parts.len() - 1
                });
                let part = &mut parts[at];
                let begin = part.length;
                part.references.push(variable.reference);
                part.length += variable.count();
                part.arrays |= variable.is_array();
                (at, begin)
            });
            places.push((at, begin + element));
        }
        let selected: HashSet<&(usize, usize)> = places.iter().collect();
        for (at, part) in parts.iter_mut().enumerate() {
            part.whole = (0..part.length).all(|place| selected.contains(&(at, place)));
        }
        let in_order = places.iter().enumerate().all(|(k, place)| *place == (0, k));
        let is_one_call = in_order && parts.first().is_some_and(|part| part.length == places.len());
        Selection { parts, places, is_one_call }
    }

    /// Returns the number of values.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Returns whether there are none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Returns whether an array is among the variables.
    pub(crate) fn has_arrays(&self) -> bool {
        self.parts.iter().any(|part| part.arrays)
    }
}
