//! The picture of a model or a scene into a frame.

use core::fmt;

use rho_grid::blob::format::MAX_MATERIALS;
use rho_grid::blob::{Blob, BlobError};
use rho_grid::frame::Frame;
use rho_grid::mode::{FrameMode, MapSize, ShadowMode, VisibilityMode};
use rho_grid::render::{
    Blend, Buffers, EyeOrder, Rect, Tones, View, ViewError, ZBuffer, bands, quarter_words,
    tone_words,
};
use rho_grid::scene::{Arrangement, Placed, SceneTones, Turn};
use rho_grid::shading::{Shade, Shading};

use crate::count::{Counter, Phase, Stopwatch};
use crate::instances::{Divided, Every, Instances, Modes, Preset, draw_turn, place};
use crate::painter::{Give, PaintError, Painter, Shapes, draw_part};
use crate::panel::ScreenError;
use crate::request::Scene;
use crate::shadow::{Maps, Seen, Shadow};
use crate::size::{HEIGHT, PIXELS, WIDTH, Words};

/// What drawing needs beside the frame, for every mode and up to eight materials.
#[derive(Debug)]
pub struct Memory {
    arrangement: Arrangement,
    view: View,
    colours: [u16; Shading::words(MAX_MATERIALS)],
    coverage: [u32; EyeOrder::words(WIDTH, HEIGHT)],
    depth: [u16; PIXELS],
    scene_tones: SceneTones,
    /// Of a whole frame, or of a band of quarters.
    tones: [u32; TONE_WORDS],
    shadow: Shadow<{ MapSize::LARGEST.words() }>,
}

/// Bytes from row to row of a frame of tones, and of a band of quarters: as wide as the panel.
pub(crate) const TONES: usize = WIDTH as usize;
pub(crate) const QUARTERS: usize = 2 * TONES;

pub(crate) const TONE_WORDS: usize = {
    let frame = tone_words(TONES, HEIGHT);
    let band = quarter_words(QUARTERS);
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
            scene_tones: SceneTones::empty(),
            tones: [0; TONE_WORDS],
            shadow: Shadow::EMPTY,
        }
    }
}

impl Memory {
    /// What drawing instances into tones takes, and the memory of the tones.
    fn instances<'a, 'g, C: Counter>(
        &'a mut self,
        blob: &'a Blob<'g>,
        scene: &'a Scene,
        watch: &mut Stopwatch<'_, C>,
    ) -> Result<(Instances<'a, 'g>, &'a mut [u32]), ModelError> {
        let instances = Instances {
            blob,
            scene,
            arrangement: &self.arrangement,
            view: &mut self.view,
            scene_tones: &mut self.scene_tones,
            depth: &mut self.depth,
            prepared: None,
            shadows: self.shadow.for_scene(blob, scene, watch)?,
        };
        Ok((instances, &mut self.tones))
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
    /// Objects reach into each other, and the program has no depths.
    Tangled,
    /// The frame or the shadow map is larger than the board's memory for it.
    TooLarge,
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Blob(error) => error.fmt(f),
            Self::Grid(index) => write!(f, "the blob has no grid {index}"),
            Self::View(error) => error.fmt(f),
            Self::Mode => {
                f.write_str("this program does not draw in this mode (some draw by presets alone)")
            }
            Self::Tangled => {
                f.write_str("objects reach into each other, and there is no memory for depths")
            }
            Self::TooLarge => {
                f.write_str("the frame or the shadow map is larger than the memory for it")
            }
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

    /// Finds what the scene shows, and in which order.
    ///
    /// # Errors
    /// When there is no such grid, or the camera is none.
    pub(crate) fn arrange<C: Counter>(
        &self,
        scene: &Scene,
        arrangement: &mut Arrangement,
        watch: &mut Stopwatch<'_, C>,
    ) -> Result<(), ModelError> {
        let Scene {
            camera,
            mode,
            light,
        } = scene;
        let blob = &self.blob;
        if mode.contradiction().is_some() {
            return Err(ModelError::Mode);
        }
        if mode.fineness.is_none() && !blob.is_scene() && mode.grid >= blob.grid_count() {
            return Err(ModelError::Grid(mode.grid));
        }
        let in_order = mode.visibility == VisibilityMode::Eye;
        watch
            .time(Phase::Setup, || match mode.shadows {
                ShadowMode::OnePass => arrangement.arrange_in_light(blob, camera, *light),
                _ => arrangement.arrange(blob, camera, in_order),
            })
            .map_err(ModelError::View)
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
        self.arrange(scene, &mut memory.arrangement, watch)?;
        match scene.mode.frame {
            FrameMode::Words => self.words(scene, words, memory, watch),
            FrameMode::Tones => self.tones(scene, words, memory, watch),
            FrameMode::Quarters => self.quarters(scene, words, memory, watch),
        }
    }

    /// Into a byte a pixel.
    fn tones<C: Counter>(
        &self,
        scene: &Scene,
        words: &mut Words,
        memory: &mut Memory,
        watch: &mut Stopwatch<'_, C>,
    ) -> Result<(), ModelError> {
        let camera = &scene.camera;
        let (mut instances, tones) = memory.instances(&self.blob, scene, watch)?;
        instances.prepare(watch);
        let mut frame = watch
            .time(Phase::Clear, || {
                Tones::cleared(tones, TONES, camera.width, camera.height)
            })
            .ok_or(ModelError::TooLarge)?;
        instances.draw::<Preset<true, true>, _>(&mut frame, None, watch)?;
        watch.time(Phase::Send, || {
            let palette = instances.scene_tones.palette(&self.blob);
            for (word, tone) in words.iter_mut().zip(frame.rows().flatten()) {
                *word = palette.colour(*tone);
            }
        });
        Ok(())
    }

    /// Into a byte a quarter of a pixel, blended.
    fn quarters<C: Counter>(
        &self,
        scene: &Scene,
        words: &mut Words,
        memory: &mut Memory,
        watch: &mut Stopwatch<'_, C>,
    ) -> Result<(), ModelError> {
        let camera = &scene.camera;
        let (mut instances, tones) = memory.instances(&self.blob, scene, watch)?;
        instances.prepare(watch);
        let blend = watch.time(Phase::ShadingTables, || {
            Blend::new(&instances.scene_tones.palette(&self.blob))
        });
        for rows in bands(camera.height) {
            let first = usize::from(rows.start / 2) * usize::from(camera.width);
            let words = words.get_mut(first..).unwrap_or_default();
            let mut band = watch
                .time(Phase::Clear, || {
                    Tones::band(tones, QUARTERS, 2 * camera.width, rows.clone())
                })
                .ok_or(ModelError::TooLarge)?;
            let reach = instances.draw::<Preset<true, true>, _>(&mut band, Some(&rows), watch)?;
            watch.time(Phase::Fill, || {
                blend.rows(&band, words, camera.width, reach);
            });
        }
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
            shadow,
            ..
        } = memory;
        let (blob, camera, mode) = (&self.blob, &scene.camera, scene.mode);
        let mut shadows = shadow.for_scene(blob, scene, watch)?;
        let mut frame =
            Frame::new(words, camera.width, camera.height).ok_or(ModelError::TooLarge)?;
        watch.time(Phase::Clear, || {
            frame.clear_to(blob.background());
            Buffers { coverage, depth }.clear(mode);
        });
        for turn in arrangement.turns() {
            let Some(placed) = place(blob, *turn, scene, view, watch)? else {
                continue;
            };
            let shading = watch
                .time(Phase::ShadingTables, || {
                    let lighting = placed.lighting(blob, scene.light);
                    Shading::of_instance(colours, blob, &placed, &lighting)
                })
                .ok_or(ModelError::TooLarge)?;
            if let Some(shadows) = &mut shadows {
                shadows.see(&placed, watch);
            }
            let unit = arrangement.unit();
            watch.time(Phase::Draw, || {
                let mut turn = InWords {
                    turn: *turn,
                    placed: &placed,
                    view,
                    unit,
                    coverage,
                    depth,
                };
                match &mut shadows {
                    None => turn.draw::<Every>(&shading, &mut frame),
                    Some(Seen {
                        tables,
                        map,
                        one_pass: Some(_),
                        ..
                    }) => {
                        let shading = tables.in_order(&shading, map.lend());
                        turn.draw_deep::<Divided>(&shading, &mut frame)
                    }
                    Some(Seen { tables, map, .. }) => {
                        turn.draw::<Divided>(&tables.over(&shading, map), &mut frame)
                    }
                }
            })?;
        }
        Ok(())
    }
}

/// The turn of an instance into words.
struct InWords<'a, 'g> {
    turn: Turn,
    placed: &'a Placed<'g>,
    view: &'a View,
    unit: Option<u32>,
    coverage: &'a mut [u32],
    depth: &'a mut [u16],
}

impl InWords<'_, '_> {
    fn draw<M: Modes>(
        &mut self,
        shading: &impl Shade,
        frame: &mut Frame<'_>,
    ) -> Result<Option<Rect>, ModelError> {
        let (placed, view, unit) = (self.placed, self.view, self.unit);
        match placed.mode.visibility {
            VisibilityMode::Eye => {
                let target = EyeOrder::new(frame, self.coverage);
                let target = &mut target.ok_or(ModelError::TooLarge)?;
                draw_turn::<M, _>(self.turn, placed, view, shading, unit, target, self.depth)
            }
            VisibilityMode::Z => self.draw_deep::<M>(shading, frame),
        }
    }

    /// In any order, against depths.
    fn draw_deep<M: Modes>(
        &mut self,
        shading: &impl Shade,
        frame: &mut Frame<'_>,
    ) -> Result<Option<Rect>, ModelError> {
        let (placed, view) = (self.placed, self.view);
        let target = ZBuffer::<_, false>::new(frame, self.depth);
        let mut target = target.ok_or(ModelError::TooLarge)?;
        if let Some(unit) = self.unit {
            target = target.scaled(placed.depth_factor(view, unit));
        }
        Ok(M::draw(placed, view, shading, &mut target))
    }
}
