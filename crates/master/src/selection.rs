//! Single values that are read or set together.
//!
//! An FMU 2.0 has a value for each type and reference. An FMU 3.0 has arrays, which are read and set whole, by one call for all of
//! one type: which of their elements are meant is found out once, not at each communication point.

use crate::error::{Error, Result};
use crate::ssp::{Address, Fmi, Interface, Type};
use std::collections::HashMap;

/// Single values of an instance that are read or set together, in an order.
#[derive(Debug, Clone, Default)]
pub struct Selection {
    /// One for each type.
    parts: Vec<Part>,
    count: usize,
}

/// The values that one call reads or sets.
#[derive(Debug, Clone, Default)]
pub(crate) struct Part {
    pub(crate) of: Type,
    pub(crate) references: Vec<u32>,
    /// The number of values of the call.
    length: usize,
    /// From the selected values to their places among those of the call; `None` if they are the same.
    places: Option<Vec<Place>>,
    /// True if each value of the call is a selected one.
    whole: bool,
    /// True if an array is among the variables.
    arrays: bool,
}

/// A selected value, and which of the call's it is.
#[derive(Debug, Clone, Copy)]
struct Place {
    selected: u32,
    of_call: u32,
}

impl Selection {
    /// Makes the selection of values by their addresses.
    ///
    /// # Errors
    /// The FMU has no such value.
    pub(crate) fn new(interface: &Interface, addresses: &[Address]) -> Result<Selection> {
        let count = addresses.len();
        let mut parts: Vec<Part> = Vec::new();
        let mut places: Vec<Vec<Place>> = Vec::new();
        // Where the values of a variable begin, in which part.
        let mut begins: HashMap<(Type, u32), (usize, usize)> = HashMap::new();
        for (selected, &Address { of, reference, element }) in (0..).zip(addresses) {
            let (at, begin) = match begins.get(&(of, reference)) {
                Some(known) => *known,
                None => {
                    // In FMI 2.0 each variable is a single value.
                    let (values, array) = if interface.fmi == Fmi::V2 {
                        (1, false)
                    } else {
                        let variable = interface.referenced(reference);
                        let variable = variable.ok_or_else(|| no_reference(reference))?;
                        (variable.count(), variable.is_array())
                    };
                    let at = parts.iter().position(|part| part.of == of).unwrap_or_else(|| {
                        parts.push(Part { of, ..Part::default() });
                        places.push(Vec::new());
                        parts.len() - 1
                    });
                    let part = &mut parts[at];
                    let begin = part.length;
                    part.references.push(reference);
                    part.length += values;
                    part.arrays |= array;
                    begins.insert((of, reference), (at, begin));
                    (at, begin)
                }
            };
            let of_call = begin + element.unwrap_or(0) as usize;
            if of_call >= parts[at].length {
                return Err(no_reference(reference));
            }
            places[at].push(Place { selected, of_call: of_call as u32 });
        }
        for (part, places) in parts.iter_mut().zip(places) {
            let mut there = vec![false; part.length];
            places.iter().for_each(|place| there[place.of_call as usize] = true);
            part.whole = there.iter().all(|there| *there);
            let same = places.len() == part.length && places.len() == count;
            let same = same && places.iter().all(|place| place.selected == place.of_call);
            part.places = (!same).then_some(places);
        }
        Ok(Selection { parts, count })
    }

    /// Returns the number of values.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Returns whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns whether an array is among the variables.
    pub(crate) fn has_arrays(&self) -> bool {
        self.parts.iter().any(|part| part.arrays)
    }

    /// Reads the values by a call for each part.
    pub(crate) fn read<T: Clone + Default>(
        &self,
        values: &mut [T],
        mut get: impl FnMut(&Part, &mut [T]) -> Result<()>,
    ) -> Result<()> {
        assert_eq!(self.count, values.len(), "a value for each that is selected");
        for part in &self.parts {
            let Some(places) = &part.places else {
                get(part, values)?;
                continue;
            };
            let mut all = vec![T::default(); part.length];
            get(part, &mut all)?;
            for place in places {
                values[place.selected as usize].clone_from(&all[place.of_call as usize]);
            }
        }
        Ok(())
    }

    /// Sets the values by a call for each part. Arrays of which only some elements are selected are read before.
    pub(crate) fn write<T: Clone + Default>(
        &self,
        values: &[T],
        mut get: impl FnMut(&Part, &mut [T]) -> Result<()>,
        mut set: impl FnMut(&Part, &[T]) -> Result<()>,
    ) -> Result<()> {
        assert_eq!(self.count, values.len(), "a value for each that is selected");
        for part in &self.parts {
            let Some(places) = &part.places else {
                set(part, values)?;
                continue;
            };
            let mut all = vec![T::default(); part.length];
            if !part.whole {
                get(part, &mut all)?;
            }
            for place in places {
                all[place.of_call as usize].clone_from(&values[place.selected as usize]);
            }
            set(part, &all)?;
        }
        Ok(())
    }
}

fn no_reference(reference: u32) -> Error {
    let what = "the FMU has no variable with the value reference";
    Error::new(format!("{what} {reference}, or not so many values in it"))
}
