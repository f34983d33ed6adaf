//! A running world: the elements of quantities in it, and its threads.

use crate::engine::{BodyId, Vec2, World, Wrench};
use crate::quantities::CrowdQuantity;
use lemons_fmi::{Answer, refuse};

/// Returns the agent of an element of Fp or Mp.
pub(super) fn agent_of_drive(quantity: CrowdQuantity, element: usize) -> usize {
    if quantity == CrowdQuantity::Fp { element / 2 } else { element }
}

/// Returns the part of a drive that an element of Fp or Mp is.
pub(super) fn part_of_drive(drive: &mut Wrench, quantity: CrowdQuantity, element: usize) -> &mut f64 {
    match quantity {
        CrowdQuantity::Fp if element.is_multiple_of(2) => &mut drive.force.x,
        CrowdQuantity::Fp => &mut drive.force.y,
        _ => &mut drive.torque,
    }
}

/// Returns the input of a running world behind an element, if it is one.
#[inline]
pub(super) fn input(world: &mut World, quantity: CrowdQuantity, element: usize) -> Option<&mut f64> {
    let is_drive = matches!(quantity, CrowdQuantity::Fp | CrowdQuantity::Mp);
    is_drive.then(|| part_of_drive(&mut world.drive[agent_of_drive(quantity, element)], quantity, element))
}

/// Reads elements of a quantity from a running world, from an element on. Returns whether the world
/// has it.
#[inline(always)]
pub(super) fn read(world: &World, quantity: CrowdQuantity, first: usize, values: &mut [f64]) -> bool {
    fn each(first: usize, values: &mut [f64], number: impl Fn(usize) -> f64) {
        values.iter_mut().enumerate().for_each(|(k, value)| *value = number(first + k));
    }
    fn axes(first: usize, values: &mut [f64], vector: impl Fn(usize) -> Vec2) {
        each(first, values, |k| {
            let [x, y] = vector(k / 2).into();
            if k.is_multiple_of(2) { x } else { y }
        });
    }
    let (state, report, exposures) = (world.state(), world.contacts(), world.exposures());
    let faces = world.face_exposures();
    match quantity {
        CrowdQuantity::Fp => axes(first, values, |i| world.drive[i].force),
        CrowdQuantity::Mp => each(first, values, |i| world.drive[i].torque),
        CrowdQuantity::Position => axes(first, values, |i| state.poses[i].position),
        CrowdQuantity::Theta => each(first, values, |i| state.poses[i].orientation),
        CrowdQuantity::Velocity => axes(first, values, |i| state.twists[i].velocity),
        CrowdQuantity::Omega => each(first, values, |i| state.twists[i].angular_velocity),
        CrowdQuantity::NormalForce => each(first, values, |i| report.bodies[i].squeeze),
        CrowdQuantity::MeanNormalForce => each(first, values, |i| exposures[i].mean_force),
        CrowdQuantity::MeanPeopleForce => each(first, values, |i| exposures[i].mean_people_force()),
        CrowdQuantity::MeanWallForce => each(first, values, |i| exposures[i].mean_wall_force),
        CrowdQuantity::PeakNormalForce => each(first, values, |i| exposures[i].peak_force),
        CrowdQuantity::PeakOverlap => each(first, values, |i| exposures[i].peak_overlap),
        // A Trial that was chosen later may have fewer walls, or none.
        CrowdQuantity::WallMeanNormalForce => {
            each(first, values, |k| faces.get(k).map_or(0.0, |of| of.mean_force));
        }
        CrowdQuantity::WallPeakNormalForce => {
            each(first, values, |k| faces.get(k).map_or(0.0, |of| of.peak_force));
        }
        CrowdQuantity::Active => each(first, values, |i| world.is_present(BodyId::from(i)).into()),
        CrowdQuantity::AgentContacts => each(first, values, |i| report.bodies[i].agent_contacts.into()),
        CrowdQuantity::WallContacts => each(first, values, |i| report.bodies[i].wall_contacts.into()),
        CrowdQuantity::ContactingAgents => {
            each(first, values, |i| report.bodies[i].touching_bodies.into());
        }
        CrowdQuantity::TotalAgentContacts => values.fill(report.agent_contacts.into()),
        CrowdQuantity::TotalWallContacts => values.fill(report.wall_contacts.into()),
        CrowdQuantity::CoincidentContacts => values.fill(report.coincident.len() as f64),
        CrowdQuantity::LargestOverlap => values.fill(world.largest_overlap()),
        _ => return false,
    }
    true
}

/// Gives a world a number of threads: those of the previous world, if it has as many.
pub(super) fn give_threads(world: &mut World, threads: i32, so_far: Option<&World>) -> Answer<()> {
    if let Some(so_far) = so_far {
        world.share_threads(so_far);
    }
    let given = world.set_threads(usize::try_from(threads).unwrap_or(1));
    given.or_else(|error| refuse(format!("Threads: {error}")))
}
