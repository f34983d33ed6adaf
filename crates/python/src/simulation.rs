//! A crowd that steps, with what it reads and writes as arrays.

use crate::SimulationError;
use crate::arrays::{append, numbers_of_each};
use crate::model::{PyModel, short};
use crowd_mechanics::engine::{Wrench, vec2};
use lemons_decision::Plan;
use lemons_sim::settings::Value;
use lemons_sim::{Algorithm, SimError, StopCondition, Until};
use numpy::ndarray::Dimension;
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray, PyReadonlyArray1, PyReadonlyArray2,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyBytes, PyFloat, PyInt, PyString};

/// A simulation of a [`PyModel`]: values by the names of the FMU's variables, steps, states.
#[pyclass(name = "Simulation", module = "lemons_fmu._native")]
pub struct PySimulation {
    pub(crate) simulation: lemons_sim::Simulation,
    /// Where its people walk.
    pub(crate) plan: Option<Plan>,
}

/// An error of the simulation, in Python.
pub fn refused(error: impl std::fmt::Display) -> PyErr {
    SimulationError::new_err(short(error))
}

/// Returns when a run ends: at a time \[s\], or when all have left.
pub fn until_of(time: Option<f64>) -> Until {
    time.map_or(Until::Left, Until::Time)
}

/// Returns what ends such a run before its time; `leaving` says of everybody whether they have an exit.
///
/// # Errors
/// Nobody can leave.
pub fn condition(until: Until, leaving: Vec<bool>) -> PyResult<Option<StopCondition>> {
    until.condition(None, || leaving).map_err(|nobody| refused(format!("until='left': {nobody}")))
}

/// Returns the algorithm of this name.
pub fn algorithm_of(name: &str) -> PyResult<Algorithm> {
    let algorithm = serde_json::from_value(name.into());
    algorithm.map_err(|error| PyValueError::new_err(format!("the algorithm: {error}")))
}

/// Returns a value as the text that sets it.
///
/// # Errors
/// It is neither a number, nor a truth value, nor a text.
pub fn text_of(value: &Bound<'_, PyAny>) -> PyResult<String> {
    if value.is_instance_of::<PyString>() {
        return value.extract();
    }
    // Of numpy.
    let value = if value.hasattr("item")? { value.call_method0("item")? } else { value.clone() };
    if value.is_instance_of::<PyBool>() {
        Ok(if value.is_truthy()? { "true" } else { "false" }.to_owned())
    } else if value.is_instance_of::<PyInt>() {
        Ok(value.str()?.to_string())
    } else if value.is_instance_of::<PyFloat>() {
        Ok(format!("{:?}", value.extract::<f64>()?))
    } else {
        let text = value.repr()?;
        Err(PyTypeError::new_err(format!("{text} is neither a number, nor True or False, nor a text")))
    }
}

/// Returns the numbers of an array, those of the last index beside each other, however they lie in memory.
pub fn in_order<D: Dimension>(array: &PyReadonlyArray<'_, f64, D>) -> Vec<f64> {
    array.as_array().iter().copied().collect()
}

/// Checks that an array has a shape.
pub fn check_shape(shape: &[usize], wanted: &[usize]) -> PyResult<()> {
    if shape == wanted {
        return Ok(());
    }
    Err(PyValueError::new_err(format!("the array has the shape {shape:?}, not {wanted:?}")))
}

/// Checks pushes, three numbers each; `agent` is who is pushed by the k-th of them.
pub fn check_finite(pushes: &[f64], agent: impl Fn(usize) -> usize) -> PyResult<()> {
    let Some(k) = pushes.iter().position(|push| !push.is_finite()) else { return Ok(()) };
    let name = ["Fp.x", "Fp.y", "Mp"][k % 3];
    Err(refused(format!("agent[{}].{name} = {:?}: must be finite", agent(k / 3), pushes[k])))
}

#[pymethods]
impl PySimulation {
    #[new]
    fn new(model: &PyModel, algorithm: &str) -> PyResult<PySimulation> {
        let algorithm = algorithm_of(algorithm)?;
        let simulation = lemons_sim::Simulation::new(model.documents.clone(), algorithm);
        Ok(PySimulation { simulation: simulation.map_err(refused)?, plan: model.documents.plan.clone() })
    }

    /// Sets a parameter or a start value before the beginning.
    fn set(&mut self, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        match self.simulation.set(name, &text_of(value)?).map_err(refused)? {
            None => Ok(()),
            Some(input) => {
                let by = if name.starts_with("decision.") { "the crowd" } else { "Decision" };
                Err(refused(format!(
                    "{name}: would be overwritten: {by} feeds {input} (decision=False: nobody walks)"
                )))
            }
        }
    }

    /// Begins at a time \[s\].
    fn begin(&mut self, py: Python<'_>, start: f64) -> PyResult<()> {
        py.detach(|| self.simulation.begin(start, None)).map_err(refused)
    }

    /// Goes back to before the beginning, without what was set.
    fn reset(&mut self) -> PyResult<()> {
        self.simulation.reset().map_err(refused)
    }

    /// The last communication point \[s\].
    #[getter]
    fn time(&self) -> f64 {
        self.simulation.time()
    }

    /// Steps to a communication point \[s\].
    fn step_to(&mut self, py: Python<'_>, time: f64) -> PyResult<()> {
        py.detach(|| self.simulation.step_to(time)).map_err(refused)
    }

    /// Names of all variables.
    fn variables(&self) -> Vec<String> {
        self.simulation.variables()
    }

    /// The value of a variable.
    fn get<'py>(&mut self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        Ok(match self.simulation.value(name).map_err(refused)? {
            Value::Real(value) => value.into_pyobject(py)?.into_any(),
            Value::Integer(value) => value.into_pyobject(py)?.into_any(),
            Value::Boolean(value) => value.into_pyobject(py)?.to_owned().into_any(),
            Value::Text(value) => value.into_pyobject(py)?.into_any(),
        })
    }

    /// The masses \[kg\].
    fn masses<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let masses: Vec<f64> = self.simulation.trial().agents.iter().map(|agent| agent.mass).collect();
        masses.into_pyarray(py)
    }

    /// Pushes everybody: Fp.x, Fp.y \[N\], Mp \[N.m\], shape (N, 3).
    fn push(&mut self, pushes: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        check_shape(pushes.shape(), &[self.simulation.ids().len(), 3])?;
        let pushes = in_order(&pushes);
        check_finite(&pushes, |k| k)?;
        for (agent, push) in pushes.chunks_exact(3).enumerate() {
            let push = Wrench { force: vec2(push[0], push[1]), torque: push[2] };
            self.simulation.push(agent, push);
        }
        Ok(())
    }

    /// The drive of everybody: Fp.x, Fp.y \[N\], Mp \[N.m\], shape (N, 3).
    fn drive<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let world = self.simulation.world().ok_or_else(|| refused(SimError::NotBegun))?;
        let drive: Vec<f64> =
            world.drive.iter().flat_map(|drive| [drive.force.x, drive.force.y, drive.torque]).collect();
        drive.into_pyarray(py).reshape([world.drive.len(), 3])
    }

    /// Takes people out, or lets them come back.
    fn set_active(&mut self, active: PyReadonlyArray1<'_, bool>) -> PyResult<()> {
        check_shape(active.shape(), &[self.simulation.ids().len()])?;
        for (agent, active) in active.as_array().iter().enumerate() {
            self.simulation.set_present(agent, *active);
        }
        Ok(())
    }

    /// Keeps `door[k]` or `exit[k]` shut, or lets it be open at its times.
    fn set_open(&mut self, name: &str, is_open: bool) -> PyResult<()> {
        let operated = self.simulation.set_open(name, is_open);
        operated.then_some(()).ok_or_else(|| refused(format!("{name:?}: there is no such door or exit")))
    }

    /// The numbers of everybody, shape (N, 15), or (N, 20) with legs.
    fn observe<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.simulation.world().ok_or_else(|| refused(SimError::NotBegun))?;
        let frame = self.simulation.frame();
        let mut numbers = Vec::new();
        append(&frame, &mut numbers);
        numbers.into_pyarray(py).reshape([frame.agents.len(), numbers_of_each(&frame)])
    }

    /// The state, as bytes.
    fn save<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.simulation.save())
    }

    /// Goes to a saved state.
    fn restore(&mut self, state: &[u8]) -> PyResult<()> {
        self.simulation.restore(state).map_err(refused)
    }

    /// Warnings since the last call.
    fn take_warnings(&mut self) -> Vec<String> {
        self.simulation.take_warnings().iter().map(short).collect()
    }
}
