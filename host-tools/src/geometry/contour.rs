//! The zeros of a field as triangles, by dual contouring (Ju, Losasso, Schaefer & Warren 2002).
//!
//! Every cell in which the sign changes has one vertex, placed where the tangent planes at the
//! crossed edges meet best, so that edges and corners stay sharp; every crossed edge joins the
//! four cells round it. Cells are found by halving the cube and leaving out what is farther
//! from the surface than half a diagonal.
//!
//! The vertices lie on the surface. Between them a surface of curvature k is missed by k/8
//! squares of a cell's diagonal at most; an edge or corner by a quarter of a cell; what is
//! thinner than a cell may be lost.

use std::collections::HashMap;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::cells::{Cell, plane};
use super::field::Field;
use crate::mesh::Mesh;

/// What keeps the vertex near the middle of its crossings where the planes leave it free: a
/// hundredth of what a plane pulls.
const REST: f64 = 0.01;

/// The mesh of the surface within the cube, of `n` cells an axis, at most 1024. Where the
/// surface leaves the cube it is open.
pub(super) fn contour<F: Field>(field: &F, n: u32) -> Mesh {
    let mut cells = vec![Cell::ROOT];
    let mut per_axis = 1;
    // Halved as often as n is even, then cut into what is left.
    while per_axis < n {
        let left = n / per_axis;
        let rho = if left.is_multiple_of(2) { 2 } else { left };
        cells = cells
            .par_iter()
            .flat_map_iter(|cell| {
                let parts = (0..rho.pow(3)).map(move |i| {
                    let part = [i % rho, i / rho % rho, i / (rho * rho)];
                    Cell {
                        per_axis: per_axis * rho,
                        index: [0, 1, 2].map(|axis| cell.index[axis] * rho + part[axis]),
                    }
                });
                parts.filter(|part| {
                    field.value(part.centre()).abs() <= part.side() * 0.866_025_403_784_438_8
                })
            })
            .collect();
        per_axis *= rho;
    }
    let vertices: Vec<([u32; 3], u8, DVec3)> = cells
        .par_iter()
        .filter_map(|cell| {
            let (signs, place) = vertex(field, cell)?;
            Some((cell.index, signs, place))
        })
        .collect();
    let number: HashMap<[u32; 3], u32> = vertices
        .iter()
        .zip(0..)
        .map(|((index, ..), number)| (*index, number))
        .collect();
    let mut mesh = Mesh {
        positions: vertices.iter().map(|(.., place)| *place).collect(),
        normals: vertices
            .par_iter()
            .map(|(.., place)| field.normal(*place))
            .collect(),
        colours: vertices
            .par_iter()
            .map(|(.., place)| field.colour(*place))
            .collect(),
        triangles: Vec::new(),
    };
    for (index, signs, _) in &vertices {
        for axis in 0..3 {
            // The edge at the cell's lowest corner, and the cells round it.
            let (inside, beyond) = (signs & 1 == 1, signs >> (1 << axis) & 1 == 1);
            if inside == beyond {
                continue;
            }
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let around = |du: u32, dv: u32| {
                let mut at = *index;
                at[u] = at[u].checked_sub(du)?;
                at[v] = at[v].checked_sub(dv)?;
                number.get(&at).copied()
            };
            let ring = (around(1, 1), around(0, 1), around(0, 0), around(1, 0));
            let (Some(a), Some(b), Some(c), Some(d)) = ring else {
                continue;
            };
            let quad = if inside { [a, b, c, d] } else { [d, c, b, a] };
            cut(&mut mesh, quad);
        }
    }
    mesh
}

/// Cuts a quad along the shorter diagonal.
fn cut(mesh: &mut Mesh, [a, b, c, d]: [u32; 4]) {
    let place = |v: u32| mesh.positions[v as usize];
    let (ac, bd) = (place(a).distance(place(c)), place(b).distance(place(d)));
    mesh.triangles.extend(if ac <= bd {
        [[a, b, c], [a, c, d]]
    } else {
        [[a, b, d], [b, c, d]]
    });
}

/// Which corners of a cell are inside, a bit each, and its vertex; `None` when all are on one
/// side.
fn vertex<F: Field>(field: &F, cell: &Cell) -> Option<(u8, DVec3)> {
    let corner = |i: usize| {
        let at = |axis: usize| plane(cell.index[axis] + (i >> axis & 1) as u32, cell.per_axis);
        DVec3::new(at(0), at(1), at(2))
    };
    let corners: [DVec3; 8] = std::array::from_fn(corner);
    let values = corners.map(|corner| field.value(corner));
    let signs = (0..8).fold(0, |signs, i| signs | u8::from(values[i] < 0.0) << i);
    if signs == 0 || signs == 255 {
        return None;
    }
    let mut crossings = Vec::with_capacity(12);
    for i in 0..8 {
        for axis in 0..3 {
            let j = i | 1 << axis;
            if i != j && (values[i] < 0.0) != (values[j] < 0.0) {
                let at = crossing(field, (corners[i], values[i]), (corners[j], values[j]));
                crossings.push((at, field.normal(at)));
            }
        }
    }
    let middle = crossings.iter().map(|(at, _)| *at).sum::<DVec3>() / crossings.len() as f64;
    let mut matrix = DMat3::from_diagonal(DVec3::splat(REST));
    let mut pull = DVec3::ZERO;
    for (at, normal) in &crossings {
        matrix += DMat3::from_cols(*normal * normal.x, *normal * normal.y, *normal * normal.z);
        pull += *normal * normal.dot(*at - middle);
    }
    let (low, high) = (corners[0], corners[7]);
    let place = (middle + matrix.inverse() * pull).clamp(low, high);
    let on_surface = field
        .zero_near(place)
        .filter(|zero| zero.distance(place) <= 0.5 * cell.side());
    Some((
        signs,
        on_surface.map_or(place, |zero| zero.clamp(low, high)),
    ))
}

/// Where the sign changes between two places (Illinois: regula falsi that does not stick).
fn crossing<F: Field>(field: &F, mut a: (DVec3, f64), mut b: (DVec3, f64)) -> DVec3 {
    const STEPS: u32 = 12;
    for _ in 0..STEPS {
        let share = a.1 / (a.1 - b.1);
        let at = a.0.lerp(b.0, share);
        let value = field.value(at);
        if value.abs() < 1e-12 {
            return at;
        }
        if (value < 0.0) == (b.1 < 0.0) {
            a.1 *= 0.5;
        } else {
            a = b;
        }
        b = (at, value);
    }
    b.0
}

#[cfg(test)]
mod tests {
    use super::super::triangle;
    use super::*;

    /// A cube of half side 0.3, turned away from the axes.
    struct Block;

    const AXES: [DVec3; 3] = [
        DVec3::new(0.6, 0.8, 0.0),
        DVec3::new(-0.48, 0.36, 0.8),
        DVec3::new(0.64, -0.48, 0.6),
    ];

    impl Field for Block {
        fn value(&self, at: DVec3) -> f64 {
            let faces = AXES.map(|axis| at.dot(axis).abs() - 0.3);
            faces.into_iter().fold(f64::NEG_INFINITY, f64::max)
        }

        fn colour(&self, _: DVec3) -> [u8; 3] {
            [9; 3]
        }
    }

    #[test]
    fn edges_and_corners_stay_sharp_and_the_mesh_is_closed() {
        let mesh = contour(&Block, 40);
        let mut edges = HashMap::new();
        let mut volume = 0.0;
        for triangle in &mesh.triangles {
            let corners = triangle.map(|v| mesh.positions[v as usize]);
            volume += triangle::area_normal(&corners).dot(corners[0]) / 6.0;
            for i in 0..3 {
                *edges
                    .entry((triangle[i], triangle[(i + 1) % 3]))
                    .or_insert(0) += 1;
            }
        }
        assert!(
            edges
                .iter()
                .all(|((a, b), n)| *n == 1 && edges.get(&(*b, *a)) == Some(&1))
        );
        assert!((volume / 0.216 - 1.0).abs() < 2e-3, "{volume}");
        let corner = 0.3 * (AXES[0] + AXES[1] + AXES[2]);
        let near = mesh.positions.iter().map(|p| p.distance(corner));
        let near = near.fold(f64::INFINITY, f64::min);
        assert!(near < 0.25 / 40.0, "{near}");
    }

    #[test]
    fn every_number_of_cells_does_and_a_surface_that_leaves_the_cube_is_open() {
        struct Floor;
        impl Field for Floor {
            fn value(&self, at: DVec3) -> f64 {
                at.y - 0.123
            }
            fn colour(&self, _: DVec3) -> [u8; 3] {
                [9; 3]
            }
        }
        for n in [1, 7, 12, 32] {
            let mesh = contour(&Floor, n);
            assert_eq!(mesh.positions.len(), (n * n) as usize);
            assert_eq!(mesh.triangles.len(), 2 * ((n - 1) * (n - 1)) as usize);
            assert!(mesh.positions.iter().all(|p| (p.y - 0.123).abs() < 1e-9));
            assert!(mesh.normals.iter().all(|n| n.distance(DVec3::Y) < 1e-6));
        }
    }
}
