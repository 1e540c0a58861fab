//! Four quarters a pixel: drawn twice as wide and high, in bands, and blended.
//!
//! A silhouette that covers a quarter of a pixel shows as a quarter of its colour, and what is
//! smaller than a pixel is averaged and not chosen: far away this looks better than one exact ray
//! a pixel. The quarters of a whole frame would take four times its memory, so they are drawn in
//! bands of [`ROWS`] rows, one after the other into the same buffer:
//!
//! ```text
//! prepare the view for Camera::in_quarters, once
//! for each band: clear it; View::see_rows; draw; Blend::rows into the frame
//! ```
//!
//! A cell at a border is visited in both bands, a sample drawn where its window touches one.

use core::ops::Range;

use super::tones::{Tones, tone_words};
use crate::camera::Camera;
use crate::shading::{Addend, Palette};

/// Rows of quarters in a band, twice those of pixels.
const ROWS: u16 = 80;

/// Words that a band needs whose rows are `stride` bytes long.
#[must_use]
pub const fn quarter_words(stride: usize) -> usize {
    tone_words(stride, ROWS)
}

/// The rows of quarters of each band of a frame of `height` pixels, from the top.
pub fn bands(height: u16) -> impl Iterator<Item = Range<u16>> {
    let end = height.saturating_mul(2);
    let first = (0..end).step_by(ROWS.into());
    first.map(move |first| first..end.min(first.saturating_add(ROWS)))
}

impl Camera {
    /// The widest and the highest picture that can be drawn in quarters.
    pub const MAX_QUARTERED: u16 = Self::MAX_SIDE / 2;

    /// The same picture in quarters of pixels: twice as wide and as high. `None` when it is larger
    /// than [`Self::MAX_QUARTERED`], or its focal length is 2^19 pixels or more.
    #[must_use]
    pub fn in_quarters(&self) -> Option<Self> {
        let fits = self.width.max(self.height) <= Self::MAX_QUARTERED;
        let focal = self.focal.checked_add(self.focal)?;
        fits.then_some(Self {
            focal,
            width: 2 * self.width,
            height: 2 * self.height,
            ..*self
        })
    }
}

/// The colours of quarters, ready to be added: 256 by tone.
#[derive(Clone, Debug)]
pub struct Blend([Addend; 256]);

impl Blend {
    /// Of the tones of `palette`; open quarters have its background.
    #[must_use]
    pub fn new(palette: &Palette) -> Self {
        Self(core::array::from_fn(|tone| palette.addend(tone as u8)))
    }

    /// The pixels of a band, RGB565, into `words`, the frame from the band's first row on: `width`
    /// a row, half of the band's. Each is the mean of its four quarters.
    pub fn rows<const STRIDE: usize, const SPAN: usize>(
        &self,
        band: &Tones<'_, STRIDE, SPAN>,
        words: &mut [u16],
        width: u16,
    ) {
        let mut rows = band.rows();
        for words in words.chunks_exact_mut(usize::from(width).max(1)) {
            let (Some(upper), Some(lower)) = (rows.next(), rows.next()) else {
                return;
            };
            self.row(upper, lower, words);
        }
    }

    /// A row of pixels.
    #[inline(never)]
    fn row(&self, upper: &[u8], lower: &[u8], words: &mut [u16]) {
        let (upper, _) = upper.as_chunks::<4>();
        let (lower, _) = lower.as_chunks::<4>();
        let (pairs, _) = words.as_chunks_mut::<2>();
        let background = Addend::mean([self.of(0); 4]);
        for ((upper, lower), words) in upper.iter().zip(lower).zip(pairs) {
            let (a, b) = (u32::from_le_bytes(*upper), u32::from_le_bytes(*lower));
            if a | b == 0 {
                *words = [background; 2];
                continue;
            }
            let pair = |shift: u32| {
                let at = |word: u32, byte: u32| self.of((word >> byte) & 255);
                let upper = [at(a, shift), at(a, shift + 8)];
                let lower = [at(b, shift), at(b, shift + 8)];
                Addend::mean([upper[0], upper[1], lower[0], lower[1]])
            };
            *words = [pair(0), pair(16)];
        }
    }

    #[inline(always)]
    fn of(&self, tone: u32) -> Addend {
        let Self(colours) = self;
        colours
            .get(tone as usize & 255)
            .copied()
            .unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bands_of_a_frame_have_all_its_rows_once() {
        for height in [1, 39, 40, 41, 320, Camera::MAX_QUARTERED] {
            let mut next = 0;
            for band in bands(height) {
                assert_eq!(band.start, next);
                assert!(band.len() <= usize::from(ROWS) && band.len() % 2 == 0);
                next = band.end;
            }
            assert_eq!(next, 2 * height);
        }
    }
}
