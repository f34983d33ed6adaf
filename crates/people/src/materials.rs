//! Materials of people, of walls, and of what goes along with people.

use lemons_core::files::source::Memory;
use lemons_core::trial::{ContactCoefficients, Material, Materials};
use std::path::Path;
use std::sync::LazyLock;

/// Returns `Materials.xml` of the paper's App. C: concrete, people with clothes and without.
pub fn paper_materials() -> Materials {
    static PAPER: LazyLock<Materials> = LazyLock::new(|| {
        let (mut files, name) = (Memory::default(), Path::new("Materials.xml"));
        let text = include_bytes!("../../../resources/Trial_push/static/Materials.xml");
        files.put(name, text.to_vec());
        Materials::read_from(&files, name).expect("the committed file is right, tests read it").0
    });
    PAPER.clone()
}

/// Ids of the [`materials`] that people can have.
pub const SKINS: [&str; 3] = ["human_naked", "human_clothes", SOFT];

/// Id of the material of people with a softer chest. Only a Trial that uses it has it in its `Materials.xml`.
const SOFT: &str = "human_soft";

/// Ids of the [`materials`] of what goes along with people.
pub const PART_MATERIALS: [&str; 2] = [FRAME, LUGGAGE];
pub(crate) const FRAME: &str = "frame";
const LUGGAGE: &str = "luggage";

/// Returns the materials that people, walls and things can have: [`paper_materials`], `human_soft`, `frame`, `luggage`.
///
/// `frame` (wheelchairs, walkers, strollers) and `luggage` are assumptions, no source gives them: a frame on its tyres
/// is as stiff as the paper's people without clothes, and luggage ten times softer; both have the damping of clothes.
/// docs/people.md says how much results depend on it.
///
/// E and G of `human_soft` are the paper's for people without clothes, divided by 138: k_n is 18.2 kN/m between two
/// people, as soft as two chests, and a weak push runs through a row of people of 80 kg and 25 cm at 0.25 m √(k_n/m) =
/// 3.8 m/s. The damping is γ_n = 2 ζ √(k_n m\*), ζ = −ln e / √(π² + ln² e), for two people of 80 kg with the restitution
/// e = 0.3, while one pair of disks touches. Of a contact with a wall of concrete, k_n and m\* are twice as large, and so
/// is γ_n. Assumptions: e, γ_t = γ_n as in the paper, the friction of people without clothes, and that γ_n with the paper's
/// people is that with concrete (their m\* is not twice as large: 849 would be the same e). `docs/guide/squeeze.md` has
/// the sources.
pub fn materials() -> Materials {
    let Materials { mut intrinsic, mut binary, load_length } = paper_materials();
    intrinsic.push(Material { id: SOFT.into(), young_modulus: 2.9e4, shear_modulus: 1e4 });
    let others = [
        ("concrete", 1200.0, 0.5),
        ("human_clothes", 1200.0, 0.5),
        ("human_naked", 1200.0, 0.4),
        (SOFT, 600.0, 0.4),
    ];
    let contact = |one: &str, other: &str, gamma, kinetic_friction| ContactCoefficients {
        id1: one.into(),
        id2: other.into(),
        gamma_normal: gamma,
        gamma_tangential: gamma,
        kinetic_friction,
    };
    binary.extend(others.map(|(other, gamma, friction)| contact(other, SOFT, gamma, friction)));
    for (id, young_modulus, shear_modulus) in [(FRAME, 4e6, 1_379_310.3), (LUGGAGE, 4e5, 137_931.03)] {
        for other in intrinsic.iter().map(|material| &*material.id).chain([id]) {
            binary.push(contact(other, id, 1300.0, if other == "concrete" { 0.5 } else { 0.4 }));
        }
        intrinsic.push(Material { id: id.into(), young_modulus, shear_modulus });
    }
    Materials { load_length, intrinsic, binary }
}
