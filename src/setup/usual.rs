//! The usual values of attributes, and the units in which others may be by mistake.

use super::Setup;
use super::advice::of_attribute;
use crate::engine::{Vec2, vec2};
use lemons_core::message::{Message, message};
use lemons_core::rule::sentences::*;
use lemons_core::trial::{
    Agent, AgentDynamics, ContactCoefficients, DriveTable, DriveValues, EVER, FileNames, Material, Problem,
    Rule,
};

/// The rows of `usual.txt`: for each attribute its usual values, and why others are not.
fn table() -> impl Iterator<Item = Usual> {
    include_str!("usual.txt").lines().filter_map(|line| Usual::read(line.trim()))
}

/// A row of `usual.txt`.
struct Usual {
    attribute: &'static str,
    /// Unit of the values.
    unit: &'static str,
    /// The least and the greatest magnitude, perhaps infinite; zero is usual, too.
    range: [f64; 2],
    /// A value that is met often.
    typical: f64,
    /// Units of values by mistake, and what one of them is in `unit`.
    mistaken: Vec<(&'static str, f64)>,
    reason: &'static str,
}

/// A value in a file.
#[derive(Clone)]
struct Value {
    value: f64,
    /// The value as it is written.
    shown: String,
    /// Name of what has it; `None`: the only one.
    of: Option<Message>,
    /// \[kg\] or \[kg m²\] Mass or moment of inertia by which one in another unit is divided; else 1.
    body: f64,
}

fn value(value: f64, of: Message) -> Value {
    Value { value, shown: format!("{value:?}"), of: Some(of), body: 1.0 }
}

fn vector(vector: Vec2, of: Message) -> Value {
    Value { shown: format!("{:?},{:?}", vector.x, vector.y), ..value(vector.norm(), of) }
}

impl Usual {
    /// Returns `None` for a comment.
    fn read(line: &'static str) -> Option<Usual> {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let [attribute, unit, least, greatest, typical, mistaken, reason] = cells[..] else { return None };
        let number = |text: &str| text.trim().parse().ok();
        let mistaken = mistaken.split(';').filter_map(|one| one.split_once('='));
        let mistaken: Option<Vec<_>> =
            mistaken.map(|(unit, factor)| Some((unit.trim(), number(factor)?))).collect();
        let range = [number(least)?, number(greatest)?];
        let (typical, mistaken) = (number(typical)?, mistaken?);
        Some(Usual { attribute, unit, range, typical, mistaken, reason })
    }

    /// Returns the values of the attribute in a Trial.
    fn values(&self, setup: &Setup<'_>) -> Vec<Value> {
        let agents = |of: &dyn Fn(&Agent, &AgentDynamics, Message) -> Value| {
            let all = setup.agents.iter().zip(&setup.dynamics);
            all.map(|(agent, dynamics)| of(agent, dynamics, message!(OF_AGENT, agent = &agent.id))).collect()
        };
        let contacts = |of: fn(&ContactCoefficients) -> f64| {
            let named = |ContactCoefficients { id1, id2, .. }: &ContactCoefficients| {
                message!(OF_MATERIALS, one = id1, other = id2)
            };
            setup.materials.binary.iter().map(|contact| value(of(contact), named(contact))).collect()
        };
        let materials = |of: fn(&Material) -> f64| {
            let named = |material: &Material| message!(OF_MATERIAL, material = &material.id);
            let all = setup.materials.intrinsic.iter();
            all.map(|material| value(of(material), named(material))).collect()
        };
        match self.attribute {
            "TimeStep" => vec![Value { of: None, ..value(setup.parameters.time_step, Message::default()) }],
            "Mass" => agents(&|agent, _, of| value(agent.mass, of)),
            // An attribute that is not there is usual.
            "Height" => agents(&|agent, _, of| value(agent.height.unwrap_or(0.0), of)),
            "Radius" => {
                let all = setup.agents.iter().flat_map(|agent| {
                    agent
                        .shapes
                        .iter()
                        .map(|shape| value(shape.radius, message!(OF_AGENT, agent = &agent.id)))
                });
                all.collect()
            }
            "MomentOfInertia" => agents(&|agent, _, of| value(agent.moment_of_inertia, of)),
            "FloorDamping" => {
                agents(&|agent, _, of| Value { body: agent.mass, ..value(agent.floor_damping, of) })
            }
            // An attribute that is not there is usual.
            "FloorDampingAcross" => agents(&|agent, _, of| Value {
                body: agent.mass,
                ..value(agent.floor_damping_across.unwrap_or(0.0), of)
            }),
            "AngularDamping" => agents(&|agent, _, of| Value {
                body: agent.moment_of_inertia,
                ..value(agent.angular_damping, of)
            }),
            "Velocity" => agents(&|_, dynamics, of| vector(dynamics.velocity, of)),
            "Theta" => agents(&|_, dynamics, of| value(dynamics.theta, of)),
            "Omega" => agents(&|_, dynamics, of| value(dynamics.omega, of)),
            "Fp" => agents(&|_, dynamics, of| vector(dynamics.fp, of)),
            "Mp" => agents(&|_, dynamics, of| value(dynamics.mp, of)),
            "YoungModulus" => materials(|material| material.young_modulus),
            "ShearModulus" => materials(|material| material.shear_modulus),
            "KineticFriction" => contacts(|contact| contact.kinetic_friction),
            "GammaNormal" => contacts(|contact| contact.gamma_normal),
            "GammaTangential" => contacts(|contact| contact.gamma_tangential),
            _ => Vec::new(),
        }
    }

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
    fn doubt(&self, values: Vec<Value>) -> Option<(String, Message)> {
        let mut odd = values.into_iter().filter(|value| !self.is_met_by(value.value));
        let first = odd.next()?;
        let others = Some(odd.count()).filter(|count| *count > 0).map(|count| message!(AND_MORE, count));
        let whose = first.of.as_ref().map(|of| message!(WHOSE, of, others));
        let with_unit = |number: f64| format!("{} {}", told(number), self.unit).trim_end().to_owned();
        let range = match self.range {
            [0.0, high] => message!(AT_MOST, high = with_unit(high)),
            [low, f64::INFINITY] => message!(AT_LEAST, low = with_unit(low)),
            [low, high] => message!(FROM_TO, low = with_unit(low), high = with_unit(high)),
        };
        let ask = match self.meant(&first) {
            Some((unit, value)) => message!(IN_UNIT, unit, value = with_unit(value)),
            None => message!(IS_RIGHT),
        };
        let reason = Message { id: self.reason_id().into(), ..self.reason.into() };
        Some((first.shown, message!(UNUSUAL, whose, range, reason, ask)))
    }

    fn reason_id(&self) -> String {
        format!("usual.{}", self.attribute)
    }
}

/// Returns why values are usual: an id for each attribute, and the text.
pub fn reasons() -> impl Iterator<Item = (String, &'static str)> {
    table().map(|usual| (usual.reason_id(), usual.reason))
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
        table().filter_map(|usual| {
            let (value, message) = usual.doubt(usual.values(self))?;
            Some(of_attribute(Rule::Unusual, places, usual.attribute, value, message))
        })
    }
}

/// Returns what is unusual in a drive file: forces, torques and times that are probably in other units.
pub fn doubts_of_drive(drive: &DriveTable) -> Vec<Message> {
    let mut ids: Vec<&str> = drive.agents().collect();
    ids.sort_unstable();
    let agents: Vec<(&str, &[(f64, DriveValues)])> =
        ids.into_iter().filter_map(|id| Some((id, drive.rows(id)?))).collect();
    let pushes = || {
        let rows = agents.iter().flat_map(|(agent, rows)| rows.iter().map(move |(_, push)| (agent, push)));
        rows.map(|(agent, push)| (message!(OF_AGENT, agent), push))
    };
    let changes = agents.iter().flat_map(|(agent, rows)| {
        let changes = rows.windows(2).filter(|rows| rows[0].1 != rows[1].1);
        changes.map(move |rows| {
            let (from, to) = (rows[0].0, rows[1].0);
            let of = message!(OF_CHANGE, agent, within = to - from, from);
            Value { shown: format!("{to:?}"), ..value(to - from, of) }
        })
    });
    let ends = agents.iter().filter_map(|(_, rows)| Some(rows.iter().rfind(|(time, _)| *time != EVER)?.0));
    let end = ends.max_by(f64::total_cmp);
    let quickest = changes.min_by(|a, b| a.value.total_cmp(&b.value));
    let doubts = table().filter_map(|usual| {
        let (column, values) = match usual.attribute {
            "Fp" => ("Fp", pushes().map(|(of, [x, y, _])| vector(vec2(*x, *y), of)).collect()),
            "Mp" => ("Mp", pushes().map(|(of, [_, _, torque])| value(*torque, of)).collect()),
            "change" => ("t", quickest.iter().cloned().collect()),
            "end" => ("t", end.map(|end| value(end, message!(OF_LAST_ROW))).into_iter().collect()),
            _ => return None,
        };
        let (value, doubt) = usual.doubt(values)?;
        Some(message!(UNUSUAL_IN_DRIVE, column, value, doubt))
    });
    doubts.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_of_the_table_is_read() {
        let rows = include_str!("usual.txt").lines().filter(|line| !line.starts_with('#'));
        assert_eq!(table().count(), rows.count());
    }

    #[test]
    fn drives_in_other_units_are_doubted() {
        let messages = |rows: &str| {
            let text = format!("t,agent,Fp.x,Fp.y,Mp\n{rows}");
            let found = doubts_of_drive(&DriveTable::from_csv(text.as_bytes()).unwrap());
            found.iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        // Somebody who pushes for ten minutes.
        assert_eq!(messages("0,a,0,0,0\n0.3,a,600,-100,9\n0.6,a,0,0,0\n1,b,50,0,0\n600,b,50,0,0\n"), [""; 0]);
        // As our pulses end.
        assert_eq!(messages("0,a,0,0,0\n0.3,a,600,0,0\n0.6,a,0,0,0\n1e6,a,0,0,0\n"), [""; 0]);
        // The same beside what drives them always.
        assert_eq!(messages("0,a,5,0,0\n0.3,a,600,0,0\n0.6,a,5,0,0\n1e6,a,5,0,0\n"), [""; 0]);
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
            let messages = messages(rows);
            assert!(messages.len() == 1 && messages[0].starts_with(words), "{messages:?}");
        }
    }
}
