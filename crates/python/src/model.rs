//! A Trial, its drive, and where its people walk.

use crate::CommandError;
use crowd_mechanics::setup;
use lemons_core::files::input;
use lemons_core::files::source::Memory;
use lemons_core::files::words::shortened;
use lemons_core::trial::{DriveChoice, DriveTable, FileNames, Problem, ShapeElement, Trial};
use lemons_decision::{DecisionConfig, Plan};
use lemons_master::{DecisionChoice, documents_of, whole};
use lemons_sim::Documents;
use lemons_sim::lint::{self, Files};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The message of an error.
pub fn short(error: impl std::fmt::Display) -> String {
    shortened(&error.to_string()).into_owned()
}

/// A finding: its line, the id of its rule, severity, where it is, and what is said of it.
pub type FindingRow = (String, String, String, String, String);

/// Returns a finding for Python.
pub fn found(problem: &Problem) -> FindingRow {
    let (id, place) = (problem.rule.row().id.to_owned(), problem.place());
    let place = place.trim_end_matches(": ").to_owned();
    (short(problem), id, problem.severity().to_string(), place, short(&problem.message))
}

/// A Trial with its drive and its `decision.toml`, read and checked. It can be pickled.
#[pyclass(name = "Model", frozen, module = "lemons_fmu._native")]
pub struct PyModel {
    pub(crate) documents: Documents,
    /// The file that says where people walk, as the user knows it.
    #[pyo3(get)]
    decision: Option<PathBuf>,
    /// Warnings of what is probably not meant.
    #[pyo3(get)]
    warnings: Vec<FindingRow>,
}

/// The texts of a model: name and directory of the Trial, its files, the drive as CSV, and its decision.toml.
type Texts = (String, PathBuf, Vec<(PathBuf, String)>, String, Option<String>);

/// Times \[s\] and pushes of each agent that a drive names, by index.
type Drives<'py> = BTreeMap<usize, (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>)>;

#[pymethods]
impl PyModel {
    /// Reads a Trial (its directory or its zip), or the Trial in the FMU of a crowd. People walk by `decision`, by default by
    /// the Trial's decision.toml, or not at all.
    #[staticmethod]
    #[pyo3(signature = (path, decision=None, walk=true))]
    fn read(py: Python<'_>, path: PathBuf, decision: Option<PathBuf>, walk: bool) -> PyResult<PyModel> {
        let choice = match decision {
            Some(path) => DecisionChoice::File(path),
            None if walk => DecisionChoice::Own,
            None => DecisionChoice::None,
        };
        let read = py.detach(|| documents_of(&path, &DriveChoice::Own, &choice));
        let (documents, mut problems, decision) = read.map_err(|error| {
            let is_fmu = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("fmu"));
            let advice = if is_fmu { OTHER_FMU } else { "" };
            CommandError::new_err(format!("{}{advice}", short(whole(&error))))
        })?;
        let files = Files::chosen(&path, &DriveChoice::Own, decision.as_deref());
        problems.extend(lint::of_documents(&documents, &files));
        problems.extend(lint::of_step(&documents, documents.trial.parameters.time_step, &files));
        Ok(PyModel { documents, decision, warnings: problems.iter().map(found).collect() })
    }

    /// Makes the model of its texts.
    #[staticmethod]
    fn of_texts(texts: Texts, decision: Option<PathBuf>, warnings: Vec<FindingRow>) -> PyResult<PyModel> {
        let (name, directory, files, drive, toml) = texts;
        let mut memory = Memory::default();
        files.into_iter().for_each(|(path, text)| memory.put(&path, text.into_bytes()));
        let wrong = |error: &dyn std::fmt::Display| PyValueError::new_err(short(error));
        let read = setup::read_from(&memory, &directory, &FileNames::default());
        let trial = Trial { name, ..read.map_err(|problems| wrong(&problems))?.0 };
        let drive = DriveTable::from_csv(drive.as_bytes()).map_err(|error| wrong(&error))?;
        let plan = toml.map(|text| Plan::of(&trial, &DecisionConfig::from_toml(&text)?)).transpose();
        let plan = plan.map_err(|error| wrong(&error))?;
        Ok(PyModel { documents: Documents::new(trial, drive, plan), decision, warnings })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Parts)> {
        let Documents { trial, drive, plan } = &self.documents;
        let mut rows = String::from("t,agent,Fp.x,Fp.y,Mp\n");
        for agent in drive.agents() {
            let id = agent.replace('"', "\"\"");
            for (time, [x, y, torque]) in drive.rows(agent).unwrap_or_default() {
                rows += &format!("{time:?},\"{id}\",{x:?},{y:?},{torque:?}\n");
            }
        }
        let toml = plan.as_ref().map(|plan| plan.config.to_toml()).transpose();
        let toml = toml.map_err(|error| PyValueError::new_err(short(error)))?;
        let texts = trial.texts(&trial.directory);
        let texts = (trial.name.clone(), trial.directory.clone(), texts, rows, toml);
        let make = py.get_type::<PyModel>().getattr("of_texts")?;
        Ok((make, (texts, self.decision.clone(), self.warnings.clone())))
    }

    /// Name of the Trial.
    #[getter]
    fn trial(&self) -> &str {
        &self.documents.trial.name
    }

    /// Ids of the agents.
    #[getter]
    fn ids(&self) -> Vec<&str> {
        self.documents.trial.agents.iter().map(|agent| agent.id.as_str()).collect()
    }

    /// The Trial's communication step \[s\].
    #[getter]
    fn step(&self) -> f64 {
        self.documents.trial.parameters.time_step
    }

    /// The plan of everybody, as text that is equal for equal plans: for tests.
    fn planned(&self) -> Option<String> {
        let plan = Plan { config: DecisionConfig::default(), fingerprint: 0, ..self.documents.plan.clone()? };
        Some(format!("{plan:?}"))
    }

    /// The Trial's drive.csv.
    fn drive<'py>(&self, py: Python<'py>) -> PyResult<Drives<'py>> {
        drives(py, &self.documents.drive, &self.ids())
    }
}

/// The parts of a model: its texts, the path of its `decision.toml`, warnings.
type Parts = (Texts, Option<PathBuf>, Vec<FindingRow>);

/// Said of an FMU that has no Trial.
const OTHER_FMU: &str = "; here the Trial in the FMU of a crowd is simulated: any other FMU runs with FMPy \
                         (fmpy.simulate_fmu), or with lemons run";

/// The people of a Trial: Ids, masses \[kg\], moments of inertia \[kg.m2\], statures \[m\] (not a number: not known), disks of
/// each (x, y, radius \[m\]), poses (x, y \[m\], theta \[rad\]).
type People = (Vec<String>, Vec<f64>, Vec<f64>, Vec<f64>, Vec<Vec<[f64; 3]>>, Vec<[f64; 3]>);

/// Reads the people of a Trial.
#[pyfunction]
pub fn read_people(directory: PathBuf) -> PyResult<People> {
    let read = Trial::read(&directory).map_err(|problems| PyValueError::new_err(short(problems)))?;
    let Trial { agents, dynamics, .. } = read.0;
    let disk = |shape: &ShapeElement| [shape.position.x, shape.position.y, shape.radius];
    Ok((
        agents.iter().map(|agent| agent.id.clone()).collect(),
        agents.iter().map(|agent| agent.mass).collect(),
        agents.iter().map(|agent| agent.moment_of_inertia).collect(),
        agents.iter().map(|agent| agent.height.unwrap_or(f64::NAN)).collect(),
        agents.iter().map(|agent| agent.shapes.iter().map(disk).collect()).collect(),
        dynamics.iter().map(|own| [own.position.x, own.position.y, own.theta]).collect(),
    ))
}

/// An error of reading a file, as Python's own.
fn unread(path: &Path, error: std::io::Error) -> PyErr {
    std::io::Error::new(error.kind(), format!("{}: {error}", path.display())).into()
}

/// Reads a regular file of measurements: text.
#[pyfunction]
pub fn read_text(path: PathBuf) -> PyResult<String> {
    let text = input::read(&path, input::LARGEST_DRIVE).map_err(|error| unread(&path, error))?;
    String::from_utf8(text)
        .map_err(|error| PyValueError::new_err(format!("{}: it is not UTF-8 text ({error})", path.display())))
}

/// Reads a drive file for agents with these Ids.
#[pyfunction]
pub fn read_drive<'py>(py: Python<'py>, path: PathBuf, ids: Vec<String>) -> PyResult<Drives<'py>> {
    let file = input::open_bounded(&path, input::LARGEST_DRIVE).map_err(|error| unread(&path, error))?;
    let known: Vec<&str> = ids.iter().map(String::as_str).collect();
    let read = py.detach(|| {
        let drive = DriveTable::from_csv(file)?;
        drive.check_ids(known.iter().copied()).map(|()| drive)
    });
    let drive = read.map_err(|error| PyValueError::new_err(short(error.of_file(&path))))?;
    drives(py, &drive, &known)
}

fn drives<'py>(py: Python<'py>, drive: &DriveTable, ids: &[&str]) -> PyResult<Drives<'py>> {
    let mut all = BTreeMap::new();
    for id in drive.agents() {
        let agent = ids.iter().position(|known| *known == id);
        let agent = agent.ok_or_else(|| PyValueError::new_err(format!("there is no agent {id:?}")))?;
        let rows = drive.rows(id).unwrap_or_default();
        let times: Vec<f64> = rows.iter().map(|(time, _)| *time).collect();
        let pushes: Vec<f64> = rows.iter().flat_map(|(_, push)| *push).collect();
        all.insert(agent, (times.into_pyarray(py), pushes.into_pyarray(py).reshape([rows.len(), 3])?));
    }
    Ok(all)
}
