//! Plans as architects draw them, made from seeds, with what is known of them.

use super::*;
use std::fmt::Write;

/// A sequence of numbers from a seed (Knuth's constants).
pub(super) struct Random(pub u64);

impl Random {
    pub fn part(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.part()
    }

    /// To the centimetre, as architects do.
    pub fn length(&mut self, low: f64, high: f64) -> f64 {
        (self.within(low, high) * 100.0).round() / 100.0
    }

    pub fn of(&mut self, count: usize) -> usize {
        (self.part() * count as f64) as usize
    }

    pub fn yes(&mut self) -> bool {
        self.part() < 0.5
    }
}

/// Names of layers: walls, doors, windows, columns, furniture, stairs, axes, hatches, texts. The last ones say nothing.
const NAMES: [[&str; 9]; 6] = [
    ["A-WALL", "A-DOOR", "A-GLAZ", "A-COLS", "A-FURN", "A-STAIR", "A-GRID", "A-HATCH", "A-ANNO"],
    ["Wände", "Türen", "Fenster", "Stützen", "Möbel", "Treppen", "Achsen", "Schraffur", "Beschriftung"],
    ["WAENDE_TRAGEND", "TUEREN", "FENSTER", "STUETZEN", "THEKE", "TREPPE", "RASTER", "SCHRAFFUREN", "TEXTE"],
    ["MURS", "PORTES", "FENETRES", "POTEAUX", "MOBILIER", "ESCALIERS", "AXES", "HACHURES", "COTES"],
    ["Cloisons", "Portes", "Fenêtres", "Poteaux", "Comptoir", "Escalier", "Trame", "Hachure", "Texte"],
    ["L1", "L2", "Fenster", "L4", "Bar", "L6", "L7", "L8", "L9"],
];

/// A plan in the making: lengths in m, in a frame of its own.
pub(super) struct PlanBuilder {
    pub random: Random,
    pub layers: [&'static str; 9],
    /// Length of a unit \[m\], and its number in `$INSUNITS`.
    pub unit: (f64, u32),
    pub turned: f64,
    pub moved: Vec2,
    pub blocks: String,
    pub entities: String,
}

impl PlanBuilder {
    pub fn place(&self, at: Vec2) -> Vec2 {
        let (sin, cos) = self.turned.sin_cos();
        vec2(at.x * cos - at.y * sin, at.x * sin + at.y * cos) + self.moved
    }

    pub fn point(&self, code: u32, at: Vec2) -> String {
        let at = self.place(at) / self.unit.0;
        format!("{code}\n{:.6}\n{}\n{:.6}\n", at.x, code + 10, at.y)
    }

    pub fn line(&mut self, layer: usize, a: Vec2, b: Vec2) {
        let (a, b) = (self.point(10, a), self.point(11, b));
        let _ = write!(self.entities, "0\nLINE\n8\n{}\n{a}{b}", self.layers[layer]);
    }

    pub fn chain(&mut self, layer: usize, corners: &[Vec2], closed: bool) {
        if self.random.yes() {
            let points: String = corners.iter().map(|corner| self.point(10, *corner)).collect();
            let layer = self.layers[layer];
            let _ = write!(self.entities, "0\nLWPOLYLINE\n8\n{layer}\n70\n{}\n{points}", u8::from(closed));
            return;
        }
        let ends = corners.iter().skip(1).chain(closed.then(|| &corners[0]));
        for (a, b) in corners.iter().zip(ends) {
            self.line(layer, *a, *b);
        }
    }

    pub fn arc(&mut self, layer: usize, centre: Vec2, radius: f64, from: f64, to: f64) {
        let (centre, turned) = (self.point(10, centre), self.turned.to_degrees());
        let _ = write!(
            self.entities,
            "0\nARC\n8\n{}\n{centre}40\n{}\n50\n{}\n51\n{}\n",
            self.layers[layer],
            radius / self.unit.0,
            from + turned,
            to + turned
        );
    }

    pub fn insert(&mut self, layer: usize, block: &str, at: Vec2) {
        let at = self.point(10, at);
        let turned = self.turned.to_degrees();
        let _ = write!(self.entities, "0\nINSERT\n8\n{}\n2\n{block}\n{at}50\n{turned}\n", self.layers[layer]);
    }

    /// A leaf that hangs at `hinge`, opens towards `into`, and reaches `shut`.
    pub fn swing(&mut self, hinge: Vec2, shut: Vec2, into: Vec2) {
        let radius = (shut - hinge).norm();
        let open = hinge + into * radius;
        if self.random.yes() {
            self.line(1, hinge, open);
        } else {
            let off = (shut - hinge) / radius * 0.04;
            self.chain(1, &[hinge, open, open + off, hinge + off], true);
        }
        let angle = |at: Vec2| (at.y - hinge.y).atan2(at.x - hinge.x).to_degrees();
        let (a, b) = (angle(shut), angle(open));
        let (from, to) = if (b - a).rem_euclid(360.0) < 180.0 { (a, b) } else { (b, a) };
        self.arc(1, hinge, radius, from, to);
    }

    pub fn dxf(&self) -> String {
        format!(
            "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n{}\n0\nENDSEC\n0\nSECTION\n2\nBLOCKS\n{}0\nENDSEC\n0\nSECTION\n2\n\
             ENTITIES\n{}0\nENDSEC\n0\nEOF\n",
            self.unit.1, self.blocks, self.entities
        )
    }
}

/// An opening of a wall: from and to along the side, and whether it is a window.
type Cut = (f64, f64, bool);

/// Values that are known by hand.
pub(super) struct ExpectedPlan {
    pub dxf: String,
    /// \[m²\] Within walls, and what obstacles take of it.
    pub area: f64,
    pub obstacles: f64,
    pub doors: Vec<(Vec2, f64)>,
    pub passages: usize,
    pub windows: usize,
    /// Of the outer walls.
    pub thickness: f64,
    pub small_gap: bool,
    pub stairs: bool,
}

/// A hall, perhaps with a second room, and what architects draw in it.
pub(super) fn hall(seed: u64) -> ExpectedPlan {
    let mut random = Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    random.part();
    let units = [(0.001, 4), (0.01, 5), (1.0, 6)];
    let (layers, unit) = (NAMES[random.of(NAMES.len())], units[random.of(3)]);
    let turned = if random.yes() { 0.0 } else { random.within(-3.0, 3.0) };
    let moved = vec2(random.within(-500.0, 500.0), random.within(-500.0, 500.0));
    let mut plan =
        PlanBuilder { random, layers, unit, turned, moved, blocks: String::new(), entities: String::new() };
    let (width, height) = (plan.random.length(20.0, 32.0), plan.random.length(10.0, 18.0));
    let t = plan.random.length(0.05, 0.40);
    let small_gap = plan.random.of(4) == 0;
    let capped = plan.random.of(4) > 0;
    let mut known = ExpectedPlan {
        dxf: String::new(),
        area: width * height,
        obstacles: 0.0,
        doors: Vec::new(),
        passages: 0,
        windows: 0,
        thickness: t,
        small_gap,
        stairs: plan.random.yes(),
    };
    // The sides, counter-clockwise: where they begin, where they go, how long they are.
    let sides = [
        (vec2(0.0, 0.0), vec2(1.0, 0.0), width),
        (vec2(width, 0.0), vec2(0.0, 1.0), height),
        (vec2(width, height), vec2(-1.0, 0.0), width),
        (vec2(0.0, height), vec2(0.0, -1.0), height),
    ];
    let mut openings: Vec<(usize, Vec<Cut>)> = Vec::new();
    let total = 1 + plan.random.of(4);
    for side in 0..4 {
        let mut cuts = Vec::new();
        if side < total {
            let long = plan.random.length(0.8, 2.6);
            let from = plan.random.length(0.6, 3.0);
            cuts.push((from, from + long, false));
            let window = plan.random.length(0.9, 2.0);
            if plan.random.of(3) == 0 {
                let from = plan.random.length(6.5, 7.0);
                cuts.push((from, from + window, true));
            }
        }
        openings.push((side, cuts));
    }
    // Walls between openings, each a band: along sides from one opening over corners to the next.
    let at = |(side, along): (usize, f64), off: f64| {
        let (begin, way, _) = sides[side];
        begin + way * along + vec2(way.y, -way.x) * off
    };
    let corner = |side: usize, off: f64| {
        let (begin, way, _) = sides[side];
        let before = sides[(side + 3) % 4].1;
        begin + vec2(way.y, -way.x) * off + vec2(before.y, -before.x) * off
    };
    let all: Vec<(usize, Cut)> =
        openings.iter().flat_map(|(side, cuts)| cuts.iter().map(move |cut| (*side, *cut))).collect();
    for (k, (side, (_, to, _))) in all.iter().enumerate() {
        let (next, (until, ..)) = all[(k + 1) % all.len()];
        let turns = match next as i64 - *side as i64 {
            0 if all.len() > 1 && until > *to => 0,
            turns => {
                if turns <= 0 {
                    turns + 4
                } else {
                    turns
                }
            }
        };
        let over: Vec<usize> = (1..=turns as usize).map(|k| (side + k) % 4).collect();
        let line = |off: f64| -> Vec<Vec2> {
            let corners = over.iter().map(|side| corner(*side, off));
            std::iter::once(at((*side, *to), off)).chain(corners).chain([at((next, until), off)]).collect()
        };
        let (inner, outer) = (line(0.0), line(t));
        if small_gap && inner.len() > 2 {
            // The inner line ends 2 cm before a corner.
            let way = (inner[1] - inner[0]).normalize();
            plan.line(0, inner[0], inner[1] - way * 0.02);
            plan.chain(0, &inner[1..], false);
            plan.chain(0, &outer, false);
            plan.line(0, inner[0], outer[0]);
            plan.line(0, inner[inner.len() - 1], outer[outer.len() - 1]);
        } else if capped {
            let ring: Vec<Vec2> = inner.iter().chain(outer.iter().rev()).copied().collect();
            plan.chain(0, &ring, true);
        } else {
            plan.chain(0, &inner, false);
            plan.chain(0, &outer, false);
        }
    }
    for (side, (from, to, is_window)) in all {
        let (_, way, _) = sides[side];
        let outwards = vec2(way.y, -way.x);
        if is_window {
            known.windows += 1;
            for off in [0.0, 0.5 * t, t] {
                plan.line(2, at((side, from), off), at((side, to), off));
            }
            continue;
        }
        known.doors.push((plan.place(at((side, 0.5 * (from + to)), 0.0)), to - from));
        let level = if plan.random.yes() { t } else { 0.0 };
        let into = if level > 0.0 { outwards } else { -outwards };
        let (a, b) = (at((side, from), level), at((side, to), level));
        match to - from {
            long if long > 1.4 => {
                plan.swing(a, (a + b) * 0.5, into);
                plan.swing(b, (a + b) * 0.5, into);
            }
            _ if plan.random.yes() => plan.swing(a, b, into),
            _ => plan.swing(b, a, into),
        }
    }
    // A wall between two rooms, with a door in it, or one that ends in the room.
    let thin = plan.random.length(0.05, 0.2);
    let x = plan.random.length(9.2, width - 9.6);
    match plan.random.of(3) {
        0 => {
            let (low, high) = (plan.random.length(3.0, 4.0), plan.random.length(4.8, 5.2));
            plan.chain(0, &[vec2(x, 0.0), vec2(x, low), vec2(x + thin, low), vec2(x + thin, 0.0)], false);
            plan.chain(
                0,
                &[vec2(x, height), vec2(x, high), vec2(x + thin, high), vec2(x + thin, height)],
                false,
            );
            plan.swing(vec2(x, low), vec2(x, high), vec2(-1.0, 0.0));
            known.area -= thin * (height - (high - low));
            known.passages = 1;
        }
        1 => {
            let low = plan.random.length(4.0, 5.0);
            plan.chain(
                0,
                &[vec2(x, height), vec2(x, low), vec2(x + thin, low), vec2(x + thin, height)],
                false,
            );
            known.area -= thin * (height - low);
        }
        _ => (),
    }
    // Columns as blocks: squares with diagonals, and round ones.
    let (side, radius) = (plan.random.length(0.3, 0.6), plan.random.length(0.15, 0.3));
    let half = 0.5 * side / unit.0;
    let ring: String = [(-half, -half), (half, -half), (half, half), (-half, half)]
        .map(|(x, y)| format!("10\n{x}\n20\n{y}\n"))
        .concat();
    plan.blocks = format!(
        "0\nBLOCK\n2\nSQUARE\n10\n0\n20\n0\n0\nLWPOLYLINE\n8\n0\n70\n1\n{ring}0\nLINE\n8\n0\n10\n{0}\n20\n{0}\n11\n{1}\n\
         21\n{1}\n0\nLINE\n8\n0\n10\n{0}\n20\n{1}\n11\n{1}\n21\n{0}\n0\nENDBLK\n0\nBLOCK\n2\nROUND\n10\n0\n20\n0\n0\n\
         CIRCLE\n8\n0\n10\n0\n20\n0\n40\n{2}\n0\nENDBLK\n",
        -half,
        half,
        radius / unit.0
    );
    for k in 0..3 {
        let x = 4.0 + 2.0 * f64::from(k);
        plan.insert(3, "SQUARE", vec2(x, 6.0));
        plan.insert(3, "ROUND", vec2(x, 8.0));
        known.obstacles += side * side + std::f64::consts::PI * radius * radius;
    }
    // A bar: part of a ring, or a table.
    if plan.random.yes() {
        let (centre, inner, outer) = (vec2(0.0, 7.0), 2.0, 2.6);
        let at = |radius: f64, angle: f64| {
            centre + vec2(angle.to_radians().cos(), angle.to_radians().sin()) * radius
        };
        for radius in [inner, outer] {
            plan.arc(4, centre, radius, -50.0, 50.0);
        }
        for angle in [-50.0, 50.0] {
            plan.line(4, at(inner, angle), at(outer, angle));
        }
        known.obstacles += 100.0_f64.to_radians() * 0.5 * (outer * outer - inner * inner);
    } else {
        plan.chain(4, &[vec2(1.0, 5.0), vec2(1.8, 5.0), vec2(1.8, 9.0), vec2(1.0, 9.0)], true);
        known.obstacles += 3.2;
    }
    if known.stairs {
        for k in 0..8 {
            let x = width - 3.0 + 0.29 * f64::from(k);
            plan.line(5, vec2(x, height - 1.2), vec2(x, height));
        }
    }
    // Axes run through the columns to far beyond the walls.
    for x in [4.0, 6.0, 8.0] {
        plan.line(6, vec2(x, -5.0), vec2(x, height + 5.0));
    }
    plan.line(6, vec2(-4.0, 6.0), vec2(width + 4.0, 6.0));
    let at = plan.point(10, vec2(5.0, 5.0));
    let (hatch, text) = (layers[7], layers[8]);
    let _ = write!(plan.entities, "0\nHATCH\n8\n{hatch}\n{at}0\nTEXT\n8\n{text}\n{at}1\nHall\n");
    known.dxf = plan.dxf();
    known
}
