//! Blocks of the walk whose samples are stamped.

use super::{Cell, Open, Walk};
use crate::reciprocal::Reciprocal;
use crate::render::order;
use crate::render::project::Homogeneous;
use crate::render::stamp::{self, Kind, Stamps};
use crate::render::view::Half;
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
        // A parent's place is exact; within it, a sample stands off by the part of a step by which
        // the parent's depth differs from the block's: an eighth of a pixel at most.
        if below.rho != 3
            || !(leaves || inner.stop_w <= nearest)
            || middle.stop_w <= w + dw
            || nearest < view.near
        {
            return false;
        }
        if w >> 3 < dw {
            return self.stamped_in_parts::<R>(kind, open, cell, level);
        }
        let (mx, my) = self.middle();
        let at = [bounds.x - mx, bounds.y - my];
        let side = view.side::<R>(inner, w);
        let reach = bounds.half_x.max(bounds.half_y);
        if !Stamps::can_hold(view, reach, side) {
            // What it shares with the other cells of its own parent is more than its own extent.
            let own = view.half::<R>(outer, at, Half::default(), nearest);
            if !Stamps::can_hold(view, own.x.max(own.y), side) {
                return self.stamped_in_parts::<R>(kind, open, cell, level);
            }
        }
        let is_inside = self.is_within_frame(bounds, Stamps::overhang(side));
        let steps = view.steps_at::<R>(inner, at, w);
        let depths = inner.depth_steps();
        if !(self.stamps).turn_to(view, &steps, at, side, depths, is_inside) {
            return false;
        }
        let rho = i32::from(nodes.rho);
        let light = self.in_light(level, cell.place);
        // The eye's slab among all subcells.
        let eye = self.eye_slab(inner, cell.place.map(|p| p * rho), 3);
        let mut parents = stamp::Parents::new(
            cell.centre,
            view.displacements(outer),
            view.k,
            below,
            open.first_child,
            self.grid,
            self.first(level + 2),
            (rho * rho * rho) as usize,
            light,
            &mut self.parents,
        );
        parents.list(nodes.rho, nodes.mask_any(cell.node), eye);
        (self.stamps).stamp::<V, R>(kind, self.target, &parents, self.shading);
        true
    }

    /// The same for a block that is too large or too near: cut in two along each axis, so that a part has half as
    /// many parents a side, or one more.
    #[inline(never)]
    fn stamped_in_parts<R: Reciprocal>(
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
        let (w, dw) = (cell.centre.w, outer.half.w);
        let nearest = w - dw;
        if w >> 2 < dw {
            return false;
        }
        let rho = i32::from(nodes.rho);
        let cut = (rho + 1) / 2;
        let (mx, my) = self.middle();
        let axis = [cell.bounds.x - mx, cell.bounds.y - my];
        let own = view.half::<R>(outer, axis, Half::default(), nearest);
        // The larger part's parents, each as wide as the widest of them.
        let parent = view.half::<R>(middle, axis, own, nearest);
        let half = Half {
            x: parent.x.saturating_mul(cut),
            y: parent.y.saturating_mul(cut),
        };
        let side = view.side::<R>(inner, nearest);
        let farthest = [axis[0].abs() + own.x, axis[1].abs() + own.y];
        if !Stamps::can_hold(view, half.x.max(half.y), side) || !Stamps::sees(view, farthest) {
            return false;
        }
        let eye = self.eye_slab(inner, cell.place.map(|p| p * rho), 3);
        let mut all = stamp::NO_PARENTS;
        let mut listed = stamp::Parents::new(
            cell.centre,
            view.displacements(outer),
            view.k,
            below,
            open.first_child,
            self.grid,
            self.first(level + 2),
            (rho * rho * rho) as usize,
            self.in_light(level, cell.place),
            &mut all,
        );
        listed.list(nodes.rho, nodes.mask_any(cell.node), eye);
        // Of each axis, whether the part beyond the cut comes first.
        let [x, y, z] = eye.map(|e| e >= 3 * cut);
        for n in 0..8 {
            let is_upper = [(n & 1 == 1) != x, (n & 2 == 2) != y, (n & 4 == 4) != z];
            let mut centre = cell.centre;
            for (upper, edge) in is_upper.into_iter().zip(outer.half_edges()) {
                // From the middle of all to the part's, in parts of half an edge.
                let along = if upper { cut } else { cut - rho };
                let step = |v: i32| v / rho * along;
                centre = centre.plus(Homogeneous {
                    x: step(edge.x),
                    y: step(edge.y),
                    w: step(edge.w),
                });
            }
            let (x, y) = self.on_screen::<R>(centre);
            let bounds = self.bounds(x, y, half);
            let side = view.side::<R>(inner, centre.w);
            let is_inside = self.is_within_frame(&bounds, Stamps::overhang(side));
            let steps = view.steps_at::<R>(inner, [x, y], centre.w);
            let depths = inner.depth_steps();
            let parts = listed.those_in(&mut self.parents, |subcell| {
                let place = order::place(nodes.rho, subcell);
                place
                    .iter()
                    .zip(is_upper)
                    .all(|(p, upper)| (*p >= cut) == upper)
            });
            if !parts.is_empty()
                && (self.stamps).turn_to(view, &steps, [x, y], side, depths, is_inside)
            {
                (self.stamps).stamp::<V, R>(kind, self.target, &parts, self.shading);
            }
        }
        true
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
