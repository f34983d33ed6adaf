//! People in levels: a person is a stack of slabs, each with disks that cover the section of its body there.

use crate::body3d::{Body3d, Figure};
use crate::error::{Result, require};
use crate::kinds::BodyDisk;
use crate::population::CrowdMember;
use crate::shape::Shape;
use lemons_core::distribution::bisected;
use lemons_core::plane::{Bounds, Disk, Ring, Vec2, convex_hull, union, vec2};
use lemons_core::trial::Heights;

/// Most slabs.
const MOST: usize = 10;
/// \[m\] From where to where there are slabs, if only their number is given: from the knees to the chin.
const BAND: [f64; 2] = [0.5, 1.7];
/// \[m\] Least and greatest height of a level, and the least distance of two.
const RANGE: [f64; 2] = [0.1, 2.2];
const APART: f64 = 0.02;
/// \[m\] Who reaches less far into a slab has no disks there: the top of a head is a point.
const REACH: f64 = 0.02;
/// \[m\] Least radius of a disk, if the section is not smaller: others are probably not meant (src/setup/usual.txt).
const LEAST: f64 = 0.02;
/// Sections of which the fullest stands for a slab.
const SECTIONS: u32 = 9;
/// Places on half of the middle line of a section at which disks can be.
const PLACES: i32 = 24;

/// Slabs of heights in which people have disks. Without any it is the plan, in which disks are of all heights.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Slabs(Vec<Slab>);

/// A slab; \[m\] the height of its section, if it is given.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Slab {
    heights: Heights,
    at: Option<f64>,
}

impl Slabs {
    /// Makes equal slabs from 0.5 m to 1.7 m; one is the plan.
    ///
    /// # Errors
    /// The number is not 1 to 10.
    pub fn equal(count: usize) -> Result<Slabs> {
        require((1..=MOST).contains(&count), || format!("{count}: must be 1 to {MOST}"))?;
        let [low, high] = BAND;
        let end = |k: usize| rounded(low + (high - low) * k as f64 / count as f64);
        let slab = |k| Slab { heights: Heights { bottom: end(k), top: end(k + 1) }, at: None };
        let slabs = (0..count).map(slab);
        Ok(Slabs(if count == 1 { Vec::new() } else { slabs.collect() }))
    }

    /// Makes slabs about heights \[m\]: they end in the middles, and the lowest and the highest one are as far below as
    /// above their height.
    ///
    /// # Errors
    /// There are not 2 to 10 heights, one is out of range, or they do not ascend.
    pub fn about(heights: &[f64]) -> Result<Slabs> {
        let (count, [low, high]) = (heights.len(), RANGE);
        require((2..=MOST).contains(&count), || format!("{heights:?}: must be 2 to {MOST} heights"))?;
        require(heights.iter().all(|at| (low..=high).contains(at)), || {
            format!("{heights:?}: must be from {low} to {high} m")
        })?;
        require(heights.is_sorted_by(|low, high| high - low >= APART), || {
            format!("{heights:?}: each must be at least {APART} m above the one before")
        })?;
        let half = |k: usize| 0.5 * (heights[k + 1] - heights[k]);
        let ends: Vec<f64> = std::iter::once((heights[0] - half(0)).max(0.0))
            .chain((0..count - 1).map(|k| heights[k] + half(k)))
            .chain([heights[count - 1] + half(count - 2)])
            .map(rounded)
            .collect();
        let slab = |(ends, at): (&[f64], &f64)| Slab {
            heights: Heights { bottom: ends[0], top: ends[1] },
            at: Some(*at),
        };
        Ok(Slabs(ends.windows(2).zip(heights).map(slab).collect()))
    }

    /// \[m\] Returns the height of all slabs: who is pressed over it is as stiff as in the plan. There is none in the plan.
    pub fn load_length(&self) -> Option<f64> {
        let [first, .., last] = self.0[..] else { return None };
        Some(rounded(last.heights.top - first.heights.bottom))
    }

    /// Returns the disks of an agent: the first and the last one are left and right of one level.
    ///
    /// # Errors
    /// As those of [`Body3d::similar`], or somebody is below all slabs.
    pub fn disks(&self, agent: &CrowdMember) -> Result<Vec<BodyDisk>> {
        let Some(Slab { heights: lowest, .. }) = self.0.first() else { return agent.disks() };
        let figure = Figure::of(agent)?;
        let things = things(&figure, agent);
        let seat = things.iter().fold(0.0, |seat: f64, (_, heights)| seat.max(heights.top));
        let sits = matches!(agent, CrowdMember::Member(member) if member.kind.seated);
        let mut stacks: Vec<Vec<BodyDisk>> = Vec::new();
        for (body, at, raised) in figure.trunks() {
            // Things are around who sits, up to their top.
            let own = Heights { bottom: if sits { seat } else { 0.0 }, top: body.stature() + raised };
            require(own.top.max(own.bottom) - lowest.bottom >= REACH, || {
                let (stature, bottom) = (body.stature(), lowest.bottom);
                format!(
                    "a person of {stature:.2} m does not reach the lowest level, which begins at {bottom} m"
                )
            })?;
            let parts = self.within(own);
            stacks.extend(parts.filter_map(|(part, height)| section(body, at, raised, part, height)));
        }
        for (disks, heights) in things {
            let part = |heights| disks.iter().map(|disk| BodyDisk { heights, ..disk.clone() }).collect();
            stacks.extend(self.within(heights).map(|(heights, _)| part(heights)));
        }
        let ahead = stacks.iter().position(|stack| looks_ahead(stack));
        let first = ahead.map(|k| stacks.remove(k)).or_else(|| Some(halves(stacks.first_mut()?)));
        let mut all = first.unwrap_or_default();
        let between = all.len().min(1);
        all.splice(between..between, stacks.into_iter().flatten());
        Ok(all)
    }

    /// Returns what is placed: the disks of all levels, without those within another one.
    ///
    /// # Errors
    /// As those of [`Slabs::disks`].
    pub fn shape(&self, agent: &CrowdMember) -> Result<Shape> {
        if self.0.is_empty() {
            return agent.shape();
        }
        let within =
            |one: &Disk, other: &Disk| (one.centre - other.centre).norm() + one.radius <= other.radius;
        let mut disks: Vec<Disk> = Vec::new();
        for BodyDisk { disk, .. } in self.disks(agent)? {
            if !disks.iter().any(|other| within(&disk, other)) {
                disks.retain(|other| !within(other, &disk));
                disks.push(disk);
            }
        }
        Ok(Shape { disks })
    }

    /// Returns the parts of what is between two heights, by slab; with the height of a section that is given.
    fn within(&self, own: Heights) -> impl Iterator<Item = (Heights, Option<f64>)> {
        let part = move |Slab { heights: Heights { bottom, top }, at }: &Slab| {
            let part = Heights { bottom: bottom.max(own.bottom), top: top.min(own.top) };
            (part, at.filter(|at| part.hold(*at)))
        };
        self.0.iter().map(part).filter(|(part, _)| part.extent() >= REACH)
    }
}

/// \[m\] Returns the height of somebody's chest: of the person, if there is a child at its hand. None if there are no disks of
/// a person: where a chair or a bicycle is around it, and above or below all slabs.
pub fn chest_height(agent: &CrowdMember, disks: &[BodyDisk]) -> Option<f64> {
    let (person, seat) = match agent {
        CrowdMember::Pedestrian(person) => (person, None),
        CrowdMember::Member(member) => (&member.people[0].0, member.kind.seated.then_some(member.kind.seat)),
    };
    let [crotch, chest] = Body3d::crotch_and_chest(person);
    let height = rounded(chest + seat.map_or(0.0, |seat| seat - crotch));
    disks.iter().any(|of| of.material.is_none() && of.heights.hold(height)).then_some(height)
}

/// \[m\] Heights are written in tenths of a millimetre.
fn rounded(height: f64) -> f64 {
    (height * 1e4).round() / 1e4
}

/// The disks of things from the centre of mass, and where they are: those of the plan.
fn things(figure: &Figure, agent: &CrowdMember) -> Vec<(Vec<BodyDisk>, Heights)> {
    let heights = |[bottom, top]: [f64; 2]| Heights { bottom, top };
    if let (Some(ends), CrowdMember::Member(member)) = (figure.bicycle(), agent) {
        return vec![(member.disks.clone(), heights(ends))];
    }
    let parts = figure.parts().map(|(part, origin, ends)| {
        let disk = |&[x, y, radius]: &[f64; 3]| BodyDisk {
            material: Some(part.material.clone()),
            ..BodyDisk::of(Disk { radius, centre: origin + vec2(x, y) })
        };
        (part.disks.iter().map(disk).collect(), heights(ends))
    });
    parts.collect()
}

/// The disks of a part of a body that is higher than that of who stands: of its section at a height, or of the fullest one.
fn section(
    body: &Body3d,
    at: Vec2,
    raised: f64,
    heights: Heights,
    height: Option<f64>,
) -> Option<Vec<BodyDisk>> {
    let outline = |height: f64| {
        let slices = body.slice_at(height - raised);
        Ring::through(convex_hull(slices.into_iter().flat_map(|slice| slice.points)))
    };
    let within = |k: u32| heights.bottom + heights.extent() * (f64::from(k) + 0.5) / f64::from(SECTIONS);
    let outline = match height {
        Some(height) => outline(height),
        None => (0..SECTIONS)
            .filter_map(|k| outline(within(k)))
            .max_by(|one, other| one.area().total_cmp(&other.area())),
    }?;
    let placed = |disk: Disk| BodyDisk { heights, ..BodyDisk::of(Disk { centre: disk.centre + at, ..disk }) };
    Some(covering(&outline).into_iter().map(placed).collect())
}

/// Whether the first and the last disk are left and right.
fn looks_ahead(disks: &[BodyDisk]) -> bool {
    let [first, .., last] = disks else { return false };
    first.disk.centre.x == last.disk.centre.x && first.disk.centre.y > last.disk.centre.y
}

/// Takes a disk out, as its lower and its upper half: two disks at one place look ahead. Together they act as before.
fn halves(stack: &mut Vec<BodyDisk>) -> Vec<BodyDisk> {
    let one = stack.remove(0);
    let middle = 0.5 * (one.heights.bottom + one.heights.top);
    let half = |heights| BodyDisk { heights, ..one.clone() };
    vec![half(Heights { top: middle, ..one.heights }), half(Heights { bottom: middle, ..one.heights })]
}

/// Returns five disks with the area of a convex outline, which is symmetric about the x axis: one and two pairs on its
/// middle line, which is across if it is broader than deep. Of the inscribed disks there, those that cover most, grown
/// evenly.
fn covering(outline: &Ring) -> Vec<Disk> {
    let Bounds { low, high } = outline.bounds();
    let (size, middle) = (high - low, 0.5 * (low.x + high.x));
    let across = size.y >= size.x;
    let step = 0.5 * size.x.max(size.y) / f64::from(PLACES);
    let inscribed = |k: i32| {
        let along = step * f64::from(k);
        if !across {
            let centre = vec2(middle + along, 0.0);
            return Disk { centre, radius: outline.nearest(centre).distance };
        }
        // The left one, for both sides.
        let centre = vec2(middle_of_chord(outline, along.abs()), along.abs());
        Disk { radius: outline.nearest(centre).distance, centre: vec2(centre.x, along) }
    };
    let places = -(PLACES - 1)..PLACES;
    let all: Vec<Disk> = places.clone().map(inscribed).collect();
    let at = |k: i32| all[(k + PLACES - 1) as usize];
    // Nearly half of the area.
    let covers = |chosen: &[i32]| -> f64 {
        let depth = |place: i32| {
            let of = |k: &i32| at(*k).radius.powi(2) - (step * f64::from(place - k)).powi(2);
            chosen.iter().map(of).fold(0.0, f64::max).sqrt()
        };
        places.clone().map(depth).sum()
    };
    let least = LEAST.min(0.5 * at(0).radius);
    let far = (2..PLACES).filter(|far| at(*far).radius.min(at(-far).radius) >= least);
    let candidates = far.flat_map(|far| (1..far).map(move |near| [far, near, 0, -near, -far]));
    let best = candidates.map(|chosen| (covers(&chosen), chosen)).max_by(|a, b| a.0.total_cmp(&b.0));
    let disks: Vec<Disk> = best.iter().flat_map(|(_, chosen)| chosen).map(|k| at(*k)).collect();
    let grown = |by: f64| disks.iter().map(move |disk| Disk { radius: disk.radius + by, ..*disk });
    let area = outline.area();
    let (by, _) =
        bisected([0.0, step * f64::from(PLACES)], 20, |by| union(&grown(by).collect::<Vec<_>>()).area < area);
    grown(by).collect()
}

/// x \[m\] of the middle of what a convex outline has at a height y \[m\] within it.
fn middle_of_chord(outline: &Ring, y: f64) -> f64 {
    let crossed = outline.sides().filter(|(a, b)| (a.y <= y) != (b.y <= y));
    let at = crossed.map(|(a, b)| a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)));
    let (sum, count) = at.fold((0.0, 0), |(sum, count), x| (sum + x, count + 1));
    sum / f64::from(count)
}
