//! Pictures by the presets, in little memory: a byte a pixel, sent strip by strip.
//!
//! A frame of tones is half as large as one of colours, and a band of quarters a quarter of that; their
//! colours are looked up as they are sent, [`STRIP`] rows at a time, so that no frame of colours is
//! ever whole. What it draws is what [`Frames`](crate::picture::Frames) draws by the same presets.

use rho_grid::mode::{FootprintMode, FrameMode, Mode, ReciprocalMode, VisibilityMode};
use rho_grid::reciprocal::Divide;
use rho_grid::render::footprint::{Disc, PixelCentre};
use rho_grid::render::{Blend, Rect, View, Visibility, bands, draw};
use rho_grid::shading::{Palette, ToneTable};

use crate::count::{Counter, Phase, Stopwatch};
use crate::painter::{Give, PaintError, Painter, Shapes, draw_part};
use crate::panel::ScreenError;
use crate::picture::{BACKGROUND, Model, ModelError, PanelQuarters, PanelTones, TONE_WORDS};
use crate::request::Scene;
use crate::size::{HEIGHT, WIDTH};

/// Rows of a strip: half of those of a band of quarters.
const STRIP: u16 = 40;

/// The memory of a painter in strips.
#[derive(Debug)]
pub struct Strips {
    view: View,
    tone_table: ToneTable,
    tones: [u32; TONE_WORDS],
    strip: [u16; STRIP as usize * WIDTH as usize],
}

impl Strips {
    /// All zeros, so that a board's static costs no flash.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            view: View::empty(),
            tone_table: ToneTable::empty(),
            tones: [0; TONE_WORDS],
            strip: [0; STRIP as usize * WIDTH as usize],
        }
    }
}

impl Default for Strips {
    fn default() -> Self {
        Self::new()
    }
}

/// Whether a mode is among those that a preset may be.
fn is_known(mode: Mode) -> bool {
    mode.visibility == VisibilityMode::Eye
        && mode.reciprocal == ReciprocalMode::Divide
        && mode.frame != FrameMode::Words
        && matches!(mode.footprint, FootprintMode::Disc | FootprintMode::Box)
}

impl Painter for Strips {
    fn model<C: Counter>(
        &mut self,
        model: &Model<'_>,
        scene: &Scene,
        watch: &mut Stopwatch<'_, C>,
        give: Give<'_>,
    ) -> Result<(), PaintError> {
        let Self {
            view,
            tone_table,
            tones,
            strip,
        } = self;
        let Scene {
            camera,
            light,
            mode,
        } = scene;
        if !is_known(*mode) {
            return Err(ModelError::Mode.into());
        }
        let blob = model.blob();
        let grid = &blob.grid(mode.grid).ok_or(ModelError::Grid(mode.grid))?;
        let quarters = match mode.frame {
            FrameMode::Quarters => Some(camera.in_quarters().ok_or(ModelError::TooLarge)?),
            FrameMode::Tones | FrameMode::Words => None,
        };
        let seen = quarters.as_ref().unwrap_or(camera);
        watch
            .time(Phase::Setup, || view.prepare(seen, grid, mode.cell_size))
            .map_err(ModelError::View)?;
        let palette = watch.time(Phase::ShadingTables, || {
            tone_table.shade(grid.layout(), blob.materials().len(), *light);
            Palette::new(blob.materials(), BACKGROUND)
        });
        let width = usize::from(camera.width);
        if let Some(quarters) = quarters {
            let blend = watch.time(Phase::ShadingTables, || Blend::new(&palette));
            for rows in bands(camera.height) {
                view.see_rows(rows.clone());
                let strip = strip.get_mut(..width * (rows.len() / 2));
                let strip = strip.ok_or(ModelError::TooLarge)?;
                let mut band = watch
                    .time(Phase::Clear, || {
                        PanelQuarters::band(tones, quarters.width, rows)
                    })
                    .ok_or(ModelError::TooLarge)?;
                watch.time(Phase::Draw, || {
                    by_footprint(mode.footprint, grid, view, tone_table, &mut band)
                });
                watch.time(Phase::Fill, || blend.rows(&band, strip, camera.width));
                watch.time(Phase::Send, || give(strip))?;
            }
            return Ok(());
        }
        let mut frame = watch
            .time(Phase::Clear, || {
                PanelTones::cleared(tones, camera.width, camera.height)
            })
            .ok_or(ModelError::TooLarge)?;
        let reach = watch.time(Phase::Draw, || {
            by_footprint(mode.footprint, grid, view, tone_table, &mut frame)
        });
        if let Some(reach) = reach {
            watch.time(Phase::Fill, || frame.fill(reach));
        }
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

/// What presets draw: discs, or boxes where the samples have no offsets.
fn by_footprint<V: Visibility>(
    footprint: FootprintMode,
    grid: &rho_grid::blob::Grid<'_>,
    view: &View,
    tones: &ToneTable,
    target: &mut V,
) -> Option<Rect> {
    match footprint {
        FootprintMode::Disc => draw::<V, Disc, Divide>(grid, view, tones, target),
        _ => draw::<V, PixelCentre, Divide>(grid, view, tones, target),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
