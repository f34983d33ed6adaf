//! The values on their way between components, of one type.

use crate::calls::Value;
use crate::error::Result;
use crate::instance::Instance;
use crate::selection::Selection;
use crate::ssp::{Address, Affine, Type};
use std::collections::HashMap;

/// A connection of single values, by component and address.
pub(crate) struct Wire {
    pub(crate) from: (usize, Address),
    pub(crate) to: (usize, Address),
    /// Of Reals.
    pub(crate) map: Affine,
}

/// What is done with the connected variables of one type.
pub(crate) trait Exchange {
    /// Adds connections.
    fn connect(&mut self, wires: &[Wire], instances: &[&Instance]) -> Result<()>;
    /// The connections as text.
    fn wiring(&self) -> String;
    /// Whether a connection feeds an input of a component.
    fn feeds(&self, c: usize, address: Address) -> bool;
    /// Reads the outputs of a component; whether one is new.
    fn read(&mut self, c: usize, instance: &Instance) -> Result<bool>;
    /// Sets the inputs of a component.
    fn send(&mut self, c: usize, instance: &Instance) -> Result<()>;
}

/// One channel for each type that is connected, in the order of [`channel_of`].
pub(crate) fn channels(components: usize) -> [Box<dyn Exchange>; 4] {
    [
        Box::new(Channel::<f64>::new(components)),
        Box::new(Channel::<i32>::new(components)),
        Box::new(Channel::<bool>::new(components)),
        Box::new(Channel::<String>::new(components)),
    ]
}

/// The place of a type's channel; `None` of types that are not connected.
pub(crate) fn channel_of(of: &Type) -> Option<usize> {
    match of {
        Type::Real(_) => Some(0),
        Type::Integer => Some(1),
        Type::Boolean => Some(2),
        Type::String => Some(3),
        Type::Enumeration(_) | Type::Binary | Type::Clock => None,
    }
}

/// The connected variables of one type, by component.
struct Channel<T> {
    outputs: Vec<Outputs<T>>,
    inputs: Vec<Inputs<T>>,
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
struct Inputs<T> {
    addresses: Vec<Address>,
    selection: Selection,
    places: HashMap<Address, usize>,
    sources: Vec<Source>,
    values: Vec<T>,
}

/// Which output feeds an input.
#[derive(Clone, Copy)]
struct Source {
    component: usize,
    place: usize,
    map: Affine,
}

impl<T: Value> Channel<T> {
    fn new(components: usize) -> Channel<T> {
        Channel { outputs: vec![Outputs::default(); components], inputs: vec![Inputs::default(); components] }
    }
}

impl<T: Value> Exchange for Channel<T> {
    fn connect(&mut self, wires: &[Wire], instances: &[&Instance]) -> Result<()> {
        // One output may feed several inputs and is read once.
        let mut places = HashMap::new();
        for wire in wires {
            let outputs = &mut self.outputs[wire.from.0];
            let place = *places.entry(wire.from).or_insert_with(|| {
                outputs.addresses.push(wire.from.1);
                outputs.newest.push(T::default());
                outputs.addresses.len() - 1
            });
            let inputs = &mut self.inputs[wire.to.0];
            inputs.places.insert(wire.to.1, inputs.addresses.len());
            inputs.addresses.push(wire.to.1);
            inputs.sources.push(Source { component: wire.from.0, place, map: wire.map });
        }
        for ((instance, outputs), inputs) in instances.iter().zip(&mut self.outputs).zip(&mut self.inputs) {
            outputs.selection = instance.select_at(&outputs.addresses)?;
            inputs.selection = instance.select_at(&inputs.addresses)?;
        }
        Ok(())
    }

    fn wiring(&self) -> String {
        let inputs = self.inputs.iter().enumerate().flat_map(|(c, inputs)| {
            let ends = inputs.addresses.iter().zip(&inputs.sources);
            ends.map(move |(to, source)| (c, *to, source))
        });
        let lines = inputs.map(|(c, to, source)| {
            let from = self.outputs[source.component].addresses[source.place];
            format!("{}.{from} -> {c}.{to} {:?}", source.component, source.map)
        });
        let mut lines: Vec<String> = lines.collect();
        lines.sort_unstable();
        lines.join(" ")
    }

    fn feeds(&self, c: usize, address: Address) -> bool {
        self.inputs[c].places.contains_key(&address)
    }

    fn read(&mut self, c: usize, instance: &Instance) -> Result<bool> {
        let outputs = &mut self.outputs[c];
        if outputs.addresses.is_empty() {
            return Ok(false);
        }
        let first = outputs.before.is_empty();
        outputs.before.clone_from(&outputs.newest);
        instance.get(&outputs.selection, &mut outputs.newest)?;
        Ok(first || outputs.before != outputs.newest)
    }

    fn send(&mut self, c: usize, instance: &Instance) -> Result<()> {
        let Inputs { selection, sources, values, .. } = &mut self.inputs[c];
        if selection.is_empty() {
            return Ok(());
        }
        values.clear();
        let outputs = &self.outputs;
        values.extend(
            sources.iter().map(|source| outputs[source.component].newest[source.place].converted(source.map)),
        );
        instance.set(selection, values)
    }
}
