//! Asks a model whether it keeps the bounds that its descriptions declare.

use crate::variables::Number;
use crate::{FmuFormat, Function, Model, Phase, Slave, Version, description, guid, instantiation_token};
use std::collections::HashMap;

/// Each variable that can be set: type, value reference, least and greatest value.
fn settable(xml: &str) -> Vec<(String, u32, [Option<f64>; 2])> {
    let attribute = |tag: &str, name: &str| {
        let rest = &tag[tag.find(&format!(" {name}=\""))? + name.len() + 3..];
        Some(rest[..rest.find('"')?].to_owned())
    };
    let mut found = Vec::new();
    let mut scalar = String::new();
    let mut types: HashMap<String, [Option<f64>; 2]> = HashMap::new();
    let mut simple = None;
    for tag in xml.split('<') {
        if tag.starts_with("ScalarVariable ") {
            tag.clone_into(&mut scalar);
            continue;
        }
        let bound = |name| attribute(tag, name).map(|bound| bound.parse().unwrap());
        let bounds = ["min", "max"].map(bound);
        if tag.starts_with("SimpleType ") {
            simple = attribute(tag, "name");
        } else if tag.starts_with("Float64Type ") {
            types.insert(attribute(tag, "name").unwrap(), bounds);
        } else if let Some(name) = simple.take() {
            types.insert(name, bounds);
        }
        // FMI 2.0 has the type in an element of its own.
        let whole = if attribute(tag, "valueReference").is_some() {
            tag.to_owned()
        } else {
            format!("{tag}{scalar}")
        };
        let kind = tag.split(' ').next().unwrap_or_default();
        let is_number = ["Real", "Integer", "Float64", "Int32", "UInt64"].contains(&kind);
        if is_number && attribute(tag, "start").is_some() {
            let reference = attribute(&whole, "valueReference").unwrap().parse().unwrap();
            let declared = attribute(tag, "declaredType").map_or([None; 2], |name| types[&name]);
            let both = [0, 1].map(|place| bounds[place].or(declared[place]));
            found.push((kind.to_owned(), reference, both));
        }
    }
    found
}

/// Sets elements that are not 0, or all, to a value; returns whether that is accepted.
fn accepts<M: Model, N: Number>(slave: &mut Slave<M>, reference: u32, length: usize, value: f64) -> bool {
    let mut values = vec![N::of(0.0); length];
    let readable = slave.get(&[reference], &mut values).is_ok();
    let starts = N::numbers(&values).into_owned();
    let all = starts.iter().all(|start| *start == 0.0);
    let changed: Vec<N> =
        starts.iter().map(|start| N::of(if all || *start != 0.0 { value } else { 0.0 })).collect();
    let accepted = slave.set(&[reference], &changed).is_ok();
    // FMI 2.0 lets nothing be read yet.
    if readable {
        slave.set(&[reference], &values).unwrap_or_else(|why| panic!("the start: {why}"));
    }
    accepted
}

/// Asserts, for both versions of FMI, that each number within the declared bounds is accepted, and each beyond refused.
pub fn are_kept<M: Model>(make: impl Fn() -> M) {
    for (version, format) in [(Version::V2, FmuFormat::default()), (Version::V3, FmuFormat::Fmi3)] {
        let mut model = make();
        let xml = description::model_description(&mut model, format).unwrap_or_else(|why| panic!("{why}"));
        let token = if version == Version::V2 { guid(&model.scalars()) } else { instantiation_token::<M>() };
        let mut slave = Slave::new(make(), version, &token.to_string()).unwrap_or_else(|why| panic!("{why}"));
        let variables = settable(&xml);
        let bounded = variables.iter().filter(|(.., bounds)| bounds.iter().any(Option::is_some)).count();
        assert!(bounded > 5 && bounded < variables.len(), "{bounded} of {}", variables.len());
        for (kind, reference, [least, most]) in variables {
            let sizes = 1 + M::SIZES.len();
            let length = match version {
                Version::V2 => 1,
                Version::V3 => (reference as usize)
                    .checked_sub(sizes)
                    .map_or(1, |place| super::dependencies::length(&model, &M::VARIABLES[place])),
            };
            let (smallest, largest) = match &*kind {
                "UInt64" => (0.0, 1e18),
                "Int32" | "Integer" => (i32::MIN.into(), i32::MAX.into()),
                _ => (-1e300, 1e300),
            };
            let real = ["Real", "Float64"].contains(&&*kind);
            let beside = |bound: f64, by: f64| {
                if !real {
                    bound + by
                } else if by < 0.0 {
                    bound.next_down()
                } else {
                    bound.next_up()
                }
            };
            let mut cases = vec![(least.unwrap_or(smallest), true), (most.unwrap_or(largest), true)];
            cases.extend(least.map(|least| (beside(least, -1.0), false)));
            cases.extend(least.filter(|_| smallest < 0.0).map(|_| (smallest, false)));
            cases.extend(most.map(|most| (beside(most, 1.0), false)));
            let size = kind == "UInt64";
            if size {
                slave.change_phase(Function::EnterConfigurationMode, Phase::Configuration).unwrap();
            }
            for (value, expected) in cases {
                let accepted = match &*kind {
                    "UInt64" => accepts::<M, u64>(&mut slave, reference, length, value),
                    "Int32" | "Integer" => accepts::<M, i32>(&mut slave, reference, length, value),
                    _ => accepts::<M, f64>(&mut slave, reference, length, value),
                };
                assert_eq!(accepted, expected, "{version:?}: {kind} {reference} = {value:?}");
            }
            if size {
                slave.change_phase(Function::ExitConfigurationMode, Phase::Instantiated).unwrap();
            }
        }
    }
}
