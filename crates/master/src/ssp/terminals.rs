//! The terminals of an FMU: variables that belong together, and their names for whoever connects them.
//!
//! SSP 2.0 has no terminals, so they only say which variables are connected.

use crate::error::{Result, require};
use lemons_core::xml::{Document, Element};
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// Where an archive holds them, in FMI 3.0 and from FMI 2.0.4 on.
pub(crate) const TERMINALS_FILE: &str = "terminalsAndIcons/terminalsAndIcons.xml";
/// \[byte\] Of this file.
pub(crate) const LARGEST_TERMINALS: u64 = 64_000_000;
/// Elements and texts of it.
const NODES: u32 = 2_000_000;

/// A `<Terminal>` that has a kind, and members that are matched by their names or places.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Terminal {
    /// `terminalKind`: only terminals of one kind fit together.
    kind: String,
    matching: Matching,
    /// Names of members, and of their variables.
    members: Vec<(String, String)>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Matching {
    /// `plug` and `bus`
    Names,
    /// `sequence`
    Places,
}

impl Terminal {
    /// Reads the terminals in `terminalsAndIcons.xml`, without those that are nested, have no kind, or match by a rule
    /// of a tool.
    ///
    /// # Errors
    /// It is not such a file.
    pub fn read(bytes: &[u8]) -> Result<Vec<Terminal>> {
        let document = Document::parse(Path::new(TERMINALS_FILE), bytes, NODES)?;
        let terminals = document.root("fmiTerminalsAndIcons")?.child("Terminals");
        let elements = terminals.into_iter().flat_map(|terminals| terminals.children("Terminal"));
        elements.filter_map(|element| Terminal::of(element).transpose()).collect()
    }

    fn of(element: Element<'_>) -> Result<Option<Terminal>> {
        let matching = match element.text("matchingRule")? {
            "plug" | "bus" => Matching::Names,
            "sequence" => Matching::Places,
            _ => return Ok(None),
        };
        let Some(kind) = element.optional("terminalKind") else { return Ok(None) };
        let mut names = HashSet::new();
        let mut members = Vec::new();
        for member in element.children("TerminalMemberVariable") {
            let name = match matching {
                Matching::Names => member.text("memberName")?,
                Matching::Places => member.optional("memberName").unwrap_or_default(),
            };
            require(matching == Matching::Places || names.insert(name), || {
                member.wrong("memberName", "another member of the terminal has this name").to_string()
            })?;
            members.push((name.to_owned(), member.text("variableName")?.to_owned()));
        }
        Ok(Some(Terminal { kind: kind.to_owned(), matching, members }))
    }

    /// Returns the pairs of variables, of this terminal and of another one that it fits.
    pub(super) fn pairs<'a>(&'a self, other: &'a Terminal) -> Vec<(&'a str, &'a str)> {
        if (&self.kind, self.matching) != (&other.kind, other.matching) {
            return Vec::new();
        }
        let variables = |((_, own), (_, of_other)): (&'a (String, String), &'a (String, String))| {
            (own.as_str(), of_other.as_str())
        };
        if self.matching == Matching::Places {
            return self.members.iter().zip(&other.members).map(variables).collect();
        }
        let named: HashMap<&str, &(String, String)> =
            other.members.iter().map(|member| (member.0.as_str(), member)).collect();
        let found = |member: &'a (String, String)| Some((member, *named.get(member.0.as_str())?));
        self.members.iter().filter_map(found).map(variables).collect()
    }
}
