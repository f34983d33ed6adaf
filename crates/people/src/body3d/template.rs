//! The landmark outlines of a person: from the survey, or from common proportions where the survey has no data.
//!
//! The survey has girths of flexed arms, heights of landmarks on the standing body, and breadths, depths and girths of
//! trunk, head and limbs. It does not have, and we chose: how far forward outlines are (a standing posture seen from
//! the side), the ratio of depth to breadth of limbs, the outlines between landmarks of neck, face, hand and foot, and
//! how much thinner a hanging arm is than a flexed one.

use super::landmarks::Heights;
use super::measures::Measures;
use super::outline::{Oval, POINTS, Points, depth_of_girth, directions, mirrored};
use super::skin::{Ring, skin};
use super::slices::outline;
use crate::person::{Person, Sex};
use lemons_core::plane::{Vec2, vec2};

/// Girth of a hanging arm / girth of the flexed one.
const RELAXED: f64 = 0.93;
/// \[m\] Smallest distance between arm and trunk, and between the thighs.
const GAP: f64 = 0.003;
/// Slope of the arm: least distance outwards per metre below the armpit.
const LEAN: f64 = 0.05;
/// \[m\] Length below the armpit in which an arm that is pushed aside by the chest has mostly moved.
const BESIDE: f64 = 0.03;
/// Exponent of the outline at the torso's altitude. Its area is then 0.81 of its bounding box; the paper's five disks
/// fill 0.79.
const SHOULDER_FULLNESS: f64 = 2.15;
/// \[rad\] Angle by which the feet turn outwards.
const TOES_OUT: f64 = 0.13;

/// The dense rings of one person; of arms and legs, the left ones.
pub(super) struct Skins {
    pub trunk: Vec<Ring>,
    pub arm: Vec<Ring>,
    pub leg: Vec<Ring>,
}

/// The rings of the other side.
pub(super) fn other_side(rings: &[Ring]) -> Vec<Ring> {
    rings.iter().map(|ring| Ring { z: ring.z, points: mirrored(&ring.points) }).collect()
}

/// The paper's scale profile: 1 between knees and neck, 0 beyond, smooth (its published constants, in cm on a template
/// of 186.6 cm).
fn door(z: f64, stature: f64) -> f64 {
    let z = z / stature * 186.6;
    let logistic = |v: f64| 1.0 / (1.0 + libm::exp(-v));
    logistic((160.0 - z) / 2.0) * logistic((z - 59.0) / 8.0)
}

fn mix(low: f64, high: f64, share: f64) -> f64 {
    low + share * (high - low)
}

/// Ovals whose exponents do not depend on the girth factor, found once per person.
pub(super) struct Template {
    heights: Heights,
    /// Exponents of chest, waist, hips and head.
    fullness: [f64; 4],
    measures: Measures,
    around: Points,
    broad: Points,
    long: Points,
}

impl Template {
    pub(super) fn of(person: &Person) -> Template {
        let measures = Measures::of(person);
        let m = |name| measures.get(name);
        let fullness =
            |breadth, depth, girth| Oval::new(0.0, Vec2::zeros(), breadth, depth).with_girth(girth).fullness;
        Template {
            heights: Heights::of(&measures),
            fullness: [
                fullness(m("chestbreadth"), person.depth, m("chestcircumference")).min(2.6),
                fullness(m("waistbreadth"), m("waistdepth"), m("waistcircumference")),
                fullness(m("hipbreadth"), m("buttockdepth"), m("buttockcircumference")),
                fullness(m("headbreadth"), m("headlength"), m("headcircumference")),
            ],
            around: directions(0.0),
            broad: directions(0.35),
            long: directions(-0.2),
            measures,
        }
    }

    /// The skins whose girths between knees and neck are scaled by a factor, the arms straight down. Breadth and depth
    /// at the torso's altitude stay the person's.
    pub(super) fn skins(&self, factor: f64) -> Skins {
        let arms = self.arm_ovals(factor);
        let trunk = self.trunk(factor, &arms[0]);
        let ring = |oval: &Oval| Ring { z: oval.z, points: oval.points(&self.around) };
        let arm: Vec<Ring> = arms.iter().rev().map(ring).collect();
        Skins { trunk, arm: skin(&arm), leg: skin(&self.leg(factor)) }
    }

    fn grow(&self, oval: Oval, factor: f64) -> Oval {
        oval.grown(1.0 + (factor - 1.0) * door(oval.z, self.measures.person.stature))
    }

    /// \[m\] Half breadth of the chest at the armpit. The arm beside it must stay within the shoulders.
    fn chest_side(&self, factor: f64) -> f64 {
        let m = &self.measures;
        let arm = 0.85 * RELAXED * m.get("bicepscircumferenceflexed") / std::f64::consts::PI;
        let room = 0.5 * m.person.breadth - arm - GAP;
        (0.5 * m.get("chestbreadth") * factor).min(room.max(0.25 * m.person.breadth))
    }

    /// From the crotch to the top of the head.
    fn trunk(&self, factor: f64, upper_arm: &Oval) -> Vec<Ring> {
        let (h, person) = (&self.heights, &self.measures.person);
        let m = |name| self.measures.get(name);
        let [chest_full, waist_full, hip_full, head_full] = self.fullness;
        let (rib_breadth, rib_depth, bust) = match person.sex {
            Sex::Male => (0.97, 0.98, 0.97),
            Sex::Female => (0.93, 0.94, 0.89),
        };
        let at = |x: f64| vec2(x * person.stature / 1.75, 0.0);
        let grown = |oval: Oval| self.grow(oval, factor);
        let hips = grown(Oval::new(h.buttock, at(-0.012), m("hipbreadth"), m("buttockdepth")).full(hip_full));
        let waist = grown(Oval::new(h.waist, at(0.004), m("waistbreadth"), m("waistdepth")).full(waist_full));
        let rib = Oval::new(h.rib, at(0.002), rib_breadth * m("waistbreadth"), rib_depth * m("waistdepth"));
        let rib = grown(rib.full(waist_full));
        let mut chest =
            grown(Oval::new(h.chest, at(-0.004), m("chestbreadth"), person.depth).full(chest_full));
        chest.breadth = self.chest_side(factor);
        let mut under = Oval { z: 0.5 * (h.rib + h.chest), centre: at(-0.006), ..chest };
        under.breadth = 0.5 * (rib.breadth + chest.breadth);
        under.depth = (0.5 * (rib.depth + chest.depth)).min(bust * chest.depth);
        // The armpit: a slightly shallower chest, first without and then with the arms beside it.
        let armpit = Oval { z: h.axilla, centre: at(-0.009), depth: 0.97 * chest.depth, ..chest };
        let ring = |oval: Oval| Ring { z: oval.z, points: oval.points(&self.broad) };
        let mut rings = skin(&[
            self.crotch(factor),
            ring(hips),
            ring(waist),
            ring(rib),
            ring(under),
            ring(chest),
            ring(armpit),
        ]);

        let shoulders = Oval::new(h.torso, at(-0.02), person.breadth, person.depth).full(SHOULDER_FULLNESS);
        let biacromial = m("biacromialbreadth").min(0.88 * person.breadth);
        // The shoulders become round between the torso's altitude and their tips.
        let tips = (m("acromialheight") + 0.012).clamp(h.neck(0.27), h.neck(0.36));
        let round = |up: f64, broad: f64, deep: f64| {
            let z = h.torso + up * (tips - h.torso);
            Oval::new(z, at(-0.02 - 0.007 * up), broad * person.breadth, deep * person.depth).full(2.1)
        };
        let top = Oval::new(tips, at(-0.027), 0.97 * biacromial, 0.7 * person.depth);
        let neck_girth = m("neckcircumference");
        let nape = (0.46 * biacromial).max(1.25 * neck_girth / std::f64::consts::PI);
        let trapezius =
            Oval::new(h.neck(0.58), at(-0.027), nape, 0.5 * (m("neckcircumferencebase") + neck_girth) * 0.34);
        let neck = Oval::of_girth(h.neck(0.78), at(-0.017), 1.02 * neck_girth, 1.05);
        let throat = Oval::of_girth(h.neck(0.9), at(-0.006), neck_girth, 1.08);
        let (breadth, length) = (m("headbreadth"), m("headlength"));
        let face = person.stature - h.chin;
        let head = |up: f64, ahead: f64, broad: f64, long: f64| {
            Oval::new(h.chin + up * face, at(ahead), broad * breadth, long * length).full(head_full)
        };
        // The armpit's outline: the chest with an arm on either side.
        let mut upper = vec![self.with_lobes(&armpit, upper_arm, 5), ring(shoulders)];
        upper.extend(
            [round(0.35, 0.985, 0.95), round(0.7, 0.93, 0.86), top, trapezius, neck, throat].map(ring),
        );
        upper.extend(
            [
                head(0.02, 0.022, 0.64, 0.72),
                head(0.08, 0.018, 0.73, 0.79),
                head(0.20, 0.011, 0.85, 0.86),
                head(0.38, 0.001, 0.94, 0.955),
                head(0.58, -0.004, 1.0, 1.0),
            ]
            .map(ring),
        );
        // The dome: a superellipse of exponent 2.3 seen from the side.
        for up in [0.3f64, 0.55, 0.75, 0.88, 0.95, 0.985, 1.0] {
            let left = (1.0 - libm::pow(up, 2.3)).max(0.0);
            let wide = libm::pow(left, 1.0 / 2.3).max(0.04);
            let mut oval = head(0.58 + 0.42 * up, -0.004 - 0.004 * up, wide, wide);
            if up == 1.0 {
                oval.z = person.stature;
            }
            upper.push(ring(oval));
        }
        rings.extend(skin(&upper));
        rings
    }

    /// The trunk's lowest outline: two thighs and a small gap between them.
    fn crotch(&self, factor: f64) -> Ring {
        let thigh = self.thigh(factor);
        let centre = vec2(thigh.centre.x, 0.0);
        let between = Oval { centre, breadth: 0.3 * thigh.breadth, depth: 0.8 * thigh.depth, ..thigh };
        self.with_lobes(&between, &thigh, 3)
    }

    /// An oval with an ellipse on either side: the outermost of them, seen from the oval's centre. The creases between
    /// them are filled a little in each of `fillings` rounds.
    fn with_lobes(&self, middle: &Oval, left: &Oval, fillings: usize) -> Ring {
        let mut reach = middle.reaches(&self.broad);
        for (reach, way) in reach.iter_mut().zip(self.broad) {
            let to_the_left = vec2(way.x, way.y.abs());
            *reach = left.far_side(middle.centre, to_the_left).unwrap_or(0.0).max(*reach);
        }
        for _ in 0..fillings {
            // Add the two neighbours first: mirror images then stay exact.
            let beside = |k: usize| reach[(k + POINTS - 1) % POINTS] + reach[(k + 1) % POINTS];
            reach = std::array::from_fn(|k| reach[k].max(0.25 * beside(k) + 0.5 * reach[k]));
        }
        Ring { z: middle.z, points: std::array::from_fn(|k| middle.centre + self.broad[k] * reach[k]) }
    }

    /// The left thigh at the crotch: half as broad as the hips, as deep as its girth requires.
    fn thigh(&self, factor: f64) -> Oval {
        let m = |name| self.measures.get(name);
        let breadth = 0.5 * m("hipbreadth") - GAP;
        let depth = depth_of_girth(breadth, m("thighcircumference"), 0.9, 1.35).min(0.98 * m("buttockdepth"));
        let oval = Oval::new(self.heights.crotch, vec2(-0.01, 0.0), breadth, depth);
        self.aside(self.grow(oval, factor), 0.0)
    }

    /// Moved to the left until it is clear of the middle and its centre at least `least` \[m\] from it.
    fn aside(&self, oval: Oval, least: f64) -> Oval {
        Oval { centre: vec2(oval.centre.x, least.max(oval.breadth + GAP)), ..oval }
    }

    /// The left leg from the sole to the crotch.
    fn leg(&self, factor: f64) -> Vec<Ring> {
        let h = &self.heights;
        let m = |name| self.measures.get(name);
        let thigh = self.thigh(factor);
        let size = self.measures.person.stature / 1.75;
        // The legs are vertical below the hips, whose breadth the girth factor does not change.
        let line = 0.25 * m("hipbreadth");
        let limb = |z: f64, ahead: f64, girth: f64, deeper: f64| {
            let oval = Oval::of_girth(z, vec2(ahead * size, 0.0), girth, deeper);
            self.aside(self.grow(oval, factor), line)
        };
        let (thigh_girth, lower, calf) =
            (m("thighcircumference"), m("lowerthighcircumference"), m("calfcircumference"));
        let ankle_z = h.malleolus + 0.035 * size;
        let calf_z = mix(ankle_z, h.tibial, 0.65);
        let above_knee = h.knee + (0.06 * size).min(0.3 * (h.crotch - h.knee));
        let span = h.crotch - above_knee;
        // At most half as broad as the hips above: a thick thigh is deep instead.
        let upper = |share: f64, ahead: f64, girth: f64, deeper: f64| {
            let most = (0.5 * m("hipbreadth") - GAP) * (0.9 + 0.1 * share);
            let around = Oval::of_girth(above_knee + share * span, vec2(ahead * size, 0.0), girth, deeper);
            let breadth = most.min(2.0 * around.breadth);
            let depth = depth_of_girth(breadth, girth, deeper, 1.4);
            self.aside(self.grow(Oval { breadth: 0.5 * breadth, depth: 0.5 * depth, ..around }, factor), line)
        };
        let limbs = [
            limb(ankle_z, -0.028, m("anklecircumference"), 1.3),
            limb(mix(ankle_z, calf_z, 0.5), -0.024, mix(m("anklecircumference"), calf, 0.55), 1.12),
            limb(calf_z, -0.018, calf, 1.08),
            limb(mix(calf_z, h.tibial, 0.75), -0.008, 0.92 * calf, 1.05),
            limb(h.knee, 0.0, mix(lower, calf, 0.5) * 0.97, 1.1),
            limb(above_knee, -0.002, lower, 1.06),
            upper(0.45, -0.002, mix(lower, thigh_girth, 0.56), 1.08),
            upper(0.8, -0.006, 0.95 * thigh_girth, 1.14),
            thigh,
        ];
        // The foot: fractions of the ankle bone's height, and of the foot's length and breadth; heel position before
        // its hindmost point.
        let (length, breadth) = (m("footlength"), m("footbreadthhorizontal"));
        let heel = -0.078 * size;
        let foot = |up: f64, long: f64, broad: f64, ahead: f64| {
            let x = heel + ahead * length + 0.5 * long * length;
            let oval = Oval::new(up * h.malleolus, vec2(x, line), broad * breadth, long * length).full(2.3);
            let (sin, cos) = libm::sincos(TOES_OUT);
            let pivot = vec2(-0.028 * size, line);
            let points = oval.points(&self.long).map(|point| {
                let arm = point - pivot;
                pivot + vec2(cos * arm.x - sin * arm.y, sin * arm.x + cos * arm.y)
            });
            Ring { z: oval.z, points }
        };
        let mut rings = vec![
            foot(0.0, 0.95, 0.90, 0.02),
            foot(0.15, 1.0, 1.0, 0.0),
            foot(0.32, 0.96, 0.98, 0.0),
            foot(0.55, 0.74, 0.90, 0.0),
            foot(0.8, 0.53, 0.80, 0.005),
            foot(1.1, 0.40, 0.72, 0.01),
        ];
        rings.extend(limbs.map(|oval| Ring { z: oval.z, points: oval.points(&self.long) }));
        rings
    }

    /// The left arm from the armpit down, vertical below its start, at a distance from the chest.
    fn arm_ovals(&self, factor: f64) -> Vec<Oval> {
        let h = &self.heights;
        let m = |name| self.measures.get(name);
        let size = self.measures.person.stature / 1.75;
        let grow = |share: f64| 1.0 + (factor - 1.0) * share;
        let biceps = RELAXED * m("bicepscircumferenceflexed") * grow(1.0);
        let forearm = RELAXED * m("forearmcircumferenceflexed") * grow(0.7);
        // Between the chest and the widest of the shoulders.
        let round = biceps / std::f64::consts::PI;
        let inner = self.chest_side(factor) + GAP;
        let breadth = (0.5 * self.measures.person.breadth - inner).clamp(0.7 * round, 1.05 * round);
        let depth = depth_of_girth(breadth, biceps, 0.8, 1.6);
        let y = inner + 0.5 * breadth;
        let at = |x: f64| vec2(x * size, y);
        let elbow = (m("acromialheight") - m("acromionradialelength")).min(h.axilla - 8.0 * h.step);
        let wrist = m("wristheight").min(elbow - 10.0 * h.step);
        let fingertip = (wrist - m("handlength")).max(0.05 * self.measures.person.stature);
        let hand = wrist - fingertip;
        let palm = m("handbreadth");
        let fingers = |down: f64, x: f64, deep: f64, thick: f64| {
            Oval::new(wrist - down * hand, at(x), thick * palm, deep * palm).full(2.3)
        };
        vec![
            Oval::new(h.axilla, at(-0.016), breadth, depth),
            Oval::of_girth(mix(h.axilla, elbow, 0.4), at(-0.02), 0.98 * biceps, 1.1),
            Oval::of_girth(elbow, at(-0.026), 0.97 * forearm, 1.08),
            Oval::of_girth(mix(elbow, wrist, 0.2), at(-0.02), forearm, 1.08),
            Oval::of_girth(mix(elbow, wrist, 0.65), at(-0.004), 0.8 * forearm, 1.15),
            Oval::of_girth(wrist, at(0.01), m("wristcircumference") * grow(0.3), 1.35),
            fingers(0.25, 0.018, 1.05, 0.40),
            fingers(0.45, 0.022, 1.0, 0.36),
            fingers(0.7, 0.022, 0.85, 0.27),
            fingers(0.93, 0.020, 0.60, 0.19),
            fingers(1.0, 0.018, 0.25, 0.07),
        ]
    }
}

impl Skins {
    /// Moves the arm outwards as far as trunk and leg require: beside the chest at once, then along a slope. Every ring
    /// keeps its area.
    pub(super) fn lean_arm(&mut self) {
        let Some(top) = self.arm.last().map(|ring| ring.z) else { return };
        let below = |ring: &Ring| (top - ring.z, 1.0 - libm::exp(-(top - ring.z) / BESIDE));
        let (mut aside, mut lean) = (0.0f64, LEAN);
        let pushes: Vec<f64> = self.arm.iter().map(|ring| self.push(ring)).collect();
        let hanging = || self.arm.iter().zip(&pushes).filter(|(ring, _)| ring.z < top);
        for (ring, push) in hanging() {
            let (down, share) = below(ring);
            if down < 4.0 * BESIDE {
                aside = aside.max((push - lean * down) / share);
            }
        }
        for (ring, push) in hanging() {
            let (down, share) = below(ring);
            lean = lean.max((push - aside * share) / down);
        }
        for ring in &mut self.arm {
            let (down, share) = below(ring);
            let out = vec2(0.0, aside * share + lean * down);
            ring.points = ring.points.map(|point| point + out);
        }
    }

    /// \[m\] Distance by which a ring of the arm must move to the left.
    fn push(&self, ring: &Ring) -> f64 {
        push_out(&ring.points, &self.trunk, ring.z).max(push_out(&ring.points, &self.leg, ring.z))
    }
}

/// \[m\] Distance by which the points must move to the left to be clear of the rings at an altitude; 0 if there are no
/// rings.
fn push_out(points: &Points, rings: &[Ring], z: f64) -> f64 {
    let Some(other) = outline(rings, z, false) else { return 0.0 };
    let outermost = other.iter().fold(f64::MIN, |y, point| y.max(point.y));
    if points.iter().all(|point| point.y >= outermost + GAP) {
        return 0.0;
    }
    let mut push = f64::NEG_INFINITY;
    // The two polygons are nearest, along y, at a corner of one of them.
    for (corners, sides, sign) in [(points, &other, 1.0), (&other, points, -1.0)] {
        for corner in corners {
            for k in 0..POINTS {
                let (a, b) = (sides[k], sides[(k + 1) % POINTS]);
                let (left, right) = (a.x.min(b.x), a.x.max(b.x));
                if corner.x < left || corner.x > right || left == right {
                    continue;
                }
                let y = a.y + (b.y - a.y) * ((corner.x - a.x) / (b.x - a.x));
                push = push.max(sign * (y - corner.y));
            }
        }
    }
    (push + GAP).max(0.0)
}
