//! Shadows in one pass (paper, section 5.3).
//!
//! Along a directional light cells have one order in which none that comes later can shade an earlier
//! one. Drawn in this order, against depths for the eye, a sample asks the map as it is, and then lays its
//! splat into it. All samples must come, also those that the eye does not see, and all of the grid that
//! is drawn: there is no coarser pass to take instead.

use core::cell::Cell;

use super::cells::{self, Cell as GridCell};
use super::map::ShadowMap;
use super::view::ShadowView;
use crate::blob::Grid;
use crate::shading::Shade;

/// A way to shade, with a map that is filled as samples are met.
#[expect(
    missing_debug_implementations,
    reason = "a cell that cannot be looked into"
)]
pub struct OnePass<'a, S> {
    pub(super) shade: &'a S,
    pub(super) looked_up: &'a ShadowView,
    pub(super) cast: &'a ShadowView,
    /// The side of splats in texels.
    pub(super) splat: usize,
    pub(super) higher: [bool; 3],
    /// Taken out for each sample.
    pub(super) map: Cell<Option<ShadowMap<'a>>>,
}

impl<S: Shade> Shade for OnePass<'_, S> {
    #[inline(always)]
    fn colour(&self, word: u32) -> u16 {
        self.shade.colour(word)
    }

    #[inline(always)]
    fn of_normal(&self, index: u32) -> u16 {
        self.shade.of_normal(index)
    }

    #[inline(always)]
    fn unlit(&self, word: u32) -> u16 {
        self.shade.unlit(word)
    }

    #[inline(always)]
    fn light(&self) -> Option<&ShadowView> {
        Some(self.looked_up)
    }

    const MEETS: bool = true;

    #[inline(always)]
    fn higher(&self) -> [bool; 3] {
        self.higher
    }

    #[inline(never)]
    fn meet(&self, word: u32, place: u32) -> u16 {
        let lit = self.shade.colour(word);
        let Some(mut map) = self.map.take() else {
            return lit;
        };
        let is_shaded = map.shades(place.wrapping_add(self.looked_up.moved().of(word)));
        let at = place.wrapping_add(self.cast.moved().of(word));
        match self.splat {
            1 => map.splat::<1>(at),
            2 => map.splat::<2>(at),
            3 => map.splat::<3>(at),
            _ => map.splat::<4>(at),
        }
        self.map.set(Some(map));
        if is_shaded {
            self.shade.unlit(word)
        } else {
            lit
        }
    }

    #[inline(never)]
    fn meet_below(&self, grid: &Grid<'_>, level: usize, node: u32, place: [i32; 3]) {
        let leaves = grid.subdivisions();
        let from = GridCell { level, node, place };
        cells::walk_from(from, grid, |cell| {
            if cell.level < leaves {
                return true;
            }
            let word = grid.attribute(grid.first_leaf() + cell.node);
            self.meet(word, self.looked_up.place(leaves, cell.place));
            false
        });
    }
}
