//! Where a surface of triangles ends.

use std::collections::HashMap;

use glam::DVec3;

use super::Rim;

/// How far apart the places are at most, in sides of the cube.
const APART: f64 = 1.0 / 128.0;
/// An opening of less area than this is a crack: a tenth of a square of that.
const CRACK: f64 = 0.1 * APART * APART;

/// Bits scattered over all 64 (Steele, Lea and Flood, Fast Splittable Pseudorandom Number Generators,
/// 2014: the last steps of SplitMix64).
pub(super) fn mix(bits: u64) -> u64 {
    let z = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// Of a place: vertices at the same one count as one.
pub(super) fn hash(place: DVec3) -> u64 {
    // 0 and -0 are the same place.
    let bits = (place + 0.0).to_array().map(f64::to_bits);
    bits.into_iter().fold(0x9E37_79B9_7F4A_7C15, |hash, bits| {
        mix(hash ^ bits).wrapping_add(bits)
    })
}

/// A side of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    /// Its ends, the same for both ways along it.
    between: [u64; 2],
    /// 1 or -1: the way round its triangle.
    pub(super) way: i32,
    ends: [DVec3; 2],
}

impl Edge {
    pub(super) fn new(ends: [DVec3; 2]) -> Self {
        let [from, to] = ends.map(hash);
        Self {
            between: [from.min(to), from.max(to)],
            way: if from < to { 1 } else { -1 },
            ends,
        }
    }

    /// The same for both ways along it.
    pub(super) fn hash(&self) -> u64 {
        let [one, other] = self.between;
        mix(one ^ mix(other))
    }
}

/// Places along `edges`, those at which a surface ends.
pub(super) fn all(edges: &[Edge]) -> Vec<Rim> {
    let openings = openings(edges);
    // The vector's length is the area of a flat opening; of one that is not, what counts is its size.
    let mut areas: HashMap<usize, (DVec3, f64)> = HashMap::new();
    for (edge, opening) in edges.iter().zip(&openings) {
        let centre = edges[*opening].ends[0];
        let [from, to] = edge.ends.map(|end| end - centre);
        // A surface's edge goes round it as seen from its front, and backs are seen from the other side.
        let part = 0.5 * to.cross(from);
        let (area, size) = areas.entry(*opening).or_default();
        *area += part;
        *size += part.length();
    }
    edges
        .iter()
        .zip(&openings)
        .filter_map(|(edge, opening)| Some((edge, areas.get(opening)?)))
        .filter(|(_, (_, size))| *size > CRACK)
        .flat_map(|(edge, (area, _))| {
            let [from, to] = edge.ends;
            let count = (from.distance(to) / APART).ceil().clamp(1.0, 1000.0);
            (0..count as u32).map(move |i| Rim {
                at: from.lerp(to, (f64::from(i) + 0.5) / count),
                opens: *area,
            })
        })
        .collect()
}

/// The opening of each edge, those that hang together, as the number of one of them.
fn openings(edges: &[Edge]) -> Vec<usize> {
    let mut parents: Vec<usize> = (0..edges.len()).collect();
    fn root(parents: &mut [usize], mut at: usize) -> usize {
        while parents[at] != at {
            parents[at] = parents[parents[at]];
            at = parents[at];
        }
        at
    }
    let mut seen: HashMap<u64, usize> = HashMap::new();
    for (at, edge) in edges.iter().enumerate() {
        for end in edge.between {
            if let Some(other) = seen.insert(end, at) {
                let (a, b) = (root(&mut parents, at), root(&mut parents, other));
                parents[a] = b;
            }
        }
    }
    (0..edges.len()).map(|at| root(&mut parents, at)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rims(triangles: &[[DVec3; 3]]) -> Vec<Rim> {
        let sides = triangles
            .iter()
            .flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
        let edges: Vec<Edge> = sides.map(Edge::new).collect();
        let alone = |edge: &&Edge| edges.iter().filter(|e| e.between == edge.between).count() == 1;
        let single: Vec<Edge> = edges.iter().filter(alone).copied().collect();
        all(&single)
    }

    #[test]
    fn a_square_opens_towards_its_back() {
        let [a, b, c, d] =
            [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let rims = rims(&[[a, b, c], [a, c, d]]);
        assert_eq!(rims.len(), 4 * 128);
        assert!(
            rims.iter()
                .all(|rim| (rim.opens + DVec3::Z).length() < 1e-9)
        );
    }

    #[test]
    fn a_box_without_a_lid_opens_upwards_and_a_crack_is_no_opening() {
        let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let quad = |[a, b, c, d]: [DVec3; 4]| [[a, b, c], [a, c, d]];
        let [a, b, c, d] = [
            p(0.0, 0.0, 0.0),
            p(1.0, 0.0, 0.0),
            p(1.0, 1.0, 0.0),
            p(0.0, 1.0, 0.0),
        ];
        let [e, f, g, h] = [a, b, c, d].map(|v| v + DVec3::Z);
        let sides = [
            [d, c, b, a],
            [a, b, f, e],
            [b, c, g, f],
            [c, d, h, g],
            [d, a, e, h],
        ];
        let box_: Vec<[DVec3; 3]> = sides.into_iter().flat_map(quad).collect();
        let found = rims(&box_);
        assert_eq!(found.len(), 4 * 128);
        assert!(
            found
                .iter()
                .all(|rim| (rim.opens - DVec3::Z).length() < 1e-9)
        );
        let small: Vec<[DVec3; 3]> = box_.iter().map(|t| t.map(|v| v / 500.0)).collect();
        assert!(rims(&small).is_empty());
    }
}
