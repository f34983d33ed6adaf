//! Structures and archives, good and bad, as their users meet them.

use lemons_master::ssp::{
    Allowance, ArchiveReader, Interface, Participant, SystemStructure, Terminal, connect, write_archive,
};
use std::fs::File;
use std::io::Write;
use std::path::Path;
use tempfile::TempDir;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// As another tool might write it: other prefixes, system outputs, geometry, parameters in a file.
const FOREIGN: &str = include_str!("ssp_files/foreign.ssd");

const VALUES: &str = include_str!("ssp_files/values.ssv");

fn zip(path: &Path, files: &[(&str, &str)]) {
    let mut zip = ZipWriter::new(File::create(path).unwrap());
    for (name, text) in files {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    }
    zip.finish().unwrap();
}

fn read(structure: &str) -> Result<SystemStructure, String> {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("x.ssp");
    zip(&path, &[("SystemStructure.ssd", structure), ("values.ssv", VALUES)]);
    ArchiveReader::open(&path).unwrap().structure().map_err(|error| format!("{error:#}"))
}

#[test]
fn a_foreign_structure_is_read() {
    let structure = read(FOREIGN).unwrap();
    assert_eq!((structure.start, structure.stop), (Some(1.0), Some(2.5)));
    let [connection] = &structure.connections[..] else { panic!("{:?}", structure.connections) };
    let [from, to] =
        [&connection.from, &connection.to].map(|port| (&*structure.port(port).0.name, &*port.connector));
    assert_eq!((from, to), (("a", "y"), ("b", "u")), "from the output to the input");
    assert_eq!(connection.transformation.unwrap().apply(3.0), -6.0);
    assert!(connection.suppress_unit_conversion);
    assert_eq!(structure.units["m"].exponents[1], 1);
    assert_eq!(structure.parameters[0].name, "a.k");
}

/// Returns the text that is replaced in a file, its replacement, and the message.
fn mistakes(file: &str) -> Vec<(String, String, String)> {
    let all = include_str!("ssp_files/mistakes.txt");
    let (_, own) = all.split_once(&format!("[{file}]\n")).unwrap();
    let own = own.split("\n\n[").next().unwrap();
    let lines: Vec<String> =
        own.lines().map(|line| line.get(2..).unwrap_or_default().replace("\\n", "\n")).collect();
    let rows: Vec<_> = lines.chunks(3).map(|row| (row[0].clone(), row[1].clone(), row[2].clone())).collect();
    assert!(rows.len() > 10, "{file}");
    rows
}

#[test]
fn hostile_descriptions_are_refused_by_element_attribute_and_value() {
    let good = include_str!("ssp_files/modelDescription.xml");
    for (from, to, words) in mistakes("modelDescription.xml") {
        assert!(good.contains(&from), "{from}");
        let read = Interface::read(good.replacen(&from, &to, 1).as_bytes());
        let message = read.map_or_else(|error| error.to_string(), |_| "read".to_owned());
        assert!(message.starts_with("modelDescription.xml:") && message.contains(&words), "{to}: {message}");
    }
}

#[test]
fn what_is_wrong_or_not_served_is_named() {
    for (from, to, words) in mistakes("foreign.ssd") {
        assert!(FOREIGN.contains(&from), "{from}");
        let message = read(&FOREIGN.replacen(&from, &to, 1)).expect_err(&to);
        assert!(message.contains(&words) && message.contains("SystemStructure.ssd"), "{to}: {message}");
        assert!(message.lines().count() == 1, "{message}");
    }
    let broken = read(&FOREIGN.replace("values.ssv", "SystemStructure.ssd")).unwrap_err();
    assert!(broken.contains("the root element must be <ParameterSet>"), "{broken}");
}

#[test]
fn archives_are_checked_before_anything_is_taken_out() {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("x.ssp");
    let message = |files: &[(&str, &str)]| {
        zip(&path, files);
        let read = ArchiveReader::open(&path).and_then(|mut archive| archive.structure());
        read.unwrap_err().whole()
    };
    let outside = message(&[("SystemStructure.ssd", FOREIGN), ("values.ssv", VALUES), ("../x", "")]);
    assert!(outside.contains("the entry \"../x\" leads outside"), "{outside}");
    assert!(message(&[("other.ssd", FOREIGN)]).contains("there is no SystemStructure.ssd in the archive"));
    assert!(message(&[("SystemStructure.ssd", FOREIGN)]).contains("there is no values.ssv"));
    zip(&path, &[("SystemStructure.ssd", FOREIGN), ("values.ssv", VALUES), ("resources/a b.fmu", "it")]);
    let mut copied = Vec::new();
    let mut archive = ArchiveReader::open(&path).unwrap();
    let mut allowance = Allowance::new(3);
    archive.copy("./resources/a%20b.fmu", &mut copied, &mut allowance).unwrap();
    assert_eq!(copied, b"it");
    let message = archive.copy("resources/a b.fmu", &mut copied, &mut allowance).unwrap_err().to_string();
    assert!(message.contains("resources/a b.fmu: is refused: more than"), "{message}");
    // An archive cut in the middle.
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    assert!(ArchiveReader::open(&path).is_err());
}

#[test]
fn archives_that_unpack_to_a_lot_are_refused() {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("x.ssp");
    let message = |structure: &str, values: &str| {
        zip(&path, &[("SystemStructure.ssd", structure), ("values.ssv", values)]);
        assert!(path.metadata().unwrap().len() < 1_000_000, "it is a small file");
        ArchiveReader::open(&path).unwrap().structure().unwrap_err().whole()
    };
    let spaces = " ".repeat(64_000_000);
    let large = message(&format!("{FOREIGN}{spaces}"), VALUES);
    assert_eq!(large, "SystemStructure.ssd: is refused: more than 64 MB to unpack in all");
    let large = message(FOREIGN, &spaces);
    assert!(large.contains("source=\"values.ssv\": values.ssv: is refused: more than 64 MB"), "{large}");
    // Small as a text, large as a tree.
    let elements = FOREIGN.replacen("<Elements>", &format!("<Elements>{}", "<a/>".repeat(4_000_000)), 1);
    let large = message(&elements, VALUES);
    assert!(large.contains("nodes limit reached"), "{large}");
}

/// A model description of Reals: name, causality, unit.
fn interface(variables: &[(&str, &str, &str)], units: &str) -> Interface {
    let variables: String = variables
        .iter()
        .enumerate()
        .map(|(k, (name, causality, unit))| {
            let of = match *unit {
                "Integer" => "<Integer/>".to_owned(),
                "" => "<Real/>".to_owned(),
                unit => format!("<Real unit=\"{unit}\"/>"),
            };
            format!(r#"<ScalarVariable name="{name}" valueReference="{k}" causality="{causality}">{of}</ScalarVariable>"#)
        })
        .collect();
    let text = format!(
        "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"m\" guid=\"g\"><CoSimulation \
         modelIdentifier=\"m\"/><UnitDefinitions>{units}</UnitDefinitions>\
         <ModelVariables>{variables}</ModelVariables></fmiModelDescription>"
    );
    Interface::read(text.as_bytes()).unwrap()
}

const METRE: &str = r#"<Unit name="m"><BaseUnit m="1"/></Unit>"#;

fn connected(interfaces: &[Interface]) -> Result<lemons_master::ssp::Connected, String> {
    chosen(interfaces, &[])
}

fn chosen(interfaces: &[Interface], by: &[[&str; 2]]) -> Result<lemons_master::ssp::Connected, String> {
    by_terminals(interfaces, &[], by)
}

/// With the terminals of the first few, as XML.
fn by_terminals(
    interfaces: &[Interface],
    terminals: &[&str],
    by: &[[&str; 2]],
) -> Result<lemons_master::ssp::Connected, String> {
    let of = |place: usize| {
        terminals.get(place).map_or_else(Vec::new, |inner| {
            let text = format!("<fmiTerminalsAndIcons><Terminals>{inner}</Terminals></fmiTerminalsAndIcons>");
            Terminal::read(text.as_bytes()).unwrap()
        })
    };
    let participants: Vec<Participant> = interfaces
        .iter()
        .zip(["a", "b", "c"])
        .enumerate()
        .map(|(place, (interface, name))| Participant {
            name: name.into(),
            source: format!("resources/{name}.fmu"),
            interface,
            terminals: of(place),
        })
        .collect();
    let by: Vec<(String, String)> = by.iter().map(|[from, to]| ((*from).into(), (*to).into())).collect();
    connect("test", &participants, &by).map_err(|error| format!("{error:#}"))
}

#[test]
fn equal_names_are_connected_and_written_the_same_each_time() {
    let a = interface(
        &[("x", "output", "m"), ("f", "input", ""), ("p", "parameter", "m"), ("g", "input", "")],
        METRE,
    );
    let b = interface(&[("x", "input", "m"), ("f", "output", "m"), ("x2", "output", "m")], METRE);
    let c = interface(&[("x", "input", ""), ("p", "input", "")], "");
    let interfaces = [a, b, c];
    let made = connected(&interfaces).unwrap();
    let own = |from, to, name: &str| (from, to, name.to_owned());
    assert_eq!(made.connections, [own(1, 0, "f"), own(0, 1, "x"), own(0, 2, "x")], "one output may feed two");
    assert_eq!(made.unconnected, [vec!["g".to_owned()], vec![], vec!["p".to_owned()]]);
    let text = &made.structure;
    assert_eq!(*text, connected(&interfaces).unwrap().structure);
    assert_eq!(text.matches("<ssc:Unit ").count(), 1, "{text}");
    assert_eq!(read(text).unwrap().connections.len(), 3);

    let directory = TempDir::new().unwrap();
    let fmu = directory.path().join("a.fmu");
    std::fs::write(&fmu, "bytes").unwrap();
    let [first, second] = ["1.ssp", "2.ssp"].map(|name| {
        let path = directory.path().join(name);
        write_archive(&path, &made.structure, &[("resources/a.fmu".into(), fmu.as_path())]).unwrap();
        std::fs::read(path).unwrap()
    });
    assert!(first == second);
    let missing = directory.path().join("none.fmu");
    let path = directory.path().join("3.ssp");
    assert!(write_archive(&path, &made.structure, &[("resources/a.fmu".into(), missing.as_path())]).is_err());
    assert!(!path.exists());
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 3, "no temporary file is left");
}

#[test]
fn what_cannot_be_connected_is_said() {
    let message = |interfaces: &[Interface]| connected(interfaces).map(drop).unwrap_err();
    let sends = |unit: &str, units: &str| interface(&[("x", "output", unit)], units);
    let takes = |unit: &str, units: &str| interface(&[("x", "input", unit)], units);
    assert_eq!(
        message(&[sends("km", METRE), takes("m", METRE)]),
        r#"x, from a to b: the output is in "km", the input in "m", as each FMU defines its unit"#
    );
    let other = METRE.replace("m=\"1\"", "m=\"1\" factor=\"2\"");
    assert_eq!(
        message(&[sends("m", METRE), takes("m", &other)]),
        r#"x, from a to b: the output is in "m", the input in "m", as each FMU defines its unit"#
    );
    // The same unit by another name agrees.
    let metre = METRE.replace("\"m\"", "\"metre\"");
    assert!(connected(&[sends("metre", &metre), takes("m", METRE)]).is_ok());
    assert_eq!(
        message(&[sends("Integer", ""), takes("m", METRE)]),
        "x, from a to b: Integer does not become Real"
    );
    assert_eq!(
        message(&[sends("m", METRE), takes("m", METRE), sends("m", METRE)]),
        "the input x of b is fed by two outputs, of a and of c"
    );
    assert_eq!(
        message(&[sends("m", METRE), interface(&[("y", "input", "m")], METRE)]),
        "no output has the name of an input of another FMU: nothing to connect\n\
         a: 1 outputs: x\na: 0 inputs\nb: 0 outputs\nb: 1 inputs: y"
    );
    let names: Vec<String> = (0..9).map(|i| format!("x{i}")).collect();
    let all = |causality, unit| {
        interface(&names.iter().map(|name| (name.as_str(), causality, unit)).collect::<Vec<_>>(), METRE)
    };
    let message = message(&[all("output", "m"), all("input", "km")]);
    assert_eq!(message.lines().count(), 6, "{message}");
    assert!(message.ends_with("… and 4 more like these"), "{message}");
}

/// Of FMI 3.0: two people, their positions and whatever else is said.
fn people(causality: [&str; 2], size: usize, more: &str) -> Interface {
    let [position, force] = causality;
    let text = format!(
        r#"<fmiModelDescription fmiVersion="3.0" modelName="m" instantiationToken="t"><CoSimulation modelIdentifier="m"/>
        <UnitDefinitions>{METRE}</UnitDefinitions><ModelVariables>
        <UInt64 name="Agents" valueReference="1" causality="structuralParameter" start="{size}"/>
        <Float64 name="Position" valueReference="2" causality="{position}" unit="m"><Dimension valueReference="1"/>
        <Dimension start="2"/></Float64>
        <Float64 name="Mp" valueReference="3" causality="{force}"><Dimension valueReference="1"/></Float64>{more}
        </ModelVariables></fmiModelDescription>"#
    );
    Interface::read(text.as_bytes()).unwrap()
}

#[test]
fn arrays_are_connected_whole_where_both_have_them() {
    let decides = people(["input", "output"], 2, "");
    let more = r#"<Int32 name="Count" valueReference="7" causality="output"><Dimension start="3"/></Int32>
        <Float64 name="free" valueReference="8" causality="input"><Dimension start="2"/></Float64>"#;
    let moves = people(["output", "input"], 2, more);
    let made = connected(&[decides, moves]).unwrap();
    assert_eq!(made.connections, [(1, 0, "Position".to_owned()), (0, 1, "Mp".to_owned())]);
    assert_eq!(made.unconnected, [vec![], vec!["free[1]".to_owned(), "free[2]".to_owned()]]);
    let text = &made.structure;
    for part in [
        r#" version="2.0""#,
        r#"<ssd:Connector name="Agents" kind="structuralParameter">"#,
        r#"<ssc:UInt64/>"#,
        r#"<ssc:Float64 unit="m"/>"#,
        r#"<ssc:Dimension sizeConnector="Agents"/>"#,
        r#"<ssc:Dimension size="2"/>"#,
        r#"<ssd:Connection startElement="b" startConnector="Position" endElement="a" endConnector="Position"/>"#,
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(text.contains(r#"name="Count""#) && !text.contains(r#"name="free""#), "{text}");
    assert_eq!(read(text).unwrap().components[0].connectors["Position"].dimensions.len(), 2);
}

#[test]
fn arrays_of_one_name_and_shape_are_connected_however_their_sizes_are_called() {
    let fixed = |size: &str, causality: &str| {
        let text = format!(
            r#"<fmiModelDescription fmiVersion="3.0" modelName="m" instantiationToken="t"><CoSimulation modelIdentifier="m"/>
            <ModelVariables><UInt64 name="N" valueReference="1" causality="structuralParameter" start="2"/>
            <Float64 name="Position" valueReference="2" causality="{causality}">{size}<Dimension start="2"/></Float64>
            </ModelVariables></fmiModelDescription>"#
        );
        Interface::read(text.as_bytes()).unwrap()
    };
    let moves = || people(["output", "input"], 2, "");
    for size in [r#"<Dimension start="2"/>"#, r#"<Dimension valueReference="1"/>"#] {
        let made = connected(&[fixed(size, "input"), moves()]).unwrap();
        assert_eq!(made.connections, [(1, 0, "Position".to_owned())]);
        assert!(read(&made.structure).unwrap().connections[0].to.indices.is_empty());
        let twice = connected(&[fixed(size, "output"), moves(), people(["input", "output"], 2, "")]);
        assert_eq!(
            twice.map(drop).unwrap_err(),
            "the input Position of c is fed by two outputs, of a and of b"
        );
    }
    let other = connected(&[fixed(r#"<Dimension start="3"/>"#, "input"), moves()]);
    assert!(other.map(drop).unwrap_err().starts_with("no output has the name"));
}

/// Of a controller with single values.
#[test]
fn single_outputs_can_be_chosen_in_place_of_an_array() {
    let single = interface(&[("agent[0].Mp", "output", ""), ("agent[1].Mp", "output", "")], METRE);
    let three = [people(["input", "output"], 2, ""), single, people(["output", "input"], 2, "")];
    let message = chosen(&three, &[]).map(drop).unwrap_err();
    assert_eq!(message, "the input agent[0].Mp of c is fed by two outputs, of a and of b");
    let made = chosen(&three, &[["b.agent[*].Mp", "c.agent[*].Mp"]]).unwrap();
    let forces: Vec<_> = made.connections.iter().filter(|(.., name)| name.contains("Mp")).collect();
    assert!(forces.len() == 2 && forces.iter().all(|(from, to, _)| (*from, *to) == (1, 2)), "{forces:?}");
}

/// A controller between two others.
#[test]
fn outputs_can_be_chosen_for_inputs_of_other_names() {
    let more = r#"<Float64 name="Wanted" valueReference="9" causality="input"><Dimension valueReference="1"/></Float64>"#;
    let three = [
        people(["input", "output"], 2, ""),
        people(["input", "output"], 2, more),
        people(["output", "input"], 2, ""),
    ];
    let message = |by: &[[&str; 2]]| chosen(&three, by).map(drop).unwrap_err();
    assert_eq!(message(&[]), "the input Mp of c is fed by two outputs, of a and of b");
    let last = ["b.Mp", "c.Mp"];
    for inner in [["a.Mp", "b.Wanted"], ["a.agent[*].Mp", "b.agent[*].Wanted"]] {
        let made = chosen(&three, &[inner, last]).unwrap();
        let forces: Vec<_> =
            made.connections.iter().filter(|(.., name)| !name.contains("Position")).collect();
        assert!(forces.iter().any(|(from, to, name)| (*from, *to) == (0, 1) && name.contains("Wanted")));
        assert_eq!(forces.last(), Some(&&(1, 2, "Mp".to_owned())));
        assert!(made.unconnected.iter().all(Vec::is_empty), "{:?}", made.unconnected);
        let read = read(&made.structure).unwrap();
        let wanted = read.connections.iter().filter(|connection| connection.to.connector == "Wanted");
        assert!(wanted.map(|connection| &connection.from.connector).all(|from| from == "Mp"));
    }
    assert_eq!(message(&[["a.Mp", "b.Unknown"], last]), "b.Unknown: no component has this input");
    assert_eq!(message(&[["b.Wanted", "c.Mp"]]), "b.Wanted: no component has this output");
    assert_eq!(message(&[last, ["a.Mp", "c.Mp"]]), "c.Mp: two outputs are chosen for this input");
    let both = message(&[["a.Mp", "b.Wanted"], ["a.agent[*].Mp", "b.agent[*].Wanted"], last]);
    assert_eq!(both, "b.Wanted: outputs are chosen for all of it and for elements");
    let shape = message(&[["c.Position", "b.Wanted"], last]);
    assert_eq!(shape, "b.Wanted: Position is no array of the same sizes");
}

#[test]
fn single_values_are_connected_with_elements_of_arrays() {
    let names = ["agent[0].Position.x", "agent[0].Position.y", "agent[1].Position.x", "agent[1].Position.y"];
    let decides = interface(
        &[
            (names[0], "input", "m"),
            (names[1], "input", "m"),
            (names[2], "input", "m"),
            ("agent[1].Mp", "output", ""),
        ],
        METRE,
    );
    let made = connected(&[decides, people(["output", "input"], 2, "")]).unwrap();
    let connected_names: Vec<&str> = made.connections.iter().map(|(.., name)| name.as_str()).collect();
    assert_eq!(connected_names, [names[0], names[1], names[2], "agent[1].Mp"]);
    assert_eq!(made.unconnected[1], ["agent[0].Mp"]);
    let text = &made.structure;
    for part in [
        r#" version="2.0""#,
        r#"startConnector="Position" startIndices="2 1" endElement="a" endConnector="agent[1].Position.x"/>"#,
        r#"startElement="a" startConnector="agent[1].Mp" endElement="b" endConnector="Mp" endIndices="2"/>"#,
        "<ssc:Real unit=\"m\"/>",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let again = read(text).unwrap();
    let indices: Vec<_> =
        again.connections.iter().map(|c| (c.from.indices.clone(), c.to.indices.clone())).collect();
    assert_eq!(
        indices,
        [(vec![1, 1], vec![]), (vec![1, 2], vec![]), (vec![2, 1], vec![]), (vec![], vec![2])]
    );
    // Crowds of other sizes have other people.
    let three = connected(&[people(["input", "output"], 3, ""), people(["output", "input"], 2, "")]).unwrap();
    assert_eq!(three.unconnected[0], ["agent[2].Position.x", "agent[2].Position.y"]);
    assert_eq!(three.connections.len(), 6, "each element by itself");
}

/// A terminal of a kind: members and their variables.
fn terminal(kind: &str, rule: &str, members: &[[&str; 2]]) -> String {
    let member = |[member, variable]: &[&str; 2]| {
        format!(r#"<TerminalMemberVariable variableName="{variable}" memberName="{member}"/>"#)
    };
    let members: String = members.iter().map(member).collect();
    format!(r#"<Terminal name="t" matchingRule="{rule}" terminalKind="{kind}">{members}</Terminal>"#)
}

#[test]
fn terminals_of_one_kind_connect_variables_of_other_names() {
    let crowd = interface(&[("F", "input", "m"), ("x", "output", "m"), ("y", "output", "m")], METRE);
    let other = interface(&[("force", "output", "m"), ("place", "input", "m"), ("y", "input", "m")], METRE);
    let both = [crowd, other];
    let ends = |made: lemons_master::ssp::Connected| {
        let mut ends: Vec<_> = made.connections.into_iter().map(|(from, _, to)| (from, to)).collect();
        ends.sort();
        ends.into_iter().map(|(from, to)| format!("{from} {to}")).collect::<Vec<_>>()
    };
    let own = [["F", "F"], ["x", "x"]];
    let theirs = [["x", "place"], ["F", "force"]];
    for (rules, kinds, expected) in [
        (["bus", "bus"], ["k", "k"], vec!["0 place", "0 y", "1 F"]),
        (["plug", "bus"], ["k", "k"], vec!["0 place", "0 y", "1 F"]),
        // The first members are two inputs, or the second ones two outputs: nothing to connect.
        (["sequence", "sequence"], ["k", "k"], vec!["0 y"]),
        (["bus", "sequence"], ["k", "k"], vec!["0 y"]),
        (["none", "none"], ["k", "k"], vec!["0 y"]),
        (["bus", "bus"], ["k", "l"], vec!["0 y"]),
    ] {
        let terminals = [terminal(kinds[0], rules[0], &own), terminal(kinds[1], rules[1], &theirs)];
        let made = by_terminals(&both, &terminals.each_ref().map(String::as_str), &[]).unwrap();
        assert_eq!(ends(made), expected, "{rules:?} {kinds:?}");
    }
    let terminals =
        [terminal("k", "sequence", &own), terminal("k", "sequence", &[["", "force"], ["", "place"]])];
    let made = by_terminals(&both, &terminals.each_ref().map(String::as_str), &[]).unwrap();
    assert_eq!(ends(made), ["0 place", "0 y", "1 F"]);
    // What the user says comes first.
    let made = by_terminals(&both, &terminals.each_ref().map(String::as_str), &[["a.y", "b.place"]]).unwrap();
    assert_eq!(ends(made), ["0 place", "0 y", "1 F"]);
    assert!(ends(chosen(&both, &[["a.x", "b.place"]]).unwrap()).contains(&"0 place".to_owned()));

    let third = interface(&[("push", "output", "m")], METRE);
    let [crowd, other] = both;
    let third_terminal = terminal("k", "bus", &[["F", "push"]]);
    let terminals = [terminal("k", "bus", &own), terminal("k", "bus", &theirs), third_terminal];
    let all = [crowd, other, third];
    let terminals = terminals.each_ref().map(String::as_str);
    let message = by_terminals(&all, &terminals, &[]).map(|_| ()).unwrap_err();
    assert_eq!(message, "a.F: terminals give it two outputs, b.force and c.push; choose one of them");
    let made = by_terminals(&all, &terminals, &[["c.push", "a.F"]]).map(ends);
    assert_eq!(made, Ok(vec!["0 place".to_owned(), "0 y".to_owned(), "2 F".to_owned()]));
}

#[test]
fn broken_terminals_are_refused() {
    for (text, message) in [
        (
            "<a/>",
            "terminalsAndIcons/terminalsAndIcons.xml:1: <a>: the root element must be <fmiTerminalsAndIcons>",
        ),
        ("<fmiTerminalsAndIcons><Terminals><Terminal/></Terminals></fmiTerminalsAndIcons>", "matchingRule"),
    ] {
        let error = Terminal::read(text.as_bytes()).unwrap_err().whole();
        assert!(error.contains(message), "{error}");
    }
    let twice = terminal("k", "bus", &[["x", "a"], ["x", "b"]]);
    let text = format!("<fmiTerminalsAndIcons><Terminals>{twice}</Terminals></fmiTerminalsAndIcons>");
    let error = Terminal::read(text.as_bytes()).unwrap_err().whole();
    assert!(error.contains("memberName=\"x\": another member of the terminal has this name"), "{error}");
}
