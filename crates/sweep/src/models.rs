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
    /// By the Trial's `decision.toml`, which must be there.
    Needed,
    /// Nobody walks.
    None,
    /// By this file at each point.
    File(Template),
}

/// What is simulated at a point: a Trial, or the one in an FMU, and where people walk.
pub type Simulated = (PathBuf, PlanChoice);

/// What is simulated at all points.
#[derive(Debug)]
pub struct Models {
    /// Each of them once.
    pub all: Vec<Simulated>,
    /// The place of each point's own; `None` if all have the first.
    of_points: Option<Vec<usize>>,
    /// Of each parameter, whether it only chooses.
    chooses: Vec<bool>,
}

impl Models {
    /// Of these points.
    ///
    /// # Errors
    /// There are too many.
    pub fn of(points: &Points, model: &Template, plan: &Plan) -> Result<Models> {
        let only: Vec<bool> =
            (0..points.columns.len()).map(|column| only_chooses(model, plan, column)).collect();
        let chooses: Vec<usize> = (0..only.len()).filter(|column| only[*column]).collect();
        if chooses.is_empty() {
            return Ok(Models {
                all: vec![simulated(points, model, plan, 0)],
                of_points: None,
                chooses: only,
            });
        }
        let (mut all, mut known, mut places) = (Vec::new(), HashMap::new(), HashMap::new());
        let mut of_points = Vec::with_capacity(points.count);
        for point in 0..points.count {
            // There are far more points than models: a path is made once.
            let text = |column: &usize| points.columns[*column].1.text(point);
            let chosen: Vec<String> = chooses.iter().map(text).collect();
            if let Some(place) = known.get(&chosen) {
                of_points.push(*place);
                continue;
            }
            if known.len() == MOST_MODELS {
                return Err(Error::Spec(format!("there are more than {MOST_MODELS} Trials, FMUs or plans")));
            }
            let own = simulated(points, model, plan, point);
            let place = *places.entry(own).or_insert_with_key(|own: &Simulated| {
                all.push(own.clone());
                all.len() - 1
            });
            known.insert(chosen, place);
            of_points.push(place);
        }
        Ok(Models { all, of_points: Some(of_points), chooses: only })
    }

    /// Whether a parameter only chooses what is simulated, and is no variable of it.
    pub fn only_chooses(&self, column: usize) -> bool {
        self.chooses[column]
    }

    /// The place of a point's own.
    pub fn place(&self, point: usize) -> usize {
        self.of_points.as_ref().map_or(0, |all| all[point])
    }
}

/// What is simulated at a point.
pub(crate) fn simulated(points: &Points, model: &Template, plan: &Plan, point: usize) -> Simulated {
    let plan = match plan {
        Plan::Own | Plan::Needed => PlanChoice::Own,
        Plan::None => PlanChoice::None,
        Plan::File(template) => PlanChoice::File(template.path(points, point)),
    };
    (model.path(points, point), plan)
}

/// Whether the parameter in a column only chooses what is simulated.
pub(crate) fn only_chooses(model: &Template, plan: &Plan, column: usize) -> bool {
    model.uses(column) || matches!(plan, Plan::File(template) if template.uses(column))
}
