//! An implicit surface answers both questions of sampling: see [`Geometry`] and [`Field`].
//!
//! The whole surface is one primitive. A box without the surface is recognised by the value
//! at its centre, which is larger than half its diagonal; one with it, by values of both signs
//! among centre and corners. What is neither is cut into eight, a few times; what then still
//! is neither counts as met, so that no part of the surface is lost: such a box is nearer to
//! it than 0.06 of a subcell, where the value is the distance.

use std::borrow::Cow;
use std::sync::OnceLock;

use glam::DVec3;

use super::cells::Subcells;
use super::contour::contour;
use super::field::Field;
use super::{Geometry, Sample};
use crate::mesh::Mesh;

/// How often a box is cut before it counts as met.
const CUTS: u32 = 4;

/// Half the diagonal of the smallest box, in sides of a subcell.
#[cfg(test)]
const SLACK: f64 = 0.866_025_403_784_438_6 / (1 << CUTS) as f64;

/// Half the diagonal of a cube of half side 1, rounded up.
const DIAGONAL: f64 = 1.732_050_807_568_877_5;

/// Cells an axis of the mesh that the number of leaves is foreseen by.
const COARSE: u32 = 96;

/// A field as an object.
#[derive(Debug)]
pub(super) struct Implicit<F> {
    field: F,
    /// Cells an axis of the mesh that stands for it.
    detail: u32,
    coarse: OnceLock<Mesh>,
}

impl<F: Field> Implicit<F> {
    /// The surface of `field` within the cube; its mesh has `detail` cells an axis.
    pub(super) fn new(field: F, detail: u32) -> Self {
        Self {
            field,
            detail,
            coarse: OnceLock::new(),
        }
    }

    /// Whether the box about `centre` is met.
    fn meets_box(&self, centre: DVec3, half: f64) -> bool {
        let value = self.field.value(centre);
        if value.abs() > DIAGONAL * half {
            return false;
        }
        let other_side = |i| self.field.value(corner(centre, half, i)) * value <= 0.0;
        (0..8).any(other_side) || self.meets_part(centre, half, value, CUTS)
    }

    /// Whether one of the eight parts of a box holds a zero or a value of another sign than
    /// `sign`, or cannot be told from one that does after so many cuts.
    fn meets_part(&self, centre: DVec3, half: f64, sign: f64, cuts: u32) -> bool {
        let half = 0.5 * half;
        (0..8).any(|i| {
            let middle = corner(centre, half, i);
            let value = self.field.value(middle);
            value * sign <= 0.0
                || value.abs() <= DIAGONAL * half
                    && (cuts == 1 || self.meets_part(middle, half, sign, cuts - 1))
        })
    }

    /// Whether the surface crosses the segment.
    fn cuts(&self, from: DVec3, to: DVec3) -> bool {
        /// The shortest step, in lengths of the segment: what comes and goes between two of
        /// them is not seen.
        const STEP: f64 = 1.0 / 4096.0;
        let (first, last) = (self.field.value(from), self.field.value(to));
        let length = from.distance(to);
        if first * last <= 0.0 {
            return true;
        }
        // No zero lies within the value of either end.
        let mut at = first.abs();
        while at < length - last.abs() {
            let value = self.field.value(from.lerp(to, at / length));
            if value * first <= 0.0 {
                return true;
            }
            at += value.abs().max(STEP * length);
        }
        false
    }

    /// The nearest zero that is found from a place.
    fn nearest(&self, centre: DVec3) -> Option<DVec3> {
        self.field.zero_near(centre).or_else(|| {
            // Where the normal leads in circles, look in all directions.
            let directions = (0..27_i32).filter(|&i| i != 13).map(|i| {
                let part = |i: i32| f64::from(i % 3 - 1);
                DVec3::new(part(i), part(i / 3), part(i / 9)).normalize()
            });
            let found = directions.filter_map(|direction| self.along(centre, direction));
            let by_distance =
                |a: &f64, b: &f64| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal);
            found.min_by(|a, b| by_distance(&a.distance(centre), &b.distance(centre)))
        })
    }

    /// The first zero on a ray within the cube's diagonal.
    fn along(&self, from: DVec3, direction: DVec3) -> Option<DVec3> {
        const STEPS: u32 = 256;
        let mut at = 0.0;
        for _ in 0..STEPS {
            let value = self.field.value(from + at * direction).abs();
            if value <= 1e-9 {
                return Some(from + at * direction);
            }
            at += value;
            if at > DIAGONAL {
                break;
            }
        }
        None
    }

    fn mask(&self, subcells: &Subcells, holds: impl Fn(DVec3) -> bool) -> u128 {
        let mut mask = 0;
        for (k, &z) in subcells.centres(2).iter().enumerate() {
            for (j, &y) in subcells.centres(1).iter().enumerate() {
                for (i, &x) in subcells.centres(0).iter().enumerate() {
                    if holds(DVec3::new(x, y, z)) {
                        mask |= 1 << subcells.bit(i, j, k);
                    }
                }
            }
        }
        mask
    }
}

/// Corner number `i` of a box.
fn corner(centre: DVec3, half: f64, i: u32) -> DVec3 {
    let side = |axis: u32| if i >> axis & 1 == 0 { -half } else { half };
    centre + DVec3::new(side(0), side(1), side(2))
}

impl<F: Field> Geometry for Implicit<F> {
    fn primitives(&self) -> u32 {
        1
    }

    fn meets(&self, _: u32, subcells: &Subcells) -> u128 {
        self.mask(subcells, |centre| self.meets_box(centre, subcells.half()))
    }

    fn crosses(&self, _: u32, subcells: &Subcells) -> u128 {
        let half = subcells.half();
        self.mask(subcells, |centre| {
            self.field.value(centre).abs() <= half
                && DVec3::AXES
                    .iter()
                    .any(|&axis| self.cuts(centre - half * axis, centre + half * axis))
        })
    }

    fn sample_at(&self, primitives: &[u32], centre: DVec3) -> Option<Sample> {
        primitives.first()?;
        let position = self.nearest(centre)?;
        Some(Sample {
            position,
            normal: self.field.normal(position),
            colour: self.field.colour(position),
        })
    }

    fn weighted_area(&self, weight: fn(DVec3) -> f64) -> f64 {
        let mesh = self.coarse.get_or_init(|| contour(&self.field, COARSE));
        super::triangles::Triangles::new(mesh).weighted_area(weight)
    }

    fn mesh(&self) -> Cow<'_, Mesh> {
        Cow::Owned(contour(&self.field, self.detail))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::cells::Cell;
    use super::*;

    /// Of radius 0.4, a little beside the middle.
    struct Ball;

    const MIDDLE: DVec3 = DVec3::new(0.01, -0.02, 0.03);

    impl Field for Ball {
        fn value(&self, at: DVec3) -> f64 {
            at.distance(MIDDLE) - 0.4
        }

        fn colour(&self, _: DVec3) -> [u8; 3] {
            [1, 2, 3]
        }
    }

    fn ball() -> Implicit<Ball> {
        Implicit::new(Ball, 64)
    }

    /// The least and the largest distance of a box's points from the ball's middle.
    fn distances(cell: &Cell) -> (f64, f64) {
        let (low, high) = cell.corners();
        let near = MIDDLE.clamp(low, high);
        let far = DVec3::select((MIDDLE - low).cmpgt(high - MIDDLE), low, high);
        (near.distance(MIDDLE), far.distance(MIDDLE))
    }

    proptest! {
        #[test]
        fn a_ball_meets_and_crosses_the_boxes_that_it_should(
            n in 1..40_u32, index in prop::array::uniform3(0..40_u32), rho in 1..=5_u8
        ) {
            let cell = Cell { per_axis: n, index: index.map(|i| i % n) };
            let subcells = Subcells::of(&cell, rho);
            let (met, crossed) = (ball().meets(0, &subcells), ball().crosses(0, &subcells));
            prop_assert_eq!(crossed & !met, 0);
            for bit in 0..u32::from(rho).pow(3) {
                let child = cell.child(rho, bit);
                let (near, far) = distances(&child);
                let slack = SLACK * child.side();
                let (inner, outer) = (near <= 0.4 && 0.4 <= far, near <= 0.4 + slack && 0.4 <= far + slack);
                let meets = met >> bit & 1 == 1;
                prop_assert!(!inner || meets, "{:?} is met", child);
                prop_assert!(outer || !meets, "{:?} is not met", child);

                let (centre, half) = (child.centre(), 0.5 * child.side());
                let crosses = DVec3::AXES.iter().any(|&axis| {
                    let (a, b) = (centre - half * axis, centre + half * axis);
                    let at = (MIDDLE - a).dot(axis).clamp(0.0, 2.0 * half);
                    let near = (a + at * axis).distance(MIDDLE);
                    let far = a.distance(MIDDLE).max(b.distance(MIDDLE));
                    near <= 0.4 && 0.4 <= far
                });
                prop_assert_eq!(crossed >> bit & 1 == 1, crosses);
            }
        }
    }

    #[test]
    fn the_sample_is_the_nearest_point() {
        for place in [DVec3::new(0.3, 0.1, -0.2), DVec3::new(0.5, 0.5, 0.5)] {
            let sample = ball().sample_at(&[0], place).unwrap();
            let normal = (place - MIDDLE).normalize();
            assert!(sample.position.distance(MIDDLE + 0.4 * normal) < 1e-8);
            assert!(sample.normal.distance(normal) < 1e-6);
            assert_eq!(sample.colour, [1, 2, 3]);
        }
        assert!(ball().sample_at(&[], DVec3::ZERO).is_none());
        // From the middle every direction is as good, and none is told by the field.
        let sample = ball().sample_at(&[0], MIDDLE).unwrap();
        assert!((sample.position.distance(MIDDLE) - 0.4).abs() < 1e-8);
    }

    #[test]
    fn the_area_is_that_of_the_ball() {
        let area = ball().weighted_area(DVec3::length);
        let expected = 4.0 * std::f64::consts::PI * 0.16;
        assert!((area / expected - 1.0).abs() < 2e-3, "{area}");
    }
}
