//! A model's picture into a frame.

use core::fmt;

use rho_grid::blob::format::MAX_MATERIALS;
use rho_grid::blob::{Blob, BlobError};
use rho_grid::frame::Frame;
use rho_grid::mode::FrameMode;
use rho_grid::render::{
    Blend, Buffers, EyeOrder, Tones, View, ViewError, bands, draw_mode, draw_seen, quarter_words,
    tone_words,
};
use rho_grid::shading::{Palette, Shading, ToneTable};

use crate::count::{Counter, Phase, Stopwatch};
use crate::painter::{Give, PaintError, Painter, Shapes, draw_part};
use crate::panel::ScreenError;
use crate::request::Scene;
use crate::size::{HEIGHT, PIXELS, WIDTH, Words};

/// The background: black.
pub(crate) const BACKGROUND: u16 = 0;

/// What drawing needs beside the frame, for every mode and up to eight materials.
#[derive(Debug)]
pub struct Memory {
    view: View,
    colours: [u16; Shading::words(MAX_MATERIALS)],
    coverage: [u32; EyeOrder::words(WIDTH, HEIGHT)],
    depth: [u16; PIXELS],
    tone_table: ToneTable,
    /// Of a whole frame, or of a band of quarters.
    tones: [u32; TONE_WORDS],
}

/// Quarters a row, and from the first of a window of four rows to beyond its last.
const QUARTERS: (usize, usize) = (2 * WIDTH as usize, 6 * WIDTH as usize + 4);

pub(crate) const TONE_WORDS: usize = {
    let frame = tone_words(WIDTH as usize, HEIGHT);
    let band = quarter_words(QUARTERS.0);
    if frame > band { frame } else { band }
};

/// Draws into a whole frame of words, in every mode.
#[derive(Debug)]
pub struct Frames<'a> {
    /// The frame.
    pub words: &'a mut Words,
    /// What drawing a model needs beside.
    pub memory: &'a mut Memory,
}

impl Painter for Frames<'_> {
    fn model<C: Counter>(
        &mut self,
        model: &Model<'_>,
        scene: &Scene,
        watch: &mut Stopwatch<'_, C>,
        give: Give<'_>,
    ) -> Result<(), PaintError> {
        model.draw(scene, self.words, self.memory, watch)?;
        let pixels = usize::from(scene.camera.width) * usize::from(scene.camera.height);
        let frame = self.words.get(..pixels).ok_or(ModelError::TooLarge)?;
        Ok(watch.time(Phase::Send, || give(frame))?)
    }

    fn shapes<C: Counter>(
        &mut self,
        shapes: Shapes<'_>,
        watch: &mut Stopwatch<'_, C>,
        give: Give<'_>,
    ) -> Result<(), ScreenError> {
        watch.time(Phase::Draw, || draw_part(self.words, 0, shapes));
        watch.time(Phase::Send, || give(self.words))
    }
}

/// A frame of a byte a pixel, as wide as the panel.
pub(crate) type PanelTones<'a> = Tones<'a, { WIDTH as usize }, { 3 * WIDTH as usize + 4 }>;

/// A band of quarters, as wide as the panel.
pub(crate) type PanelQuarters<'a> = Tones<'a, { QUARTERS.0 }, { QUARTERS.1 }>;

impl Memory {
    /// All zeros, so that a board's static costs no flash.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            view: View::empty(),
            colours: [0; Shading::words(MAX_MATERIALS)],
            coverage: [0; EyeOrder::words(WIDTH, HEIGHT)],
            depth: [0; PIXELS],
            tone_table: ToneTable::empty(),
            tones: [0; TONE_WORDS],
        }
    }
}

impl Default for Memory {
    fn default() -> Self {
        Self::new()
    }
}

/// Why a model is not drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelError {
    /// The blob is refused.
    Blob(BlobError),
    /// It has no grid of this number.
    Grid(u16),
    /// The camera is none.
    View(ViewError),
    /// The program was built without this mode.
    Mode,
    /// The frame is larger than the board's memory for it.
    TooLarge,
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Blob(error) => error.fmt(f),
            Self::Grid(index) => write!(f, "the blob has no grid {index}"),
            Self::View(error) => error.fmt(f),
            Self::Mode => f.write_str("this program draws by presets alone"),
            Self::TooLarge => f.write_str("the frame is larger than the memory for it"),
        }
    }
}

impl core::error::Error for ModelError {}

/// A model in flash that can be drawn: its blob was checked.
#[derive(Clone, Copy, Debug)]
pub struct Model<'a> {
    blob: Blob<'a>,
}

impl<'a> Model<'a> {
    /// Checks the blob at the start of `flash`, once.
    ///
    /// # Errors
    /// When there is none, or it is refused.
    pub fn check(flash: &'a [u8]) -> Result<Self, ModelError> {
        let blob = Blob::parse(flash).map_err(ModelError::Blob)?;
        Ok(Self { blob })
    }

    /// What was checked.
    #[must_use]
    pub fn blob(&self) -> &Blob<'a> {
        &self.blob
    }

    /// Draws the scene into the first `width * height` words.
    ///
    /// # Errors
    /// When there is no such grid, the camera is none or its frame too large.
    pub fn draw<C: Counter>(
        &self,
        scene: &Scene,
        words: &mut Words,
        memory: &mut Memory,
        watch: &mut Stopwatch<'_, C>,
    ) -> Result<(), ModelError> {
        let Memory {
            view,
            colours,
            coverage,
            depth,
            tone_table,
            tones,
        } = memory;
        let Scene {
            camera,
            light,
            mode,
        } = scene;
        let blob = &self.blob;
        let grid = &blob.grid(mode.grid).ok_or(ModelError::Grid(mode.grid))?;
        let quarters = match mode.frame {
            FrameMode::Quarters => Some(camera.in_quarters().ok_or(ModelError::TooLarge)?),
            FrameMode::Tones | FrameMode::Words => None,
        };
        let seen = quarters.as_ref().unwrap_or(camera);
        watch
            .time(Phase::Setup, || view.prepare(seen, grid, mode.cell_size))
            .map_err(ModelError::View)?;
        if let Some(quarters) = quarters {
            let blend = watch.time(Phase::ShadingTables, || {
                tone_table.shade(grid.layout(), blob.materials().len(), *light);
                Blend::new(&Palette::new(blob.materials(), BACKGROUND))
            });
            for rows in bands(camera.height) {
                let first = usize::from(rows.start / 2) * usize::from(camera.width);
                view.see_rows(rows.clone());
                let mut band = watch
                    .time(Phase::Clear, || {
                        PanelQuarters::band(tones, quarters.width, rows)
                    })
                    .ok_or(ModelError::TooLarge)?;
                watch.time(Phase::Draw, || {
                    draw_seen(*mode, grid, view, tone_table, &mut band)
                });
                watch.time(Phase::Fill, || {
                    let words = words.get_mut(first..).unwrap_or_default();
                    blend.rows(&band, words, camera.width);
                });
            }
            return Ok(());
        }
        if mode.frame == FrameMode::Tones {
            watch.time(Phase::ShadingTables, || {
                tone_table.shade(grid.layout(), blob.materials().len(), *light);
            });
            let mut frame = watch
                .time(Phase::Clear, || {
                    PanelTones::cleared(tones, camera.width, camera.height)
                })
                .ok_or(ModelError::TooLarge)?;
            let reach = watch.time(Phase::Draw, || {
                draw_seen(*mode, grid, view, tone_table, &mut frame)
            });
            if let Some(reach) = reach {
                watch.time(Phase::Fill, || frame.fill(reach));
            }
            watch.time(Phase::Send, || {
                let palette = Palette::new(blob.materials(), BACKGROUND);
                for (word, tone) in words.iter_mut().zip(frame.rows().flatten()) {
                    *word = palette.colour(*tone);
                }
            });
            return Ok(());
        }
        let shading = watch
            .time(Phase::ShadingTables, || {
                Shading::new(colours, grid.layout(), blob.materials(), *light)
            })
            .ok_or(ModelError::TooLarge)?;
        let mut frame =
            Frame::new(words, camera.width, camera.height).ok_or(ModelError::TooLarge)?;
        let mut buffers = Buffers { coverage, depth };
        watch.time(Phase::Clear, || {
            frame.clear_to(BACKGROUND);
            buffers.clear(*mode);
        });
        watch
            .time(Phase::Draw, || {
                draw_mode(*mode, grid, view, &shading, &mut frame, &mut buffers)
            })
            .map_err(|_| ModelError::TooLarge)
    }
}
