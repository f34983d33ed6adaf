//! The table of columns beside the FMU's table of variables: the same outputs, units and types.

use crowd_mechanics::quantities::{Role, VariableType, scalars};
use crowd_mechanics::setup;
use lemons_results::columns::{ALL, Column, Group, QUANTITIES};
use std::collections::HashMap;
use std::path::Path;

#[test]
fn columns_are_outputs_of_the_fmu_in_its_units() {
    let push = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../resources/Trial_push");
    let (mut trial, _) = setup::read(&push).unwrap();
    trial.agents[0].chest_height = Some(1.3);
    let is_output = |role: Role| matches!(role, Role::Exact | Role::Calculated);
    let mut outputs: HashMap<String, VariableType> = scalars(&trial)
        .into_iter()
        .filter(|scalar| is_output(scalar.variable.role))
        .map(|scalar| (scalar.name, scalar.variable.kind))
        .collect();
    // Whether somebody is there is an input, and legs are of Decision.
    for quantity in QUANTITIES.iter().filter(|of| !matches!(of.group, Group::Active | Group::Legs)) {
        let of = if quantity.group == Group::Totals { "" } else { "agent[0]." };
        let name = format!("{of}{}", quantity.variable);
        match outputs.remove(&name).expect(&name) {
            VariableType::Real(of) => assert_eq!(Some(of.unit.name), quantity.unit, "{name}"),
            VariableType::Integer | VariableType::Boolean => assert_eq!(None, quantity.unit, "{name}"),
            VariableType::String => panic!("{name} is a text"),
        }
    }
    // Nothing that the FMU says of an agent is left out, but what is the rest of two others, and what only FMUs have.
    let left = outputs.keys().filter(|name| name.starts_with("agent[0]."));
    let others = [".MeanPeopleForce", ".Compression.front", ".Compression.side"];
    let left: Vec<&String> = left.filter(|name| !others.iter().any(|end| name.ends_with(end))).collect();
    assert!(left.is_empty(), "{left:?} are no columns");
}

/// For tests of programs in other languages. `COLUMNS_TABLE=write cargo test -p lemons-results --all-features --test record columns` writes it.
#[test]
fn the_committed_table_is_that_of_the_library() {
    let mut text = "name,unit,variable,description\n".to_owned();
    for Column { name, unit, variable, description, .. } in
        ALL.with(Group::Active, false).with(Group::Legs, false).with(Group::Chest, false).columns()
    {
        let cells = [name, unit.unwrap_or_default(), variable, description];
        assert!(cells.iter().all(|cell| !cell.contains(['"', '\n'])), "{cells:?}");
        let quoted = cells.map(|cell| if cell.contains(',') { format!("\"{cell}\"") } else { cell });
        text += &(quoted.join(",") + "\n");
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/columns.csv");
    if std::env::var_os("COLUMNS_TABLE").is_some_and(|what| what == "write") {
        std::fs::write(&path, &text).unwrap();
    }
    let again = "write it again: COLUMNS_TABLE=write cargo test -p lemons-results --all-features --test record columns";
    assert!(std::fs::read_to_string(&path).unwrap_or_default() == text, "{again}");
}
