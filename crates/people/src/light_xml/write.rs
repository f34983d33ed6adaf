//! Agents -> the text of a light file.

use super::{LightAgent, LightDisk, LightError, LightShapes, UNIQUE, fault};
use lemons_core::xml::{Layout, Out, number};
use std::collections::BTreeSet;

/// Returns the text of the file. Numbers are the shortest decimals that are read back as the same doubles.
///
/// # Errors
/// An agent has a number out of range, a material is not a name, or an Id is used twice.
pub fn light_xml(agents: &[LightAgent]) -> Result<String, LightError> {
    let mut ids = BTreeSet::new();
    for agent in agents {
        let id = agent.id;
        if !ids.insert(id) {
            return Err(LightError::Agent { id, name: "Id".into(), value: id.to_string(), fault: UNIQUE });
        }
        if let Some((name, value, fault)) = fault(agent) {
            return Err(LightError::Agent { id, name, value, fault });
        }
    }
    Ok(Out::document(Layout::PAPER, "Agents", &[], |out| {
        for agent in agents {
            out.element("Agent", &[], |out| write_agent(out, agent));
        }
    }))
}

fn write_agent(out: &mut Out, agent: &LightAgent) {
    let kind = match agent.shapes {
        LightShapes::Pedestrian(_) => "pedestrian",
        LightShapes::Bicycle { .. } => "bike",
    };
    out.text("type", kind);
    out.text("Id", &agent.id.to_string());
    out.text("MomentOfInertia", &number(agent.moment_of_inertia));
    out.text("FloorDamping", &number(agent.floor_damping));
    out.text("AngularDamping", &number(agent.angular_damping));
    out.element("Shapes", &[], |out| match &agent.shapes {
        LightShapes::Pedestrian(disks) => {
            for (place, LightDisk { disk, material }) in disks.iter().enumerate() {
                out.element(&format!("disk{place}"), &[], |out| {
                    out.text("type", "disk");
                    out.text("radius", &number(disk.radius));
                    out.text("material", material);
                    out.text("x", &number(disk.centre.x));
                    out.text("y", &number(disk.centre.y));
                });
            }
        }
        LightShapes::Bicycle { bike, rider } => {
            for (name, rectangle) in [("bike", bike), ("rider", rider)] {
                out.element(name, &[], |out| {
                    out.text("type", "rectangle");
                    out.text("material", &rectangle.material);
                    out.text("min_x", &number(rectangle.min.x));
                    out.text("min_y", &number(rectangle.min.y));
                    out.text("max_x", &number(rectangle.max.x));
                    out.text("max_y", &number(rectangle.max.y));
                });
            }
        }
    });
}
