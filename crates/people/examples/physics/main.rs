//! Draws the pictures of docs/guide/physics.md into a directory, and prints the numbers of that page.
//!
//! `cargo run --release -p lemons-people --example physics -- docs/guide`

mod cases;
mod drawings;
mod numbers;

use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let directory = PathBuf::from(std::env::args_os().nth(1).ok_or("which directory?")?);
    for (name, svg) in drawings::all()? {
        std::fs::write(directory.join(name), svg)?;
    }
    print!("{}", numbers::text()?);
    Ok(())
}
