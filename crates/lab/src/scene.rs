//! What a page draws of a Trial: everything that does not move.

use crowd_mechanics::setup::Setup;
use lemons_trial::{Agent, Trial, Wall};
use serde_json::{Value, json};

/// Returns the walls' corners \[m\] and each agent's Id, mass \[kg\] and disks (x, y, radius \[m\], in the body's frame),
/// and the steps; `run` is added by [`crate::Lab`].
pub fn of(trial: &Trial) -> Value {
    let agent = |agent: &Agent| {
        let disks: Vec<[f64; 3]> =
            agent.shapes.iter().map(|disk| [disk.position.x, disk.position.y, disk.radius]).collect();
        json!({ "id": agent.id, "mass": agent.mass, "disks": disks })
    };
    let wall = |wall: &Wall| {
        let corners: Vec<[f64; 2]> = wall.corners.iter().map(|corner| [corner.x, corner.y]).collect();
        json!({ "id": wall.id, "corners": corners })
    };
    let steps = Setup::of(trial).steps();
    let steps = steps.as_ref();
    json!({
        "name": trial.name,
        "agents": trial.agents.iter().map(agent).collect::<Vec<_>>(),
        "walls": trial.geometry.walls.iter().map(wall).collect::<Vec<_>>(),
        "step": trial.parameters.time_step,
        "mechanical_step": trial.parameters.time_step_mechanical,
        "stable": steps.map(|steps| steps.stable()),
        "error": steps.map(|steps| steps.error(trial.parameters.time_step_mechanical)),
    })
}
