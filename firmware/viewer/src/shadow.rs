//! The shadow map of a scene, made or kept.

use rho_grid::blob::{Blob, Grid};
use rho_grid::mode::{LightSplat, MapSize, ShadowMode};
use rho_grid::q::Unit;
use rho_grid::render::shadow::{ShadowMap, Shadows};
use rho_grid::scene::Placed;

use crate::count::{Counter, Phase, Stopwatch};
use crate::request::Scene;

/// A shadow map, its tables, and what they were made for.
#[derive(Debug)]
pub(crate) struct Shadow {
    tables: Shadows,
    map: [u16; MapSize::LARGEST.words()],
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

impl Shadow {
    pub(crate) const fn new() -> Self {
        Self {
            tables: Shadows::empty(),
            map: [0; MapSize::LARGEST.words()],
            made_for: None,
            seen: None,
        }
    }

    /// The map for a scene: made, or as it is when it is to be kept and can be; `None` when there are
    /// to be no shadows.
    pub(crate) fn for_scene<C: Counter>(
        &mut self,
        blob: &Blob<'_>,
        scene: &Scene,
        watch: &mut Stopwatch<'_, C>,
    ) -> Option<Seen<'_>> {
        let Scene { light, mode, .. } = scene;
        if mode.shadows == ShadowMode::None {
            return None;
        }
        watch.time(Phase::ShadowMap, || {
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
        })
    }
}

/// The map of a frame, and the tables of the instance that is drawn.
pub(crate) struct Seen<'a> {
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
