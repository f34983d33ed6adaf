//! The values on their way between components, of one type.

use crate::error::{Error, Result};
use crate::instance::Instance;
use crate::selection::Selection;
use lemons_ssp::{Address, Affine};
use std::collections::HashMap;

/// A connection of single values, by component and address.
pub(crate) struct Wire {
    pub(crate) from: (usize, Address),
    pub(crate) to: (usize, Address),
    /// Of Reals.
    pub(crate) map: Affine,
}

/// The FMI functions of a type.
pub(crate) trait Signal {
    type Value: Clone + Default + PartialEq;
    fn get(instance: &Instance, selection: &Selection, values: &mut [Self::Value]) -> Result<()>;
    fn set(instance: &Instance, selection: &Selection, values: &[Self::Value]) -> Result<()>;
    /// What arrives of a value that is sent, with what is added there.
    fn arrive(value: &Self::Value, _: &Source) -> Self::Value {
        value.clone()
    }
}

pub(crate) struct Reals;
pub(crate) struct Integers;
pub(crate) struct Booleans;
pub(crate) struct Strings;

impl Signal for Reals {
    type Value = f64;
    fn get(instance: &Instance, selection: &Selection, values: &mut [f64]) -> Result<()> {
        instance.get_real(selection, values)
    }
    fn set(instance: &Instance, selection: &Selection, values: &[f64]) -> Result<()> {
        instance.set_real(selection, values)
    }
    fn arrive(value: &f64, source: &Source) -> f64 {
        let value = source.map.apply(*value);
        // -0 stays -0.
        if source.added == 0.0 { value } else { value + source.added }
    }
}

impl Signal for Integers {
    type Value = i32;
    fn get(instance: &Instance, selection: &Selection, values: &mut [i32]) -> Result<()> {
        instance.get_integer(selection, values)
    }
    fn set(instance: &Instance, selection: &Selection, values: &[i32]) -> Result<()> {
        instance.set_integer(selection, values)
    }
}

impl Signal for Booleans {
    type Value = i32;
    fn get(instance: &Instance, selection: &Selection, values: &mut [i32]) -> Result<()> {
        instance.get_boolean(selection, values)
    }
    fn set(instance: &Instance, selection: &Selection, values: &[i32]) -> Result<()> {
        instance.set_boolean(selection, values)
    }
}

impl Signal for Strings {
    type Value = String;
    fn get(instance: &Instance, selection: &Selection, values: &mut [String]) -> Result<()> {
        instance.get_string(selection, values)
    }
    fn set(instance: &Instance, selection: &Selection, values: &[String]) -> Result<()> {
        let values: Vec<&str> = values.iter().map(String::as_str).collect();
        instance.set_string(selection, &values)
    }
}

/// The connected variables of one type, by component.
pub(crate) struct Channel<S: Signal> {
    outputs: Vec<Outputs<S::Value>>,
    inputs: Vec<Inputs<S::Value>>,
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
pub(crate) struct Source {
    component: usize,
    place: usize,
    map: Affine,
    /// Of Reals, from elsewhere.
    added: f64,
}

impl<S: Signal> Channel<S> {
    pub(crate) fn new(components: usize) -> Channel<S> {
        Channel { outputs: vec![Outputs::default(); components], inputs: vec![Inputs::default(); components] }
    }

    pub(crate) fn connect(&mut self, wires: &[Wire], instances: &[&Instance]) -> Result<()> {
        // One output may feed several inputs and is read once.
        let mut places = HashMap::new();
        for wire in wires {
            let outputs = &mut self.outputs[wire.from.0];
            let place = *places.entry(wire.from).or_insert_with(|| {
                outputs.addresses.push(wire.from.1);
                outputs.newest.push(S::Value::default());
                outputs.addresses.len() - 1
            });
            let inputs = &mut self.inputs[wire.to.0];
            inputs.places.insert(wire.to.1, inputs.addresses.len());
            inputs.addresses.push(wire.to.1);
            inputs.sources.push(Source { component: wire.from.0, place, map: wire.map, added: 0.0 });
        }
        for ((instance, outputs), inputs) in instances.iter().zip(&mut self.outputs).zip(&mut self.inputs) {
            outputs.selection = instance.select_at(&outputs.addresses)?;
            inputs.selection = instance.select_at(&inputs.addresses)?;
        }
        Ok(())
    }

    /// The values: those of a former run must not pass for values that have been sent.
    pub(crate) fn forget(&mut self) {
        self.inputs.iter_mut().flat_map(|inputs| &mut inputs.sources).for_each(|source| source.added = 0.0);
        for outputs in &mut self.outputs {
            outputs.newest.fill(S::Value::default());
            outputs.before.clear();
        }
    }

    pub(crate) fn wiring(&self) -> String {
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

    pub(crate) fn feeds(&self, c: usize, address: Address) -> bool {
        self.inputs[c].places.contains_key(&address)
    }

    pub(crate) fn read(&mut self, c: usize, instance: &Instance) -> Result<bool> {
        let outputs = &mut self.outputs[c];
        if outputs.addresses.is_empty() {
            return Ok(false);
        }
        let first = outputs.before.is_empty();
        outputs.before.clone_from(&outputs.newest);
        S::get(instance, &outputs.selection, &mut outputs.newest)?;
        Ok(first || outputs.before != outputs.newest)
    }

    pub(crate) fn send(&mut self, c: usize, instance: &Instance) -> Result<()> {
        let Inputs { selection, sources, values, .. } = &mut self.inputs[c];
        if selection.is_empty() {
            return Ok(());
        }
        values.clear();
        let outputs = &self.outputs;
        values.extend(
            sources.iter().map(|source| S::arrive(&outputs[source.component].newest[source.place], source)),
        );
        S::set(instance, selection, values)
    }
}

impl Channel<Reals> {
    /// Adds values to what arrives at inputs of a component, until others are given.
    ///
    /// # Errors
    /// Nothing feeds one of these inputs.
    pub(crate) fn add(&mut self, c: usize, addresses: &[Address], values: &[f64]) -> Result<()> {
        let Inputs { places, sources, .. } = &mut self.inputs[c];
        for (address, value) in addresses.iter().zip(values) {
            let place = places.get(address).ok_or(Error::NoReference(address.reference))?;
            sources[*place].added = *value;
        }
        Ok(())
    }
}
