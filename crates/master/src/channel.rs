//! The values on their way between components: numbers, or texts.

use crate::calls::{Instance, Value};
use crate::error::Result;
use crate::instance::Selection;
use crate::ssp::{Affine, Single, Type};
use std::collections::BTreeMap;

/// A connection of single values, each with the place of its component.
#[derive(Clone, Copy)]
pub(crate) struct Wire<'a> {
    pub(crate) from: (usize, Single<'a>),
    pub(crate) to: (usize, Single<'a>),
    /// Conversion of Reals.
    pub(crate) map: Affine,
}

/// The connections from one component to another, or to itself.
pub(crate) struct Channel {
    pub(crate) from: usize,
    pub(crate) to: usize,
    /// True if an input has the name of the output that feeds it.
    pub(crate) alike: bool,
    numbers: Values<f64>,
    texts: Values<String>,
}

/// Connected values of one kind.
struct Values<T> {
    outputs: Selection,
    inputs: Selection,
    maps: Vec<Affine>,
    /// Of the outputs.
    newest: Vec<T>,
}

impl Channel {
    /// Makes the channels of all connections.
    pub(crate) fn of(wires: &[Wire]) -> Vec<Channel> {
        let mut all: BTreeMap<(usize, usize), Vec<Wire>> = BTreeMap::new();
        for wire in wires {
            all.entry((wire.from.0, wire.to.0)).or_default().push(*wire);
        }
        let channel = |((from, to), wires): ((usize, usize), Vec<Wire>)| {
            let is_text = |wire: &Wire| wire.from.1.variable.of == Type::String;
            let alike = wires.iter().any(|wire| wire.from.1.variable.name == wire.to.1.variable.name);
            let (texts, numbers): (Vec<Wire>, Vec<Wire>) = wires.into_iter().partition(is_text);
            Channel { from, to, alike, numbers: Values::new(&numbers), texts: Values::new(&texts) }
        };
        all.into_iter().map(channel).collect()
    }

    /// Reads the outputs; returns whether one is new.
    pub(crate) fn read(&mut self, from: &Instance) -> Result<bool> {
        Ok(self.numbers.read(from)? | self.texts.read(from)?)
    }

    /// Sets the inputs.
    pub(crate) fn send(&self, to: &Instance) -> Result<()> {
        self.numbers.send(to)?;
        self.texts.send(to)
    }
}

impl<T: Value> Values<T> {
    fn new(wires: &[Wire]) -> Values<T> {
        Values {
            outputs: Selection::new(wires.iter().map(|wire| wire.from.1)),
            inputs: Selection::new(wires.iter().map(|wire| wire.to.1)),
            maps: wires.iter().map(|wire| wire.map).collect(),
            newest: Vec::new(),
        }
    }

    fn read(&mut self, from: &Instance) -> Result<bool> {
        let before = std::mem::replace(&mut self.newest, from.values(&self.outputs)?);
        Ok(before != self.newest)
    }

    fn send(&self, to: &Instance) -> Result<()> {
        let sent = self.newest.iter().zip(&self.maps).map(|(value, map)| value.converted(*map));
        to.set(&self.inputs, &sent.collect::<Vec<T>>())
    }
}
