//! The scene that a page draws of a Trial: everything that does not move.

use crate::frame::overlapping;
use crate::kinds;
use crate::run::Run;
use crowd_mechanics::setup::Setup;
use lemons_core::trial::{Agent, Contact, Material, Wall};
use lemons_people::{Person, mechanical_step_for};
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// Returns the walls' corners \[m\]; each agent's Id, mass \[kg\] and disks (x, y, radius \[m\], in the body's frame), its
/// kind with what goes along ([`kinds`]), its desired speed \[m/s\], and measures where they are known; who overlaps; who
/// is pushed; ways, exits and goals of those who walk, and how many leave; the steps, materials and contacts. Of a run at
/// its start; [`crate::Lab`] adds its number, warnings, and lines beyond doors.
pub fn of(run: &Run) -> Value {
    let driven = &run.driven;
    let trial = &driven.trial;
    let agent = |(k, agent): (usize, &Agent)| {
        // A Trial may show its disks at another orientation than 0.
        let disks = agent.disks_facing_x().into_iter();
        let disks: Vec<[f64; 3]> = disks.map(|(place, radius)| [place.x, place.y, radius]).collect();
        let made = driven.people.as_ref().and_then(|people| people[k].member());
        let planned = driven.plan.as_ref().map(|plan| plan.agents[k].walker.desired_speed);
        let speed = planned.or_else(|| made.map(|member| member.speed));
        json!({
            "id": agent.id, "mass": agent.mass, "disks": disks, "kind": agent.kind, "speed": speed,
            "things": kinds::things(agent), "seated": kinds::seated(agent, made),
        })
    };
    let wall = |wall: &Wall| {
        let corners: Vec<[f64; 2]> = wall.corners.iter().copied().map(Into::into).collect();
        let mut value = json!({ "id": wall.id, "corners": corners });
        if let Some(open) = &wall.open {
            value["open"] = json!(open);
        }
        value
    };
    let person = |agent: &lemons_people::Agent| {
        let Person { sex, breadth, depth, stature, mass } = *agent.everybody().first()?;
        Some(
            json!({ "sex": sex.name(), "breadth": breadth, "depth": depth, "stature": stature, "mass": mass }),
        )
    };
    let people = driven.people.as_ref().map(|people| people.iter().map(person).collect::<Vec<_>>());
    let plan = driven.plan.as_ref();
    let ways = plan.map(|plan| plan.ways_of_points(100)).unwrap_or_default();
    let targets = plan.map_or(&[][..], |plan| &plan.targets);
    let mut pushed: Vec<&str> = driven.table.agents().collect();
    pushed.sort_unstable();
    let of_people: BTreeSet<&str> =
        trial.agents.iter().flat_map(|agent| &agent.shapes).map(|disk| &*disk.material_id).collect();
    let of_walls = trial.geometry.walls.iter().map(|wall| &*wall.material_id);
    let used: BTreeSet<&str> = of_people.iter().copied().chain(of_walls).collect();
    let materials = trial.materials.intrinsic.iter().filter(|of| used.contains(&*of.id));
    let material = |of: &Material| {
        let Material { id, young_modulus, shear_modulus } = of;
        json!({ "id": id, "young_modulus": young_modulus, "shear_modulus": shear_modulus })
    };
    let contacts = trial.materials.binary.iter().filter(|of| {
        let pair = [&*of.id1, &*of.id2];
        pair.iter().all(|id| used.contains(id)) && pair.iter().any(|id| of_people.contains(id))
    });
    let contact = |of: &Contact| {
        json!({
            "id1": of.id1, "id2": of.id2, "gamma_normal": of.gamma_normal,
            "gamma_tangential": of.gamma_tangential, "kinetic_friction": of.kinetic_friction,
        })
    };
    let steps = Setup::of(trial).steps();
    let steps = steps.as_ref();
    let (overlapping, _, overlap) = overlapping(run.world(), None);
    json!({
        "name": trial.name,
        "agents": trial.agents.iter().enumerate().map(agent).collect::<Vec<_>>(),
        "walls": trial.geometry.walls.iter().map(wall).collect::<Vec<_>>(),
        "step": trial.parameters.time_step,
        "mechanical_step": trial.parameters.time_step_mechanical,
        "stable": steps.map(|steps| steps.stable()),
        "longest": steps.map(|steps| steps.longest()),
        "advised": steps.and_then(|steps| steps.proposed()).map(|_| mechanical_step_for(trial)),
        "error": steps.map(|steps| steps.error(trial.parameters.time_step_mechanical)),
        "materials": materials.map(material).collect::<Vec<_>>(), "contacts": contacts.map(contact).collect::<Vec<_>>(),
        "pushed": pushed, "walk": plan.is_some(), "ways": ways, "targets": targets, "leaving": plan.map_or(0, |plan| plan.leaving().into_iter().filter(|leaves| *leaves).count()),
        "kinds": kinds::parts(trial), "people": people, "overlapping": overlapping, "overlap": overlap,
    })
}
