//! Blocks of the walk whose samples are stamped.

use super::{Cell, Open, Walk};
use crate::blob::Attributes;
use crate::reciprocal::Reciprocal;
use crate::render::order;
use crate::render::stamp::{self, Fields, Kind, Stamps};
use crate::render::visibility::Visibility;
use crate::shading::Shade;

impl<'g, 'v, V: Visibility, S: Shade> Walk<'g, 'v, V, S> {
    /// Stamps the grandchildren of a cell of `level`, if it is a block and can be stamped.
    #[inline(always)]
    pub(super) fn stamps_all<R: Reciprocal>(
        &mut self,
        open: &mut Open,
        cell: &Cell,
        level: usize,
    ) -> bool {
        match (self.stamps, self.grid.attributes()) {
            (Some(Kind::Offset), Attributes::Halves(words)) => {
                self.stamped::<stamp::Offset, R>(words, open, cell, level)
            }
            (Some(Kind::Both), Attributes::Halves(words)) => {
                self.stamped::<stamp::Both, R>(words, open, cell, level)
            }
            (Some(Kind::Colour), Attributes::Words(words)) => {
                self.stamped::<stamp::Colour, R>(words, open, cell, level)
            }
            _ => false,
        }
    }

    #[inline(never)]
    pub(super) fn stamped<A: Fields, R: Reciprocal>(
        &mut self,
        words: &'g [A::Word],
        open: &mut Open,
        cell: &Cell,
        level: usize,
    ) -> bool {
        let Some([nodes, below]) = self.two_levels(level) else {
            return false;
        };
        let view = self.view;
        let (outer, inner) = (self.level(level), self.level(level + 2));
        let (w, bounds) = (cell.centre.w, &cell.bounds);
        let dw = outer.half.w;
        let leaves = level + 2 == self.grid.subdivisions();
        let nearest = w - dw;
        if below.rho != 3
            || !(leaves || inner.stop_w <= nearest)
            || self.level(level + 1).stop_w <= w + dw
            || nearest < view.near
        {
            return false;
        }
        let side = view.side::<R>(inner, w);
        let is_inside = self.is_within_frame(bounds, Stamps::overhang(side));
        let rho = i32::from(nodes.rho);
        let (mx, my) = self.middle();
        let axis = [bounds.x - mx, bounds.y - my];
        // A parent's place is exact; within it, a sample stands off by the part of a step by which
        // the parent's depth differs from the block's: an eighth of a pixel at most.
        if w >> 3 < dw {
            return false;
        }
        let steps = view.steps_at::<R>(inner, axis, w);
        let range = self.grid.layout().offset_range;
        let own = bounds.half_x.max(bounds.half_y);
        let Some(stamps) = Stamps::new::<A>(
            view,
            range,
            &steps,
            axis,
            own,
            side,
            inner.depth_steps(),
            is_inside,
        ) else {
            return false;
        };
        // The eye's slab among all subcells, and among the parents.
        let eye = self.eye_slab(inner, cell.place.map(|p| p * rho), 3);
        let eye_of_parents = self.eye_slab(self.level(level + 1), cell.place, rho);
        let words = words.get(self.first(level + 2) as usize..);
        let mut parents = stamp::Parents::new(
            cell.centre,
            view.displacements(outer),
            view.k,
            below,
            open.first_child,
            words.unwrap_or_default(),
            (rho * rho * rho) as usize,
            self.in_light(level, cell.place),
            &mut self.parents,
        );
        if rho == 3 && eye.iter().all(|e| *e < 1 || *e > 7) {
            let [mask, ..] = nodes.mask::<3>(cell.node);
            parents.outside(mask, eye.map(|e| e > 7));
        } else {
            let mask = match rho {
                2 => open.order::<2>(nodes, cell.node, eye_of_parents),
                3 => open.order::<3>(nodes, cell.node, eye_of_parents),
                4 => open.order::<4>(nodes, cell.node, eye_of_parents),
                _ => open.order::<5>(nodes, cell.node, eye_of_parents),
            };
            let list = open.list.iter().take(usize::from(open.count));
            let list = list.map(|s| (order::rank(&mask, *s), u32::from(*s)));
            parents.list(list, eye, |s| order::place(nodes.rho, s as u8));
        }
        stamps.stamp::<A, V, R>(self.target, &parents, self.shading);
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
