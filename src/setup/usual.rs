//! The usual values of attributes, and the units in which others may be by mistake.

use super::Setup;
use super::advice::warning_of_attribute;
use crate::engine::Vec2;
use lemons_core::trial::{
    Agent, AgentDynamics, Contact, DriveTable, FileNames, Material, Problem, Push, quoted,
};
use std::f64::consts::PI;

/// An attribute, its usual values, and why others are not.
struct Usual {
    attribute: &'static str,
    /// Of the values.
    unit: &'static str,
    /// The least and the greatest magnitude, perhaps infinite; zero is usual, too.
    range: [f64; 2],
    reason: &'static str,
    /// One that is met often: of several units, the one that leads nearest to it is asked for.
    typical: f64,
    /// Units of values by mistake, and what one of them is in `unit`.
    mistaken: &'static [(&'static str, f64)],
    values: fn(&Setup<'_>) -> Vec<Value>,
}

/// A value in a file.
struct Value {
    value: f64,
    /// As it is written.
    shown: String,
    of: String,
    /// \[kg\] or \[kg m²\] Mass or moment of inertia by which one in another unit is divided; else 1.
    body: f64,
}

fn value(value: f64, of: String) -> Value {
    Value { value, shown: format!("{value:?}"), of, body: 1.0 }
}

fn vector(vector: Vec2, of: String) -> Value {
    Value { shown: format!("{:?},{:?}", vector.x, vector.y), ..value(vector.norm(), of) }
}

/// Returns values of each agent, made with what the agent is called.
fn agents<I: IntoIterator<Item = Value>>(
    setup: &Setup<'_>,
    of: fn(&Agent, &AgentDynamics, String) -> I,
) -> Vec<Value> {
    let all = setup.agents.iter().zip(&setup.dynamics);
    all.flat_map(|(agent, dynamics)| of(agent, dynamics, format!("agent {}", quoted(&agent.id)))).collect()
}

fn materials(setup: &Setup<'_>, of: fn(&Material) -> f64) -> Vec<Value> {
    let one = |material: &Material| value(of(material), format!("material {}", quoted(&material.id)));
    setup.materials.intrinsic.iter().map(one).collect()
}

fn contacts(setup: &Setup<'_>, of: fn(&Contact) -> f64) -> Vec<Value> {
    let one = |contact: &Contact| {
        let whose = format!("materials {} and {}", quoted(&contact.id1), quoted(&contact.id2));
        value(of(contact), whose)
    };
    setup.materials.binary.iter().map(one).collect()
}

const DEGREE: f64 = PI / 180.0;

/// A modulus of materials.
const fn modulus(attribute: &'static str, values: fn(&Setup<'_>) -> Vec<Value>) -> Usual {
    Usual {
        attribute,
        unit: "N/m",
        range: [1e4, 1e12],
        reason: "people have some 1e6 N/m and concrete some 1e9 N/m",
        typical: 4e6,
        mistaken: &[("MN/m or MPa", 1e6), ("GN/m or GPa", 1e9)],
        values,
    }
}

/// A damping of contacts. Too much of it is found by comparison with the critical one.
const fn damping(attribute: &'static str, values: fn(&Setup<'_>) -> Vec<Value>) -> Usual {
    Usual {
        attribute,
        unit: "kg/s",
        range: [1.0, f64::INFINITY],
        reason: "people have some 1000 kg/s, and the critical damping is some 10000 kg/s",
        typical: 1000.0,
        mistaken: &[("t/s", 1e3), ("MN s/m", 1e6)],
        values,
    }
}

const FORCE: Usual = Usual {
    attribute: "Fp",
    unit: "N",
    range: [0.0, 3e4],
    reason: "walking takes Mass · FloorDamping · speed, some 500 N, and a strong push is 2000 N",
    typical: 500.0,
    mistaken: &[("mN", 1e-3)],
    values: |setup| agents(setup, |_, dynamics, of| [vector(dynamics.fp, of)]),
};

const TORQUE: Usual = Usual {
    attribute: "Mp",
    unit: "N m",
    range: [0.0, 2000.0],
    reason: "people turn with some 10 N m, and a rider with a bicycle with some 100 N m",
    typical: 10.0,
    mistaken: &[("N cm", 1e-2), ("N mm", 1e-3)],
    values: |setup| agents(setup, |_, dynamics, of| [value(dynamics.mp, of)]),
};

/// The shortest time between two rows of a drive file with different pushes.
const PACE: Usual = Usual {
    attribute: "t",
    unit: "s",
    range: [0.0, 30.0],
    reason: "people begin and end a push within seconds",
    typical: 0.1,
    mistaken: &[("ms", 1e-3)],
    values: |_| Vec::new(),
};

/// The last row of a drive file.
const LAST: Usual = Usual { range: [0.0, 3600.0], reason: "hardly a run is longer", ..PACE };

const USUAL: [Usual; 17] = [
    Usual {
        attribute: "TimeStep",
        unit: "s",
        range: [1e-5, 1.0],
        reason: "drives are constant and results are written once in a TimeStep; the step of the integration is \
                 TimeStepMechanical",
        typical: 0.05,
        mistaken: &[("ms", 1e-3)],
        values: |setup| vec![value(setup.parameters.time_step, String::new())],
    },
    Usual {
        attribute: "Mass",
        unit: "kg",
        range: [1.0, 1000.0],
        reason: "an infant has 3 kg, and people on a loaded cargo bicycle have 300 kg",
        typical: 75.0,
        mistaken: &[("g", 1e-3), ("t", 1e3)],
        values: |setup| agents(setup, |agent, _, of| [value(agent.mass, of)]),
    },
    Usual {
        attribute: "Height",
        unit: "m",
        range: [0.3, 2.8],
        reason: "an infant is 0.5 m tall, and the tallest person was 2.72 m tall",
        typical: 1.7,
        mistaken: &[("cm", 1e-2), ("mm", 1e-3), ("inches", 0.0254)],
        values: |setup| agents(setup, |agent, _, of| agent.height.map(|height| value(height, of))),
    },
    Usual {
        attribute: "Radius",
        unit: "m",
        // Too large ones make a body too wide, which is found with their Positions.
        range: [0.015, f64::INFINITY],
        reason: "the disks of an adult have 0.08 to 0.14 m",
        typical: 0.1,
        mistaken: &[],
        values: |setup| {
            agents(setup, |agent, _, of| {
                let radii = agent.shapes.iter().map(|shape| value(shape.radius, of.clone()));
                radii.collect::<Vec<_>>()
            })
        },
    },
    Usual {
        attribute: "MomentOfInertia",
        unit: "kg m²",
        range: [3e-3, 300.0],
        reason: "an infant has 0.01 kg m², an adult 1 to 2 kg m², and a rider with a bicycle some 10 kg m²",
        typical: 1.5,
        mistaken: &[("kg cm²", 1e-4), ("kg mm²", 1e-6), ("g cm²", 1e-7)],
        values: |setup| agents(setup, |agent, _, of| [value(agent.moment_of_inertia, of)]),
    },
    Usual {
        attribute: "FloorDamping",
        unit: "1/s",
        range: [0.0, 50.0],
        reason: "it is 1/t of the time t in which the floor stops people, and this is 0.1 to 1 s",
        typical: 4.5,
        mistaken: &[("kg/s", 1.0)],
        values: |setup| {
            agents(setup, |agent, _, of| [Value { body: agent.mass, ..value(agent.floor_damping, of) }])
        },
    },
    Usual {
        attribute: "AngularDamping",
        unit: "1/s",
        range: [0.0, 50.0],
        reason: "it is 1/t of the time t in which the floor stops people's turn, and this is 0.1 to 1 s",
        typical: 4.5,
        mistaken: &[("kg m²/s", 1.0)],
        values: |setup| {
            agents(setup, |agent, _, of| {
                [Value { body: agent.moment_of_inertia, ..value(agent.angular_damping, of) }]
            })
        },
    },
    Usual {
        attribute: "Velocity",
        unit: "m/s",
        range: [0.0, 15.0],
        reason: "people walk at 1 to 2 m/s, run at up to 10 m/s and ride bicycles at up to 15 m/s",
        typical: 1.3,
        mistaken: &[("km/h", 1.0 / 3.6), ("cm/s", 1e-2), ("mm/s", 1e-3)],
        values: |setup| agents(setup, |_, dynamics, of| [vector(dynamics.velocity, of)]),
    },
    Usual {
        attribute: "Theta",
        unit: "rad",
        range: [0.0, 4.0 * PI],
        reason: "these are two whole turns",
        typical: 1.5,
        mistaken: &[("degrees", DEGREE)],
        values: |setup| agents(setup, |_, dynamics, of| [value(dynamics.theta, of)]),
    },
    Usual {
        attribute: "Omega",
        unit: "rad/s",
        range: [0.0, 40.0],
        reason: "people turn at some rad/s, and the fastest skaters at 35 rad/s",
        typical: 1.0,
        mistaken: &[("degrees/s", DEGREE)],
        values: |setup| agents(setup, |_, dynamics, of| [value(dynamics.omega, of)]),
    },
    FORCE,
    TORQUE,
    modulus("YoungModulus", |setup| materials(setup, |material| material.young_modulus)),
    modulus("ShearModulus", |setup| materials(setup, |material| material.shear_modulus)),
    Usual {
        attribute: "KineticFriction",
        unit: "",
        range: [0.0, 2.0],
        reason: "skin and clothes have 0.2 to 0.6, and rubber on concrete has 1",
        typical: 0.5,
        mistaken: &[("per cent", 1e-2)],
        values: |setup| contacts(setup, |contact| contact.kinetic_friction),
    },
    damping("GammaNormal", |setup| contacts(setup, |contact| contact.gamma_normal)),
    damping("GammaTangential", |setup| contacts(setup, |contact| contact.gamma_tangential)),
];

impl Usual {
    fn is_met_by(&self, value: f64) -> bool {
        let [low, high] = self.range;
        value == 0.0 || (low..=high).contains(&value.abs())
    }

    /// Returns the unit in which a value probably is, and the value in the right one.
    fn meant(&self, Value { value, body, .. }: &Value) -> Option<(&'static str, f64)> {
        let far = |value: f64| libm::log(value.abs() / self.typical).abs();
        let all = self.mistaken.iter().map(|(name, factor)| (*name, value * factor / body));
        let nearer = all.filter(|(_, meant)| self.is_met_by(*meant) && far(*meant) < far(*value));
        nearer.min_by(|a, b| far(a.1).total_cmp(&far(b.1)))
    }

    /// Returns the first unusual value, as it is written, and what is said of it.
    fn doubt(&self, values: Vec<Value>) -> Option<(String, String)> {
        let mut odd = values.into_iter().filter(|value| !self.is_met_by(value.value));
        let first = odd.next()?;
        let others = match odd.count() {
            0 => String::new(),
            count => format!(" (and {count} more)"),
        };
        let whose = if first.of.is_empty() { String::new() } else { format!("{}{others}: ", first.of) };
        let with_unit = |number: f64| format!("{} {}", told(number), self.unit).trim_end().to_owned();
        let range = match self.range {
            [0.0, high] => format!("at most {}", with_unit(high)),
            [low, f64::INFINITY] => format!("at least {}", with_unit(low)),
            range => range.map(with_unit).join(" to "),
        };
        let ask = match self.meant(&first) {
            Some((unit, value)) => format!("is it in {unit} ({})?", with_unit(value)),
            None => "is it right?".to_owned(),
        };
        Some((first.shown, format!("{whose}{range} is usual, because {}: {ask}", self.reason)))
    }
}

/// Writes a number with three digits.
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
    pub(super) fn unusual(&self, places: &FileNames) -> impl Iterator<Item = Problem> {
        USUAL.iter().filter_map(|usual| {
            let (value, message) = usual.doubt((usual.values)(self))?;
            Some(warning_of_attribute(places, usual.attribute, value, message))
        })
    }
}

/// Returns what is unusual in a drive file: forces, torques and times that are probably in other units.
pub fn doubts_of_drive(drive: &DriveTable) -> Vec<String> {
    let mut ids: Vec<&str> = drive.agents().collect();
    ids.sort_unstable();
    let agents: Vec<(String, &[(f64, Push)])> =
        ids.into_iter().filter_map(|id| Some((format!("agent {}", quoted(id)), drive.rows(id)?))).collect();
    let pushes = || agents.iter().flat_map(|(of, rows)| rows.iter().map(move |(_, push)| (of.clone(), push)));
    let forces = pushes().map(|(of, [x, y, _])| vector(Vec2 { x: *x, y: *y }, of));
    let torques = pushes().map(|(of, [_, _, torque])| value(*torque, of));
    let changes = agents.iter().flat_map(|(of, rows)| {
        let changes = rows.windows(2).filter(|rows| rows[0].1 != rows[1].1);
        changes.map(move |rows| {
            let (from, to) = (rows[0].0, rows[1].0);
            let within = format!("{of}, whose push changes in the {:?} s after t={from:?}", to - from);
            Value { shown: format!("{to:?}"), ..value(to - from, within) }
        })
    });
    let quickest = changes.min_by(|a, b| a.value.total_cmp(&b.value));
    let last = drive.end().map(|end| value(end, "last row".into()));
    let all = [
        (&FORCE, forces.collect()),
        (&TORQUE, torques.collect()),
        (&PACE, quickest.into_iter().collect()),
        (&LAST, last.into_iter().collect()),
    ];
    let doubts = all.into_iter().filter_map(|(usual, values): (&Usual, Vec<Value>)| {
        let (shown, message) = usual.doubt(values)?;
        Some(format!("{}=\"{shown}\": {message}", usual.attribute))
    });
    doubts.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drives_in_other_units_are_doubted() {
        let said = |rows: &str| {
            let text = format!("t,agent,Fp.x,Fp.y,Mp\n{rows}");
            doubts_of_drive(&DriveTable::from_csv(text.as_bytes()).unwrap())
        };
        // Somebody who pushes for ten minutes.
        assert_eq!(said("0,a,0,0,0\n0.3,a,600,-100,9\n0.6,a,0,0,0\n1,b,50,0,0\n600,b,50,0,0\n"), [""; 0]);
        for (rows, words) in [
            (
                "0,a,0,0,0\n0.3,a,0,-1e6,0\n0.6,a,0,0,0\n",
                "Fp=\"0.0,-1000000.0\": agent \"a\": at most 30000 N is usual, because walking takes Mass · FloorDamping · speed, some 500 N, and a strong push is 2000 N: is it in mN (1000 N)?",
            ),
            ("0,a,0,0,0\n0.3,a,0,0,9000\n", "Mp=\"9000.0\": agent \"a\": at most 2000 N m is usual"),
            (
                "0,a,0,0,0\n300,a,600,0,0\n600,a,0,0,0\n",
                "t=\"300.0\": agent \"a\", whose push changes in the 300.0 s after t=0.0: at most 30 s is usual, because people begin and end a push within seconds: is it in ms (0.3 s)?",
            ),
            (
                "0,a,0,0,0\n10,a,600,0,0\n5000,a,0,0,0\n",
                "t=\"5000.0\": last row: at most 3600 s is usual, because hardly a run is longer: is it in ms (5 s)?",
            ),
        ] {
            let said = said(rows);
            assert!(said.len() == 1 && said[0].starts_with(words), "{said:?}");
        }
    }
}
