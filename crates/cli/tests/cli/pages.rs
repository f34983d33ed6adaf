//! Runs the pages of tests/cmd: shell commands, and what they print.
//!
//! In a block after ```` ```console ```` a line after `$ ` is given to bash in a directory that the commands of a page
//! share; lines after `> ` continue it. The lines that follow are what it prints on standard output and standard error.
//! `? 2` as the first of them is the exit code, `…` alone stands for lines that are left out, and `[..]` for a part of a
//! line. `$root` is the repository, `$shared` has Trials and FMUs that several pages use.
//!
//! `CMD_WRITE=1 cargo test -p lemons-cli pages` writes what is printed into the pages. `CMD=name` selects pages.

use crate::common::root;
use crate::coupling::controller::{DESCRIPTION, write_controller};
use lemons_core::trial::{Parameters, Trial};
use rayon::prelude::*;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// Beginnings of lines whose rest is a time that was measured.
const MEASURED: [&str; 4] = ["wall time ", "real-time factor ", "placed in ", "points per second "];

struct Step {
    command: String,
    /// As the page has it.
    expected: Vec<String>,
}

enum Part {
    Text(String),
    Step(Step),
}

fn parse(page: &str) -> Vec<Part> {
    let mut parts = Vec::new();
    let mut in_block = false;
    for line in page.lines() {
        if line.starts_with("```") {
            in_block = line == "```console";
            parts.push(Part::Text(line.to_owned()));
        } else if let Some(command) = line.strip_prefix("$ ").filter(|_| in_block) {
            parts.push(Part::Step(Step { command: command.to_owned(), expected: Vec::new() }));
        } else if let (Some(Part::Step(step)), true) = (parts.last_mut(), in_block) {
            match line.strip_prefix("> ") {
                Some(more) if step.expected.is_empty() => step.command += &format!("\n{more}"),
                _ => step.expected.push(line.to_owned()),
            }
        } else {
            parts.push(Part::Text(line.to_owned()));
        }
    }
    parts
}

fn run(step: &Step, place: &Path, shared: &Path) -> Vec<String> {
    let program = Path::new(env!("CARGO_BIN_EXE_lemons"));
    let path = format!("{}:{}", program.parent().unwrap().display(), std::env::var("PATH").unwrap());
    let mut bash = Command::new("bash");
    bash.args(["-c", &format!("set -o pipefail; exec 2>&1\n{}", step.command)]).current_dir(place);
    bash.env("PATH", path).env("root", root().canonicalize().unwrap()).env("shared", shared);
    let output = bash.env("LC_ALL", "C.UTF-8").output().unwrap();
    let mut text = String::from_utf8_lossy(&output.stdout).into_owned();
    let (built, root) = (program.parent().unwrap(), root().canonicalize().unwrap());
    for (long, short) in [(place, "[HERE]"), (shared, "[SHARED]"), (built, "[BUILT]"), (&root, "[ROOT]")] {
        text = text.replace(long.to_str().unwrap(), short);
    }
    text = text.replace(env!("CARGO_PKG_VERSION"), "[VERSION]");
    let code = output.status.code().unwrap_or(-1);
    let code = Some(format!("? {code}")).filter(|_| code != 0);
    let lines = text.lines().map(|line| match MEASURED.iter().find(|begin| line.starts_with(*begin)) {
        Some(begin) => format!("{begin}[..]"),
        None => line.to_owned(),
    });
    code.into_iter().chain(lines).collect()
}

fn line_matches(expected: &str, line: &str) -> bool {
    let Some((begin, rest)) = expected.split_once("[..]") else { return expected == line };
    let Some(line) = line.strip_prefix(begin) else { return false };
    line.char_indices().map(|(at, _)| at).chain([line.len()]).any(|at| line_matches(rest, &line[at..]))
}

fn matches(expected: &[String], lines: &[String]) -> bool {
    match expected.split_first() {
        None => lines.is_empty(),
        Some((first, rest)) if first == "…" => (0..=lines.len()).any(|k| matches(rest, &lines[k..])),
        Some((first, rest)) => lines.split_first().is_some_and(|(line, others)| {
            (line_matches(first, line) || first == line) && matches(rest, others)
        }),
    }
}

/// Runs a page. Returns what differs, and the page with what was printed.
fn run_page(page: &Path, shared: &Path) -> (String, String) {
    let directory = TempDir::new().unwrap();
    let place = directory.path().canonicalize().unwrap();
    let (mut different, mut now) = (String::new(), String::new());
    for part in parse(&std::fs::read_to_string(page).unwrap()) {
        match part {
            Part::Text(line) => now += &format!("{line}\n"),
            Part::Step(step) => {
                let lines = run(&step, &place, shared);
                let same = matches(&step.expected, &lines);
                let lines = lines.join("\n");
                if !same {
                    let expected = step.expected.join("\n");
                    let name = page.display();
                    write!(different, "{name}: $ {}\n{lines}\nexpected:\n{expected}\n\n", step.command)
                        .unwrap();
                }
                let shown = if same { step.expected.join("\n") } else { lines };
                let command = step.command.replace('\n', "\n> ");
                now += &format!("$ {command}\n{shown}{}", if shown.is_empty() { "" } else { "\n" });
            }
        }
    }
    (different, now)
}

/// Files that are made once: FMUs of a controller in C, variants that cannot be coupled, and the shipped Trials with a
/// longer mechanical step, which makes their runs short.
fn shared() -> TempDir {
    let directory = TempDir::new().unwrap();
    let at = |name: &str| directory.path().join(name);
    for name in ["push", "door"] {
        let (trial, _) = Trial::read(&root().join("resources").join(format!("Trial_{name}"))).unwrap();
        let trial =
            Trial { parameters: Parameters { time_step_mechanical: 1e-4, ..trial.parameters }, ..trial };
        trial.write(&at(name)).unwrap();
        for beside in ["drive.csv", "decision.toml"] {
            let file = trial.directory.join(beside);
            if file.exists() {
                std::fs::copy(file, at(name).join(beside)).unwrap();
            }
        }
    }
    write_controller(&at("controller.fmu"), DESCRIPTION, true);
    let unit = DESCRIPTION.replace("<Unit name=\"m\"><BaseUnit m=", "<Unit name=\"m\"><BaseUnit s=");
    write_controller(&at("other_unit.fmu"), &unit, false);
    write_controller(&at("exchange.fmu"), &DESCRIPTION.replace("<CoSimulation", "<ModelExchange"), false);
    directory
}

#[test]
fn commands_print_what_the_pages_say() {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cmd");
    let chosen = std::env::var("CMD").unwrap_or_default();
    let mut pages: Vec<PathBuf> =
        std::fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path()).collect();
    pages.retain(|page| page.file_stem().is_some_and(|name| name.to_string_lossy().contains(&chosen)));
    assert!(!pages.is_empty(), "no page has {chosen:?} in its name");
    let shared = shared();
    let place = shared.path().canonicalize().unwrap();
    let different = pages.par_iter().map(|page| {
        let (different, now) = run_page(page, &place);
        if !different.is_empty() && std::env::var_os("CMD_WRITE").is_some() {
            std::fs::write(page, now).unwrap();
        }
        different
    });
    let different: String = different.collect();
    assert!(different.is_empty(), "{different}");
}

#[test]
fn a_page_is_compared_line_by_line() {
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
    for (expected, printed, same) in [
        ("a\nb", "a\nb", true),
        ("a", "a\nb", false),
        ("a\nb", "a", false),
        ("a\n…\nd", "a\nb\nc\nd", true),
        ("a\n…\nd", "a\nb\nc", false),
        ("…", "", true),
        ("x [..] z", "x y y z", true),
        ("x [..] z", "x y", false),
    ] {
        assert_eq!(matches(&lines(expected), &lines(printed)), same, "{expected:?} {printed:?}");
    }
}
