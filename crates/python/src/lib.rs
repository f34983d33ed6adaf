//! The extension module `lemons_fmu._native`: what the Python package simulates, measures, draws and sweeps, in memory.
//!
//! Each class is thin: the work is done by the libraries of this workspace. Long calls release the GIL and return after a
//! part of their work, so that Python sees Ctrl-C and shows progress. Arrays own the memory that was filled here.

mod arrays;
mod command;
mod model;
mod recording;
mod simulation;
mod sweep;

use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;

create_exception!(
    lemons_fmu,
    SimulationError,
    PyException,
    "The simulation refuses a value or a step, or fails: the message says why."
);
create_exception!(
    lemons_fmu,
    CommandError,
    PyException,
    "A file or an option is refused: the message is that of the command `lemons`."
);

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let python = module.py();
    module.add("SimulationError", python.get_type::<SimulationError>())?;
    module.add("CommandError", python.get_type::<CommandError>())?;
    module.add("NUMBERS", arrays::names())?;
    module.add("TABLE", arrays::table())?;
    module.add_class::<command::Task>()?;
    module.add_class::<model::PyModel>()?;
    module.add_function(wrap_pyfunction!(command::look_in, module)?)?;
    module.add_class::<recording::Recording>()?;
    module.add_class::<simulation::PySimulation>()?;
    module.add("SweepError", python.get_type::<sweep::SweepError>())?;
    module.add_class::<sweep::Study>()?;
    module.add_class::<sweep::PySweepTable>()?;
    module.add_function(wrap_pyfunction!(model::read_drive, module)?)?;
    module.add_function(wrap_pyfunction!(model::read_people, module)?)?;
    module.add_function(wrap_pyfunction!(model::read_text, module)?)?;
    Ok(())
}
