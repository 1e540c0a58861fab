//! The space in which a directional light sees: two axes across its direction and one along it.
//!
//! A light that is infinitely far away sees in parallel, so that a point's place there is linear in
//! its coordinates: no division, and displacements that hold everywhere (paper, section 5.3).

use super::cells::{self, Cell};
use crate::blob::format::MAX_SUBDIVISIONS;
use crate::blob::{Grid, Instance};
use crate::q::Unit;

/// A directional light, and the bounds of what it shines on.
#[derive(Clone, Copy, Debug)]
pub struct LightSpace {
    /// u, v across the light, d away from it, in the scene's axes, Q14.
    axes: [[i32; 3]; 3],
    /// Least and greatest u, v, d of all that is held, Q16 sides of the scene's cube from its centre.
    pub(super) bounds: [(i32, i32); 3],
}

/// The same as seen from an instance's cube.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    /// In the cube's axes, Q14.
    pub(super) axes: [[i32; 3]; 3],
    /// The cube's side in sides of the scene's, Q30.
    scale: i64,
    /// Its centre's u, v, d, Q16 sides of the scene's cube.
    pub(super) centre: [i32; 3],
}

/// Bounds are those of the cells of a level of at most so many nodes; and of the level below it,
/// where these may reach beyond what others are sure to reach.
const FEW: u32 = 128;

/// Nothing was held yet: from two sides before the centre to two behind.
const NOTHING: (i32, i32) = (1 << 17, -(1 << 17));

impl LightSpace {
    /// No light; all zeros, so that a static costs no flash.
    pub(super) const NONE: Self = Self {
        axes: [[0; 3]; 3],
        bounds: [(0, 0); 3],
    };

    /// A light towards `towards`, a unit vector in the scene's axes, that shines on nothing yet.
    #[must_use]
    pub fn towards(towards: [Unit; 3]) -> Self {
        let l = towards.map(|c| i32::from(c.to_bits()));
        let [lx, ly, lz] = l;
        // Across the light, and across the axis that it is farthest from.
        let [x, y, z] = l.map(i32::abs);
        let across = if x <= y && x <= z {
            [0, -lz, ly]
        } else if y <= z {
            [lz, 0, -lx]
        } else {
            [-ly, lx, 0]
        };
        // Of a vector of any length, so that a light of none does not divide by it.
        let square: i32 = across.iter().map(|v| v * v).sum();
        let length = square.isqrt().max(1);
        let u = across.map(|v| (v << 14) / length);
        let [ux, uy, uz] = u;
        let v = [ly * uz - lz * uy, lz * ux - lx * uz, lx * uy - ly * ux];
        Self {
            axes: [u, v.map(|v| v >> 14), l.map(|c| -c)],
            bounds: [NOTHING; 3],
        }
    }

    /// The axes from an instance's cube, rounded to nearest.
    pub(super) fn local(&self, instance: &Instance) -> Local {
        let [x, y, z] = instance
            .rotation
            .map(|row| row.map(|v| i64::from(v.to_bits())));
        let ([xa, xb, xc], [ya, yb, yc], [za, zb, zc]) = (x, y, z);
        let t = instance.translation.map(|v| i64::from(v.to_bits()));
        let [tx, ty, tz] = t;
        let turned = |[u, v, w]: [i64; 3]| {
            let sums = [
                xa * u + ya * v + za * w,
                xb * u + yb * v + zb * w,
                xc * u + yc * v + zc * w,
            ];
            sums.map(|sum| ((sum + (1 << 29)) >> 30) as i32)
        };
        let axes = self.axes.map(|axis| axis.map(i64::from));
        Local {
            axes: axes.map(turned),
            scale: i64::from(instance.scale.to_bits()),
            // Q44 to Q16.
            centre: axes.map(|[u, v, w]| ((tx * u + ty * v + tz * w) >> 28) as i32),
        }
    }

    /// Along each axis of an instance's cube, whether higher cells are nearer to the light.
    pub(super) fn higher(&self, instance: &Instance) -> [bool; 3] {
        let [_, _, away] = self.local(instance).axes;
        away.map(|c| c < 0)
    }

    /// Widens the bounds so that they hold the cells of an instance's `grid`.
    pub fn hold(&mut self, instance: &Instance, grid: &Grid<'_>) {
        let local = self.local(instance);
        let levels = grid.levels().iter();
        let coarse = levels.take_while(|level| level.nodes <= FEW).count();
        let coarse = coarse.saturating_sub(1);
        // What is in a cell reaches at least to its farther side.
        let mut sure = [NOTHING; 3];
        local.spans(grid, coarse, |_, span| {
            for ((low, high), (from, to)) in sure.iter_mut().zip(span) {
                (*low, *high) = ((*low).min(to), (*high).max(from));
            }
            true
        });
        let mut bounds = self.bounds;
        for ((low, high), (from, to)) in bounds.iter_mut().zip(sure) {
            (*low, *high) = ((*low).min(from), (*high).max(to));
        }
        local.spans(grid, coarse + 1, |level, span| {
            let mut beyond = false;
            for ((low, high), (from, to)) in sure.iter().zip(span) {
                beyond |= from < *low || to > *high;
            }
            if beyond && level > coarse {
                for ((low, high), (from, to)) in bounds.iter_mut().zip(span) {
                    (*low, *high) = ((*low).min(from), (*high).max(to));
                }
            }
            beyond
        });
        self.bounds = bounds;
    }

    /// Extents along u (or v, if that is more) and along d, Q16 sides, at least a quarter of a side, so
    /// that places have 31 bits.
    pub(super) fn extents(&self) -> (i32, i32) {
        let [u, v, d] = self
            .bounds
            .map(|(low, high)| high.saturating_sub(low).max(1 << 14));
        (u.max(v), d)
    }
}

impl Local {
    /// Asks `enter` with the level of each cell, down to `last`, and with its first and last u, v and d
    /// (Q16 sides of the scene's cube from its centre, rounded outwards); its subcells come if it says so.
    fn spans(
        &self,
        grid: &Grid<'_>,
        last: usize,
        mut enter: impl FnMut(usize, [(i32, i32); 3]) -> bool,
    ) {
        let half = self
            .axes
            .map(|axis| axis.iter().map(|c| c.abs()).sum::<i32>());
        let mut cells = [1; MAX_SUBDIVISIONS + 1];
        for (level, cells) in cells.iter_mut().enumerate().take(last + 1) {
            *cells = grid.cells(level) as i32;
        }
        cells::walk(grid, |Cell { level, place, .. }| {
            let cells = cells.get(level).copied().unwrap_or(1);
            let [x, y, z] = place.map(|p| 2 * p + 1 - cells);
            let mut spans = [(0, 0); 3];
            let axes = self.axes.iter().zip(half).zip(self.centre);
            for (span, (([ax, ay, az], half), centre)) in spans.iter_mut().zip(axes) {
                // Q14 in half cells.
                let at = ax * x + ay * y + az * z;
                let scene = |v: i32| {
                    // Q16 sides of the cube.
                    let own = i64::from(v * 2 / cells);
                    centre + ((own * self.scale) >> 30) as i32
                };
                *span = (scene(at - half) - 2, scene(at + half) + 2);
            }
            enter(level, spans) && level < last
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_axes_are_across_each_other_and_of_length_one(
            yaw in -3.2..3.2f64, pitch in -1.57..1.57f64
        ) {
            let towards = [yaw.sin() * pitch.cos(), pitch.sin(), yaw.cos() * pitch.cos()];
            let light = LightSpace::towards(towards.map(|c| Unit::from_bits((c * 16384.0).round() as i16)));
            for (i, a) in light.axes.iter().enumerate() {
                for (j, b) in light.axes.iter().enumerate() {
                    let dot: f64 = (0..3).map(|k| f64::from(a[k]) * f64::from(b[k])).sum();
                    let expected = if i == j { 1.0 } else { 0.0 };
                    prop_assert!((dot / f64::from(1 << 28) - expected).abs() < 5e-4, "{i} {j}");
                }
            }
            let away: f64 = (0..3).map(|k| f64::from(light.axes[2][k]) * towards[k]).sum();
            prop_assert!(away < 0.0);
        }
    }

    #[test]
    fn a_light_of_no_length_is_no_division_by_it() {
        let light = LightSpace::towards([Unit::ZERO; 3]);
        assert_eq!(light.axes[2], [0; 3]);
        assert_eq!(light.extents(), (1 << 14, 1 << 14));
    }
}
