//! docs/reference/trial.md has the elements that are read, and for each of them its attributes: these, and no others. What
//! it says of each is a test of tests/fmpy.

use crate::xml::Kind;
use crate::{agents, dynamics, geometry, interactions, materials, parameters};
use std::path::Path;

/// The cells of the first column of each table with this header, with the heading above the table.
fn tables<'a>(page: &'a str, header: &str) -> Vec<(&'a str, Vec<&'a str>)> {
    let (mut found, mut heading): (Vec<(&str, Vec<&str>)>, _) = (Vec::new(), "");
    let mut inside = false;
    for line in page.lines() {
        let first = line.strip_prefix("| ").and_then(|row| row.split(" | ").next());
        match first {
            Some(cell) if cell == header => {
                inside = true;
                found.push((heading, Vec::new()));
            }
            Some(cell) if inside => {
                found.last_mut().expect("the header comes first").1.push(cell.trim_matches('`'));
            }
            // The line below the header.
            _ => inside &= line.starts_with("|---"),
        }
        heading = line.strip_prefix("### ").unwrap_or(heading);
    }
    found
}

const ROOTS: [&Kind; 6] = [
    &parameters::PARAMETERS,
    &materials::MATERIALS,
    &geometry::GEOMETRY,
    &agents::AGENTS,
    &dynamics::AGENTS,
    &interactions::INTERACTIONS,
];

fn page() -> String {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/trial.md");
    std::fs::read_to_string(page).unwrap()
}

/// All elements below one, in the order of the page.
fn below(kind: &'static Kind) -> Vec<&'static Kind> {
    kind.children.iter().flat_map(|child| std::iter::once(*child).chain(below(child))).collect()
}

#[test]
fn the_page_has_all_attributes_and_no_others() {
    let page = page();
    assert!(ROOTS.iter().all(|root| root.attributes.is_empty()));
    // Lists of elements have no attributes, and no table.
    let read = ROOTS.into_iter().flat_map(below).filter(|kind| !kind.attributes.is_empty());
    let read: Vec<(&str, Vec<&str>)> = read.map(|kind| (kind.name, kind.attributes.to_vec())).collect();
    let shown = tables(&page, "attribute").into_iter();
    let shown: Vec<(&str, Vec<&str>)> = shown
        .map(|(heading, attributes)| (heading.split(' ').next().unwrap_or(heading), attributes))
        .collect();
    assert_eq!(shown, read);
}

#[test]
fn the_page_has_all_elements_and_no_others() {
    let page = page();
    let sorted = |mut names: Vec<String>| {
        names.sort();
        names
    };
    let shown = tables(&page, "element").into_iter();
    let shown: Vec<Vec<String>> =
        shown.map(|(_, names)| sorted(names.into_iter().map(str::to_owned).collect())).collect();
    let read = ROOTS.map(|root| sorted(below(root).iter().map(|kind| format!("<{}>", kind.name)).collect()));
    assert_eq!(shown, read);
}
