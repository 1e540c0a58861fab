//! What a mode keeps in memory, by the types that a board's program would have as statics.

use std::mem::size_of;

use rho_grid::blob::format::MAX_MATERIALS;
use rho_grid::mode::MapSize;
use rho_grid::render::shadow::Shadows;
use rho_grid::render::{EyeOrder, View, quarter_words, tone_words};
use rho_grid::scene::{Arrangement, SceneTones};
use rho_grid::shading::Shading;
use rho_viewer::size::{HEIGHT, PIXELS, WIDTH};
use rho_viewer::strips::STRIP;

use super::table;
use crate::text::thousands;

/// What a mode keeps, in bytes.
struct Kept {
    mode: &'static str,
    frame: usize,
    /// Coverage or depths, beside the frame.
    seen: usize,
    /// Colours or tones by normal and material.
    shades: usize,
    /// Texels a side, or 0.
    map: usize,
}

/// Where the camera and all instances are.
const PLACES: usize = size_of::<View>() + size_of::<Arrangement>();
/// RGB565.
const FRAME: usize = 2 * PIXELS;
/// A byte a pixel; sent in strips of words.
const TONES: usize = 4 * tone_words(WIDTH as usize, HEIGHT) + WORDS_OF_STRIP;
const QUARTERS: usize = 4 * quarter_words(2 * WIDTH as usize) + WORDS_OF_STRIP;
const WORDS_OF_STRIP: usize = 2 * STRIP as usize * WIDTH as usize;
const DEPTHS: usize = 2 * PIXELS;

impl Kept {
    const fn words(mode: &'static str, seen: usize, map: usize) -> Self {
        Self {
            mode,
            frame: FRAME,
            seen,
            shades: 2 * Shading::words(MAX_MATERIALS),
            map,
        }
    }

    const fn tones(mode: &'static str, frame: usize, seen: usize, map: usize) -> Self {
        Self {
            mode,
            frame,
            seen,
            shades: size_of::<SceneTones>(),
            map,
        }
    }

    fn row(&self) -> Vec<String> {
        let size = MapSize::of(self.map as u16);
        // A texel has two bytes; a row and a texel more take what a splat has beyond the last.
        let (map, light) = size.map_or((0, 0), |size| (2 * size.words(), size_of::<Shadows>()));
        let parts = [self.frame, self.seen, PLACES, self.shades, light, map];
        let all: usize = parts.iter().sum();
        let numbers = parts.into_iter().chain([all]);
        std::iter::once(self.mode.to_owned())
            .chain(numbers.map(|bytes| thousands(bytes as u64)))
            .collect()
    }
}

/// Bytes by mode, for a panel of 240 x 320.
#[must_use]
pub fn modes() -> String {
    let coverage = 4 * EyeOrder::words(WIDTH, HEIGHT);
    let rows = [
        Kept::words("words, eye order", coverage, 0),
        Kept::words("words, depths", DEPTHS, 0),
        Kept::words("words, eye order, tangled objects", coverage + DEPTHS, 0),
        Kept::words("words, depths, one pass", DEPTHS, 128),
        Kept::tones("tones: `fast`, `balanced`, `fine`", TONES, 0, 0),
        Kept::tones("tones, tangled objects", TONES, DEPTHS, 0),
        Kept::tones("tones, two passes, map of 64", TONES, 0, 64),
        Kept::tones("tones, two passes, map of 128", TONES, 0, 128),
        Kept::tones("tones, two passes, map of 256", TONES, 0, 256),
        Kept::tones("quarters: `finest`", QUARTERS, 0, 0),
        Kept::tones("quarters, two passes, map of 128", QUARTERS, 0, 128),
    ]
    .map(|kept| kept.row());
    table(
        &[
            "mode",
            "frame",
            "coverage or depths",
            "camera, order",
            "shades",
            "light",
            "shadow map",
            "in all",
        ],
        &rows,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mode_with_shadows_keeps_a_map_more() {
        let sum =
            |row: &[String]| -> usize { row.last().unwrap().replace(',', "").parse().unwrap() };
        let plain = Kept::tones("", TONES, 0, 0).row();
        let shadowed = Kept::tones("", TONES, 0, 128).row();
        assert!(sum(&shadowed) >= sum(&plain) + 2 * 128 * 128);
        // The STM32F429's 192 and 64 kB, with 20 kB of stack.
        assert!(sum(&shadowed) < 236 << 10);
    }
}
