//! The path of what is simulated, in which parameters may stand.

use crate::points::Points;
use std::path::{Path, PathBuf};

/// \[byte\] Of a path, in any system.
const LONGEST: usize = 4096;

/// A path in which `{NAME}` stands for the value of that parameter: each point can have a model of its own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Template {
    directory: PathBuf,
    pieces: Vec<Piece>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Piece {
    Text(String),
    /// The value of the parameter in this column.
    Value(usize),
}

impl Template {
    /// Reads a path that is relative to a directory.
    ///
    /// # Errors
    /// A sentence with a name in braces that is no parameter's; or the text is longer than any path.
    pub fn read(text: &str, directory: &Path, points: &Points) -> Result<Template, String> {
        if text.len() > LONGEST {
            return Err(format!("it has {} bytes: at most {LONGEST} can be a path", text.len()));
        }
        let (mut pieces, mut rest) = (Vec::new(), text);
        while let Some((before, after)) = rest.split_once('{') {
            let Some((name, further)) = after.split_once('}') else { break };
            let column = points.parameters.iter().position(|known| known.name == name);
            let column = column.ok_or_else(|| format!("{text}: there is no parameter {name:?}"))?;
            pieces.extend([Piece::Text(before.to_owned()), Piece::Value(column)]);
            rest = further;
        }
        pieces.push(Piece::Text(rest.to_owned()));
        Ok(Template { directory: directory.to_owned(), pieces })
    }

    /// Makes a path without parameters, whatever is written in it.
    pub fn of_path(path: &Path) -> Template {
        Template { directory: path.to_owned(), pieces: Vec::new() }
    }

    /// Returns the path at a point. Numbers are written as in the table of results.
    pub fn path(&self, points: &Points, point: usize) -> PathBuf {
        let written = self.pieces.iter().map(|piece| match piece {
            Piece::Text(text) => text.clone(),
            Piece::Value(column) => points.parameters[*column].at(point).to_owned(),
        });
        let written = written.collect::<String>();
        if written.is_empty() { self.directory.clone() } else { self.directory.join(written) }
    }

    /// Returns whether the parameter in a column stands in it.
    pub fn uses(&self, column: usize) -> bool {
        self.pieces.contains(&Piece::Value(column))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_stand_in_for_names() {
        let axes = vec![
            ("width".to_owned(), ["0.8", "1.0"].map(str::to_owned).to_vec()),
            ("seed".to_owned(), ["1", "2"].map(str::to_owned).to_vec()),
            ("Mass".to_owned(), vec!["60.0".to_owned()]),
        ];
        let points = Points::grid(axes).unwrap();
        let read = |text: &str| Template::read(text, Path::new("in"), &points);
        let template = read("door_{width}/{seed}-{seed}").unwrap();
        let paths: Vec<PathBuf> = (0..points.count).map(|point| template.path(&points, point)).collect();
        assert_eq!(
            paths,
            ["in/door_0.8/1-1", "in/door_0.8/2-2", "in/door_1.0/1-1", "in/door_1.0/2-2"].map(PathBuf::from)
        );
        assert_eq!([0, 1, 2].map(|column| template.uses(column)), [true, true, false]);
        assert_eq!(read("a{wdith}").unwrap_err(), "a{wdith}: there is no parameter \"wdith\"");
        assert!(read(&"x".repeat(5000)).unwrap_err().contains("5000 bytes"));
        assert_eq!(read("a}b{c").unwrap().path(&points, 0), PathBuf::from("in/a}b{c"));
    }
}
