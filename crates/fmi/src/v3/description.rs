//! `modelDescription.xml` of FMI 3.0, from the table of arrays.

use super::arrays::{Array, ArrayModel, Dependency, Dimension, TIME, array_reference, size_reference, token};
use crate::boundary::LOG_CATEGORIES;
use crate::units::{units_of, write_unit};
use crate::variables::units::SECOND;
use crate::variables::{Kind, Role};
use lemons_core::xml::{Layout, Out, number};

/// The start value of a variable.
#[derive(Debug, Clone, PartialEq)]
pub enum Start {
    /// Of each element; where all are equal, one value is written.
    Numbers(Vec<f64>),
    /// Of each element.
    Texts(Vec<String>),
}

/// The content of a model description.
pub struct Description<'a, B> {
    /// `modelName`
    pub model_name: &'a str,
    /// `modelIdentifier`: the stem of the binaries' names.
    pub model_identifier: &'a str,
    /// Description for users.
    pub description: &'a str,
    /// Whether the model knows derivatives of outputs.
    pub knows_derivatives: bool,
    /// Whether the model can show values within a step.
    pub shows_intermediate_values: bool,
    /// \[s\] `DefaultExperiment.stopTime`; the start time is 0.
    pub stop_time: f64,
    /// \[s\] `DefaultExperiment.stepSize`
    pub step_size: f64,
    /// The values of the structural parameters.
    pub sizes: &'a [u64],
    /// Returns the start value of an array; `None` if it is computed.
    pub start: &'a dyn Fn(B) -> Option<Start>,
    /// Returns the inputs on which an output depends at a communication point.
    pub dependencies: &'a dyn Fn(B) -> Vec<Dependency<B>>,
    /// Returns the inputs and parameters on which a computed output depends in initialization.
    pub initial_dependencies: &'a dyn Fn(B) -> Vec<Dependency<B>>,
}

impl<B: Copy + PartialEq> Description<'_, B> {
    /// As XML.
    pub fn xml<M: ArrayModel<Block = B>>(&self) -> String {
        let arrays = M::arrays();
        let root = [
            ("fmiVersion", "3.0"),
            ("modelName", self.model_name),
            ("instantiationToken", &token::<M>().braced().to_string()),
            ("description", self.description),
            ("version", env!("CARGO_PKG_VERSION")),
            ("license", "MIT OR Apache-2.0"),
            ("generationTool", concat!("LEMONS-FMU ", env!("CARGO_PKG_VERSION"))),
            ("variableNamingConvention", "structured"),
        ];
        Out::document(Layout::STANDARD, "fmiModelDescription", &root, |out| {
            self.write_co_simulation(out);
            out.element("UnitDefinitions", &[], |out| {
                let kinds = [Kind::Real(SECOND)].into_iter().chain(arrays.iter().map(|array| array.kind));
                units_of(kinds).iter().for_each(|unit| write_unit(out, unit));
            });
            out.element("LogCategories", &[], |out| {
                for (name, description) in LOG_CATEGORIES {
                    out.empty("Category", &[("name", name), ("description", description)]);
                }
            });
            let (stop, step) = (number(self.stop_time), number(self.step_size));
            let times = [("startTime", &number(0.0)[..]), ("stopTime", &stop), ("stepSize", &step)];
            out.empty("DefaultExperiment", &times);
            out.element("ModelVariables", &[], |out| {
                write_time(out);
                for (place, (size, value)) in M::SIZES.iter().zip(self.sizes).enumerate() {
                    write_size(out, place, size.name, size.description, *value);
                }
                for (place, array) in arrays.iter().enumerate() {
                    self.write_array(out, array_reference::<M>(place), array);
                }
            });
            out.element("ModelStructure", &[], |out| self.write_structure::<M>(out, &arrays));
        })
    }

    fn write_co_simulation(&self, out: &mut Out) {
        let mut attributes = vec![
            ("modelIdentifier", self.model_identifier),
            ("canHandleVariableCommunicationStepSize", "true"),
            ("canGetAndSetFMUState", "true"),
            ("canSerializeFMUState", "true"),
            ("providesPerElementDependencies", "true"),
        ];
        if self.knows_derivatives {
            attributes.push(("maxOutputDerivativeOrder", "1"));
        }
        if self.shows_intermediate_values {
            for flag in ["providesIntermediateUpdate", "canReturnEarlyAfterIntermediateUpdate"] {
                attributes.push((flag, "true"));
            }
        }
        out.empty("CoSimulation", &attributes);
    }

    fn write_array(&self, out: &mut Out, reference: u32, array: &Array<B>) {
        let (causality, initial) = match array.role {
            Role::Input => ("input", None),
            Role::Exact => ("output", Some("exact")),
            Role::Calculated => ("output", Some("calculated")),
            Role::Parameter => ("parameter", Some("exact")),
            Role::CalculatedParameter => ("calculatedParameter", Some("calculated")),
        };
        let variability = match (array.role, array.kind) {
            (Role::Parameter | Role::CalculatedParameter, _) => "fixed",
            (_, Kind::Real(_)) => "continuous",
            _ => "discrete",
        };
        let reference = reference.to_string();
        let mut attributes = vec![
            ("name", array.name),
            ("valueReference", &reference[..]),
            ("description", array.description),
            ("causality", causality),
            ("variability", variability),
        ];
        attributes.extend(initial.map(|initial| ("initial", initial)));
        let element = match array.kind {
            Kind::Real(unit) => {
                attributes.push(("unit", unit.name));
                "Float64"
            }
            Kind::Integer => "Int32",
            Kind::Boolean => "Boolean",
            Kind::String => "String",
        };
        let (start, texts) = match (self.start)(array.block) {
            None => (None, Vec::new()),
            Some(Start::Texts(texts)) => (None, texts),
            Some(Start::Numbers(values)) => (Some(compact(&values, array.kind)), Vec::new()),
        };
        attributes.extend(start.as_deref().map(|start| ("start", start)));
        if array.dimensions.is_empty() && texts.is_empty() {
            return out.empty(element, &attributes);
        }
        out.element(element, &attributes, |out| {
            for dimension in array.dimensions {
                match dimension {
                    Dimension::Fixed(size) => out.empty("Dimension", &[("start", &size.to_string())]),
                    Dimension::Size(place) => {
                        let reference = size_reference(*place).to_string();
                        out.empty("Dimension", &[("valueReference", &reference)]);
                    }
                }
            }
            texts.iter().for_each(|text| out.empty("Start", &[("value", text)]));
        });
    }

    fn write_structure<M: ArrayModel<Block = B>>(&self, out: &mut Out, arrays: &[Array<B>]) {
        let reference_of = |block: B| {
            let place = arrays.iter().position(|array| array.block == block);
            place.map(array_reference::<M>)
        };
        let mut write = |name: &str, place: usize, dependencies: Vec<Dependency<B>>| {
            let on = dependencies.into_iter().map(|dependency| dependency.on);
            // Many elements depend on the same few arrays.
            let mut blocks: Vec<B> = Vec::new();
            on.for_each(|block| {
                if !blocks.contains(&block) {
                    blocks.push(block);
                }
            });
            let mut references: Vec<u32> = blocks.into_iter().filter_map(reference_of).collect();
            references.sort_unstable();
            let references: Vec<String> = references.iter().map(u32::to_string).collect();
            let (own, on) = (array_reference::<M>(place).to_string(), references.join(" "));
            out.empty(name, &[("valueReference", &own), ("dependencies", &on)]);
        };
        for (place, array) in arrays.iter().enumerate() {
            if matches!(array.role, Role::Exact | Role::Calculated) {
                write("Output", place, (self.dependencies)(array.block));
            }
        }
        for (place, array) in arrays.iter().enumerate() {
            if matches!(array.role, Role::Calculated | Role::CalculatedParameter) {
                write("InitialUnknown", place, (self.initial_dependencies)(array.block));
            }
        }
    }
}

fn write_time(out: &mut Out) {
    let attributes = [
        ("name", "time"),
        ("valueReference", &TIME.to_string()[..]),
        ("description", "simulation time"),
        ("causality", "independent"),
        ("variability", "continuous"),
        ("unit", SECOND.name),
    ];
    out.empty("Float64", &attributes);
}

fn write_size(out: &mut Out, place: usize, name: &str, description: &str, value: u64) {
    let attributes = [
        ("name", name),
        ("valueReference", &size_reference(place).to_string()[..]),
        ("description", description),
        ("causality", "structuralParameter"),
        ("variability", "fixed"),
        ("start", &value.to_string()),
    ];
    out.empty("UInt64", &attributes);
}

/// The values as a list; one value where all are equal.
fn compact(values: &[f64], kind: Kind) -> String {
    let written = |value: &f64| match kind {
        Kind::Integer => format!("{value:.0}"),
        Kind::Boolean => (*value != 0.0).to_string(),
        _ => number(*value),
    };
    match values {
        [first, rest @ ..] if rest.iter().all(|value| value.to_bits() == first.to_bits()) => written(first),
        _ => values.iter().map(written).collect::<Vec<String>>().join(" "),
    }
}
