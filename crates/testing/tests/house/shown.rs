//! That circles are found, on small sources.

use super::circles::{Edge, circles};
use super::modules::Crate;
use std::path::Path;

/// The circles of a crate of these files, each as its level, its modules and its places.
fn found(files: &[(&str, &str)]) -> Vec<String> {
    let read = |path: &Path| {
        let file = files.iter().find(|(name, _)| path == Path::new(name));
        file.map(|(_, text)| (*text).to_owned())
    };
    let circles = Crate::read(Path::new(files[0].0), &read).circles();
    circles.into_iter().map(|(level, circle)| format!("{}: {circle}", level.join("::"))).collect()
}

const NONE: [&str; 0] = [];

#[test]
fn a_ring_by_super_is_found_with_its_files_and_lines() {
    let files = [
        ("src/lib.rs", "pub mod engine;"),
        ("src/engine/mod.rs", "mod contacts;\nmod neighbours;\nmod pairs;\nmod scene;"),
        ("src/engine/contacts.rs", "use super::pairs::Pairs;\npub struct Standing;\nfn f(_: Pairs) {}"),
        ("src/engine/neighbours.rs", "use super::contacts::Standing;\n\npub struct Circle(Standing);"),
        (
            "src/engine/pairs.rs",
            "use super::scene::Scene;\nuse super::neighbours::Circle;\npub struct Pairs(Circle, Scene);",
        ),
        ("src/engine/scene.rs", "pub struct Scene;"),
    ];
    assert_eq!(
        found(&files),
        ["engine: contacts -> pairs -> neighbours -> contacts\
        \n    src/engine/contacts.rs:1: super::pairs::Pairs\
        \n    src/engine/pairs.rs:2: super::neighbours::Circle\
        \n    src/engine/neighbours.rs:1: super::contacts::Standing"]
    );
}

#[test]
fn a_ring_by_crate_is_found_between_directories() {
    let files = [
        ("src/main.rs", "mod a;\nmod b;\nfn main() { a::deep::f() }"),
        ("src/a.rs", "pub mod deep;"),
        ("src/a/deep.rs", "pub fn f() {\n    crate::b::g()\n}"),
        ("src/b.rs", "use crate::a::{\n    deep::{self, f},\n};\npub fn g() {}"),
    ];
    let found = found(&files);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0], ": a -> b -> a\n    src/a/deep.rs:2: crate::b::g\n    src/b.rs:2: crate::a::deep");
}

/// A module and those in it are one thing, in which each may use what the others define.
#[test]
fn parent_and_child_are_no_circle() {
    let files = [
        ("src/lib.rs", "mod trial;\npub struct Problem;"),
        (
            "src/trial/mod.rs",
            "mod agents;\nuse agents::read;\npub struct Agent;\nfn f() { read(); self::agents::read() }",
        ),
        (
            "src/trial/agents.rs",
            "use super::Agent;\nuse crate::Problem;\npub fn read() -> (Agent, Problem) { crate::trial::f() }",
        ),
    ];
    assert_eq!(found(&files), NONE);
}

/// The parent passes on what they define.
#[test]
fn a_ring_behind_the_parents_names_is_found() {
    let passed_on = [
        ("src/lib.rs", "mod a;\nmod b;\npub use a::A;\npub use b::*;"),
        ("src/a.rs", "use crate::B;\npub struct A(B);"),
        ("src/b.rs", "pub struct B;\nfn f(_: super::A) {}"),
    ];
    let places = ": a -> b -> a\n    src/a.rs:1: crate::B\n    src/b.rs:2: super::A";
    assert_eq!(found(&passed_on), [places]);
    // One that is taken in with everything else that the parent has.
    let all = [
        passed_on[0],
        ("src/a.rs", "use super::*;\npub struct A(\n    B,\n);"),
        ("src/b.rs", "use crate::A as Renamed;\npub struct B;"),
    ];
    assert_eq!(found(&all), [": a -> b -> a\n    src/a.rs:3: B\n    src/b.rs:1: crate::A"]);
}

#[test]
fn tests_may_use_anything() {
    let b = ("src/b.rs", "use super::a::A;\npub struct B(A);");
    for test in [
        "#[cfg(test)]\nmod tests { use crate::b::B; }",
        "#[cfg(test)]\nuse crate::b::B;",
        "#[cfg(all(unix, test))]\nimpl A { fn b(_: crate::b::B) {} }",
        "#[test]\nfn f() { crate::b::g() }",
        "impl A { #[cfg(test)] fn b(_: crate::b::B) {} }",
    ] {
        let files = [("src/lib.rs", "mod a;\nmod b;"), ("src/a.rs", &format!("pub struct A;\n{test}")), b];
        assert_eq!(found(&files), NONE, "{test}");
        // The same without the mark.
        let unmarked = test.split_once(']').unwrap().1.replace("#[cfg(test)]", "");
        if !test.starts_with("impl") {
            let files = [files[0], ("src/a.rs", &format!("pub struct A;\n{unmarked}")), b];
            assert_eq!(found(&files).len(), 1, "{unmarked}");
        }
    }
    let not = [
        ("src/lib.rs", "mod a;\nmod b;"),
        ("src/a.rs", "pub struct A;\n#[cfg(not(test))]\nuse crate::b::B;"),
        b,
    ];
    assert_eq!(found(&not).len(), 1);
}

#[test]
fn macros_and_attributes_are_read() {
    let b = ("src/b.rs", "use crate::a::A;\npub struct B(A);\npub const MOST: f64 = 1.0;");
    for a in [
        "fn f() { println!(\"{}\", crate::b::MOST); }",
        "fn f() { assert!([1, super::b::MOST].len() > { 0 }) }",
        "macro_rules! of { ($x:expr) => { $crate::b::MOST * $x } }",
        "#[derive(clap::Args)]\nstruct G { #[arg(value_parser = crate::b::parse)] g: f64 }",
        "struct G { #[serde(default = \"crate::b::most\")] g: f64 }",
        "fn f<T: crate::b::Of>() {}",
        "fn f(x: u8) { match x { crate::b::MOST => {}, _ => {} } }",
        "fn f() { use super::b; b::g() }",
    ] {
        let files = [("src/lib.rs", "mod a;\nmod b;"), ("src/a.rs", &format!("pub struct A;\n{a}")), b];
        assert_eq!(found(&files).len(), 1, "{a}");
    }
    // A field, a lifetime and a word are no paths.
    let a = "pub struct A;\nuse crate::*;\nfn f() { say!(x.b, 'b, \"crate::b\") } // crate::b\n/// crate::b\nfn g() {}";
    assert_eq!(found(&[("src/lib.rs", "mod a;\nmod b;"), ("src/a.rs", a), b]), NONE);
}

#[test]
fn using_a_macro_is_using_its_module() {
    let files = [
        ("src/main.rs", "#[macro_use]\nmod tell;\nmod run;"),
        ("src/tell.rs", "macro_rules! say { () => {} }\nfn f() { crate::run::f() }"),
        ("src/run.rs", "pub fn f() {\n    say!();\n}"),
    ];
    let places = ": run -> tell -> run\n    src/run.rs:2: say\n    src/tell.rs:2: crate::run::f";
    assert_eq!(found(&files), [places]);
    let exported = [
        files[0],
        ("src/tell.rs", "#[macro_export]\nmacro_rules! say { () => {} }\nfn f() { crate::run::f() }"),
        ("src/run.rs", "pub fn f() { crate::say!() }"),
    ];
    assert_eq!(found(&exported).len(), 1);
}

#[test]
fn modules_are_found_where_attributes_put_them() {
    let files = [
        ("src/lib.rs", "#[path = \"other/a_unix.rs\"]\nmod a;\nmod b { #[path = \"d.rs\"]\npub mod c; }"),
        ("src/other/a_unix.rs", "mod inside;"),
        ("src/other/inside.rs", "use crate::b::c;"),
        ("src/b/d.rs", "use crate::a;"),
    ];
    let places = ": a -> b -> a\n    src/other/inside.rs:1: crate::b::c\n    src/b/d.rs:1: crate::a";
    assert_eq!(found(&files), [places]);
}

#[test]
fn imports_that_lead_round_end() {
    let files = [
        ("src/lib.rs", "mod a;\nmod b;"),
        ("src/a.rs", "pub use crate::b::*;\npub use crate::b::X;"),
        ("src/b.rs", "pub use crate::a::*;\npub use crate::a::X;"),
    ];
    assert_eq!(found(&files).len(), 1);
}

#[test]
fn every_circle_is_told_the_shortest_first() {
    let edge =
        |(from, to): (&str, &str)| Edge { from: from.into(), to: to.into(), place: format!("{from}{to}") };
    let edges = [("a", "b"), ("b", "c"), ("c", "a"), ("c", "d"), ("d", "c"), ("e", "a"), ("a", "a")];
    let told: Vec<String> = circles(edges.map(edge)).iter().map(ToString::to_string).collect();
    assert_eq!(told, ["c -> d -> c\n    cd\n    dc", "a -> b -> c -> a\n    ab\n    bc\n    ca"]);
}
