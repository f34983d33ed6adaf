//! Contacts that began or ended within a mechanical step.
//!
//! The force of an evaluation counts for half a step before it and half a step after it. Where a contact began within
//! the step before, or ended within it, it lasted longer or shorter than that. The difference is given as an impulse:
//! else a force that jumps would make the integrator first order.

use super::contact_geometry::{ContactForce, ContactGeometry, Instant};
use super::contact_law::{Reaction, Relaxation, SpringHistory, normal_force, react};
use super::corner_transition::CornerTransition;
use super::near_pairs::{DiskPair, DiskPairDetail, FacePair, Spring};
use super::overlap::{COINCIDENT, Overlap, overlap_with_part, unit};
use super::wall_contacts::WallContact;

/// Normals that differ by less \[1\] have no jump between them.
const SMOOTH: f64 = 1e-6;

/// By how much the impulse of a contact that began or ended within a step differs from that of the evaluation next to
/// this time, whose forces count for half a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ImpulseCorrection {
    /// \[N.s\] along the normal.
    pub normal: f64,
    /// \[N.s\] along the tangent.
    pub tangential: f64,
    /// \[N.s\] of |F_n|.
    pub squeeze: f64,
    /// \[N\] |F_n| when it began or ended.
    pub peak: f64,
}

/// When a contact began or ended within the last step.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ContactEvent {
    /// \[s\] Time since then.
    since: f64,
    /// \[m\] The depth at that time.
    depth: f64,
    /// Whether all of its forces began or ended there; else the disk passed around a corner, and its normal force went
    /// on.
    whole: bool,
}

impl Instant<'_> {
    /// The contact of two disks that began within the last step, whose duration is `dt` \[s\].
    #[cold]
    #[inline(never)]
    pub fn disks_began(&self, geometry: &ContactGeometry, dt: f64) -> (ContactForce, ImpulseCorrection) {
        let rate = -geometry.speeds().0;
        began(geometry, beginning(geometry.overlap.depth, rate, None, dt), 0.0, dt)
    }

    /// The contact of a disk and a face that began within the last step.
    #[cold]
    #[inline(never)]
    pub fn face_began(
        &self,
        pair: &FacePair,
        contact: &WallContact,
        geometry: &ContactGeometry,
        dt: f64,
    ) -> (ContactForce, ImpulseCorrection) {
        let transition = self.transition(pair, dt);
        let came = transition.coming(&self.scene.faces[pair.face.index()], contact.part);
        let rate = -transition.velocity.dot(&contact.gradient);
        began(geometry, beginning(contact.overlap.depth, rate, came, dt), 0.0, dt)
    }

    /// The contact of two disks, if it ended within the last step.
    #[cold]
    #[inline(never)]
    pub fn disks_ended(
        &self,
        pair: &DiskPair,
        detail: &DiskPairDetail,
        spring: &Spring,
        dt: f64,
    ) -> Option<(ContactForce, ImpulseCorrection)> {
        let separation = pair.separation(self.kinematics);
        let distance = separation.between.norm();
        if distance <= COINCIDENT {
            return None;
        }
        let apart = Overlap { depth: pair.reach - distance, normal: unit(separation.between, distance) };
        let geometry = self.disk_geometry(pair, detail, &separation, apart);
        let event = end(apart.depth, -geometry.speeds().0, None, dt)?;
        Some(ended(&geometry, spring, event, dt))
    }

    /// The contact of a disk and a face, if it ended within the last step. `held`: the other face of an inner corner
    /// holds the disk alone now.
    #[cold]
    #[inline(never)]
    pub fn face_ended(
        &self,
        pair: &FacePair,
        held: Option<&WallContact>,
        spring: &Spring,
        dt: f64,
    ) -> Option<(ContactForce, ImpulseCorrection)> {
        let transition = self.transition(pair, dt);
        let (overlap, rate, left) = match held {
            Some(contact) => (contact.overlap, -transition.velocity.dot(&contact.gradient), None),
            None => {
                let (disk, wall) =
                    (&self.scene.disks[pair.disk.index()], &self.scene.faces[pair.face.index()]);
                let apart = overlap_with_part(wall, spring.part, transition.centre, disk.radius)?;
                (apart, -transition.velocity.dot(&apart.normal), transition.leaving(wall, spring.part))
            }
        };
        let event = end(overlap.depth, rate, left, dt)?;
        Some(ended(&self.face_geometry(pair, overlap, spring.part), spring, event, dt))
    }

    /// A contact that passed within the last step from one face of a line to another, on the inner side of a bend: what
    /// ended at the one and began at the other. None if it passed on without a jump of the normal.
    #[inline(never)]
    pub fn passed_bend(
        &self,
        [from, to]: [&FacePair; 2],
        contact: &WallContact,
        spring: &Spring,
        dt: f64,
    ) -> Option<[(ContactForce, ImpulseCorrection); 2]> {
        let left = &self.scene.faces[from.face.index()];
        let (transition, radius) = (self.transition(from, dt), self.scene.disks[from.disk.index()].radius);
        let before = overlap_with_part(left, spring.part, transition.centre, radius)?;
        let turn = before.normal - contact.overlap.normal;
        // Since both were equally near.
        let (lead, rate) = (contact.overlap.depth - before.depth, transition.velocity.dot(&turn));
        if turn.norm_squared() <= SMOOTH * SMOOTH || lead <= 0.0 || rate * dt <= lead {
            return None;
        }
        let since = lead / rate;
        let event =
            |depth: f64, normal: f64| ContactEvent { since, depth: depth + normal * since, whole: true };
        let [ending, beginning] = [(from, before, spring.part), (to, contact.overlap, contact.part)]
            .map(|(pair, overlap, part)| self.face_geometry(pair, overlap, part));
        let ended = ended(&ending, spring, event(before.depth, ending.speeds().0), dt);
        let began = began(
            &beginning,
            event(contact.overlap.depth, beginning.speeds().0),
            ended.0.reaction.elongation,
            dt,
        );
        Some([ended, began])
    }

    fn transition(&self, pair: &FacePair, dt: f64) -> CornerTransition<'_> {
        let disk = &self.scene.disks[pair.disk.index()];
        let kinematics = &self.kinematics[disk.body.index()];
        let arm = kinematics.arm(disk.offset);
        let (centre, velocity) = (kinematics.position + arm, kinematics.velocity_at(arm));
        CornerTransition { scene: self.scene, centre, velocity, dt }
    }
}

impl ImpulseCorrection {
    /// Takes a share of the forces.
    pub fn scale(&mut self, share: f64) {
        for value in [&mut self.normal, &mut self.tangential, &mut self.squeeze, &mut self.peak] {
            *value *= share;
        }
    }

    /// For a contact that lasted a time \[s\] within a step, between its event and the evaluation;
    /// see [`ContactEvent::whole`].
    fn of(event: &Reaction, evaluated: &Reaction, lasted: f64, dt: f64, whole: bool) -> ImpulseCorrection {
        let over = |event: f64, evaluated: f64| 0.5 * ((event + evaluated) * lasted - evaluated * dt);
        let (tangential, peak) = (over(event.tangential, evaluated.tangential), event.normal.abs());
        if !whole {
            return ImpulseCorrection { normal: 0.0, tangential, squeeze: 0.0, peak };
        }
        let squeeze = over(event.normal.abs(), evaluated.normal.abs());
        ImpulseCorrection { normal: over(event.normal, evaluated.normal), tangential, squeeze, peak }
    }
}

/// A contact that began within a step, with a spring of this elongation \[m\].
fn began(
    geometry: &ContactGeometry,
    event: ContactEvent,
    elongation: f64,
    dt: f64,
) -> (ContactForce, ImpulseCorrection) {
    let ContactGeometry { law, overlap, .. } = *geometry;
    let (normal_speed, slip_speed) = geometry.speeds();
    let first = react(law, normal_force(law, event.depth, normal_speed), slip_speed, elongation);
    let normal = normal_force(law, overlap.depth, normal_speed);
    let history = SpringHistory::after(law, &first, slip_speed);
    let relaxation = Relaxation::over(law, event.since);
    let reaction = history.advanced(law, normal, slip_speed, event.since, &relaxation);
    (geometry.with(reaction), ImpulseCorrection::of(&first, &reaction, event.since, dt, event.whole))
}

/// When a contact began whose depth \[m\] grows at a rate \[m/s\]. `came` \[s\] is the time since the receiver came to
/// this part of a wall, if it did so within the step.
fn beginning(depth: f64, rate: f64, came: Option<f64>, dt: f64) -> ContactEvent {
    // Deeper than it can have come in a step: other contacts turned it, and when it began is not known.
    let known = 2.0 * rate * dt > depth;
    let touched = if known { dt.min(depth / rate) } else { 0.5 * dt };
    let came = came.filter(|came| *came < touched || !known);
    let since = came.unwrap_or(touched);
    let depth = if known || came.is_some() { depth - rate * since } else { depth };
    ContactEvent { since, depth, whole: came.is_none() }
}

/// A contact that ended within a step, at its end. `geometry` is what the two would have now.
fn ended(
    geometry: &ContactGeometry,
    spring: &Spring,
    event: ContactEvent,
    dt: f64,
) -> (ContactForce, ImpulseCorrection) {
    let law = geometry.law;
    let (normal_speed, slip_speed) = geometry.speeds();
    let (history, lasted) = (spring.history, dt - event.since);
    let normal = normal_force(law, event.depth.max(0.0), normal_speed);
    let reaction = history.advanced(law, normal, slip_speed, lasted, &Relaxation::over(law, lasted));
    let evaluated = Reaction { normal: history.normal, tangential: history.tangential(law), ..reaction };
    (geometry.with(reaction), ImpulseCorrection::of(&reaction, &evaluated, lasted, dt, event.whole))
}

/// When a contact ended whose depth \[m\], now negative, grows at a rate \[m/s\]. `left` \[s\] is the time since the
/// receiver left this part of a wall, if it did so within the step.
fn end(depth: f64, rate: f64, left: Option<f64>, dt: f64) -> Option<ContactEvent> {
    let parted = (depth <= 0.0 && rate < 0.0).then(|| dt.min(depth / rate));
    let (since, whole) = match (left, parted) {
        (Some(left), Some(parted)) => (left.max(parted), parted >= left),
        (Some(left), None) => (left, false),
        (None, Some(parted)) => (parted, true),
        (None, None) => return None,
    };
    Some(ContactEvent { since, depth: depth - rate * since, whole })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{FacePart, PairLaw, Vec2, vec2};

    static LAW: PairLaw = PairLaw {
        normal_stiffness: 2e6,
        tangential_stiffness: 1e6,
        normal_damping: 1000.0,
        tangential_damping: 1000.0,
        friction: 0.5,
    };
    const DT: f64 = 1e-4;

    /// The other is below.
    fn geometry(depth: f64, velocity: Vec2) -> ContactGeometry<'static> {
        let overlap = Overlap { depth, normal: vec2(0.0, 1.0) };
        let (arm, other_arm) = (Vec2::zeros(), Vec2::zeros());
        ContactGeometry { law: &LAW, law_at: 0, overlap, part: FacePart::Left, arm, other_arm, velocity }
    }

    #[test]
    fn a_contact_counts_from_the_time_when_it_began() {
        // 25 µm deep at 1 m/s: it has lasted a quarter of the step. The tangent points to the left.
        let event = beginning(2.5e-5, 1.0, None, DT);
        assert!((event.since - 0.25 * DT).abs() < 1e-18 && event.whole && event.depth.abs() < 1e-18);
        let (force, ImpulseCorrection { normal, squeeze, tangential, .. }) =
            began(&geometry(2.5e-5, vec2(-0.4, -1.0)), event, 0.0, DT);
        // From 1000 N to 1050 N; half a step of 1050 N counts anyhow.
        assert!((force.reaction.normal - 1050.0).abs() < 1e-9);
        assert!((normal - (1025.0 * 0.25 - 1050.0 * 0.5) * DT).abs() < 1e-12);
        assert_eq!(squeeze, normal);
        // The damper is there at once, the spring is stretched since.
        assert!((force.reaction.elongation - 0.4 * 0.25 * DT).abs() < 1e-18);
        assert!((force.reaction.tangential + 410.0).abs() < 1e-9);
        assert!((tangential + (405.0 * 0.25 - 410.0 * 0.5) * DT).abs() < 1e-12);
    }

    /// A spring that begins does not jump: where the damper alone exceeds the limit, it relaxes under the limit.
    #[test]
    fn a_contact_may_slide_from_its_first_instant() {
        let event = beginning(2.5e-5, 1.0, None, DT);
        let (force, _) = began(&geometry(2.5e-5, vec2(-0.8, -1.0)), event, 0.0, DT);
        // 800 N of damping and a limit of 500 N to 525 N: γ_t ds/dt = F − k_t s.
        let (x, slope): (f64, f64) = (1e6 * 0.25 * DT / 1000.0, 25e-6 / (0.25 * DT) / 1000.0);
        let steady = |time: f64| 500e-6 + slope * 1000.0 * time - slope;
        let expected = steady(0.25 * DT) - steady(0.0) * (-x).exp();
        assert!((force.reaction.elongation - expected).abs() < 1e-12, "{:?} {expected}", force.reaction);
        assert!((force.reaction.tangential + 525.0).abs() < 1e-9);
    }

    #[test]
    fn at_a_corner_the_normal_force_goes_on() {
        let event = beginning(3e-3, 1.0, Some(0.1 * DT), DT);
        assert!((event.since - 0.1 * DT).abs() < 1e-18 && !event.whole);
        let (force, correction) = began(&geometry(3e-3, vec2(0.4, -1.0)), event, 0.0, DT);
        assert_eq!((correction.normal, correction.squeeze), (0.0, 0.0));
        let (first, now) = (400.0, force.reaction.tangential);
        assert!((correction.tangential - (0.5 * (first + now) * 0.1 - 0.5 * now) * DT).abs() < 1e-12);
        // It came to this part of the wall before it touched it.
        let before = beginning(2.5e-5, 1.0, Some(0.9 * DT), DT);
        assert!((before.since - 0.25 * DT).abs() < 1e-18 && before.whole);
    }

    #[test]
    fn a_contact_counts_until_the_time_when_it_ended() {
        let history = SpringHistory { elongation: 1e-5, rate: 0.0, normal: -900.0 };
        let spring = Spring { history, part: FacePart::Left, touched_at: 1 };
        let ended = |gap: f64, speed: f64| {
            Some(super::ended(&geometry(-gap, vec2(0.0, speed)), &spring, end(-gap, -speed, None, DT)?, DT))
        };
        // 75 µm away at 1 m/s: it ended three quarters of the step ago, when it pulled with 1000 N.
        let (force, correction) = ended(7.5e-5, 1.0).unwrap();
        assert!((force.reaction.normal + 1000.0).abs() < 1e-9);
        // From −900 N to −1000 N over a quarter of the step; half a step of −900 N has counted.
        assert!((correction.normal + (950.0 * 0.25 - 900.0 * 0.5) * DT).abs() < 1e-13);
        assert!((correction.squeeze - (950.0 * 0.25 - 900.0 * 0.5) * DT).abs() < 1e-13);
        assert_eq!(force.reaction.tangential, -1e6 * 1e-5);
        // Not longer ago than it was seen.
        assert!((ended(1.0, 1.0).unwrap().1.normal - 0.5 * DT * 900.0).abs() < 1e-13);
        // It comes back: when it ended is not known.
        assert!(ended(1e-5, -1.0).is_none());
    }
}
