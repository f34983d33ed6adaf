//! The `lemons` command.

fn main() {}
