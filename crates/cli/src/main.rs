//! The `lemons` command; all of it is in the library of this package.

use std::process::ExitCode;

fn main() -> ExitCode {
    lemons_cli::main()
}
