//! The table of FMI 2.0 variables: value reference, name, type, causality, unit and quantity.
//!
//! A variable's value reference is its index in the table. Names follow the structured naming convention and use the
//! words of the XML formats. The index of `agent[i]` starts from 0, in the order of Agents.xml.

use lemons_core::trial::Trial;
pub use lemons_fmi::v2::guid;
use lemons_fmi::variables::units::*;
use lemons_fmi::variables::{Domain, Unit};
pub use lemons_fmi::variables::{Kind, Role};
use serde::{Deserialize, Serialize};

/// Default of `MostMechanicalSteps`. So many steps take some minutes for five people, half a day for a thousand.
pub const MOST_MECHANICAL_STEPS: f64 = 1e9;

/// The quantity of the model behind a variable. Indices are `u32`, like value references: small rows are read faster.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Quantity {
    /// A quantity of one agent.
    Agent(u32, AgentQuantity),
    /// A quantity of one material.
    Material(u32, MaterialQuantity),
    /// A quantity of two materials.
    Contact(u32, ContactQuantity),
    /// Number of disk–disk contacts, each pair once.
    AgentContacts,
    /// Number of disk–face contacts.
    WallContacts,
    /// Number of contacts without a normal.
    CoincidentContacts,
    /// \[m\] Deepest overlap of the crowd within the last step.
    LargestOverlap,
    /// \[s\] Longest step of the integrator.
    TimeStepMechanical,
    /// Greatest number of mechanical steps in a communication step.
    MostMechanicalSteps,
    /// Number of mechanical steps between intermediate updates (FMI 3.0); 0 for none.
    IntermediateSteps,
    /// Number of threads of this instance.
    Threads,
    /// The packed Trial that is loaded.
    Trial,
    /// Whether the Trial's packed drive is played.
    PlayDrive,
    /// The directory for XML output.
    OutputDirectory,
}

/// A quantity of one agent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[allow(missing_docs)] // the names of FMU.md
pub enum AgentQuantity {
    FpX,
    FpY,
    Mp,
    Active,
    PositionX,
    PositionY,
    Theta,
    VelocityX,
    VelocityY,
    Omega,
    AgentContacts,
    WallContacts,
    ContactingAgents,
    NormalForce,
    MeanNormalForce,
    PeakNormalForce,
    PeakOverlap,
    Mass,
    MomentOfInertia,
    FloorDamping,
    AngularDamping,
}

/// A quantity of one material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum MaterialQuantity {
    YoungModulus,
    ShearModulus,
}

/// A quantity of two materials.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum ContactQuantity {
    GammaNormal,
    GammaTangential,
    KineticFriction,
}

/// A row of the table.
pub type Variable = lemons_fmi::variables::Variable<Quantity>;

type AgentRow = (AgentQuantity, &'static str, Kind, Role, Domain, &'static str);

const AGENT_ROWS: [AgentRow; 21] = {
    use AgentQuantity::*;
    use Domain::*;
    use Role::*;
    [
        (FpX, "Fp.x", Kind::Real(NEWTON), Input, Finite, "propulsion force along x"),
        (FpY, "Fp.y", Kind::Real(NEWTON), Input, Finite, "propulsion force along y"),
        (Mp, "Mp", Kind::Real(NEWTON_METRE), Input, Finite, "propulsion torque"),
        (
            Active,
            "Active",
            Kind::Boolean,
            Input,
            Finite,
            "whether it is there from the next step on; if not, it touches nothing and does not move",
        ),
        (PositionX, "Position.x", Kind::Real(METRE), Exact, Finite, "x of the centre of mass"),
        (PositionY, "Position.y", Kind::Real(METRE), Exact, Finite, "y of the centre of mass"),
        (Theta, "Theta", Kind::Real(RADIAN), Exact, Finite, "orientation: angle from the x axis to the gaze"),
        (VelocityX, "Velocity.x", Kind::Real(METRE_PER_SECOND), Exact, Finite, "velocity along x"),
        (VelocityY, "Velocity.y", Kind::Real(METRE_PER_SECOND), Exact, Finite, "velocity along y"),
        (Omega, "Omega", Kind::Real(RADIAN_PER_SECOND), Exact, Finite, "angular velocity"),
        (AgentContacts, "AgentContacts", Kind::Integer, Calculated, Finite, "disk-disk contacts"),
        (WallContacts, "WallContacts", Kind::Integer, Calculated, Finite, "disk-face contacts"),
        (
            ContactingAgents,
            "ContactingAgents",
            Kind::Integer,
            Calculated,
            Finite,
            "different agents that touch it",
        ),
        (
            NormalForce,
            "NormalForce",
            Kind::Real(NEWTON),
            Calculated,
            Finite,
            "squeeze at the communication point: sum of |Fn| over its contacts",
        ),
        (
            MeanNormalForce,
            "MeanNormalForce",
            Kind::Real(NEWTON),
            Calculated,
            NonNegative,
            "mean squeeze: time average of NormalForce over the last step",
        ),
        (
            PeakNormalForce,
            "PeakNormalForce",
            Kind::Real(NEWTON),
            Calculated,
            NonNegative,
            "peak squeeze: largest NormalForce within the last step",
        ),
        (
            PeakOverlap,
            "PeakOverlap",
            Kind::Real(METRE),
            Calculated,
            NonNegative,
            "deepest overlap of its contacts within the last step",
        ),
        (Mass, "Mass", Kind::Real(KILOGRAM), Parameter, Positive, "mass"),
        (
            MomentOfInertia,
            "MomentOfInertia",
            Kind::Real(KILOGRAM_METRE_SQUARED),
            Parameter,
            Positive,
            "moment of inertia about the centre of mass",
        ),
        (
            FloorDamping,
            "FloorDamping",
            Kind::Real(PER_SECOND),
            Parameter,
            NonNegative,
            "relaxation rate of the velocity, 1/t_transl",
        ),
        (
            AngularDamping,
            "AngularDamping",
            Kind::Real(PER_SECOND),
            Parameter,
            NonNegative,
            "relaxation rate of the angular velocity, 1/t_rot",
        ),
    ]
};

const MATERIAL_ROWS: [(MaterialQuantity, &str, Unit, &str); 2] = [
    (MaterialQuantity::YoungModulus, "YoungModulus", NEWTON_PER_METRE, "2D Young modulus"),
    (MaterialQuantity::ShearModulus, "ShearModulus", NEWTON_PER_METRE, "2D shear modulus"),
];

const CONTACT_ROWS: [(ContactQuantity, &str, Unit, &str); 3] = [
    (ContactQuantity::GammaNormal, "GammaNormal", KILOGRAM_PER_SECOND, "damping along the normal"),
    (ContactQuantity::GammaTangential, "GammaTangential", KILOGRAM_PER_SECOND, "damping along the tangent"),
    (ContactQuantity::KineticFriction, "KineticFriction", ONE, "Coulomb's coefficient"),
];

type CrowdRow = (&'static str, Quantity, Kind, Role, Domain, &'static str);

/// What is of the whole crowd, with the names of FMI 2.0.
const CROWD_ROWS: [CrowdRow; 10] = {
    use Role::{Calculated, Parameter};
    [
        (
            "TimeStepMechanical",
            Quantity::TimeStepMechanical,
            Kind::Real(SECOND),
            Parameter,
            Domain::Positive,
            "longest step of the integrator",
        ),
        (
            "MostMechanicalSteps",
            Quantity::MostMechanicalSteps,
            Kind::Real(ONE),
            Parameter,
            Domain::Positive,
            "a communication step of more mechanical steps is refused: nobody could cancel it",
        ),
        (
            "Threads",
            Quantity::Threads,
            Kind::Integer,
            Parameter,
            Domain::Positive,
            "threads this instance may use, up to one for each 512 agents; results do not depend on it",
        ),
        ("Trial", Quantity::Trial, Kind::String, Parameter, Domain::Finite, "which packed Trial to load"),
        (
            "PlayDrive",
            Quantity::PlayDrive,
            Kind::Boolean,
            Parameter,
            Domain::Finite,
            "whether the drive.csv of the packed Trial, if it has one, drives its agents; not those whose Fp or Mp is set",
        ),
        (
            "OutputDirectory",
            Quantity::OutputDirectory,
            Kind::String,
            Parameter,
            Domain::Finite,
            "if not empty: XML files are written there after every step",
        ),
        (
            "AgentContacts",
            Quantity::AgentContacts,
            Kind::Integer,
            Calculated,
            Domain::Finite,
            "disk-disk contacts of the crowd, each pair once",
        ),
        (
            "WallContacts",
            Quantity::WallContacts,
            Kind::Integer,
            Calculated,
            Domain::Finite,
            "disk-face contacts of the crowd",
        ),
        (
            "CoincidentContacts",
            Quantity::CoincidentContacts,
            Kind::Integer,
            Calculated,
            Domain::Finite,
            "of these contacts, those of centres at one place: no force acts between them",
        ),
        (
            "LargestOverlap",
            Quantity::LargestOverlap,
            Kind::Real(METRE),
            Calculated,
            Domain::NonNegative,
            "largest PeakOverlap: deepest overlap of the crowd within the last step",
        ),
    ]
};

/// Returns type, role, domain and description of what is of the whole crowd.
pub(crate) fn crowd_row(quantity: Quantity) -> (Kind, Role, Domain, &'static str) {
    if quantity == Quantity::IntermediateSteps {
        let description =
            "mechanical steps between intermediate updates within a communication step; 0: none";
        return (Kind::Integer, Role::Parameter, Domain::NonNegative, description);
    }
    let row = CROWD_ROWS.iter().find(|row| row.1 == quantity).expect("a row for each quantity of the crowd");
    (row.2, row.3, row.4, row.5)
}

/// Returns type, role, domain and description of a quantity of agents.
pub(crate) fn agent_row(quantity: AgentQuantity) -> (Kind, Role, Domain, &'static str) {
    let row = AGENT_ROWS.iter().find(|row| row.0 == quantity).expect("a row for each quantity of agents");
    (row.2, row.3, row.4, row.5)
}

/// Returns name, unit and description of a quantity of materials.
pub(crate) fn material_row(quantity: MaterialQuantity) -> (&'static str, Unit, &'static str) {
    let row = MATERIAL_ROWS.iter().find(|row| row.0 == quantity).expect("a row for each quantity");
    (row.1, row.2, row.3)
}

/// Returns name, unit and description of a quantity of two materials.
pub(crate) fn contact_row(quantity: ContactQuantity) -> (&'static str, Unit, &'static str) {
    let row = CONTACT_ROWS.iter().find(|row| row.0 == quantity).expect("a row for each quantity");
    (row.1, row.2, row.3)
}

/// Returns the variables of a Trial's FMI 2.0 FMU. A value reference is an index in this table.
pub fn table(trial: &Trial) -> Vec<Variable> {
    let of_crowd = |&(name, quantity, kind, role, domain, description): &CrowdRow| Variable {
        name: name.into(),
        quantity,
        kind,
        role,
        domain,
        description: description.into(),
    };
    let mut table: Vec<Variable> = CROWD_ROWS.iter().map(of_crowd).collect();
    for (i, agent) in (0..).zip(&trial.agents) {
        table.extend(AGENT_ROWS.iter().map(|&(quantity, name, kind, role, domain, description)| Variable {
            name: format!("agent[{i}].{name}"),
            quantity: Quantity::Agent(i, quantity),
            kind,
            role,
            domain,
            description: format!("agent Id {}: {description}", agent.id),
        }));
    }
    table.extend(of_materials(trial));
    table
}

/// Returns the variables of a Trial's materials.
pub(crate) fn of_materials(trial: &Trial) -> Vec<Variable> {
    let mut table = Vec::new();
    for (m, material) in (0..).zip(&trial.materials.intrinsic) {
        let id = quoted(&material.id);
        table.extend(MATERIAL_ROWS.iter().map(|&(quantity, name, unit, description)| Variable {
            name: format!("material.{id}.{name}"),
            quantity: Quantity::Material(m, quantity),
            kind: Kind::Real(unit),
            role: Role::Parameter,
            domain: Domain::Positive,
            description: description.into(),
        }));
    }
    for (c, contact) in (0..).zip(&trial.materials.binary) {
        let (id1, id2) = (quoted(&contact.id1), quoted(&contact.id2));
        table.extend(CONTACT_ROWS.iter().map(|&(quantity, name, unit, description)| Variable {
            name: format!("contact.{id1}.{id2}.{name}"),
            quantity: Quantity::Contact(c, quantity),
            kind: Kind::Real(unit),
            role: Role::Parameter,
            domain: Domain::NonNegative,
            description: description.into(),
        }));
    }
    table
}

/// Returns an Id as a part of a structured name: itself if it is a plain identifier, else a quoted name.
///
/// Quoted names may contain only some ASCII characters. All others, and `%` itself, are written as percent escapes of
/// their UTF-8 bytes, so that different Ids have different names.
fn quoted(id: &str) -> String {
    let letter = |c: char| c.is_ascii_alphabetic() || c == '_';
    let plain = id.starts_with(letter) && id.chars().all(|c| letter(c) || c.is_ascii_digit());
    if plain {
        return id.to_owned();
    }
    let mut name = String::from("'");
    for byte in id.bytes() {
        match byte {
            b'\'' | b'"' | b'\\' => {
                name.push('\\');
                name.push(char::from(byte));
            }
            b'?' => name.push_str("\\?"),
            b'%' => name.push_str("%25"),
            b' '..=b'~' if byte != b'`' => name.push(char::from(byte)),
            _ => name.push_str(&format!("%{byte:02X}")),
        }
    }
    name.push('\'');
    name
}

/// The field of a quantity in a Trial's documents: one match for reading and for writing.
macro_rules! place {
    ($trial:ident, $quantity:ident, $($borrow:tt)+) => {
        match $quantity {
            Quantity::TimeStepMechanical => $($borrow)+ $trial.parameters.time_step_mechanical,
            Quantity::Agent(i, quantity) => {
                let agent = $($borrow)+ $trial.agents[i as usize];
                let dynamics = $($borrow)+ $trial.dynamics[i as usize];
                match quantity {
                    AgentQuantity::FpX => $($borrow)+ dynamics.fp.x,
                    AgentQuantity::FpY => $($borrow)+ dynamics.fp.y,
                    AgentQuantity::Mp => $($borrow)+ dynamics.mp,
                    AgentQuantity::PositionX => $($borrow)+ dynamics.position.x,
                    AgentQuantity::PositionY => $($borrow)+ dynamics.position.y,
                    AgentQuantity::Theta => $($borrow)+ dynamics.theta,
                    AgentQuantity::VelocityX => $($borrow)+ dynamics.velocity.x,
                    AgentQuantity::VelocityY => $($borrow)+ dynamics.velocity.y,
                    AgentQuantity::Omega => $($borrow)+ dynamics.omega,
                    AgentQuantity::Mass => $($borrow)+ agent.mass,
                    AgentQuantity::MomentOfInertia => $($borrow)+ agent.moment_of_inertia,
                    AgentQuantity::FloorDamping => $($borrow)+ agent.floor_damping,
                    AgentQuantity::AngularDamping => $($borrow)+ agent.angular_damping,
                    AgentQuantity::Active
                    | AgentQuantity::AgentContacts
                    | AgentQuantity::WallContacts
                    | AgentQuantity::ContactingAgents
                    | AgentQuantity::NormalForce
                    | AgentQuantity::MeanNormalForce
                    | AgentQuantity::PeakNormalForce
                    | AgentQuantity::PeakOverlap => return None,
                }
            }
            Quantity::Material(m, quantity) => {
                let material = $($borrow)+ $trial.materials.intrinsic[m as usize];
                match quantity {
                    MaterialQuantity::YoungModulus => $($borrow)+ material.young_modulus,
                    MaterialQuantity::ShearModulus => $($borrow)+ material.shear_modulus,
                }
            }
            Quantity::Contact(c, quantity) => {
                let contact = $($borrow)+ $trial.materials.binary[c as usize];
                match quantity {
                    ContactQuantity::GammaNormal => $($borrow)+ contact.gamma_normal,
                    ContactQuantity::GammaTangential => $($borrow)+ contact.gamma_tangential,
                    ContactQuantity::KineticFriction => $($borrow)+ contact.kinetic_friction,
                }
            }
            Quantity::AgentContacts
            | Quantity::WallContacts
            | Quantity::CoincidentContacts
            | Quantity::LargestOverlap
            | Quantity::MostMechanicalSteps
            | Quantity::IntermediateSteps
            | Quantity::Threads
            | Quantity::Trial
            | Quantity::PlayDrive
            | Quantity::OutputDirectory => return None,
        }
    };
}

/// Returns the values that a Real of a Trial's documents can have; `None` if the Trial has no such Real.
pub fn domain(trial: &Trial, quantity: Quantity) -> Option<Domain> {
    match quantity {
        Quantity::TimeStepMechanical => Some(Domain::Positive),
        Quantity::Agent(i, quantity) if (i as usize) < trial.agents.len() => {
            let row = AGENT_ROWS.iter().find(|row| row.0 == quantity && row.3 != Role::Calculated);
            row.map(|row| row.4)
        }
        Quantity::Material(m, _) if (m as usize) < trial.materials.intrinsic.len() => Some(Domain::Positive),
        Quantity::Contact(c, _) if (c as usize) < trial.materials.binary.len() => Some(Domain::NonNegative),
        _ => None,
    }
}

/// Returns whether a quantity is an input: part of an agent's drive, or whether it is there.
pub fn is_input(quantity: Quantity) -> bool {
    use AgentQuantity::{Active, FpX, FpY, Mp};
    matches!(quantity, Quantity::Agent(_, FpX | FpY | Mp | Active))
}

/// Returns the value of a quantity in a Trial's documents, which is its start value. `None` if it is computed or not a
/// Real.
pub fn in_documents(trial: &Trial, quantity: Quantity) -> Option<f64> {
    Some(*place!(trial, quantity, &))
}

/// Returns the field of a quantity in a Trial's documents, to be changed.
pub fn in_documents_mut(trial: &mut Trial, quantity: Quantity) -> Option<&mut f64> {
    Some(place!(trial, quantity, &mut))
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
