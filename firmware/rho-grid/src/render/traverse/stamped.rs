//! Blocks of the walk whose samples are stamped.

use super::{Cell, Open, Walk};
use crate::blob::Attributes;
use crate::reciprocal::Reciprocal;
use crate::render::stamp::{self, Fields, Kind, Stamps};
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
        match (self.kind, self.grid.attributes()) {
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
            || w >> 3 < dw
        {
            return false;
        }
        let (mx, my) = self.middle();
        let at = [bounds.x - mx, bounds.y - my];
        let side = view.side::<R>(inner, w);
        let reach = bounds.half_x.max(bounds.half_y);
        if !Stamps::can_hold(view, reach, side) {
            return false;
        }
        let is_inside = self.is_within_frame(bounds, Stamps::overhang(side));
        let steps = view.steps_at::<R>(inner, at, w);
        let depths = inner.depth_steps();
        if !(self.stamps).turn_to::<A>(view, &steps, at, side, depths, is_inside) {
            return false;
        }
        let rho = i32::from(nodes.rho);
        let words = words.get(self.first(level + 2) as usize..);
        let light = self.in_light(level, cell.place);
        // The eye's slab among all subcells.
        let eye = self.eye_slab(inner, cell.place.map(|p| p * rho), 3);
        let mut parents = stamp::Parents::new(
            cell.centre,
            view.displacements(outer),
            view.k,
            below,
            open.first_child,
            words.unwrap_or_default(),
            (rho * rho * rho) as usize,
            light,
            &mut self.parents,
        );
        match nodes.rho {
            3 if eye.iter().all(|e| *e < 1 || *e > 7) => {
                let [mask, ..] = nodes.mask::<3>(cell.node);
                parents.outside(mask, eye.map(|e| e > 7));
            }
            rho => parents.list(rho, nodes.mask_any(cell.node), eye),
        }
        (self.stamps).stamp::<A, V, R>(self.target, &parents, self.shading);
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
