//! A camera as seen from a grid: all that a frame computes once.
//!
//! The paper, section 5.1: the centre of a cell is its parent's plus a displacement from a table,
//! one table a level, in homogeneous coordinates. The exponents of X, Y and of W are chosen here so
//! that the whole cube stays below 2^29 and as near to it as possible: any camera uses all bits.

use super::project::{Bounds, Homogeneous, OverW, slack};
use super::stamp::{Classes, DiscCut, Sight};
use crate::blob::Grid;
use crate::blob::facing::classes_apart;
use crate::blob::format::MAX_SUBDIVISIONS;
use crate::camera::{Camera, ViewError};
use crate::q::PixelSize;
use crate::reciprocal::Reciprocal;

/// Displacements of all levels together: five levels of 5 x 5 x 5 are the most below 4,096 cells
/// an axis.
const MAX_DISPLACEMENTS: usize = 5 * 125;

/// The tables of a frame, about 13 kB: one a board is enough.
#[derive(Clone, Debug)]
pub struct View {
    pub(super) root: Homogeneous,
    /// k of [`super::project`].
    pub(super) k: u32,
    /// Cells all of whose points have at least this W are projected; nearer ones are bounded by
    /// interval arithmetic.
    pub(super) near: i32,
    /// Frame size in pixels.
    pub(super) width: i32,
    pub(super) height: i32,
    /// The first of the frame's rows that are drawn, and the one after the last.
    pub(super) rows: (i32, i32),
    /// What [`OverW::times`] may be off at the frame's edge, Q8.
    slack: i32,
    pub(super) levels: [LevelView; MAX_SUBDIVISIONS + 1],
    displacements: [Homogeneous; MAX_DISPLACEMENTS],
    /// log2 of W's unit: W = 2^this is a cube's side.
    w_bits: u32,
    /// 2^17 over the focal length in pixels.
    over_focal: i32,
    /// Whether no back of the grid's samples shows.
    pub(super) no_backs: bool,
    /// How discs are stamped.
    pub(super) cut: DiscCut,
    /// Normals as the eye sees them; filled for grids whose samples have offsets.
    pub(super) classes: Classes,
}

/// What the view knows of the cells of one level.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LevelView {
    /// Half an edge of a cell along the grid's x, y, z.
    half_edges: [Homogeneous; 3],
    /// Half the extent of a cell in X, Y, W, rounded up.
    pub(super) half: Homogeneous,
    /// From this W on a cell is at most the threshold large and drawn from its own sample.
    pub(super) stop_w: i32,
    /// The eye's cell along each axis, -1 or the number of cells when it is outside.
    pub(super) eye: [i32; 3],
    /// A cell's side in the unit of X.
    pub(super) side: i32,
    /// How far a disc drawn in a cell of this level may reach beyond it, in 256ths of half its
    /// extent.
    pub(super) overhang: i32,
    /// Where its children's displacements begin, and how many there are.
    children: (usize, usize),
}

impl LevelView {
    pub(super) const NONE: Self = Self {
        half_edges: [Homogeneous::ZERO; 3],
        half: Homogeneous::ZERO,
        stop_w: 0,
        side: 0,
        overhang: 0,
        eye: [0; 3],
        children: (0, 0),
    };

    /// From a cell's centre to the middles of its faces, along x, y and z.
    pub(super) fn half_edges(&self) -> [Homogeneous; 3] {
        self.half_edges
    }

    /// The steps in W from a cell to the next along the grid's x, y, z.
    #[inline(always)]
    pub(super) fn depth_steps(&self) -> [i32; 3] {
        self.half_edges.map(|e| 2 * e.w)
    }
}

/// Half extents on the screen, Q8, that hold for all children of a cell.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Half {
    pub(super) x: i32,
    pub(super) y: i32,
}

/// A step on the screen, Q16: 65536 to the pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Step {
    pub(super) x: i32,
    pub(super) y: i32,
}

impl Step {
    #[inline(always)]
    pub(super) fn plus(self, d: Self) -> Self {
        Self {
            x: self.x + d.x,
            y: self.y + d.y,
        }
    }
}

/// Where the cells of a level within a block stand on the screen, to first order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Steps {
    /// From one cell's centre to the next along the grid's x, y, z.
    pub(super) steps: [Step; 3],
    /// Half extents of any of the cells, Q8, which also hold what the first order leaves out.
    pub(super) half: Half,
}

/// From a cell's centre to its slabs along each axis; eight, so that any three bits name one.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Slabs([[Step; 8]; 3]);

impl Steps {
    /// The slabs of the cells that are divided by `rho`.
    #[inline(always)]
    pub(super) fn slabs(&self, rho: u8) -> Slabs {
        let mut slabs = Slabs::default();
        for (axis, step) in slabs.0.iter_mut().zip(self.steps) {
            for (slab, at) in axis.iter_mut().take(rho.into()).enumerate() {
                let odd = 2 * slab as i32 + 1 - i32::from(rho);
                *at = Step {
                    x: (odd * step.x) >> 1,
                    y: (odd * step.y) >> 1,
                };
            }
        }
        slabs
    }
}

impl Slabs {
    /// Along x (0), y (1) or z (2).
    #[inline(always)]
    pub(super) fn along<const AXIS: usize>(&self, slab: u32) -> Step {
        self.0
            .get(AXIS)
            .and_then(|axis| axis.get(slab as usize & 7))
            .copied()
            .unwrap_or_default()
    }
}

impl View {
    /// Tables not yet filled.
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            root: Homogeneous::ZERO,
            k: 0,
            near: 0,
            width: 0,
            height: 0,
            rows: (0, 0),
            slack: 0,
            levels: [LevelView::NONE; MAX_SUBDIVISIONS + 1],
            displacements: [Homogeneous::ZERO; MAX_DISPLACEMENTS],
            w_bits: 0,
            over_focal: 0,
            no_backs: false,
            cut: DiscCut::NONE,
            classes: Classes::empty(),
        }
    }

    /// Fills the tables for `camera` and `grid`, whose cube stands at the world's origin with
    /// side 1. Cells at most `cell_size` large on the screen are drawn from their own sample.
    ///
    /// # Errors
    /// [`ViewError`] when the camera is none; the tables are then as before.
    pub fn prepare(
        &mut self,
        camera: &Camera,
        grid: &Grid<'_>,
        cell_size: PixelSize,
    ) -> Result<(), ViewError> {
        camera.check()?;
        let focal = i64::from(camera.focal.to_bits());
        let rotation = camera
            .rotation
            .map(|row| row.map(|v| i64::from(v.to_bits())));
        let [right, up, back] = rotation;
        let [tx, ty, tz] = camera.translation.map(|v| i64::from(v.to_bits()));

        // Exact X, Y in Q42 and Q32, W in Q30. Screen y runs down; the camera looks along -z.
        let (edges_x, edges_y) = (right.map(|v| focal * v), up.map(|v| -focal * v));
        let (centre_x, centre_y) = (focal.saturating_mul(tx), (-focal).saturating_mul(ty));
        let edges_w = back.map(|v| -v);
        let centre_w = -tz << 10;

        // The largest magnitude of any point of the cube decides the exponents.
        let half_sum = |e: &[i64; 3]| e.iter().map(|v| v.abs() >> 1).sum::<i64>();
        let reach_of = |centre: i64, edges| {
            centre
                .saturating_abs()
                .saturating_add(half_sum(edges) >> 10)
        };
        let reach = reach_of(centre_x, &edges_x).max(reach_of(centre_y, &edges_y));
        let reach_w = centre_w.abs() + half_sum(&edges_w);
        let drop = bits(reach).saturating_sub(29).max(1);
        let drop_w = bits(reach_w).saturating_sub(29).max(1);
        // X = real * 2^(32 - drop), W = real * 2^(30 - drop_w).
        self.k = (22 + 32 - drop).wrapping_sub(30 - drop_w);
        self.w_bits = 30 - drop_w;
        self.near = 1 << 31u32.saturating_sub(self.k).min(29);
        self.width = i32::from(camera.width);
        self.height = i32::from(camera.height);
        self.rows = (0, self.height);
        self.over_focal = i32::try_from((1 << 29) / focal).unwrap_or(i32::MAX);
        if grid.layout().offset > 0 {
            let cells = grid.cells(grid.subdivisions());
            self.classes.turn(camera, classes_apart(cells));
        }
        self.slack = slack(128 * self.width.max(self.height));
        self.root = Homogeneous {
            x: shift(centre_x, drop),
            y: shift(centre_y, drop),
            w: shift(centre_w, drop_w),
        };

        // The eye in the grid's axes, Q30, the cube's corner at 0.
        let eye = core::array::from_fn::<i64, 3, _>(|axis| {
            let along = |row: [i64; 3]| row.get(axis).copied().unwrap_or(0);
            let q50 = along(right) * tx + along(up) * ty + along(back) * tz;
            (1 << 29) - (q50 >> 20)
        });

        // 4096 to a side, from the centre; a camera is at most some 2,000 sides away.
        let from_centre = eye.map(|e| ((e - (1 << 29)) >> 18) as i32);
        self.cut = DiscCut::PIXELS;
        self.no_backs = grid.backs().is_some_and(|backs| !backs.show(from_centre));

        // Half the edges of the cube, in the units of X, Y and W with 32 bits after the point.
        let wide = |v: i64| v << 21u32.saturating_sub(drop) >> drop.saturating_sub(21);
        let wide_w = |v: i64| v << (31 - drop_w);
        let mut half: [[i64; 3]; 3] = core::array::from_fn(|axis| {
            let of = |e: &[i64; 3]| e.get(axis).copied().unwrap_or(0);
            [wide(of(&edges_x)), wide(of(&edges_y)), wide_w(of(&edges_w))]
        });
        let mut side = wide(focal << 30);
        let mut first = 0;
        let mut cells = 1;
        for level in 0..=grid.subdivisions() {
            let rho = grid.levels().get(level).map_or(1, |l| u32::from(l.rho));
            let half_edges = half.map(rounded);
            let sum = |get: fn(&Homogeneous) -> i32| {
                half_edges.iter().map(|e| get(e).abs()).sum::<i32>() + 3
            };
            let extent = Homogeneous {
                x: sum(|e| e.x),
                y: sum(|e| e.y),
                w: sum(|e| e.w),
            };
            let entry = LevelView {
                half_edges,
                half: extent,
                stop_w: if level < grid.first_sampled() {
                    // Without samples of their own its cells are opened, however small.
                    i32::MAX
                } else {
                    self.stop_w(extent.x.max(extent.y), cell_size)
                },
                eye: eye.map(|e| ((e * cells) >> 30).clamp(-1, cells) as i32),
                side: (side >> 31) as i32,
                overhang: 0,
                children: (first, rho.pow(3) as usize),
            };
            if let Some(slot) = self.levels.get_mut(level) {
                *slot = entry;
            }
            if level == grid.subdivisions() {
                break;
            }
            cells *= i64::from(rho);
            side = divided(side, rho);
            half = half.map(|edge| edge.map(|v| divided(v, rho)));
            let count = rho.pow(3) as usize;
            if let Some(slots) = self.displacements.get_mut(first..first + count) {
                displace(slots, rho, half);
            }
            first += count;
        }
        self.overhangs(grid);
        Ok(())
    }

    /// The tangent of the angle between the optical axis and what is projected to `x` (Q8 from the
    /// axis), 512 to the unit, rounded down.
    #[inline(always)]
    pub(super) fn tangent(&self, x: i32) -> i32 {
        ((i64::from(x) * i64::from(self.over_focal)) >> 16) as i32
    }

    /// Whether all samples in `cone`, somewhere within `bounds` on the screen, face away.
    #[inline(never)]
    pub(super) fn faces_away(&self, cone: u16, bounds: &Bounds) -> bool {
        let Bounds {
            x,
            y,
            half_x,
            half_y,
        } = *bounds;
        // One more, since tangents are rounded down.
        let (dx, dy) = (self.tangent(half_x) + 1, self.tangent(half_y) + 1);
        // Farther apart a cone would hardly hide, and a sum would not fit (`Sight::is_hidden`).
        if dx.max(dy) > 160 {
            return false;
        }
        let tx = self.tangent(x - (self.width << 7));
        let ty = self.tangent(y - (self.height << 7));
        let Some(wide) = Sight::new([tx.abs() + dx, ty.abs() + dy]) else {
            return false;
        };
        wide.along([tx, ty]).is_hidden(cone, &self.classes, dx + dy)
    }

    /// The side of a cell of `level` at depth `w`, Q16.
    #[inline(always)]
    pub(super) fn side<R: Reciprocal>(&self, level: &LevelView, w: i32) -> i32 {
        OverW::new::<R>(w, self.k).times_q16(level.side)
    }

    /// W of a distance of one side of the cube along the optical axis: `2^bits`.
    #[must_use]
    pub fn w_bits(&self) -> u32 {
        self.w_bits
    }

    /// What discs reach beyond the cells of each level, by the coarsest level that may be drawn.
    fn overhangs(&mut self, grid: &Grid<'_>) {
        let farthest = self
            .levels
            .first()
            .map_or(0, |l| self.root.w.saturating_add(l.half.w));
        let leaf = grid.subdivisions();
        let drawn = |level: &LevelView| level.stop_w <= farthest;
        let levels = self.levels.get(1..leaf).unwrap_or_default();
        let coarsest = 1 + levels.iter().position(drawn).unwrap_or(leaf - 1);
        // A disc of radius 0.9 moved by 0.87 sides reaches at most 1.26 sides from its cell's
        // centre, so 0.76 sides beyond it, and a side is at most twice a half extent.
        for (level, entry) in self.levels.iter_mut().enumerate().take(leaf + 1) {
            let finer = grid.cells(coarsest) / grid.cells(level).max(1);
            entry.overhang = 390 / finer.max(2) as i32 + 1;
        }
    }

    /// Columns of the frame, of quarters if it is in quarters.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width.unsigned_abs()
    }

    /// Draws only these rows of the frame from now on, until it is prepared again: those of a
    /// [`Tones::band`](super::Tones::band) of quarters. Rows beyond the frame do not count.
    pub fn see_rows(&mut self, rows: core::ops::Range<u16>) {
        self.cut = DiscCut::QUARTERS;
        let within = |row: u16| i32::from(row).min(self.height);
        self.rows = (within(rows.start), within(rows.end));
    }

    /// The displacements of the children of cells of `level`.
    #[inline(always)]
    pub(super) fn displacements(&self, level: &LevelView) -> &[Homogeneous] {
        let (first, count) = level.children;
        self.displacements
            .get(first..first + count)
            .unwrap_or_default()
    }

    /// Half extents of any cell of `level` within a cell whose centre is projected to (x, y) (Q8
    /// from the axis) and whose own half extents are `within`; all its W are at least `nearest`.
    ///
    /// A corner at (dX, dW) from a cell's centre is projected to exactly (dX - x dW) / (W + dW)
    /// from the centre's x. The sum of |dX - x dW| over the three half edges and the smallest W
    /// bound it for every corner, and `within` bounds how far x varies.
    #[inline(always)]
    pub(super) fn half<R: Reciprocal>(
        &self,
        level: &LevelView,
        [x, y]: [i32; 2],
        within: Half,
        nearest: i32,
    ) -> Half {
        let over = OverW::new::<R>(nearest, self.k);
        let mut sum = [0i64; 2];
        for e in &level.half_edges {
            sum[0] += (i64::from(e.x) - self.per_w(x, e.w)).abs();
            sum[1] += (i64::from(e.y) - self.per_w(y, e.w)).abs();
        }
        let extent = |sum: i64, within: i32| {
            let sum = sum + self.per_w(within, level.half.w).abs() + 6;
            let half = over.times(sum.min(1 << 29) as i32);
            // Its own error and that of the centre which it is added to.
            half.saturating_add(self.slack + (half >> 13))
        };
        Half {
            x: extent(sum[0], within.x),
            y: extent(sum[1], within.y),
        }
    }

    /// The steps between the `cells`, two levels below a block of level `block`, which is divided
    /// by `rho`, whose centre is projected to (x, y) (Q8 from the axis) at depth `w` and whose half
    /// extents are `own`; `None` when the block is too near or too large for the first order.
    ///
    /// A cell's centre at (dX, dW) from its parent's is projected to (dX - x' dW) / (W' + dW) from
    /// the parent's x'. The step takes the block's x and W for the parent's x' and for W' + dW.
    /// With r = D / (W - D), where D is the block's half extent in W, the one is off by at most
    /// r own / rho, the other by as much: the parent's extent is `own` / rho. The half extents of
    /// the cells are taken at the block's x and W too, off by a part of that of at most 1/2.
    /// Altogether 3 r own / rho.
    ///
    /// When the block is itself the parent, its x' and W' are exact. With its own division d, a
    /// centre is off by at most (1 - 1/d)^2 r own, and the half extents, own / d, by 2 r own / d:
    /// together less than 3/2 r own for any d from 2 to 5, also with the 24th by which W - D is
    /// less than W. That is what `rho` = 2 says.
    #[inline(always)]
    pub(super) fn steps<R: Reciprocal>(
        &self,
        block: &LevelView,
        cells: &LevelView,
        [x, y]: [i32; 2],
        own: Half,
        w: i32,
        rho: i32,
    ) -> Option<Steps> {
        // The extents that the first order adds grow with r: half an extent where W is 24 D and
        // rho 3 twice. Nearer than that they cost more, in overdraw and in accuracy, than exact
        // bounds a parent do; tests/tests/quality.rs holds the views that show it.
        // (W and D are below 2^30 and 2^29, so 24 D is taken as 3 D of W / 8.)
        // Up to 4,096 pixels: Q16 holds all places then, on the largest frame.
        if w >> 3 < 3 * block.half.w || own.x.max(own.y) >= 1 << 20 {
            return None;
        }
        let steps = self.steps_at::<R>(cells, [x, y], w);
        let mut sum = Step::default();
        for step in &steps {
            sum.x += step.x.abs();
            sum.y += step.y.abs();
        }
        // r in units of 2^(k - 30), rounded up.
        let nearest = OverW::new::<R>(w - block.half.w, self.k);
        let r = i64::from(nearest.times(block.half.w)) + 1;
        let scale = 30u32.saturating_sub(self.k);
        let half = |sum: i32, own: i32| {
            let half = (sum >> 9) + ((i64::from(3 * own / rho) * r) >> scale) as i32;
            half + self.slack + (half >> 13)
        };
        Some(Steps {
            steps,
            half: Half {
                x: half(sum.x, own.x),
                y: half(sum.y, own.y),
            },
        })
    }

    /// The steps between cells whose half edges are those of `cells`, at the place (x, y) (Q8 from the
    /// axis) and depth `w`, to first order, Q16.
    #[inline(always)]
    pub(super) fn steps_at<R: Reciprocal>(
        &self,
        cells: &LevelView,
        [x, y]: [i32; 2],
        w: i32,
    ) -> [Step; 3] {
        let over = OverW::new::<R>(w, self.k);
        let step = |e: &Homogeneous| {
            // How much larger it is there, of what is 1 here, Q24; places have Q8.
            let larger = i64::from(over.times_itself_q24(e.w));
            let of = |e: i32, x: i32| over.times_q16(e) - ((i64::from(x) * larger) >> 16) as i32;
            Step {
                x: 2 * of(e.x, x),
                y: 2 * of(e.y, y),
            }
        };
        let [along_x, along_y, along_z] = &cells.half_edges;
        [step(along_x), step(along_y), step(along_z)]
    }

    /// A screen coordinate (Q8) times a W, in the unit of X; rounded down.
    #[inline(always)]
    fn per_w(&self, screen: i32, w: i32) -> i64 {
        let product = i64::from(screen) * i64::from(w);
        if self.k <= 30 {
            product >> (30 - self.k)
        } else {
            product << (self.k - 30)
        }
    }

    /// The W from which on twice `half` (in the unit of X) is at most `size` pixels: the paper's
    /// test dx <= w s (equation 4) with the extent S of a level (equation 5).
    fn stop_w(&self, half: i32, size: PixelSize) -> i32 {
        let size = i64::from(size.to_bits());
        if size == 0 {
            return i32::MAX;
        }
        // Q8 pixels = X / W * 2^(30 - k).
        let w = (i64::from(half) * 2) << 30u32.saturating_sub(self.k);
        let w = (w >> self.k.saturating_sub(30)) / size + 1;
        i32::try_from(w).unwrap_or(i32::MAX)
    }
}

/// Displacements (paper, equations 1 and 2) of rho x rho x rho subcells: odd multiples of `half`, half
/// their edges, each rounded once from the exact sum.
fn displace(slots: &mut [Homogeneous], rho: u32, half: [[i64; 3]; 3]) {
    let [along_x, along_y, along_z] = half.map(|edge| edge.map(|v| 2 * v));
    let plus = |[x, y, w]: [i64; 3], [dx, dy, dw]: [i64; 3]| [x + dx, y + dy, w + dw];
    let before = |[x, y, w]: [i64; 3], edge: [i64; 3]| {
        let [dx, dy, dw] = edge.map(|v| i64::from(rho - 1) * v);
        [x - dx, y - dy, w - dw]
    };
    let mut slots = slots.iter_mut();
    let mut plane = half.into_iter().fold([0; 3], before);
    for _ in 0..rho {
        let mut row = plane;
        for _ in 0..rho {
            let mut at = row;
            for _ in 0..rho {
                if let Some(slot) = slots.next() {
                    *slot = rounded(at);
                }
                at = plus(at, along_x);
            }
            row = plus(row, along_y);
        }
        plane = plus(plane, along_z);
    }
}

/// Numbers with 32 bits after the point, rounded to nearest.
#[inline(always)]
fn rounded([x, y, w]: [i64; 3]) -> Homogeneous {
    let round = |v: i64| ((v + (1 << 31)) >> 32) as i32;
    Homogeneous {
        x: round(x),
        y: round(y),
        w: round(w),
    }
}

/// v / by, rounded down, for `by` below 2^16: the core divides 32 bits, not 64.
fn divided(v: i64, by: u32) -> i64 {
    let high = (v >> 32) as i32;
    let first = high.div_euclid(by as i32);
    let rest = (high - first * by as i32) as u32;
    let middle = rest << 16 | (v as u32) >> 16;
    let (second, rest) = (middle / by, middle % by);
    let low = rest << 16 | v as u32 & 0xFFFF;
    (i64::from(first) << 32) + (i64::from(second) << 16) + i64::from(low / by)
}

/// How many bits a magnitude needs.
fn bits(magnitude: i64) -> u32 {
    64 - magnitude.leading_zeros()
}

/// v / 2^by, rounded to nearest; the caller has chosen `by` so that it fits.
fn shift(v: i64, by: u32) -> i32 {
    ((v + (1 << (by - 1))) >> by) as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_quotient_is_rounded_down(v: i64, by in 1..=5u32) {
            prop_assert_eq!(divided(v, by), v.div_euclid(by.into()));
        }
    }
}
