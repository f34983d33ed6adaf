//! Warnings about possible but probably unintended values in a Trial: sizes a hundred times too large or small, steps
//! of a minute, people outside of the walls or inside a pillar.

use super::Setup;
use super::within::{Inside, outside_rooms, within_pillars};
use crate::engine::{Body, BodyId, CornerId, Face, FaceId, Scene, Vec2};
use lemons_core::message::{Message, Sentence, message};
use lemons_core::plane::{Bounds, segments_touch, vec2};
use lemons_core::rule::sentences::*;
use lemons_core::trial::{Agent, BODY_MASS_INDEX, FileNames, Link, Problem, Rule, Wall};
use std::collections::HashSet;

/// \[m\] Smallest and largest distance from the centre of mass of a person or a bicycle to its rim.
const RIM: [f64; 2] = [0.02, 3.0];
/// \[m\] A hall longer and wider than this ...
const LARGE_HALL: f64 = 50.0;
/// \[1/m²\] ... and with fewer people than this may be in centimetres: with a hundredth of the length and width it
/// would have 10 per m².
const FEW_PEOPLE: f64 = 1e-3;
/// Mechanical steps in a TimeStep that take some seconds for each agent.
const MANY_STEPS: f64 = 1e8;
/// \[m\] A person this close to the outside of a room may be about to enter.
const OUTSIDE: f64 = 2.0;
/// \[m\] Distance from all other people and walls that is taken for a mistake.
const FAR_AWAY: f64 = 1000.0;
/// People outside of all walls who take this many times their length may have places in centimetres.
const SPREAD: f64 = 10.0;
/// \[1\] A stiffness that is this many times that of the plan view is hardly meant.
const STIFFER: f64 = 2.0;
/// \[m\] Distance within which a wall is behind a line of a link.
const LINK_WALL: f64 = 3.0;
/// Number of directions in which walls are searched, and number of them in which a person in a room sees one: a room
/// may have doors.
const DIRECTIONS: u32 = 32;
const ENCLOSED: u32 = 24;
/// Number of people who are tested for being in a room.
const SAMPLE: usize = 50;

impl Setup<'_> {
    /// Returns all doubts.
    pub(super) fn doubts(&self, scene: &Scene, places: &FileNames) -> impl Iterator<Item = Problem> {
        let positions: Vec<Vec2> = self.dynamics.iter().map(|dynamics| dynamics.position).collect();
        let doubts = [
            (Rule::BodySize, &places.agents, self.doubts_of_bodies(scene)),
            (Rule::Centre, &places.agents, self.doubts_of_centres(scene)),
            (Rule::BodyMass, &places.agents, self.doubts_of_masses()),
            (Rule::ChestNowhere, &places.agents, self.doubts_of_chests()),
            (Rule::LoadLength, &places.materials, self.doubts_of_load_length(scene)),
            (Rule::WallsSize, &places.geometry, self.doubts_of_walls(scene)),
            (Rule::WallsDoubled, &places.geometry, self.doubts_of_doubled_faces(scene)),
            (Rule::OpeningShort, &places.geometry, self.doubts_of_openings()),
            (Rule::LinkSide, &places.geometry, self.doubts_of_links(scene)),
            (Rule::Outside, &places.dynamics, self.doubts_of_places(scene, &positions)),
            (Rule::InPillar, &places.dynamics, self.doubts_of_pillars(&positions)),
        ];
        let doubts =
            doubts.into_iter().filter_map(|(rule, file, doubt)| Some(Problem::by(rule, file, doubt?)));
        self.doubts_of_steps(places).into_iter().chain(doubts.collect::<Vec<_>>())
    }

    /// Walls open and close at communication points only.
    fn doubts_of_openings(&self) -> Option<Message> {
        let step = self.parameters.time_step;
        let short = |wall: &Wall| wall.open.as_ref()?.shorter_than(step);
        let mut all = self.geometry.walls.iter().filter_map(|wall| Some((wall, short(wall)?)));
        let (wall, [from, to]) = all.next()?;
        let others = in_all(1 + all.count(), WALLS_IN_ALL);
        Some(message!(OPENING_SHORT, wall = &wall.id, from, to, step, others))
    }

    /// People are carried over a link in the strip behind its line.
    fn doubts_of_links(&self, scene: &Scene) -> Option<Message> {
        let doubt = |link: &Link| {
            link.passages().into_iter().zip(link.lines).find_map(|(passage, [from, to])| {
                let [_, _, end, start] = passage.strip();
                let out = (start + end - from - to) * 0.5;
                let meets = |a: Vec2, b: Vec2| {
                    scene.faces.iter().any(|face| segments_touch(a, b, face.start, face.end))
                };
                let (link, x, y, to_x, to_y) = (&link.id, from.x, from.y, to.x, to.y);
                // The ends of the line are on walls at its sides.
                let blocked = [0.1, 0.5, 0.9].iter().any(|part| {
                    let at = from + (to - from) * *part;
                    meets(at, at + out)
                });
                if blocked {
                    return Some(message!(LINK_BLOCKED, link, x, y, to_x, to_y));
                }
                let middle = (from + to) * 0.5;
                let open = !meets(middle, middle + out * (LINK_WALL / out.norm()));
                open.then(|| message!(LINK_OPEN, link, most = LINK_WALL, x, y, to_x, to_y))
            })
        };
        self.geometry.links.iter().find_map(doubt)
    }

    fn doubts_of_steps(&self, places: &FileNames) -> Option<Problem> {
        let step = self.parameters.time_step;
        let steps = step / self.parameters.time_step_mechanical;
        let message = message!(TOO_SHORT, step, steps);
        (steps > MANY_STEPS).then(|| self.of_step(Rule::StepTooShort, places, message))
    }

    /// Returns the first body that is odd, the Id of its agent, and how many there are in all.
    fn odd<'b>(
        &self,
        scene: &'b Scene,
        odd: impl Fn(&Body) -> bool,
    ) -> Option<(&'b Body, &str, Option<Message>)> {
        let mut all = scene.bodies.iter().zip(&self.agents).filter(|(body, _)| odd(body));
        let (body, agent) = all.next()?;
        Some((body, &agent.id, in_all(1 + all.count(), AGENTS_IN_ALL)))
    }

    fn doubts_of_bodies(&self, scene: &Scene) -> Option<Message> {
        let [small, large] = RIM;
        let (body, agent, others) =
            self.odd(scene, |body| !(small..=large).contains(&body.bounding_radius))?;
        Some(message!(BODY_SIZE, agent, width = 2.0 * body.bounding_radius, others))
    }

    /// Things that go along are heavy, too: they have disks of other materials.
    fn doubts_of_masses(&self) -> Option<Message> {
        let [least, most] = BODY_MASS_INDEX;
        let odd = |agent: &&Agent| {
            let alone = agent.shapes.iter().all(|shape| shape.material_id == agent.shapes[0].material_id);
            let index = agent.height.map(|height| agent.mass / (height * height));
            index.is_some_and(|index| index < least || index > most && alone)
        };
        // Masses and heights that nobody has are told otherwise.
        let usual = |agent: &&Agent| agent.mass >= 1.0 && agent.height.is_some_and(|height| height < 2.8);
        let mut all = self.agents.iter().filter(usual).filter(odd);
        let Agent { id, mass, height, .. } = all.next()?;
        let (height, others) = (height.unwrap_or_default(), in_all(1 + all.count(), AGENTS_IN_ALL));
        Some(message!(
            BODY_MASS,
            agent = id,
            height,
            mass,
            index = mass / (height * height),
            others,
            least,
            most
        ))
    }

    /// A centre of mass is within the hull of the disks: in each direction one of them reaches beyond it.
    fn doubts_of_centres(&self, scene: &Scene) -> Option<Message> {
        let odd = |body: &Body| {
            (0..DIRECTIONS).any(|k| {
                let towards = direction(f64::from(k));
                let disks = &scene.disks[body.disks.clone()];
                disks.iter().all(|disk| disk.offset.dot(&towards) + disk.radius < 0.0)
            })
        };
        let (_, agent, others) = self.odd(scene, odd)?;
        Some(message!(CENTRE, agent, others))
    }

    /// Heights of chests are of levels that somebody has.
    fn doubts_of_chests(&self) -> Option<Message> {
        let nowhere = |agent: &&Agent| {
            agent.chest_height.is_some_and(|at| !agent.shapes.iter().any(|shape| shape.heights.hold(at)))
        };
        let mut all = self.agents.iter().filter(nowhere);
        let agent = all.next()?;
        let others = in_all(1 + all.count(), AGENTS_IN_ALL);
        Some(message!(CHEST_NOWHERE, agent = &agent.id, height = agent.chest_height?, others))
    }

    /// A rail in a plan view is stiffer than a wall by its own height over LoadLength.
    fn doubts_of_load_length(&self, scene: &Scene) -> Option<Message> {
        let levels = scene.levels.as_ref()?;
        let shares = (0..scene.bodies.len()).map(|body| levels.greatest_share(BodyId::from(body)));
        let mut all = self.agents.iter().zip(shares).filter(|(_, share)| *share > STIFFER);
        let (agent, share) = all.next()?;
        let others = in_all(1 + all.count(), AGENTS_IN_ALL);
        let length = self.materials.load_length;
        Some(message!(LOAD_LENGTH_SHORT, agent = &agent.id, share, length, others))
    }

    /// Faces that lie on each other act like one: that is probably meant, but not their number.
    fn doubts_of_doubled_faces(&self, scene: &Scene) -> Option<Message> {
        let doubled = &scene.doubled;
        let material =
            |face: FaceId| &self.geometry.walls[scene.faces[face.index()].wall.index()].material_id;
        let differ = |pair: &&(FaceId, FaceId)| material(pair.0) != material(pair.1);
        let &(one, other) = doubled.iter().find(differ).or(doubled.first())?;
        let [first, second] = [one, other].map(material);
        let same = |corner: CornerId| {
            let face = &scene.faces[one.index()];
            corner == face.start_corner || corner == face.end_corner
        };
        let of_other = &scene.faces[other.index()];
        let material = if first == second {
            None
        } else if same(of_other.start_corner) && same(of_other.end_corner) {
            Some(message!(OF_FIRST, first))
        } else {
            Some(message!(OF_EITHER, first, second))
        };
        let named = |face: FaceId| {
            let Face { start, end, .. } = scene.faces[face.index()];
            let wall = self.name_of_wall(scene, face);
            message!(FACE, wall, x = start.x, y = start.y, to_x = end.x, to_y = end.y)
        };
        let faces: HashSet<FaceId> = doubled.iter().flat_map(|pair| [pair.0, pair.1]).collect();
        let others = if doubled.len() > 1 { in_all(faces.len(), FACES_IN_ALL) } else { None };
        Some(message!(DOUBLED, one = named(one), other = named(other), others, material))
    }

    fn doubts_of_walls(&self, scene: &Scene) -> Option<Message> {
        let size = Bounds::of(scene.corners.iter().map(|corner| corner.position))?.size();
        let agents = scene.bodies.len() as f64;
        let widest = scene.bodies.iter().map(|body| 2.0 * body.bounding_radius).fold(0.0, f64::max);
        let (width, height) = (size.x, size.y);
        if width.max(height) < widest {
            Some(message!(WALLS_SMALL, width, height))
        } else if width.min(height) > LARGE_HALL && agents < FEW_PEOPLE * width * height {
            Some(match scene.bodies.len() {
                1 => message!(WALLS_AROUND_ONE, width, height),
                agents => message!(WALLS_AROUND, width, height, agents),
            })
        } else {
            None
        }
    }

    fn doubts_of_places(&self, scene: &Scene, places: &[Vec2]) -> Option<Message> {
        let walls = Bounds::of(scene.corners.iter().map(|corner| corner.position));
        let beyond = |far: f64, place: Vec2| walls.is_none_or(|walls| !walls.grown(far).contains(place));
        // Far from the middle of the crowd, whatever walls there are.
        let middle = middle_of(places)?;
        let is_far = |place: Vec2| (place - middle).norm() > FAR_AWAY && beyond(FAR_AWAY, place);
        if let Some(b) = places.iter().position(|place| is_far(*place)) {
            let away = (places[b] - middle).norm();
            let who = self.who_stands(&[b])?;
            return Some(message!(AWAY, who, away));
        }
        let walls = walls?;
        let outside: Vec<usize> = (0..places.len()).filter(|b| beyond(OUTSIDE, places[*b])).collect();
        let inside = places.len() - outside.len();
        let spread = Bounds::of(places.iter().copied())?.size();
        if inside == 0 && spread.x.max(spread.y) > SPREAD * walls.size().x.max(walls.size().y) {
            return Some(message!(NOBODY_BETWEEN, width = spread.x, height = spread.y));
        }
        // If most people are outside, or no person is in a room, being outside is intended.
        let most_are_enclosed = || {
            let insiders = (0..places.len()).filter(|b| outside.binary_search(b).is_err());
            let sample: Vec<usize> = insiders.step_by(inside.div_ceil(SAMPLE)).collect();
            2 * sample.iter().filter(|&&b| is_enclosed(scene, places[b])).count() > sample.len()
        };
        if inside == 0 || outside.is_empty() || outside.len() > inside || !most_are_enclosed() {
            return self.doubts_of_closed_rooms(scene, places);
        }
        Some(message!(OUTSIDE_ALL, who = self.who_stands(&outside)?))
    }

    /// Doubts people who are near closed rooms that they cannot enter.
    fn doubts_of_closed_rooms(&self, scene: &Scene, places: &[Vec2]) -> Option<Message> {
        let (mut outside, inside) = outside_rooms(&self.geometry.walls, places)?;
        // Other walls, with doors, may be around both.
        outside.retain(|&b| !is_enclosed(scene, places[b]));
        let who = self.who_stands(&outside)?;
        Some(match inside {
            0 => message!(OUTSIDE_EMPTY, who),
            count => message!(OUTSIDE_CLOSED, who, count),
        })
    }

    fn who_stands(&self, agents: &[usize]) -> Option<Message> {
        let agent = &self.agents[*agents.first()?].id;
        Some(match agents.len() {
            1 => message!(STANDS, agent),
            count => message!(STAND, count, agent),
        })
    }

    fn doubts_of_pillars(&self, places: &[Vec2]) -> Option<Message> {
        let Inside { agent, wall, count, around } = within_pillars(&self.geometry.walls, places)?;
        let (agent, wall) = (&self.agents[agent].id, &self.geometry.walls[wall].id);
        let who = match count {
            1 => message!(STANDS_INSIDE, agent, wall),
            count => message!(STAND_INSIDE, count, agent, wall),
        };
        let others = match around {
            1 => message!(AROUND_ONE),
            count => message!(AROUND, count),
        };
        Some(message!(IN_PILLAR, who, others))
    }
}

/// Says how many there are, if there are several.
fn in_all(count: usize, what: Sentence) -> Option<Message> {
    (count > 1).then(|| Message::new(what, &[("count", &count)]))
}

/// Returns the median of each coordinate.
fn middle_of(places: &[Vec2]) -> Option<Vec2> {
    let median = |coordinate: fn(&Vec2) -> f64| {
        let mut values: Vec<f64> = places.iter().map(coordinate).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied()
    };
    Some(vec2(median(|place| place.x)?, median(|place| place.y)?))
}

/// Returns the unit vector of the direction `k` of [`DIRECTIONS`].
fn direction(k: f64) -> Vec2 {
    let angle = std::f64::consts::TAU * k / f64::from(DIRECTIONS);
    vec2(libm::cos(angle), libm::sin(angle))
}

/// Returns whether walls are visible in most directions.
fn is_enclosed(scene: &Scene, place: Vec2) -> bool {
    let sees = |k: &u32| {
        let towards = direction(f64::from(*k) + 0.5);
        scene.faces.iter().any(|face| {
            let (from, to) = (face.start - place, face.end - place);
            let (a, b) = (towards.perp(&from), towards.perp(&to));
            // The ends are on different sides of the line of sight, and the crossing is ahead.
            (a > 0.0) != (b > 0.0) && (from * b - to * a).dot(&towards) * (b - a) > 0.0
        })
    };
    (0..DIRECTIONS).filter(sees).count() as u32 >= ENCLOSED
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::vec2;
    use lemons_core::trial::{Trial, Wall};

    /// The paper's five in a room of 6 m × 4 m with a door of 1.2 m in its right wall.
    fn room() -> Trial {
        let mut trial = Trial::read(&lemons_testing::trial_push()).expect("the default Trial is in order").0;
        trial.geometry.walls.truncate(1);
        trial.geometry.walls[0].corners =
            corners(&[(6.0, 2.6), (6.0, 4.0), (0.0, 4.0), (0.0, 0.0), (6.0, 0.0), (6.0, 1.4)]);
        for (k, dynamics) in trial.dynamics.iter_mut().enumerate() {
            dynamics.position = vec2(0.8 + k as f64, 2.0);
        }
        trial
    }

    fn corners(at: &[(f64, f64)]) -> Vec<Vec2> {
        at.iter().map(|&(x, y)| vec2(x, y)).collect()
    }

    fn add_wall(trial: &mut Trial, id: &str, at: &[(f64, f64)]) {
        let wall = Wall { id: id.into(), corners: corners(at), ..trial.geometry.walls[0].clone() };
        trial.geometry.walls.push(wall);
    }

    fn messages(trial: &Trial) -> Vec<String> {
        Setup::of(trial).advice_as_edited().iter().map(ToString::to_string).collect()
    }

    /// Checks that one doubt has all these words, which are between "…"; no words: there is no doubt.
    #[track_caller]
    fn says(trial: &Trial, words: &str) {
        let messages = messages(trial);
        let found = messages.iter().filter(|line| words.split(" … ").all(|words| line.contains(words)));
        assert_eq!(
            (messages.len(), found.count()),
            (usize::from(!words.is_empty()), messages.len()),
            "{messages:?}"
        );
    }

    #[test]
    fn a_room_with_a_door_is_not_doubted_but_faces_that_lie_on_each_other() {
        let mut trial = room();
        // Inside, in the door, and just through it.
        for x in [5.0, 6.0, 7.5] {
            trial.dynamics[4].position = vec2(x, 2.0);
            says(&trial, "");
        }
        // End to end: as it should be.
        add_wall(&mut trial, "again", &[(6.0, 1.4), (8.0, 1.4)]);
        says(&trial, "");
        trial.geometry.walls[1].corners = corners(&[(4.0, 0.0), (1.0, 0.0)]);
        says(&trial, "wall \"again\" from 4.0,0.0 to 1.0,0.0 lie on each other: they act like one wall");
        // Of other materials: in part, and twice the same.
        trial.geometry.walls[1].material_id = "human_naked".into();
        says(&trial, "act like one wall, of \"concrete\" or of \"human_naked\" as rounding decides");
        trial.geometry.walls[1].corners = corners(&[(6.0, 0.0), (0.0, 0.0)]);
        says(&trial, "act like one wall of \"concrete\", the material of the first");
    }

    #[test]
    fn agents_outside_of_rooms_and_in_pillars_are_named() {
        let mut trial = room();
        trial.dynamics[3].position = vec2(3.8, -7.0);
        says(&trial, "agent \"3\" stands outside of all walls, but the others are inside");
        trial.dynamics[1].position = vec2(13.8, 2.0);
        says(&trial, "2 agents stand (first \"1\") outside of all walls");
        // Pillars and a bottleneck in the open are no room.
        let mut open = trial.clone();
        open.geometry.walls[0].corners = corners(&[(0.0, 0.0), (6.0, 0.0)]);
        says(&open, "");
        trial.dynamics[1].position = vec2(5e4, 2.0);
        says(&trial, "agent \"1\" stands 49996 m away from the others");

        let mut trial = room();
        add_wall(&mut trial, "pillar", &[(2.5, 1.7), (3.1, 1.7), (3.1, 2.3), (2.5, 2.3), (2.5, 1.7)]);
        let words =
            "\"2\" stands inside the closed wall \"pillar\", around which 4 others stand: is it a pillar?";
        assert!(messages(&trial).join("\n").contains(words));
        trial.dynamics[2].position = vec2(2.8, 3.0);
        says(&trial, "");
    }

    /// An L-shaped room: its hull has the agents in the notch in it.
    #[test]
    fn agents_beside_a_closed_room_are_named() {
        let mut trial = room();
        let shape = [(0.0, 0.0), (6.0, 0.0), (6.0, 2.5), (3.0, 2.5), (3.0, 6.0), (0.0, 6.0), (0.0, 0.0)];
        trial.geometry.walls[0].corners = corners(&shape);
        says(&trial, "");
        trial.dynamics[4].position = vec2(4.0, 4.0);
        says(
            &trial,
            "agent \"4\" stands outside of the closed walls in which 4 others stand: is this intended?",
        );
        trial.dynamics[2].position = vec2(2.8, -1.0);
        says(&trial, "2 agents stand (first \"2\") outside of the closed walls in which 3 others stand");
        // Somebody who is alone; beside a pillar.
        let mut lone = trial.clone();
        lone.agents.truncate(1);
        lone.dynamics.truncate(1);
        says(&lone, "");
        lone.dynamics[0].position = vec2(-3.0, 2.0);
        says(&lone, "agent \"0\" stands outside of the closed walls, and nobody inside: is this intended?");
        lone.geometry.walls[0].corners.iter_mut().for_each(|corner| *corner *= 0.3);
        says(&lone, "");
        // More outside than inside: the others are asked about.
        trial.dynamics[1].position = vec2(1.8, -1.0);
        says(&trial, "around which 3 others stand: is it a pillar?");
        // A pen in a hall with a door: those beside it are in the hall.
        let mut hall = room();
        add_wall(&mut hall, "pen", &[(0.2, 1.0), (4.3, 1.0), (4.3, 3.0), (0.2, 3.0), (0.2, 1.0)]);
        says(&hall, "");
    }

    #[test]
    fn places_rooms_and_bodies_in_centimetres_are_doubted() {
        let scale_places = |trial: &mut Trial| {
            trial.dynamics.iter_mut().for_each(|dynamics| dynamics.position *= 100.0);
        };
        let scale_walls = |trial: &mut Trial, factor: f64| {
            trial.geometry.walls[0].corners.iter_mut().for_each(|corner| *corner *= factor);
        };
        let mut trial = room();
        scale_places(&mut trial);
        says(
            &trial,
            "nobody is between the walls, and people span 400.000 m × 0.000 m: are their Positions in metres?",
        );
        let mut trial = room();
        scale_walls(&mut trial, 100.0);
        says(
            &trial,
            "the walls span 600.000 m × 400.000 m around 5 agents: are their Coordinates in metres?",
        );
        scale_places(&mut trial);
        says(&trial, "the walls span 600.000 m × 400.000 m");
        scale_walls(&mut trial, 1e-5);
        assert!(messages(&trial)[0].contains("less than an agent"), "{:?}", messages(&trial));

        let mut trial = room();
        for (agent, place) in trial.agents.iter_mut().zip(0..) {
            agent.moment_of_inertia *= 1e4;
            for shape in &mut agent.shapes {
                shape.radius *= 100.0;
                shape.position *= 100.0;
            }
            trial.dynamics[place].position = vec2(200.0 * place as f64, 0.0);
        }
        trial.geometry.walls.clear();
        let messages = messages(&trial);
        let words = " m wide (5 agents in all): are Radius and Position of its shapes in metres?";
        assert!(messages.len() == 2 && messages[1].contains(words), "{messages:?}");
        assert!(messages[0].contains("is it in kg cm² (1.85 kg m²)?"), "{messages:?}");
    }

    #[test]
    fn steps_and_centres_that_nobody_means_are_doubted() {
        for (time_step, mechanical, words) in [
            (50.0, 1e-5, "<Times> TimeStep=\"50.0\": 1e-5 s to 1 s is usual, because drives are constant"),
            (
                1.0,
                1e-9,
                "TimeStepMechanical=\"1e-9\": is short: each TimeStep of 1.0 s takes 1.0e9 mechanical steps",
            ),
            (1e-6, 1e-6, "<Times> TimeStep=\"1e-6\": 1e-5 s to 1 s is usual"),
        ] {
            let mut trial = room();
            (trial.parameters.time_step, trial.parameters.time_step_mechanical) = (time_step, mechanical);
            says(&trial, words);
        }
        let mut trial = room();
        // Beside the disks, but between them: two shoulders.
        trial.agents[1].shapes = vec![trial.agents[1].shapes[0].clone(), trial.agents[1].shapes[4].clone()];
        says(&trial, "");
        let shapes = trial.agents[2..4].iter_mut().flat_map(|agent| &mut agent.shapes);
        shapes.for_each(|shape| shape.position.x += 0.4);
        says(&trial, "the centre of mass of agent \"2\" is outside of its own shapes (2 agents in all)");
    }

    #[test]
    fn a_mass_is_doubted_by_the_stature() {
        let mut trial = room();
        trial.agents.iter_mut().for_each(|agent| agent.height = Some(1.76));
        says(&trial, "");
        trial.agents[1].mass = 7.6;
        trial.agents[3].mass = 8.1;
        says(
            &trial,
            "agent \"1\" of Height 1.76 m has a Mass of 7.6 kg, 2.5 kg/m² (2 agents in all): people have 10",
        );
        // A toddler of 90 cm.
        for agent in [1, 3] {
            trial.agents[agent].height = Some(0.9);
            trial.agents[agent].mass = 12.5;
        }
        says(&trial, "");
        trial.agents[1].mass = 180.0;
        says(&trial, "agent \"1\" … 222.2 kg/m²:");
        // A loaded bicycle goes along.
        trial.agents[1].shapes[0].material_id = trial.geometry.walls[0].material_id.clone();
        assert!(messages(&trial).iter().all(|line| !line.contains("kg/m²")));
    }

    /// A value of each attribute in another unit, with that unit and the value that is meant: the person's own.
    #[test]
    fn values_in_other_units_are_doubted_with_the_unit() {
        type Change = fn(&mut Trial);
        let cases: [(Change, &str); 22] = [
            (
                |t| t.agents[0].mass = 89e3,
                "<Agent> Mass=\"89000.0\": agent \"0\": 1 kg to 1000 kg … g (89 kg)?",
            ),
            (|t| t.agents[0].mass = 0.089, "Mass=\"0.089\" … t (89 kg)?"),
            (
                |t| t.agents[1].moment_of_inertia = 10_200.0,
                "MomentOfInertia=\"10200.0\" … kg cm² (1.02 kg m²)?",
            ),
            (
                |t| t.agents[1].moment_of_inertia = 1.02e6,
                "MomentOfInertia=\"1020000.0\" … kg mm² (1.02 kg m²)?",
            ),
            (|t| t.agents[0].floor_damping = 450.0, "FloorDamping=\"450.0\" … kg/s (5.06 1/s)?"),
            (|t| t.agents[0].angular_damping = 90.0, "AngularDamping=\"90.0\" … kg m²/s (48.6 1/s)?"),
            (
                |t| t.dynamics[2].velocity = vec2(60.0, 80.0),
                "Velocity=\"60.0,80.0\": agent \"2\" … cm/s (1 m/s)?",
            ),
            (|t| t.dynamics[2].velocity = vec2(0.0, -18.0), "Velocity=\"0.0,-18.0\" … km/h (5 m/s)?"),
            (|t| t.dynamics[2].velocity = vec2(1e7, 0.0), "<Kinematics> Velocity … is it right?"),
            (|t| t.dynamics[2].fp = vec2(6e5, 0.0), "Fp=\"600000.0,0.0\": agent \"2\" … mN (600 N)?"),
            (|t| t.dynamics[2].mp = -1e4, "Mp=\"-10000.0\" … N mm (-10 N m)?"),
            (|t| t.agents[0].height = Some(1794.0), "<Agent> Height=\"1794.0\" … mm (1.79 m)?"),
            (|t| t.agents[0].height = Some(70.6), "<Agent> Height=\"70.6\" … inches (1.79 m)?"),
            (
                |t| t.agents[1].shapes[0].radius = 9.5e-3,
                "<Shape> Radius=\"0.0095\": agent \"1\" … is it right?",
            ),
            (|t| t.materials.binary[2].gamma_normal = 1.3e-3, "GammaNormal=\"0.0013\" … MN s/m (1300 kg/s)?"),
            (|t| t.dynamics[2].theta = -90.0, "Theta=\"-90.0\" … degrees (-1.57 rad)?"),
            (|t| t.dynamics.iter_mut().for_each(|d| d.theta = 90.0), "agent \"0\" (and 4 more) … degrees"),
            (|t| t.dynamics[2].omega = 180.0, "Omega=\"180.0\" … degrees/s (3.14 rad/s)?"),
            (
                |t| t.materials.binary[2].kinetic_friction = 40.0,
                "KineticFriction=\"40.0\": materials \"concrete\" and \"human_naked\" … per cent (0.4)?",
            ),
            (|t| t.parameters.time_step = 50.0, "TimeStep=\"50.0\": 1e-5 s to 1 s is usual … ms (0.05 s)?"),
            (
                |t| t.materials.intrinsic.iter_mut().for_each(|m| m.young_modulus *= 1e-6),
                "YoungModulus=\"1700.0\": material \"concrete\" (and 2 more): 10000 N/m to 1e12 N/m … MPa (1.7e9 N/m)?",
            ),
            (
                |t| t.materials.intrinsic.iter_mut().for_each(|m| m.shear_modulus *= 1e-6),
                "ShearModulus=\"710.0\": material \"concrete\" (and 2 more) … MN/m or MPa (7.1e8 N/m)?",
            ),
        ];
        for (change, words) in cases {
            let mut trial = room();
            change(&mut trial);
            // Before the engine's own checks, which say something else of such values.
            let unusual: Vec<_> = Setup::of(&trial).unusual(&FileNames::default()).collect();
            let messages: Vec<String> = unusual.iter().map(ToString::to_string).collect();
            let found = messages.iter().filter(|line| words.split(" … ").all(|words| line.contains(words)));
            assert_eq!(found.count(), 1, "{words}: {messages:?}");
        }
    }
}
