//! Tables of a crowd: its agents as CSV, and its statistics.

use crate::bicycle::BICYCLE_MEASURES;
use crate::person::BodyMeasure;
use crate::population::CrowdMember;
use lemons_core::xml::number;
use serde::Serialize;
use std::collections::BTreeSet;
use std::fmt;

/// Statistics of one measure over some agents.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(rename = "Summary"))]
pub struct MeasureSummary {
    /// Name of the measure.
    pub measure: &'static str,
    /// "m" or "kg".
    pub unit: &'static str,
    /// Mean, in that unit.
    pub mean: f64,
    /// Standard deviation of the sample (divided by count − 1), in that unit; `None` for a single agent.
    pub sd: Option<f64>,
    /// Smallest value, in that unit.
    pub min: f64,
    /// Largest value, in that unit.
    pub max: f64,
}

/// Statistics of one kind of agents.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct KindStatistics {
    /// "male", "female", or the name of a kind.
    pub kind: String,
    /// Number of agents.
    pub count: usize,
    /// Fraction of the whole crowd, 0…1.
    pub proportion: f64,
    /// Statistics of each measure, in the order of [`BodyMeasure::ALL`]; then those of all that a member is, and of its
    /// bicycle, [`BICYCLE_MEASURES`].
    pub measures: Vec<MeasureSummary>,
}

/// Statistics of each kind that a crowd has: men, women, kinds of people in the order of their names.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct CrowdStatistics(pub Vec<KindStatistics>);

impl CrowdStatistics {
    /// Computes the statistics of agents.
    pub fn of(agents: &[CrowdMember]) -> CrowdStatistics {
        let people = BodyMeasure::ALL.map(|measure| (measure.name(), measure.unit()));
        let of_kinds =
            [&people[..], &[("mass of all", "kg"), ("desired speed", "m/s")], &BICYCLE_MEASURES].concat();
        let names: BTreeSet<&str> =
            agents.iter().filter_map(CrowdMember::member).map(|of| &*of.kind.name).collect();
        let all = [("male", &people[..]), ("female", &people[..])].into_iter();
        let all = all.chain(names.into_iter().map(|name| (name, &of_kinds[..])));
        let statistics = all.filter_map(|(kind, names)| {
            let members: Vec<Vec<f64>> =
                agents.iter().map(kind_and_measures).filter(|of| of.0 == kind).map(|of| of.1).collect();
            let column = |place: usize| members.iter().map(|member| member[place]).collect::<Vec<f64>>();
            let measures = names.iter().enumerate().take(members.first().map_or(0, Vec::len));
            let measures = measures.map(|(place, (name, unit))| summary(name, unit, &column(place)));
            let proportion = members.len() as f64 / agents.len() as f64;
            (!members.is_empty()).then(|| KindStatistics {
                kind: kind.to_owned(),
                count: members.len(),
                proportion,
                measures: measures.collect(),
            })
        });
        CrowdStatistics(statistics.collect())
    }
}

fn kind_and_measures(agent: &CrowdMember) -> (&str, Vec<f64>) {
    match agent {
        CrowdMember::Member(member) => {
            let (person, _) = member.people[0];
            let bicycle = member.bicycle.map(|bicycle| bicycle.measures());
            let bicycle = bicycle.as_ref().map_or(&[][..], |measures| &measures[..]);
            (&member.kind.name, [&person.measures()[..], &[member.mass, member.speed], bicycle].concat())
        }
        CrowdMember::Pedestrian(person) => (person.sex.name(), person.measures().to_vec()),
    }
}

/// A readable table, in cm and kg.
impl fmt::Display for CrowdStatistics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, KindStatistics { kind, count, proportion, measures }) in self.0.iter().enumerate() {
            if place > 0 {
                writeln!(f)?;
            }
            write!(f, "{kind}: {count} ({:.1} %)", 100.0 * proportion)?;
            for MeasureSummary { measure, unit, mean, sd, min, max } in measures {
                let (scale, unit) = if *unit == "m" { (100.0, "cm") } else { (1.0, *unit) };
                write!(f, "\n    {measure:<18}{:8.2}", mean * scale)?;
                match sd {
                    Some(sd) => write!(f, " ± {:6.2}", sd * scale)?,
                    None => write!(f, "         ")?,
                }
                write!(f, "  {:8.2} … {:8.2} {unit}", min * scale, max * scale)?;
            }
        }
        Ok(())
    }
}

/// `values` must not be empty.
fn summary(measure: &'static str, unit: &'static str, values: &[f64]) -> MeasureSummary {
    // Relative to the first value, so that equal values have no deviation.
    let count = values.len() as f64;
    let mean = values[0] + values.iter().map(|value| value - values[0]).sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    MeasureSummary {
        measure,
        unit,
        mean,
        sd: (values.len() > 1).then(|| (squares / (count - 1.0)).sqrt()),
        min: values.iter().copied().fold(f64::INFINITY, f64::min),
        max: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    }
}

/// Columns of [`crowd_csv`], without those of kinds.
const COLUMNS: &str = "id,type,sex,bideltoid_breadth_m,chest_depth_m,stature_m,mass_kg,wheel_width_m,length_m,\
                       handlebar_m,top_tube_m";

/// Columns of members of kinds, where there are any.
const OF_KINDS: [&str; 2] = ["mass_of_all_kg", "desired_speed_m_per_s"];

/// Returns the agents as CSV, one per line with its index from 0. Of a member of a kind, the measures are its
/// person's; two more columns have the mass of all and the desired speed. Cells of what somebody has not are empty.
/// Lengths are in m, masses in kg, as the shortest decimals that are read back as the same doubles.
pub fn crowd_csv(agents: &[CrowdMember]) -> String {
    // Writing rows of one length into memory cannot fail, so the results are dropped.
    let mut writer = csv::Writer::from_writer(Vec::new());
    let of_kinds = if agents.iter().any(|agent| agent.member().is_some()) { &OF_KINDS[..] } else { &[] };
    let _ = writer.write_record(COLUMNS.split(',').chain(of_kinds.iter().copied()));
    for (id, agent) in agents.iter().enumerate() {
        let (kind, person) = match agent {
            CrowdMember::Pedestrian(person) => ("pedestrian", person),
            CrowdMember::Member(member) => (&*member.kind.name, &member.people[0].0),
        };
        let row = [id.to_string(), kind.to_owned(), person.sex.name().to_owned()].into_iter();
        let member = agent.member();
        let bicycle = member.and_then(|member| member.bicycle).map(|bicycle| bicycle.measures());
        let bicycle = (0..BICYCLE_MEASURES.len() - 1).map(|place| Some(bicycle?[place]));
        let more = member.map(|member| [member.mass, member.speed]);
        let more = (0..of_kinds.len()).map(|place| Some(more?[place]));
        let numbers = person.measures().map(Some).into_iter().chain(bicycle).chain(more);
        let numbers = numbers.map(|cell| cell.map_or_else(String::new, number));
        let _ = writer.write_record(row.chain(numbers));
    }
    String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bicycle::Bicycle;
    use crate::person::{Person, Sex};

    const MAN: Person = Person { sex: Sex::Male, breadth: 0.5, depth: 0.25, stature: 1.75, mass: 80.0 };

    fn member(kind: &str, bicycle: Option<Bicycle>) -> CrowdMember {
        let kinds = crate::Kinds::built_in().unwrap();
        let member = kinds.get(kind).unwrap().draw(MAN, None, bicycle, &mut crate::random::Random::new(1));
        CrowdMember::Member(Box::new(member))
    }

    fn person(sex: Sex, breadth: f64, mass: f64) -> CrowdMember {
        CrowdMember::Pedestrian(Person { sex, breadth, depth: 0.25, stature: 1.75, mass })
    }

    #[test]
    fn statistics_of_a_small_crowd() {
        let agents = [
            person(Sex::Female, 0.4, 50.0),
            person(Sex::Female, 0.45, 60.0),
            person(Sex::Male, 0.5, 80.0),
            member("bicycle", Some(Bicycle::TEMPLATE)),
        ];
        let statistics = CrowdStatistics::of(&agents);
        let [men, women, bicycles] = &statistics.0[..] else { panic!("{statistics:?}") };
        assert_eq!((men.count, women.count, bicycles.count), (1, 2, 1));
        assert_eq!((men.proportion, women.proportion), (0.25, 0.5));
        let mass = &women.measures[3];
        assert_eq!((mass.mean, mass.min, mass.max), (55.0, 50.0, 60.0));
        assert!((mass.sd.unwrap() - 50.0f64.sqrt()).abs() < 1e-14);
        assert_eq!((men.measures[0].mean, men.measures[0].sd), (0.5, None));
        assert_eq!(women.measures[1].sd, Some(0.0));
        assert_eq!((bicycles.measures[3].mean, bicycles.measures[4].mean), (80.0, 110.0));
        assert_eq!((bicycles.measures[7].measure, bicycles.measures[7].mean), ("length", 1.42));
        let shown = statistics.to_string();
        assert!(
            shown.contains("female: 2 (50.0 %)") && shown.contains("mass                 55.00 ±   7.07"),
            "{shown}"
        );
        assert_eq!(CrowdStatistics::of(&[]), CrowdStatistics::default());
    }

    #[test]
    fn a_kind_has_its_own_row_and_columns() {
        let bicycle = Bicycle::TEMPLATE;
        let agents =
            [person(Sex::Female, 0.4, 50.5), member("suitcase", None), member("bicycle", Some(bicycle))];
        let [(mass, speed), (all, riding)] =
            [1, 2].map(|k| agents[k].member().map(|of| (of.mass, of.speed)).unwrap());
        let text = crowd_csv(&agents);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].ends_with(",top_tube_m,mass_of_all_kg,desired_speed_m_per_s"));
        assert_eq!(lines[1], "0,pedestrian,female,0.4,0.25,1.75,50.5,,,,,,");
        assert_eq!(lines[2], format!("1,suitcase,male,0.5,0.25,1.75,80.0,,,,,{mass},{speed}"));
        assert_eq!(
            lines[3],
            format!("2,bicycle,male,0.5,0.25,1.75,80.0,0.11137,1.42,0.59863,0.68912,{all:?},{riding}")
        );
        let statistics = CrowdStatistics::of(&agents);
        let [women, _, suitcases] = &statistics.0[..] else { panic!("{statistics:?}") };
        assert_eq!((&*women.kind, &*suitcases.kind, suitcases.measures.len()), ("female", "suitcase", 6));
        assert_eq!((suitcases.measures[4].mean, suitcases.measures[5].mean), (mass, speed));
    }

    #[test]
    fn a_crowd_has_a_row_for_each() {
        let expected = "id,type,sex,bideltoid_breadth_m,chest_depth_m,stature_m,mass_kg,wheel_width_m,length_m,\
                        handlebar_m,top_tube_m\n\
                        0,pedestrian,female,0.4,0.25,1.75,50.5,,,,\n";
        assert_eq!(crowd_csv(&[person(Sex::Female, 0.4, 50.5)]), expected);
    }
}
