//! The variables of a description: single values in FMI 2.0, also arrays in FMI 3.0.

use super::{ArrayDimension, FmuVariable, Interface};
use crate::error::Result;
use crate::ssp::document::{Causality, FmiType};
use lemons_core::xml::Element;
use lemons_fmi::Version;
use std::collections::HashMap;

/// The most values of all variables together: more than a description of FMI 2.0 can have.
pub const MOST_VALUES: usize = 8_000_000;

/// The units of declared types, by the names of these.
type Units<'a> = HashMap<&'a str, &'a str>;

fn declared_units<'a>(root: Element<'a>) -> Result<Units<'a>> {
    let mut declared = HashMap::new();
    for own in root.child("TypeDefinitions").into_iter().flat_map(Element::elements) {
        let unit = match own.name() {
            "SimpleType" => own.child("Real").and_then(|real| real.optional("unit")),
            "Float64Type" | "Float32Type" => own.optional("unit"),
            _ => None,
        };
        if let Some(unit) = unit {
            declared.insert(own.text("name")?, unit);
        }
    }
    Ok(declared)
}

/// The places of variables of FMI 3.0 by their value references.
type References = HashMap<u32, usize>;

/// Adds the variables to the interface.
pub fn read_variables(interface: &mut Interface, root: Element) -> Result<()> {
    let declared = declared_units(root)?;
    let v3 = interface.fmi == Version::V3;
    let list = root.child("ModelVariables").into_iter().flat_map(Element::elements);
    let is_variable = |name: &str| if v3 { name != "Annotations" } else { name == "ScalarVariable" };
    let (mut elements, mut references) = (Vec::new(), References::new());
    for element in list.filter(|element| is_variable(element.name())) {
        // In FMI 2.0 an element within says the type.
        let found = if v3 { typed(element, v3) } else { element.elements().find_map(|own| typed(own, v3)) };
        let missing = if v3 { "is not a type of FMI 3.0" } else { "has no type" };
        let (typed, of) = found.ok_or_else(|| element.problem(missing))?;
        let variable = read_variable(element, typed, of, &declared)?;
        let (place, reference) = (interface.variables.len(), variable.reference);
        if v3 && let Some(other) = references.insert(reference, place) {
            let (one, other) = (&interface.variables[other].name, &variable.name);
            let why = format!("the variables {one:?} and {other:?} have this value reference");
            return Err(element.wrong("valueReference", why).into());
        }
        interface.add_name(&variable.name, place, reference, element)?;
        interface.variables.push(variable);
        for alias in element.children("Alias") {
            interface.add_name(alias.text("name")?, place, reference, alias)?;
        }
        elements.push((element, typed));
    }
    read_sizes(interface, &elements, &references)
}

/// Returns an element that says a type, with the type; `None` if this version of FMI has no such type.
fn typed(element: Element, v3: bool) -> Option<(Element, FmiType)> {
    let is_known = |of: &FmiType| match of {
        FmiType::Boolean | FmiType::String | FmiType::Enumeration => true,
        FmiType::Real | FmiType::Integer => !v3,
        _ => v3,
    };
    FmiType::from_name(element.name()).filter(is_known).map(|of| (element, of))
}

fn read_variable(element: Element, typed: Element, of: FmiType, declared: &Units) -> Result<FmuVariable> {
    let reference = element.parsed("valueReference", "a number from 0 to 4294967295")?;
    let causality = element.optional("causality").unwrap_or("local");
    let kind = Causality::from_name(causality);
    let declared_type = typed.optional("declaredType");
    let of_type = || declared.get(declared_type?).copied();
    let unit = typed.optional("unit").or_else(of_type).filter(|unit| !unit.is_empty());
    // Those of texts are elements in FMI 3.0, all others are in one attribute.
    let start = typed.optional("start").into_iter();
    let start = match of {
        FmiType::String | FmiType::Binary if typed.has("start") => start.map(str::to_owned).collect(),
        FmiType::String | FmiType::Binary => {
            let texts = element.children("Start").map(|start| Ok(start.text("value")?.to_owned()));
            texts.collect::<Result<_>>()?
        }
        _ => start.flat_map(str::split_whitespace).map(str::to_owned).collect(),
    };
    Ok(FmuVariable {
        name: element.text("name")?.to_owned(),
        reference: reference.ok_or_else(|| element.problem("has no valueReference"))?,
        // Outside of Event Mode, what belongs to a clock has no value that counts.
        kind: kind.filter(|_| of != FmiType::Clock && !element.has("clocks")),
        of,
        unit: unit.filter(|_| of.class() == FmiType::Real).map(str::to_owned),
        enumeration: (of == FmiType::Enumeration).then(|| declared_type.unwrap_or_default().to_owned()),
        dimensions: Vec::new(),
        start,
        description: element.optional("description").map(str::to_owned),
    })
}

/// Reads the dimensions of the variables, and checks names and start values by them. A dimension may name a structural
/// parameter that comes later.
fn read_sizes(
    interface: &mut Interface,
    elements: &[(Element, Element)],
    references: &References,
) -> Result<()> {
    let v3 = interface.fmi == Version::V3;
    let mut all = 0;
    for (place, (element, typed)) in elements.iter().enumerate() {
        let dimensions = element.children("Dimension").filter(|_| v3);
        let dimensions = dimensions.map(|dimension| read_dimension(interface, references, dimension));
        interface.variables[place].dimensions = dimensions.collect::<Result<_>>()?;
        let variable = &interface.variables[place];
        let count = variable.checked_count().and_then(|count| count.checked_add(all));
        all = count.filter(|all| *all <= MOST_VALUES).ok_or_else(|| {
            let sizes = variable.sizes().iter().map(usize::to_string).collect::<Vec<_>>().join(" x ");
            let why = format!(
                "with this array of {sizes} elements the variables have more than {MOST_VALUES} values in all"
            );
            element.wrong("name", why)
        })?;
        check_starts(variable, *typed)?;
        if v3 && !variable.is_array() && interface.parsed(&variable.name).is_some() {
            let why = format!("an element of an array is called {name:?}, too", name = variable.name);
            return Err(element.wrong("name", why).into());
        }
    }
    Ok(())
}

fn read_dimension(
    interface: &Interface,
    references: &References,
    dimension: Element,
) -> Result<ArrayDimension> {
    let size: Option<u64> = dimension.parsed("start", "a whole number that is not negative")?;
    let parameter: Option<u32> = dimension.parsed("valueReference", "a number from 0 to 4294967295")?;
    let (size, parameter) = match (size, parameter) {
        (Some(size), None) => (size, None),
        (None, Some(reference)) => {
            let is_size = |variable: &FmuVariable| {
                variable.kind == Some(Causality::StructuralParameter) && variable.of == FmiType::UInt64
            };
            let place = references.get(&reference).filter(|place| is_size(&interface.variables[**place]));
            let why = "no structural parameter of type UInt64 has this value reference";
            let place = *place.ok_or_else(|| dimension.wrong("valueReference", why))?;
            let FmuVariable { name, start, .. } = &interface.variables[place];
            let size = start.first().and_then(|start| start.parse().ok()).ok_or_else(|| {
                let why = format!("the structural parameter {name:?} has no start value that is a size");
                dimension.wrong("valueReference", why)
            })?;
            (size, Some(place))
        }
        (size, _) => {
            let what = if size.is_some() { "both a start and" } else { "neither a start nor" };
            return Err(dimension.problem(format!("has {what} a valueReference")).into());
        }
    };
    Ok(ArrayDimension { size: usize::try_from(size).unwrap_or(usize::MAX), parameter })
}

/// Checks that start values are numbers where they must be, and as many as elements.
fn check_starts(variable: &FmuVariable, element: Element) -> Result<()> {
    let (given, count) = (variable.start.len(), variable.count());
    if given > 1 && given != count {
        let why = format!("the variable {:?} has {given} start values, but {count} values", variable.name);
        let texts = matches!(variable.of, FmiType::String | FmiType::Binary);
        let problem = element.problem(&*why);
        return Err(if texts { problem } else { element.wrong("start", why) }.into());
    }
    if variable.of.class() == FmiType::Real {
        let nan = |start: &String| start.trim().parse::<f64>().is_ok_and(f64::is_nan);
        if let Some(place) = variable.start.iter().position(nan) {
            let which = if given > 1 { format!(" (value {} of {given})", place + 1) } else { String::new() };
            let why = format!("of the variable {:?} is not a number{which}", variable.name);
            return Err(element.wrong("start", why).into());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ssp::unit::SspUnit;

    /// As another tool might write it: sizes after the arrays, an alias, a declared type, a clock, each type of number.
    const FOREIGN: &str = include_str!("../../../tests/ssp_files/modelDescription.xml");

    fn read(text: &str) -> Interface {
        Interface::read(text.as_bytes()).unwrap_or_else(|error| panic!("{error}"))
    }

    fn message(text: &str) -> String {
        Interface::read(text.as_bytes()).map_or_else(|error| error.to_string(), |_| "read".to_owned())
    }

    #[test]
    fn a_description_of_another_tool_is_read() {
        let interface = read(FOREIGN);
        let own = interface.co_simulation.as_ref().unwrap();
        assert!(own.can_get_and_set_state && !own.can_serialize_state && own.cannot_use_memory_functions);
        assert_eq!(
            (interface.guid.as_str(), interface.step, interface.variables.len()),
            ("{x}", Some(0.1), 9)
        );
        let a = interface.variable("A").unwrap();
        assert_eq!(interface.variable("B"), Some(a), "an alias");
        assert_eq!((a.kind, a.of, a.unit.as_deref()), (Some(Causality::Input), FmiType::Float64, Some("m")));
        assert_eq!(interface.unit("m").map(|unit: &SspUnit| unit.exponents[1]), Some(1));
        assert_eq!((a.count(), a.start_of(5), a.start_of(6)), (6, Some("6"), None));
        // Row-major order, indices from 1.
        let names: Vec<String> = interface.singles().map(|(name, _)| name).collect();
        let expected = [
            "time", "A[1,1]", "A[1,2]", "A[1,3]", "A[2,1]", "A[2,2]", "A[2,3]", "y[1]", "y[2]", "m", "s[1]",
            "s[2]", "e", "tick", "counted", "b",
        ];
        assert_eq!(names, expected);
        for (name, single) in interface.singles() {
            assert_eq!(interface.single(&name), Some(single), "{name}");
        }
        for none in
            ["A", "A[0,1]", "A[3,1]", "A[1,4]", "A[1]", "A[1,1,1]", "A[01,1]", "A[+1,1]", "y[1", "b[1]"]
        {
            assert_eq!(interface.single(none), None, "{none}");
        }
        let kind =
            |name: &str| (interface.variable(name).unwrap().kind, interface.variable(name).unwrap().of);
        assert_eq!(kind("e"), (Some(Causality::Output), FmiType::Enumeration));
        assert_eq!(kind("y"), (Some(Causality::Output), FmiType::Float32));
        assert_eq!(kind("m"), (Some(Causality::StructuralParameter), FmiType::UInt64));
        assert_eq!((kind("tick").0, kind("counted").0), (None, None), "there is no Event Mode");
        assert_eq!(interface.variable("s").unwrap().start, ["one & a half", ""]);
    }

    #[test]
    fn other_sizes_are_chosen() {
        let mut interface = read(FOREIGN);
        interface.resize("m", 4).unwrap();
        assert_eq!(interface.variable("A").unwrap().count(), 12);
        assert_eq!(interface.single("A[4,3]").unwrap().element, 11);
        assert!(interface.variable("A").unwrap().start.is_empty(), "they are those of the sizes that were");
        assert_eq!(interface.variable("s").unwrap().count(), 2);
        interface.resize("m", 0).unwrap();
        assert_eq!(interface.variable("y").unwrap().count(), 0);
        for (name, size) in [("b", 1), ("none", 1), ("m", 3_000_000), ("m", u64::MAX)] {
            interface.resize(name, size).unwrap_err();
        }
        assert_eq!(interface.variable("A").unwrap().count(), 0, "a refused size changes nothing");
    }

    /// Those of people have the names that they have in FMI 2.0.
    #[test]
    fn elements_of_people_have_the_names_of_fmi_2() {
        let text = r#"<fmiModelDescription fmiVersion="3.0" modelName="c" instantiationToken="t"><ModelVariables>
            <UInt64 name="Agents" valueReference="1" causality="structuralParameter" start="2"/>
            <Float64 name="Position" valueReference="2" causality="output"><Dimension valueReference="1"/><Dimension start="2"/></Float64>
            <Float64 name="Theta" valueReference="3" causality="output"><Dimension valueReference="1"/></Float64>
            <Int32 name="AgentContacts" valueReference="4" causality="output"><Dimension valueReference="1"/></Int32>
            <Int32 name="TotalAgentContacts" valueReference="5" causality="output"/>
            <Int32 name="TotalOther" valueReference="6" causality="output"/>
            <Float64 name="Inertia" valueReference="7" causality="output"><Dimension valueReference="1"/><Dimension start="3"/></Float64>
            <UInt64 name="WallSegments" valueReference="8" causality="structuralParameter" start="2"/>
            <Float64 name="WallForce" valueReference="9" causality="output"><Dimension valueReference="8"/></Float64>
            <Float64 name="Force" valueReference="10" causality="output"><Dimension valueReference="8"/></Float64>
            </ModelVariables></fmiModelDescription>"#;
        let interface = read(text);
        let names: Vec<String> = interface.singles().map(|(name, _)| name).collect();
        let expected = "Agents agent[0].Position.x agent[0].Position.y agent[1].Position.x agent[1].Position.y \
                        agent[0].Theta agent[1].Theta agent[0].AgentContacts agent[1].AgentContacts AgentContacts \
                        TotalOther agent[0].Inertia[1] agent[0].Inertia[2] agent[0].Inertia[3] agent[1].Inertia[1] \
                        agent[1].Inertia[2] agent[1].Inertia[3] WallSegments wall[0].Force wall[1].Force Force[1] \
                        Force[2]";
        assert_eq!(names.join(" "), expected);
        for (name, single) in interface.singles() {
            assert_eq!(interface.single(&name), Some(single), "{name}");
        }
        let of = |name: &str| interface.single(name).map(|single| single.to_string());
        assert_eq!(of("agent[1].Position.y").as_deref(), Some("2[3]"));
        assert_eq!(of("AgentContacts"), of("TotalAgentContacts"));
        let others = "agent[2].Theta agent[0].Position agent[0].Position.z agent[0].Theta.x agent[00].Theta Theta[1] \
                      Position[1,1] agent[0].Position[1] agent[0].Inertia[4] agent[0].Agents \
                      wall[2].Force WallForce[1] wall[0].WallForce wall[0].Theta";
        for none in others.split(' ') {
            assert_eq!(interface.single(none), None, "{none}");
        }
        let twice = text.replace("TotalOther", "agent[1].Theta");
        assert!(
            message(&twice).contains("name=\"agent[1].Theta\": an element of an array is called"),
            "{}",
            message(&twice)
        );
    }
}
