//! Pictures by the presets, in little memory: a byte a pixel, sent strip by strip.
//!
//! A frame of tones is half as large as one of colours, and a band of quarters a quarter of that; their
//! colours are looked up as they are sent, a strip of rows at a time, so that no frame of colours is
//! ever whole. It keeps a shadow map if its type has one ([`Maps`]). Objects that reach into each other need
//! depths, for which it has no room. What it draws is what [`Frames`](crate::picture::Frames) draws by the same
//! presets.

use core::ops::Range;

use rho_grid::mode::{FrameMode, Mode};
use rho_grid::render::{Blend, Rect, Tones, View, bands};
use rho_grid::scene::{Arrangement, SceneTones};

use crate::count::{Counter, Phase, Stopwatch};
use crate::instances::{Instances, Preset};
use crate::painter::{Give, PaintError, Painter, Shapes, draw_part};
use crate::panel::ScreenError;
use crate::picture::{Model, ModelError, QUARTERS, TONE_WORDS, TONES};
use crate::request::Scene;
use crate::shadow::Maps;
use crate::size::{HEIGHT, WIDTH};

/// Rows of a strip: half of those of a band of quarters.
pub const STRIP: u16 = 40;

/// The memory of a painter in strips, and what it keeps for shadows.
#[derive(Debug)]
pub struct Strips<M> {
    arrangement: Arrangement,
    view: View,
    scene_tones: SceneTones,
    tones: [u32; TONE_WORDS],
    strip: [u16; STRIP as usize * WIDTH as usize],
    maps: M,
}

impl<M: Maps> Strips<M> {
    /// All zeros, so that a board's static costs no flash.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            arrangement: Arrangement::empty(),
            view: View::empty(),
            scene_tones: SceneTones::empty(),
            tones: [0; TONE_WORDS],
            strip: [0; STRIP as usize * WIDTH as usize],
            maps: M::EMPTY,
        }
    }

    /// Draws all instances: of the two ways, the one for which there is memory.
    fn draw<C: Counter>(
        instances: &mut Instances<'_, '_>,
        frame: &mut Tones<'_>,
        rows: Option<&Range<u16>>,
        watch: &mut Stopwatch<'_, C>,
    ) -> Result<Option<Rect>, ModelError> {
        if M::SHADOWS {
            instances.draw::<Preset<false, true>, _>(frame, rows, watch)
        } else {
            instances.draw::<Preset<false, false>, _>(frame, rows, watch)
        }
    }
}

impl<M: Maps> Default for Strips<M> {
    fn default() -> Self {
        Self::new()
    }
}

/// Whether a mode is among those that a preset may be.
fn is_known(mode: Mode) -> bool {
    mode.contradiction().is_none() && mode.frame != FrameMode::Words
}

impl<M: Maps> Painter for Strips<M> {
    fn model<C: Counter>(
        &mut self,
        model: &Model<'_>,
        scene: &Scene,
        watch: &mut Stopwatch<'_, C>,
        give: Give<'_>,
    ) -> Result<(), PaintError> {
        let Scene { camera, mode, .. } = scene;
        if !is_known(*mode) {
            return Err(ModelError::Mode.into());
        }
        let blob = model.blob();
        model.arrange(scene, &mut self.arrangement, watch)?;
        let mut instances = Instances {
            blob,
            scene,
            arrangement: &self.arrangement,
            view: &mut self.view,
            scene_tones: &mut self.scene_tones,
            depth: &mut [],
            prepared: None,
            shadows: self.maps.for_scene(blob, scene, watch)?,
        };
        instances.prepare(watch);
        let palette = watch.time(Phase::ShadingTables, || instances.scene_tones.palette(blob));
        let (tones, strip) = (&mut self.tones, &mut self.strip);
        let width = usize::from(camera.width);
        if mode.frame == FrameMode::Quarters {
            let blend = watch.time(Phase::ShadingTables, || Blend::new(&palette));
            for rows in bands(camera.height) {
                let strip = strip.get_mut(..width * (rows.len() / 2));
                let strip = strip.ok_or(ModelError::TooLarge)?;
                let mut band = watch
                    .time(Phase::Clear, || {
                        Tones::band(tones, QUARTERS, 2 * camera.width, rows.clone())
                    })
                    .ok_or(ModelError::TooLarge)?;
                let reach = Self::draw(&mut instances, &mut band, Some(&rows), watch)?;
                watch.time(Phase::Fill, || {
                    blend.rows(&band, strip, camera.width, reach);
                });
                watch.time(Phase::Send, || give(strip))?;
            }
            return Ok(());
        }
        let mut frame = watch
            .time(Phase::Clear, || {
                Tones::cleared(tones, TONES, camera.width, camera.height)
            })
            .ok_or(ModelError::TooLarge)?;
        Self::draw(&mut instances, &mut frame, None, watch)?;
        watch.time(Phase::Send, || {
            let mut rows = frame.rows();
            loop {
                let mut ready = 0;
                let words = strip.chunks_exact_mut(width.max(1));
                for (words, tones) in words.zip(rows.by_ref().take(STRIP.into())) {
                    for (word, tone) in words.iter_mut().zip(tones) {
                        *word = palette.colour(*tone);
                    }
                    ready += width;
                }
                if ready == 0 {
                    return Ok(());
                }
                give(strip.get(..ready).unwrap_or_default())?;
            }
        })
    }

    fn shapes<C: Counter>(
        &mut self,
        shapes: Shapes<'_>,
        watch: &mut Stopwatch<'_, C>,
        give: Give<'_>,
    ) -> Result<(), ScreenError> {
        for first in (0..HEIGHT).step_by(STRIP.into()) {
            watch.time(Phase::Draw, || draw_part(&mut self.strip, first, shapes));
            watch.time(Phase::Send, || give(&self.strip))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rho_grid::mode::VisibilityMode;

    const _: () = assert!(HEIGHT.is_multiple_of(STRIP));

    #[test]
    fn a_band_of_quarters_fills_a_strip() {
        for rows in bands(HEIGHT) {
            assert_eq!(rows.len() / 2, usize::from(STRIP));
        }
    }

    #[test]
    fn modes_that_no_preset_is_are_refused() {
        assert!(!is_known(Mode::default()));
        let tones = Mode {
            frame: FrameMode::Tones,
            ..Mode::default()
        };
        assert!(is_known(tones));
        assert!(!is_known(Mode {
            visibility: VisibilityMode::Z,
            ..tones
        }));
    }
}
