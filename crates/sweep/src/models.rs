//! What is simulated at which point.

use crate::error::{Error, Result};
use crate::points::Points;
use crate::template::Template;
use lemons_master::PlanChoice;
use std::collections::HashMap;
use std::path::PathBuf;

/// More are taken for a mistake: each is read and checked before the first point is simulated.
const MOST_MODELS: usize = 10_000;

/// Where the people of Trials walk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Plan {
    /// By the Trial's `decision.toml`, if it has one.
    Own,
    /// Nobody walks.
    None,
    /// By this file at each point.
    File(Template),
}

/// What is simulated at a point: a Trial, or the one in an FMU, and where people walk.
pub type Model = (PathBuf, PlanChoice);

/// What is simulated at all points.
#[derive(Debug, Clone)]
pub struct Models {
    /// Each of them once.
    pub all: Vec<Model>,
    /// The place of each point's own; `None` if all have the first.
    of_points: Option<Vec<usize>>,
    /// For each parameter, whether it only chooses.
    chooses: Vec<bool>,
}

impl Models {
    /// Finds what these points simulate.
    ///
    /// # Errors
    /// There are too many.
    pub fn of(points: &Points, path: &Template, plan: &Plan) -> Result<Models> {
        let model = |point: usize| -> Model {
            let plan = match plan {
                Plan::Own => PlanChoice::Own,
                Plan::None => PlanChoice::None,
                Plan::File(template) => PlanChoice::File(template.path(points, point)),
            };
            (path.path(points, point), plan)
        };
        let of_plan = |column| matches!(plan, Plan::File(template) if template.uses(column));
        let columns = 0..points.parameters.len();
        let chooses: Vec<bool> = columns.map(|column| path.uses(column) || of_plan(column)).collect();
        if !chooses.contains(&true) {
            return Ok(Models { all: vec![model(0)], of_points: None, chooses });
        }
        let (mut all, mut known) = (Vec::new(), HashMap::new());
        let mut of_points = Vec::with_capacity(points.count);
        for point in 0..points.count {
            let place = *known.entry(model(point)).or_insert_with_key(|own: &Model| {
                all.push(own.clone());
                all.len() - 1
            });
            of_points.push(place);
            if all.len() > MOST_MODELS {
                return Err(Error::Spec(format!("there are more than {MOST_MODELS} Trials, FMUs or plans")));
            }
        }
        Ok(Models { all, of_points: Some(of_points), chooses })
    }

    /// Returns whether a parameter only chooses what is simulated, and is no variable of it.
    pub fn only_chooses(&self, parameter: usize) -> bool {
        self.chooses[parameter]
    }

    /// Returns the place of a point's own.
    pub fn place(&self, point: usize) -> usize {
        self.of_points.as_ref().map_or(0, |all| all[point])
    }
}
