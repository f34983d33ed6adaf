//! What walls enclose: closed walls, walls whose ends meet, walls whose ends straight lines join.

use lemons_core::plane::{Ring, Vec2, segments_touch};
use lemons_core::trial::Wall;
use std::collections::BTreeMap;

/// More open walls than these have their own ends joined, not those of each other.
const MOST_OPEN: usize = 200;

/// A closed wall, or walls whose ends meet or are joined.
pub(crate) struct Outline {
    pub ring: Ring,
    /// For messages.
    pub name: String,
    /// \[m\] the straight lines that close its openings.
    pub bridges: Vec<(Vec2, Vec2)>,
}

impl Outline {
    /// Makes one without openings.
    pub fn new(name: impl Into<String>, ring: Ring) -> Outline {
        Outline { ring, name: name.into(), bridges: Vec::new() }
    }

    /// Returns its name, with its openings.
    pub fn described(&self) -> String {
        if self.bridges.is_empty() {
            return self.name.clone();
        }
        let widths: Vec<String> =
            self.bridges.iter().map(|(a, b)| format!("{:.3}", (*b - *a).norm())).collect();
        let widths: Vec<&str> =
            widths.iter().map(|text| text.trim_end_matches('0').trim_end_matches('.')).collect();
        let (noun, lines) =
            if widths.len() == 1 { ("opening", "a straight line") } else { ("openings", "straight lines") };
        format!("{}, its {noun} of {} m closed by {lines}", self.name, widths.join(", "))
    }
}

/// Equal for equal points: the sum turns −0 into 0.
fn bits(point: Vec2) -> [u64; 2] {
    [(point.x + 0.0).to_bits(), (point.y + 0.0).to_bits()]
}

/// Walls sorted by whether they enclose something.
pub(crate) struct Outlines {
    /// Closed walls, and those that open walls make where just two ends meet.
    pub rings: Vec<Outline>,
    /// \[m\] the corners of walls that are in none of these, joined where just two ends meet.
    pub open: Vec<Vec<Vec2>>,
    /// What they make when straight lines join their ends.
    pub joined: Vec<Outline>,
}

/// Walls one after the other.
#[derive(Clone)]
struct Chain {
    corners: Vec<Vec2>,
    /// Ids of the walls.
    ids: Vec<String>,
}

impl Chain {
    fn ends(&self) -> [Vec2; 2] {
        [self.corners[0], self.corners[self.corners.len() - 1]]
    }

    fn turned(mut self) -> Chain {
        self.corners.reverse();
        self.ids.reverse();
        self
    }

    /// Closed, `bridges` being what closes it.
    fn outline(self, bridges: Vec<(Vec2, Vec2)>) -> Option<Outline> {
        let name = self.name();
        Some(Outline { ring: Ring::through(self.corners)?, name, bridges })
    }

    fn name(&self) -> String {
        let ids: Vec<String> = self.ids.iter().map(|id| format!("{id:?}")).collect();
        format!("{} {}", if ids.len() == 1 { "wall" } else { "walls" }, ids.join(", "))
    }
}

impl Outlines {
    pub fn of(walls: &[Wall]) -> Outlines {
        let (mut rings, mut pieces) = (Vec::new(), Vec::new());
        for wall in walls {
            let [first, .., last] = &wall.corners[..] else { continue };
            let chain = Chain { corners: wall.corners.clone(), ids: vec![wall.id.clone()] };
            if bits(*first) == bits(*last) {
                rings.extend(chain.outline(Vec::new()));
            } else {
                pieces.push(chain);
            }
        }
        let chains = chained(&pieces);
        let (closed, open): (Vec<Chain>, Vec<Chain>) =
            chains.into_iter().partition(|chain| chain.ends().map(bits)[0] == chain.ends().map(bits)[1]);
        rings.extend(closed.into_iter().filter_map(|chain| chain.outline(Vec::new())));
        let joined = joined(&open, walls);
        Outlines { rings, open: open.into_iter().map(|chain| chain.corners).collect(), joined }
    }
}

/// Open walls put together where just two ends meet.
fn chained(pieces: &[Chain]) -> Vec<Chain> {
    let mut ends: BTreeMap<[u64; 2], Vec<usize>> = BTreeMap::new();
    for (place, piece) in pieces.iter().enumerate() {
        piece.ends().into_iter().for_each(|end| ends.entry(bits(end)).or_default().push(place));
    }
    let mut used = vec![false; pieces.len()];
    let mut chains = Vec::new();
    for start in 0..pieces.len() {
        if used[start] {
            continue;
        }
        used[start] = true;
        let mut chain = pieces[start].clone();
        // Forwards, then, unless it is closed, from its beginning backwards.
        for _ in 0..2 {
            loop {
                let [first, end] = chain.ends().map(bits);
                let next = match &ends[&end][..] {
                    [a, b] if end != first => [*a, *b].into_iter().find(|place| !used[*place]),
                    _ => None,
                };
                let Some(next) = next else { break };
                used[next] = true;
                let mut piece = pieces[next].clone();
                if bits(piece.ends()[0]) != end {
                    piece = piece.turned();
                }
                chain.corners.extend(&piece.corners[1..]);
                chain.ids.extend(piece.ids);
            }
            let [first, end] = chain.ends().map(bits);
            if first == end {
                break;
            }
            chain = chain.turned();
        }
        chains.push(chain);
    }
    chains
}

/// Rings of open walls: straight lines join their ends, the nearest first, where no wall is in between.
fn joined(chains: &[Chain], walls: &[Wall]) -> Vec<Outline> {
    let end = |k: usize| chains[k / 2].ends()[k % 2];
    let length = |&(a, b): &(usize, usize)| (end(a) - end(b)).norm_squared();
    let own = |k: usize| (2 * k, 2 * k + 1);
    let mut pairs: Vec<(usize, usize)> = if chains.len() <= MOST_OPEN {
        (0..2 * chains.len()).flat_map(|b| (0..b).map(move |a| (a, b))).collect()
    } else {
        (0..chains.len()).map(own).collect()
    };
    // Of a straight wall there is nothing inside.
    pairs.retain(|&(a, b)| a / 2 != b / 2 || chains[a / 2].corners.len() > 2);
    pairs.sort_by(|a, b| length(a).total_cmp(&length(b)));
    let mut partner: Vec<Option<usize>> = vec![None; 2 * chains.len()];
    for (a, b) in pairs {
        if partner[a].is_some() || partner[b].is_some() {
            continue;
        }
        let (from, to) = (end(a), end(b));
        let at = |p: Vec2| bits(p) == bits(from) || bits(p) == bits(to);
        let mut sides = walls.iter().flat_map(|wall| wall.corners.windows(2));
        if !sides.any(|side| !at(side[0]) && !at(side[1]) && segments_touch(from, to, side[0], side[1])) {
            (partner[a], partner[b]) = (Some(b), Some(a));
        }
    }
    let mut used = vec![false; chains.len()];
    let mut rings = Vec::new();
    for start in 0..chains.len() {
        let mut all = Chain { corners: Vec::new(), ids: Vec::new() };
        let (mut bridges, mut at, mut whole) = (Vec::new(), 2 * start, false);
        while !used[at / 2] {
            used[at / 2] = true;
            let chain = chains[at / 2].clone();
            let chain = if at % 2 == 0 { chain } else { chain.turned() };
            all.corners.extend(chain.corners);
            all.ids.extend(chain.ids);
            let out = at ^ 1;
            let Some(next) = partner[out] else { break };
            bridges.push((end(out), end(next)));
            at = next;
            whole = next == 2 * start;
        }
        if whole {
            all.corners.push(all.corners[0]);
            all.corners.dedup();
            rings.extend(all.outline(bridges));
        }
    }
    rings
}
