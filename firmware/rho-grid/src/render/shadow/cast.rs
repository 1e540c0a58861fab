//! The light's pass: the map, filled from a grid.

use super::cells::{self, Cell, Subcells};
use super::light::LightSpace;
use super::map::ShadowMap;
use super::view::{ShadowView, texels};
#[cfg(rho_thumb)]
use crate::blob::Attributes;
use crate::blob::{Blob, Grid, Instance};
use crate::mode::{LightSplat, MapSize};

/// What casts shadows: the samples of a level of a grid.
#[derive(Clone, Copy, Debug)]
pub struct Caster<'a> {
    /// The grid.
    pub grid: Grid<'a>,
    /// The level.
    pub level: usize,
    /// The side of its splats in texels.
    pub splat: usize,
}

impl<'a> Caster<'a> {
    /// The coarsest samples of an instance whose cells are at most as large as a splat, else the finest;
    /// of those, splats are as large as a cell.
    ///
    /// It is often unimportant to capture shadows in detail (paper, section 5.3): what is
    /// looked up has a texel's accuracy anyway.
    #[must_use]
    pub fn of(
        blob: &Blob<'a>,
        instance: &Instance,
        light: &LightSpace,
        size: MapSize,
        wanted: LightSplat,
    ) -> Option<Self> {
        let object = blob.object(instance.object)?;
        let wanted = wanted.texels();
        let grids = object.first_grid..object.first_grid.saturating_add(object.grids);
        let levels = grids.filter_map(|index| {
            let grid = blob.grid(index)?;
            let levels = grid.first_sampled().max(1)..=grid.subdivisions();
            let casters = levels.map(|level| {
                let cells = grid.cells(level);
                let side = splat(light, size, instance, cells);
                let fits = side <= wanted;
                let splat = side.clamp(wanted, LightSplat::LARGEST);
                let order = (!fits, if fits { cells } else { u32::MAX - cells });
                (order, index, level, splat as usize)
            });
            casters.min()
        });
        let (_, index, level, splat) = levels.min()?;
        let grid = blob.grid(index)?;
        Some(Self { grid, level, splat })
    }

    /// Lays a splat for each sample, seen by `view`.
    pub fn cast(&self, view: &ShadowView, map: &mut ShadowMap<'_>) {
        match self.splat {
            1 => self.lay::<1>(view, map),
            2 => self.lay::<2>(view, map),
            3 => self.lay::<3>(view, map),
            _ => self.lay::<4>(view, map),
        }
    }

    fn lay<const SIDE: usize>(&self, view: &ShadowView, map: &mut ShadowMap<'_>) {
        let (grid, level) = (&self.grid, self.level);
        let parents = level.saturating_sub(1);
        let Some(nodes) = grid.levels().get(parents) else {
            return;
        };
        let first = grid.levels().get(level);
        let first = first.map_or(grid.first_leaf(), |level| level.first);
        let displacements = view.displacements(parents);
        let moved = view.moved();
        #[cfg(rho_thumb)]
        if SIDE == 2
            && nodes.rho == 3
            && let Attributes::Halves(words) = grid.attributes()
            && let Some(splats) = super::thumb::Splats::new(displacements, moved, map)
        {
            cells::walk(grid, |cell: Cell| {
                if cell.level < parents {
                    return true;
                }
                let first = (first + nodes.first_child(cell.node)) as usize;
                let words = words.get(first..).unwrap_or_default();
                let [mask, ..] = nodes.mask::<3>(cell.node);
                splats.lay(view.place(parents, cell.place), mask, words);
                false
            });
            return;
        }
        cells::walk(grid, |cell: Cell| {
            if cell.level < parents {
                return true;
            }
            let place = view.place(parents, cell.place);
            let children = first + nodes.first_child(cell.node)..;
            let subcells = Subcells::of(nodes.mask_any(cell.node));
            for (subcell, child) in subcells.zip(children) {
                let d = displacements.get(subcell as usize).copied().unwrap_or(0);
                let moved = moved.of(grid.attribute(child));
                map.splat::<SIDE>(place.wrapping_add(d).wrapping_add(moved));
            }
            false
        });
    }
}

/// The side in texels of a splat as large as a cell of an instance's grid of so many cells an axis.
pub(super) fn splat(light: &LightSpace, size: MapSize, instance: &Instance, cells: u32) -> u32 {
    // An eighth of a texel more opens no gap: samples are means over several cells.
    let side = texels(light, size, instance, cells).saturating_sub(32);
    side.div_ceil(256)
}
