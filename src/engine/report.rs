//! What the contacts are at an instant, for those who ask.

use super::contacts::{Memory, Stretch, touch};
use super::encounter::{Found, Instant, Touch};
use super::pairs::{FacePair, Pairs, spring_at_face};
use super::{BodyId, DiskId, FaceId, FacePart, Regime, Scene, Vec2, Wrench};

/// The two touching things.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pair {
    /// Two disks of different bodies.
    Disks {
        /// The disk that receives the force; of the body with the lower number.
        first: DiskId,
        /// The other disk.
        second: DiskId,
    },
    /// A disk and a face.
    Face {
        /// The disk that receives the force.
        disk: DiskId,
        /// The face.
        face: FaceId,
        /// The part of the face.
        part: FacePart,
    },
}

/// One contact, with the forces on the receiver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// The two touching things.
    pub pair: Pair,
    /// \[m\] overlap h.
    pub depth: f64,
    /// Towards the receiver.
    pub normal: Vec2,
    /// \[N\] force along the normal; negative if it pulls.
    pub normal_force: f64,
    /// \[N\] force along the tangent `normal.perp()`.
    pub tangential_force: f64,
    /// \[m\] elongation of the tangential spring, along the tangent.
    pub elongation: f64,
    /// \[m/s\] velocity of the receiver relative to the other, along the normal; positive if they separate.
    pub normal_speed: f64,
    /// \[m/s\] velocity of the receiver relative to the other, along the tangent.
    pub slip_speed: f64,
    /// Whether the contact sticks or slides.
    pub regime: Regime,
}

/// What the contacts do to one body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BodyContacts {
    /// Number of disk–disk contacts, including pairs whose centres coincide.
    pub agent_contacts: u32,
    /// Number of disk–face contacts, including those whose centres coincide.
    pub wall_contacts: u32,
    /// Number of bodies that touch this one.
    pub touching_bodies: u32,
    /// \[N\] sum of |F_n| over its contacts.
    pub squeeze: f64,
    /// The sum of the forces of its contacts, and of their torques about the centre of mass.
    pub wrench: Wrench,
}

impl BodyContacts {
    fn take(&mut self, wrench: &Wrench) {
        self.wrench.force += wrench.force;
        self.wrench.torque += wrench.torque;
    }
}

/// Every contact at one time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ContactReport {
    /// Disk pairs ascending, then disk–face pairs ascending.
    pub contacts: Vec<Contact>,
    /// One for each body.
    pub bodies: Vec<BodyContacts>,
    /// Number of disk–disk contacts, each pair once.
    pub agent_contacts: u32,
    /// Number of disk–face contacts.
    pub wall_contacts: u32,
    /// How many of these contacts have coinciding centres: no force acts between them.
    pub coincident: Vec<Pair>,
    /// \[m\] the deepest overlap; zero without contacts.
    pub largest_overlap: f64,
}

impl ContactReport {
    fn empty(bodies: usize) -> ContactReport {
        ContactReport { bodies: vec![BodyContacts::default(); bodies], ..ContactReport::default() }
    }

    /// Adds a contact and returns |F_n| \[N\].
    fn add(&mut self, pair: Pair, touch: &Touch) -> f64 {
        self.largest_overlap = self.largest_overlap.max(touch.overlap.depth);
        self.contacts.push(Contact {
            pair,
            depth: touch.overlap.depth,
            normal: touch.overlap.normal,
            normal_force: touch.reaction.normal,
            tangential_force: touch.reaction.tangential,
            elongation: touch.elongation,
            normal_speed: touch.normal_speed,
            slip_speed: touch.slip_speed,
            regime: touch.reaction.regime,
        });
        touch.reaction.normal.abs()
    }

    /// Adds a pair without a normal.
    fn add_coincident(&mut self, pair: Pair, depth: f64) -> f64 {
        self.largest_overlap = self.largest_overlap.max(depth);
        self.coincident.push(pair);
        0.0
    }

    /// Returns a body on which a force is not a finite number, if there is one.
    pub(super) fn not_finite(&self, scene: &Scene) -> Option<BodyId> {
        let finite =
            |contact: &&Contact| contact.normal_force.is_finite() && contact.tangential_force.is_finite();
        let contact = self.contacts.iter().find(|contact| !finite(contact));
        let receiver = contact.map(|contact| match contact.pair {
            Pair::Disks { first, .. } => scene.body_of(first),
            Pair::Face { disk, .. } => scene.body_of(disk),
        });
        receiver.or_else(|| self.bodies.iter().position(|body| !body.squeeze.is_finite()).map(BodyId::from))
    }
}

impl Instant<'_> {
    /// Returns the contacts of all blocks at present; changes nothing.
    pub fn report<'a>(&self, blocks: impl Iterator<Item = &'a Pairs> + Clone) -> ContactReport {
        let mut report = ContactReport::empty(self.scene.bodies.len());
        let mut touching_bodies = Vec::new();
        let memory = |spring| Memory { spring, before: self.before, stretch: Stretch::Hold };
        let disks = |pairs: &'a Pairs| pairs.disks.iter().zip(&pairs.disk_details).zip(&pairs.disk_springs);
        for ((pair, detail), spring) in blocks.clone().flat_map(disks) {
            let who = Pair::Disks { first: detail.first, second: detail.second };
            let squeeze = match self.meet_disks(pair, detail, &pair.seen(self.standing)) {
                Found::Apart => continue,
                Found::Coincident { depth, .. } => report.add_coincident(who, depth),
                Found::Touching(encounter) => {
                    let touch = touch(&encounter, memory(spring));
                    let force = touch.force();
                    report.bodies[pair.first_body.index()].take(&touch.on_receiver(force));
                    report.bodies[pair.second_body.index()].take(&touch.on_giver(force));
                    report.add(who, &touch)
                }
            };
            let bodies = [pair.first_body, pair.second_body];
            touching_bodies.push(bodies);
            for body in bodies {
                report.bodies[body.index()].agent_contacts += 1;
                report.bodies[body.index()].squeeze += squeeze;
            }
            report.agent_contacts += 1;
        }
        let faces = |pairs: &'a Pairs| (0..pairs.faces.len()).map(move |k| (pairs, k));
        for (pairs, k) in blocks.flat_map(faces) {
            let Pairs { faces, face_springs, .. } = pairs;
            let FacePair { disk, face } = faces[k];
            let who = |part| Pair::Face { disk, face, part };
            // Because of rounding, a body may now touch the next face of a straight wall.
            let held = |part| memory(spring_at_face(self.scene, faces, face_springs, k, part, self.before));
            let squeeze = match self.meet_face(&faces[k]) {
                Found::Apart => continue,
                Found::Coincident { depth, part } => report.add_coincident(who(part), depth),
                Found::Touching(encounter) => {
                    let touch = touch(&encounter, held(encounter.part));
                    let body = &mut report.bodies[self.scene.body_of(disk).index()];
                    body.take(&touch.on_receiver(touch.force()));
                    report.add(who(touch.part), &touch)
                }
            };
            let body = &mut report.bodies[self.scene.body_of(disk).index()];
            body.wall_contacts += 1;
            body.squeeze += squeeze;
            report.wall_contacts += 1;
        }
        touching_bodies.sort_unstable();
        touching_bodies.dedup();
        for bodies in touching_bodies {
            for body in bodies {
                report.bodies[body.index()].touching_bodies += 1;
            }
        }
        report
    }
}
