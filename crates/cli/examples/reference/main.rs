//! Makes the reference of the command: docs/command.md, man pages, and completions for shells.
//!
//! ```sh
//! cargo run -p lemons-cli --example reference -- page docs/command.md
//! cargo run -p lemons-cli --example reference -- man DIRECTORY            # lemons.1, lemons-run.1, …
//! cargo run -p lemons-cli --example reference -- completions DIRECTORY    # bash, elvish, fish, PowerShell, zsh
//! ```

mod page;

use clap::ValueEnum;
use clap_complete::{Shell, generate_to};
use std::io;
use std::path::Path;
use std::process::ExitCode;

fn make(what: &str, place: &Path) -> io::Result<()> {
    match what {
        "page" => std::fs::write(place, page::page(lemons_cli::definition())),
        "man" => {
            std::fs::create_dir_all(place)?;
            clap_mangen::generate_to(lemons_cli::definition(), place)
        }
        "completions" => {
            std::fs::create_dir_all(place)?;
            Shell::value_variants().iter().try_for_each(|&shell| {
                generate_to(shell, &mut lemons_cli::definition(), "lemons", place).map(drop)
            })
        }
        _ => Err(io::Error::other("the first argument is page, man or completions")),
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [what, place] = &arguments[..] else {
        eprintln!("usage: reference page FILE, man DIRECTORY, or completions DIRECTORY");
        return ExitCode::from(2);
    };
    match make(what, Path::new(place)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("reference: {place}: {error}");
            ExitCode::FAILURE
        }
    }
}
