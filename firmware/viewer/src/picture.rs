//! A model's picture into a frame.

use core::fmt;

use rho_grid::blob::format::MAX_MATERIALS;
use rho_grid::blob::{Blob, BlobError, Grid};
use rho_grid::frame::Frame;
use rho_grid::mode::{FrameMode, LightSplat, MapSize, ShadowMode};
use rho_grid::q::Unit;
use rho_grid::render::shadow::{ShadowMap, Shadows};
use rho_grid::render::{
    Buffers, EyeOrder, Tones, View, ViewError, draw_mode, draw_seen, tone_words,
};
use rho_grid::shading::{Palette, Shading, ToneTable};

use crate::count::{Counter, Phase, Stopwatch};
use crate::request::Scene;
use crate::size::{HEIGHT, PIXELS, WIDTH, Words};

/// The background: black.
const BACKGROUND: u16 = 0;

/// What drawing needs beside the frame, for every mode and up to eight materials.
#[derive(Debug)]
pub struct Memory {
    view: View,
    colours: [u16; Shading::words(MAX_MATERIALS)],
    coverage: [u32; EyeOrder::words(WIDTH, HEIGHT)],
    depth: [u16; PIXELS],
    tone_table: ToneTable,
    tones: [u32; tone_words(WIDTH as usize, HEIGHT)],
    shadow: Shadow,
}

/// A shadow map, its tables, and what they were made for.
#[derive(Debug)]
struct Shadow {
    tables: Shadows,
    map: [u16; MapSize::LARGEST.words()],
    made_for: Option<MadeFor>,
}

/// All that a map depends on while there is one model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct MadeFor {
    light: [Unit; 3],
    grid: u16,
    size: MapSize,
    splat: LightSplat,
}

impl Shadow {
    const fn new() -> Self {
        Self {
            tables: Shadows::empty(),
            map: [0; MapSize::LARGEST.words()],
            made_for: None,
        }
    }

    /// The map for a scene, with its tables: made, or as it is when it is to be kept and can be.
    fn map(
        &mut self,
        blob: &Blob<'_>,
        grid: &Grid<'_>,
        scene: &Scene,
    ) -> Option<(&Shadows, ShadowMap<'_>)> {
        let Scene { light, mode, .. } = scene;
        let wanted = MadeFor {
            light: *light,
            grid: mode.grid,
            size: mode.shadow_map,
            splat: mode.light_splat,
        };
        let kept = mode.shadows == ShadowMode::Kept && self.made_for == Some(wanted);
        let Self {
            tables,
            map,
            made_for,
        } = self;
        *made_for = Some(wanted);
        let map = if kept {
            ShadowMap::kept(map, wanted.size)?
        } else {
            let how = (wanted.size, wanted.splat);
            tables.cast(blob, grid, *light, how, map)?
        };
        Some((tables, map))
    }
}

/// A frame of a byte a pixel, as wide as the panel.
type PanelTones<'a> = Tones<'a, { WIDTH as usize }, { 3 * WIDTH as usize + 4 }>;

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
            tones: [0; tone_words(WIDTH as usize, HEIGHT)],
            shadow: Shadow::new(),
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
    /// The frame is larger than the board's memory for it.
    TooLarge,
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Blob(error) => error.fmt(f),
            Self::Grid(index) => write!(f, "the blob has no grid {index}"),
            Self::View(error) => error.fmt(f),
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
            shadow,
        } = memory;
        let Scene {
            camera,
            light,
            mode,
        } = scene;
        let blob = &self.blob;
        let grid = &blob.grid(mode.grid).ok_or(ModelError::Grid(mode.grid))?;
        watch
            .time(Phase::Setup, || view.prepare(camera, grid, mode.cell_size))
            .map_err(ModelError::View)?;
        let shadows = match mode.shadows {
            ShadowMode::None => None,
            ShadowMode::TwoPass | ShadowMode::Kept => {
                let shadows = watch.time(Phase::ShadowMap, || shadow.map(blob, grid, scene));
                Some(shadows.ok_or(ModelError::TooLarge)?)
            }
        };
        if mode.frame == FrameMode::Tones {
            watch.time(Phase::ShadingTables, || {
                tone_table.shade(grid.layout(), blob.materials().len(), *light);
            });
            let mut frame = watch
                .time(Phase::Clear, || {
                    PanelTones::cleared(tones, camera.width, camera.height)
                })
                .ok_or(ModelError::TooLarge)?;
            let reach = watch.time(Phase::Draw, || match &shadows {
                None => draw_seen(*mode, grid, view, tone_table, &mut frame),
                Some((tables, map)) => {
                    let shade = tables.over(tone_table, map);
                    draw_seen(*mode, grid, view, &shade, &mut frame)
                }
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
            .time(Phase::Draw, || match &shadows {
                None => draw_mode(*mode, grid, view, &shading, &mut frame, &mut buffers),
                Some((tables, map)) => {
                    let shade = tables.over(&shading, map);
                    draw_mode(*mode, grid, view, &shade, &mut frame, &mut buffers)
                }
            })
            .map_err(|_| ModelError::TooLarge)
    }
}
