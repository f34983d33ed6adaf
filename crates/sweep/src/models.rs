//! Models of the points, and their paths, in which parameters may stand.

use crate::error::Result;
use crate::points::Points;
use lemons_master::{DecisionChoice, require};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// More are taken for a mistake: each is read and checked before the first point is simulated.
const MOST_MODELS: usize = 10_000;

/// Where the people of Trials walk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SweepDecision {
    /// By the Trial's `decision.toml`, if it has one.
    Own,
    /// Nobody walks.
    None,
    /// By this file at each point.
    File(Template),
}

/// Model of a point: a Trial, or the one in an FMU, and where people walk.
pub type SweepModel = (PathBuf, DecisionChoice);

/// Models of all points.
#[derive(Debug, Clone)]
pub struct Models {
    /// Each of them once.
    pub all: Vec<SweepModel>,
    /// The place of each point's own; `None` if all have the first.
    of_points: Option<Vec<usize>>,
    /// For each parameter, whether it only chooses.
    chooses: Vec<bool>,
    /// The first point that has each of them.
    first: Vec<usize>,
}

impl Models {
    /// Finds what these points simulate.
    ///
    /// # Errors
    /// There are too many.
    pub fn of(points: &Points, path: &Template, decision: &SweepDecision) -> Result<Models> {
        let model = |point: usize| -> SweepModel {
            let decision = match decision {
                SweepDecision::Own => DecisionChoice::Own,
                SweepDecision::None => DecisionChoice::None,
                SweepDecision::File(template) => DecisionChoice::File(template.path(points, point)),
            };
            (path.path(points, point), decision)
        };
        let of_decision = |column| matches!(decision, SweepDecision::File(template) if template.uses(column));
        let columns = 0..points.parameters.len();
        let chooses: Vec<bool> = columns.map(|column| path.uses(column) || of_decision(column)).collect();
        if !chooses.contains(&true) {
            return Ok(Models { all: vec![model(0)], of_points: None, chooses, first: vec![0] });
        }
        Models::among(points, chooses, model)
    }

    /// Finds the crowds that these points simulate, by the parameters that choose them.
    ///
    /// # Errors
    /// There are too many.
    pub fn of_crowds(points: &Points, chooses: Vec<bool>) -> Result<Models> {
        let model = |point: usize| -> SweepModel {
            let chosen = points.parameters.iter().zip(&chooses).filter(|(_, chooses)| **chooses);
            let values = chosen.map(|(parameter, _)| format!("{} = {}", parameter.name, parameter.at(point)));
            let name = values.collect::<Vec<String>>().join(", ");
            (PathBuf::from(if name.is_empty() { "population".to_owned() } else { name }), DecisionChoice::Own)
        };
        Models::among(points, chooses.clone(), model)
    }

    /// Each different model once.
    fn among(points: &Points, chooses: Vec<bool>, model: impl Fn(usize) -> SweepModel) -> Result<Models> {
        let (mut all, mut first, mut known) = (Vec::new(), Vec::new(), HashMap::new());
        let mut of_points = Vec::with_capacity(points.count);
        for point in 0..points.count {
            let place = *known.entry(model(point)).or_insert_with_key(|own: &SweepModel| {
                all.push(own.clone());
                first.push(point);
                all.len() - 1
            });
            of_points.push(place);
            let many = || {
                format!("there are more than {MOST_MODELS} crowds, Trials, FMUs or files like decision.toml")
            };
            require(all.len() <= MOST_MODELS, many)?;
        }
        Ok(Models { all, of_points: Some(of_points), chooses, first })
    }

    /// Returns whether a parameter only chooses what is simulated, and is no variable of it.
    pub fn only_chooses(&self, parameter: usize) -> bool {
        self.chooses[parameter]
    }

    /// Returns the first point that has the model of a place.
    pub(crate) fn first_point(&self, place: usize) -> usize {
        self.first[place]
    }

    /// Returns the place of a point's own.
    pub fn place(&self, point: usize) -> usize {
        self.of_points.as_ref().map_or(0, |all| all[point])
    }
}

/// \[byte\] Of a path, in any system.
const LONGEST: usize = 4096;

/// A path in which `{NAME}` stands for the value of that parameter: each point can have a model of its own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Template {
    directory: PathBuf,
    /// Texts, each with the column of the parameter whose value follows it.
    pieces: Vec<(String, Option<usize>)>,
}

impl Template {
    /// Reads a path that is relative to a directory.
    ///
    /// # Errors
    /// A sentence with a name in braces that is no parameter's; or the text is longer than any path.
    pub fn read(text: &str, directory: &Path, points: &Points) -> Result<Template, String> {
        let long = || format!("it has {} bytes: at most {LONGEST} can be a path", text.len());
        require(text.len() <= LONGEST, long)?;
        let (mut pieces, mut rest) = (Vec::new(), text);
        while let Some((before, after)) = rest.split_once('{') {
            let Some((name, further)) = after.split_once('}') else { break };
            let column = points.parameters.iter().position(|known| known.name == name);
            let column = column.ok_or_else(|| format!("{text}: there is no parameter {name:?}"))?;
            pieces.push((before.to_owned(), Some(column)));
            rest = further;
        }
        pieces.push((rest.to_owned(), None));
        Ok(Template { directory: directory.to_owned(), pieces })
    }

    /// Makes a path without parameters, whatever is written in it.
    pub fn of_path(path: &Path) -> Template {
        Template { directory: path.to_owned(), pieces: Vec::new() }
    }

    /// Returns the path at a point. Numbers are written as in the table of results.
    pub fn path(&self, points: &Points, point: usize) -> PathBuf {
        let value = |column: usize| points.parameters[column].at(point);
        let written = self.pieces.iter().flat_map(|(text, column)| [text.as_str(), column.map_or("", value)]);
        let written = written.collect::<String>();
        if written.is_empty() { self.directory.clone() } else { self.directory.join(written) }
    }

    /// Returns whether the parameter in a column stands in it.
    pub fn uses(&self, column: usize) -> bool {
        self.pieces.iter().any(|(_, used)| *used == Some(column))
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
