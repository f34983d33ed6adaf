//! Errors, warnings and notes about a Trial.

use crate::rule::Severity;
use crate::xml::Problem;
use std::fmt;
use std::path::Path;

/// All errors and warnings, in the order in which the files are read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Problems {
    all: Vec<Problem>,
    /// Number of errors that were not kept.
    more: usize,
}

impl Problems {
    /// Adds one.
    pub fn push(&mut self, problem: Problem) {
        self.all.push(problem);
    }

    /// Adds an error of a table, which may have any number of them: after the first 20 they are only counted.
    pub fn push_counted(&mut self, problem: Problem) {
        if self.all.len() < 20 { self.all.push(problem) } else { self.more += 1 }
    }

    /// Returns the same problems, of the file with this path.
    #[must_use]
    pub fn of_file(&self, path: &Path) -> Problems {
        let of_file = |problem: &Problem| Problem { file: path.to_owned(), ..problem.clone() };
        Problems { all: self.iter().map(of_file).collect(), more: self.more }
    }

    /// Returns the value if there is none.
    ///
    /// # Errors
    /// All of them.
    pub fn or<T>(self, value: T) -> Result<T, Problems> {
        if self.is_empty() { Ok(value) } else { Err(self) }
    }

    /// Returns all of them.
    pub fn iter(&self) -> impl Iterator<Item = &Problem> {
        self.all.iter()
    }

    /// Returns the errors only.
    pub fn errors(&self) -> impl Iterator<Item = &Problem> {
        self.iter().filter(|problem| problem.severity() == Severity::Error)
    }

    /// Returns the warnings only.
    pub fn warnings(&self) -> impl Iterator<Item = &Problem> {
        self.iter().filter(|problem| problem.severity() == Severity::Warning)
    }

    /// Returns whether there is any error.
    pub fn has_errors(&self) -> bool {
        self.errors().next().is_some()
    }

    /// Returns whether there is neither error nor warning.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }
}

impl From<Problem> for Problems {
    fn from(problem: Problem) -> Problems {
        Problems { all: vec![problem], more: 0 }
    }
}

impl Extend<Problem> for Problems {
    fn extend<T: IntoIterator<Item = Problem>>(&mut self, problems: T) {
        self.all.extend(problems);
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
        if self.more > 0 { write!(f, "\nand {} more errors", self.more) } else { Ok(()) }
    }
}

impl std::error::Error for Problems {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rule::Rule;

    #[test]
    fn each_problem_has_a_line() {
        let mut problems = Problems::default();
        problems.push(Problem::of_file(Path::new("a.xml"), Some(12), "must be positive"));
        problems.push(Problem::by(Rule::NotRead, Path::new("b.xml"), "is odd"));
        assert_eq!(problems.to_string(), "a.xml:12: must be positive\nwarning: b.xml: is odd");
        assert_eq!((problems.errors().count(), problems.warnings().count()), (1, 1));
    }
}
