//! The instances of a blob into tones: a whole frame of them, or a band of quarters.

use core::ops::Range;

use rho_grid::blob::Blob;
use rho_grid::mode::{FootprintMode, FrameMode};
use rho_grid::reciprocal::Divide;
use rho_grid::render::footprint::{Disc, PixelCentre};
use rho_grid::render::{
    Canvas, Rect, Tones, View, Visibility, ZBuffer, draw, draw_divided, draw_seen,
};
use rho_grid::scene::{Arrangement, Placed, SceneTones, Turn};
use rho_grid::shading::Shade;

use crate::count::{Counter, Phase, Stopwatch};
use crate::picture::ModelError;
use crate::request::Scene;
use crate::shadow::Seen;

/// Which modes a program has.
pub(crate) trait Modes {
    /// Whether there is room for depths, which what is tangled takes.
    const DEPTHS: bool;
    /// Whether shadows may be asked for.
    const SHADOWS: bool;

    /// Draws an instance.
    fn draw<V: Visibility>(
        placed: &Placed<'_>,
        view: &View,
        shading: &impl Shade,
        target: &mut V,
    ) -> Option<Rect>;
}

/// All of them, for words.
pub(crate) struct Every;

impl Modes for Every {
    const DEPTHS: bool = true;
    const SHADOWS: bool = true;

    fn draw<V: Visibility>(
        placed: &Placed<'_>,
        view: &View,
        shading: &impl Shade,
        target: &mut V,
    ) -> Option<Rect> {
        draw_seen(placed.mode, &placed.grid, view, shading, target)
    }
}

/// All but the table of reciprocals: for words with shadows.
pub(crate) struct Divided;

impl Modes for Divided {
    const DEPTHS: bool = true;
    const SHADOWS: bool = true;

    fn draw<V: Visibility>(
        placed: &Placed<'_>,
        view: &View,
        shading: &impl Shade,
        target: &mut V,
    ) -> Option<Rect> {
        let footprint = placed.mode.footprint;
        draw_divided(footprint, &placed.grid, view, shading, target)
    }
}

/// Those that a preset chooses: discs, or boxes where samples have no offsets.
pub(crate) struct Preset<const DEPTHS: bool, const SHADOWS: bool>;

impl<const DEPTHS: bool, const SHADOWS: bool> Modes for Preset<DEPTHS, SHADOWS> {
    const DEPTHS: bool = DEPTHS;
    const SHADOWS: bool = SHADOWS;

    fn draw<V: Visibility>(
        placed: &Placed<'_>,
        view: &View,
        shading: &impl Shade,
        target: &mut V,
    ) -> Option<Rect> {
        match placed.mode.footprint {
            FootprintMode::Disc => draw::<V, Disc, Divide>(&placed.grid, view, shading, target),
            _ => draw::<V, PixelCentre, Divide>(&placed.grid, view, shading, target),
        }
    }
}

/// Draws an instance in its turn; returns the pixels that it may reach.
pub(crate) fn draw_turn<M: Modes, V: Visibility + Canvas>(
    turn: Turn,
    placed: &Placed<'_>,
    view: &View,
    shading: &impl Shade,
    unit: Option<u32>,
    target: &mut V,
    depth: &mut [u16],
) -> Result<Option<Rect>, ModelError> {
    let Some(unit) = unit.filter(|_| turn.is_tangled) else {
        return Ok(M::draw(placed, view, shading, target));
    };
    if !M::DEPTHS {
        return Err(ModelError::Tangled);
    }
    if turn.is_first {
        target.depths(depth);
    }
    let target = ZBuffer::<_, true>::new(target, depth).ok_or(ModelError::TooLarge)?;
    let mut target = target.scaled(placed.depth_factor(view, unit));
    Ok(M::draw(placed, view, shading, &mut target))
}

/// All instances of a frame of tones, and their tables.
pub(crate) struct Instances<'a, 'g> {
    pub(crate) blob: &'a Blob<'g>,
    pub(crate) scene: &'a Scene,
    pub(crate) arrangement: &'a Arrangement,
    pub(crate) view: &'a mut View,
    pub(crate) scene_tones: &'a mut SceneTones,
    /// For what is tangled; may be empty where there is nothing.
    pub(crate) depth: &'a mut [u16],
    /// The one whose tables they are now.
    pub(crate) prepared: Option<Placed<'g>>,
    /// None when there are no shadows.
    pub(crate) shadows: Option<Seen<'a>>,
}

impl<'g> Instances<'_, 'g> {
    /// Finds the frame's tones; before anything is drawn.
    pub(crate) fn prepare<C: Counter>(&mut self, watch: &mut Stopwatch<'_, C>) {
        let Scene {
            camera,
            light,
            mode,
            ..
        } = self.scene;
        let instances = self.arrangement.turns().iter().map(|turn| turn.instance);
        watch.time(Phase::ShadingTables, || {
            self.scene_tones
                .prepare(self.blob, instances, camera, *light, mode.shadows);
        });
    }

    /// Draws all, each in its turn; returns the pixels that they may reach. A frame of tones is filled;
    /// of a band of quarters `rows` tells which it has.
    pub(crate) fn draw<M: Modes, C: Counter>(
        &mut self,
        frame: &mut Tones<'_>,
        rows: Option<&Range<u16>>,
        watch: &mut Stopwatch<'_, C>,
    ) -> Result<Option<Rect>, ModelError> {
        let (mut reach, mut all): (Option<Rect>, Option<Rect>) = (None, None);
        for turn in self.arrangement.turns() {
            let Some(placed) = self.placed(*turn, watch)? else {
                continue;
            };
            if let Some(rows) = rows {
                self.view.see_rows(rows.clone());
            }
            let unit = self.arrangement.unit();
            let mut shadows = self.shadows.as_mut().filter(|_| M::SHADOWS);
            if let Some(shadows) = &mut shadows {
                shadows.see(&placed, watch);
            }
            let drawn = watch.time(Phase::Draw, || {
                let (view, shading) = (&*self.view, &*self.scene_tones);
                match shadows {
                    // A program without shadows has no code for them.
                    Some(Seen { tables, map, .. }) if M::SHADOWS => {
                        let shading = &tables.over(shading, map);
                        draw_turn::<M, _>(*turn, &placed, view, shading, unit, frame, self.depth)
                    }
                    _ => draw_turn::<M, _>(*turn, &placed, view, shading, unit, frame, self.depth),
                }
            })?;
            reach = Rect::of_both(reach, drawn);
            all = Rect::of_both(all, drawn);
            // Holes are closed before what is behind shows through them.
            if turn.is_last
                && let Some(reach) = reach.take().filter(|_| rows.is_none())
            {
                watch.time(Phase::Fill, || frame.fill(reach));
            }
        }
        Ok(all)
    }

    /// The instance whose turn it is, its tables made; `None` when it is too far away. A function of its own: what it
    /// takes on the stack is free again when the instance is drawn.
    #[inline(never)]
    fn placed<C: Counter>(
        &mut self,
        turn: Turn,
        watch: &mut Stopwatch<'_, C>,
    ) -> Result<Option<Placed<'g>>, ModelError> {
        if let Some(placed) = self.prepared.filter(|p| p.number == turn.instance) {
            return Ok(Some(placed));
        }
        let placed = place(self.blob, turn, self.scene, self.view, watch)?;
        self.prepared = placed;
        let Some(placed) = placed else {
            return Ok(None);
        };
        watch.time(Phase::ShadingTables, || {
            self.scene_tones.shade(self.blob, &placed, self.scene.light);
        });
        Ok(Some(placed))
    }
}

/// The instance whose turn it is, and the tables of its view; `None` when it is too far away.
pub(crate) fn place<'g, C: Counter>(
    blob: &Blob<'g>,
    turn: Turn,
    scene: &Scene,
    view: &mut View,
    watch: &mut Stopwatch<'_, C>,
) -> Result<Option<Placed<'g>>, ModelError> {
    watch.time(Phase::Setup, || {
        let placed = Placed::new(blob, turn.instance, &scene.camera, scene.mode);
        if let Some(placed) = &placed {
            let seen = match scene.mode.frame {
                FrameMode::Quarters => placed.camera.in_quarters().ok_or(ModelError::TooLarge)?,
                FrameMode::Tones | FrameMode::Words => placed.camera,
            };
            view.prepare(&seen, &placed.grid, placed.mode.cell_size)
                .map_err(ModelError::View)?;
        }
        Ok(placed)
    })
}
