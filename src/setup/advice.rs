//! Warnings about the mechanics of a Trial without errors.

use super::steps::{CONTACTS_AT_ONCE, Fastest, rounded_down};
use super::{Setup, WorldError};
use crate::engine::{Contact, ContactReport, Pair, Scene, World};
use lemons_core::message::{Message, message};
use lemons_core::rule::sentences::*;
use lemons_core::trial::{FileNames, Problem, Rule};
use std::collections::{BTreeSet, HashSet};

/// Largest distance that a disk moves in a proposed step, as a fraction of its radius.
const PROPOSED_SHARE_OF_RADIUS: f64 = 1.0 / 10.0;

/// Damping this many times the critical one (above which nothing bounces back) is probably a mistake.
const ABSURD_DAMPING: f64 = 1000.0;

/// \[s\] Assumed duration of a drive without relaxation.
const DRIVEN_FOR: f64 = 10.0;

impl Setup<'_> {
    /// Returns warnings about overlaps at the start without a spring from an earlier step, and about a mechanical step
    /// that does not resolve the shortest contact.
    pub(super) fn advice(&self, places: &FileNames) -> Vec<Problem> {
        let dynamics = &places.dynamics;
        let world = match self.world() {
            Ok(world) => world,
            Err(crowded @ WorldError::Crowded { .. }) => {
                return vec![Problem::of_file(dynamics, None, crowded.to_string())];
            }
            // Materials that cannot touch were reported as errors already.
            Err(_) => return Vec::new(),
        };
        let scene = world.scene();
        let overlaps = self.overlaps_at_start(scene, world.contacts()).into_iter();
        let overlaps = overlaps.map(|message| Problem::by(Rule::Overlap, dynamics, message));
        let coincident = self.name_coincident(scene, &world.contacts().coincident);
        let coincident = coincident.map(|message| Problem::by(Rule::SamePlace, dynamics, message));
        let mut advice: Vec<_> = overlaps.chain(coincident).collect();
        advice.extend(self.coarse_step(scene, places));
        advice.extend(self.stepping_over(scene, places));
        advice.extend(self.unusual(places));
        advice.extend(self.doubts(scene, places));
        advice
    }

    /// Returns the same warnings for a Trial whose numbers were edited after reading.
    pub fn advice_as_edited(&self) -> Vec<Problem> {
        let mut advice = self.advice(&FileNames::default());
        for Problem { file, .. } in &mut advice {
            *file = format!("{} ({}, with the parameters as set)", self.name, file.display()).into();
        }
        advice
    }

    /// Returns the overlaps at the start that no earlier step knows.
    fn overlaps_at_start(&self, scene: &Scene, contacts: &ContactReport) -> Vec<Message> {
        let state = self.state(scene);
        let known_disks: HashSet<_> =
            state.disk_springs.iter().map(|spring| (spring.first, spring.second)).collect();
        let known_faces: HashSet<_> =
            state.face_springs.iter().map(|spring| (spring.disk, spring.face)).collect();
        let is_new = |pair: &Pair| match *pair {
            Pair::Disks { first, second } => !known_disks.contains(&(first, second)),
            Pair::Face { disk, face, .. } => !known_faces.contains(&(disk, face)),
        };
        self.overlaps(scene, contacts, is_new, message!(AT_START))
    }

    /// Returns warnings about overlaps of agents, by their places, who come back into a world at a time \[s\].
    pub fn overlaps_of(&self, world: &World, agents: &BTreeSet<usize>, time: f64) -> Vec<Message> {
        let scene = world.scene();
        let is_theirs = |disk| agents.contains(&scene.body_of(disk).index());
        let is_new = |pair: &Pair| match *pair {
            Pair::Disks { first, second } => is_theirs(first) || is_theirs(second),
            Pair::Face { disk, .. } => is_theirs(disk),
        };
        self.overlaps(scene, world.contacts(), is_new, message!(WHERE_BACK, time))
    }

    fn overlaps(
        &self,
        scene: &Scene,
        contacts: &ContactReport,
        is_new: impl Fn(&Pair) -> bool,
        when: Message,
    ) -> Vec<Message> {
        let (among_agents, with_walls): (Vec<&Contact>, Vec<&Contact>) = contacts
            .contacts
            .iter()
            .filter(|contact| is_new(&contact.pair))
            .partition(|contact| matches!(contact.pair, Pair::Disks { .. }));
        let told = |(overlaps, what): (Vec<&Contact>, Message)| {
            let count = overlaps.len();
            let pairs = if count == 1 { message!(PAIR) } else { message!(PAIRS) };
            let deepest = overlaps.into_iter().reduce(|a, b| if b.depth > a.depth { b } else { a })?;
            let whose = self.name_pair(scene, deepest.pair, false);
            Some(message!(OVERLAP, count, pairs, what, when, depth = 1e3 * deepest.depth, whose))
        };
        let all = [(among_agents, message!(DISKS_OF_AGENTS)), (with_walls, message!(DISKS_AND_WALLS))];
        all.into_iter().filter_map(told).collect()
    }

    fn coarse_step(&self, scene: &Scene, places: &FileNames) -> Option<Problem> {
        let step = self.parameters.time_step_mechanical;
        let steps = self.steps_in(scene)?;
        let Fastest { pair, rates, materials } = &steps.least_allowed;
        if step <= steps.longest() {
            return None;
        }
        let stable = steps.stable();
        let verdict = if step < stable {
            message!(LONG, stable, pair)
        } else if step < rates.unstable_from(1.0) {
            message!(GAINS, stable, contacts = CONTACTS_AT_ONCE, pair)
        } else {
            message!(CREATES, stable, pair)
        };
        let ratio = rates.damping / rates.critical_damping();
        let message = if ratio > ABSURD_DAMPING {
            self.absurd_damping(scene, *materials, ratio, verdict)
        } else if let Some(proposed) = steps.proposed() {
            let damping = (rates.damping != 0.0).then(|| message!(DAMPING_TIME, time = 1.0 / rates.damping));
            message!(RESOLVES, verdict, period = rates.period(), damping, proposed)
        } else {
            message!(NO_STEP, pair)
        };
        Some(self.of_step(Rule::StepTooLong, places, message))
    }

    /// Returns what a rule says of `TimeStepMechanical`.
    pub(super) fn of_step(&self, rule: Rule, places: &FileNames, message: Message) -> Problem {
        let step = format!("{:?}", self.parameters.time_step_mechanical);
        of_attribute(rule, places, "TimeStepMechanical", step, message)
    }

    /// Returns a message that the damping of two materials is the cause, not the step.
    fn absurd_damping(
        &self,
        scene: &Scene,
        (first, second): (usize, usize),
        ratio: f64,
        verdict: Message,
    ) -> Message {
        let law = scene.law(first, second);
        let (name, damping) = if law.normal_damping >= law.tangential_damping {
            ("GammaNormal", law.normal_damping)
        } else {
            ("GammaTangential", law.tangential_damping)
        };
        let materials = self.used_materials();
        let [first, second] = [first, second].map(|place| &materials[place].id);
        message!(DAMPED, verdict, name, damping, first, second, ratio, critical = damping / ratio)
    }

    /// Finds disks that may be on the far side of a wall or of a person before a contact is detected.
    fn stepping_over(&self, scene: &Scene, places: &FileNames) -> Option<Problem> {
        let step = self.parameters.time_step_mechanical;
        let (mut count, mut worst) = (0_usize, None::<(f64, f64, usize)>);
        for (b, (body, dynamics)) in scene.bodies.iter().zip(&self.dynamics).enumerate() {
            let for_so_long = |rate: f64| (1.0 / rate).min(DRIVEN_FOR);
            let speed = dynamics.velocity.norm()
                + dynamics.fp.norm()
                    * body.inverse_mass
                    * for_so_long(body.translation_rate.min(body.across_rate.unwrap_or(f64::INFINITY)));
            let spin = dynamics.omega.abs()
                + dynamics.mp.abs() * body.inverse_inertia * for_so_long(body.rotation_rate);
            // The disk of the body that moves furthest relative to its size.
            let steps = scene.disks[body.disks.clone()].iter().map(|disk| {
                let speed = speed + spin * disk.offset.norm();
                (speed * step / disk.radius, disk.radius)
            });
            let Some((share, radius)) = steps.max_by(|(a, _), (b, _)| a.total_cmp(b)) else { continue };
            if share > 1.0 {
                count += 1;
                if worst.is_none_or(|(most, ..)| share > most) {
                    worst = Some((share, radius, b));
                }
            }
        }
        let (share, radius, b) = worst?;
        let others = (count > 1).then(|| message!(AGENTS_MAY, count));
        let cure = match rounded_down(PROPOSED_SHARE_OF_RADIUS * step / share) {
            Some(step) => message!(SHORT_ENOUGH, step),
            None => message!(NONE_SHORT_ENOUGH),
        };
        let (agent, moved, speed) = (&self.agents[b].id, share * radius, share * radius / step);
        let message = message!(STEP_OVER, agent, moved, radius, others, speed, cure);
        Some(self.of_step(Rule::StepOver, places, message))
    }
}

/// Returns what a rule says of a value of an attribute of the Trial's files.
pub(super) fn of_attribute(
    rule: Rule,
    places: &FileNames,
    attribute: &str,
    value: String,
    message: Message,
) -> Problem {
    let (file, element) = places.with_attribute(attribute).unzip();
    Problem {
        element: element.map(str::to_owned),
        attribute: Some(attribute.to_owned()),
        value: Some(value),
        ..Problem::by(rule, &file.unwrap_or_default(), message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Vec2, vec2};
    use lemons_core::trial::Trial;

    /// The default Trial after a change.
    fn push(change: impl FnOnce(&mut Trial)) -> Trial {
        let read = Trial::read(&lemons_testing::trial_push());
        let mut trial = read.expect("the default Trial is in order").0;
        change(&mut trial);
        trial
    }

    /// Checks that there is one warning, with all these words; no words: there is none.
    #[track_caller]
    fn says(trial: &Trial, words: &[&str]) {
        let advice = Setup::of(trial).advice(&FileNames::default());
        let messages: Vec<String> = advice.iter().map(ToString::to_string).collect();
        assert_eq!(messages.len(), usize::from(!words.is_empty()), "{messages:?}");
        assert!(words.iter().all(|word| messages[0].contains(word)), "{messages:?}");
    }

    /// Checks that one of the warnings has these words.
    #[track_caller]
    fn says_besides(trial: &Trial, words: &str) {
        let advice = Setup::of(trial).advice(&FileNames::default());
        assert!(advice.iter().any(|problem| problem.to_string().contains(words)), "{advice:?}");
    }

    #[test]
    fn overlaps_are_counted_and_the_deepest_named() {
        says(&push(|_| {}), &[]);
        let mut trial = push(|trial| trial.dynamics[1].position.x = 0.2);
        says(&trial, &["warning: AgentDynamics.xml: ", "(agents \"0\" and \"1\")"]);
        trial.dynamics[1].position.x = 0.279;
        trial.dynamics[4].position.x = 1.7;
        says_besides(&trial, "(agent \"4\" and wall \"0\")");
    }

    #[test]
    fn centres_at_one_place_are_counted_and_two_named() {
        let mut trial = push(|trial| {
            for agent in &mut trial.agents {
                agent.shapes.truncate(1);
                agent.shapes[0].position = Vec2::zeros();
            }
        });
        // On both sides of a cell's edge.
        trial.dynamics[3].position = vec2(0.5 - 4e-10, 0.5);
        trial.dynamics[1].position = vec2(0.5 + 4e-10, 0.5);
        says_besides(
            &trial,
            "agents \"1\" and \"3\" have their centres at one place: no force acts between them",
        );
        trial.dynamics[4].position = trial.dynamics[1].position;
        says_besides(&trial, "at one place, and 2 more pairs: no");
        trial.dynamics[4].position.x += 1e-6;
        says_besides(&trial, "at one place: no");
        let trial = push(|trial| {
            trial.agents[2].shapes.truncate(1);
            trial.agents[2].shapes[0].position = Vec2::zeros();
            trial.dynamics[2].position = trial.geometry.walls[0].corners[0];
        });
        says_besides(
            &trial,
            "agent \"2\" and a corner of wall \"0\" have their centres at one place: no force",
        );
    }

    #[test]
    fn a_coarse_step_is_named_with_one_that_would_do() {
        let mut trial = push(|trial| trial.parameters.time_step_mechanical = 0.002);
        // k_n = 4.99e6 N/m; 1/63 kg + (0.2225 m)²/1.02 kg.m2: a period of 11 ms.
        says(
            &trial,
            &[
                "<Times> TimeStepMechanical=\"0.002\": is not stable (up to 8.4e-4 s): a body with 8",
                "at most 1e-4 s",
            ],
        );
        trial.parameters.time_step_mechanical = 8e-4;
        says(&trial, &["is stable (up to 8.4e-4 s), but long for the contact of agent", "at most 1e-4 s"]);
        trial.parameters.time_step_mechanical = 2e-4;
        says(&trial, &[]);
        // A light body, by its damping; and one that no step resolves.
        let trial = push(|trial| {
            trial.parameters.time_step_mechanical = 1e-6;
            (trial.agents[2].mass, trial.agents[2].moment_of_inertia) = (0.001, 0.001);
        });
        says_besides(&trial, "\"2\" and wall \"0\" create energy");
        let trial = push(|trial| trial.agents[0].moment_of_inertia = 1e-320);
        says_besides(&trial, "no step resolves the contact of agents");
        assert_eq!(Setup::of(&trial).proposed_step(), None);
    }

    /// The paper's agent 1 on a wall: 1/m* is 0.0644/kg, and 2 √(k m*) with k = 5.0e6 N/m is 1.8e4 kg/s.
    #[test]
    fn damping_that_makes_the_step_not_stable_is_warned_of_and_absurd_damping_is_the_cause() {
        let absurd = "1000000000000.0 kg/s of the materials \"human_naked\" and \"concrete\"";
        for (normal, damping, words) in [
            (
                true,
                2e6,
                ["is not stable (up to 9.7e-7 s): collisions in", "damping time 7.73e-6 s", "at most 5e-7 s"],
            ),
            (false, 2.5e4, ["a body with 8 contacts like", "damping time 6.19e-4 s", "at most 5e-5 s"]),
            (true, 1e12, ["its damping is the cause, GammaNormal", absurd, "critical damping of 1.8e4 kg/s"]),
            (
                false,
                1e12,
                ["its damping is the cause, GammaTangential", absurd, "critical damping of 1.8e4 kg/s"],
            ),
        ] {
            let mut trial = push(|trial| {
                trial.parameters.time_step_mechanical = 1e-4;
                let contact = &mut trial.materials.binary[2];
                *if normal { &mut contact.gamma_normal } else { &mut contact.gamma_tangential } = damping;
            });
            says(&trial, &words);
            if damping < 1e12 {
                trial.parameters.time_step_mechanical = Setup::of(&trial).proposed_step().unwrap();
                says(&trial, &[]);
            }
        }
    }

    #[test]
    fn disks_that_may_step_over_a_wall_are_warned_of() {
        // A radius of 0.095 m; 1 m/s is nothing.
        let mut trial = push(|trial| trial.parameters.time_step_mechanical = 1e-4);
        trial.dynamics[1].velocity.x = 1.0;
        says(&trial, &[]);
        trial.dynamics[1].velocity.x = 1500.0;
        says_besides(&trial, "a disk of agent \"1\" may move 1.5");
        says_besides(&trial, "at most 5e-6 s would be short enough");
        // By its drive, against the relaxation.
        trial.dynamics[1].velocity.x = 0.0;
        trial.dynamics[1].fp.y = 1500.0 * trial.agents[1].mass * trial.agents[1].floor_damping;
        says_besides(&trial, "step over a wall");
        // By turning.
        trial.dynamics[1].fp.y = 0.0;
        (trial.dynamics[1].omega, trial.dynamics[2].omega) = (1e4, 1e4);
        says_besides(&trial, "(2 agents may)");
    }
}
