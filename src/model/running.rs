//! A running world: the inputs in it, and its threads.

use crate::engine::{World, Wrench};
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

/// Gives a world a number of threads: those of the previous world, if it has as many.
pub(super) fn give_threads(world: &mut World, threads: i32, so_far: Option<&World>) -> Answer<()> {
    if let Some(so_far) = so_far {
        world.share_threads(so_far);
    }
    let given = world.set_threads(usize::try_from(threads).unwrap_or(1));
    given.or_else(|error| refuse(format!("Threads: {error}")))
}
