//! Contacts that began or ended within a mechanical step.
//!
//! The force of an evaluation counts for half a step before it and half a step after it. Where a contact began within
//! the step before, or ended within it, it lasted longer or shorter than that. The difference is given as an impulse:
//! else a force that jumps would make the integrator first order.

use super::Vec2;
use super::contact_law::{Reaction, normal_force, react};
use super::encounter::{Encounter, Instant, Touch};
use super::overlap::{COINCIDENT, Overlap, overlap_with_part, unit};
use super::pairs::{DiskPair, DiskPairDetail, FacePair, Spring};
use super::passing::{Passed, Passing};
use super::standing::velocity_at;

/// By how much the impulse of a contact that began or ended within a step differs from that of the evaluation next to
/// this time, whose forces count for half a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Amendment {
    /// \[N.s\] along the normal.
    pub normal: f64,
    /// \[N.s\] along the tangent.
    pub tangential: f64,
    /// \[N.s\] of |F_n|.
    pub squeeze: f64,
    /// \[N\] |F_n| when it began or ended.
    pub peak: f64,
}

/// How a contact began within a step.
struct Beginning {
    /// Its forces and its spring just after that.
    first: Reaction,
    /// \[s\] Time since then.
    since: f64,
    /// See [`Amendment::of`].
    whole: bool,
}

/// What happened to a contact within the last step.
struct Lately {
    /// When the receiver came to this part of a wall, if it did so.
    came: Option<Passed>,
    /// \[m/s\] What the other contacts added to the relative velocity in the last half step.
    half_kick: Vec2,
}

impl Instant<'_> {
    /// The contact of two disks that began within the last step, whose duration is `dt` \[s\].
    #[cold]
    #[inline(never)]
    pub fn began_disks(&self, pair: &DiskPair, encounter: &Encounter, dt: f64) -> (Touch, Amendment) {
        let first = velocity_at(&(self.unkicked)(pair.first_body), encounter.arm);
        let second = velocity_at(&(self.unkicked)(pair.second_body), encounter.other_arm);
        let half_kick = encounter.velocity - (first - second);
        began(encounter, Lately { came: None, half_kick }, dt)
    }

    /// The contact of a disk and a face that began within the last step.
    #[cold]
    #[inline(never)]
    pub fn began_face(&self, pair: &FacePair, encounter: &Encounter, dt: f64) -> (Touch, Amendment) {
        let body = self.scene.body_of(pair.disk);
        let half_kick = encounter.velocity - velocity_at(&(self.unkicked)(body), encounter.arm);
        let face = &self.scene.faces[pair.face.index()];
        let came = self.passing(pair, dt).coming(face, encounter.part);
        began(encounter, Lately { came, half_kick }, dt)
    }

    /// The contact of two disks, if it ended within the last step.
    #[cold]
    #[inline(never)]
    pub fn ended_disks(
        &self,
        pair: &DiskPair,
        detail: &DiskPairDetail,
        spring: &Spring,
        dt: f64,
    ) -> Option<(Touch, Amendment)> {
        let sight = pair.seen(self.standing);
        let distance = sight.between.norm();
        if distance <= COINCIDENT {
            return None;
        }
        let apart = Overlap { depth: pair.reach - distance, normal: unit(sight.between, distance) };
        ended(&self.disks_encounter(pair, detail, &sight, apart), spring, None, dt)
    }

    /// The contact of a disk and a face, if it ended within the last step.
    #[cold]
    #[inline(never)]
    pub fn ended_face(&self, pair: &FacePair, spring: &Spring, dt: f64) -> Option<(Touch, Amendment)> {
        let (disk, wall) = (&self.scene.disks[pair.disk.index()], &self.scene.faces[pair.face.index()]);
        let passing = self.passing(pair, dt);
        let apart = overlap_with_part(wall, spring.part, passing.centre, disk.radius)?;
        let left = passing.leaving(wall, spring.part);
        ended(&self.face_encounter(pair, apart, spring.part), spring, left, dt)
    }

    fn passing(&self, pair: &FacePair, dt: f64) -> Passing<'_> {
        let disk = &self.scene.disks[pair.disk.index()];
        let standing = &self.standing[disk.body.index()];
        let arm = standing.arm(disk.offset);
        let (centre, velocity) = (standing.position + arm, standing.velocity_at(arm));
        Passing { scene: self.scene, centre, velocity, dt }
    }
}

impl Amendment {
    /// For a contact that lasted a time \[s\] within a step, between its `edge` and the evaluation. `whole`: it began
    /// or ended there with all forces; else the disk passed around a corner, and its normal force went on.
    fn of(edge: &Reaction, evaluated: &Reaction, lasted: f64, dt: f64, whole: bool) -> Amendment {
        let over = |edge: f64, evaluated: f64| 0.5 * ((edge + evaluated) * lasted - evaluated * dt);
        let (tangential, peak) = (over(edge.tangential, evaluated.tangential), edge.normal.abs());
        if !whole {
            return Amendment { normal: 0.0, tangential, squeeze: 0.0, peak };
        }
        let squeeze = over(edge.normal.abs(), evaluated.normal.abs());
        Amendment { normal: over(edge.normal, evaluated.normal), tangential, squeeze, peak }
    }
}

fn began(encounter: &Encounter, lately: Lately, dt: f64) -> (Touch, Amendment) {
    let (normal_speed, slip_speed) = encounter.speeds();
    let normal = normal_force(encounter.law, encounter.overlap.depth, normal_speed);
    let Beginning { first, since, whole } = beginning(encounter, lately, dt);
    let elongation = first.elongation + slip_speed * since;
    let reaction = react(encounter.law, normal, slip_speed, elongation);
    (encounter.touch(elongation, reaction), Amendment::of(&first, &reaction, since, dt, whole))
}

fn beginning(encounter: &Encounter, lately: Lately, dt: f64) -> Beginning {
    let Encounter { law, overlap, velocity, .. } = *encounter;
    let (depth, normal_speed) = (overlap.depth, velocity.dot(overlap.normal));
    // Deeper than it can have come in a step: other contacts turned it, and when it began is not known.
    let known = -2.0 * normal_speed * dt > depth;
    let touched = if known { dt.min(depth / -normal_speed) } else { 0.5 * dt };
    let came = lately.came.filter(|came| came.since < touched || !known);
    let (since, whole) = came.map_or((touched, true), |came| (came.since, !came.around));
    // In the instant in which it begins it may slide, and then stick: the damping forces are there at once.
    let then = velocity - lately.half_kick * (since / (0.5 * dt));
    let depth = if known || came.is_some() { depth + normal_speed * since } else { depth };
    let normal = normal_force(law, depth, then.dot(overlap.normal));
    let first = react(law, normal, then.dot(overlap.normal.perp()), 0.0);
    Beginning { first, since, whole }
}

/// A contact that ended within a step, at its end. `encounter` is what the two would have now. `left` says when
/// the receiver left this part of a wall, if it did so within the step.
fn ended(
    encounter: &Encounter,
    spring: &Spring,
    left: Option<Passed>,
    dt: f64,
) -> Option<(Touch, Amendment)> {
    let Encounter { law, overlap, .. } = *encounter;
    let (normal_speed, slip_speed) = encounter.speeds();
    let gap = -overlap.depth;
    let parted = (gap >= 0.0 && normal_speed > 0.0).then(|| dt.min(gap / normal_speed));
    let (since, whole) = match (left, parted) {
        (Some(left), Some(parted)) => (left.since.max(parted), parted >= left.since || !left.around),
        (Some(left), None) => (left.since, !left.around),
        (None, Some(parted)) => (parted, true),
        (None, None) => return None,
    };
    let (grip, lasted) = (spring.grip, dt - since);
    let depth = (overlap.depth + normal_speed * since).max(0.0);
    let normal = normal_force(law, depth, normal_speed);
    let elongation = grip.stretched(law, normal, slip_speed, lasted);
    let reaction = react(law, normal, slip_speed, elongation);
    let evaluated = react(law, grip.normal, grip.slip_speed, grip.elongation);
    Some((encounter.touch(elongation, reaction), Amendment::of(&reaction, &evaluated, lasted, dt, whole)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::contact_law::Grip;
    use crate::engine::{FacePart, PairLaw, vec2};

    static LAW: PairLaw = PairLaw {
        normal_stiffness: 2e6,
        tangential_stiffness: 1e6,
        normal_damping: 1000.0,
        tangential_damping: 1000.0,
        friction: 0.5,
    };
    const DT: f64 = 1e-4;

    /// The other is below.
    fn encounter(depth: f64, velocity: Vec2) -> Encounter<'static> {
        let overlap = Overlap { depth, normal: vec2(0.0, 1.0) };
        let (arm, other_arm) = (Vec2::ZERO, Vec2::ZERO);
        Encounter { law: &LAW, overlap, part: FacePart::Left, arm, other_arm, velocity }
    }

    /// It came around a corner some time \[s\] ago.
    fn lately(came: Option<f64>) -> Lately {
        Lately { came: came.map(|since| Passed { since, around: true }), half_kick: Vec2::ZERO }
    }

    #[test]
    fn a_contact_counts_from_the_time_when_it_began() {
        // 25 µm deep at 1 m/s: it has lasted a quarter of the step. The tangent points to the left.
        let Beginning { first, since, whole } =
            beginning(&encounter(2.5e-5, vec2(-0.4, -1.0)), lately(None), DT);
        assert!((since - 0.25 * DT).abs() < 1e-18 && whole);
        assert!((first.normal - 1000.0).abs() < 1e-9 && (first.tangential + 400.0).abs() < 1e-9);
        // From 1000 N to 1050 N; half a step of 1050 N counts anyhow.
        let now = Reaction { normal: 1050.0, ..first };
        let Amendment { normal, squeeze, .. } = Amendment::of(&first, &now, since, DT, whole);
        assert!((normal - (1025.0 * 0.25 - 1050.0 * 0.5) * DT).abs() < 1e-15);
        assert_eq!(squeeze, normal);
    }

    #[test]
    fn a_contact_may_slip_in_its_first_instant() {
        let Beginning { first, .. } = beginning(&encounter(2.5e-5, vec2(-0.8, -1.0)), lately(None), DT);
        // From 800 N of damping to the limit of 500 N.
        assert!((first.elongation - (500.0 - 800.0) / 1e6).abs() < 1e-15);
        // The others' contacts have pushed it since: at first it was as slow as in the test before.
        let pushed = Lately { came: None, half_kick: vec2(-0.8, 0.0) };
        let Beginning { first, .. } = beginning(&encounter(2.5e-5, vec2(-0.8, -1.0)), pushed, DT);
        assert_eq!(first.elongation, 0.0);
    }

    #[test]
    fn at_a_corner_the_normal_force_goes_on() {
        let Beginning { first, since, whole } =
            beginning(&encounter(3e-3, vec2(0.4, -1.0)), lately(Some(0.1 * DT)), DT);
        assert!((since - 0.1 * DT).abs() < 1e-18 && !whole);
        let amendment = Amendment::of(&first, &first, since, DT, whole);
        assert_eq!((amendment.normal, amendment.squeeze), (0.0, 0.0));
        assert!((amendment.tangential + 0.4 * DT * first.tangential).abs() < 1e-15);
        // Inside of a corner it begins with all its force.
        let came = Some(Passed { since: 0.1 * DT, around: false });
        let inside = beginning(&encounter(3e-3, vec2(0.4, -1.0)), Lately { came, half_kick: Vec2::ZERO }, DT);
        assert!(inside.whole && inside.first.normal == first.normal);
        // It came to this part of the wall before it touched it.
        let before = beginning(&encounter(2.5e-5, vec2(0.4, -1.0)), lately(Some(0.9 * DT)), DT);
        assert!((before.since - 0.25 * DT).abs() < 1e-18 && before.whole);
    }

    #[test]
    fn a_contact_counts_until_the_time_when_it_ended() {
        let grip = Grip { elongation: 1e-5, slip_speed: 0.0, normal: -900.0 };
        let spring = Spring { grip, part: FacePart::Left, touched_at: 1 };
        let ended = |gap: f64, speed: f64| ended(&encounter(-gap, vec2(0.0, speed)), &spring, None, DT);
        // 75 µm away at 1 m/s: it ended three quarters of the step ago, when it pulled with 1000 N.
        let (touch, amendment) = ended(7.5e-5, 1.0).unwrap();
        assert!((touch.reaction.normal + 1000.0).abs() < 1e-9);
        // From −900 N to −1000 N over a quarter of the step; half a step of −900 N has counted.
        assert!((amendment.normal + (950.0 * 0.25 - 900.0 * 0.5) * DT).abs() < 1e-13);
        assert!((amendment.squeeze - (950.0 * 0.25 - 900.0 * 0.5) * DT).abs() < 1e-13);
        assert_eq!(touch.reaction.tangential, -1e6 * 1e-5);
        // Not longer ago than it was seen.
        assert!((ended(1.0, 1.0).unwrap().1.normal - 0.5 * DT * 900.0).abs() < 1e-13);
        // It comes back: when it ended is not known.
        assert!(ended(1e-5, -1.0).is_none());
    }
}
