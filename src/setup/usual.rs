//! The usual values of attributes, and the units in which others may be by mistake.

use super::Setup;
use lemons_trial::{Agent, AgentDynamics, Contact, Material, Places, Problem, Severity, quoted};
use std::f64::consts::PI;
use std::path::PathBuf;

/// An attribute, its usual values, and why others are not.
struct Usual {
    file: fn(&Places) -> &PathBuf,
    element: &'static str,
    attribute: &'static str,
    /// Of the values.
    unit: &'static str,
    /// The least and the greatest magnitude; zero is usual, too.
    range: [f64; 2],
    reason: &'static str,
    /// One that is met often: of several units, the one that leads nearest to it is asked for.
    typical: f64,
    /// Units of values by mistake, and what one of them is in `unit`; those per body are divided by [`Value::body`].
    mistaken: &'static [(&'static str, f64, Per)],
    values: fn(&Setup<'_>) -> Vec<Value>,
}

#[derive(Clone, Copy, PartialEq)]
enum Per {
    One,
    Body,
}

/// A value in a file.
struct Value {
    value: f64,
    /// As it is written.
    shown: String,
    of: String,
    /// \[kg\] or \[kg m²\] Mass or moment of inertia.
    body: f64,
}

fn value(value: f64, of: String) -> Value {
    Value { value, shown: format!("{value:?}"), of, body: 1.0 }
}

/// Of each agent a value, and its mass or moment of inertia.
fn agents(setup: &Setup<'_>, of: fn(&Agent) -> (f64, f64)) -> Vec<Value> {
    let one = |agent: &Agent| {
        let (number, body) = of(agent);
        Value { body, ..value(number, format!("agent {}", quoted(&agent.id))) }
    };
    setup.agents.iter().map(one).collect()
}

fn dynamics(setup: &Setup<'_>, of: fn(&AgentDynamics) -> f64) -> Vec<Value> {
    let all = setup.agents.iter().zip(&setup.dynamics);
    all.map(|(agent, dynamics)| value(of(dynamics), format!("agent {}", quoted(&agent.id)))).collect()
}

fn velocities(setup: &Setup<'_>) -> Vec<Value> {
    let all = dynamics(setup, |dynamics| dynamics.velocity.norm()).into_iter().zip(&setup.dynamics);
    all.map(|(value, AgentDynamics { velocity, .. })| Value {
        shown: format!("{:?},{:?}", velocity.x, velocity.y),
        ..value
    })
    .collect()
}

fn materials(setup: &Setup<'_>, of: fn(&Material) -> f64) -> Vec<Value> {
    let one = |material: &Material| value(of(material), format!("material {}", quoted(&material.id)));
    setup.materials.intrinsic.iter().map(one).collect()
}

fn frictions(setup: &Setup<'_>) -> Vec<Value> {
    let one = |contact: &Contact| {
        let of = format!("materials {} and {}", quoted(&contact.id1), quoted(&contact.id2));
        value(contact.kinetic_friction, of)
    };
    setup.materials.binary.iter().map(one).collect()
}

const DEGREE: f64 = PI / 180.0;

/// A modulus of materials.
const fn modulus(attribute: &'static str, values: fn(&Setup<'_>) -> Vec<Value>) -> Usual {
    Usual {
        file: |places| &places.materials,
        element: "Material",
        attribute,
        unit: "N/m",
        range: [1e4, 1e12],
        reason: "people have some 1e6 N/m and concrete some 1e9 N/m",
        typical: 4e6,
        mistaken: &[("MN/m (MPa)", 1e6, Per::One), ("GN/m (GPa)", 1e9, Per::One)],
        values,
    }
}

const USUAL: [Usual; 11] = [
    Usual {
        file: |places| &places.parameters,
        element: "Times",
        attribute: "TimeStep",
        unit: "s",
        range: [1e-5, 1.0],
        reason: "drives are constant and results are written once in a TimeStep; the step of the integration is \
                 TimeStepMechanical",
        typical: 0.05,
        mistaken: &[("ms", 1e-3, Per::One)],
        values: |setup| vec![value(setup.parameters.time_step, String::new())],
    },
    Usual {
        file: |places| &places.agents,
        element: "Agent",
        attribute: "Mass",
        unit: "kg",
        range: [1.0, 1000.0],
        reason: "an infant has 3 kg, and people on a loaded cargo bicycle have 300 kg",
        typical: 75.0,
        mistaken: &[("g", 1e-3, Per::One), ("t", 1e3, Per::One)],
        values: |setup| agents(setup, |agent| (agent.mass, 1.0)),
    },
    Usual {
        file: |places| &places.agents,
        element: "Agent",
        attribute: "MomentOfInertia",
        unit: "kg m²",
        range: [3e-3, 300.0],
        reason: "an infant has 0.01 kg m², an adult 1 to 2 kg m², and a rider with a bicycle some 10 kg m²",
        typical: 1.5,
        mistaken: &[("kg cm²", 1e-4, Per::One), ("kg mm²", 1e-6, Per::One), ("g cm²", 1e-7, Per::One)],
        values: |setup| agents(setup, |agent| (agent.moment_of_inertia, 1.0)),
    },
    Usual {
        file: |places| &places.agents,
        element: "Agent",
        attribute: "FloorDamping",
        unit: "1/s",
        range: [0.0, 50.0],
        reason: "it is 1/t of the time t in which the floor stops people, and this is 0.1 to 1 s",
        typical: 4.5,
        mistaken: &[("kg/s", 1.0, Per::Body)],
        values: |setup| agents(setup, |agent| (agent.floor_damping, agent.mass)),
    },
    Usual {
        file: |places| &places.agents,
        element: "Agent",
        attribute: "AngularDamping",
        unit: "1/s",
        range: [0.0, 50.0],
        reason: "it is 1/t of the time t in which the floor stops people's turn, and this is 0.1 to 1 s",
        typical: 4.5,
        mistaken: &[("kg m²/s", 1.0, Per::Body)],
        values: |setup| agents(setup, |agent| (agent.angular_damping, agent.moment_of_inertia)),
    },
    Usual {
        file: |places| &places.dynamics,
        element: "Kinematics",
        attribute: "Velocity",
        unit: "m/s",
        range: [0.0, 15.0],
        reason: "people walk at 1 to 2 m/s, run at up to 10 m/s and ride bicycles at up to 15 m/s",
        typical: 1.3,
        mistaken: &[("km/h", 1.0 / 3.6, Per::One), ("cm/s", 1e-2, Per::One), ("mm/s", 1e-3, Per::One)],
        values: velocities,
    },
    Usual {
        file: |places| &places.dynamics,
        element: "Kinematics",
        attribute: "Theta",
        unit: "rad",
        range: [0.0, 4.0 * PI],
        reason: "a whole turn is 2π",
        typical: 1.5,
        mistaken: &[("degrees", DEGREE, Per::One)],
        values: |setup| dynamics(setup, |dynamics| dynamics.theta),
    },
    Usual {
        file: |places| &places.dynamics,
        element: "Kinematics",
        attribute: "Omega",
        unit: "rad/s",
        range: [0.0, 40.0],
        reason: "people turn at some rad/s, and the fastest skaters at 35 rad/s",
        typical: 1.0,
        mistaken: &[("degrees/s", DEGREE, Per::One)],
        values: |setup| dynamics(setup, |dynamics| dynamics.omega),
    },
    modulus("YoungModulus", |setup| materials(setup, |material| material.young_modulus)),
    modulus("ShearModulus", |setup| materials(setup, |material| material.shear_modulus)),
    Usual {
        file: |places| &places.materials,
        element: "Contact",
        attribute: "KineticFriction",
        unit: "",
        range: [0.0, 2.0],
        reason: "skin and clothes have 0.2 to 0.6, and rubber on concrete has 1",
        typical: 0.5,
        mistaken: &[("per cent", 1e-2, Per::One)],
        values: frictions,
    },
];

impl Usual {
    fn is_met_by(&self, value: f64) -> bool {
        let [low, high] = self.range;
        value == 0.0 || (low..=high).contains(&value.abs())
    }

    /// The unit in which a value probably is, and the value in the right one.
    fn meant(&self, Value { value, body, .. }: &Value) -> Option<(&'static str, f64)> {
        let far = |value: f64| libm::log(value.abs() / self.typical).abs();
        let all = self
            .mistaken
            .iter()
            .map(|(name, factor, per)| (*name, value * factor / if *per == Per::Body { *body } else { 1.0 }));
        let nearer = all.filter(|(_, meant)| self.is_met_by(*meant) && far(*meant) < far(*value));
        nearer.min_by(|a, b| far(a.1).total_cmp(&far(b.1)))
    }

    fn warning(&self, setup: &Setup<'_>, places: &Places) -> Option<Problem> {
        let mut odd = (self.values)(setup).into_iter().filter(|value| !self.is_met_by(value.value));
        let first = odd.next()?;
        let others = match odd.count() {
            0 => String::new(),
            count => format!(" (and {count} more)"),
        };
        let whose = if first.of.is_empty() { String::new() } else { format!("{}{others}: ", first.of) };
        let with_unit = |number: f64| format!("{} {}", told(number), self.unit).trim_end().to_owned();
        let range = match self.range {
            [0.0, high] => format!("at most {}", with_unit(high)),
            range => range.map(with_unit).join(" to "),
        };
        let ask = match self.meant(&first) {
            Some((unit, value)) => format!("is it in {unit} ({})?", with_unit(value)),
            None => "is it right?".to_owned(),
        };
        Some(Problem {
            severity: Severity::Warning,
            file: (self.file)(places).clone(),
            line: None,
            element: Some(self.element.into()),
            attribute: Some(self.attribute.into()),
            value: Some(first.shown),
            message: format!("{whose}{range} is usual, because {}: {ask}", self.reason),
        })
    }
}

/// With three digits.
fn told(number: f64) -> String {
    let rounded = format!("{number:.2e}").parse().unwrap_or(number);
    if number == 0.0 || (1e-3..1e6).contains(&number.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

impl Setup<'_> {
    /// Returns a warning for each attribute with unusual values.
    pub(super) fn unusual(&self, places: &Places) -> impl Iterator<Item = Problem> {
        USUAL.iter().filter_map(|usual| usual.warning(self, places))
    }
}
