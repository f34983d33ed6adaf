//! The quantities of a crowd: one table with the name, unit, causality, shape and domain of each.
//! FMI 3.0 has each row as one array, FMI 2.0 has the elements.
//!
//! Names use the words of the XML formats. An array of agents has an element for each agent, in the
//! order of Agents.xml; one of materials for each `<Material>` of Materials.xml; one of pairs for
//! each two materials, a symmetric matrix; one of walls for each straight piece of a wall, and one of
//! barriers for each panel, in the order of Geometry.xml.

use crate::engine::{BodyId, ChestExposure, World};
use lemons_core::plane::Vec2;
use lemons_core::trial::{Agent, ContactCoefficients, Materials, Trial, Wall};
use lemons_fmi::variables::types::*;
use lemons_fmi::variables::{Dimension, Domain, Scalar, Size, Variable, row};
pub use lemons_fmi::variables::{Role, VariableType};
use serde::{Deserialize, Serialize};
use uuid::Uuid;

/// Default of `MostMechanicalSteps`. So many steps take some minutes for five people, half a day
/// for a thousand.
pub const MOST_MECHANICAL_STEPS: f64 = 1e9;

/// The structural parameters.
pub const SIZES: [Size; 6] = [
    Size::new("Agents", "number of agents"),
    Size::new("Materials", "number of materials"),
    Size::new("WallSegments", "number of straight pieces of walls; 1 without walls"),
    Size { optional: true, ..Size::new("Panels", "number of panels of walls") },
    Size { optional: true, ..Size::new("Chests", "number of agents, if the load on chests is found") },
    Size { optional: true, ..Size::new("Doors", "number of walls that open") },
];

const ONE_VALUE: &[Dimension] = &[];
const AGENTS: &[Dimension] = &[Dimension::Size(0)];
const VECTORS: &[Dimension] = &[Dimension::Size(0), Dimension::Fixed(2)];
const MATERIALS: &[Dimension] = &[Dimension::Size(1)];
const PAIRS: &[Dimension] = &[Dimension::Size(1), Dimension::Size(1)];
const WALLS: &[Dimension] = &[Dimension::Size(2)];
const PANELS: &[Dimension] = &[Dimension::Size(3)];
const CHESTS: &[Dimension] = &[Dimension::Size(4)];
const DOORS: &[Dimension] = &[Dimension::Size(5)];
/// Where disks and faces are: on this contacts and overlaps depend at the start.
const PLACES: &[CrowdQuantity] = &[
    CrowdQuantity::Trial,
    CrowdQuantity::Active,
    CrowdQuantity::DoorOpen,
    CrowdQuantity::Position,
    CrowdQuantity::Theta,
];
/// On this normal forces depend at the start.
const FORCES: &[CrowdQuantity] = &[
    CrowdQuantity::Trial,
    CrowdQuantity::Active,
    CrowdQuantity::DoorOpen,
    CrowdQuantity::Position,
    CrowdQuantity::Theta,
    CrowdQuantity::Velocity,
    CrowdQuantity::Omega,
    CrowdQuantity::YoungModulus,
    CrowdQuantity::ShearModulus,
    CrowdQuantity::GammaNormal,
];
/// On this all forces depend at the start.
const ALL_FORCES: &[CrowdQuantity] = &[
    CrowdQuantity::Trial,
    CrowdQuantity::Active,
    CrowdQuantity::DoorOpen,
    CrowdQuantity::Position,
    CrowdQuantity::Theta,
    CrowdQuantity::Velocity,
    CrowdQuantity::Omega,
    CrowdQuantity::YoungModulus,
    CrowdQuantity::ShearModulus,
    CrowdQuantity::GammaNormal,
    CrowdQuantity::GammaTangential,
    CrowdQuantity::KineticFriction,
];
/// Beginnings of the names of arrays of walls, of panels and of doors; in FMI 2.0 they are before the name.
const WALL: &str = "Wall";
const BARRIER: &str = "Barrier";
const DOOR: &str = "Door";

/// Makes the quantities: name, dimensions, type; role and description, by the methods of a [`Variable`]; and how an
/// element is read from a running world, if it is there.
macro_rules! quantities {
    ($($name:ident: $dimensions:expr, $kind:expr, $(.$method:ident($($argument:tt)*))+
       $(, |$world:ident, $element:pat_param| $read:expr)?;)*) => {
        /// A quantity: a row of [`QUANTITIES`].
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        #[allow(missing_docs)] // the table says it
        pub enum CrowdQuantity { $($name),* }

        /// The table. Where an array of agents has the name that FMI 2.0 gives a number of the whole crowd, the number is
        /// called a total.
        pub static QUANTITIES: [Variable<CrowdQuantity>; [$(CrowdQuantity::$name),*].len()] = {
            use CrowdQuantity::*;
            use Domain::*;
            use VariableType::*;
            [$(row($name, stringify!($name), $dimensions, $kind)$(.$method($($argument)*))+),*]
        };

        impl CrowdQuantity {
            /// Reads elements from a running world, from an element on. Returns whether the world has it.
            #[inline(always)]
            pub fn read(self, world: &World, first: usize, values: &mut [f64]) -> bool {
                match self {
                    $($(CrowdQuantity::$name => {
                        let number = |$world: &World, $element: usize| -> f64 { $read };
                        values.iter_mut().enumerate().for_each(|(k, value)| *value = number(world, first + k));
                    })?)*
                    _ => return false,
                }
                true
            }
        }
    };
}

quantities! {
    TimeStepMechanical: ONE_VALUE, Real(DURATION), .parameter(Positive, "longest step of the integrator");
    MostMechanicalSteps: ONE_VALUE, Real(COUNT),
        .parameter(Positive, "a communication step of more mechanical steps is refused: nobody could cancel it");
    IntermediateSteps: ONE_VALUE, Integer,
        .parameter(NonNegative, "mechanical steps between intermediate updates within a communication step; 0: none");
    Threads: ONE_VALUE, Integer,
        .parameter(Positive, "threads this instance may use, up to one for each 512 agents; results do not depend on it");
    Trial: ONE_VALUE, String, .parameter(Finite, "which packed Trial to load");
    PlayDrive: ONE_VALUE, Boolean,
        .parameter(
            Finite,
            "whether the drive.csv of the packed Trial, if it has one, drives its \
             agents; not those whose Fp or Mp is set",
        );
    OutputDirectory: ONE_VALUE, String,
        .parameter(Finite, "if not empty: XML files are written there after every step");
    TotalAgentContacts: ONE_VALUE, Integer,
        .calculated("disk-disk contacts of the crowd, each pair once").initially_on(PLACES),
        |world, _| world.contacts().agent_contacts.into();
    TotalWallContacts: ONE_VALUE, Integer, .calculated("disk-face contacts of the crowd").initially_on(PLACES),
        |world, _| world.contacts().wall_contacts.into();
    CoincidentContacts: ONE_VALUE, Integer,
        .calculated("of these contacts, those of centres at one place: no force acts between them")
        .initially_on(PLACES), |world, _| world.contacts().coincident.len() as f64;
    LargestOverlap: ONE_VALUE, Real(OVERLAP),
        .calculated("largest PeakOverlap: deepest overlap of the crowd within the last step")
        .initially_on(PLACES), |world, _| world.largest_overlap();
    Fp: VECTORS, Real(FORCE), .input("propulsion force along x and y"),
        |world, k| axis_of(world.drive[k / 2].force, k);
    Mp: AGENTS, Real(TORQUE), .input("propulsion torque"), |world, i| world.drive[i].torque;
    Active: AGENTS, Boolean,
        .input("whether it is there from the next step on; if not, it touches nothing and does not move"),
        |world, i| world.is_present(BodyId::from(i)).into();
    DoorOpen: DOORS, Boolean,
        .input(
            "whether the door is open from the next step on, at the times at which it may be: Open in Geometry.xml; it \
             shuts when nobody is in it",
        );
    Position: VECTORS, Real(POSITION), .exact("x and y of the centre of mass"),
        |world, k| axis_of(world.state().poses[k / 2].position, k);
    Theta: AGENTS, Real(ANGLE), .exact("orientation: angle from the x axis to the gaze"),
        |world, i| world.state().poses[i].orientation;
    Velocity: VECTORS, Real(VELOCITY), .exact("velocity along x and y"),
        |world, k| axis_of(world.state().twists[k / 2].velocity, k);
    Omega: AGENTS, Real(ANGULAR_VELOCITY), .exact("angular velocity"),
        |world, i| world.state().twists[i].angular_velocity;
    AgentContacts: AGENTS, Integer, .calculated("disk-disk contacts").initially_on(PLACES),
        |world, i| world.contacts().bodies[i].agent_contacts.into();
    WallContacts: AGENTS, Integer, .calculated("disk-face contacts").initially_on(PLACES),
        |world, i| world.contacts().bodies[i].wall_contacts.into();
    ContactingAgents: AGENTS, Integer, .calculated("different agents that touch it").initially_on(PLACES),
        |world, i| world.contacts().bodies[i].touching_bodies.into();
    NormalForce: AGENTS, Real(NORMAL_FORCE),
        .calculated("squeeze at the communication point: sum of |Fn| over its contacts").initially_on(FORCES),
        |world, i| world.contacts().bodies[i].squeeze;
    MeanNormalForce: AGENTS, Real(NORMAL_FORCE),
        .calculated("mean squeeze: time average of NormalForce over the last step").initially_on(FORCES),
        |world, i| world.exposures()[i].mean_force;
    MeanPeopleForce: AGENTS, Real(NORMAL_FORCE),
        .calculated("mean squeeze by other agents: the part of MeanNormalForce that is not by walls")
        .initially_on(FORCES), |world, i| world.exposures()[i].mean_people_force();
    MeanWallForce: AGENTS, Real(NORMAL_FORCE),
        .calculated("mean squeeze by walls: time average of the sum of |Fn| over its contacts with walls")
        .initially_on(FORCES), |world, i| world.exposures()[i].mean_wall_force;
    PeakNormalForce: AGENTS, Real(NORMAL_FORCE),
        .calculated("peak squeeze: largest NormalForce within the last step").initially_on(FORCES),
        |world, i| world.exposures()[i].peak_force;
    PeakOverlap: AGENTS, Real(OVERLAP),
        .calculated("deepest overlap of its contacts within the last step").initially_on(PLACES),
        |world, i| world.exposures()[i].peak_overlap;
    CompressionFront: AGENTS, Real(FORCE), .named("Compression.front")
        .calculated("front-back compression")
        .initially_on(ALL_FORCES), |world, i| world.compressions()[i].front;
    CompressionSide: AGENTS, Real(FORCE), .named("Compression.side")
        .calculated("side-side compression")
        .initially_on(ALL_FORCES), |world, i| world.compressions()[i].side;
    // A Trial that was chosen later may have no heights of chests.
    ChestForce: CHESTS, Real(NORMAL_FORCE),
        .calculated("time average of the sum of |Fn| over the contacts of its chest over the last step")
        .initially_on(FORCES), |world, i| chest(world, i).map_or(0.0, |of| of.people_force + of.wall_force);
    ChestWallForce: CHESTS, Real(NORMAL_FORCE), .calculated("the part of ChestForce by walls")
        .initially_on(FORCES), |world, i| chest(world, i).map_or(0.0, |of| of.wall_force);
    ChestFront: CHESTS, Real(FORCE), .named("ChestCompression.front")
        .calculated("time average of the force that presses its chest together along the gaze over the last step")
        .initially_on(ALL_FORCES), |world, i| chest(world, i).map_or(0.0, |of| of.compression.front);
    ChestSide: CHESTS, Real(FORCE), .named("ChestCompression.side")
        .calculated("the same across the gaze")
        .initially_on(ALL_FORCES), |world, i| chest(world, i).map_or(0.0, |of| of.compression.side);
    ChestLeast: CHESTS, Real(FORCE), .named("ChestCompression.least")
        .calculated("smaller principal part of the same: what presses it together from all sides")
        .initially_on(ALL_FORCES), |world, i| chest(world, i).map_or(0.0, |of| of.compression.principal()[0]);
    // A Trial that was chosen later may have fewer walls, or none.
    WallMeanNormalForce: WALLS, Real(NORMAL_FORCE),
        .calculated("time average of the sum of |Fn| over its contacts with agents over the last step")
        .initially_on(FORCES), |world, k| world.face_exposures().get(k).map_or(0.0, |of| of.mean_force);
    WallPeakNormalForce: WALLS, Real(NORMAL_FORCE),
        .calculated("largest sum of |Fn| over its contacts with agents within the last step")
        .initially_on(FORCES), |world, k| world.face_exposures().get(k).map_or(0.0, |of| of.peak_force);
    BarrierLoad: PANELS, Real(LINE_LOAD),
        .calculated("time average of the sum of |Fn| over its contacts with agents over the last step, over its length")
        .initially_on(FORCES), |world, k| world.panel_loads(k).0;
    BarrierPeakLoad: PANELS, Real(LINE_LOAD),
        .calculated("largest sum of |Fn| over its contacts with agents within the last step, over its length")
        .initially_on(FORCES), |world, k| world.panel_loads(k).1;
    Mass: AGENTS, Real(MASS), .parameter(Positive, "mass");
    MomentOfInertia: AGENTS, Real(INERTIA), .parameter(Positive, "moment of inertia about the centre of mass");
    FloorDamping: AGENTS, Real(RATE), .parameter(NonNegative, "relaxation rate of the velocity, 1/t_transl");
    AngularDamping: AGENTS, Real(RATE),
        .parameter(NonNegative, "relaxation rate of the angular velocity, 1/t_rot");
    YoungModulus: MATERIALS, Real(MODULUS), .parameter(Positive, "2D Young modulus E; E < 4 G").tunable();
    ShearModulus: MATERIALS, Real(MODULUS), .parameter(Positive, "2D shear modulus G").tunable();
    GammaNormal: PAIRS, Real(DAMPING), .parameter(NonNegative, "damping along the normal").tunable();
    GammaTangential: PAIRS, Real(DAMPING), .parameter(NonNegative, "damping along the tangent").tunable();
    KineticFriction: PAIRS, Real(FRICTION), .parameter(NonNegative, "Coulomb's coefficient").tunable();
    AgentId: AGENTS, String, .calculated_parameter("Ids of the agents").initially_on(&[Trial]);
    MaterialId: MATERIALS, String, .calculated_parameter("Ids of the materials").initially_on(&[Trial]);
}

impl CrowdQuantity {
    /// Returns whether it has an element for each two materials.
    pub fn is_of_pairs(self) -> bool {
        self.row().dimensions == PAIRS
    }

    /// Returns its row of the table.
    pub fn row(self) -> &'static Variable<CrowdQuantity> {
        &QUANTITIES[self as usize]
    }
}

/// Returns the values of the structural parameters for a Trial.
pub fn sizes(trial: &Trial) -> Vec<u64> {
    // FMI 3.0: no size is 0 in a model description.
    let segments = segments(trial).count().max(1);
    // Without panels there are no arrays of them.
    let panels = trial.geometry.panel_count();
    let agents = trial.agents.len() as u64;
    let chests = if trial.agents.iter().any(Agent::has_chest) { agents } else { 0 };
    let materials = trial.materials.intrinsic.len() as u64;
    vec![agents, materials, segments as u64, panels as u64, chests, trial.geometry.doors().count() as u64]
}

/// Returns the straight pieces of walls: the wall of each, and its place in it.
pub fn segments(trial: &Trial) -> impl Iterator<Item = (&Wall, usize)> {
    trial.geometry.walls.iter().flat_map(|wall| (1..wall.corners.len()).map(move |end| (wall, end - 1)))
}

/// Returns the variables of a Trial's FMI 2.0 FMU. A value reference is an index in this list.
pub fn scalars(trial: &Trial) -> Vec<Scalar<CrowdQuantity>> {
    let of = |dimensions: &'static [Dimension]| {
        QUANTITIES.iter().filter(move |row| row.dimensions.first() == dimensions.first())
    };
    let of_crowd = of(ONE_VALUE).filter(|row| row.quantity != CrowdQuantity::IntermediateSteps);
    let mut scalars: Vec<Scalar<CrowdQuantity>> = of_crowd.flat_map(|row| row.scalars(0, "", "")).collect();
    for scalar in &mut scalars {
        scalar.name = scalar.name.trim_start_matches("Total").to_owned();
    }
    let has_chests = sizes(trial)[4] > 0;
    let numbers = || {
        let of_chests = of(CHESTS).filter(move |_| has_chests);
        of(AGENTS).filter(|row| row.kind != VariableType::String).chain(of_chests)
    };
    for (i, agent) in trial.agents.iter().enumerate() {
        let (prefix, about) = (format!("agent[{i}]."), format!("agent Id {}: ", agent.id));
        scalars.extend(numbers().flat_map(|row| row.scalars(i, &prefix, &about)));
    }
    for (k, (wall, piece)) in segments(trial).enumerate() {
        let about = format!("piece {piece} of wall Id {}: ", wall.id);
        let of_piece = of(WALLS).flat_map(|row| row.scalars(k, "", &about));
        scalars.extend(of_piece.map(|scalar| Scalar {
            name: format!("wall[{k}].{}", scalar.name.trim_start_matches(WALL)),
            ..scalar
        }));
    }
    for (k, (wall, [start, end])) in trial.geometry.panels().enumerate() {
        let middle = (start + end) * 0.5;
        let about = format!("panel of wall Id {} about ({:.2}, {:.2}) m: ", wall.id, middle.x, middle.y);
        let of_panel = of(PANELS).flat_map(|row| row.scalars(k, "", &about));
        scalars.extend(of_panel.map(|scalar| Scalar {
            name: format!("barrier[{k}].{}", scalar.name.trim_start_matches(BARRIER)),
            ..scalar
        }));
    }
    for (k, (_, wall)) in trial.geometry.doors().enumerate() {
        let about = format!("wall Id {}: ", wall.id);
        let of_door = of(DOORS).flat_map(|row| row.scalars(k, "", &about));
        scalars.extend(of_door.map(|scalar| Scalar {
            name: format!("door[{k}].{}", scalar.name.trim_start_matches(DOOR)),
            ..scalar
        }));
    }
    scalars.extend(scalars_of_materials(trial));
    scalars
}

/// Returns the variables of a Trial's materials. A quantity of a pair of materials has one, for the
/// pair as it is in Materials.xml.
fn scalars_of_materials(trial: &Trial) -> Vec<Scalar<CrowdQuantity>> {
    let of = |dimensions| {
        QUANTITIES.iter().filter(move |row| row.dimensions == dimensions && row.kind != VariableType::String)
    };
    let materials = &trial.materials.intrinsic;
    let mut scalars = Vec::new();
    for (m, material) in materials.iter().enumerate() {
        let prefix = format!("material.{}.", quoted(&material.id));
        scalars.extend(of(MATERIALS).flat_map(|row| row.scalars(m, &prefix, "")));
    }
    let place = |id: &str| materials.iter().position(|material| material.id == id);
    for contact in &trial.materials.binary {
        let (Some(one), Some(other)) = (place(&contact.id1), place(&contact.id2)) else { continue };
        let prefix = format!("contact.{}.{}.", quoted(&contact.id1), quoted(&contact.id2));
        let element = one * materials.len() + other;
        scalars.extend(of(PAIRS).flat_map(|row| row.scalars(element, &prefix, "")));
    }
    scalars
}

/// Returns the GUID of a Trial's FMI 2.0 FMU.
pub fn guid(trial: &Trial) -> Uuid {
    lemons_fmi::guid(&scalars(trial))
}

/// Returns a token of the variables that the Trials of an FMI 2.0 FMU share: of all but those of walls, panels, chests and doors. The FMU has
/// these of its first Trial; where another one has fewer walls, they are 0.
pub fn shared(trial: &Trial) -> Uuid {
    let mut scalars = scalars(trial);
    scalars.retain(|scalar| ![WALLS, PANELS, CHESTS, DOORS].contains(&scalar.variable.dimensions));
    lemons_fmi::guid(&scalars)
}

/// Returns the elements that a quantity of materials has in FMI 3.0, by its name in FMI 2.0: names
/// of arrays, and places in them. A quantity of two materials has two.
pub fn of_materials(trial: &Trial, name: &str) -> Vec<(&'static str, usize)> {
    let found = scalars_of_materials(trial).into_iter().find(|scalar| scalar.name == name);
    let Some(Scalar { variable, element, .. }) = found else { return Vec::new() };
    let mut elements = vec![element];
    if variable.dimensions == PAIRS {
        let count = trial.materials.intrinsic.len();
        elements.push((element % count) * count + element / count);
    }
    elements.sort_unstable();
    elements.dedup();
    elements.into_iter().map(|element| (variable.name, element)).collect()
}

/// Returns an Id as a part of a structured name: itself if it is a plain identifier, else a quoted
/// name.
///
/// Quoted names may contain only some ASCII characters. All others, and `%` itself, are written as
/// percent escapes of their UTF-8 bytes, so that different Ids have different names.
fn quoted(id: &str) -> String {
    let letter = |c: char| c.is_ascii_alphabetic() || c == '_';
    let plain = id.starts_with(letter) && id.chars().all(|c| letter(c) || c.is_ascii_digit());
    if plain {
        return id.to_owned();
    }
    let mut name = String::from("'");
    for byte in id.bytes() {
        match byte {
            b'\'' | b'"' | b'\\' | b'?' => {
                name.push('\\');
                name.push(char::from(byte));
            }
            b'%' => name.push_str("%25"),
            b' '..=b'~' if byte != b'`' => name.push(char::from(byte)),
            _ => name.push_str(&format!("%{byte:02X}")),
        }
    }
    name.push('\'');
    name
}

/// Returns the element of a quantity in a Trial's documents; `None` if it is not there: it is
/// computed, or belongs to the instance.
pub(crate) fn field(trial: &mut Trial, quantity: CrowdQuantity, element: usize) -> Option<&mut f64> {
    use CrowdQuantity::*;
    let i = if quantity.row().is_vector() { element / 2 } else { element };
    Some(match quantity {
        TimeStepMechanical => &mut trial.parameters.time_step_mechanical,
        Fp => axis(&mut trial.dynamics.get_mut(i)?.fp, element),
        Mp => &mut trial.dynamics.get_mut(i)?.mp,
        Position => axis(&mut trial.dynamics.get_mut(i)?.position, element),
        Theta => &mut trial.dynamics.get_mut(i)?.theta,
        Velocity => axis(&mut trial.dynamics.get_mut(i)?.velocity, element),
        Omega => &mut trial.dynamics.get_mut(i)?.omega,
        Mass => &mut trial.agents.get_mut(i)?.mass,
        MomentOfInertia => &mut trial.agents.get_mut(i)?.moment_of_inertia,
        FloorDamping => &mut trial.agents.get_mut(i)?.floor_damping,
        AngularDamping => &mut trial.agents.get_mut(i)?.angular_damping,
        YoungModulus => &mut trial.materials.intrinsic.get_mut(i)?.young_modulus,
        ShearModulus => &mut trial.materials.intrinsic.get_mut(i)?.shear_modulus,
        GammaNormal => &mut contact(&mut trial.materials, element)?.gamma_normal,
        GammaTangential => &mut contact(&mut trial.materials, element)?.gamma_tangential,
        KineticFriction => &mut contact(&mut trial.materials, element)?.kinetic_friction,
        _ => return None,
    })
}

fn chest(world: &World, agent: usize) -> Option<&ChestExposure> {
    world.chest_exposures().get(agent)
}

fn axis_of(mut vector: Vec2, element: usize) -> f64 {
    *axis(&mut vector, element)
}

fn axis(vector: &mut Vec2, element: usize) -> &mut f64 {
    if element.is_multiple_of(2) { &mut vector.x } else { &mut vector.y }
}

fn contact(materials: &mut Materials, element: usize) -> Option<&mut ContactCoefficients> {
    let place = place_of_contact(materials, element)?;
    materials.binary.get_mut(place)
}

/// Returns the place in Materials.xml of a pair of materials, an element of a matrix; `None` if
/// they never touch.
pub(crate) fn place_of_contact(materials: &Materials, element: usize) -> Option<usize> {
    let [one, other] = ids_of_pair(materials, element)?;
    let is_it = |ContactCoefficients { id1, id2, .. }: &ContactCoefficients| {
        (id1 == one && id2 == other) || (id1 == other && id2 == one)
    };
    materials.binary.iter().position(is_it)
}

/// Returns the Ids of a pair of materials, an element of a matrix.
pub(crate) fn ids_of_pair(materials: &Materials, element: usize) -> Option<[&str; 2]> {
    let all = &materials.intrinsic;
    let one = all.get(element / all.len().max(1))?;
    Some([&one.id, &all[element % all.len()].id])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_become_parts_of_structured_names() {
        assert_eq!(quoted("human_naked"), "human_naked");
        assert_eq!(quoted("0"), "'0'");
        assert_eq!(quoted("two words"), "'two words'");
        assert_eq!(quoted("it's"), "'it\\'s'");
        assert_eq!(quoted("Glück"), "'Gl%C3%BCck'");
        assert_ne!(quoted("ü"), quoted("%C3%BC"));
    }
}
