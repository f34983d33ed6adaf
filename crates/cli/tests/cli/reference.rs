//! docs/command.md is what clap knows of the command; man pages and completions can be made.

#[path = "../../examples/reference/page.rs"]
mod page;

use clap_complete::Shell;
use std::path::Path;
use tempfile::TempDir;

#[test]
fn committed_reference_of_the_command_is_the_generated_one() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/command.md");
    let committed = std::fs::read_to_string(path).unwrap();
    assert!(
        committed == page::page(lemons_cli::definition()),
        "docs/command.md is not what the command says of itself. \
         Regenerate it: cargo run -p lemons-cli --example reference -- page docs/command.md"
    );
}

#[test]
fn man_pages_and_completions_are_made_for_every_command() {
    let directory = TempDir::new().unwrap();
    clap_mangen::generate_to(lemons_cli::definition(), directory.path()).unwrap();
    for command in lemons_cli::definition().get_subcommands() {
        let page = directory.path().join(format!("lemons-{}.1", command.get_name()));
        let text =
            std::fs::read_to_string(&page).unwrap_or_else(|error| panic!("{}: {error}", page.display()));
        assert!(text.contains("Example"), "{}", page.display());
    }
    clap_complete::generate_to(Shell::Bash, &mut lemons_cli::definition(), "lemons", directory.path())
        .unwrap();
    let bash = std::fs::read_to_string(directory.path().join("lemons.bash")).unwrap();
    assert!(bash.contains("--algorithm") && bash.contains("gauss-seidel"));
}
