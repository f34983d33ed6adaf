//! The points of a sweep, what they simulate, and the table of their results.

use crate::model::{PyModel, short};
use crate::simulation::{algorithm_of, condition, refused, until_of};
use lemons_master::DecisionChoice;
use lemons_sim::Clock;
use lemons_sweep::{Finished, MeasuredValue, Models, SweepDecision, Template, check_parameters, identity};
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyIndexError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyInt, PyString};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

create_exception!(
    lemons_fmu,
    SweepError,
    PyException,
    "The sweep cannot continue: its table is that of another sweep, in use or damaged, or nobody works for it."
);

fn wrong(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(short(error))
}

/// The points of a sweep: a row of parameter values for each, and what they simulate.
#[pyclass(frozen, module = "lemons_fmu._native")]
pub struct Study {
    points: lemons_sweep::Points,
    /// The values of each parameter, as Python has them.
    columns: Vec<Vec<Py<PyAny>>>,
    models: Models,
}

/// Returns the values of a parameter as texts: all whole numbers, all numbers, or all texts.
fn texts_of(name: &str, values: &[Bound<'_, PyAny>]) -> PyResult<Vec<String>> {
    let is_bool = |value: &Bound<'_, PyAny>| value.is_instance_of::<PyBool>();
    let is_whole = |value: &Bound<'_, PyAny>| value.is_instance_of::<PyInt>() && !is_bool(value);
    if values.iter().all(is_whole) || values.iter().all(|value| value.is_instance_of::<PyString>()) {
        return values.iter().map(|value| Ok(value.str()?.to_string())).collect();
    }
    let text = |value: &Bound<'_, PyAny>| match value.extract::<f64>() {
        Ok(number) if !is_bool(value) => Ok(format!("{number:?}")),
        _ => Err(wrong(format!("parameter {name}: values must be all numbers or all texts"))),
    };
    values.iter().map(text).collect()
}

/// Reads a path with the names of parameters in braces. What is there as it is written has none.
fn template(text: &str, points: &lemons_sweep::Points) -> PyResult<Template> {
    let path = Path::new(text);
    if path.symlink_metadata().is_ok() {
        return Ok(Template::of_path(path));
    }
    Template::read(text, Path::new(""), points).map_err(wrong)
}

#[pymethods]
impl Study {
    /// Makes the points of parameters and their values: all combinations (a grid), or a point for each row. They simulate a
    /// Trial or the FMU of a crowd, whose path may contain names of parameters in braces. People walk by `decision`, by default
    /// by the Trial's decision.toml, or not at all.
    #[new]
    fn new(
        columns: Vec<(String, Vec<Bound<'_, PyAny>>)>,
        grid: bool,
        what: &str,
        decision: Option<&str>,
        walk: bool,
    ) -> PyResult<Study> {
        let texts = columns.iter().map(|(name, values)| Ok((name.clone(), texts_of(name, values)?)));
        let all = texts.collect::<PyResult<_>>()?;
        let points = if grid {
            lemons_sweep::Points::grid(all).map_err(wrong)?
        } else {
            lemons_sweep::Points::of_rows(all)
        };
        if points.count == 0 {
            return Err(wrong("there are no points"));
        }
        let decision = match decision {
            Some(text) => SweepDecision::File(template(text, &points)?),
            None if walk => SweepDecision::Own,
            None => SweepDecision::None,
        };
        let models = Models::of(&points, &template(what, &points)?, &decision);
        let columns = columns.into_iter().map(|(_, values)| values.into_iter().map(Bound::unbind).collect());
        let models = models.map_err(|error| wrong(error.whole()))?;
        Ok(Study { points, columns: columns.collect(), models })
    }

    /// The number of points.
    #[getter]
    fn count(&self) -> usize {
        self.points.count
    }

    /// Names of the parameters.
    #[getter]
    fn names(&self) -> Vec<&str> {
        self.points.parameters.iter().map(|parameter| parameter.name.as_str()).collect()
    }

    /// The value of a parameter at a point.
    fn value(&self, py: Python<'_>, column: usize, point: usize) -> PyResult<Py<PyAny>> {
        self.check_point(point)?;
        let parameter = self.points.parameters.get(column);
        let parameter =
            parameter.ok_or_else(|| PyIndexError::new_err(format!("there is no column {column}")))?;
        Ok(self.columns[column][parameter.place(point)].clone_ref(py))
    }

    /// Each model's path, the path of its `decision.toml`, and whether people walk.
    fn models(&self) -> Vec<(PathBuf, Option<PathBuf>, bool)> {
        let all = self.models.all.iter();
        all.map(|(path, decision)| match decision {
            DecisionChoice::File(file) => (path.clone(), Some(file.clone()), true),
            decision => (path.clone(), None, *decision != DecisionChoice::None),
        })
        .collect()
    }

    /// The place of a point's model.
    fn place(&self, point: usize) -> PyResult<usize> {
        self.check_point(point)?;
        Ok(self.models.place(point))
    }

    /// The places of parameters that are set: the others only choose a model.
    fn set(&self) -> Vec<usize> {
        let columns = 0..self.points.parameters.len();
        columns.filter(|column| !self.models.only_chooses(*column)).collect()
    }

    /// Checks that a model has all variables that are set, that people can leave (without a time `until` \[s\]), and that
    /// there are communication points. Returns what must be equal to go on, as JSON.
    fn identity(&self, model: &PyModel, algorithm: &str, until: Option<f64>, step: f64) -> PyResult<String> {
        let algorithm = algorithm_of(algorithm)?;
        let simulation = lemons_sim::Simulation::new(model.documents.clone(), algorithm).map_err(refused)?;
        let checked = check_parameters(&self.points, &self.models, &simulation);
        checked.map_err(|error| refused(error.whole()))?;
        let until = until_of(until);
        condition(until, model.documents.leaving())?;
        Clock::new(0.0, step, until.latest()).map_err(wrong)?;
        let own = identity::of_documents(&model.documents, algorithm, step);
        Ok(Value::Object(own.map_err(|error| wrong(error.whole()))?).to_string())
    }

    /// The same of all models together, by what is different in them; and of the points.
    fn identity_of_all(&self, each: Vec<String>) -> String {
        let mut all = Map::from_iter([("points".to_owned(), identity::of_points(&self.points))]);
        if each.len() > 1 {
            all.extend(identity::of_models(&self.points, &each, &self.models));
        }
        Value::Object(all).to_string()
    }
}

impl Study {
    fn check_point(&self, point: usize) -> PyResult<()> {
        if point < self.points.count {
            return Ok(());
        }
        Err(PyIndexError::new_err(format!("point {point}: there are {}", self.points.count)))
    }
}

/// A finished point: its number, its measures by their names, or the message of its failure.
type Row<'py> = (usize, Option<Bound<'py, PyDict>>, Option<String>);

/// The table of a sweep, in a file.
#[pyclass(name = "Table", module = "lemons_fmu._native")]
pub struct PySweepTable(Option<lemons_sweep::SweepTable>);

fn cannot(error: lemons_sweep::SweepError) -> PyErr {
    SweepError::new_err(short(error.whole()))
}

#[pymethods]
impl PySweepTable {
    /// Creates the table, or opens that of an unfinished sweep. `identity` is JSON.
    #[new]
    fn new(path: PathBuf, identity: &str, study: &Study) -> PyResult<PySweepTable> {
        let identity: Map<String, Value> = serde_json::from_str(identity).map_err(wrong)?;
        // Opening a pipe would wait.
        if path.exists() && !path.is_file() {
            let text = format!("{}: is not a file; give the name of a table (.csv)", path.display());
            return Err(SweepError::new_err(text));
        }
        let table = lemons_sweep::SweepTable::open(&path, &identity, &study.points).map_err(cannot)?;
        Ok(PySweepTable(Some(table)))
    }

    /// Names of the measures; None as long as no point has any.
    #[getter]
    fn measures(&self) -> Option<Vec<String>> {
        self.0.as_ref()?.measures().map(<[String]>::to_vec)
    }

    /// The finished points, in order.
    fn rows<'py>(&self, py: Python<'py>) -> PyResult<Vec<Row<'py>>> {
        let Some(table) = &self.0 else { return Ok(Vec::new()) };
        table.rows().map(|row| self.row(py, row)).collect()
    }

    /// Appends finished points, whose measures have the names and the order of the table's.
    fn add(&mut self, names: Vec<String>, rows: Vec<Row<'_>>) -> PyResult<()> {
        let Some(table) = &mut self.0 else { return Ok(()) };
        table.name_measures(&names).map_err(cannot)?;
        let finished = rows.into_iter().map(|(point, measures, error)| {
            let outcome = match (measures, error) {
                (_, Some(error)) => Err(error),
                (Some(measures), None) => Ok(names
                    .iter()
                    .map(|name| measures.get_item(name)?.map(|value| measured(&value)).transpose())
                    .collect::<PyResult<_>>()?),
                (None, None) => {
                    return Err(PyTypeError::new_err("a point has neither measures nor an error"));
                }
            };
            Ok(Finished { point, outcome })
        });
        let finished: Vec<Finished> = finished.collect::<PyResult<_>>()?;
        table.add(&finished).map_err(cannot)
    }

    /// Sorts the rows of a finished sweep.
    fn finish(&mut self) -> PyResult<()> {
        match self.0.take() {
            Some(table) => table.finish().map(drop).map_err(cannot),
            None => Ok(()),
        }
    }
}

impl PySweepTable {
    fn row<'py>(&self, py: Python<'py>, Finished { point, outcome }: &Finished) -> PyResult<Row<'py>> {
        let values = match outcome {
            Err(message) => return Ok((*point, None, Some(message.clone()))),
            Ok(values) => values,
        };
        let measures = PyDict::new(py);
        for (name, value) in self.measures().unwrap_or_default().iter().zip(values) {
            match value {
                None => measures.set_item(name, f64::NAN)?,
                Some(MeasuredValue::Number(number)) => measures.set_item(name, number)?,
                Some(MeasuredValue::Text(text)) => measures.set_item(name, text)?,
            }
        }
        Ok((*point, Some(measures), None))
    }
}

fn measured(value: &Bound<'_, PyAny>) -> PyResult<MeasuredValue> {
    match value.cast::<PyString>() {
        Ok(text) => Ok(MeasuredValue::Text(text.to_string())),
        Err(_) => Ok(MeasuredValue::Number(value.extract()?)),
    }
}
