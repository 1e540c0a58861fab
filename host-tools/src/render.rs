//! A frame computed on the PC by the device's own renderer.

use fixed::traits::ToFixed;
use glam::DVec3;
use rho_grid::blob::{Blob, Grid};
use rho_grid::camera::Camera;
use rho_grid::frame::Frame;
use rho_grid::mode::{FrameMode, Mode, ShadowMode, VisibilityMode};
use rho_grid::q::Unit;
use rho_grid::render::shadow::Shadows;
use rho_grid::render::{self, EyeOrder, Rect, Tones, Visibility, ZBuffer, tone_words};
use rho_grid::shading::{Palette, Shade, Shading, ToneTable};

use crate::failure::{Failure, Outcome};
use crate::view::View;

/// Pixels a row of the widest picture.
const WIDEST: usize = Camera::MAX_SIDE as usize;

/// Black; the standard scene's background.
pub const BACKGROUND: u16 = 0;

/// A frame and what is known of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// Pixels a row.
    pub width: u16,
    /// Rows.
    pub height: u16,
    /// RGB565 words, rows from the top.
    pub words: Vec<u16>,
    /// A pixel's distance along the optical axis in cube units, NaN where nothing is drawn.
    pub depth: Vec<f32>,
}

impl Drawn {
    /// Pixels that differ from the background.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.words.iter().filter(|w| **w != BACKGROUND).count()
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

/// Draws `blob`.
///
/// # Errors
/// When the view is out of range, or the blob has no such grid.
pub fn render(blob: &Blob<'_>, view: &View, towards: DVec3, mode: Mode) -> Outcome<Drawn> {
    let grid = blob.grid(mode.grid).ok_or_else(|| {
        let count = blob.grid_count();
        Failure::input(format!(
            "there is no grid {} in a blob of {count}",
            mode.grid
        ))
        .help(format!("give --grid 0 to {}", count - 1))
    })?;
    let camera = view.camera()?;
    let (width, height) = (camera.width, camera.height);
    let pixels = usize::from(width) * usize::from(height);
    let mut words = vec![BACKGROUND; pixels];
    let mut tables = Box::new(render::View::empty());
    let mut colours = vec![0; Shading::words(blob.materials().len())];
    tables
        .prepare(&camera, &grid, mode.cell_size)
        .map_err(|e| Failure::input(e.to_string()))?;
    let mut shadows = Box::new(Shadows::empty());
    let mut texels = vec![0; mode.shadow_map.words()];
    let map = match mode.shadows {
        ShadowMode::None => None,
        ShadowMode::TwoPass | ShadowMode::Kept => {
            let how = (mode.shadow_map, mode.light_splat);
            let map = shadows.cast(blob, &grid, light(towards), how, &mut texels);
            Some(map.ok_or_else(|| internal("shadow map"))?)
        }
    };
    let mut w = vec![0; pixels];
    if mode.frame == FrameMode::Tones {
        let mut table = ToneTable::empty();
        table.shade(grid.layout(), blob.materials().len(), light(towards));
        let mut buffer = vec![0; tone_words(WIDEST, height)];
        let inner = Tones::<WIDEST, { 3 * WIDEST + 4 }>::cleared(&mut buffer, width, height)
            .ok_or_else(|| internal("frame size"))?;
        let mut target = Recorder::new(inner, &mut w, width);
        let reach = match &map {
            None => render::draw_seen(mode, &grid, &tables, &table, &mut target),
            Some(map) => {
                let shade = shadows.over(&table, map);
                render::draw_seen(mode, &grid, &tables, &shade, &mut target)
            }
        };
        if let Some(reach) = reach {
            target.inner.fill(reach);
        }
        let palette = Palette::new(blob.materials(), BACKGROUND);
        let tones = target.inner.rows().flatten();
        words = tones.map(|tone| palette.colour(*tone)).collect();
        return Ok(drawn(&tables, (width, height), words, w));
    }
    let shading = Shading::new(
        &mut colours,
        grid.layout(),
        blob.materials(),
        light(towards),
    )
    .ok_or_else(|| internal("shading table"))?;
    match &map {
        None => draw_words(
            mode,
            &grid,
            &tables,
            &shading,
            &mut words,
            (&mut w, width, height),
        )?,
        Some(map) => {
            let shade = shadows.over(&shading, map);
            draw_words(
                mode,
                &grid,
                &tables,
                &shade,
                &mut words,
                (&mut w, width, height),
            )?;
        }
    }
    Ok(drawn(&tables, (width, height), words, w))
}

/// Into a frame of RGB565 words, by a visibility method that fits it.
fn draw_words(
    mode: Mode,
    grid: &Grid<'_>,
    tables: &render::View,
    shade: &impl Shade,
    words: &mut [u16],
    (w, width, height): (&mut [i32], u16, u16),
) -> Outcome {
    let mut frame = Frame::new(words, width, height).ok_or_else(|| internal("frame size"))?;
    match mode.visibility {
        VisibilityMode::Eye => {
            let mut bits = vec![0; EyeOrder::words(width, height)];
            let inner = EyeOrder::new(&mut frame, &mut bits).ok_or_else(|| internal("coverage"))?;
            let mut target = Recorder::new(inner, w, width);
            render::draw_seen(mode, grid, tables, shade, &mut target);
        }
        VisibilityMode::Z => {
            let mut buffer = vec![u16::MAX; w.len()];
            let inner = ZBuffer::new(&mut frame, &mut buffer).ok_or_else(|| internal("depths"))?;
            let mut target = Recorder::new(inner, w, width);
            render::draw_seen(mode, grid, tables, shade, &mut target);
        }
    }
    Ok(())
}

/// What a caller's numbers cannot bring about.
fn internal(what: &str) -> Failure {
    Failure::input(format!("{what} (an error in rho)"))
}

fn drawn(
    tables: &render::View,
    (width, height): (u16, u16),
    words: Vec<u16>,
    w: Vec<i32>,
) -> Drawn {
    let unit = (-f64::from(tables.w_bits())).exp2();
    let depth = w
        .into_iter()
        .map(|w| match w {
            0 => f32::NAN,
            w => (f64::from(w) * unit) as f32,
        })
        .collect();
    Drawn {
        width,
        height,
        words,
        depth,
    }
}

/// A visibility method that also remembers the w of what it shows.
struct Recorder<'a, V> {
    inner: V,
    w: &'a mut [i32],
    width: u32,
}

impl<'a, V> Recorder<'a, V> {
    fn new(inner: V, w: &'a mut [i32], width: u16) -> Self {
        Self {
            inner,
            w,
            width: u32::from(width),
        }
    }
}

impl<V: Visibility> Visibility for Recorder<'_, V> {
    const FRONT_TO_BACK: bool = V::FRONT_TO_BACK;

    fn is_hidden(&self, rect: Rect) -> bool {
        self.inner.is_hidden(rect)
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
                    self.w[(y * self.width + x) as usize] = w.max(1);
                }
            }
        }
    }
}
