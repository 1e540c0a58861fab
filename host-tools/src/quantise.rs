//! A direction to the index of its octahedron face: the inverse of `rho_grid::normal`.

use std::sync::LazyLock;

use glam::DVec3;
use rho_grid::normal::{BITS, OCTANT, child};

/// Triangles above the finest: 1 + 4 + 16 + 64 + 256.
const INNER: usize = (OCTANT - 1) / 3;

/// For each inner triangle, the planes that cut off its three corners, each normal towards its
/// corner; breadth first, so that the children of triangle `t` are `4 t + 1` to `4 t + 4`.
static PLANES: LazyLock<Vec<[DVec3; 3]>> = LazyLock::new(|| {
    let mut triangles = vec![[DVec3::X, DVec3::Y, DVec3::Z]];
    let mut planes = Vec::with_capacity(INNER);
    for t in 0..INNER {
        let [a, b, c] = triangles[t];
        let mids = [a + b, b + c, c + a].map(DVec3::normalize);
        let [ab, bc, ca] = mids;
        let plane = |corner: DVec3, p: DVec3, q: DVec3| {
            let n = p.cross(q);
            n * n.dot(corner).signum()
        };
        planes.push([plane(a, ab, ca), plane(b, bc, ab), plane(c, ca, bc)]);
        triangles.extend((0..4).map(|which| child(which, [a, b, c], mids)));
    }
    planes
});

/// Components below this count as 0. An axis is a corner of eight faces; where a plane lies across
/// an axis, rounding must not choose another of them from sample to sample.
const NOTHING: f64 = 1e-5;

/// The 13-bit index of the face which `normal`, of length 1, passes through.
#[must_use]
pub fn normal_index(normal: DVec3) -> u32 {
    let clean = |c: f64| if c.abs() < NOTHING { 0.0 } else { c };
    let normal = DVec3::new(clean(normal.x), clean(normal.y), clean(normal.z));
    let octant =
        u32::from(normal.x < 0.0) << 2 | u32::from(normal.y < 0.0) << 1 | u32::from(normal.z < 0.0);
    let d = normal.abs();
    let mut index = octant;
    let mut t = 0;
    for _ in 0..(BITS - 3) / 2 {
        let corner = PLANES[t].iter().position(|plane| plane.dot(d) > 0.0);
        let which = corner.map_or(0, |c| c + 1);
        index = index << 2 | which as u32;
        t = 4 * t + 1 + which;
    }
    index
}

#[cfg(test)]
mod tests {
    use super::*;
    use rho_grid::normal::{COUNT, normal};

    fn direction(index: u32) -> DVec3 {
        let [x, y, z] = normal(index).map(|c| f64::from(c.to_bits()) / 16384.0);
        DVec3::new(x, y, z)
    }

    #[test]
    fn every_face_finds_itself() {
        for index in 0..COUNT as u32 {
            assert_eq!(normal_index(direction(index)), index);
        }
    }

    #[test]
    fn rounding_does_not_speckle_a_plane_across_an_axis() {
        let up = normal_index(DVec3::Y);
        for (x, z) in [(1e-7, -1e-8), (-1e-7, 1e-8), (-1e-9, -1e-7), (-0.0, 0.0)] {
            assert_eq!(normal_index(DVec3::new(x, 1.0, z)), up);
        }
    }

    #[test]
    fn no_direction_is_off_by_more_than_the_papers_error() {
        // Table 3 at level 5, as the worst case of 1 - n.q: 9.75e-4.
        let mut worst = 0f64;
        for i in 0..200 {
            for j in 0..400 {
                let (a, b) = (f64::from(i) / 199.0 * 2.0 - 1.0, f64::from(j) / 400.0);
                let r = (1.0 - a * a).max(0.0).sqrt();
                let angle = b * std::f64::consts::TAU;
                let d = DVec3::new(r * angle.cos(), a, r * angle.sin());
                worst = worst.max(1.0 - d.dot(direction(normal_index(d)).normalize()));
            }
        }
        assert!(worst < 1.0e-3, "{worst}");
    }
}
