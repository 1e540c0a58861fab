//! A frame computed on the PC by the device's own renderer.

use std::ops::Range;

use fixed::traits::ToFixed;
use glam::DVec3;
use rho_grid::blob::Blob;
use rho_grid::blob::format::MAX_MATERIALS;
use rho_grid::camera::Camera;
use rho_grid::frame::Frame;
use rho_grid::mode::{FrameMode, Mode, ShadowMode, VisibilityMode};
use rho_grid::q::Unit;
use rho_grid::render::shadow::{ShadowMap, Shadows};
use rho_grid::render::{
    self, Blend, Canvas, EyeOrder, Rect, Tones, Visibility, ZBuffer, bands, quarter_words,
    tone_words,
};
use rho_grid::scene::{Arrangement, Placed, SceneTones, Turn};
use rho_grid::shading::{Shade, Shading};

use crate::failure::{Failure, Outcome};
use crate::picture::{Picture, rgb888};
use crate::view::View;

/// A frame and what is known of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// Pixels a row.
    pub width: u16,
    /// Rows.
    pub height: u16,
    /// RGB565 words, rows from the top.
    pub words: Vec<u16>,
    /// What is where nothing is drawn: black, but for scenes.
    pub background: u16,
    /// A pixel's distance along the optical axis in cube units, NaN where nothing is drawn.
    pub depth: Vec<f32>,
    /// How much of each pixel is covered, 0 to 255, where quarters of pixels tell.
    pub coverage: Option<Vec<u8>>,
}

/// A background of RGB565 words as pictures tell it: black is what they have without one.
fn behind(background: u16) -> Option<[u8; 3]> {
    (background != 0).then(|| rgb888(background))
}

impl Drawn {
    /// Pixels that differ from the background.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.words.iter().filter(|w| **w != self.background).count()
    }

    /// The frame as a picture, with its coverage.
    #[must_use]
    pub fn picture(&self) -> Picture {
        Picture {
            coverage: self.coverage.clone(),
            background: behind(self.background),
            ..Picture::from_rgb565(self.width.into(), self.height.into(), &self.words)
        }
    }

    /// CRC-32 over the words, little-endian, rows from the top.
    #[must_use]
    pub fn crc32(&self) -> u32 {
        frame_crc32(&self.words)
    }
}

/// CRC-32 (IEEE 802.3) over RGB565 words, little-endian, rows from the top.
#[must_use]
pub fn frame_crc32(words: &[u16]) -> u32 {
    let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
    crc32fast::hash(&bytes)
}

/// The unit vector towards a light as a device takes it, rounded to nearest.
#[must_use]
pub fn light(towards: DVec3) -> [Unit; 3] {
    towards.normalize().to_array().map(ToFixed::to_fixed)
}

/// Draws `blob` as `view` sees it, its first light `towards` there.
///
/// # Errors
/// When the view is out of range, or the blob has no such grid.
pub fn render(blob: &Blob<'_>, view: &View, towards: DVec3, mode: Mode) -> Outcome<Drawn> {
    render_from(blob, &view.camera()?, light(towards), mode)
}

/// The same from a device's camera.
///
/// # Errors
/// When the camera is none, or the blob has no such grid.
pub fn render_from(
    blob: &Blob<'_>,
    camera: &Camera,
    towards: [Unit; 3],
    mode: Mode,
) -> Outcome<Drawn> {
    if mode.fineness.is_none() && !blob.is_scene() && mode.grid >= blob.grid_count() {
        let count = blob.grid_count();
        return Err(Failure::input(format!(
            "there is no grid {} in a blob of {count}",
            mode.grid
        ))
        .help(format!("give --grid 0 to {}", count - 1)));
    }
    let mut arrangement = Box::new(Arrangement::empty());
    let in_order = mode.visibility == VisibilityMode::Eye;
    match mode.shadows {
        ShadowMode::OnePass => arrangement.arrange_in_light(blob, camera, towards),
        _ => arrangement.arrange(blob, camera, in_order),
    }
    .map_err(|e| Failure::input(e.to_string()))?;
    let (width, height) = (camera.width, camera.height);
    let pixels = usize::from(width) * usize::from(height);
    let mut words = vec![blob.background(); pixels];
    let mut stage = Stage {
        blob,
        camera,
        mode,
        tables: Box::new(render::View::empty()),
        shadows: None,
        unit: arrangement.unit(),
        depth: vec![f32::NAN; pixels],
        buffer: vec![u16::MAX; pixels],
    };
    let internal = |what: &str| Failure::input(format!("{what} (an error in rho)"));
    let mut texels = vec![0; mode.shadow_map.words()];
    if mode.shadows != ShadowMode::None {
        let mut tables = Box::new(Shadows::empty());
        let mut map = ShadowMap::cleared(&mut texels, mode.shadow_map)
            .ok_or_else(|| internal("shadow map"))?;
        if mode.shadows == ShadowMode::OnePass {
            tables.fit(blob, towards);
        } else {
            tables.cast(blob, towards, mode.light_splat, &mut map);
        }
        stage.shadows = Some((tables, map));
    }
    let mut coverage = None;
    let mut tones = Box::new(SceneTones::empty());
    let instances = arrangement.turns().iter().map(|turn| turn.instance);
    tones.prepare(blob, instances, camera, towards, mode.shadows);
    let palette = tones.palette(blob);
    if mode.frame == FrameMode::Quarters {
        if camera.in_quarters().is_none() {
            let largest = Camera::MAX_QUARTERED;
            return Err(Failure::input(format!(
                "a picture in quarters has at most {largest} x {largest} pixels"
            ))
            .help("give a smaller --size, or --frame tones"));
        }
        stage.depth = vec![f32::NAN; 4 * pixels];
        stage.buffer = vec![u16::MAX; 4 * pixels];
        let mut covered = Vec::with_capacity(pixels);
        let blend = Blend::new(&palette);
        let stride = usize::from(2 * width).next_multiple_of(4);
        let mut buffer = vec![0; quarter_words(stride)];
        for rows in bands(height) {
            let first = usize::from(rows.start / 2) * usize::from(width);
            let mut band = Tones::band(&mut buffer, stride, 2 * width, rows.clone())
                .ok_or_else(|| internal("frame size"))?;
            let reach = stage.tones(
                arrangement.turns(),
                towards,
                &mut tones,
                &mut band,
                Some(&rows),
            )?;
            blend.rows(&band, &mut words[first..], width, reach);
            let places =
                (0..rows.len() as i32 / 2).flat_map(|y| (0..i32::from(width)).map(move |x| (x, y)));
            covered.extend(places.map(|(x, y)| (band.quarters(x, y) * 255).div_ceil(4) as u8));
        }
        stage.gather(usize::from(width));
        coverage = Some(covered);
    } else if mode.frame == FrameMode::Tones {
        let stride = usize::from(width).next_multiple_of(4);
        let mut buffer = vec![0; tone_words(stride, height)];
        let mut frame = Tones::cleared(&mut buffer, stride, width, height)
            .ok_or_else(|| internal("frame size"))?;
        stage.tones(arrangement.turns(), towards, &mut tones, &mut frame, None)?;
        let tones = frame.rows().flatten();
        words = tones.map(|tone| palette.colour(*tone)).collect();
    } else {
        let mut colours = vec![0; Shading::words(MAX_MATERIALS)];
        let mut bits = vec![0; EyeOrder::words(width, height)];
        let mut frame =
            Frame::new(&mut words, width, height).ok_or_else(|| internal("frame size"))?;
        for turn in arrangement.turns() {
            let Some(placed) = stage.placed(*turn)? else {
                continue;
            };
            let shading =
                Shading::of_instance(&mut colours, blob, &placed, &placed.lighting(blob, towards))
                    .ok_or_else(|| internal("shading table"))?;
            if in_order {
                let mut target =
                    EyeOrder::new(&mut frame, &mut bits).ok_or_else(|| internal("coverage"))?;
                stage.draw(*turn, &placed, &shading, &mut target);
            } else if let Some((tables, mut map)) = stage.shadows.take() {
                if mode.shadows == ShadowMode::OnePass {
                    let shading = tables.in_order(&shading, map.lend());
                    stage.draw_deep::<_, false>(&placed, &shading, &mut frame);
                    stage.shadows = Some((tables, map));
                    continue;
                }
                stage.draw_deep::<_, false>(&placed, &tables.over(&shading, &map), &mut frame);
                stage.shadows = Some((tables, map));
            } else {
                stage.draw_deep::<_, false>(&placed, &shading, &mut frame);
            }
        }
    }
    let Stage { depth, .. } = stage;
    Ok(Drawn {
        width,
        height,
        words,
        background: blob.background(),
        depth,
        coverage,
    })
}

/// The picture of a frame that a device has drawn in this mode. A wire carries no coverage: where
/// quarters of pixels tell it, it is that of the same frame drawn here.
///
/// # Errors
/// As [`render_from`].
pub fn picture(
    drawn: (u16, u16, &[u16]),
    blob: &Blob<'_>,
    camera: &Camera,
    towards: [Unit; 3],
    mode: Mode,
) -> Outcome<Picture> {
    let (width, height, words) = drawn;
    if mode.frame == FrameMode::Quarters {
        let ours = render_from(blob, camera, towards, mode)?;
        if ours.words == words {
            return Ok(ours.picture());
        }
    }
    Ok(Picture {
        background: behind(blob.background()),
        ..Picture::from_rgb565(width.into(), height.into(), words)
    })
}

/// What the instances of a frame have in common.
struct Stage<'a> {
    blob: &'a Blob<'a>,
    camera: &'a Camera,
    mode: Mode,
    /// The view of the present instance.
    tables: Box<render::View>,
    /// What the light sees, if there are shadows.
    shadows: Option<(Box<Shadows>, ShadowMap<'a>)>,
    unit: Option<u32>,
    /// What is shown, in sides of the scene's cube.
    depth: Vec<f32>,
    /// The depth buffer's.
    buffer: Vec<u16>,
}

impl<'a> Stage<'a> {
    /// The instance whose turn it is; `None` when it is too far away.
    fn placed(&mut self, turn: Turn) -> Outcome<Option<Placed<'a>>> {
        let placed = Placed::new(self.blob, turn.instance, self.camera, self.mode);
        if let Some(placed) = &placed {
            let quarters = placed.camera.in_quarters();
            let quarters = quarters.filter(|_| self.mode.frame == FrameMode::Quarters);
            let seen = quarters.as_ref().unwrap_or(&placed.camera);
            self.tables
                .prepare(seen, &placed.grid, placed.mode.cell_size)
                .map_err(|e| Failure::input(e.to_string()))?;
            if let Some((tables, map)) = &mut self.shadows {
                let (instance, grid, size) = (&placed.instance, &placed.grid, map.size());
                if self.mode.shadows == ShadowMode::OnePass {
                    tables.see_in_order(instance, grid, size, self.mode.light_splat);
                } else {
                    tables.see(instance, grid, size);
                }
            }
        }
        Ok(placed)
    }

    /// Draws all instances into a frame of tones, which is filled, or a band of quarters with these
    /// rows; returns the pixels that they may reach.
    fn tones(
        &mut self,
        turns: &[Turn],
        towards: [Unit; 3],
        tones: &mut SceneTones,
        frame: &mut Tones<'_>,
        rows: Option<&Range<u16>>,
    ) -> Outcome<Option<Rect>> {
        let (mut reach, mut all): (Option<Rect>, Option<Rect>) = (None, None);
        for turn in turns {
            let Some(placed) = self.placed(*turn)? else {
                continue;
            };
            if let Some(rows) = rows {
                self.tables.see_rows(rows.clone());
            }
            tones.shade(self.blob, &placed, towards);
            let drawn = self.draw(*turn, &placed, &*tones, frame);
            reach = Rect::of_both(reach, drawn);
            all = Rect::of_both(all, drawn);
            if turn.is_last
                && let Some(reach) = reach.take().filter(|_| rows.is_none())
            {
                frame.fill(reach);
            }
        }
        Ok(all)
    }

    /// Of the depths of quarters, those of pixels: of the first quarter that has one.
    fn gather(&mut self, width: usize) {
        self.depth = self
            .depth
            .chunks_exact(4 * width)
            .flat_map(|two| {
                let (upper, lower) = two.split_at(2 * width);
                upper.as_chunks().0.iter().zip(lower.as_chunks().0)
            })
            .map(|(&[a, b], &[c, d]): (&[f32; 2], &[f32; 2])| {
                let mut covered = [a, b, c, d].into_iter().filter(|depth| depth.is_finite());
                covered.next().unwrap_or(f32::NAN)
            })
            .collect();
    }

    /// Draws an instance in its turn, with its shadows; returns the pixels that it may reach.
    fn draw(
        &mut self,
        turn: Turn,
        placed: &Placed<'_>,
        shading: &impl Shade,
        target: &mut (impl Visibility + Canvas),
    ) -> Option<Rect> {
        let Some((tables, map)) = self.shadows.take() else {
            return self.draw_lit(turn, placed, shading, target);
        };
        let reach = self.draw_lit(turn, placed, &tables.over(shading, &map), target);
        self.shadows = Some((tables, map));
        reach
    }

    fn draw_lit(
        &mut self,
        turn: Turn,
        placed: &Placed<'_>,
        shading: &impl Shade,
        target: &mut (impl Visibility + Canvas),
    ) -> Option<Rect> {
        if turn.is_tangled && self.unit.is_some() {
            if turn.is_first {
                target.depths(&mut self.buffer);
            }
            return self.draw_deep::<_, true>(placed, shading, target);
        }
        let mut target = Recorder::new(target, &mut self.depth, placed, &self.tables);
        render::draw_divided(
            placed.mode.footprint,
            &placed.grid,
            &self.tables,
            shading,
            &mut target,
        )
    }

    /// Draws an instance against depths.
    fn draw_deep<C: Canvas, const IN_ORDER: bool>(
        &mut self,
        placed: &Placed<'_>,
        shading: &impl Shade,
        target: &mut C,
    ) -> Option<Rect> {
        let mut z = ZBuffer::<_, IN_ORDER>::new(target, &mut self.buffer)?;
        if let Some(unit) = self.unit {
            z = z.scaled(placed.depth_factor(&self.tables, unit));
        }
        let mut target = Recorder::new(&mut z, &mut self.depth, placed, &self.tables);
        render::draw_divided(
            placed.mode.footprint,
            &placed.grid,
            &self.tables,
            shading,
            &mut target,
        )
    }
}

/// A visibility method that also remembers the depth of what it shows.
struct Recorder<'a, V> {
    inner: &'a mut V,
    depth: &'a mut [f32],
    width: u32,
    /// Sides of the scene's cube a step of w.
    unit: f64,
}

impl<'a, V: Visibility> Recorder<'a, V> {
    fn new(
        inner: &'a mut V,
        depth: &'a mut [f32],
        placed: &Placed<'_>,
        tables: &render::View,
    ) -> Self {
        let side = placed.instance.scale.to_num::<f64>();
        Self {
            inner,
            depth,
            width: tables.width(),
            unit: side * (-f64::from(tables.w_bits())).exp2(),
        }
    }
}

impl<V: Visibility> Visibility for Recorder<'_, V> {
    const FRONT_TO_BACK: bool = V::FRONT_TO_BACK;

    fn is_hidden(&self, rect: Rect) -> bool {
        self.inner.is_hidden(rect)
    }

    fn is_behind(&self, rect: Rect, nearest: i32) -> bool {
        self.inner.is_behind(rect, nearest)
    }

    fn is_open(&self, x: u32, y: u32) -> bool {
        self.inner.is_open(x, y)
    }

    fn holds(&self, x: i32, y: i32) -> bool {
        self.inner.holds(x, y)
    }

    fn shows(&self, x: u32, y: u32, w: i32) -> bool {
        self.inner.shows(x, y, w)
    }

    fn draw(&mut self, rect: Rect, w: i32, colour: impl FnOnce() -> u16) {
        let mut colour = Some(colour);
        let mut found = 0;
        for y in rect.y0..=rect.y1 {
            for x in rect.x0..=rect.x1 {
                let pixel = Rect {
                    x0: x,
                    x1: x,
                    y0: y,
                    y1: y,
                };
                let mut shown = false;
                self.inner.draw(pixel, w, || {
                    if let Some(colour) = colour.take() {
                        found = colour();
                    }
                    shown = true;
                    found
                });
                if shown {
                    let depth = f64::from(w.max(1)) * self.unit;
                    self.depth[(y * self.width + x) as usize] = depth as f32;
                }
            }
        }
    }
}
