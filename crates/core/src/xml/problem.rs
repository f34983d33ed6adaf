//! Problems of a document, with their places.

use crate::message::{Message, message};
use crate::rule::{Rule, Severity, parts};
use std::fmt;
use std::path::{Path, PathBuf};

/// One error, warning or note about a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// The rule that has found it.
    pub rule: Rule,
    /// The file's path, beginning as the user gave it; empty if the text comes from no file.
    pub file: PathBuf,
    /// Line number, from 1.
    pub line: Option<u32>,
    /// Name of the XML element.
    pub element: Option<String>,
    /// Name of its attribute.
    pub attribute: Option<String>,
    /// The attribute's value, as written.
    pub value: Option<String>,
    /// Says what is wrong; the fields above say where.
    pub message: Message,
}

/// Result of a reader that stops at the first problem. The box keeps results small.
pub type Result<T> = std::result::Result<T, Box<Problem>>;

impl Problem {
    /// An error about a whole file, or about a line of it.
    pub fn of_file(file: &Path, line: Option<u32>, message: impl Into<Message>) -> Problem {
        Problem { line, ..Problem::by(Rule::Invalid, file, message) }
    }

    /// Returns a problem of a whole file.
    pub fn by(rule: Rule, file: &Path, message: impl Into<Message>) -> Problem {
        Problem {
            rule,
            file: file.to_owned(),
            line: None,
            element: None,
            attribute: None,
            value: None,
            message: message.into(),
        }
    }

    /// Returns whether the document can be used in spite of it.
    pub fn severity(&self) -> Severity {
        self.rule.row().severity
    }

    /// Says where it is: what is before the message.
    pub fn place(&self) -> String {
        let file = self.file.display();
        let mut place = match (self.file.as_os_str().is_empty(), self.line) {
            (false, Some(line)) => format!("{file}:{line}: "),
            (false, None) => format!("{file}: "),
            (true, Some(line)) => format!("line {line}: "),
            (true, None) => String::new(),
        };
        if let Some(element) = &self.element {
            let attribute = self.attribute.iter().map(|attribute| match &self.value {
                Some(value) => format!(" {attribute}={}", quoted(value)),
                None => format!(" {attribute}"),
            });
            place += &format!("<{element}>{}: ", attribute.collect::<String>());
        }
        place
    }

    /// Returns all of it as a message, with the word "warning" or "note".
    pub fn told(&self) -> Message {
        let (place, message) = (self.place(), &self.message);
        match self.severity() {
            Severity::Error => message!(parts::ERROR, place, message),
            Severity::Warning => message!(parts::WARNING, place, message),
            Severity::Note => message!(parts::NOTE, place, message),
        }
    }
}

impl std::error::Error for Problem {}

/// One line: `static/Agents.xml:12: <Shape> Radius="-0.1": must be positive`; `#` leaves out the word "warning" or "note".
impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if f.alternate() { write!(f, "{}{}", self.place(), self.message) } else { self.told().fmt(f) }
    }
}

/// Returns the text in quotes, on one line, cut to a readable length.
pub fn quoted(text: &str) -> String {
    const LONGEST: usize = 80;
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{:?}…", &text[..end]),
        None => format!("{text:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_problem_is_one_line_that_says_where() {
        let good = Problem {
            element: Some("Shape".into()),
            attribute: Some("Radius".into()),
            value: Some("-0.1".into()),
            ..Problem::of_file(Path::new("static/Agents.xml"), Some(12), "must be positive")
        };
        assert_eq!(good.to_string(), "static/Agents.xml:12: <Shape> Radius=\"-0.1\": must be positive");
        let nameless = Problem { file: PathBuf::new(), value: None, ..good.clone() };
        assert_eq!(nameless.to_string(), "line 12: <Shape> Radius: must be positive");
        let hostile = Problem { value: Some("é\n".repeat(100_000)), ..good.clone() }.to_string();
        assert!(hostile.len() < 400 && !hostile.contains('\n'), "{hostile}");
        let warning = Problem { rule: Rule::NotRead, attribute: None, line: None, ..good };
        assert_eq!(warning.to_string(), "warning: static/Agents.xml: <Shape>: must be positive");
        assert_eq!(format!("{warning:#}"), "static/Agents.xml: <Shape>: must be positive");
    }
}
