//! The icons and diagrams of the FMUs are small files: an SVG made by hand, and the PNG that is drawn from it.

use lemons_picture::png;
use lemons_testing::repository;

/// `ICONS=write cargo test -p lemons-picture icons` draws them again.
#[test]
fn the_committed_ones_are_the_drawn_ones() {
    let both = ["src", "crates/decision/src"].into_iter();
    let both = both.flat_map(|directory| [("icon", 200), ("diagram", 760)].map(|of| (directory, of)));
    // Its icon is the crowd's.
    for (directory, (name, width)) in both.chain([("crates/summary/src", ("diagram", 760))]) {
        let file = |extension| repository().join(directory).join(name).with_extension(extension);
        let drawn = file("png");
        let bytes = png(&std::fs::read_to_string(file("svg")).unwrap(), width).unwrap();
        if std::env::var_os("ICONS").is_some_and(|what| what == "write") {
            std::fs::write(&drawn, &bytes).unwrap();
        }
        assert!(std::fs::read(&drawn).unwrap() == bytes, "{}: see docs/development.md", drawn.display());
    }
}
