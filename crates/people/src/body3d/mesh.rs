//! Closed triangle meshes.

use super::outline::POINTS;
use super::skin::Ring;
use super::{Body3d, BodyPart};
use lemons_core::plane::{Pose, Vec2, rotation, vec2};

/// A closed surface of one part of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshPart {
    /// Name, of letters, digits and `_`.
    pub name: String,
    /// \[m\] Coordinates x, y, z; z is up.
    pub vertices: Vec<[f64; 3]>,
    /// Triples of indices into `vertices`, counter-clockwise seen from outside. Every edge belongs to two triangles,
    /// once in each direction.
    pub triangles: Vec<[u32; 3]>,
}

impl MeshPart {
    /// The surface through rings, closed at both ends. Of each ring it takes every `stride`-th point.
    fn through(name: &str, rings: &[&Ring], stride: usize) -> MeshPart {
        let mut part = MeshPart { name: name.to_owned(), vertices: Vec::new(), triangles: Vec::new() };
        let mut below: Option<Vec<u32>> = None;
        for (k, ring) in rings.iter().enumerate() {
            // In a flat step most points are the same in both rings: they share a vertex.
            let stands = |i: usize| rings[k - 1].z == ring.z && rings[k - 1].points[i] == ring.points[i];
            let places = (0..POINTS).step_by(stride).enumerate();
            let indices: Vec<u32> = places
                .map(|(k, i)| match &below {
                    Some(below) if stands(i) => below[k],
                    _ => part.vertex(ring.points[i], ring.z),
                })
                .collect();
            match below {
                None => part.cap(ring, &indices, false),
                Some(below) => part.band(&below, &indices),
            }
            below = Some(indices);
        }
        if let (Some(ring), Some(indices)) = (rings.last(), below) {
            part.cap(ring, &indices, true);
        }
        part
    }

    fn vertex(&mut self, point: Vec2, z: f64) -> u32 {
        self.vertices.push([point.x, point.y, z]);
        (self.vertices.len() - 1) as u32
    }

    /// The band between two rings: two triangles for each side, fewer where points are shared.
    fn band(&mut self, low: &[u32], high: &[u32]) {
        for i in 0..low.len() {
            let next = (i + 1) % low.len();
            // Cut along the shorter diagonal: creases stay sharp, and left and right are mirror images.
            let [a, b, c, d] = [low[i], low[next], high[next], high[i]];
            let halves = if self.distance(a, c) <= self.distance(b, d) {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            };
            for triangle in halves {
                let [a, b, c] = triangle;
                if a != b && b != c && c != a {
                    self.triangles.push(triangle);
                }
            }
        }
    }

    /// The squared distance between two vertices \[m²\].
    fn distance(&self, a: u32, b: u32) -> f64 {
        let [p, q] = [a, b].map(|index| self.vertices[index as usize]);
        (0..3).map(|k| (p[k] - q[k]) * (p[k] - q[k])).sum()
    }

    /// Closes a ring with a fan about the mean of its points. All of them are visible from there.
    fn cap(&mut self, ring: &Ring, indices: &[u32], is_top: bool) {
        let sum = ring.points.iter().fold(Vec2::zeros(), |sum, &point| sum + point);
        let centre = self.vertex(sum * (1.0 / POINTS as f64), ring.z);
        for i in 0..indices.len() {
            let (a, b) = (indices[i], indices[(i + 1) % indices.len()]);
            self.triangles.push(if is_top { [centre, a, b] } else { [centre, b, a] });
        }
    }
}

/// Returns numbers of vertices and triangles; and as bytes, little-endian, the coordinates \[m\] in single precision, then
/// the corners' indices: what graphics cards take.
pub fn packed(parts: &[MeshPart]) -> ([usize; 2], Vec<u8>) {
    let (mut places, mut corners, mut first) = (Vec::new(), Vec::new(), 0);
    for part in parts {
        places.extend(part.vertices.iter().flatten().flat_map(|number| (*number as f32).to_le_bytes()));
        corners.extend(part.triangles.iter().flatten().flat_map(|corner| (first + corner).to_le_bytes()));
        first += part.vertices.len() as u32;
    }
    let counts = [places.len() / 12, corners.len() / 12];
    (counts, [places, corners].concat())
}

impl Body3d {
    /// Returns its surface in the body's frame: one closed part each for the trunk with head, the arms and the legs. They do
    /// not overlap. Neighbouring parts may share a plane.
    pub fn mesh(&self) -> Vec<MeshPart> {
        self.surface(1)
    }

    /// Returns the same of an agent at a pose, in world coordinates; the parts' names begin with the agent's Id.
    pub fn surfaces(&self, id: &str, pose: &Pose) -> impl Iterator<Item = MeshPart> + use<> {
        let turn = rotation(pose.orientation);
        let (parts, id, position) = (self.mesh().into_iter(), id.to_owned(), pose.position);
        parts.map(move |mut part| {
            for [x, y, _] in &mut part.vertices {
                let point = turn * vec2(*x, *y) + position;
                (*x, *y) = (point.x, point.y);
            }
            MeshPart { name: format!("agent_{id}_{}", part.name), ..part }
        })
    }

    /// Returns the same with about a sixteenth of the triangles, to be looked at: its corners are on the surface, and its
    /// volume is up to 5 % smaller.
    pub fn coarse_mesh(&self) -> Vec<MeshPart> {
        self.surface(4)
    }

    /// The surface through every `stride`-th ring, the first and the last ones and flat steps, and every `stride`-th point.
    fn surface(&self, stride: usize) -> Vec<MeshPart> {
        let surface = |(part, rings): (BodyPart, &Vec<Ring>)| {
            let last = rings.len().saturating_sub(1);
            let flat = |k: usize| k < last && rings[k].z == rings[k + 1].z;
            let kept =
                |k: &usize| k.is_multiple_of(stride) || *k == last || flat(*k) || (*k > 0 && flat(k - 1));
            let chosen: Vec<&Ring> = (0..=last).filter(kept).map(|k| &rings[k]).collect();
            MeshPart::through(part.name(), &chosen, stride)
        };
        self.parts().map(surface).collect()
    }
}
