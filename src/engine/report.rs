//! Contacts at an instant, for those who ask.

use super::contact_geometry::{ContactForce, Instant};
use super::contacts::{SpringUpdate, contact_force};
use super::levels::ChestForce;
use super::near_pairs::NearPairs;
use super::overlap::{Proximity, proximity};
use super::wall_contacts::WallContacts;
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
    /// \[N\] force along the tangent `normal.left()`.
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

/// Effect of the contacts on one body.
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
    /// \[N\] the part of it by walls.
    pub wall_squeeze: f64,
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
    /// Contacts whose centres coincide: no force acts between them.
    pub coincident: Vec<Pair>,
    /// \[m\] the deepest overlap; zero without contacts.
    pub largest_overlap: f64,
    /// What the contacts do to the chests that are watched.
    pub(super) chest_forces: Vec<ChestForce>,
}

impl ContactReport {
    /// Adds a contact and returns |F_n| \[N\]; one without a force has no normal.
    fn add(&mut self, pair: Pair, depth: f64, force: Option<&ContactForce>) -> f64 {
        self.largest_overlap = self.largest_overlap.max(depth);
        let Some(force) = force else {
            self.coincident.push(pair);
            return 0.0;
        };
        self.contacts.push(Contact {
            pair,
            depth,
            normal: force.overlap.normal,
            normal_force: force.reaction.normal,
            tangential_force: force.reaction.tangential,
            elongation: force.reaction.elongation,
            normal_speed: force.normal_speed,
            slip_speed: force.slip_speed,
            regime: force.reaction.regime,
        });
        force.reaction.normal.abs()
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
    pub fn report<'a>(&self, blocks: impl Iterator<Item = &'a NearPairs> + Clone) -> ContactReport {
        let bodies = vec![BodyContacts::default(); self.scene.bodies.len()];
        let mut report = ContactReport { bodies, ..ContactReport::default() };
        let mut touching_bodies = Vec::new();
        let disks =
            |pairs: &'a NearPairs| pairs.disks.iter().zip(&pairs.disk_details).zip(&pairs.disk_springs);
        for ((pair, detail), spring) in blocks.clone().flat_map(disks) {
            let who = Pair::Disks { first: detail.first, second: detail.second };
            let separation = pair.separation(self.kinematics);
            let squeeze = match proximity(separation.between, pair.reach) {
                Proximity::Apart => continue,
                Proximity::Coincident => report.add(who, pair.reach, None),
                Proximity::Touching(overlap) => {
                    let spring = (spring.touched_at == self.before).then_some(spring);
                    let geometry = self.disk_geometry(pair, detail, &separation, overlap);
                    let force = contact_force(&geometry, spring, SpringUpdate::Hold);
                    let force = self.shared(force, who, &mut report);
                    let vector = force.vector();
                    report.bodies[pair.first_body.index()].take(&force.on_receiver(vector));
                    report.bodies[pair.second_body.index()].take(&force.on_giver(vector));
                    report.add(who, force.overlap.depth, Some(&force))
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
        for pairs in blocks {
            self.report_walls(pairs, &mut report);
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

    /// Returns the share of a force that acts where things have heights; and notes what it does to chests.
    fn shared(&self, mut force: ContactForce, pair: Pair, report: &mut ContactReport) -> ContactForce {
        let Some(levels) = &self.scene.levels else { return force };
        let share = self.scene.share(pair);
        if levels.watches_chests() {
            let who = match pair {
                Pair::Disks { first, second } => [first, second],
                Pair::Face { disk, .. } => [disk; 2],
            };
            let turn = |disk| self.kinematics[self.scene.body_of(disk).index()].turn();
            report.chest_forces.extend(levels.chest_forces(self.scene, who, turn, &force, None, share));
        }
        force.scale(share);
        force
    }

    /// Adds the contacts with walls.
    fn report_walls(&self, pairs: &NearPairs, report: &mut ContactReport) {
        let mut walls = WallContacts::default();
        let mut springs = &pairs.face_springs[..];
        for of_disk in pairs.faces.chunk_by(|one, next| one.disk == next.disk) {
            let (springs_of_disk, others) = springs.split_at(of_disk.len());
            springs = others;
            let (disk, body) = (self.circle(&of_disk[0]), self.scene.body_of(of_disk[0].disk));
            walls.find(self.scene, of_disk, disk, self.kinematics[body.index()].position);
            for contact in walls.found().iter().filter(|contact| contact.overlap.depth > 0.0) {
                let pair = of_disk[contact.place];
                let who = Pair::Face { disk: pair.disk, face: pair.face, part: contact.part };
                let squeeze = if contact.coincident {
                    report.add(who, contact.overlap.depth, None)
                } else {
                    // Because of rounding, a body may now touch the next face of a line.
                    let from =
                        walls.keeps(self.scene, of_disk, springs_of_disk, contact, disk.centre, self.before);
                    let geometry = self.face_geometry(&pair, contact.overlap, contact.part);
                    let spring = from.map(|from| &springs_of_disk[from]);
                    let force = contact_force(&geometry, spring, SpringUpdate::Hold);
                    let force = self.shared(force, who, report);
                    report.bodies[body.index()].take(&force.on_receiver(force.vector()));
                    report.add(who, force.overlap.depth, Some(&force))
                };
                let body = &mut report.bodies[body.index()];
                body.wall_contacts += 1;
                body.squeeze += squeeze;
                body.wall_squeeze += squeeze;
                report.wall_contacts += 1;
            }
        }
    }
}
