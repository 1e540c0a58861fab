//! The shadow map of a scene, made or kept.

use rho_grid::blob::{Blob, Grid};
use rho_grid::mode::{LightSplat, MapSize, ShadowMode};
use rho_grid::q::Unit;
use rho_grid::render::shadow::{ShadowMap, Shadows};
use rho_grid::scene::Placed;

use crate::count::{Counter, Phase, Stopwatch};
use crate::picture::ModelError;
use crate::request::Scene;

/// What a painter keeps for shadows.
pub trait Maps {
    /// Whether it keeps anything.
    const SHADOWS: bool;

    /// All zeros, so that a board's static costs no flash.
    const EMPTY: Self;

    /// The map for a scene: made, or as it is when it is to be kept and can be; `None` when there are
    /// to be no shadows.
    ///
    /// # Errors
    /// When the scene asks for shadows and there are none, or for a larger map.
    fn for_scene<C: Counter>(
        &mut self,
        blob: &Blob<'_>,
        scene: &Scene,
        watch: &mut Stopwatch<'_, C>,
    ) -> Result<Option<Seen<'_>>, ModelError>;
}

/// Nothing.
#[derive(Debug)]
pub struct NoShadows;

impl Maps for NoShadows {
    const SHADOWS: bool = false;
    const EMPTY: Self = Self;

    fn for_scene<C: Counter>(
        &mut self,
        _: &Blob<'_>,
        scene: &Scene,
        _: &mut Stopwatch<'_, C>,
    ) -> Result<Option<Seen<'_>>, ModelError> {
        match scene.mode.shadows {
            ShadowMode::None => Ok(None),
            _ => Err(ModelError::Mode),
        }
    }
}

/// A shadow map of at most so many texels, its tables, and what they were made for.
#[derive(Debug)]
pub struct Shadow<const TEXELS: usize> {
    tables: Shadows,
    map: [u16; TEXELS],
    made_for: Option<MadeFor>,
    /// Number and grid of the instance that is looked up.
    seen: Option<(u16, u16)>,
}

/// All that a map depends on while there is one model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct MadeFor {
    light: [Unit; 3],
    size: MapSize,
    splat: LightSplat,
}

impl<const TEXELS: usize> Maps for Shadow<TEXELS> {
    const SHADOWS: bool = true;
    const EMPTY: Self = Self {
        tables: Shadows::empty(),
        map: [0; TEXELS],
        made_for: None,
        seen: None,
    };

    fn for_scene<C: Counter>(
        &mut self,
        blob: &Blob<'_>,
        scene: &Scene,
        watch: &mut Stopwatch<'_, C>,
    ) -> Result<Option<Seen<'_>>, ModelError> {
        let Scene { light, mode, .. } = scene;
        if mode.shadows == ShadowMode::None {
            return Ok(None);
        }
        let made = watch.time(Phase::ShadowMap, || {
            let wanted = MadeFor {
                light: *light,
                size: mode.shadow_map,
                splat: mode.light_splat,
            };
            let kept = mode.shadows == ShadowMode::Kept && self.made_for == Some(wanted);
            // One pass leaves a map that other splats made.
            let lasts = mode.shadows != ShadowMode::OnePass;
            self.made_for = lasts.then_some(wanted);
            let Self {
                tables, map, seen, ..
            } = self;
            let map = if kept {
                ShadowMap::kept(map, wanted.size)?
            } else {
                *seen = None;
                let mut map = ShadowMap::cleared(map, wanted.size)?;
                if mode.shadows == ShadowMode::OnePass {
                    tables.fit(blob, *light);
                } else {
                    tables.cast(blob, *light, wanted.splat, &mut map);
                }
                map
            };
            let one_pass = (mode.shadows == ShadowMode::OnePass).then_some(wanted.splat);
            Some(Seen {
                tables,
                map,
                one_pass,
                seen,
            })
        });
        made.map(Some).ok_or(ModelError::TooLarge)
    }
}

/// The map of a frame, and the tables of the instance that is drawn.
pub struct Seen<'a> {
    pub(crate) tables: &'a mut Shadows,
    pub(crate) map: ShadowMap<'a>,
    /// The size of splats, if the map is filled while drawing.
    pub(crate) one_pass: Option<LightSplat>,
    seen: &'a mut Option<(u16, u16)>,
}

impl Seen<'_> {
    /// Makes the tables of an instance, unless they are.
    pub(crate) fn see<C: Counter>(&mut self, placed: &Placed<'_>, watch: &mut Stopwatch<'_, C>) {
        let wanted = Some((placed.number, placed.index));
        if *self.seen == wanted {
            return;
        }
        *self.seen = wanted;
        let grid: &Grid<'_> = &placed.grid;
        let size = self.map.size();
        let instance = &placed.instance;
        watch.time(Phase::ShadowMap, || match self.one_pass {
            None => self.tables.see(instance, grid, size),
            Some(splat) => self.tables.see_in_order(instance, grid, size, splat),
        });
    }
}
