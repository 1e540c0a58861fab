//! A bounding volume hierarchy over triangles, for rays.

use glam::DVec3;

use super::ray::{Hit, Ray};
use crate::mesh::Mesh;

/// Triangles a leaf at most, unless their centres coincide.
const LEAF: usize = 4;
/// Planes tried an axis, less one.
const BINS: usize = 16;
/// Above this, the two halves are built in parallel.
const PARALLEL: usize = 1 << 13;
/// Boxes are this much larger than what they hold, in cube units: far more than the rounding
/// of the slab test for an eye within 2047 cube sides, far less than a pixel.
const MARGIN: f64 = 1e-9;

#[derive(Clone, Copy, Debug)]
struct Bounds {
    min: DVec3,
    max: DVec3,
}

impl Bounds {
    const EMPTY: Self = Self {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    fn with(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    fn half_area(self) -> f64 {
        let d = (self.max - self.min).max(DVec3::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

/// In the order in which a ray visits when nothing is skipped: a node's first child follows it.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    /// Inner: how many nodes on the second child lies. Leaf: the first of its triangles.
    next: u32,
    /// Leaf: how many triangles; inner: 0.
    count: u32,
}

#[derive(Clone, Copy)]
struct Item {
    bounds: Bounds,
    centre: DVec3,
    triangle: u32,
}

/// A hierarchy over the triangles of a mesh.
#[derive(Debug)]
pub(super) struct Bvh {
    nodes: Vec<Node>,
    /// The corners of the triangles, leaf by leaf.
    corners: Vec<[DVec3; 3]>,
    /// Which triangle of the mesh each is.
    triangles: Vec<u32>,
}

impl Bvh {
    /// The same hierarchy for the same mesh, whatever the number of threads.
    pub(super) fn new(mesh: &Mesh) -> Self {
        let corners = |t: &[u32; 3]| t.map(|i| mesh.positions[i as usize]);
        let mut items: Vec<Item> = mesh
            .triangles
            .iter()
            .zip(0..)
            .map(|(t, triangle)| {
                let [a, b, c] = corners(t);
                let bounds = Bounds {
                    min: a.min(b).min(c),
                    max: a.max(b).max(c),
                };
                Item {
                    bounds,
                    centre: 0.5 * (bounds.min + bounds.max),
                    triangle,
                }
            })
            .collect();
        let mut nodes = Vec::new();
        if !items.is_empty() {
            build(&mut items, 0, &mut nodes);
        }
        Self {
            nodes,
            corners: items
                .iter()
                .map(|item| corners(&mesh.triangles[item.triangle as usize]))
                .collect(),
            triangles: items.iter().map(|item| item.triangle).collect(),
        }
    }

    /// The nearest triangle that the ray meets; among equally near ones, the first of the mesh.
    pub(super) fn nearest(&self, ray: &Ray) -> Option<(u32, Hit)> {
        let mut best: Option<(u32, Hit)> = None;
        let mut end = f64::INFINITY;
        // Deeper than any hierarchy over 2^32 triangles that splits by the middle; the vector
        // grows for a stranger one.
        let mut open: Vec<(usize, f64)> = Vec::with_capacity(64);
        if let Some(root) = self.nodes.first() {
            open.extend(enter(root, ray, end).map(|t| (0, t)));
        }
        while let Some((mut at, from)) = open.pop() {
            if from > end {
                continue;
            }
            loop {
                let node = &self.nodes[at];
                if node.count > 0 {
                    let first = node.next as usize;
                    for i in first..first + node.count as usize {
                        if let Some(hit) = ray.meet(&self.corners[i]) {
                            let triangle = self.triangles[i];
                            if hit.t < end
                                || hit.t == end && best.is_some_and(|(b, _)| triangle < b)
                            {
                                end = hit.t;
                                best = Some((triangle, hit));
                            }
                        }
                    }
                    break;
                }
                let (a, b) = (at + 1, at + node.next as usize);
                let near = enter(&self.nodes[a], ray, end);
                let far = enter(&self.nodes[b], ray, end);
                at = match (near, far) {
                    (Some(ta), Some(tb)) if ta <= tb => {
                        open.push((b, tb));
                        a
                    }
                    (Some(ta), Some(_)) => {
                        open.push((a, ta));
                        b
                    }
                    (Some(_), None) => a,
                    (None, Some(_)) => b,
                    (None, None) => break,
                };
            }
        }
        best
    }
}

/// Where the ray enters the box, unless it misses it or that lies beyond `end`.
fn enter(node: &Node, ray: &Ray, end: f64) -> Option<f64> {
    let a = (node.bounds.min - ray.origin) * ray.inverse;
    let b = (node.bounds.max - ray.origin) * ray.inverse;
    let from = a.min(b).max_element().max(0.0);
    let to = a.max(b).min_element();
    (from <= to && from <= end).then_some(from)
}

/// Appends the hierarchy over `items`, of which the first is number `first` of all.
fn build(items: &mut [Item], first: usize, nodes: &mut Vec<Node>) {
    let empty = (Bounds::EMPTY, Bounds::EMPTY);
    let (bounds, centres) = items.iter().fold(empty, |(bounds, centres), item| {
        let centre = Bounds {
            min: item.centre,
            max: item.centre,
        };
        (bounds.with(item.bounds), centres.with(centre))
    });
    let at = nodes.len();
    nodes.push(Node {
        bounds: Bounds {
            min: bounds.min - DVec3::splat(MARGIN),
            max: bounds.max + DVec3::splat(MARGIN),
        },
        next: first as u32,
        count: items.len() as u32,
    });
    if items.len() <= LEAF {
        return;
    }
    let Some(middle) = split(items, centres) else {
        return;
    };
    let (left, right) = items.split_at_mut(middle);
    nodes[at].count = 0;
    if left.len() + right.len() > PARALLEL {
        let mut second = Vec::new();
        rayon::join(
            || build(left, first, nodes),
            || build(right, first + middle, &mut second),
        );
        nodes[at].next = (nodes.len() - at) as u32;
        nodes.append(&mut second);
    } else {
        build(left, first, nodes);
        nodes[at].next = (nodes.len() - at) as u32;
        build(right, first + middle, nodes);
    }
}

/// Parts the items at the plane of least cost (surface area times number) and says where the
/// second part begins; `None` when all centres coincide.
fn split(items: &mut [Item], centres: Bounds) -> Option<usize> {
    let extent = centres.max - centres.min;
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in 0..3 {
        if extent[axis] <= 0.0 {
            continue;
        }
        let mut bins = [(Bounds::EMPTY, 0usize); BINS];
        for item in items.iter() {
            let (bounds, count) = &mut bins[bin(item, centres, axis)];
            *bounds = bounds.with(item.bounds);
            *count += 1;
        }
        let mut below = [0.0; BINS];
        let mut sum = (Bounds::EMPTY, 0);
        for (cost, bin) in below.iter_mut().zip(&bins) {
            sum = (sum.0.with(bin.0), sum.1 + bin.1);
            *cost = sum.0.half_area() * sum.1 as f64;
        }
        let mut sum = (Bounds::EMPTY, 0);
        for plane in (1..BINS).rev() {
            sum = (sum.0.with(bins[plane].0), sum.1 + bins[plane].1);
            let cost = below[plane - 1] + sum.0.half_area() * sum.1 as f64;
            if sum.1 > 0 && sum.1 < items.len() && best.is_none_or(|(b, ..)| cost < b) {
                best = Some((cost, axis, plane));
            }
        }
    }
    let (_, axis, plane) = best?;
    // Both parts hold at least one item.
    let mut middle = 0;
    for i in 0..items.len() {
        if bin(&items[i], centres, axis) < plane {
            items.swap(i, middle);
            middle += 1;
        }
    }
    Some(middle)
}

fn bin(item: &Item, centres: Bounds, axis: usize) -> usize {
    let from = centres.min[axis];
    let part = (item.centre[axis] - from) / (centres.max[axis] - from);
    ((part * BINS as f64) as usize).min(BINS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles scattered by a multiplicative sequence, some of them doubled.
    fn scattered(count: u32) -> Mesh {
        let mut mesh = Mesh::default();
        let number =
            |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24) - 0.5;
        for i in 0..count {
            let seed = i / 10 * 9 + i % 10 % 9;
            let centre = DVec3::new(number(3 * seed), number(3 * seed + 1), number(3 * seed + 2));
            let base = 3 * i;
            for k in 0..3 {
                let off = DVec3::new(
                    number(seed + 7 * k),
                    number(seed + 11 * k),
                    number(seed + 13 * k),
                );
                mesh.positions.push(centre + 0.2 * off);
            }
            mesh.triangles.push([base, base + 1, base + 2]);
        }
        mesh
    }

    #[test]
    fn the_hierarchy_finds_what_a_search_of_all_triangles_finds() {
        let mesh = scattered(500);
        let bvh = Bvh::new(&mesh);
        let mut hits = 0;
        for i in 0..40 {
            for j in 0..40 {
                let ray = Ray::new(
                    DVec3::new(0.1, -0.2, 2.0),
                    DVec3::new(f64::from(i) / 40.0 - 0.5, f64::from(j) / 40.0 - 0.4, -2.0),
                );
                let mut expected: Option<(u32, Hit)> = None;
                for (t, number) in mesh.triangles.iter().zip(0..) {
                    if let Some(hit) = ray.meet(&t.map(|i| mesh.positions[i as usize]))
                        && expected.is_none_or(|(_, e)| hit.t < e.t)
                    {
                        expected = Some((number, hit));
                    }
                }
                let found = bvh.nearest(&ray);
                hits += usize::from(found.is_some());
                assert_eq!(
                    found.map(|(t, h)| (t, h.t)),
                    expected.map(|(t, h)| (t, h.t))
                );
            }
        }
        assert!(hits > 250, "{hits}");
    }

    #[test]
    fn triangles_with_one_centre_end_in_one_leaf() {
        let mut mesh = scattered(1);
        mesh.triangles = vec![[0, 1, 2]; 50];
        let bvh = Bvh::new(&mesh);
        assert_eq!(bvh.nodes.len(), 1);
        let centre = (mesh.positions[0] + mesh.positions[1] + mesh.positions[2]) / 3.0;
        let ray = Ray::new(
            DVec3::new(0.0, 0.0, 3.0),
            centre - DVec3::new(0.0, 0.0, 3.0),
        );
        assert_eq!(bvh.nearest(&ray).unwrap().0, 0);
    }

    #[test]
    fn a_mesh_without_triangles_is_never_met() {
        let bvh = Bvh::new(&Mesh::default());
        assert!(bvh.nearest(&Ray::new(DVec3::ZERO, DVec3::X)).is_none());
    }
}
