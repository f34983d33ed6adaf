//! A running world: the elements of quantities in it, and its threads.

use crate::engine::{BodyId, Vec2, World, Wrench};
use crate::quantities::Quantity;
use lemons_fmi::{Answer, refuse};

/// Returns the agent of an element of Fp or Mp.
pub(super) fn agent_of_drive(quantity: Quantity, element: usize) -> usize {
    if quantity == Quantity::Fp { element / 2 } else { element }
}

/// Returns the part of a drive that an element of Fp or Mp is.
pub(super) fn part_of_drive(drive: &mut Wrench, quantity: Quantity, element: usize) -> &mut f64 {
    match quantity {
        Quantity::Fp if element.is_multiple_of(2) => &mut drive.force.x,
        Quantity::Fp => &mut drive.force.y,
        _ => &mut drive.torque,
    }
}

/// Returns the input of a running world behind an element, if it is one.
#[inline]
pub(super) fn input(world: &mut World, quantity: Quantity, element: usize) -> Option<&mut f64> {
    let is_drive = matches!(quantity, Quantity::Fp | Quantity::Mp);
    is_drive.then(|| part_of_drive(&mut world.drive[agent_of_drive(quantity, element)], quantity, element))
}

/// Reads elements of a quantity from a running world, from an element on. Returns whether the world
/// has it.
#[inline(always)]
pub(super) fn read(world: &World, quantity: Quantity, first: usize, values: &mut [f64]) -> bool {
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
        Quantity::Fp => axes(first, values, |i| world.drive[i].force),
        Quantity::Mp => each(first, values, |i| world.drive[i].torque),
        Quantity::Position => axes(first, values, |i| state.poses[i].position),
        Quantity::Theta => each(first, values, |i| state.poses[i].orientation),
        Quantity::Velocity => axes(first, values, |i| state.twists[i].velocity),
        Quantity::Omega => each(first, values, |i| state.twists[i].angular_velocity),
        Quantity::NormalForce => each(first, values, |i| report.bodies[i].squeeze),
        Quantity::MeanNormalForce => each(first, values, |i| exposures[i].mean_force),
        Quantity::MeanPeopleForce => each(first, values, |i| exposures[i].mean_people_force()),
        Quantity::MeanWallForce => each(first, values, |i| exposures[i].mean_wall_force),
        Quantity::PeakNormalForce => each(first, values, |i| exposures[i].peak_force),
        Quantity::PeakOverlap => each(first, values, |i| exposures[i].peak_overlap),
        // A Trial that was chosen later may have fewer walls, or none.
        Quantity::WallMeanNormalForce => {
            each(first, values, |k| faces.get(k).map_or(0.0, |of| of.mean_force));
        }
        Quantity::WallPeakNormalForce => {
            each(first, values, |k| faces.get(k).map_or(0.0, |of| of.peak_force));
        }
        Quantity::Active => each(first, values, |i| world.is_present(BodyId::from(i)).into()),
        Quantity::AgentContacts => each(first, values, |i| report.bodies[i].agent_contacts.into()),
        Quantity::WallContacts => each(first, values, |i| report.bodies[i].wall_contacts.into()),
        Quantity::ContactingAgents => {
            each(first, values, |i| report.bodies[i].touching_bodies.into());
        }
        Quantity::TotalAgentContacts => values.fill(report.agent_contacts.into()),
        Quantity::TotalWallContacts => values.fill(report.wall_contacts.into()),
        Quantity::CoincidentContacts => values.fill(report.coincident.len() as f64),
        Quantity::LargestOverlap => values.fill(world.largest_overlap()),
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
