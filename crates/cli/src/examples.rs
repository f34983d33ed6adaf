//! Examples for the help of each command.

/// The examples of all commands, with an empty line between commands. A test asks clap whether it accepts them.
pub const EXAMPLES: &str = include_str!("help/examples.txt");

/// The examples of a command.
pub fn of_command(command: &str) -> Option<&'static str> {
    let is_own = |text: &&str| text.split([' ', '\n']).nth(1) == Some(command);
    EXAMPLES.split("\n\n").find(is_own).map(str::trim_end)
}

/// The help below the options: the examples, then what the command itself says there.
pub fn help_of(command: &str, own: Option<String>) -> String {
    let examples = of_command(command).unwrap_or_default();
    let heading = if examples.contains("\nlemons ") { "Examples:" } else { "Example:" };
    let examples: String = examples.lines().map(|line| format!("\n  {line}")).collect();
    let own = own.map(|own| format!("\n\n{own}")).unwrap_or_default();
    format!("{heading}{examples}{own}")
}
