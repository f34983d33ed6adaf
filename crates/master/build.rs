//! Builds the logger that FMUs call: it takes a variable number of arguments, which stable Rust cannot.

fn main() {
    println!("cargo::rerun-if-changed=src/logger.c");
    cc::Build::new().file("src/logger.c").compile("lemons_logger");
}
