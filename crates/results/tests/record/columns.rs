//! The table of columns beside the FMU's table of variables: the same outputs, units and types.

use crowd_mechanics::quantities::{Kind, Role, scalars};
use crowd_mechanics::setup;
use lemons_results::columns::{CONTACTS, Column, Groups, MOTION, OF_STEP, Quantity, SQUEEZE, TOTALS};
use std::collections::HashSet;
use std::path::Path;

fn is_output(role: Role) -> bool {
    matches!(role, Role::Exact | Role::Calculated)
}

#[test]
fn columns_are_outputs_of_the_fmu_in_its_units() {
    let push = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../resources/Trial_push");
    let (trial, _) = setup::read(&push).unwrap();
    let table = scalars(&trial);
    let check = |quantity: &Quantity, name: &str| {
        let variable =
            table.iter().find(|scalar| scalar.name == name).unwrap_or_else(|| panic!("{name}")).variable;
        assert!(is_output(variable.role), "{name}");
        match variable.kind {
            Kind::Real(unit) => assert_eq!(Some(unit.name), quantity.unit, "{name}"),
            Kind::Integer | Kind::Boolean => assert_eq!(None, quantity.unit, "{name}"),
            Kind::String => panic!("{name} is a text"),
        }
    };
    let of_agents: Vec<&Quantity> =
        MOTION.iter().chain(&CONTACTS).chain([&SQUEEZE]).chain(&OF_STEP).collect();
    of_agents.iter().for_each(|quantity| check(quantity, &format!("agent[0].{}", quantity.variable)));
    TOTALS.iter().for_each(|quantity| check(quantity, quantity.variable));
    // Nothing that the FMU says of an agent is left out.
    let known: HashSet<&str> = of_agents.iter().map(|quantity| quantity.variable).collect();
    let outputs = table.iter().filter(|scalar| is_output(scalar.variable.role));
    for name in outputs.filter_map(|scalar| scalar.name.strip_prefix("agent[0].")) {
        assert!(known.contains(name), "agent[0].{name} is no column");
    }
}

/// For tests of programs in other languages. `COLUMNS_TABLE=write cargo test -p lemons-results --all-features --test record columns` writes it.
#[test]
fn the_committed_table_is_that_of_the_library() {
    let groups = Groups { contacts: true, of_step: true, active: false, totals: true };
    let mut text = "name,unit,variable,description\n".to_owned();
    for Column { name, unit, variable, description, .. } in groups.columns() {
        let cells = [name, unit.unwrap_or_default(), variable, description];
        assert!(cells.iter().all(|cell| !cell.contains(['"', '\n'])), "{cells:?}");
        let quoted = |cell: &String| if cell.contains(',') { format!("\"{cell}\"") } else { cell.clone() };
        text += &cells.iter().map(quoted).collect::<Vec<_>>().join(",");
        text.push('\n');
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/columns.csv");
    if std::env::var_os("COLUMNS_TABLE").is_some_and(|what| what == "write") {
        std::fs::write(&path, &text).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        committed == text,
        "write it again: COLUMNS_TABLE=write cargo test -p lemons-results --all-features --test record columns"
    );
}
