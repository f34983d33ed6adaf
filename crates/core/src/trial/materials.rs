//! `Materials.xml`.

use crate::files::source::FileSource;
use crate::trial::agents::Agent;
use crate::trial::geometry::Geometry;
use crate::trial::heights::LOAD_LENGTH;
use crate::trial::schema::{AttributeValue, Schema};
use crate::trial::xml::{
    Checked, Element, Reading, document, empty, given_before, ids_of, read_alone, read_id,
};
use crate::xml::{Problem, number, quoted};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

pub(crate) static MATERIALS: Schema =
    Schema { name: "Materials", attributes: &[], children: &[&INTRINSIC, &BINARY] };
static INTRINSIC: Schema = Schema {
    name: "Intrinsic",
    attributes: &[("LoadLength", AttributeValue::Positive)],
    children: &[&MATERIAL],
};
static MATERIAL: Schema = Schema {
    name: "Material",
    attributes: &[
        ("Id", AttributeValue::Id),
        ("YoungModulus", AttributeValue::Positive),
        ("ShearModulus", AttributeValue::Positive),
    ],
    children: &[],
};
static BINARY: Schema = Schema { name: "Binary", attributes: &[], children: &[&CONTACT] };
static CONTACT: Schema = Schema {
    name: "Contact",
    attributes: &[
        ("Id1", AttributeValue::IdOf("material")),
        ("Id2", AttributeValue::IdOf("material")),
        ("GammaNormal", AttributeValue::NotNegative),
        ("GammaTangential", AttributeValue::NotNegative),
        ("KineticFriction", AttributeValue::NotNegative),
    ],
    children: &[],
};

/// `Materials.xml`.
#[derive(Debug, Clone, PartialEq)]
pub struct Materials {
    /// \[m\] `LoadLength`: height over which things touch with the stiffness that follows from the moduli; used where one of
    /// them has `Bottom` or `Top`.
    pub load_length: f64,
    /// `<Intrinsic>`
    pub intrinsic: Vec<Material>,
    /// `<Binary>`
    pub binary: Vec<ContactCoefficients>,
}

impl Default for Materials {
    fn default() -> Materials {
        Materials { load_length: LOAD_LENGTH, intrinsic: Vec::new(), binary: Vec::new() }
    }
}

impl Materials {
    /// Reads and checks a single `Materials.xml`. Returns it and the warnings.
    ///
    /// # Errors
    /// All errors in the file.
    pub fn read_from(files: &dyn FileSource, path: &Path) -> Checked<Materials> {
        read_alone(files, path, &MATERIALS, |root| read(root).materials)
    }
}

/// `<Material>`.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Unique among the materials.
    pub id: String,
    /// \[N/m\] 2D Young modulus.
    pub young_modulus: f64,
    /// \[N/m\] 2D shear modulus.
    pub shear_modulus: f64,
}

/// `<Contact>`: coefficients of the contact of two materials; their order does not matter.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactCoefficients {
    /// First material.
    pub id1: String,
    /// Second material; may be the same.
    pub id2: String,
    /// \[kg/s\] damping along the normal.
    pub gamma_normal: f64,
    /// \[kg/s\] damping along the tangent.
    pub gamma_tangential: f64,
    /// \[1\] coefficient of Coulomb friction.
    pub kinetic_friction: f64,
}

/// \[N/m\] stiffness of the springs between two materials, normal and tangential: `(k_n, k_t)` (paper, section 3.1).
///
/// The values are not positive or not finite if the moduli do not belong to a 2D elastic material (E ≥ 4G).
pub fn stiffness(first: &Material, second: &Material) -> (f64, f64) {
    let normal =
        |m: &Material| (4.0 * m.shear_modulus - m.young_modulus) / (4.0 * m.shear_modulus * m.shear_modulus);
    let tangential =
        |m: &Material| (6.0 * m.shear_modulus - m.young_modulus) / (8.0 * m.shear_modulus * m.shear_modulus);
    (1.0 / (normal(first) + normal(second)), 1.0 / (tangential(first) + tangential(second)))
}

/// The file as read, with what the checks of the other files need of it.
pub(crate) struct Read {
    pub(crate) materials: Materials,
    path: PathBuf,
    /// Line of each material.
    lines: Vec<u32>,
    /// Pairs of places in `intrinsic`, the lower first.
    pairs: HashMap<(usize, usize), u32>,
    /// Line of `<Binary>`; `None` when it is missing, which is reported once.
    binary_line: Option<u32>,
}

pub(crate) fn read(root: Element<'_>) -> Read {
    let (mut intrinsic, mut binary) = (Vec::new(), Vec::new());
    let (mut ids, mut lines, mut pairs) = (HashMap::new(), Vec::new(), HashMap::new());
    let list = root.only("Intrinsic");
    let load_length = list.filter(|list| list.node.has("LoadLength"));
    let load_length = load_length.map_or(LOAD_LENGTH, |list| {
        let length = list.number("LoadLength");
        if length > 0.0 && !(0.001..=1000.0).contains(&length) {
            list.wrong("LoadLength", "must be from 0.001 m to 1000 m");
        }
        length
    });
    for element in list.iter().flat_map(|list| list.children("Material")) {
        lines.push(element.line());
        intrinsic.push(Material {
            id: read_id(element, &mut ids),
            young_modulus: element.number("YoungModulus"),
            shear_modulus: element.number("ShearModulus"),
        });
    }
    let ids = ids_of(intrinsic.iter().map(|material| &material.id));
    let list = root.only("Binary");
    for element in list.iter().flat_map(|list| list.children("Contact")) {
        let (id1, first) = element.reference("Id1", Some(&ids));
        let (id2, second) = element.reference("Id2", Some(&ids));
        if let (Some(first), Some(second)) = (first, second) {
            let pair = (first.min(second), first.max(second));
            if let Some(line) = given_before(&mut pairs, pair, element) {
                let pair = format!("{} and {}", quoted(&id1), quoted(&id2));
                element.error(format!("duplicate pair {pair}, first given at line {line}"));
            }
        }
        binary.push(ContactCoefficients {
            id1,
            id2,
            gamma_normal: element.number("GammaNormal"),
            gamma_tangential: element.number("GammaTangential"),
            kinetic_friction: element.number("KineticFriction"),
        });
    }
    Read {
        materials: Materials { load_length, intrinsic, binary },
        path: root.node.file().to_owned(),
        lines,
        pairs,
        binary_line: list.map(Element::line),
    }
}

/// Materials that agents and walls may be of: the table of laws has a row and a column for each, 40 bytes for two.
const MOST_MATERIALS: usize = 1000;

/// Returns the pairs of materials that can touch, as places of them, the lower first: those of two agents, then those of an
/// agent and a wall. A rigid agent does not touch itself, nor a wall a wall.
///
/// `shapes`: agent and material of each shape; `walls`: materials of walls.
pub fn pairs_that_touch(shapes: &[(usize, usize)], walls: &BTreeSet<usize>) -> Vec<(usize, usize)> {
    // Of each material the only agent who has it; `None` if there are several.
    let mut sole: BTreeMap<usize, Option<usize>> = BTreeMap::new();
    for &(agent, material) in shapes {
        let own = sole.entry(material).or_insert(Some(agent));
        *own = own.filter(|&other| other == agent);
    }
    let among_agents = sole.iter().flat_map(|(&first, one)| {
        let others = sole.range(first..).filter(move |(_, other)| one.is_none() || one != *other);
        others.map(move |(&second, _)| (first, second))
    });
    let with_walls = sole.keys().flat_map(|&first| walls.iter().map(move |&second| (first, second)));
    let mut seen = BTreeSet::new();
    let pairs = among_agents.chain(with_walls).map(|(one, other)| (one.min(other), one.max(other)));
    pairs.filter(|&pair| seen.insert(pair)).collect()
}

/// Every pair of materials that can touch has its coefficients.
pub(crate) fn check_pairs(read: &Read, geometry: Option<&Geometry>, agents: &[Agent], reading: &Reading<'_>) {
    /// Of a file that forgot them all, these many say enough.
    const REPORTED: usize = 100;

    let ids = ids_of(read.materials.intrinsic.iter().map(|material| &material.id));
    let of_agent = |(agent, of): (usize, &Agent)| {
        let places = of.shapes.iter().filter_map(|shape| ids.get(&*shape.material_id).copied());
        places.map(|material| (agent, material)).collect::<Vec<_>>()
    };
    let shapes: Vec<(usize, usize)> = agents.iter().enumerate().flat_map(of_agent).collect();
    let walls = geometry.iter().flat_map(|geometry| &geometry.walls);
    let walls: BTreeSet<usize> = walls.filter_map(|wall| ids.get(&*wall.material_id).copied()).collect();
    let used = shapes.iter().map(|&(_, material)| material).chain(walls.iter().copied());
    let used = used.collect::<BTreeSet<_>>().len();
    if used > MOST_MATERIALS {
        let message =
            format!("agents and walls are of {used} materials: at most {MOST_MATERIALS} can be used");
        reading.report(Problem::of_file(&read.path, None, message));
        return;
    }
    let pairs = pairs_that_touch(&shapes, &walls).into_iter();
    let wrong = pairs.filter_map(|pair| read.pair_problem(pair)).take(REPORTED);
    wrong.for_each(|problem| reading.report(problem));
}

impl Read {
    fn pair_problem(&self, pair: (usize, usize)) -> Option<Problem> {
        let (first, second) = (self.materials.intrinsic.get(pair.0)?, self.materials.intrinsic.get(pair.1)?);
        if !self.pairs.contains_key(&pair) {
            let line = self.binary_line?;
            let message =
                format!("no <Contact> of {} and {}, which can touch", quoted(&first.id), quoted(&second.id));
            return Some(self.problem("Binary", line, message));
        }
        let moduli = [first.young_modulus, first.shear_modulus, second.young_modulus, second.shear_modulus];
        let (normal, tangential) = stiffness(first, second);
        let good = |k: f64| k > 0.0 && k.is_finite();
        if moduli.iter().any(|modulus| modulus.is_nan()) || (good(normal) && good(tangential)) {
            return None;
        }
        // The line of the one that is no 2D elastic material by itself.
        let culprit = if first.young_modulus < 4.0 * first.shear_modulus { pair.1 } else { pair.0 };
        let material = |Material { id, young_modulus, shear_modulus }: &Material| {
            let id = quoted(id);
            format!("{id} (YoungModulus {young_modulus:?}, ShearModulus {shear_modulus:?})")
        };
        let message = format!(
            "{} and {} touch with stiffnesses k_n = {normal:?}, k_t = {tangential:?} N/m: must be positive and finite",
            material(first),
            material(second)
        );
        Some(self.problem("Material", *self.lines.get(culprit)?, message))
    }

    fn problem(&self, element: &str, line: u32, message: String) -> Problem {
        Problem { element: Some(element.into()), ..Problem::of_file(&self.path, Some(line), message) }
    }
}

pub(crate) fn xml(materials: &Materials) -> String {
    document("Materials", |out| {
        let load_length = (materials.load_length != LOAD_LENGTH).then(|| number(materials.load_length));
        out.element("Intrinsic", &INTRINSIC.values(&[load_length.as_deref()]), |out| {
            for material in &materials.intrinsic {
                let [young, shear] = [material.young_modulus, material.shear_modulus].map(number);
                empty(out, &MATERIAL, &[&material.id, &young, &shear]);
            }
        });
        out.element("Binary", &[], |out| {
            for contact in &materials.binary {
                let numbers = [contact.gamma_normal, contact.gamma_tangential, contact.kinetic_friction];
                let [normal, tangential, friction] = numbers.map(number);
                empty(out, &CONTACT, &[&contact.id1, &contact.id2, &normal, &tangential, &friction]);
            }
        });
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn material(young_modulus: f64, shear_modulus: f64) -> Material {
        Material { id: String::new(), young_modulus, shear_modulus }
    }

    #[test]
    fn stiffness_of_the_paper_s_materials() {
        // 4G − E = 8 − 4 = 4, 6G − E = 8, G = 2: compliances 4/16 and 8/32 each, hence 1/(2/4) = 2.
        assert_eq!(stiffness(&material(4.0, 2.0), &material(4.0, 2.0)), (2.0, 2.0));
        assert!(stiffness(&material(5.0, 1.0), &material(5.0, 1.0)).0 < 0.0, "no material of the plane");
        let (naked, concrete) = (material(4.0e6, 1379310.3), material(1.7e9, 7.1e8));
        assert_eq!(stiffness(&naked, &concrete), stiffness(&concrete, &naked));
        let (normal, tangential) = stiffness(&naked, &naked);
        assert!((normal / 2.508e6 - 1.0).abs() < 1e-3, "{normal}");
        assert!((tangential / 1.780e6 - 1.0).abs() < 1e-3, "{tangential}");
    }
}
