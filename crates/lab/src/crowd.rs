//! A crowd: how many, of whom, in which room -> a Trial.

use crate::Refused;
use lemons_people::placing::{Dense, Ended, Orientation, Region, Watch, dense, measure, placing_seed, wider};
use lemons_people::{
    Agent, CrowdStatistics, Person, Population, Proportions, Shape, Source, TrialSettings, crowd_trial,
    heading, walls,
};
use lemons_plane::{Vec2, vec2};
use lemons_trial::Trial;
use serde::Deserialize;
use serde_json::{Value, json};

/// Largest number of people: what a page can pack and show.
pub const MOST_PEOPLE: u32 = 5000;

/// Largest seed: the largest integer that a page's numbers hold exactly.
pub const LARGEST_SEED: u64 = (1 << 53) - 1;

/// A crowd.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wanted {
    /// How many; 1 to [`MOST_PEOPLE`].
    pub number: u32,
    /// The same seed gives the same crowd, here and with `lemons crowd`.
    pub seed: u64,
    /// \[m\] Size of the room along x and y; its lower left corner is the origin.
    pub room: [f64; 2],
    /// Probability that a person is a man.
    #[serde(default = "half")]
    pub men: f64,
    /// \[°\] Which way people face at first, -360 to 360; `None`: any.
    pub direction: Option<f64>,
    /// \[m/s\] The speed at which each would walk alone, in this direction.
    #[serde(default)]
    pub speed: f64,
}

fn half() -> f64 {
    0.5
}

/// A crowd that was made.
#[derive(Debug, Clone, PartialEq)]
pub struct Made {
    /// Its Trial.
    pub trial: Trial,
    /// How it was placed, and statistics of its people.
    pub value: Value,
}

/// Draws people and places them without overlap, as `lemons crowd --number --box --seed` does.
///
/// # Errors
/// A number is out of range, there is no room, or `watch` stopped the placing.
pub fn crowd(wanted: &Wanted, watch: &mut Watch) -> Result<Made, Refused> {
    if !(1..=MOST_PEOPLE).contains(&wanted.number) {
        return Err(Refused(format!("{} people: the number must be 1 to {MOST_PEOPLE}", wanted.number)));
    }
    let within = |what: &str, value: f64, [low, high]: [f64; 2]| {
        let inside = (low..=high).contains(&value);
        if inside { Ok(()) } else { Err(Refused(format!("{what} = {value}: must be {low} to {high}"))) }
    };
    within("seed", wanted.seed as f64, [0.0, LARGEST_SEED as f64])?;
    within("direction [°]", wanted.direction.unwrap_or(0.0), [-360.0, 360.0])?;
    within("speed [m/s]", wanted.speed, [0.0, 20.0])?;
    for side in wanted.room {
        within("a side of the room [m]", side, [0.1, 1000.0])?;
    }
    let [width, height] = wanted.room;
    let region = Region::rectangle(Vec2::ZERO, vec2(width, height)).map_err(Refused::of)?;
    let proportions = Proportions { men: wanted.men, ..Proportions::default() };
    let population = Population::new(Source::Ansur, proportions).map_err(Refused::of)?;
    let people: Vec<Person> = population
        .agents(wanted.seed)
        .take(wanted.number as usize)
        .filter_map(|agent| match agent {
            Agent::Pedestrian(person) => Some(person),
            Agent::Bicycle(_) => None,
        })
        .collect();
    let shapes = people.iter().map(Shape::of).collect::<Result<Vec<_>, _>>().map_err(Refused::of)?;
    let orientation =
        wanted.direction.map_or(Orientation::Free, |angle| Orientation::Towards(angle.to_radians()));
    let settings = Dense { orientation, seed: placing_seed(wanted.seed), ..Dense::default() };
    let packing = dense(&wider(&shapes), &region, &settings, watch).map_err(Refused::of)?;
    let largest_overlap = measure(&shapes, &region, &packing.poses).largest_overlap;
    if !packing.complete {
        return Err(Refused(match packing.ended {
            Ended::Cancelled => "the placing was stopped".into(),
            _ => format!(
                "{} people do not fit into {width} m x {height} m without overlap; about {:.1} per m² do",
                wanted.number, packing.clear_density
            ),
        }));
    }
    let settings = TrialSettings {
        desired_velocity: heading(wanted.direction.unwrap_or(0.0)) * wanted.speed,
        ..TrialSettings::default()
    };
    let name = format!("crowd_{}_seed_{}", wanted.number, wanted.seed);
    let geometry = walls(region.rings(), "concrete");
    let trial =
        crowd_trial(&name, &people, &shapes, &packing.poses, geometry, &settings).map_err(Refused::of)?;
    let agents: Vec<Agent> = people.into_iter().map(Agent::Pedestrian).collect();
    let value = json!({
        "density": packing.density, "iterations": packing.iterations,
        "largest_overlap": largest_overlap, "statistics": CrowdStatistics::of(&agents).csv(),
    });
    Ok(Made { trial, value })
}
