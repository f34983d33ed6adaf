//! The commands in this process.

use crate::CommandError;
use crate::arrays::{frame_of, is_width};
use crate::model::PyModel;
use crate::recording::duration;
use crate::simulation::in_order;
use lemons_cli::embedded::{Done, Held, InMemory, call};
use lemons_results::Run;
use lemons_sim::Documents;
use numpy::ndarray::ArrayView2;
use numpy::{PyReadonlyArray1, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::Builder;

/// Byte size of the stack of a command, as that of a program.
const STACK: usize = 8 << 20;

/// A command under way in a thread of its own.
#[pyclass(module = "lemons_fmu._native")]
pub struct Task {
    stop: Arc<AtomicBool>,
    done: Mutex<Receiver<Result<Done, String>>>,
}

/// A command's output, its notes; its picture; its summary and tables.
type CommandResult<'py> = (String, Vec<String>, Bound<'py, PyBytes>, String, Vec<(&'static str, String)>);

#[pymethods]
impl Task {
    /// Begins a command: its name and arguments. `held` is its operand, if that is a run in memory, or the path of a
    /// database in the place of the file that is named.
    #[new]
    #[pyo3(signature = (words, held=None))]
    fn new(words: Vec<OsString>, held: Option<&Bound<'_, PyAny>>) -> PyResult<Task> {
        let held = held.map(|held| match held.extract::<PathBuf>() {
            Ok(path) => Ok(Held::Database(path)),
            Err(_) => in_memory(held).map(|run| Held::Run(Arc::new(run))),
        });
        let held = held.transpose()?;
        let (stop, (send, done)) = (Arc::new(AtomicBool::new(false)), channel());
        let flag = stop.clone();
        let work = move || {
            // Nobody waits for it any more if this fails.
            let _ = send.send(call(&words, held, flag));
        };
        Builder::new().name("lemons".into()).stack_size(STACK).spawn(work)?;
        Ok(Task { stop, done: Mutex::new(done) })
    }

    /// Waits for its end, at most so long \[s\], and returns what came of it; None if it is not over.
    fn wait<'py>(&self, py: Python<'py>, seconds: f64) -> PyResult<Option<CommandResult<'py>>> {
        let wait = duration(seconds)?;
        let got = py.detach(|| self.done.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(wait));
        let done = match got {
            Ok(done) => done.map_err(CommandError::new_err)?,
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("a fault in this program"));
            }
            Err(RecvTimeoutError::Timeout) => return Ok(None),
        };
        let Done { printed, notes, picture, summary, tables } = done;
        Ok(Some((printed, notes, PyBytes::new(py, &picture), summary, tables)))
    }

    /// Asks it to end, without what it has begun.
    fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// Lets commands that pack FMUs look for libraries in a directory.
#[pyfunction]
pub fn look_in(directory: PathBuf) {
    lemons_master::look_in(&directory);
}

/// A `Run` of the package.
fn in_memory(run: &Bound<'_, PyAny>) -> PyResult<InMemory> {
    let model = run.getattr("model")?;
    let model = model.cast::<PyModel>()?.get();
    let times: PyReadonlyArray1<'_, f64> = run.getattr("times")?.extract()?;
    let numbers: PyReadonlyArray3<'_, f64> = run.getattr("numbers")?.extract()?;
    let leaving: bool = run.getattr("leaving")?.extract()?;
    let ids: Vec<String> = run.getattr("ids")?.extract()?;
    let each = numbers.shape()[2];
    let moments = in_order(&times);
    let is_whole = numbers.shape()[..2] == [moments.len(), ids.len()]
        && ids.len() == model.documents.trial.agents.len()
        && moments.iter().all(|time| time.is_finite())
        && moments.is_sorted_by(|earlier, later| earlier < later);
    if !is_whole || !is_width(each) {
        return Err(PyValueError::new_err(
            "the times or numbers of the run are not those of its people, or of another version",
        ));
    }
    let numbers = numbers.as_array();
    let frame = |(time, numbers): (&f64, ArrayView2<'_, f64>)| {
        frame_of(*time, numbers.as_standard_layout().as_slice().unwrap_or_default(), each, leaving)
    };
    let frames = moments.iter().zip(numbers.outer_iter()).map(frame).collect();
    let run = Run { source: run.repr()?.to_string().into(), ids, frames };
    let Documents { trial, plan, .. } = &model.documents;
    Ok(InMemory { run, trial: trial.clone(), plan: plan.clone() })
}
