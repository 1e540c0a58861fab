//! The walk through the grid.
//!
//! ```text
//! stack: the open cells from the root down, each with its non-empty subcells in order
//! take the next subcell of the innermost open cell; none left: close it
//!   bounds on the screen; beyond the frame, or all that it reaches is covered: leave it
//!   a leaf, or small enough: draw its sample
//!   else open it
//! a cell whose subcells are all drawn is not opened: they are drawn in one loop
//! ```
//!
//! It is the paper's recursive Render (sections 5.1, 5.2) with a stack of its own, bounded by the
//! number of subdivisions, in the order of [`super::order`]. Departures: the extent is bounded a
//! parent, not a cell, and exactly ([`View::half`]); cells that come too near to the eye to be
//! projected (a division by next to nothing) are bounded by interval arithmetic instead, so that
//! nothing overflows and nothing in view is lost.

use super::footprint::{Footprint, Pixels};
use super::order::{self, MAX_SUBCELLS};
use super::project::{Bounds, Homogeneous, OverW};
use super::view::{Half, LevelView, View};
use super::visibility::{Rect, Visibility};
use crate::blob::format::MAX_SUBDIVISIONS;
use crate::blob::{Grid, Level};
use crate::reciprocal::Reciprocal;
use crate::shading::Shading;

/// A cell whose subcells are being visited.
#[derive(Clone, Copy, Debug)]
struct Open {
    centre: Homogeneous,
    /// Place among the cells of its level.
    place: [i32; 3],
    mask: [u32; 4],
    /// Number of its first child within the next level.
    first_child: u32,
    /// Half extents of its children, or `None` when they may be too near to be projected.
    half: Option<Half>,
    list: [u8; MAX_SUBCELLS],
    count: u8,
    next: u8,
}

impl Open {
    const NONE: Self = Self {
        centre: Homogeneous::ZERO,
        place: [0; 3],
        mask: [0; 4],
        first_child: 0,
        half: None,
        list: [0; MAX_SUBCELLS],
        count: 0,
        next: 0,
    };
}

/// A cell to be opened or drawn.
#[derive(Clone, Copy)]
struct Cell {
    /// Number within its level.
    node: u32,
    centre: Homogeneous,
    place: [i32; 3],
    bounds: Bounds,
}

struct Walk<'g, 'v, V> {
    grid: &'g Grid<'g>,
    view: &'v View,
    shading: &'v Shading<'v>,
    target: &'v mut V,
}

/// Draws `grid` as `view` (prepared for it) sees it.
///
/// Every loop is bounded by the number of nodes; the stack is bounded by the subdivisions.
pub fn draw<V: Visibility, F: Footprint, R: Reciprocal>(
    grid: &Grid<'_>,
    view: &View,
    shading: &Shading<'_>,
    target: &mut V,
) {
    Walk {
        grid,
        view,
        shading,
        target,
    }
    .run::<F, R>();
}

impl<V: Visibility> Walk<'_, '_, V> {
    fn run<F: Footprint, R: Reciprocal>(&mut self) {
        let mut stack = [Open::NONE; MAX_SUBDIVISIONS];
        let Some(root) = self.root::<R>() else {
            return;
        };
        // How many cells are open; the innermost is stack[open - 1], a cell of level open - 1.
        let mut open = usize::from(self.enter::<F, R>(root, 0, &mut stack));
        while let Some(level) = open.checked_sub(1) {
            let Some(parent) = stack.get_mut(level) else {
                return;
            };
            if parent.next == parent.count {
                open = level;
                continue;
            }
            let subcell = parent.list.get(usize::from(parent.next)).copied();
            parent.next += 1;
            let Some((cell, pixels)) = self.subcell::<F, R>(parent, level, subcell.unwrap_or(0))
            else {
                continue;
            };
            let child_level = level + 1;
            let leaf = child_level == self.grid.subdivisions();
            if leaf || self.level(child_level).stop_w <= cell.centre.w {
                let first = self.first(child_level);
                self.sample::<F>(&cell, first + cell.node);
            } else if !self.target.is_hidden(pixels) {
                open += usize::from(self.enter::<F, R>(cell, child_level, &mut stack));
            }
        }
    }

    /// The whole cube; `None` when it is behind the eye.
    fn root<R: Reciprocal>(&self) -> Option<Cell> {
        let centre = self.view.root;
        let level = self.level(0);
        let bounds = if centre.w - level.half.w >= self.view.near {
            let (x, y) = self.on_screen::<R>(centre);
            let nearest = centre.w - level.half.w;
            let half = self.view.half::<R>(level, [x, y], Half::default(), nearest);
            self.bounds(x, y, half)
        } else {
            self.near_bounds(centre, level)?
        };
        Some(Cell {
            node: 0,
            centre,
            place: [0; 3],
            bounds,
        })
    }

    /// Opens a cell, or draws all its subcells at once; whether there is now one more open.
    #[inline(always)]
    fn enter<F: Footprint, R: Reciprocal>(
        &mut self,
        cell: Cell,
        level: usize,
        stack: &mut [Open; MAX_SUBDIVISIONS],
    ) -> bool {
        let (Some(nodes), Some(slot)) = (self.grid.levels().get(level), stack.get_mut(level))
        else {
            return false;
        };
        match nodes.rho {
            2 => self.enter_rho::<F, R, 2>(cell, level, nodes, slot),
            3 => self.enter_rho::<F, R, 3>(cell, level, nodes, slot),
            4 => self.enter_rho::<F, R, 4>(cell, level, nodes, slot),
            _ => self.enter_rho::<F, R, 5>(cell, level, nodes, slot),
        }
    }

    fn enter_rho<F: Footprint, R: Reciprocal, const RHO: usize>(
        &mut self,
        cell: Cell,
        level: usize,
        nodes: &Level<'_>,
        open: &mut Open,
    ) -> bool {
        let children = self.level(level + 1);
        open.centre = cell.centre;
        open.place = cell.place;
        open.mask = nodes.mask::<RHO>(cell.node);
        open.first_child = nodes.first_child(cell.node);
        open.next = 0;
        let eye = if V::FRONT_TO_BACK {
            let [ex, ey, ez] = children.eye;
            let [px, py, pz] = cell.place.map(|p| p * RHO as i32);
            [ex - px, ey - py, ez - pz]
        } else {
            [0; 3]
        };
        open.count = order::list::<RHO>(&open.mask, eye, &mut open.list) as u8;

        let nearest = cell.centre.w - self.level(level).half.w;
        if nearest < self.view.near {
            open.half = None;
            return true;
        }
        let axis = [
            cell.bounds.x - (self.view.width << 7),
            cell.bounds.y - (self.view.height << 7),
        ];
        let own = Half {
            x: cell.bounds.half_x,
            y: cell.bounds.half_y,
        };
        let half = self.view.half::<R>(children, axis, own, nearest);
        let leaves = level + 1 == self.grid.subdivisions();
        if leaves || children.stop_w <= nearest {
            self.samples::<F, R, RHO>(open, half, level);
            false
        } else {
            open.half = Some(half);
            true
        }
    }

    /// Draws all subcells of a cell from their samples.
    #[inline(always)]
    fn samples<F: Footprint, R: Reciprocal, const RHO: usize>(
        &mut self,
        open: &Open,
        half: Half,
        level: usize,
    ) {
        let displacements = self.view.displacements(self.level(level));
        let first = self.first(level + 1) + open.first_child;
        let (grid, shading) = (self.grid, self.shading);
        for &subcell in open.list.get(..usize::from(open.count)).unwrap_or_default() {
            let Some(d) = displacements.get(usize::from(subcell)) else {
                continue;
            };
            let centre = open.centre.plus(*d);
            let (x, y) = self.on_screen::<R>(centre);
            if let Some(rect) = self.clip(F::cover(self.bounds(x, y, half))) {
                self.target.draw(rect, centre.w, || {
                    let node = first + order::rank::<RHO>(&open.mask, subcell);
                    shading.colour(grid.attribute(node))
                });
            }
        }
    }

    /// One subcell of an open cell, and the pixels that it may reach; `None` when there are none.
    #[inline(always)]
    fn subcell<F: Footprint, R: Reciprocal>(
        &self,
        parent: &Open,
        level: usize,
        subcell: u8,
    ) -> Option<(Cell, Rect)> {
        let displacements = self.view.displacements(self.level(level));
        let centre = parent
            .centre
            .plus(displacements.get(usize::from(subcell)).copied()?);
        let bounds = match parent.half {
            Some(half) => {
                let (x, y) = self.on_screen::<R>(centre);
                self.bounds(x, y, half)
            }
            None => self.near_bounds(centre, self.level(level + 1))?,
        };
        let reach = self.clip(F::reach(bounds))?;
        let rho = self.grid.levels().get(level)?.rho;
        let rank = match rho {
            2 => order::rank::<2>(&parent.mask, subcell),
            3 => order::rank::<3>(&parent.mask, subcell),
            4 => order::rank::<4>(&parent.mask, subcell),
            _ => order::rank::<5>(&parent.mask, subcell),
        };
        let [i, j, k] = order::place(rho, subcell);
        let [px, py, pz] = parent.place.map(|p| p * i32::from(rho));
        let cell = Cell {
            node: parent.first_child + rank,
            centre,
            place: [px + i, py + j, pz + k],
            bounds,
        };
        Some((cell, reach))
    }

    /// Draws a cell from its own sample.
    #[inline(always)]
    fn sample<F: Footprint>(&mut self, cell: &Cell, node: u32) {
        let (grid, shading) = (self.grid, self.shading);
        if let Some(rect) = self.clip(F::cover(cell.bounds)) {
            self.target
                .draw(rect, cell.centre.w, || shading.colour(grid.attribute(node)));
        }
    }

    /// Q8 from the optical axis.
    #[inline(always)]
    fn on_screen<R: Reciprocal>(&self, p: Homogeneous) -> (i32, i32) {
        let over = OverW::new::<R>(p.w, self.view.k);
        (over.times(p.x), over.times(p.y))
    }

    #[inline(always)]
    fn bounds(&self, x: i32, y: i32, half: Half) -> Bounds {
        Bounds {
            x: x + (self.view.width << 7),
            y: y + (self.view.height << 7),
            half_x: half.x,
            half_y: half.y,
        }
    }

    /// The part of `pixels` within the frame.
    #[inline(always)]
    fn clip(&self, pixels: Pixels) -> Option<Rect> {
        let (x0, x1) = (pixels.x.0.max(0), pixels.x.1.min(self.view.width - 1));
        let (y0, y1) = (pixels.y.0.max(0), pixels.y.1.min(self.view.height - 1));
        if x0 > x1 || y0 > y1 {
            return None;
        }
        Some(Rect {
            x0: x0 as u32,
            x1: x1 as u32,
            y0: y0 as u32,
            y1: y1 as u32,
        })
    }

    /// Bounds of a cell that the eye may be in or very near to; `None` when it is behind.
    ///
    /// X and W range independently, W from the eye's plane on: wider than exact, and never too
    /// narrow.
    #[cold]
    fn near_bounds(&self, centre: Homogeneous, level: &LevelView) -> Option<Bounds> {
        let w = (centre.w - level.half.w, centre.w + level.half.w);
        if w.1 < 1 {
            return None;
        }
        let w = (w.0.max(1), w.1);
        let (x, half_x) = self.interval(centre.x, level.half.x, w);
        let (y, half_y) = self.interval(centre.y, level.half.y, w);
        Some(self.bounds(
            x,
            y,
            Half {
                x: half_x,
                y: half_y,
            },
        ))
    }

    /// Centre and half extent, Q8, of (v - half ..= v + half) / w, cut at 2^22 pixels.
    fn interval(&self, v: i32, half: i32, w: (i32, i32)) -> (i32, i32) {
        let over = |v: i32, w: i32| {
            // Q8 = X / W * 2^(30 - k)
            let k = self.view.k;
            let v = i64::from(v) << 30u32.saturating_sub(k);
            let w = i64::from(w) << k.saturating_sub(30);
            (v / w.max(1)).clamp(-(1 << 28), 1 << 28) as i32
        };
        let (low, high) = (v - half, v + half);
        let low = over(low, if low < 0 { w.0 } else { w.1 }) - 1;
        let high = over(high, if high > 0 { w.0 } else { w.1 }) + 1;
        let middle = (low + high) >> 1;
        (middle, high - middle)
    }

    #[inline(always)]
    fn level(&self, level: usize) -> &LevelView {
        static NONE: LevelView = LevelView::NONE;
        self.view.levels.get(level).unwrap_or(&NONE)
    }

    /// Number over all levels of the first node of `level`.
    #[inline(always)]
    fn first(&self, level: usize) -> u32 {
        match self.grid.levels().get(level) {
            Some(nodes) => nodes.first,
            None => self.grid.first_leaf(),
        }
    }
}
