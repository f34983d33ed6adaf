//! The values on their way between components: numbers, or texts.

use crate::calls::Value;
use crate::error::Result;
use crate::selection::Selection;
use crate::ssp::{Address, Affine};
use crate::system::Component;
use std::collections::HashMap;

/// A connection of single values, by component and address.
#[derive(Clone, Copy)]
pub(crate) struct Wire {
    pub(crate) from: (usize, Address),
    pub(crate) to: (usize, Address),
    /// Conversion of Reals.
    pub(crate) map: Affine,
}

/// The connected variables, by component.
pub(crate) struct Channel<T> {
    outputs: Vec<Outputs<T>>,
    inputs: Vec<Inputs>,
}

/// The connected outputs of a component.
#[derive(Clone, Default)]
struct Outputs<T> {
    addresses: Vec<Address>,
    selection: Selection,
    newest: Vec<T>,
    before: Vec<T>,
}

/// The connected inputs of a component.
#[derive(Clone, Default)]
struct Inputs {
    addresses: Vec<Address>,
    selection: Selection,
    sources: Vec<Source>,
}

/// Which output feeds an input.
#[derive(Clone, Copy)]
struct Source {
    component: usize,
    place: usize,
    map: Affine,
}

impl<T: Value> Channel<T> {
    /// Connects components.
    ///
    /// # Errors
    /// An FMU has no such values.
    pub(crate) fn new<'a>(
        wires: impl Iterator<Item = &'a Wire>,
        components: &[Component],
    ) -> Result<Channel<T>> {
        let mut outputs = vec![Outputs::default(); components.len()];
        let mut inputs = vec![Inputs::default(); components.len()];
        // One output may feed several inputs and is read once.
        let mut places = HashMap::new();
        for wire in wires {
            let Outputs { addresses, newest, .. } = &mut outputs[wire.from.0];
            let place = *places.entry(wire.from).or_insert_with(|| {
                addresses.push(wire.from.1);
                newest.push(T::default());
                addresses.len() - 1
            });
            let inputs = &mut inputs[wire.to.0];
            inputs.addresses.push(wire.to.1);
            inputs.sources.push(Source { component: wire.from.0, place, map: wire.map });
        }
        for ((component, outputs), inputs) in components.iter().zip(&mut outputs).zip(&mut inputs) {
            outputs.selection = component.instance.select_at(&outputs.addresses)?;
            inputs.selection = component.instance.select_at(&inputs.addresses)?;
        }
        Ok(Channel { outputs, inputs })
    }

    /// Reads the outputs of a component; returns whether one is new.
    pub(crate) fn read(&mut self, c: usize, component: &Component) -> Result<bool> {
        let outputs = &mut self.outputs[c];
        if outputs.addresses.is_empty() {
            return Ok(false);
        }
        let first = outputs.before.is_empty();
        outputs.before.clone_from(&outputs.newest);
        component.instance.get(&outputs.selection, &mut outputs.newest)?;
        Ok(first || outputs.before != outputs.newest)
    }

    /// Sets the inputs of a component.
    pub(crate) fn send(&self, c: usize, component: &Component) -> Result<()> {
        let Inputs { selection, sources, .. } = &self.inputs[c];
        if selection.is_empty() {
            return Ok(());
        }
        let value =
            |source: &Source| self.outputs[source.component].newest[source.place].converted(source.map);
        component.instance.set(selection, &sources.iter().map(value).collect::<Vec<T>>())
    }
}
