//! The build script of the engine and the FMU, which do not depend on a commit: so nothing is found out here. What the
//! command says of its sources, crates/cli/build.rs finds out.

fn main() {
    // Without it cargo would look at all files of the package, and build it again for a change of any.
    println!("cargo::rerun-if-changed=build.rs");
}
