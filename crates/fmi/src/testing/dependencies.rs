//! Compares the dependencies that a model declares with what moves when a known number is changed.

use crate::variables::{Dimension, Known, Role, Variable, VariableType};
use crate::{FmuFormat, Model, Phase, Slave, description, instantiation_token, reference};
use std::collections::{BTreeSet, HashMap};

/// Names of variables of FMI 3.0: what is computed, and on what it depends.
pub type Pairs = BTreeSet<(&'static str, &'static str)>;

/// The elements of an array of a model.
pub(super) fn length<M: Model>(model: &M, variable: &Variable<M::Quantity>) -> usize {
    let of = |dimension: &Dimension| match *dimension {
        Dimension::Fixed(size) => size,
        Dimension::Size(place) => model.size(place),
    };
    variable.dimensions.iter().map(of).product::<u64>() as usize
}

/// The dependencies in a model description: of each unknown of a kind, by an attribute of it; none is "on all".
fn declared(xml: &str, element: &str, key: &str) -> HashMap<usize, Option<BTreeSet<usize>>> {
    let attribute = |tag: &str, name: &str| {
        let rest = &tag[tag.find(&format!(" {name}=\""))? + name.len() + 3..];
        Some(rest[..rest.find('"')?].to_owned())
    };
    let numbers = |text: String| text.split_whitespace().map(|number| number.parse().unwrap()).collect();
    xml.split('<')
        .filter(|tag| tag.starts_with(&format!("{element} ")))
        .map(|tag| {
            let unknown = attribute(tag, key).unwrap().parse().unwrap();
            (unknown, attribute(tag, "dependencies").map(numbers))
        })
        .collect()
}

/// Changes each number that is known in a phase, and asserts that all that moves is declared to depend on it: in the
/// descriptions of FMI 2.0 and 3.0, and by `fmi3GetVariableDependencies`. Returns what moved. All numbers are as before
/// in the end.
pub fn moved<M: Model>(make: impl Fn() -> M, known: Known) -> Pairs {
    let mut model = make();
    let phase = if known == Known::Starts { Phase::Initialization } else { Phase::StepComplete };
    let is_unknown = |role: Role| match known {
        Known::Starts => matches!(role, Role::Calculated | Role::CalculatedParameter),
        Known::Inputs => matches!(role, Role::Calculated | Role::Exact),
    };
    let kind = if known == Known::Starts { "InitialUnknown" } else { "Output" };
    let [xml2, xml3] = [FmuFormat::default(), FmuFormat::Fmi3].map(|format| {
        description::model_description(&mut model, format).unwrap_or_else(|why| panic!("{why}"))
    });
    let list = &xml2[xml2.find(&format!("<{kind}s>")).unwrap()..xml2.find(&format!("</{kind}s>")).unwrap()];
    let (of_scalars, of_arrays) =
        (declared(list, "Unknown", "index"), declared(&xml3, kind, "valueReference"));
    let scalars = model.scalars();
    let place = |quantity: M::Quantity, element: usize| {
        let is_it =
            |of: &crate::variables::Scalar<_>| of.variable.quantity == quantity && of.element == element;
        scalars.iter().position(is_it).map(|place| place + 1)
    };
    let token = instantiation_token::<M>().to_string();
    let slave = Slave::new(make(), crate::Version::V3, &token).unwrap_or_else(|why| panic!("{why}"));
    let number_of = |variable: &&Variable<M::Quantity>| variable.kind != VariableType::String;
    let unknowns: Vec<_> =
        M::VARIABLES.iter().filter(|variable| is_unknown(variable.role)).filter(number_of).collect();
    let read = |model: &mut M| {
        let all = unknowns.iter().map(|variable| {
            let mut values = vec![0.0; length(model, variable)];
            model.numbers(variable.quantity, &mut values).ok().map(|()| values)
        });
        all.collect::<Option<Vec<Vec<f64>>>>()
    };
    let start = read(&mut model).expect("the start is a good one");
    let mut moved = Pairs::new();
    for on in M::VARIABLES.iter().filter(|variable| known.includes(variable.role)).filter(number_of) {
        for element in 0..length(&model, on) {
            let own = model.number(on.quantity, element).unwrap_or_else(|why| panic!("{why}"));
            let others = match on.kind {
                VariableType::Boolean => vec![1.0 - own],
                VariableType::Integer => vec![own - 1.0, own + 1.0],
                _ => vec![own - 0.5, own - 0.1, own + 0.1, own + 0.5, 0.7 * own, 1.3 * own],
            };
            for other in others.into_iter().filter(|other| on.domain.check(*other).is_ok()) {
                model.set(on.quantity, element, other, phase);
                // What does not fit together is refused, and moves nothing.
                for ((unknown, before), after) in
                    unknowns.iter().zip(&start).zip(read(&mut model).into_iter().flatten())
                {
                    for k in (0..before.len()).filter(|k| before[*k].to_bits() != after[*k].to_bits()) {
                        moved.insert((unknown.name, on.name));
                        let what = format!("{}[{k}] by {}[{element}]", unknown.name, on.name);
                        let (own, its) =
                            (reference::<M>(unknown.quantity).unwrap(), reference::<M>(on.quantity).unwrap());
                        let list = of_arrays[&(own as usize)].as_ref();
                        assert!(list.is_none_or(|list| list.contains(&(its as usize))), "{what}: FMI 3.0");
                        if let (Some(one), Some(other)) =
                            (place(unknown.quantity, k), place(on.quantity, element))
                        {
                            assert!(
                                of_scalars[&one].as_ref().is_none_or(|list| list.contains(&other)),
                                "{what}: FMI 2.0"
                            );
                        }
                        if known == Known::Starts {
                            let listed = slave.dependencies(own).unwrap_or_else(|why| panic!("{why}"));
                            let elements = [(0, its, 0), (k + 1, its, element + 1)];
                            assert!(
                                elements.iter().any(|entry| listed.contains(entry)),
                                "{what}: {listed:?}"
                            );
                        }
                    }
                }
            }
            model.set(on.quantity, element, own, phase);
        }
    }
    assert!(read(&mut model) == Some(start), "all as before");
    moved
}

/// The pairs that the description of FMI 3.0 declares, of numbers.
pub fn declared_pairs<M: Model>(model: &mut M, known: Known) -> Pairs {
    let kind = if known == Known::Starts { "InitialUnknown" } else { "Output" };
    let xml = description::model_description(model, FmuFormat::Fmi3).unwrap_or_else(|why| panic!("{why}"));
    let by_reference = |wanted: usize| {
        M::VARIABLES.iter().find(|of| reference::<M>(of.quantity) == Some(wanted as u32)).expect("a variable")
    };
    let mut pairs = Pairs::new();
    for (unknown, on) in declared(&xml, kind, "valueReference") {
        for on in on.expect("a list") {
            let (unknown, on) = (by_reference(unknown), by_reference(on));
            if unknown.kind != VariableType::String && on.kind != VariableType::String {
                pairs.insert((unknown.name, on.name));
            }
        }
    }
    pairs
}
