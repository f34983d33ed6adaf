//! Errors and warnings about a Trial.

use crate::xml::{Problem, Severity};
use std::fmt;
use std::path::Path;

/// All errors and warnings, in the order in which the files are read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Problems(Vec<Problem>);

impl Problems {
    /// Adds one.
    pub fn push(&mut self, problem: Problem) {
        self.0.push(problem);
    }

    /// Adds others after them.
    pub(crate) fn append(&mut self, others: Problems) {
        self.0.extend(others.0);
    }

    /// Returns the same problems, of the file with this path.
    #[must_use]
    pub fn of_file(&self, path: &Path) -> Problems {
        Problems(self.iter().map(|problem| Problem { file: path.to_owned(), ..problem.clone() }).collect())
    }

    /// Returns the value, or `None` after the problem is added.
    pub(crate) fn or_push<T>(&mut self, read: crate::xml::Result<T>) -> Option<T> {
        read.map_err(|problem| self.push(*problem)).ok()
    }

    /// Returns all of them.
    pub fn iter(&self) -> impl Iterator<Item = &Problem> {
        self.0.iter()
    }

    /// Returns the errors only.
    pub fn errors(&self) -> impl Iterator<Item = &Problem> {
        self.iter().filter(|problem| problem.severity == Severity::Error)
    }

    /// Returns the warnings only.
    pub fn warnings(&self) -> impl Iterator<Item = &Problem> {
        self.iter().filter(|problem| problem.severity == Severity::Warning)
    }

    /// Returns whether there is any error.
    pub fn has_errors(&self) -> bool {
        self.errors().next().is_some()
    }

    /// Returns whether there is neither error nor warning.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// One problem per line, without a line end after the last.
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

    #[test]
    fn each_problem_has_a_line() {
        let mut problems = Problems::default();
        problems.push(Problem::of_file(Path::new("a.xml"), Some(12), "must be positive"));
        let warning = Problem::of_file(Path::new("b.xml"), None, "is odd");
        problems.push(Problem { severity: Severity::Warning, ..warning });
        assert_eq!(problems.to_string(), "a.xml:12: must be positive\nwarning: b.xml: is odd");
        assert_eq!((problems.errors().count(), problems.warnings().count()), (1, 1));
    }
}
