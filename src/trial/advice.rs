//! What may be a mistake in a Trial that is otherwise in order.

use super::problem::{Problem, Severity, quoted};
use super::{Contact, Material, Trial, WorldError, stiffness};
use crate::engine::{ContactReport, DiskId, Pair, Scene};
use std::collections::HashSet;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

/// A mechanical step longer than this share of the shortest contact period is warned of: beyond about a
/// third of it the integration is unstable, and contacts in a dense crowd share bodies.
const LONGEST_SHARE: f64 = 1.0 / 20.0;

/// The share of the shortest contact period that is proposed instead.
const PROPOSED_SHARE: f64 = 1.0 / 50.0;

/// The share of the shortest time in which a contact's damping stops a motion that is proposed at most: twice that
/// time would be unstable.
const PROPOSED_DAMPING_SHARE: f64 = 1.0 / 10.0;

impl Trial {
    /// Warnings: overlaps at the start that no spring of an earlier step explains, and a mechanical step
    /// that does not resolve the shortest contact.
    pub(super) fn advice(&self, parameters: &Path, dynamics: &Path) -> Vec<Problem> {
        let world = match self.world() {
            Ok(world) => world,
            Err(crowded @ WorldError::Crowded { .. }) => {
                return vec![Problem {
                    severity: Severity::Error,
                    ..warning(dynamics, None, crowded.to_string())
                }];
            }
            // Materials that cannot touch were reported as errors already.
            Err(_) => return Vec::new(),
        };
        let scene = world.scene();
        let mut advice = self.overlaps(scene, world.contacts(), dynamics);
        advice.extend(self.coarse_step(scene, parameters));
        advice
    }

    /// The same of a Trial whose numbers were edited since it was read, as lines.
    pub fn advice_as_edited(&self) -> Vec<String> {
        let of = |name: &str| PathBuf::from(format!("{} ({name}, with the parameters as set)", self.name));
        let advice = self.advice(&of("Parameters.xml"), &of("AgentDynamics.xml"));
        advice.iter().map(ToString::to_string).collect()
    }

    fn overlaps(&self, scene: &Scene, contacts: &ContactReport, file: &Path) -> Vec<Problem> {
        let state = self.state(scene);
        let known_disks: HashSet<_> =
            state.disk_springs.iter().map(|spring| (spring.first, spring.second)).collect();
        let known_faces: HashSet<_> =
            state.face_springs.iter().map(|spring| (spring.disk, spring.face)).collect();
        let agent = |disk: DiskId| quoted(&self.agents[scene.body_of(disk).index()].id);
        let (mut among_agents, mut with_walls) = (Deepest::default(), Deepest::default());
        for contact in &contacts.contacts {
            match contact.pair {
                Pair::Disks { first, second } if !known_disks.contains(&(first, second)) => {
                    among_agents
                        .see(contact.depth, || format!("agents {} and {}", agent(first), agent(second)));
                }
                Pair::Face { disk, face, .. } if !known_faces.contains(&(disk, face)) => {
                    let wall = &self.geometry.walls[scene.faces[face.index()].wall.index()];
                    with_walls.see(contact.depth, || {
                        format!("agent {} and wall {}", agent(disk), quoted(&wall.id))
                    });
                }
                _ => {}
            }
        }
        let said = [among_agents.says("disks of different agents"), with_walls.says("disks and walls")];
        said.into_iter().flatten().map(|message| warning(file, None, message)).collect()
    }

    fn coarse_step(&self, scene: &Scene, file: &Path) -> Option<Problem> {
        let step = self.parameters.time_step_mechanical;
        let Fastest { period, pair, .. } = self.fastest_contacts(scene)?;
        if step <= LONGEST_SHARE * period {
            return None;
        }
        let message = format!(
            "is long for the shortest contact period, {period:.2e} s ({pair}): at most {:e} s would resolve it",
            rounded_down(PROPOSED_SHARE * period)
        );
        Some(warning(file, Some(("Times", "TimeStepMechanical", step)), message))
    }

    /// \[s\] A mechanical step that resolves every contact that these agents and walls can have; `None` if nothing can
    /// touch.
    ///
    /// A contact moves the points that touch as a spring moves an effective mass m\\*, 1/m\\* = Σ (1/m + R²/I) over the
    /// bodies in contact (walls do not move), R from the centre of mass to the rim. The step is a fiftieth of the
    /// shortest period 2π √(m\\*/k), k the stiffer of the two springs, or a tenth of the shortest damping time m\\*/γ
    /// where that is less, rounded down to 1, 2 or 5 times a power of ten.
    pub fn proposed_step(&self) -> Option<f64> {
        let Fastest { period, damping, .. } = self.fastest_contacts(&self.scene().ok()?)?;
        Some(rounded_down((PROPOSED_SHARE * period).min(PROPOSED_DAMPING_SHARE * damping)))
    }

    /// `None` if nothing can touch.
    fn fastest_contacts(&self, scene: &Scene) -> Option<Fastest> {
        let placed = self.materials_placed(&self.material_places());
        let materials = placed.len();
        // The two lightest agents that carry each material: a contact may be between two of a kind.
        let mut lightest: Vec<[Option<(f64, usize)>; 2]> = vec![[None; 2]; materials];
        for (b, body) in scene.bodies.iter().enumerate() {
            // How easily a force at the body's rim moves the point it acts on.
            let lightness = 1.0 / body.mass + body.bounding_radius * body.bounding_radius / body.inertia;
            let mut carried: Vec<usize> = body.disks.clone().map(|disk| scene.disks[disk].material).collect();
            carried.sort_unstable();
            carried.dedup();
            for material in carried {
                let [first, second] = &mut lightest[material];
                if first.is_none_or(|(other, _)| lightness > other) {
                    *second = first.replace((lightness, b));
                } else if second.is_none_or(|(other, _)| lightness > other) {
                    *second = Some((lightness, b));
                }
            }
        }
        let id = |b: usize| quoted(&self.agents[b].id);
        let mut fastest: Option<Fastest> = None;
        let mut consider = |first: usize, second: usize, lightness: f64, whose: &dyn Fn() -> String| {
            let (normal, tangential) = stiffness(placed[first], placed[second]);
            let period = TAU / (normal.max(tangential) * lightness).sqrt();
            let damping = 1.0 / (self.strongest_damping(placed[first], placed[second]) * lightness);
            match &mut fastest {
                None => fastest = Some(Fastest { period, pair: whose(), damping }),
                Some(fastest) => {
                    if period < fastest.period {
                        (fastest.period, fastest.pair) = (period, whose());
                    }
                    fastest.damping = fastest.damping.min(damping);
                }
            }
        };
        for first in 0..materials {
            let Some((lightness, a)) = lightest[first][0] else { continue };
            for (second, carriers) in lightest.iter().enumerate().skip(first) {
                let other = carriers.iter().flatten().find(|(_, b)| *b != a);
                if let Some(&(other, b)) = other {
                    consider(first, second, lightness + other, &|| format!("agents {} and {}", id(a), id(b)));
                }
            }
            for (wall, faces) in self.geometry.walls.iter().zip(&scene.wall_faces) {
                let material = scene.faces[faces.start].material;
                consider(first, material, lightness, &|| {
                    format!("agent {} and wall {}", id(a), quoted(&wall.id))
                });
            }
        }
        fastest
    }

    /// \[kg/s\] between two materials, along the normal or the tangent.
    fn strongest_damping(&self, first: &Material, second: &Material) -> f64 {
        let of_pair = |contact: &&Contact| {
            (contact.id1 == first.id && contact.id2 == second.id)
                || (contact.id1 == second.id && contact.id2 == first.id)
        };
        let contact = self.materials.binary.iter().find(of_pair);
        contact.map_or(0.0, |contact| contact.gamma_normal.max(contact.gamma_tangential))
    }
}

/// What a mechanical step must resolve.
struct Fastest {
    /// \[s\] the shortest period of a contact's springs.
    period: f64,
    /// Whose it is.
    pair: String,
    /// \[s\] the shortest time in which a contact's damping slows a motion to 1/e; infinite without damping.
    damping: f64,
}

/// How many overlaps there are, and the deepest.
#[derive(Default)]
struct Deepest {
    count: usize,
    depth: f64,
    whose: String,
}

impl Deepest {
    fn see(&mut self, depth: f64, whose: impl FnOnce() -> String) {
        self.count += 1;
        if depth > self.depth {
            self.depth = depth;
            self.whose = whose();
        }
    }

    fn says(&self, what: &str) -> Option<String> {
        let pairs = if self.count == 1 { "pair" } else { "pairs" };
        let (count, depth, whose) = (self.count, 1e3 * self.depth, &self.whose);
        (count > 0).then(|| {
            format!("{count} {pairs} of {what} overlap at the start, the deepest by {depth:.3} mm ({whose})")
        })
    }
}

/// To 1, 2 or 5 times a power of ten.
fn rounded_down(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    let lead = [5.0, 2.0].into_iter().find(|lead| lead * power <= value).unwrap_or(1.0);
    lead * power
}

fn warning(file: &Path, subject: Option<(&str, &str, f64)>, message: String) -> Problem {
    Problem {
        severity: Severity::Warning,
        file: file.to_owned(),
        line: None,
        element: subject.map(|(element, _, _)| element.into()),
        attribute: subject.map(|(_, attribute, _)| attribute.into()),
        value: subject.map(|(_, _, value)| format!("{value:?}")),
        message,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn push() -> Trial {
        let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("resources/Trial_push");
        Trial::read(&directory).expect("the default Trial is in order").0
    }

    fn said(trial: &Trial) -> Vec<String> {
        let advice = trial.advice(Path::new("Parameters.xml"), Path::new("AgentDynamics.xml"));
        advice.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn nothing_to_say_of_the_default_trial() {
        assert_eq!(said(&push()), [""; 0]);
    }

    #[test]
    fn overlaps_are_counted_and_the_deepest_named() {
        let mut trial = push();
        trial.dynamics[1].position.x = 0.2;
        let said = said(&trial);
        assert_eq!(said.len(), 1);
        assert!(said[0].starts_with("warning: AgentDynamics.xml: "), "{said:?}");
        assert!(said[0].contains("(agents \"0\" and \"1\")"), "{said:?}");
        trial.dynamics[1].position.x = 0.279;
        trial.dynamics[4].position.x = 1.7;
        let said = super::tests::said(&trial);
        assert!(said[0].contains("(agent \"4\" and wall \"0\")"), "{said:?}");
    }

    #[test]
    fn a_coarse_step_is_named_with_one_that_would_do() {
        let mut trial = push();
        trial.parameters.time_step_mechanical = 0.002;
        let said = said(&trial);
        assert_eq!(said.len(), 1);
        assert!(said[0].contains("<Times> TimeStepMechanical=\"0.002\": is long for"), "{said:?}");
        // k_n = 4.99e6 N/m; 1/63 kg + (0.2225 m)²/1.02 kg.m2: a period of 11 ms.
        assert!(said[0].contains("at most 2e-4 s"), "{said:?}");
        trial.parameters.time_step_mechanical = 2e-4;
        assert_eq!(super::tests::said(&trial), [""; 0]);
    }

    #[test]
    fn the_proposed_step_resolves_springs_and_dampers() {
        let mut trial = push();
        // As warned of above.
        assert_eq!(trial.proposed_step(), Some(2e-4));
        // 1/m* of agent 1 and a wall is 0.0644/kg: with 1e6 kg/s a time of 15.5 µs, a tenth of it 1.55 µs.
        trial.materials.binary[2].gamma_tangential = 1e6;
        assert_eq!(trial.proposed_step(), Some(1e-6));
        trial.geometry.walls.clear();
        trial.agents.truncate(1);
        assert_eq!(trial.proposed_step(), None);
    }

    #[test]
    fn rounding_goes_down() {
        assert_eq!(rounded_down(0.000_73), 0.000_5);
        assert_eq!(rounded_down(0.3), 0.2);
        assert_eq!(rounded_down(1.9), 1.0);
    }
}
