//! Blocks of the walk whose samples are stamped.

use super::{Cell, Open, Walk};
use crate::reciprocal::Reciprocal;
use crate::render::order;
use crate::render::project::{Bounds, Homogeneous};
use crate::render::stamp::{self, Kind, ParentList, Stamps};
use crate::render::view::{Half, LevelView};
use crate::render::visibility::Visibility;
use crate::shading::Shade;

impl<'g, 'v, V: Visibility, S: Shade> Walk<'g, 'v, V, S> {
    /// Stamps the grandchildren of a cell of `level`, if it is a block and can be stamped.
    #[inline(always)]
    pub(super) fn stamps_all<R: Reciprocal>(
        &mut self,
        open: &Open,
        cell: &Cell,
        level: usize,
    ) -> bool {
        self.kind
            .is_some_and(|kind| self.stamped::<R>(kind, open, cell, level))
    }

    #[inline(never)]
    pub(super) fn stamped<R: Reciprocal>(
        &mut self,
        kind: Kind,
        open: &Open,
        cell: &Cell,
        level: usize,
    ) -> bool {
        let Some([nodes, below]) = self.two_levels(level) else {
            return false;
        };
        let view = self.view;
        let (outer, middle, inner) = (
            self.level(level),
            self.level(level + 1),
            self.level(level + 2),
        );
        let (w, bounds) = (cell.centre.w, &cell.bounds);
        let dw = outer.half.w;
        let leaves = level + 2 == self.grid.subdivisions();
        let nearest = w - dw;
        if below.rho != 3
            || !(leaves || inner.stop_w <= nearest)
            || middle.stop_w <= w + dw
            || nearest < view.near
        {
            return false;
        }
        let (mx, my) = self.middle();
        let at = [bounds.x - mx, bounds.y - my];
        let side = view.side::<R>(inner, w);
        let holds = |reach: Half| Stamps::can_hold(view, reach.x.max(reach.y), side);
        let shared = Half {
            x: bounds.half_x,
            y: bounds.half_y,
        };
        // What it shares with the other cells of its own parent is more than its own extent.
        let own = || view.half::<R>(outer, at, Half::default(), nearest);
        // A parent's place is exact; within it, a sample stands off by the part of a step by which
        // the parent's depth differs from the block's: an eighth of a pixel at most.
        let is_whole = w >> 3 >= dw && (holds(shared) || holds(own()));
        // The half extents of a part, of what is to be stamped in parts.
        let part = if is_whole {
            self.turn_to::<R>(inner, bounds, w).then_some(None)
        } else {
            let part = self.part::<R>([outer, middle, inner], nodes.rho, at, w);
            part.map(Some)
        };
        let Some(part) = part else {
            return false;
        };
        let rho = i32::from(nodes.rho);
        // The eye's slab among all subcells.
        let eye = self.eye_slab(inner, cell.place.map(|p| p * rho), 3);
        (self.parents).list(nodes.rho, nodes.mask_any(cell.node), eye);
        let parents = stamp::Parents {
            centre: cell.centre,
            displacements: view.displacements(outer),
            k: view.k,
            level: below,
            first: open.first_child,
            grid: self.grid,
            first_word: self.first(level + 2),
            subcells: (rho * rho * rho) as usize,
            light: self.in_light(level, cell.place),
            order: &ParentList::EMPTY,
        };
        match part {
            None => {
                let order = &self.parents;
                let parents = stamp::Parents { order, ..parents };
                (self.stamps).stamp::<V, R>(kind, self.target, &parents, self.shading);
            }
            Some(half) => {
                self.stamp_parts::<R>(kind, &parents, [outer, inner], nodes.rho, half, eye);
            }
        }
        true
    }

    /// Turns to what has these bounds and its centre at `w`, of whose cells `inner` tells.
    #[inline(always)]
    fn turn_to<R: Reciprocal>(&mut self, inner: &LevelView, bounds: &Bounds, w: i32) -> bool {
        let view = self.view;
        let (mx, my) = self.middle();
        let at = [bounds.x - mx, bounds.y - my];
        let side = view.side::<R>(inner, w);
        let is_inside = self.is_within_frame(bounds, Stamps::overhang(side));
        let steps = view.steps_at::<R>(inner, at, w);
        let depths = inner.depth_steps();
        (self.stamps).turn_to(view, &steps, at, side, depths, is_inside)
    }

    /// A block that is too large or too near is cut in two along each axis, so that a part has half as many parents a
    /// side, or one more: the half extents of such a part, if all of them can be stamped.
    #[inline(never)]
    fn part<R: Reciprocal>(
        &self,
        [outer, middle, inner]: [&LevelView; 3],
        rho: u8,
        at: [i32; 2],
        w: i32,
    ) -> Option<Half> {
        let view = self.view;
        // As of a whole block: a part is half as deep.
        if w >> 2 < outer.half.w {
            return None;
        }
        let nearest = w - outer.half.w;
        let own = view.half::<R>(outer, at, Half::default(), nearest);
        // The larger part's parents, each as wide as the widest of them.
        let parent = view.half::<R>(middle, at, own, nearest);
        let half = Half {
            x: parent.x.saturating_mul(cut(rho)),
            y: parent.y.saturating_mul(cut(rho)),
        };
        let [x, y] = at.map(i32::abs);
        let side = view.side::<R>(inner, nearest);
        let fits = Stamps::can_hold(view, half.x.max(half.y), side)
            && Stamps::sees(view, [x + own.x, y + own.y]);
        fits.then_some(half)
    }

    /// Stamps the parents that are listed, part by part from front to back.
    #[inline(never)]
    fn stamp_parts<R: Reciprocal>(
        &mut self,
        kind: Kind,
        block: &stamp::Parents<'_, '_>,
        [outer, inner]: [&LevelView; 2],
        rho: u8,
        half: Half,
        eye: [i32; 3],
    ) {
        let all = self.parents;
        let cut = cut(rho);
        // Of each axis, whether the part beyond the cut comes first.
        let [x, y, z] = eye.map(|e| e >= 3 * cut);
        for n in 0..8 {
            let is_upper = [(n & 1 == 1) != x, (n & 2 == 2) != y, (n & 4 == 4) != z];
            self.parents.take(&all, |subcell| {
                let mut place = order::place(rho, subcell).into_iter().zip(is_upper);
                place.all(|(p, upper)| (p >= cut) == upper)
            });
            if self.parents.entries().is_empty() {
                continue;
            }
            let mut centre = block.centre;
            for (upper, edge) in is_upper.into_iter().zip(outer.half_edges()) {
                // From the middle of all to the part's, in parts of half an edge.
                let along = if upper { cut } else { cut - i32::from(rho) };
                let step = |v: i32| v / i32::from(rho) * along;
                centre = centre.plus(Homogeneous {
                    x: step(edge.x),
                    y: step(edge.y),
                    w: step(edge.w),
                });
            }
            let (x, y) = self.on_screen::<R>(centre);
            if self.turn_to::<R>(inner, &self.bounds(x, y, half), centre.w) {
                let order = &self.parents;
                let parents = stamp::Parents { order, ..*block };
                (self.stamps).stamp::<V, R>(kind, self.target, &parents, self.shading);
            }
        }
    }

    /// The parents of a block of `level` in the light.
    #[inline(always)]
    pub(super) fn in_light(&self, level: usize, place: [i32; 3]) -> Option<stamp::InLight<'v>> {
        let light = self.shading.light()?;
        Some(stamp::InLight {
            at: light.place(level, place),
            parents: light.displacements(level),
            cells: light.displacements(level + 1).first_chunk()?,
        })
    }
}

/// The first parent along an axis of the upper part of a block divided by `rho`.
fn cut(rho: u8) -> i32 {
    (i32::from(rho) + 1) / 2
}
