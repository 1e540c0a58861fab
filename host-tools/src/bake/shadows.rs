//! Shadows of a light that is fixed to the model, baked into its materials.
//!
//! A ray from each sample towards the light, and a second material for what it does not reach: the same
//! without diffuse light. The device knows nothing of it, and draws as fast as any model with materials does.

use glam::{DVec3, UVec3};
use rayon::prelude::*;

use crate::reference::Caster;
use crate::sampling::Tree;

/// How far from a sample its ray begins, in sides of its cell, towards the light. Closer than this, the surface within
/// the cell that the sample stands for would shade it; farther away, creases lose their shadows.
const TOWARDS: f64 = 0.5;

/// Marks the samples between which and a light towards `towards` (of length 1) something lies.
pub(super) fn shade(tree: &mut Tree, caster: &Caster<'_>, towards: DVec3) {
    let mut places = vec![UVec3::ZERO];
    let mut cells = 1;
    for (depth, level) in tree.levels.iter_mut().enumerate() {
        let side = 1.0 / f64::from(cells);
        level
            .samples
            .par_iter_mut()
            .zip(&places)
            .for_each(|(sample, place)| {
                let centre = (place.as_dvec3() + 0.5) * side - 0.5;
                let normal = DVec3::from(sample.normal);
                let surface = centre + f64::from(sample.offset) * side * normal;
                let start = surface + TOWARDS * side * towards;
                // What faces away is dark as it is.
                sample.shaded =
                    sample.normal.dot(towards.as_vec3()) > 0.0 && caster.is_between(start, towards);
            });
        if let Some(rho) = tree.sequence.get(depth) {
            let rho = u32::from(*rho);
            cells *= rho;
            places = below(&places, &level.masks, rho);
        }
    }
}

/// The places of the children of nodes at `places`, among the cells of their level.
fn below(places: &[UVec3], masks: &[u128], rho: u32) -> Vec<UVec3> {
    let nodes = places.iter().zip(masks);
    nodes
        .flat_map(|(place, mask)| {
            let subcells = (0..rho.pow(3)).filter(move |bit| mask >> bit & 1 == 1);
            subcells.map(move |bit| {
                let subcell = UVec3::new(bit % rho, bit / rho % rho, bit / (rho * rho));
                place * rho + subcell
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicU64;

    use super::*;
    use crate::geometry::triangles::Triangles;
    use crate::mesh::Mesh;
    use crate::sampling::{Sampling, Separation, Sequence};

    /// Squares of that half side at that height, facing up.
    fn squares(all: &[(f64, f64)]) -> Mesh {
        let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
        let positions =
            |(half, y): &(f64, f64)| corners.map(|(x, z)| DVec3::new(half * x, *y, half * z));
        Mesh {
            positions: all.iter().flat_map(positions).collect(),
            normals: vec![DVec3::Y; 4 * all.len()],
            colours: Vec::new(),
            triangles: (0..all.len() as u32)
                .flat_map(|n| [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i| 4 * n + i)))
                .collect(),
        }
    }

    #[test]
    fn a_roof_shades_the_floor_below_it_and_nothing_else() {
        let mesh = squares(&[(0.49, -0.3), (0.2, 0.3)]);
        let sampling = Sampling {
            sequence: Sequence::new(&[3, 3, 3]).unwrap(),
            separation: Separation::TwentySix,
            memory: 1 << 30,
        };
        let geometry = Triangles::new(&mesh);
        let mut tree = sampling.sample(&geometry, &AtomicU64::new(0)).unwrap();
        shade(&mut tree, &Caster::new(&mesh), DVec3::Y);
        let mut places = vec![UVec3::ZERO];
        for (level, rho) in tree.levels.iter().zip(&tree.sequence) {
            places = below(&places, &level.masks, u32::from(*rho));
        }
        let leaves = &tree.levels.last().unwrap().samples;
        assert_eq!(leaves.len(), places.len());
        for (sample, place) in leaves.iter().zip(places) {
            let at = (place.as_vec3() + 0.5) / 27.0 - 0.5;
            let is_below = at.y < 0.0 && at.x.abs().max(at.z.abs()) < 0.2;
            // Half a cell at the shadow's edge.
            if (at.x.abs().max(at.z.abs()) - 0.2).abs() > 0.02 {
                assert_eq!(sample.shaded, is_below, "{at}");
            }
        }
    }
}
