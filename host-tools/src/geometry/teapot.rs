//! The Utah teapot (Martin Newell, 1975) on a round slab, from its Bezier patches.
//!
//! The pot's 32 patches are few curves. Rim, body, lid and bottom are surfaces of revolution:
//! a profile in (radius, height) turned through four quarters, each a cubic that replaces the
//! arc's 0.5523 by 0.56. Handle and spout are sections of two by two points, mirrored, along
//! a curve. So the numbers below are those profiles and sections, in Newell's units and
//! without the squeeze of 1.3 in height that his original had; y is up.
//!
//! The slab is made of the same kind of patches, with true quarters.

use std::borrow::Cow;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::cells::{Cell, Subcells};
use super::patch::{Patch, Piece};
use super::portion::{Portion, gather};
use super::{Geometry, Sample, triangle};
use crate::mesh::Mesh;

/// Four control points in (radius, height).
type Profile = [(f64, f64); 4];

/// From the lid's knob down to the middle of the bottom, outside on the left going down.
const POT: [Profile; 6] = [
    // Lid.
    [(0.0, 3.15), (0.8, 3.15), (0.0, 2.85), (0.2, 2.7)],
    [(0.2, 2.7), (0.4, 2.55), (1.3, 2.55), (1.3, 2.4)],
    // Rim.
    [(1.4, 2.4), (1.3375, 2.53125), (1.4375, 2.53125), (1.5, 2.4)],
    // Body.
    [(1.5, 2.4), (1.75, 1.875), (2.0, 1.35), (2.0, 0.9)],
    [(2.0, 0.9), (2.0, 0.45), (1.5, 0.225), (1.5, 0.15)],
    // Bottom.
    [(1.5, 0.15), (1.5, 0.075), (1.425, 0.0), (0.0, 0.0)],
];

/// One control section of a tube that is symmetric to the plane z = 0: where its two rows of
/// control points lie in (x, y), and how far from that plane.
struct Section {
    inner: (f64, f64),
    outer: (f64, f64),
    width: f64,
}

const fn section(inner: (f64, f64), outer: (f64, f64), width: f64) -> Section {
    Section {
        inner,
        outer,
        width,
    }
}

/// From where it leaves the body at the top.
const HANDLE: [Section; 7] = [
    section((-1.6, 2.025), (-1.5, 2.25), 0.3),
    section((-2.3, 2.025), (-2.5, 2.25), 0.3),
    section((-2.7, 2.025), (-3.0, 2.25), 0.3),
    section((-2.7, 1.8), (-3.0, 1.8), 0.3),
    section((-2.7, 1.575), (-3.0, 1.35), 0.3),
    section((-2.5, 1.125), (-2.65, 0.9375), 0.3),
    section((-2.0, 0.9), (-1.9, 0.6), 0.3),
];

/// From inside the body, to the tip and a little back into it.
const SPOUT: [Section; 7] = [
    section((1.7, 1.425), (1.7, 0.6), 0.66),
    section((2.6, 1.425), (3.1, 0.825), 0.66),
    section((2.3, 2.1), (2.4, 2.025), 0.25),
    section((2.7, 2.4), (3.3, 2.4), 0.25),
    section((2.8, 2.475), (3.525, 2.49375), 0.25),
    section((2.9, 2.475), (3.45, 2.5125), 0.15),
    section((2.8, 2.4), (3.2, 2.4), 0.15),
];

/// A quarter of a circle as Newell drew it, as he drew it on the knob, and nearest the truth.
const NEWELL: f64 = 0.56;
const KNOB: [f64; 4] = [NEWELL, 0.5625, NEWELL, NEWELL];
const CIRCLE: f64 = 0.552_284_75;

/// The slab's middle along x, under the middle of the pot with handle and spout; its radius,
/// its thickness, and the radius of the ring inlaid in its top.
const MIDDLE: f64 = 0.217;
const RADIUS: f64 = 3.6;
const THICKNESS: f64 = 0.3;
const RING: (f64, f64) = (2.85, 3.1);

/// The top of the pot.
const HEIGHT: f64 = 3.15;

const GLAZE: [u8; 3] = [214, 122, 66];
const STONE: [u8; 3] = [104, 124, 140];
const INLAY: [u8; 3] = [226, 216, 188];

/// How far, in cube units, the pieces that serve as primitives may be from the surface: a
/// hundredth of a cell at 1,000 cells an axis.
const FLAT: f64 = 1e-5;

/// Rows and columns into which [`Geometry::mesh`] cuts a patch; the triangles lie within 4e-5
/// of the surface.
const MESH: u32 = 64;

/// The teapot on its slab.
#[derive(Clone, Debug)]
pub struct Teapot {
    patches: Vec<(Patch, [u8; 3])>,
    /// The primitives, each with the number of its patch.
    pieces: Vec<(Piece, usize)>,
}

impl Default for Teapot {
    fn default() -> Self {
        Self::new()
    }
}

impl Teapot {
    /// Lays out the patches and cuts them into primitives.
    #[must_use]
    pub fn new() -> Self {
        let mut patches = Vec::new();
        for (part, profile) in POT.iter().enumerate() {
            let arcs = if part == 0 { KNOB } else { [NEWELL; 4] };
            patches.extend(turned(profile, 0.0, arcs).map(|patch| (patch, GLAZE)));
        }
        for tube in [&HANDLE, &SPOUT] {
            for half in [&tube[..4], &tube[3..]] {
                patches.extend(mirrored(half).map(|patch| (patch, GLAZE)));
            }
        }
        for (profile, colour) in slab() {
            patches.extend(turned(&profile, MIDDLE, [CIRCLE; 4]).map(|patch| (patch, colour)));
        }
        for point in patches
            .iter_mut()
            .flat_map(|(patch, _)| patch.points.as_flattened_mut())
        {
            *point =
                (*point - DVec3::new(MIDDLE, 0.5 * (HEIGHT - THICKNESS), 0.0)) / (2.0 * RADIUS);
        }
        let pieces = patches
            .par_iter()
            .enumerate()
            .flat_map_iter(|(number, (patch, _))| {
                let mut parts = Vec::new();
                patch.pieces(FLAT, &mut parts);
                parts.into_iter().map(move |piece| (piece, number))
            })
            .collect();
        Self { patches, pieces }
    }
}

/// A profile turned about the vertical axis at `x`, a patch a quarter: u goes round from +x
/// to +z, v along the profile.
fn turned(profile: &Profile, x: f64, arcs: [f64; 4]) -> [Patch; 4] {
    // In (x, z).
    let axes = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
    [0, 1, 2, 3].map(|quarter| {
        let (start, end) = (axes[quarter], axes[(quarter + 1) % 4]);
        let mut patch = Patch {
            points: [[DVec3::ZERO; 4]; 4],
        };
        for (row, ((radius, height), arc)) in patch.points.iter_mut().zip(profile.iter().zip(arcs))
        {
            *row = [start, start + arc * end, arc * start + end, end]
                .map(|at| DVec3::new(x + radius * at.x, *height, radius * at.y));
        }
        patch
    })
}

/// Both halves of a tube along four sections.
fn mirrored(sections: &[Section]) -> [Patch; 2] {
    [1.0, -1.0].map(|side| {
        let mut patch = Patch {
            points: [[DVec3::ZERO; 4]; 4],
        };
        for (row, section) in patch.points.iter_mut().zip(sections) {
            let at = |(x, y): (f64, f64), z: f64| DVec3::new(x, y, side * z);
            *row = [
                at(section.inner, 0.0),
                at(section.inner, section.width),
                at(section.outer, section.width),
                at(section.outer, 0.0),
            ];
            if side < 0.0 {
                row.reverse();
            }
        }
        patch
    })
}

/// The slab's profiles, from the middle of its top outwards, round its edge, and back.
fn slab() -> [(Profile, [u8; 3]); 6] {
    let line = |from: f64, to: f64, height: f64| {
        // So weighted that both ends are exact: a pole must be one point.
        [0.0, 1.0, 2.0, 3.0].map(|third| ((from * (3.0 - third) + to * third) / 3.0, height))
    };
    let bevel = 0.5 * THICKNESS;
    let edge = RADIUS - bevel;
    let bulge = bevel * (1.0 - CIRCLE);
    let side = [
        (edge, 0.0),
        (RADIUS - bulge, 0.0),
        (RADIUS, -bulge),
        (RADIUS, -bevel),
    ];
    let mut under = side.map(|(radius, height)| (radius, -THICKNESS - height));
    under.reverse();
    [
        (line(0.0, RING.0, 0.0), STONE),
        (line(RING.0, RING.1, 0.0), INLAY),
        (line(RING.1, edge, 0.0), STONE),
        (side, STONE),
        (under, STONE),
        (line(edge, 0.0, -THICKNESS), STONE),
    ]
}

impl Geometry for Teapot {
    fn primitives(&self) -> u32 {
        self.pieces.len() as u32
    }

    fn meets(&self, primitive: u32, subcells: &Subcells) -> u128 {
        let [a, b] = &self.pieces[primitive as usize].0.triangles;
        triangle::meets(a, subcells) | triangle::meets(b, subcells)
    }

    fn crosses(&self, primitive: u32, subcells: &Subcells) -> u128 {
        let [a, b] = &self.pieces[primitive as usize].0.triangles;
        triangle::crosses(a, subcells) | triangle::crosses(b, subcells)
    }

    fn sample_at(&self, primitives: &[u32], centre: DVec3) -> Option<Sample> {
        let mut best = f64::INFINITY;
        let mut found = None;
        for &primitive in primitives {
            let (piece, patch) = &self.pieces[primitive as usize];
            let (point, u, v) = piece.nearest(centre);
            let distance = centre.distance_squared(point);
            if distance < best {
                best = distance;
                found = Some((*patch, u, v));
            }
        }
        let (patch, u, v) = found?;
        let (patch, colour) = &self.patches[patch];
        let (u, v) = patch.approach(centre, u, v);
        Some(Sample {
            position: patch.at(u, v),
            normal: patch.normal(u, v),
            colour: *colour,
        })
    }

    fn portion(&self, primitives: &[u32], cell: &Cell) -> Option<Portion> {
        let (low, high) = cell.corners();
        let halves = primitives.iter().flat_map(|&primitive| {
            let (piece, patch) = &self.pieces[primitive as usize];
            (0..2).map(move |half| (piece, &self.patches[*patch], half))
        });
        let pieces = halves.filter_map(|(piece, (patch, colour), half)| {
            let corners = &piece.triangles[half];
            let (area, centre) = triangle::within(corners, low, high)?;
            let (u, v) = piece.at(half, triangle::weights(corners, centre));
            let sample = Sample {
                position: centre,
                normal: patch.normal(u, v),
                colour: *colour,
            };
            Some((area, sample))
        });
        gather(cell, pieces, || self.sample_at(primitives, cell.centre()))
    }

    fn weighted_area(&self, weight: fn(DVec3) -> f64) -> f64 {
        let triangles = self.pieces.iter().flat_map(|(piece, _)| &piece.triangles);
        triangles
            .map(|corners| 0.5 * weight(triangle::area_normal(corners).abs()))
            .sum()
    }

    fn mesh(&self) -> Cow<'_, Mesh> {
        let mut mesh = Mesh::default();
        for (patch, colour) in &self.patches {
            let first = mesh.positions.len() as u32;
            for row in 0..=MESH {
                for column in 0..=MESH {
                    let [u, v] = [column, row].map(|i| f64::from(i) / f64::from(MESH));
                    mesh.positions.push(patch.at(u, v));
                    mesh.normals.push(patch.normal(u, v));
                    mesh.colours.push(*colour);
                }
            }
            for row in 0..MESH {
                for column in 0..MESH {
                    let a = first + row * (MESH + 1) + column;
                    let (b, c, d) = (a + 1, a + MESH + 1, a + MESH + 2);
                    for triangle in [[a, b, d], [a, d, c]] {
                        let corners = triangle.map(|v| mesh.positions[v as usize]);
                        // At a pole every other triangle is a line, but for rounding.
                        if triangle::area_normal(&corners).length() > 1e-14 {
                            mesh.triangles.push(triangle);
                        }
                    }
                }
            }
        }
        Cow::Owned(mesh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn everything(pot: &Teapot) -> Vec<u32> {
        (0..pot.primitives()).collect()
    }

    #[test]
    fn the_slab_is_as_wide_as_the_cube_and_nothing_reaches_out() {
        let pot = Teapot::new();
        let mesh = pot.mesh();
        let low = mesh.positions.iter().copied().reduce(DVec3::min).unwrap();
        let high = mesh.positions.iter().copied().reduce(DVec3::max).unwrap();
        let half = DVec3::new(0.5, 0.5 * (HEIGHT + THICKNESS) / (2.0 * RADIUS), 0.5);
        assert!((high - half).length() < 1e-12, "{high}");
        assert!((low + half).length() < 1e-12, "{low}");
    }

    #[test]
    fn the_normals_are_of_length_1_and_agree_with_the_triangles() {
        let mesh = Teapot::new().mesh().into_owned();
        for triangle in &mesh.triangles {
            let face = triangle::area_normal(&triangle.map(|v| mesh.positions[v as usize]));
            for v in triangle {
                let normal = mesh.normals[*v as usize];
                assert!((normal.length() - 1.0).abs() < 1e-12);
                let cosine = face.normalize().dot(normal);
                assert!(cosine > 0.8, "{cosine} at {}", mesh.positions[*v as usize]);
            }
        }
    }

    #[test]
    fn poles_and_places_between_them_face_where_they_should() {
        let pot = Teapot::new();
        let all = everything(&pot);
        let place = |x: f64, y: f64, z: f64| {
            DVec3::new(x - MIDDLE, y - 0.5 * (HEIGHT - THICKNESS), z) / (2.0 * RADIUS)
        };
        for (from, to, normal) in [
            // The knob's top, the slab's middle from below, the body from four sides.
            ((0.0, 3.3, 0.0), (0.0, 3.15, 0.0), DVec3::Y),
            ((MIDDLE, -0.4, 0.0), (MIDDLE, -0.3, 0.0), DVec3::NEG_Y),
            ((0.0, 0.9, 2.2), (0.0, 0.9, 2.0), DVec3::Z),
            ((0.0, 0.9, -2.2), (0.0, 0.9, -2.0), DVec3::NEG_Z),
            // The slab's rim and top.
            (
                (MIDDLE + 3.7, -0.15, 0.0),
                (MIDDLE + 3.6, -0.15, 0.0),
                DVec3::X,
            ),
            ((MIDDLE - 3.2, 0.1, 0.0), (MIDDLE - 3.2, 0.0, 0.0), DVec3::Y),
            // The handle from above, the spout's belly from the side.
            ((-2.0, 2.4, 0.0), (-2.0, 2.22, 0.0), DVec3::Y),
            ((2.4, 1.2, 1.0), (2.4, 1.2, 0.4), DVec3::Z),
        ] {
            let sample = pot.sample_at(&all, place(from.0, from.1, from.2)).unwrap();
            let off = sample.position.distance(place(to.0, to.1, to.2)) * 2.0 * RADIUS;
            assert!(off < 0.25, "{from:?}: {off} off");
            let cosine = sample.normal.dot(normal);
            assert!(cosine > 0.8, "{from:?}: {}", sample.normal);
        }
    }

    #[test]
    fn the_pieces_lie_on_the_surface() {
        let pot = Teapot::new();
        for (piece, patch) in pot.pieces.iter().step_by(101) {
            let patch = &pot.patches[*patch].0;
            let middle = patch.at(
                f64::midpoint(piece.u[0], piece.u[1]),
                f64::midpoint(piece.v[0], piece.v[1]),
            );
            let (near, _, _) = piece.nearest(middle);
            assert!(near.distance(middle) <= 2.0 * FLAT);
            let corner = patch.at(piece.u[0], piece.v[0]);
            assert!(corner.distance(piece.triangles[0][0]) < 1e-14);
        }
    }

    #[test]
    fn the_ground_has_colours_of_its_own() {
        let pot = Teapot::new();
        let colour = |x: f64, y: f64| pot.sample_at(&everything(&pot), DVec3::new(x, y, 0.0));
        assert_eq!(colour(0.49, -0.2).unwrap().colour, STONE);
        assert_eq!(colour(2.95 / 7.2, -0.19).unwrap().colour, INLAY);
        assert_eq!(colour(0.0, 0.3).unwrap().colour, GLAZE);
    }
}
