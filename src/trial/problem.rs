//! What can be wrong with a Trial.

use std::fmt;
use std::path::PathBuf;

/// Whether a Trial with the problem can be run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// It cannot.
    Error,
    /// It can, but perhaps not as meant.
    Warning,
}

/// One thing wrong with a file of the Trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// Error or warning.
    pub severity: Severity,
    /// The file's path, from the Trial's directory as it was given.
    pub file: PathBuf,
    /// Counted from 1.
    pub line: Option<u32>,
    /// Name of the XML element.
    pub element: Option<String>,
    /// Name of its attribute.
    pub attribute: Option<String>,
    /// The attribute's value, as written.
    pub value: Option<String>,
    /// What is wrong; the fields above are its subject.
    pub message: String,
}

/// One line: `static/Agents.xml:12: <Shape> Radius="-0.1": must be positive`
impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.severity == Severity::Warning {
            write!(f, "warning: ")?;
        }
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        write!(f, ": ")?;
        if let Some(element) = &self.element {
            write!(f, "<{element}>")?;
            if let Some(attribute) = &self.attribute {
                write!(f, " {attribute}")?;
                if let Some(value) = &self.value {
                    write!(f, "={}", quoted(value))?;
                }
            }
            write!(f, ": ")?;
        }
        write!(f, "{}", self.message)
    }
}

/// In quotes, on one line, cut to a length that a reader takes in.
pub(super) fn quoted(text: &str) -> String {
    const LONGEST: usize = 80;
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{:?}…", &text[..end]),
        None => format!("{text:?}"),
    }
}

/// Everything found wrong, in the order in which the files are read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Problems(Vec<Problem>);

impl Problems {
    /// Adds one.
    pub fn push(&mut self, problem: Problem) {
        self.0.push(problem);
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &Problem> {
        self.0.iter()
    }

    /// The errors alone.
    pub fn errors(&self) -> impl Iterator<Item = &Problem> {
        self.iter().filter(|problem| problem.severity == Severity::Error)
    }

    /// The warnings alone.
    pub fn warnings(&self) -> impl Iterator<Item = &Problem> {
        self.iter().filter(|problem| problem.severity == Severity::Warning)
    }

    /// Whether there is any error.
    pub fn has_errors(&self) -> bool {
        self.errors().next().is_some()
    }

    /// Whether there is neither error nor warning.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// One problem per line, no line end after the last.
impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, problem) in self.iter().enumerate() {
            if place > 0 {
                writeln!(f)?;
            }
            write!(f, "{problem}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Problems {}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(severity: Severity, value: &str) -> Problem {
        Problem {
            severity,
            file: "static/Agents.xml".into(),
            line: Some(12),
            element: Some("Shape".into()),
            attribute: Some("Radius".into()),
            value: Some(value.into()),
            message: "must be positive".into(),
        }
    }

    #[test]
    fn a_problem_is_one_line() {
        let mut problems = Problems::default();
        problems.push(problem(Severity::Error, "-0.1"));
        problems.push(Problem { attribute: None, ..problem(Severity::Warning, "") });
        let expected = "static/Agents.xml:12: <Shape> Radius=\"-0.1\": must be positive\n\
                        warning: static/Agents.xml:12: <Shape>: must be positive";
        assert_eq!(problems.to_string(), expected);
        assert_eq!((problems.errors().count(), problems.warnings().count()), (1, 1));
        let hostile = problem(Severity::Error, &"é\n".repeat(100_000)).to_string();
        assert!(hostile.len() < 400 && !hostile.contains('\n'), "{hostile}");
    }
}
