//! An FMU 3.0 of another hand: each type of value, sizes that are chosen, and steps that end otherwise than as a whole.

use crate::controller::{compiled, write_zip};
use crowd_mechanics::pack::host_directory;
use lemons_master::{Fmu, FmuInstance, System, ValueSelection, assemble};
use lemons_sim::Algorithm;
use std::path::Path;
use tempfile::TempDir;

const DESCRIPTION: &str = include_str!("../../../../tests/coupling/arrays.xml");

fn write(path: &Path, description: &str, flags: &[&str]) {
    let library = compiled(path, "arrays.c", flags);
    let name = format!("binaries/{}/arrays{}", host_directory().unwrap(), std::env::consts::DLL_SUFFIX);
    write_zip(path, &[("modelDescription.xml", description.as_bytes()), (&name, &library)]);
}

fn fmu(directory: &TempDir) -> Fmu {
    let path = directory.path().join("arrays.fmu");
    write(&path, DESCRIPTION, &[]);
    Fmu::open(&path).unwrap()
}

fn select(instance: &FmuInstance, names: &[&str]) -> ValueSelection {
    instance.select(names).unwrap()
}

#[test]
fn values_of_each_type_are_set_and_read_in_any_order() {
    let directory = TempDir::new().unwrap();
    let fmu = fmu(&directory);
    let instance = fmu.instantiate("x").unwrap();
    // Elements of arrays wait for initialization; of two the later one counts.
    instance.set_text(&["f64.in[2,1]"], "7").unwrap();
    instance.set_text(&["f64.in[1,1]", "f64.in[1,2]", "f64.in[2,1]", "f64.in[2,2]"], "3").unwrap();
    instance.set_text(&["f64.in[1,2]"], "4.5").unwrap();
    instance.set_text(&["b.in[2]"], "true").unwrap();
    instance.set_text(&["s.in[2]"], "two").unwrap();
    instance.set_text(&["f32.in[1]"], "0.1").unwrap();
    instance.set_text(&["i8.in"], "-5").unwrap();
    instance.set_text(&["u64.in"], "40000").unwrap();
    instance.initialize().unwrap();
    let real = |name: &str| instance.value::<f64>(name).unwrap();
    assert_eq!(
        ["f64.out[1,1]", "f64.out[1,2]", "f64.out[2,1]", "f64.out[2,2]"].map(real),
        [4.0, 5.5, 4.0, 4.0]
    );
    // Of two types at once, in an order of their own, one twice.
    let names = ["f32.out[1]", "f64.out[2,2]", "f32.in[2]", "f64.out[1,2]", "f32.out[1]"];
    let values = instance.values::<f64>(&select(&instance, &names)).unwrap();
    let single = f64::from(0.1_f32 + 1.0);
    assert_eq!(values, [single, 4.0, 0.0, 5.5, single]);
    let numbers = |names: &[&str]| instance.values::<f64>(&select(&instance, names));
    let names =
        ["u64.in", "i8.out", "f64.in[2,1]", "i8.in", "n", "b.out[2]", "b.out[1]", "b.in[1]", "b.in[2]"];
    assert_eq!(numbers(&names).unwrap(), [40_000.0, -4.0, 3.0, -5.0, 2.0, 0.0, 1.0, 0.0, 1.0]);
    assert_eq!(["s.out[1]", "s.out[2]"].map(|name| instance.value::<String>(name).unwrap()), ["x", "twox"]);
    // While it runs, the others of an array stay as they are.
    instance.set(&select(&instance, &["f64.in[2,2]", "f64.in[1,1]"]), &[-1.0, -2.0]).unwrap();
    assert_eq!(
        ["f64.in[1,1]", "f64.in[1,2]", "f64.in[2,1]", "f64.in[2,2]"].map(real),
        [-2.0, 4.5, 3.0, -1.0]
    );
    // 50000² does not fit into what tables have, 300 not into an Int8.
    instance.set_text(&["u64.in"], "50000").unwrap();
    let message = numbers(&["u64.out"]).unwrap_err().whole();
    assert_eq!(message, "fmi3GetUInt64: 2500000000 is not a value of Int32, to which it is read");
    let message = instance.set_text(&["i8.in"], "300").unwrap_err().whole();
    assert_eq!(message, "fmi3SetInt8: 300 is not a value of Int8");
}

#[test]
fn other_sizes_are_set_in_configuration_mode() {
    let directory = TempDir::new().unwrap();
    let mut fmu = fmu(&directory);
    fmu.configure([("n", "3")].into_iter()).unwrap();
    let instance = fmu.instantiate("x").unwrap();
    instance.set_text(&["f64.in[3,2]"], "5").unwrap();
    instance.initialize().unwrap();
    assert_eq!(instance.value::<f64>("f64.out[3,2]").unwrap(), 6.0);
    instance.step(0.0, 0.5).unwrap();
    instance.terminate().unwrap();
    fmu.configure([("n", "9")].into_iter()).unwrap();
    let message = fmu.instantiate("x").map_or_else(|error| error.whole(), |_| "made".to_owned());
    assert!(message.ends_with("arrays.fmu: fmi3SetUInt64 returned Error"), "{message}");
    let message = fmu.configure([("n", "many")].into_iter()).unwrap_err().whole();
    assert!(message.starts_with("n=many: not a size"), "{message}");
}

#[test]
fn a_step_that_does_not_end_as_a_whole_is_an_error_that_says_how() {
    let directory = TempDir::new().unwrap();
    let fmu = fmu(&directory);
    let message = |mode: &str| {
        let instance = fmu.instantiate("x").unwrap();
        instance.set_text(&["mode"], mode).unwrap();
        instance.initialize().unwrap();
        let done = instance.step(1.0, 0.5).map_or_else(|error| error.whole(), |()| "done".to_owned());
        (done, instance.warnings().join("; "))
    };
    assert_eq!(message("0"), ("done".into(), String::new()));
    let within = "within the step from 1.0 s over 0.5 s";
    assert_eq!(message("1").0, format!("fmi3DoStep: the FMU has returned at t = 1.25 s, {within}"));
    assert_eq!(message("2").0, format!("fmi3DoStep: the FMU ends the simulation at t = 1.25 s, {within}"));
    assert_eq!(
        message("3").0,
        "fmi3DoStep: the FMU wants Event Mode at t = 1.5 s, which this master has not"
    );
    // A text is not a format; two number signs mean one.
    assert_eq!(message("4"), ("50 % of the step # is too long".to_owned(), String::new()));
    let warning = "warning: the step from t = 1.0 s returned the status fmi3Warning";
    assert_eq!(message("5"), ("done".into(), warning.into()));
    assert_eq!(message("6").0, "fmi3DoStep returned 5, which is no status of FMI");
}

#[test]
fn what_a_library_or_a_flag_lacks_is_named() {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("x.fmu");
    let message = |description: &str, flags: &[&str]| {
        write(&path, description, flags);
        let fmu = Fmu::open(&path).unwrap();
        let made = fmu.instantiate("x").and_then(|instance| {
            instance.initialize()?;
            instance.set_text(&["i8.in"], "1")
        });
        made.map_or_else(|error| error.whole(), |()| "made".to_owned())
    };
    assert_eq!(message(DESCRIPTION, &[]), "made");
    let without = |name: &str| message(DESCRIPTION, &[&format!("-D{name}=other_{name}")]);
    assert!(without("fmi3DoStep").contains("has no function fmi3DoStep"), "{}", without("fmi3DoStep"));
    // Only where it is needed.
    assert_eq!(without("fmi3SetInt8"), "the FMU has no function fmi3SetInt8");
    assert_eq!(without("fmi3GetUInt64"), "made");
    let other = message(&DESCRIPTION.replace("{arrays}", "{other}"), &[]);
    assert!(
        other.ends_with("x.fmu: has no directory resources, which it may need: 100 % of this # is a text"),
        "{other}"
    );
    assert_eq!(Fmu::open(&path).unwrap().cannot_save(), Some("canGetAndSetFMUState"));
}

/// Two of them in a ring: whole arrays, single elements, and a map of the values.
#[test]
fn arrays_are_coupled_by_ssp_2() {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("x.ssp");
    let fmu = directory.path().join("arrays.fmu");
    write(&fmu, DESCRIPTION, &[]);
    let bytes = std::fs::read(&fmu).unwrap();
    let connectors = r#"<d:Connectors><d:Connector name="n" kind="structuralParameter"><c:UInt64/></d:Connector>
        <d:Connector name="f64.in" kind="input"><c:Float64/><c:Dimension sizeConnector="n"/><c:Dimension size="2"/></d:Connector>
        <d:Connector name="f64.out" kind="output"><c:Float64/><c:Dimension sizeConnector="n"/><c:Dimension/></d:Connector>
        <d:Connector name="f32.in" kind="input"><c:Float32/><c:Dimension sizeConnector="n"/></d:Connector>
        </d:Connectors>"#;
    let component = |name: &str, more: &str| {
        format!(r#"<d:Component name="{name}" source="arrays.fmu">{connectors}{more}</d:Component>"#)
    };
    let sizes = r#"<d:ParameterBindings><d:ParameterBinding><d:ParameterValues><v:ParameterSet version="2.0" name="p"><v:Parameters>
        <v:Parameter name="n"><v:UInt64 value="3"/></v:Parameter>
        <v:Parameter name="f64.in[3,1]"><v:Float64 value="0.5"/></v:Parameter>
        </v:Parameters></v:ParameterSet></d:ParameterValues></d:ParameterBinding></d:ParameterBindings>"#;
    let connections = r#"<d:Connection startElement="a" startConnector="f64.out" endElement="b" endConnector="f64.in">
          <c:LinearTransformation factor="10"/></d:Connection>
        <d:Connection startElement="b" startConnector="f64.out" startIndices="2 1" endElement="a" endConnector="f32.in" endIndices="3"/>"#;
    let structure = format!(
        r#"<d:SystemStructureDescription xmlns:d="http://ssp-standard.org/SSP1/SystemStructureDescription"
        xmlns:c="http://ssp-standard.org/SSP1/SystemStructureCommon"
        xmlns:v="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="2.0" name="x"><d:System name="x">
        <d:Elements>{}{}</d:Elements><d:Connections>{connections}</d:Connections></d:System></d:SystemStructureDescription>"#,
        component("a", sizes),
        component("b", sizes)
    );
    let assembled = |structure: &str| {
        write_zip(&path, &[("SystemStructure.ssd", structure.as_bytes()), ("arrays.fmu", &bytes)]);
        assemble(&path, Algorithm::GaussSeidel, &[]).map(|assembled| assembled.system)
    };
    let mut system: System = assembled(&structure).unwrap_or_else(|error| panic!("{}", error.whole()));
    system.initialize(0.0, None).unwrap();
    for _ in 0..3 {
        system.step_to(system.time + 0.5).unwrap();
    }
    let real =
        |component: usize, name: &str| system.components[component].instance.value::<f64>(name).unwrap();
    assert_eq!(real(1, "f64.in[3,1]"), 15.0, "10 (0.5 + 1)");
    assert_eq!(real(1, "f64.in[1,2]"), 10.0, "10 (0 + 1)");
    assert_eq!((real(0, "f32.in[3]"), real(0, "f32.in[2]")), (11.0, 0.0), "only that element");
    assert_eq!(system.connections, 2);
    let message = |from: &str, to: &str| {
        assert!(structure.contains(from), "{from}");
        assembled(&structure.replacen(from, to, 1)).map_or_else(|error| error.whole(), |_| "read".to_owned())
    };
    let again =
        r#"<d:Connection startElement="a" startConnector="f64.out" endElement="b" endConnector="f64.in""#;
    for (from, to, expected) in [
        (r#"endIndices="3""#, r#"endIndices="4""#, r#""f32.in" has no element [4]: indices are from 1 on"#),
        (r#"endIndices="3""#, r#"endIndices="3 1""#, r#""f32.in" has 1 dimensions, not 2"#),
        (r#" endIndices="3""#, "", "a single value does not become an array of 3"),
        (r#" startIndices="2 1""#, "", "an array of 3 x 2 does not become a single value"),
        (
            r#"<c:Dimension size="2"/>"#,
            r#"<c:Dimension size="4"/>"#,
            "its <Dimension> says 4, but the FMU has 2 there",
        ),
        (r#"<c:Dimension size="2"/>"#, "", "it has 1 <Dimension>, but the FMU has an array of 2"),
        (
            r#"sizeConnector="n""#,
            r#"sizeConnector="m""#,
            r#"sizeConnector="m": the FMU has no such structural parameter"#,
        ),
        ("<c:Float32/>", "<c:Int8/>", "<Integer>, but the FMU says Real"),
        // An input that is fed twice: as a whole, and by an element.
        ("</d:Connections>", &format!("{again}/></d:Connections>"), "line 18 feeds this input already"),
        (
            "</d:Connections>",
            &format!(r#"{again} startIndices="1 1" endIndices="2 2"/></d:Connections>"#),
            "line 18 feeds this input already",
        ),
        (
            r#"<v:UInt64 value="3"/>"#,
            r#"<v:UInt64 value="99999999"/>"#,
            "n=99999999: the variables would have more than 8000000 values",
        ),
    ] {
        let message = message(from, to);
        assert!(message.contains(expected), "{to}: {message}");
    }
}
