//! Shadows of a directional light, by a shadow map (paper, section 5.3).
//!
//! ```text
//! light   bounds of the grid across and along the light; the scale that fits the map         Light
//!         tables: a subcell's displacement in the light's space, one word                    ShadowView
//! cast    for each sample of a coarse grid: a splat of some texels, the nearest depth stays  Caster
//! draw    a sample about to be shown, and not facing away from the light:
//!         its place = its parent's + displacement + what normal and offset move it by        Shadowed
//!         something lies before it in the map: it is drawn as if the light were off
//! ```
//!
//! A place, two coordinates and a depth, is one word (`view`), so that a sample's is found by two
//! additions. Departures from the paper: its two passes draw the same samples, here the light's pass
//! takes those of a grid whose cells are as large as a splat, and the eye's pass looks up what it shows
//! alone. What is looked up is moved outwards ([`Bias`]), since a flat splat stands out of a
//! surface that is not perpendicular to the light; tests/tests/shadows.rs prints what the
//! moves cost and gain.

mod cast;
mod cells;
mod light;
mod map;
mod moved;
mod one_pass;
#[cfg(rho_thumb)]
mod thumb;
mod view;

pub use cast::Caster;
pub use light::LightSpace;
pub use map::ShadowMap;
pub use moved::Bias;
pub use one_pass::OnePass;
pub use view::ShadowView;

use core::cell::Cell;

use crate::blob::{Blob, Grid, Instance};
use crate::mode::{LightSplat, MapSize};
use crate::q::Unit;
use crate::shading::Shade;
#[cfg(rho_thumb)]
use crate::unlit;

/// The tables of a scene in its light: of the instance that is drawn, and of the one that casts.
#[derive(Clone, Debug)]
pub struct Shadows {
    light: LightSpace,
    looked_up: ShadowView,
    cast: ShadowView,
    /// Of one pass.
    splat: usize,
    higher: [bool; 3],
}

impl Shadows {
    /// Tables not yet filled: all zeros, so that a board's static costs no flash.
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            light: LightSpace::NONE,
            looked_up: ShadowView::empty(),
            cast: ShadowView::empty(),
            splat: 0,
            higher: [false; 3],
        }
    }

    /// Takes the bounds of what a light towards `towards` shines on.
    pub fn fit(&mut self, blob: &Blob<'_>, towards: [Unit; 3]) {
        self.light = LightSpace::towards(towards);
        // What lies within the bounds of others need not be walked through: the largest comes first.
        let largest = instances(blob).max_by_key(|instance| instance.scale);
        for instance in largest.into_iter().chain(instances(blob)) {
            let Some(object) = blob.object(instance.object) else {
                continue;
            };
            if let Some(grid) = blob.grids_of(&object).next()
                && !(self.light).holds(&instance, &object, grid.cells(grid.subdivisions()))
            {
                self.light.hold(&instance, &grid);
            }
        }
    }

    /// Fills a map with what a light towards `towards` sees of the scene. It stays as it is until light or
    /// objects move.
    pub fn cast(
        &mut self,
        blob: &Blob<'_>,
        towards: [Unit; 3],
        splat: LightSplat,
        map: &mut ShadowMap<'_>,
    ) {
        self.fit(blob, towards);
        let size = map.size();
        for instance in instances(blob) {
            let Some(caster) = Caster::of(blob, &instance, &self.light, size, splat) else {
                continue;
            };
            let (grid, bias) = ((&caster.grid, caster.level), Bias::splat(caster.splat));
            self.cast.prepare(&self.light, size, &instance, grid, bias);
            caster.cast(&self.cast, map);
        }
    }

    /// Fills the tables by which an instance, drawn in `grid`, is looked up in a map of this size.
    pub fn see(&mut self, instance: &Instance, grid: &Grid<'_>, size: MapSize) {
        let leaves = (grid, grid.subdivisions());
        let (view, light) = (&mut self.looked_up, &self.light);
        view.prepare(light, size, instance, leaves, Bias::LOOKED_UP);
    }

    /// The same for drawing it in one pass, which lays splats of that size or as large as its leaves.
    pub fn see_in_order(
        &mut self,
        instance: &Instance,
        grid: &Grid<'_>,
        size: MapSize,
        splat: LightSplat,
    ) {
        self.see(instance, grid, size);
        let leaves = grid.subdivisions();
        let side = cast::splat(&self.light, size, instance, grid.cells(leaves));
        self.splat = side.clamp(splat.texels(), LightSplat::LARGEST) as usize;
        self.higher = self.light.higher(instance);
        let bias = Bias::splat(self.splat);
        self.cast
            .prepare(&self.light, size, instance, (grid, leaves), bias);
    }

    /// How its samples look, drawn in one pass as `shade` has them, with a map that was cleared.
    #[must_use]
    pub fn in_order<'a, S>(&'a self, shade: &'a S, map: ShadowMap<'a>) -> OnePass<'a, S> {
        OnePass {
            shade,
            looked_up: &self.looked_up,
            cast: &self.cast,
            splat: self.splat,
            higher: self.higher,
            map: Cell::new(Some(map)),
        }
    }

    /// How the samples of that instance look, drawn as `shade` has them, but where `map` has something
    /// before them.
    #[must_use]
    pub fn over<'a, S>(&'a self, shade: &'a S, map: &'a ShadowMap<'a>) -> Shadowed<'a, S> {
        Shadowed {
            shade,
            view: &self.looked_up,
            map,
        }
    }
}

fn instances(blob: &Blob<'_>) -> impl Iterator<Item = Instance> {
    (0..blob.instance_count()).filter_map(|index| blob.instance(index))
}

/// What the loops in assembly look up: the tables of [`Shadowed`].
#[cfg(rho_thumb)]
#[derive(Clone, Copy, Debug)]
pub struct LookUp<'a> {
    /// The tones of what the light does not reach, the first material's first, by normal; and the bits
    /// of a row.
    pub(super) unlit: (&'a unlit::Table<u8>, u32),
    /// By the upper seven bits of a word and its lowest three.
    pub(super) moved: &'a [[u32; 8]; 128],
    /// `2^bits` texels a side.
    pub(super) map: &'a [u16],
    pub(super) bits: u32,
}

/// A way to shade, but where something lies between the light and a sample.
#[derive(Clone, Copy, Debug)]
pub struct Shadowed<'a, S> {
    /// How samples look in the light.
    pub shade: &'a S,
    /// The grid in the light.
    pub view: &'a ShadowView,
    /// What the light sees.
    pub map: &'a ShadowMap<'a>,
}

impl<S: Shade> Shade for Shadowed<'_, S> {
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
        Some(self.view)
    }

    #[cfg(rho_thumb)]
    fn tones(&self, both: bool) -> Option<&[u8]> {
        self.shade.tones(both)
    }

    #[cfg(rho_thumb)]
    fn look_up(&self) -> Option<LookUp<'_>> {
        Some(LookUp {
            unlit: self.shade.unlit_tones()?,
            moved: self.view.moved().table()?,
            map: self.map.texels(),
            bits: self.map.size().bits(),
        })
    }

    /// What faces away from the light is dark, and need not be looked up.
    #[inline(never)]
    fn colour_at(&self, word: u32, place: u32) -> u16 {
        let (lit, unlit) = (self.shade.colour(word), self.shade.unlit(word));
        let shaded = lit != unlit
            && self
                .map
                .shades(place.wrapping_add(self.view.moved().of(word)));
        if shaded { unlit } else { lit }
    }
}
