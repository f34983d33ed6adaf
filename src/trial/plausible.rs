//! What is possible in a Trial but hardly meant: sizes a hundred times too large or small, steps of a minute, somebody
//! who stands outside.

use super::Trial;
use super::problem::quoted;
use crate::engine::{Scene, Vec2};

/// \[m\] From the centre of mass of a person or a bicycle to its rim, at least and at most.
const RIM: [f64; 2] = [0.02, 3.0];
/// \[m\] A hall so wide and long ...
const LARGE_HALL: f64 = 50.0;
/// \[1/m²\] ... in which so few people stand may be meant in centimetres: a hundredth along both sides would be 10 per m².
const FEW_PEOPLE: f64 = 1e-3;
/// \[s\] A drive is held, and results are written, once in a TimeStep.
const TIME_STEP: [f64; 2] = [1e-5, 2.0];
/// Mechanical steps in a TimeStep: some seconds for each agent.
const MANY_STEPS: f64 = 1e8;
/// \[m\] Somebody just outside of a room may be about to enter.
const OUTSIDE: f64 = 2.0;
/// \[m\] From anybody else and any wall.
const FAR_AWAY: f64 = 1000.0;
/// Directions in which it is looked for walls, and in how many of them those in a room see one: it may have doors.
const DIRECTIONS: u32 = 32;
const ENCLOSED: u32 = 24;
/// Of so many people it is looked whether they are in a room.
const SAMPLE: usize = 50;

/// Of which file, and what.
pub(super) enum Doubt {
    Parameters(&'static str, f64, String),
    Agents(String),
    Geometry(String),
    Dynamics(String),
}

impl Trial {
    /// All that is doubted.
    pub(super) fn doubts(&self, scene: &Scene) -> Vec<Doubt> {
        let mut doubts = self.doubts_of_steps();
        doubts.extend(self.doubts_of_bodies(scene));
        doubts.extend(self.doubts_of_walls(scene));
        doubts.extend(self.doubts_of_places(scene));
        doubts
    }

    fn doubts_of_steps(&self) -> Vec<Doubt> {
        let (step, mechanical) = (self.parameters.time_step, self.parameters.time_step_mechanical);
        let mut doubts = Vec::new();
        let [short, long] = TIME_STEP;
        if step > long {
            let message = format!(
                "is long: people are pushed the same way during all of it, and results are written once in it; usual are \
                 0.01 to 1 s, and TimeStepMechanical is the step of the integration ({mechanical:?} s)"
            );
            doubts.push(Doubt::Parameters("TimeStep", step, message));
        } else if step < short {
            let message = "is short: results are written at each; usual are 0.01 to 1 s".to_owned();
            doubts.push(Doubt::Parameters("TimeStep", step, message));
        }
        let steps = step / mechanical;
        if steps > MANY_STEPS {
            let message = format!("is short: each TimeStep of {step:?} s takes {steps:.1e} mechanical steps");
            doubts.push(Doubt::Parameters("TimeStepMechanical", mechanical, message));
        }
        doubts
    }

    fn doubts_of_bodies(&self, scene: &Scene) -> Option<Doubt> {
        let [small, large] = RIM;
        let doubted = |rim: f64| rim < small || rim > large;
        let mut odd = scene.bodies.iter().enumerate().filter(|(_, body)| doubted(body.bounding_radius));
        let (b, body) = odd.next()?;
        let others = match odd.count() {
            0 => String::new(),
            count => format!(" ({} agents are so)", count + 1),
        };
        let (id, width) = (quoted(&self.agents[b].id), 2.0 * body.bounding_radius);
        Some(Doubt::Agents(format!(
            "agent {id} is {width:.3} m wide{others}: are Radius and Position of its shapes in metres?"
        )))
    }

    fn doubts_of_walls(&self, scene: &Scene) -> Option<Doubt> {
        let (low, high) = box_of(scene.corners.iter().map(|corner| corner.position))?;
        let size = high - low;
        let agents = scene.bodies.len() as f64;
        let widest = scene.bodies.iter().map(|body| 2.0 * body.bounding_radius).fold(0.0, f64::max);
        let spans = format!("the walls span {:.3} m × {:.3} m", size.x, size.y);
        let message = if size.x.max(size.y) < widest {
            format!("{spans}, less than an agent: are their Coordinates in metres?")
        } else if size.x.min(size.y) > LARGE_HALL && agents < FEW_PEOPLE * size.x * size.y {
            let noun = if agents == 1.0 { "agent" } else { "agents" };
            format!("{spans} around {agents} {noun}: are their Coordinates in metres?")
        } else {
            return None;
        };
        Some(Doubt::Geometry(message))
    }

    fn doubts_of_places(&self, scene: &Scene) -> Option<Doubt> {
        let places: Vec<Vec2> = self.dynamics.iter().map(|dynamics| dynamics.position).collect();
        let hull = hull_of(scene.corners.iter().map(|corner| corner.position).collect());
        let name = |b: usize| quoted(&self.agents[b].id);
        // Far from what is in the middle, whatever walls there are.
        let middle = middle_of(&places)?;
        let lost = (0..places.len()).find(|&b| {
            (places[b] - middle).norm() > FAR_AWAY
                && beyond(&hull, places[b]).is_none_or(|far| far > FAR_AWAY)
        });
        if let Some(b) = lost {
            let away = (places[b] - middle).norm();
            return Some(Doubt::Dynamics(format!(
                "agent {} stands {away:.0} m away from the others: is its Position in metres?",
                name(b)
            )));
        }
        let outside: Vec<usize> = (0..places.len())
            .filter(|&b| beyond(&hull, places[b]).is_some_and(|far| far > OUTSIDE))
            .collect();
        let inside = places.len() - outside.len();
        // Where most are outside, or nobody is in a room, outside is where they are meant to be.
        if outside.is_empty() || 2 * outside.len() > places.len() || outside.len() == places.len() {
            return None;
        }
        let insiders = (0..places.len()).filter(|b| outside.binary_search(b).is_err());
        let sample: Vec<usize> = insiders.step_by(inside.div_ceil(SAMPLE)).collect();
        let enclosed = sample.iter().filter(|&&b| is_enclosed(scene, places[b])).count();
        if 2 * enclosed <= sample.len() {
            return None;
        }
        let who = match outside.len() {
            1 => format!("agent {} stands", name(outside[0])),
            count => format!("{count} agents stand (first {})", name(outside[0])),
        };
        Some(Doubt::Dynamics(format!(
            "{who} outside of all walls, which the others are within: is it meant so?"
        )))
    }
}

/// The lowest and highest coordinates.
fn box_of(mut points: impl Iterator<Item = Vec2>) -> Option<(Vec2, Vec2)> {
    let first = points.next()?;
    Some(points.fold((first, first), |(low, high), point| {
        let lower = Vec2 { x: low.x.min(point.x), y: low.y.min(point.y) };
        (lower, Vec2 { x: high.x.max(point.x), y: high.y.max(point.y) })
    }))
}

/// The median of each coordinate.
fn middle_of(places: &[Vec2]) -> Option<Vec2> {
    let median = |coordinate: fn(&Vec2) -> f64| {
        let mut values: Vec<f64> = places.iter().map(coordinate).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied()
    };
    Some(Vec2 { x: median(|place| place.x)?, y: median(|place| place.y)? })
}

/// The convex hull, counter-clockwise.
fn hull_of(mut points: Vec<Vec2>) -> Vec<Vec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let half = |points: &mut dyn Iterator<Item = Vec2>| {
        let mut hull: Vec<Vec2> = Vec::new();
        for point in points {
            while let [.., before, last] = hull[..] {
                if (last - before).cross(point - last) > 0.0 {
                    break;
                }
                hull.pop();
            }
            hull.push(point);
        }
        hull.pop();
        hull
    };
    let mut hull = half(&mut points.iter().copied());
    hull.extend(half(&mut points.iter().rev().copied()));
    hull
}

/// \[m\] How far a place is from a convex hull; `None` without one, 0 within it.
fn beyond(hull: &[Vec2], place: Vec2) -> Option<f64> {
    let last = *hull.last()?;
    let edges = || std::iter::once(last).chain(hull.iter().copied()).zip(hull.iter().copied());
    if hull.len() > 2 && edges().all(|(from, to)| (to - from).cross(place - from) >= 0.0) {
        return Some(0.0);
    }
    let to_edge = |(from, to): (Vec2, Vec2)| {
        let along = to - from;
        let length = along.norm_squared();
        let share = if length > 0.0 { ((place - from).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
        (place - (from + along * share)).norm()
    };
    edges().map(to_edge).reduce(f64::min)
}

/// Whether walls are seen in most directions.
fn is_enclosed(scene: &Scene, place: Vec2) -> bool {
    let sees = |direction: &u32| {
        let angle = std::f64::consts::TAU * (f64::from(*direction) + 0.5) / f64::from(DIRECTIONS);
        let towards = Vec2 { x: libm::cos(angle), y: libm::sin(angle) };
        scene.faces.iter().any(|face| {
            let (from, to) = (face.start - place, face.end - place);
            let (a, b) = (towards.cross(from), towards.cross(to));
            // One end on either side of the line of sight, the crossing before the eyes.
            (a > 0.0) != (b > 0.0) && (from * b - to * a).dot(towards) * (b - a) > 0.0
        })
    };
    (0..DIRECTIONS).filter(sees).count() as u32 >= ENCLOSED
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::vec2;
    use std::path::Path;

    /// The paper's five in a room of 6 m × 4 m with a door of 1.2 m in its right wall.
    fn room() -> Trial {
        let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("resources/Trial_push");
        let mut trial = Trial::read(&directory).expect("the default Trial is in order").0;
        trial.geometry.walls.truncate(1);
        trial.geometry.walls[0].corners =
            [(6.0, 2.6), (6.0, 4.0), (0.0, 4.0), (0.0, 0.0), (6.0, 0.0), (6.0, 1.4)]
                .map(|(x, y)| vec2(x, y))
                .to_vec();
        for (k, dynamics) in trial.dynamics.iter_mut().enumerate() {
            dynamics.position = vec2(0.8 + k as f64, 2.0);
        }
        trial
    }

    fn said(trial: &Trial) -> Vec<String> {
        trial.advice_as_edited()
    }

    fn says(trial: &Trial, words: &str) {
        let said = said(trial);
        assert!(said.len() == 1 && said[0].contains(words), "{said:?}");
    }

    #[test]
    fn nothing_is_doubted_of_a_room_with_a_door() {
        let mut trial = room();
        assert_eq!(said(&trial), [""; 0]);
        // In the door, and just through it.
        trial.dynamics[4].position = vec2(6.0, 2.0);
        assert_eq!(said(&trial), [""; 0]);
        trial.dynamics[4].position = vec2(7.5, 2.0);
        assert_eq!(said(&trial), [""; 0]);
    }

    #[test]
    fn an_agent_outside_of_all_walls_is_named() {
        let mut trial = room();
        trial.dynamics[3].position = vec2(3.8, -7.0);
        says(&trial, "agent \"3\" stands outside of all walls, which the others are within");
        trial.dynamics[1].position = vec2(13.8, 2.0);
        says(&trial, "2 agents stand (first \"1\") outside of all walls");
        // Pillars and a bottleneck in the open are no room.
        let mut open = trial.clone();
        open.geometry.walls[0].corners = vec![vec2(0.0, 0.0), vec2(6.0, 0.0)];
        assert_eq!(said(&open), [""; 0]);
        trial.dynamics[1].position = vec2(5e4, 2.0);
        says(&trial, "agent \"1\" stands 49996 m away from the others");
    }

    #[test]
    fn a_room_in_centimetres_is_doubted() {
        let mut trial = room();
        for corner in &mut trial.geometry.walls[0].corners {
            *corner = *corner * 100.0;
        }
        says(
            &trial,
            "the walls span 600.000 m × 400.000 m around 5 agents: are their Coordinates in metres?",
        );
        for dynamics in &mut trial.dynamics {
            dynamics.position = dynamics.position * 100.0;
        }
        says(&trial, "the walls span 600.000 m × 400.000 m");
        for corner in &mut trial.geometry.walls[0].corners {
            *corner = *corner * 1e-5;
        }
        assert!(said(&trial)[0].contains("less than an agent"), "{:?}", said(&trial));
    }

    #[test]
    fn bodies_in_centimetres_are_doubted() {
        let mut trial = room();
        for (agent, place) in trial.agents.iter_mut().zip(0..) {
            agent.moment_of_inertia *= 1e4;
            for shape in &mut agent.shapes {
                shape.radius *= 100.0;
                shape.position = shape.position * 100.0;
            }
            trial.dynamics[place].position = vec2(200.0 * place as f64, 0.0);
        }
        trial.geometry.walls.clear();
        let said = said(&trial);
        let words = [
            "agent \"0\" is ",
            " m wide (5 agents are so): are Radius and Position of its shapes in metres?",
        ];
        assert!(said.len() == 1 && words.iter().all(|word| said[0].contains(word)), "{said:?}");
    }

    #[test]
    fn steps_that_nobody_means_are_doubted() {
        let mut trial = room();
        trial.parameters.time_step = 50.0;
        trial.parameters.time_step_mechanical = 1e-5;
        says(&trial, "<Times> TimeStep=\"50.0\": is long: people are pushed the same way during all of it");
        trial.parameters.time_step = 1.0;
        trial.parameters.time_step_mechanical = 1e-9;
        says(
            &trial,
            "<Times> TimeStepMechanical=\"1e-9\": is short: each TimeStep of 1.0 s takes 1.0e9 mechanical steps",
        );
        (trial.parameters.time_step, trial.parameters.time_step_mechanical) = (1e-6, 1e-6);
        says(&trial, "<Times> TimeStep=\"1e-6\": is short");
    }
}
