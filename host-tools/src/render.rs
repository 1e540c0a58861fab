//! A frame computed on the PC by the device's own renderer.

use fixed::traits::ToFixed;
use glam::DVec3;
use rho_grid::blob::{Blob, Grid};
use rho_grid::camera::Camera;
use rho_grid::frame::Frame;
use rho_grid::mode::{FrameMode, Mode, VisibilityMode};
use rho_grid::q::Unit;
use rho_grid::render::{
    self, Blend, EyeOrder, Rect, Tones, Visibility, ZBuffer, bands, quarter_words, tone_words,
};
use rho_grid::shading::{Palette, Shading, ToneTable};

use crate::failure::{Failure, Outcome};
use crate::picture::Picture;
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
    /// How much of each pixel is covered, 0 to 255, where quarters of pixels tell.
    pub coverage: Option<Vec<u8>>,
}

impl Drawn {
    /// Pixels that differ from the background.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.words.iter().filter(|w| **w != BACKGROUND).count()
    }

    /// The frame as a picture, with its coverage.
    #[must_use]
    pub fn picture(&self) -> Picture {
        Picture {
            coverage: self.coverage.clone(),
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
    if mode.frame == FrameMode::Quarters {
        return in_quarters(blob, &grid, &camera, towards, mode);
    }
    let mut tables = Box::new(render::View::empty());
    let mut colours = vec![0; Shading::words(blob.materials().len())];
    let internal = |what: &str| Failure::input(format!("{what} (an error in rho)"));
    tables
        .prepare(&camera, &grid, mode.cell_size)
        .map_err(|e| Failure::input(e.to_string()))?;
    let mut w = vec![0; pixels];
    if mode.frame == FrameMode::Tones {
        let mut table = ToneTable::empty();
        table.shade(grid.layout(), blob.materials().len(), light(towards));
        let mut buffer = vec![0; tone_words(WIDEST, height)];
        let inner = Tones::<WIDEST, { 3 * WIDEST + 4 }>::cleared(&mut buffer, width, height)
            .ok_or_else(|| internal("frame size"))?;
        let mut target = Recorder::new(inner, &mut w, width);
        let reach = render::draw_seen(mode, &grid, &tables, &table, &mut target);
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
    let mut frame = Frame::new(&mut words, width, height).ok_or_else(|| internal("frame size"))?;
    match mode.visibility {
        VisibilityMode::Eye => {
            let mut bits = vec![0; EyeOrder::words(width, height)];
            let inner = EyeOrder::new(&mut frame, &mut bits).ok_or_else(|| internal("coverage"))?;
            let mut target = Recorder::new(inner, &mut w, width);
            render::draw_seen(mode, &grid, &tables, &shading, &mut target);
        }
        VisibilityMode::Z => {
            let mut buffer = vec![u16::MAX; pixels];
            let inner = ZBuffer::new(&mut frame, &mut buffer).ok_or_else(|| internal("depths"))?;
            let mut target = Recorder::new(inner, &mut w, width);
            render::draw_seen(mode, &grid, &tables, &shading, &mut target);
        }
    }
    Ok(drawn(&tables, (width, height), words, w))
}

/// Draws `blob` in quarters of pixels.
fn in_quarters(
    blob: &Blob<'_>,
    grid: &Grid<'_>,
    camera: &Camera,
    towards: DVec3,
    mode: Mode,
) -> Outcome<Drawn> {
    let (width, height) = (camera.width, camera.height);
    let quarters = camera.in_quarters().ok_or_else(|| {
        Failure::input(format!(
            "a picture in quarters is at most {0} x {0} pixels large",
            Camera::MAX_QUARTERED
        ))
        .help("give a smaller --size, or --frame tones")
    })?;
    let mut tables = Box::new(render::View::empty());
    tables
        .prepare(&quarters, grid, mode.cell_size)
        .map_err(|e| Failure::input(e.to_string()))?;
    let mut table = ToneTable::empty();
    table.shade(grid.layout(), blob.materials().len(), light(towards));
    let blend = Blend::new(&Palette::new(blob.materials(), BACKGROUND));
    let row = usize::from(width);
    let mut words = vec![BACKGROUND; row * usize::from(height)];
    let mut w = vec![0; 4 * words.len()];
    let mut buffer = vec![0; quarter_words(WIDEST)];
    for rows in bands(height) {
        let first = usize::from(rows.start / 2) * row;
        tables.see_rows(rows.clone());
        let band = Tones::<WIDEST, { 3 * WIDEST + 4 }>::band(&mut buffer, 2 * width, rows);
        let band = band.ok_or_else(|| Failure::input("frame size (an error in rho)"))?;
        let mut target = Recorder::new(band, &mut w, 2 * width);
        render::draw_seen(mode, grid, &tables, &table, &mut target);
        blend.rows(&target.inner, &mut words[first..], width);
    }
    let pixels = w.chunks_exact(4 * row).flat_map(|two| {
        let (upper, lower) = two.split_at(2 * row);
        let pairs = upper
            .as_chunks::<2>()
            .0
            .iter()
            .zip(lower.as_chunks::<2>().0);
        pairs.map(|(&[a, b], &[c, d])| [a, b, c, d])
    });
    let covered = |quarters: [i32; 4]| quarters.into_iter().filter(|w| *w != 0);
    let coverage = pixels
        .clone()
        .map(|quarters| (covered(quarters).count() * 255).div_ceil(4) as u8);
    // A pixel's depth is that of its first quarter that has one.
    let w = pixels.map(|quarters| covered(quarters).next().unwrap_or(0));
    let (coverage, w) = (coverage.collect(), w.collect());
    Ok(Drawn {
        coverage: Some(coverage),
        ..drawn(&tables, (width, height), words, w)
    })
}

/// The picture of a frame that a device has drawn in this mode. A wire carries no coverage: where
/// quarters of pixels tell it, it is that of the same frame drawn here.
///
/// # Errors
/// As [`render`].
pub fn picture(
    drawn: (u16, u16, &[u16]),
    blob: &Blob<'_>,
    view: &View,
    towards: DVec3,
    mode: Mode,
) -> Outcome<Picture> {
    let (width, height, words) = drawn;
    if mode.frame == FrameMode::Quarters {
        let ours = render(blob, view, towards, mode)?;
        if ours.words == words {
            return Ok(ours.picture());
        }
    }
    Ok(Picture::from_rgb565(width.into(), height.into(), words))
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
        coverage: None,
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

    fn holds(&self, x: i32, y: i32) -> bool {
        self.inner.holds(x, y)
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
