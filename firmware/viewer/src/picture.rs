//! The picture of a model or a scene into a frame.

use core::fmt;

use rho_grid::blob::format::MAX_MATERIALS;
use rho_grid::blob::{Blob, BlobError};
use rho_grid::frame::Frame;
use rho_grid::mode::{FrameMode, VisibilityMode};
use rho_grid::render::{
    Buffers, Canvas, EyeOrder, Rect, Tones, View, ViewError, Visibility, ZBuffer, draw_seen,
    tone_words,
};
use rho_grid::scene::{Arrangement, Placed, SceneTones, Turn};
use rho_grid::shading::{Palette, Shade, Shading, ToneTable};

use crate::count::{Counter, Phase, Stopwatch};
use crate::request::Scene;
use crate::size::{HEIGHT, PIXELS, WIDTH, Words};

/// What drawing needs beside the frame, for every mode and up to eight materials.
#[derive(Debug)]
pub struct Memory {
    arrangement: Arrangement,
    view: View,
    colours: [u16; Shading::words(MAX_MATERIALS)],
    coverage: [u32; EyeOrder::words(WIDTH, HEIGHT)],
    depth: [u16; PIXELS],
    tone_table: ToneTable,
    scene_tones: SceneTones,
    tones: [u32; tone_words(WIDTH as usize, HEIGHT)],
}

/// A frame of a byte a pixel, as wide as the panel.
type PanelTones<'a> = Tones<'a, { WIDTH as usize }, { 3 * WIDTH as usize + 4 }>;

impl Memory {
    /// All zeros, so that a board's static costs no flash.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            arrangement: Arrangement::empty(),
            view: View::empty(),
            colours: [0; Shading::words(MAX_MATERIALS)],
            coverage: [0; EyeOrder::words(WIDTH, HEIGHT)],
            depth: [0; PIXELS],
            tone_table: ToneTable::empty(),
            scene_tones: SceneTones::empty(),
            tones: [0; tone_words(WIDTH as usize, HEIGHT)],
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
        let Scene { camera, mode, .. } = scene;
        let blob = &self.blob;
        if mode.fineness.is_none() && !blob.is_scene() && mode.grid >= blob.grid_count() {
            return Err(ModelError::Grid(mode.grid));
        }
        let in_order = mode.visibility == VisibilityMode::Eye;
        watch
            .time(Phase::Setup, || {
                memory.arrangement.arrange(blob, camera, in_order)
            })
            .map_err(ModelError::View)?;
        match mode.frame {
            FrameMode::Tones => self.tones(scene, words, memory, watch),
            FrameMode::Words => self.words(scene, words, memory, watch),
        }
    }

    /// Whether it is one model, whose samples have no colours of their own.
    fn is_plain(&self) -> bool {
        let coloured = self.blob.grids().any(|grid| grid.layout().colour > 0);
        !self.blob.is_scene() && !coloured
    }

    /// Into a byte a pixel.
    fn tones<C: Counter>(
        &self,
        scene: &Scene,
        words: &mut Words,
        memory: &mut Memory,
        watch: &mut Stopwatch<'_, C>,
    ) -> Result<(), ModelError> {
        let Memory {
            arrangement,
            view,
            depth,
            tone_table,
            scene_tones,
            tones,
            ..
        } = memory;
        let (blob, camera) = (&self.blob, &scene.camera);
        let is_plain = self.is_plain();
        if !is_plain {
            watch.time(Phase::ShadingTables, || {
                let instances = arrangement.turns().iter().map(|turn| turn.instance);
                scene_tones.prepare(blob, instances, camera, scene.light);
            });
        }
        let mut frame = watch
            .time(Phase::Clear, || {
                PanelTones::cleared(tones, camera.width, camera.height)
            })
            .ok_or(ModelError::TooLarge)?;
        let unit = arrangement.unit();
        let mut reach = None;
        for turn in arrangement.turns() {
            let Some(placed) = self.placed(*turn, scene, view, watch)? else {
                continue;
            };
            let drawn = if is_plain {
                let materials = blob.materials().len();
                watch.time(Phase::ShadingTables, || {
                    tone_table.shade(placed.grid.layout(), materials, scene.light);
                });
                watch.time(Phase::Draw, || {
                    draw_turn(*turn, &placed, view, tone_table, unit, &mut frame, depth)
                })?
            } else {
                watch.time(Phase::ShadingTables, || {
                    let lighting = placed.lighting(blob, scene.light);
                    scene_tones.shade(blob, &placed, &lighting);
                });
                watch.time(Phase::Draw, || {
                    draw_turn(*turn, &placed, view, scene_tones, unit, &mut frame, depth)
                })?
            };
            reach = match (reach, drawn) {
                (Some(a), Some(b)) => Some(Rect::with(a, b)),
                (a, b) => a.or(b),
            };
            // Holes are closed before what is behind shows through them.
            if turn.is_last
                && let Some(reach) = reach.take()
            {
                watch.time(Phase::Fill, || frame.fill(reach));
            }
        }
        watch.time(Phase::Send, || {
            let palette = if is_plain {
                Palette::new(blob.materials(), blob.background())
            } else {
                scene_tones.palette(blob.background())
            };
            for (word, tone) in words.iter_mut().zip(frame.rows().flatten()) {
                *word = palette.colour(*tone);
            }
        });
        Ok(())
    }

    /// Into RGB565 words.
    fn words<C: Counter>(
        &self,
        scene: &Scene,
        words: &mut Words,
        memory: &mut Memory,
        watch: &mut Stopwatch<'_, C>,
    ) -> Result<(), ModelError> {
        let Memory {
            arrangement,
            view,
            colours,
            coverage,
            depth,
            ..
        } = memory;
        let (blob, camera, mode) = (&self.blob, &scene.camera, scene.mode);
        let mut frame =
            Frame::new(words, camera.width, camera.height).ok_or(ModelError::TooLarge)?;
        watch.time(Phase::Clear, || {
            frame.clear_to(blob.background());
            Buffers { coverage, depth }.clear(mode);
        });
        for turn in arrangement.turns() {
            let Some(placed) = self.placed(*turn, scene, view, watch)? else {
                continue;
            };
            let shading = watch
                .time(Phase::ShadingTables, || {
                    let lighting = placed.lighting(blob, scene.light);
                    Shading::of_instance(colours, blob, &placed, &lighting)
                })
                .ok_or(ModelError::TooLarge)?;
            let unit = arrangement.unit();
            watch.time(Phase::Draw, || match mode.visibility {
                VisibilityMode::Eye => {
                    let mut target =
                        EyeOrder::new(&mut frame, coverage).ok_or(ModelError::TooLarge)?;
                    draw_turn(*turn, &placed, view, &shading, unit, &mut target, depth)
                }
                VisibilityMode::Z => {
                    let target = ZBuffer::<_, false>::new(&mut frame, depth);
                    let mut target = target.ok_or(ModelError::TooLarge)?;
                    if let Some(unit) = unit {
                        target = target.scaled(placed.depth_factor(view, unit));
                    }
                    Ok(draw_seen(
                        placed.mode,
                        &placed.grid,
                        view,
                        &shading,
                        &mut target,
                    ))
                }
            })?;
        }
        Ok(())
    }

    /// The instance whose turn it is, and the tables of its view; `None` when it is too far away.
    fn placed<C: Counter>(
        &self,
        turn: Turn,
        scene: &Scene,
        view: &mut View,
        watch: &mut Stopwatch<'_, C>,
    ) -> Result<Option<Placed<'a>>, ModelError> {
        watch.time(Phase::Setup, || {
            let placed = Placed::new(&self.blob, turn.instance, &scene.camera, scene.mode);
            if let Some(placed) = &placed {
                view.prepare(&placed.camera, &placed.grid, scene.mode.cell_size)
                    .map_err(ModelError::View)?;
            }
            Ok(placed)
        })
    }
}

/// Draws an instance in its turn; returns the pixels that it may reach.
fn draw_turn<V: Visibility + Canvas>(
    turn: Turn,
    placed: &Placed<'_>,
    view: &View,
    shading: &impl Shade,
    unit: Option<u32>,
    target: &mut V,
    depth: &mut [u16],
) -> Result<Option<Rect>, ModelError> {
    let Some(unit) = unit.filter(|_| turn.is_tangled) else {
        return Ok(draw_seen(placed.mode, &placed.grid, view, shading, target));
    };
    if turn.is_first {
        target.depths(depth);
    }
    let target = ZBuffer::<_, true>::new(target, depth).ok_or(ModelError::TooLarge)?;
    let mut target = target.scaled(placed.depth_factor(view, unit));
    Ok(draw_seen(
        placed.mode,
        &placed.grid,
        view,
        shading,
        &mut target,
    ))
}
