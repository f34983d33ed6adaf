//! The numbers and drawings of docs/guide/physics.md are those of the engine.

#[path = "../examples/physics/cases.rs"]
mod cases;
#[path = "../examples/physics/drawings.rs"]
mod drawings;
#[path = "../examples/physics/numbers.rs"]
mod numbers;

use std::path::PathBuf;

fn guide() -> PathBuf {
    lemons_testing::repository().join("docs/guide")
}

#[test]
fn the_page_shows_these_numbers() {
    let page = std::fs::read_to_string(guide().join("physics.md")).unwrap();
    let text = numbers::text().unwrap();
    assert!(page.contains(&text), "docs/guide/physics.md must contain\n{text}");
}

#[test]
fn the_drawings_are_these() {
    let page = std::fs::read_to_string(guide().join("physics.md")).unwrap();
    for (name, svg) in drawings::all().unwrap() {
        let again = "docs/pictures.sh makes it again";
        assert!(std::fs::read_to_string(guide().join(name)).unwrap() == svg, "{name} differs: {again}");
        assert!(page.contains(&format!("]({name})")), "the page does not show {name}");
    }
}
