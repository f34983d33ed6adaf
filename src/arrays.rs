//! The table of FMI 3.0 variables: a crowd as arrays.
//!
//! Names are those of FMI 2.0 where possible. An array of agents has an element for each agent, in the order of Agents.xml;
//! one of materials for each `<Material>` of Materials.xml; one of contacts for each pair of materials.

use crate::variables::{
    self, AgentQuantity, ContactQuantity, Kind, MaterialQuantity, Quantity, Role, agent_row, contact_row,
    crowd_row, in_documents, material_row,
};
use lemons_core::trial::Trial;
use lemons_fmi::v3::{Array, Dimension, Size};
use lemons_fmi::variables::Domain;

/// The structural parameters.
pub const SIZES: [Size; 2] = [
    Size { name: "Agents", description: "number of agents" },
    Size { name: "Materials", description: "number of materials" },
];
const AGENTS: Dimension = Dimension::Size(0);
const MATERIALS: Dimension = Dimension::Size(1);

/// An array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Block {
    /// A single value.
    One(Quantity),
    /// These quantities of each agent.
    Agents(&'static [AgentQuantity]),
    /// A quantity of each material.
    Materials(MaterialQuantity),
    /// A quantity of each pair of materials, a symmetric matrix.
    Contacts(ContactQuantity),
    /// Ids of the agents.
    AgentIds,
    /// Ids of the materials.
    MaterialIds,
}

/// Name, quantities, and the description where it is not that of the one quantity.
const OF_AGENTS: [(&str, &[AgentQuantity], &str); 18] = {
    use AgentQuantity::*;
    [
        ("Fp", &[FpX, FpY], "propulsion force along x and y"),
        ("Mp", &[Mp], ""),
        ("Active", &[Active], ""),
        ("Position", &[PositionX, PositionY], "x and y of the centre of mass"),
        ("Theta", &[Theta], ""),
        ("Velocity", &[VelocityX, VelocityY], "velocity along x and y"),
        ("Omega", &[Omega], ""),
        ("AgentContacts", &[AgentContacts], ""),
        ("WallContacts", &[WallContacts], ""),
        ("ContactingAgents", &[ContactingAgents], ""),
        ("NormalForce", &[NormalForce], ""),
        ("MeanNormalForce", &[MeanNormalForce], ""),
        ("PeakNormalForce", &[PeakNormalForce], ""),
        ("PeakOverlap", &[PeakOverlap], ""),
        ("Mass", &[Mass], ""),
        ("MomentOfInertia", &[MomentOfInertia], ""),
        ("FloorDamping", &[FloorDamping], ""),
        ("AngularDamping", &[AngularDamping], ""),
    ]
};

/// Name and quantity of single values. Where an array of agents has the name that FMI 2.0 gives a number of the whole
/// crowd, the number is called a total here.
const OF_CROWD: [(&str, Quantity); 11] = [
    ("TimeStepMechanical", Quantity::TimeStepMechanical),
    ("MostMechanicalSteps", Quantity::MostMechanicalSteps),
    ("IntermediateSteps", Quantity::IntermediateSteps),
    ("Threads", Quantity::Threads),
    ("Trial", Quantity::Trial),
    ("PlayDrive", Quantity::PlayDrive),
    ("OutputDirectory", Quantity::OutputDirectory),
    ("TotalAgentContacts", Quantity::AgentContacts),
    ("TotalWallContacts", Quantity::WallContacts),
    ("CoincidentContacts", Quantity::CoincidentContacts),
    ("LargestOverlap", Quantity::LargestOverlap),
];

/// Returns the arrays, which are the same for every Trial.
pub fn arrays() -> Vec<Array<Block>> {
    let mut arrays: Vec<Array<Block>> = Vec::new();
    for (name, quantity) in OF_CROWD {
        let (kind, role, domain, description) = crowd_row(quantity);
        let block = Block::One(quantity);
        arrays.push(Array { name, block, kind, role, domain, dimensions: &[], description });
    }
    for (name, quantities, of_both) in OF_AGENTS {
        let (kind, role, domain, of_one) = agent_row(quantities[0]);
        let dimensions: &[Dimension] =
            if quantities.len() == 2 { &[AGENTS, Dimension::Fixed(2)] } else { &[AGENTS] };
        let description = if of_both.is_empty() { of_one } else { of_both };
        arrays.push(Array {
            name,
            block: Block::Agents(quantities),
            kind,
            role,
            domain,
            dimensions,
            description,
        });
    }
    for quantity in [MaterialQuantity::YoungModulus, MaterialQuantity::ShearModulus] {
        let (name, unit, description) = material_row(quantity);
        arrays.push(Array {
            name,
            block: Block::Materials(quantity),
            kind: Kind::Real(unit),
            role: Role::Parameter,
            domain: Domain::Positive,
            dimensions: &[MATERIALS],
            description,
        });
    }
    use ContactQuantity::{GammaNormal, GammaTangential, KineticFriction};
    for quantity in [GammaNormal, GammaTangential, KineticFriction] {
        let (name, unit, description) = contact_row(quantity);
        arrays.push(Array {
            name,
            block: Block::Contacts(quantity),
            kind: Kind::Real(unit),
            role: Role::Parameter,
            domain: Domain::NonNegative,
            dimensions: &[MATERIALS, MATERIALS],
            description,
        });
    }
    let ids = [
        ("AgentId", Block::AgentIds, &[AGENTS], "Ids of the agents"),
        ("MaterialId", Block::MaterialIds, &[MATERIALS], "Ids of the materials"),
    ];
    for (name, block, dimensions, description) in ids {
        arrays.push(Array {
            name,
            block,
            kind: Kind::String,
            role: Role::CalculatedParameter,
            domain: Domain::Finite,
            dimensions,
            description,
        });
    }
    arrays
}

/// Returns the values of the structural parameters for a Trial.
pub fn sizes(trial: &Trial) -> Vec<u64> {
    vec![trial.agents.len() as u64, trial.materials.intrinsic.len() as u64]
}

/// Returns the quantity behind an element of an array of numbers; `None` for a pair of materials that Materials.xml does
/// not have.
pub fn element(trial: &Trial, block: Block, k: usize) -> Option<Quantity> {
    Some(match block {
        Block::One(quantity) => quantity,
        Block::Agents(quantities) => {
            Quantity::Agent((k / quantities.len()) as u32, quantities[k % quantities.len()])
        }
        Block::Materials(quantity) => Quantity::Material(k as u32, quantity),
        Block::Contacts(quantity) => {
            let materials = &trial.materials.intrinsic;
            let (one, other) = (&materials[k / materials.len()].id, &materials[k % materials.len()].id);
            let of = |(a, b): (&String, &String)| (a, b) == (one, other) || (a, b) == (other, one);
            let contact = trial.materials.binary.iter().position(|pair| of((&pair.id1, &pair.id2)))?;
            Quantity::Contact(contact as u32, quantity)
        }
        Block::AgentIds | Block::MaterialIds => return None,
    })
}

/// Returns the elements that a quantity of materials has here, by its name in FMI 2.0: arrays, and places in them. A
/// quantity of two materials has two.
pub fn of_materials(trial: &Trial, name: &str) -> Vec<(&'static str, usize)> {
    let table = variables::of_materials(trial);
    let Some(quantity) = table.iter().find(|variable| variable.name == name).map(|found| found.quantity)
    else {
        return Vec::new();
    };
    let own = |array: &Array<Block>| match (array.block, quantity) {
        (Block::Materials(of), Quantity::Material(_, own)) => of == own,
        (Block::Contacts(of), Quantity::Contact(_, own)) => of == own,
        _ => false,
    };
    let Some(array) = arrays().into_iter().find(own) else { return Vec::new() };
    let places = 0..length(trial, array.block);
    places.filter(|k| element(trial, array.block, *k) == Some(quantity)).map(|k| (array.name, k)).collect()
}

/// Returns the number of elements of an array.
pub fn length(trial: &Trial, block: Block) -> usize {
    let (agents, materials) = (trial.agents.len(), trial.materials.intrinsic.len());
    match block {
        Block::One(_) => 1,
        Block::Agents(quantities) => agents * quantities.len(),
        Block::Materials(_) | Block::MaterialIds => materials,
        Block::Contacts(_) => materials * materials,
        Block::AgentIds => agents,
    }
}

/// Returns the start values of an array of Reals of the documents; 0 for a pair of materials that Materials.xml does
/// not have. `None` if it is computed.
pub fn starts(trial: &Trial, block: Block) -> Option<Vec<f64>> {
    let start = |k| match element(trial, block, k) {
        None => Some(0.0),
        Some(quantity) => in_documents(trial, quantity),
    };
    (0..length(trial, block)).map(start).collect()
}
