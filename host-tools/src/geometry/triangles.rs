//! A mesh answers both questions of sampling: see [`Geometry`] and, for one triangle,
//! [`super::triangle`].

use std::borrow::Cow;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::cells::{Cell, Subcells};
use super::portion::{Portion, gather};
use super::rim::{self, Edge};
use super::triangle::{self, Corners};
use super::{Geometry, Rim, Sample, WHITE};
use crate::mesh::Mesh;

/// The triangles of a mesh, made ready for many questions. Needs 72 bytes a triangle beside
/// the mesh.
#[derive(Clone, Debug)]
pub struct Triangles<'a> {
    mesh: Cow<'a, Mesh>,
    corners: Vec<Corners>,
}

impl<'a> Triangles<'a> {
    /// Gathers the corners.
    #[must_use]
    pub fn new(mesh: &'a Mesh) -> Self {
        Self::of(Cow::Borrowed(mesh))
    }

    /// The same for a mesh that nobody else needs.
    #[must_use]
    pub fn owning(mesh: Mesh) -> Triangles<'static> {
        Triangles::of(Cow::Owned(mesh))
    }

    fn of(mesh: Cow<'a, Mesh>) -> Self {
        let corner = |v: u32| mesh.positions[v as usize];
        let corners = mesh.triangles.iter().map(|t| t.map(corner)).collect();
        Self { mesh, corners }
    }

    /// Whether each edge goes one way as often as the other, vertices at the same place counted as
    /// one: sums of hashes cancel then, and but for one chance in 2^64 only then.
    fn is_closed(&self) -> bool {
        let of_triangle = |corners: &Corners| {
            let [a, b, c] = corners.map(rim::hash);
            let edges = [(a, b), (b, c), (c, a)];
            edges.into_iter().fold(0u64, |sum, (from, to)| {
                sum.wrapping_add(rim::mix(from ^ rim::mix(to)))
                    .wrapping_sub(rim::mix(to ^ rim::mix(from)))
            })
        };
        let sums = self.corners.par_iter().map(of_triangle);
        sums.reduce(|| 0, u64::wrapping_add) == 0
    }

    /// The triangle's point with these weights, which lies at `position`.
    fn sample(&self, primitive: u32, weights: [f64; 3], position: DVec3) -> Sample {
        let vertices = self.mesh.triangles[primitive as usize];
        let face = || {
            let normal = triangle::area_normal(&self.corners[primitive as usize]);
            normal.try_normalize().unwrap_or(DVec3::Y)
        };
        let normal = interpolate(vertices, weights, |v| self.mesh.normals.get(v).copied());
        Sample {
            position,
            // Normals that point against each other leave nothing but noise.
            normal: normal
                .filter(|n| n.length_squared() > 1e-12)
                .map_or_else(face, DVec3::normalize),
            colour: interpolate(vertices, weights, |v| {
                let colour = self.mesh.colours.get(v)?;
                Some(DVec3::from_array(colour.map(f64::from)))
            })
            .map_or(WHITE, |c| c.to_array().map(|x| x.round() as u8)),
        }
    }
}

impl Geometry for Triangles<'_> {
    fn primitives(&self) -> u32 {
        self.corners.len() as u32
    }

    fn meets(&self, primitive: u32, subcells: &Subcells) -> u128 {
        triangle::meets(&self.corners[primitive as usize], subcells)
    }

    fn crosses(&self, primitive: u32, subcells: &Subcells) -> u128 {
        triangle::crosses(&self.corners[primitive as usize], subcells)
    }

    fn sample_at(&self, primitives: &[u32], centre: DVec3) -> Option<Sample> {
        let mut best = f64::INFINITY;
        let mut found = None;
        for &primitive in primitives {
            let corners = &self.corners[primitive as usize];
            let weights = triangle::nearest(corners, centre);
            let position = triangle::point(corners, weights);
            let distance = centre.distance_squared(position);
            if distance < best {
                best = distance;
                found = Some((primitive, weights, position));
            }
        }
        let (primitive, weights, position) = found?;
        Some(self.sample(primitive, weights, position))
    }

    fn portion(&self, primitives: &[u32], cell: &Cell) -> Option<Portion> {
        let (low, high) = cell.corners();
        let pieces = primitives.iter().filter_map(|&primitive| {
            let corners = &self.corners[primitive as usize];
            let (area, centre) = triangle::within(corners, low, high)?;
            let weights = triangle::weights(corners, centre);
            Some((area, self.sample(primitive, weights, centre)))
        });
        gather(cell, pieces, || self.sample_at(primitives, cell.centre()))
    }

    fn weighted_area(&self, weight: fn(DVec3) -> f64) -> f64 {
        let areas = self.corners.iter().map(triangle::area_normal);
        areas.map(|normal| 0.5 * weight(normal.abs())).sum()
    }

    /// Along the edges that do not go one way as often as the other.
    fn rims(&self) -> Option<Arc<[Rim]>> {
        if self.is_closed() {
            return Some(Arc::new([]));
        }
        // A hash and a number: of millions of edges few are those where the surface ends.
        let edge = |side: u32| {
            let corners = &self.corners[(side / 3) as usize];
            let from = (side % 3) as usize;
            Edge::new([corners[from], corners[(from + 1) % 3]])
        };
        let mut sides: Vec<(u64, u32)> = (0..3 * self.primitives())
            .into_par_iter()
            .map(|side| (edge(side).hash(), side))
            .collect();
        sides.par_sort_unstable();
        let single: Vec<Edge> = sides
            .chunk_by(|(a, _), (b, _)| a == b)
            .filter(|same| same.iter().map(|(_, side)| edge(*side).way).sum::<i32>() != 0)
            .map(|same| edge(same[0].1))
            .collect();
        Some(rim::all(&single).into())
    }

    fn mesh(&self) -> Cow<'_, Mesh> {
        Cow::Borrowed(&self.mesh)
    }
}

/// The attribute of three vertices, weighted; `None` when the mesh does not have it.
fn interpolate(
    vertices: [u32; 3],
    weights: [f64; 3],
    attribute: impl Fn(usize) -> Option<DVec3>,
) -> Option<DVec3> {
    let mut sum = DVec3::ZERO;
    for (vertex, weight) in vertices.into_iter().zip(weights) {
        sum += weight * attribute(vertex as usize)?;
    }
    Some(sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A right angle at the origin in the plane z = 0.
    fn mesh() -> Mesh {
        Mesh {
            positions: vec![DVec3::ZERO, 0.4 * DVec3::X, 0.4 * DVec3::Y],
            normals: vec![DVec3::Z, DVec3::X, DVec3::Z],
            colours: vec![[0, 0, 0], [200, 0, 0], [0, 100, 7]],
            triangles: vec![[0, 1, 2]],
        }
    }

    #[test]
    fn normals_and_colours_are_interpolated_at_the_nearest_point() {
        let mesh = mesh();
        let geometry = Triangles::new(&mesh);
        let sample = geometry
            .sample_at(&[0], DVec3::new(0.2, -0.1, 0.3))
            .unwrap();
        assert!((sample.position - 0.2 * DVec3::X).length() < 1e-15);
        assert!((sample.normal - (DVec3::X + DVec3::Z).normalize()).length() < 1e-12);
        assert_eq!(sample.colour, [100, 0, 0]);
    }

    #[test]
    fn where_vertex_normals_cancel_the_face_speaks() {
        let mut mesh = mesh();
        mesh.normals = vec![DVec3::X, -DVec3::X, DVec3::X];
        mesh.colours.clear();
        let geometry = Triangles::new(&mesh);
        let sample = geometry
            .sample_at(&[0], DVec3::new(0.2, -0.1, 0.3))
            .unwrap();
        assert_eq!(sample.normal, DVec3::Z);
        assert_eq!(sample.colour, WHITE);
    }

    #[test]
    fn the_nearest_of_several_is_taken_and_the_first_of_equals() {
        let mut mesh = mesh();
        mesh.triangles.push([2, 1, 0]);
        mesh.positions.push(DVec3::new(0.0, 0.0, 0.25));
        mesh.normals.push(DVec3::Y);
        mesh.colours.push([9; 3]);
        mesh.triangles.push([3, 3, 3]);
        let geometry = Triangles::new(&mesh);
        let near = |z: f64| geometry.sample_at(&[0, 1, 2], DVec3::new(0.0, 0.0, z));
        assert_eq!(near(0.3).unwrap().colour, [9; 3]);
        assert_eq!(near(0.1).unwrap().colour, [0; 3]);
        assert_eq!(geometry.sample_at(&[], DVec3::ZERO), None);
    }

    #[test]
    fn an_area_is_weighted_by_its_normal() {
        let mut mesh = mesh();
        let area = |mesh: &Mesh| Triangles::new(mesh).weighted_area(DVec3::element_sum);
        assert!((area(&mesh) - 0.08).abs() < 1e-15);
        mesh.positions[2] = DVec3::new(0.0, 0.4, 0.4);
        assert!((area(&mesh) - 0.16).abs() < 1e-15);
    }
}
