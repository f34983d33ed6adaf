//! A crowd: how many, of whom, in which room -> a Trial.

use crate::Refused;
use lemons_people::placing::{Dense, Ended, Orientation, Region, Watch, dense};
use lemons_people::{
    Agent, CrowdStatistics, Person, Population, Proportions, Shape, Source, TrialSettings, crowd_trial, walls,
};
use lemons_plane::{Vec2, vec2};
use lemons_trial::Trial;
use serde::Deserialize;
use serde_json::{Value, json};

/// Largest number of people: what a page can pack and show.
pub const MOST_PEOPLE: u32 = 5000;

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
    /// \[rad\] Which way people face; `None`: any.
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
    let orientation = wanted.direction.map_or(Orientation::Free, Orientation::Towards);
    let settings = Dense { orientation, seed: wanted.seed, ..Dense::default() };
    let packing = dense(&shapes, &region, &settings, watch).map_err(Refused::of)?;
    if !packing.complete {
        return Err(Refused(match packing.ended {
            Ended::Cancelled => "the placing was stopped".into(),
            _ => format!(
                "{} people do not fit into {width} m x {height} m without overlap; about {:.1} per m² do",
                wanted.number, packing.clear_density
            ),
        }));
    }
    let heading = wanted.direction.unwrap_or(0.0);
    let settings = TrialSettings {
        desired_velocity: vec2(wanted.speed, 0.0).rotated(lemons_plane::Rotation::by(heading)),
        ..TrialSettings::default()
    };
    let geometry = walls(region.rings(), "concrete");
    let trial =
        crowd_trial("crowd", &people, &shapes, &packing.poses, geometry, &settings).map_err(Refused::of)?;
    let agents: Vec<Agent> = people.into_iter().map(Agent::Pedestrian).collect();
    let value = json!({
        "density": packing.density, "iterations": packing.iterations,
        "largest_overlap": packing.largest_overlap, "statistics": CrowdStatistics::of(&agents).csv(),
    });
    Ok(Made { trial, value })
}
