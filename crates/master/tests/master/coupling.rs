//! Coupled FMUs against loops written out here, and against recurrences done by hand.

use crate::controller::{DESCRIPTION, write_controller, write_zip};
use crate::packed;
use crowd_mechanics::pack::FmuFormat;
use lemons_master::{Fmu, FmuInstance, System, assemble};
use lemons_sim::Algorithm;
use std::path::Path;
use tempfile::TempDir;

/// A structure of two components of one FMU; `connections` and `rest` as XML.
fn structure(connectors: &str, bindings: [&str; 2], connections: &str, rest: &str) -> String {
    let component = |name: &str, bindings: &str| {
        format!(
            r#"<ssd:Component name="{name}" source="resources/it.fmu">
                 <ssd:Connectors>{connectors}</ssd:Connectors>{bindings}</ssd:Component>"#
        )
    };
    format!(
        r#"<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
             xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"
             xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" name="two">
             <ssd:System name="two"><ssd:Elements>{}{}</ssd:Elements>
             <ssd:Connections>{connections}</ssd:Connections></ssd:System>{rest}
           </ssd:SystemStructureDescription>"#,
        component("a", bindings[0]),
        component("b", bindings[1])
    )
}

/// Parameters of a component, and their units.
fn binding(parameters: &str, units: &str) -> String {
    format!(
        r#"<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>
             <ssv:ParameterSet version="1.0" name="p"><ssv:Parameters>{parameters}</ssv:Parameters>{units}
             </ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>"#
    )
}

fn write_ssp(directory: &Path, structure: &str) -> std::path::PathBuf {
    let fmu = std::fs::read(directory.join("it.fmu")).unwrap();
    let path = directory.join("two.ssp");
    write_zip(&path, &[("SystemStructure.ssd", structure.as_bytes()), ("resources/it.fmu", &fmu)]);
    path
}

fn real(instance: &FmuInstance, name: &str) -> f64 {
    instance.value(name).unwrap()
}

fn set_real(instance: &FmuInstance, name: &str, value: f64) {
    instance.set(&instance.select([name]).unwrap(), &[value]).unwrap();
}

const FORCE: &str = "agent[0].NormalForce";
const INPUT: &str = "agent[0].Fp.x";
const STEP: f64 = 0.01;
const STEPS: u32 = 60;

/// Where both crowds' agents are, after each step.
type Seen = Vec<Vec<u64>>;

fn look(instances: [&FmuInstance; 2]) -> Vec<u64> {
    let names = (0..5).flat_map(|i| {
        ["Position.x", "Velocity.y", "Omega", "NormalForce"].map(|name| format!("agent[{i}].{name}"))
    });
    let names: Vec<String> = names.collect();
    instances.iter().flat_map(|instance| names.iter().map(|name| real(instance, name).to_bits())).collect()
}

/// Effect of the squeezes of the first agents on the first agent of the other crowd, written out. `a` is pushed
/// by half the squeeze in `b` and 100 N.
fn by_hand(fmu: &Fmu, algorithm: Algorithm) -> Seen {
    let (a, b) = (fmu.instantiate("a").unwrap(), fmu.instantiate("b").unwrap());
    set_real(&a, "agent[0].Velocity.x", 2.0);
    set_real(&b, "agent[0].Velocity.x", 1.0);
    let to_a = |squeeze: f64| 0.5 * squeeze + 100.0;
    for instance in [&a, &b] {
        instance.enter_initialization(0.0, None).unwrap();
    }
    // Squeezes do not depend on inputs: one exchange is all.
    set_real(&a, INPUT, to_a(real(&b, FORCE)));
    set_real(&b, INPUT, real(&a, FORCE));
    for instance in [&a, &b] {
        instance.exit_initialization().unwrap();
    }
    let mut seen = Vec::new();
    for k in 0..STEPS {
        let (time, end) = (f64::from(k) * STEP, f64::from(k + 1) * STEP);
        match algorithm {
            Algorithm::Jacobi => {
                let (of_a, of_b) = (real(&a, FORCE), real(&b, FORCE));
                set_real(&a, INPUT, to_a(of_b));
                set_real(&b, INPUT, of_a);
                a.step(time, end - time).unwrap();
                b.step(time, end - time).unwrap();
            }
            Algorithm::GaussSeidel => {
                set_real(&a, INPUT, to_a(real(&b, FORCE)));
                a.step(time, end - time).unwrap();
                set_real(&b, INPUT, real(&a, FORCE));
                b.step(time, end - time).unwrap();
            }
        }
        seen.push(look([&a, &b]));
    }
    seen
}

fn coupled(path: &Path, algorithm: Algorithm) -> Seen {
    let mut system = assemble(path, algorithm, &[]).unwrap().system;
    system.initialize(0.0, None).unwrap();
    let seen = (1..=STEPS).map(|k| {
        system.step_to(f64::from(k) * STEP).unwrap();
        let components = &system.components;
        look([&components[0].instance, &components[1].instance])
    });
    seen.collect()
}

#[test]
fn two_crowds_exchange_forces_as_in_a_loop_written_out() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    std::fs::rename(packed(at, FmuFormat::default()), at.join("it.fmu")).unwrap();
    let connectors = format!(
        r#"<ssd:Connector name="{FORCE}" kind="output"><ssc:Real unit="N"/></ssd:Connector>
           <ssd:Connector name="{INPUT}" kind="input"><ssc:Real/></ssd:Connector>"#
    );
    let binding = |velocity: &str| {
        let value = format!(r#"<ssv:Real value="{velocity}"/>"#);
        binding(&format!(r#"<ssv:Parameter name="agent[0].Velocity.x">{value}</ssv:Parameter>"#), "")
    };
    // The second connection is written from its input to its output, which SSP allows.
    let connections = format!(
        r#"<ssd:Connection startElement="a" startConnector="{FORCE}" endElement="b" endConnector="{INPUT}"/>
           <ssd:Connection startElement="a" startConnector="{INPUT}" endElement="b" endConnector="{FORCE}">
           <ssc:LinearTransformation factor="0.5" offset="100"/></ssd:Connection>"#
    );
    let text = structure(&connectors, [&binding("2"), &binding("1.0")], &connections, "");
    let path = write_ssp(at, &text);
    let fmu = Fmu::open(&at.join("it.fmu")).unwrap();
    let [jacobi, gauss_seidel] = [Algorithm::Jacobi, Algorithm::GaussSeidel].map(|algorithm| {
        let seen = coupled(&path, algorithm);
        assert!(seen == by_hand(&fmu, algorithm), "{algorithm:?}");
        seen
    });
    assert!(jacobi != gauss_seidel, "the second crowd hears of the first one a step earlier");
    let squeezed = |seen: &Seen, crowd: usize| {
        seen.iter().map(|row| f64::from_bits(row[20 * crowd + 3])).fold(0.0, f64::max)
    };
    assert!(squeezed(&jacobi, 0) > 100.0 && squeezed(&jacobi, 1) > 100.0, "the coupling has forces to carry");
}

#[test]
fn every_type_arrives_and_the_algorithms_count_as_they_should() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    write_controller(&at.join("it.fmu"), DESCRIPTION, true);
    let (mut connectors, mut connections) = (String::new(), String::new());
    for of in ["Real", "Integer", "Boolean", "String"] {
        let name = of.to_lowercase();
        for (end, kind) in [("in", "input"), ("out", "output")] {
            let of = format!("<ssc:{of}/>");
            connectors +=
                &format!(r#"<ssd:Connector name="{name}.{end}" kind="{kind}">{of}</ssd:Connector>"#);
        }
        for (from, to) in [("a", "b"), ("b", "a")] {
            let start = format!(r#"startElement="{from}" startConnector="{name}.out""#);
            let end = format!(r#"endElement="{to}" endConnector="{name}.in""#);
            connections += &format!("<ssd:Connection {start} {end}/>");
        }
    }
    let path = write_ssp(at, &structure(&connectors, ["", ""], &connections, ""));
    for algorithm in [Algorithm::Jacobi, Algorithm::GaussSeidel] {
        let mut system = assemble(&path, algorithm, &[]).unwrap().system;
        assert_eq!(system.connections, 8);
        system.initialize(0.0, None).unwrap();
        for k in 1..=6 {
            system.step_to(0.1 * f64::from(k)).unwrap();
            // Each output is the other's plus one: of the step before, or of this one for b in Gauss-Seidel.
            let counts = match algorithm {
                Algorithm::Jacobi => [k, k],
                Algorithm::GaussSeidel => [2 * k - 1, 2 * k],
            };
            for (component, count) in system.components.iter().zip(counts) {
                let instance = &component.instance;
                assert_eq!(real(instance, "real.out"), f64::from(count));
                assert_eq!(real(instance, "integer.out"), f64::from(count));
                assert_eq!(real(instance, "boolean.out"), f64::from(count % 2));
                let text = instance.value::<String>("string.out").unwrap();
                assert_eq!(text, "x".repeat(usize::try_from(count).unwrap()));
            }
        }
        system.terminate().unwrap();
    }
}

#[test]
fn units_are_converted_on_the_way_and_parameters_on_theirs() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    // Its one Real input and output, in km and in cm.
    let length = |name: &str, factor: &str| {
        format!(r#"<Unit name="{name}"><BaseUnit m="1" factor="{factor}"/></Unit></UnitDefinitions>"#)
    };
    let unit_of = |description: &str, name: &str, unit: &str| {
        let start = description.find(&format!("name=\"{name}\"")).unwrap();
        let real = start + description[start..].find("<Real").unwrap() + "<Real".len();
        format!("{} unit=\"{unit}\"{}", &description[..real], &description[real..])
    };
    let description = DESCRIPTION
        .replace("</UnitDefinitions>", &length("km", "1000"))
        .replace("</UnitDefinitions>", &length("cm", "0.01"));
    let description = unit_of(&unit_of(&description, "real.in", "cm"), "real.out", "km");
    write_controller(&at.join("it.fmu"), &description, true);
    let connectors = r#"<ssd:Connector name="real.in" kind="input"><ssc:Real/></ssd:Connector>
        <ssd:Connector name="real.out" kind="output"/>"#;
    let binding = binding(
        r#"<ssv:Parameter name="Delay"><ssv:Real value="2" unit="min"/></ssv:Parameter>
           <ssv:Parameter name="Nobody"><ssv:Real value="2"/></ssv:Parameter>"#,
        r#"<ssv:Units><ssc:Unit name="min"><ssc:BaseUnit s="1" factor="60"/></ssc:Unit></ssv:Units>"#,
    );
    let connection = |attributes: &str, inside: &str| {
        format!(
            r#"<ssd:Connection startElement="a" startConnector="real.out" endElement="b" endConnector="real.in"
                 {attributes}>{inside}</ssd:Connection>"#
        )
    };
    let transformed = r#"<ssc:LinearTransformation factor="2" offset="1"/>"#;
    // 1 km is 100000 cm; the transformation comes after that, or instead of it.
    for (attributes, inside, arrives) in [
        ("", "", 1e5),
        (r#"suppressUnitConversion="true""#, "", 1.0),
        ("", transformed, 2e5 + 1.0),
        (r#"suppressUnitConversion="true""#, transformed, 3.0),
    ] {
        let path = write_ssp(at, &structure(connectors, [&binding, ""], &connection(attributes, inside), ""));
        let assembled = assemble(&path, Algorithm::GaussSeidel, &[]).unwrap();
        assert_eq!(assembled.warnings.len(), 1);
        assert!(assembled.warnings[0].contains("\"Nobody\""), "{:?}", assembled.warnings);
        let mut system = assembled.system;
        system.initialize(0.0, None).unwrap();
        system.step_to(0.1).unwrap();
        let [a, b] = [0, 1].map(|c| &system.components[c].instance);
        assert_eq!(real(a, "real.out"), 1.0);
        assert_eq!(real(a, "Delay"), 120.0);
        assert_eq!(real(b, "real.in"), arrives);
    }
}

#[test]
fn first_values_pass_through_initialization() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    std::fs::rename(packed(at, FmuFormat::default()), at.join("it.fmu")).unwrap();
    let connectors = r#"<ssd:Connector name="agent[1].Position.x" kind="output"/>
        <ssd:Connector name="agent[0].Fp.x" kind="input"/>"#;
    let connection = r#"<ssd:Connection startElement="a" startConnector="agent[1].Position.x"
        endElement="b" endConnector="agent[0].Fp.x" suppressUnitConversion="true"/>"#;
    let path = write_ssp(at, &structure(connectors, ["", ""], connection, ""));
    let mut system: System = assemble(&path, Algorithm::Jacobi, &[]).unwrap().system;
    system.initialize(0.0, None).unwrap();
    let [a, b] = [0, 1].map(|c| &system.components[c].instance);
    assert_eq!(real(a, "agent[1].Position.x"), 0.279);
    assert_eq!(real(b, "agent[0].Fp.x"), 0.279, "before any step");
}

#[test]
fn what_does_not_fit_the_fmu_is_refused() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    write_controller(&at.join("it.fmu"), DESCRIPTION, true);
    // Each connector is there by its name, kind and type.
    let connectors = r#"<ssd:Connector name="integer.out" kind="output"><ssc:Integer/></ssd:Connector>
        <ssd:Connector name="integer.in" kind="input"/><ssd:Connector name="real.in" kind="input"/>
        <ssd:Connector name="agent[0].Theta" kind="input"/><ssd:Connector name="agent[0].Fp.x" kind="output"/>"#;
    let binding = binding(r#"<ssv:Parameter name="Delay"><ssv:Real value="2"/></ssv:Parameter>"#, "");
    let connection = r#"<ssd:Connection startElement="a" startConnector="integer.out" endElement="b"
        endConnector="integer.in"></ssd:Connection>"#;
    let units = r#"<ssd:Units><ssc:Unit name="km"><ssc:BaseUnit m="1" factor="1e3"/></ssc:Unit></ssd:Units>"#;
    let good = structure(connectors, [&binding, ""], connection, units);
    let message = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        let made = assemble(&write_ssp(at, &good.replace(from, to)), Algorithm::Jacobi, &[]);
        made.map_or_else(|error| error.whole(), |_| "accepted".to_owned())
    };
    assert_eq!(message("", ""), "accepted");
    for (from, to, words) in [
        ("name=\"real.in\"", "name=\"real.ein\"", r#"name="real.ein": the FMU has no such"#),
        ("real.in\" kind=\"input\"", "real.in\" kind=\"output\"", r#"kind="output", but the FMU says input"#),
        ("<ssc:Integer/>", "<ssc:Real/>", "<Real>, but the FMU says Integer"),
        (
            "Theta\" kind=\"input\"/>",
            "Theta\" kind=\"input\"><ssc:Real unit=\"km\"/></ssd:Connector>",
            r#"unit="km", but the FMU says "rad""#,
        ),
        ("endConnector=\"integer.in\"", "endConnector=\"real.in\"", "Integer does not become Real"),
        (
            "startConnector=\"integer.out\" endElement=\"b\"\n        endConnector=\"integer.in\"",
            "startConnector=\"agent[0].Fp.x\" endElement=\"b\" endConnector=\"agent[0].Theta\"",
            "\"N\" cannot be converted to \"rad\"",
        ),
        (
            "></ssd:Connection>",
            "><ssc:LinearTransformation factor=\"2\"/></ssd:Connection>",
            "no <LinearTransformation> for type Integer",
        ),
        ("<ssv:Real", "<ssv:String", "<Parameter> name=\"Delay\": the FMU's variable is of type Real"),
    ] {
        let message = message(from, to);
        assert!(message.contains(words) && message.contains("SystemStructure.ssd:"), "{message}");
    }
}
