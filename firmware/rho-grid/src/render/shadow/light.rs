//! The space in which a directional light sees: two axes across its direction and one along it.
//!
//! A light that is infinitely far away sees in parallel, so that a point's place there is linear in
//! its coordinates: no division, and displacements that hold everywhere (paper, section 5.3).

use super::cells::{self, Cell};
use crate::blob::format::MAX_SUBDIVISIONS;
use crate::blob::{Grid, Instance, Object};
use crate::camera::Camera;
use crate::q::{Focal, Length, Rotation, Unit};

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

    /// A camera that sees as the light does, nearly: so far away that lines of sight meet at less than a tenth of a
    /// degree, with all of the scene in view.
    pub(crate) fn eye(&self) -> Camera {
        let [u, v, away] = self.axes;
        Camera {
            rotation: [u, v, away.map(|c| -c)].map(|row| row.map(|c| Rotation::from_bits(c << 16))),
            translation: [Length::ZERO, Length::ZERO, Length::from_bits(-1000 << 20)],
            focal: Focal::ONE,
            width: Camera::MAX_SIDE,
            height: Camera::MAX_SIDE,
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

    /// Whether the bounds hold the box of an instance's object already, and half a cell all round of its
    /// coarsest grid, which has so many cells an axis: all that is seen of it in whatever grid.
    pub(super) fn holds(&self, instance: &Instance, object: &Object, cells: u32) -> bool {
        let local = self.local(instance);
        // A cell's side, Q15, and more for what is rounded.
        let beyond = (1 << 15) / cells.max(1) as i32 + 2;
        let [low, high] = object
            .bounds
            .map(|corner| corner.map(|v| i32::from(v.to_bits())));
        let mut held = true;
        let axes = local.axes.iter().zip(local.centre).zip(self.bounds);
        for ((axis, centre), (from, to)) in axes {
            let (mut middle, mut half) = (0, 0);
            for ((along, low), high) in axis.iter().zip(low).zip(high) {
                // Twice, Q29.
                middle += i64::from(along * (low + high));
                half += i64::from(along.abs()) * i64::from(high - low + beyond);
            }
            // Q30 and Q30 to Q16.
            let [middle, half] = [middle, half].map(|v| (((v >> 14) * local.scale) >> 30) as i32);
            held &= centre + middle - half > from + 2 && centre + middle + half < to - 2;
        }
        held
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
        // Of each level: cells an axis; half a cell's side, Q30 sides of the scene's cube; half a cell's extent.
        let mut levels = [(1, 0, [0; 3]); MAX_SUBDIVISIONS + 1];
        for (level, (cells, side, reach)) in levels.iter_mut().enumerate().take(last + 1) {
            *cells = grid.cells(level) as i32;
            *side = 2 * self.scale / i64::from(*cells);
            *reach = half.map(|half| ((i64::from(half) * *side) >> 30) as i32 + 3);
        }
        cells::walk(grid, |Cell { level, place, .. }| {
            let (cells, side, reach) = levels.get(level).copied().unwrap_or_default();
            let [x, y, z] = place.map(|p| 2 * p + 1 - cells);
            let mut spans = [(0, 0); 3];
            let axes = self.axes.iter().zip(self.centre).zip(reach);
            for (span, (([ax, ay, az], centre), reach)) in spans.iter_mut().zip(axes) {
                // Q14 in half cells, to Q16 sides of the scene's cube.
                let at = i64::from(ax * x + ay * y + az * z);
                let middle = centre + ((at * side) >> 30) as i32;
                *span = (middle - reach, middle + reach);
            }
            enter(level, spans) && level < last
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::q::{Extent, Place, Scale};
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

    proptest! {
        #[test]
        fn an_instance_is_held_when_its_box_lies_within_the_bounds(
            yaw in -3.2..3.2f64, turn in -3.2..3.2f64, scale in 0.01..1.5f64,
            at in proptest::array::uniform3(-1.0..1.0f64),
            low in proptest::array::uniform3(-0.5..0.0f64), high in proptest::array::uniform3(0.0..0.5f64),
            room in -0.02..0.02f64,
        ) {
            let towards = [yaw.sin() * 0.8, 0.6, yaw.cos() * 0.8];
            let mut light = LightSpace::towards(towards.map(|c| Unit::from_bits((c * 16384.0) as i16)));
            let rows = [[turn.cos(), 0.0, turn.sin()], [0.0, 1.0, 0.0], [-turn.sin(), 0.0, turn.cos()]];
            let instance = Instance {
                rotation: rows.map(|row| row.map(|v| Rotation::from_bits((v * f64::from(1 << 30)) as i32))),
                scale: Scale::from_bits((scale * f64::from(1 << 30)) as u32),
                translation: at.map(|v| Place::from_bits((v * f64::from(1 << 30)) as i32)),
                ..Instance::AS_IS
            };
            let object = Object {
                first_grid: 0,
                grids: 1,
                first_material: 0,
                materials: 1,
                bounds: [low, high].map(|c| c.map(|v| Extent::from_bits((v * 32768.0) as i16))),
            };
            // The box and half a cell all round, along the light's axes.
            let mut exact = [(f64::MAX, f64::MIN); 3];
            for corner in 0..8 {
                let mut own = [0.0; 3];
                for (axis, own) in own.iter_mut().enumerate() {
                    let beyond = 0.5 / 27.0;
                    *own = if corner >> axis & 1 == 1 { high[axis] + beyond } else { low[axis] - beyond };
                }
                for (axis, (from, to)) in light.axes.iter().zip(&mut exact) {
                    let mut along = 0.0;
                    for k in 0..3 {
                        let place: f64 = (0..3).map(|j| rows[k][j] * own[j]).sum::<f64>() * scale + at[k];
                        along += f64::from(axis[k]) / 16384.0 * place;
                    }
                    (*from, *to) = (from.min(along), to.max(along));
                }
            }
            let q16 = |v: f64| (v * 65536.0) as i32;
            light.bounds = exact.map(|(from, to)| (q16(from - room), q16(to + room)));
            // A thousandth is more than all that is rounded.
            prop_assert!(room >= 0.0 || !light.holds(&instance, &object, 27), "{room}");
            prop_assert!(room <= 0.001 || light.holds(&instance, &object, 27), "{room}");
        }
    }

    #[test]
    fn a_light_of_no_length_is_no_division_by_it() {
        let light = LightSpace::towards([Unit::ZERO; 3]);
        assert_eq!(light.axes[2], [0; 3]);
        assert_eq!(light.extents(), (1 << 14, 1 << 14));
    }
}
