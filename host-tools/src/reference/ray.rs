//! Where a ray meets a triangle, without cracks between triangles that share an edge.
//!
//! The ray is sheared onto an axis and the triangle seen along it, so that each edge gives one
//! signed area that the neighbour computes with the opposite sign and nothing else (Woop,
//! Benthin and Wald, Watertight Ray/Triangle Intersection, JCGT 2013).

use glam::DVec3;

/// A ray with what every test of it shares.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    pub(super) origin: DVec3,
    /// One over the direction, finite also where that is 0.
    pub(super) inverse: DVec3,
    /// The axis of the largest part of the direction comes last; the others in the order that
    /// keeps the winding.
    axes: [usize; 3],
    /// What brings the direction onto the last axis at length 1.
    shear: DVec3,
}

/// A point on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hit {
    /// How far along, in lengths of the ray's direction; more than 0.
    pub(super) t: f64,
    /// The weights of the three corners; their sum is 1.
    pub(super) weights: [f64; 3],
}

impl Ray {
    /// `direction` is not zero and need not have length 1.
    pub(super) fn new(origin: DVec3, direction: DVec3) -> Self {
        let size = direction.abs();
        let z = if size.x > size.y && size.x > size.z {
            0
        } else if size.y > size.z {
            1
        } else {
            2
        };
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let axes = if direction[z] < 0.0 {
            [y, x, z]
        } else {
            [x, y, z]
        };
        let shear = DVec3::new(direction[axes[0]], direction[axes[1]], 1.0) / direction[z];
        // So small that a box is missed or met whatever its size, and 0 times it is 0.
        let inverse = |d: f64| if d == 0.0 { 1e300 } else { 1.0 / d };
        Self {
            origin,
            inverse: DVec3::from(direction.to_array().map(inverse)),
            axes,
            shear,
        }
    }

    /// Where the ray meets the triangle, from either side; borders belong to it.
    pub(super) fn meet(&self, corners: &[DVec3; 3]) -> Option<Hit> {
        let [x, y, z] = self.axes;
        let [a, b, c] = corners.map(|p| {
            let p = p - self.origin;
            DVec3::new(p[x] - self.shear.x * p[z], p[y] - self.shear.y * p[z], p[z])
        });
        let u = c.x * b.y - c.y * b.x;
        let v = a.x * c.y - a.y * c.x;
        let w = b.x * a.y - b.y * a.x;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let sum = u + v + w;
        if sum == 0.0 {
            return None;
        }
        let weights = [u / sum, v / sum, w / sum];
        let t = self.shear.z * (weights[0] * a.z + weights[1] * b.z + weights[2] * c.z);
        (t > 0.0).then_some(Hit { t, weights })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [DVec3; 3] = [
        DVec3::new(0.0, 0.0, 1.0),
        DVec3::new(1.0, 0.0, 1.0),
        DVec3::new(0.0, 1.0, 2.0),
    ];

    #[test]
    fn a_ray_meets_a_triangle_at_the_weights_of_its_corners() {
        let weights = [0.2, 0.3, 0.5];
        let target = weights[0] * TRIANGLE[0] + weights[1] * TRIANGLE[1] + weights[2] * TRIANGLE[2];
        for origin in [
            DVec3::new(0.3, 0.2, -4.0),
            DVec3::new(5.0, 0.1, 1.0),
            DVec3::new(0.1, -7.0, 1.5),
            DVec3::new(0.3, 0.2, 9.0),
        ] {
            let hit = Ray::new(origin, (target - origin) / 4.0)
                .meet(&TRIANGLE)
                .unwrap();
            assert!((hit.t - 4.0).abs() < 1e-12);
            for (found, expected) in hit.weights.iter().zip(weights) {
                assert!((found - expected).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn what_lies_behind_or_beside_is_missed() {
        let up = Ray::new(DVec3::new(0.2, 0.2, 3.0), DVec3::Z);
        assert_eq!(up.meet(&TRIANGLE), None);
        let beside = Ray::new(DVec3::new(0.8, 0.8, 0.0), DVec3::Z);
        assert_eq!(beside.meet(&TRIANGLE), None);
        let edge_on = Ray::new(DVec3::new(-1.0, 0.0, 1.0), DVec3::X);
        let flat = [
            DVec3::new(0.0, -1.0, 1.0),
            DVec3::new(0.0, 1.0, 1.0),
            DVec3::new(1.0, 0.0, 1.0),
        ];
        assert_eq!(edge_on.meet(&flat), None);
    }

    #[test]
    fn no_ray_slips_through_the_edges_of_a_fan() {
        // Slivers round a centre; rays towards points on their shared edges and near them.
        let rim = |i: u32| {
            let angle = f64::from(i) * std::f64::consts::TAU / 97.0;
            DVec3::new(angle.cos(), angle.sin(), 0.1 * (7.0 * angle).sin())
        };
        let centre = DVec3::new(0.017, -0.031, 0.3);
        let fan: Vec<[DVec3; 3]> = (0..97)
            .map(|i| [centre, rim(i), rim((i + 1) % 97)])
            .collect();
        for i in 0..97 {
            for step in 0..50 {
                let target = centre.lerp(rim(i), f64::from(step) / 50.0);
                for origin in [DVec3::new(0.2, 0.3, 5.0), DVec3::new(-0.4, 0.1, -3.0)] {
                    let ray = Ray::new(origin, target - origin);
                    assert!(fan.iter().any(|t| ray.meet(t).is_some()), "{i} {step}");
                }
            }
        }
    }
}
