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

use super::tones::{COVERED, Tones, tone_words};
use super::visibility::{Canvas, Rect};
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
    /// a row, half of the band's. Each is the mean of its four quarters, of those that
    /// [`Tones::quarters`] counts as covered. Nothing is drawn beyond `reach`, in quarters of the frame.
    pub fn rows(&self, band: &Tones<'_>, words: &mut [u16], width: u16, reach: Option<Rect>) {
        let background = Addend::mean([self.of(0); 4]);
        let columns = reach.map_or(0..0, |r| r.x0 as usize / 4..r.x1 as usize / 4 + 1);
        let reached = reach.map_or(0..0, |r| r.y0 / 2..r.y1 / 2 + 1);
        let rows = words.chunks_exact_mut(usize::from(width).max(1));
        for (y, words) in (0..).zip(rows) {
            let (Some(upper), Some(lower)) = (band.row(2 * y), band.row(2 * y + 1)) else {
                return;
            };
            if !reached.contains(&(band.first_row() / 2 + y as u32)) {
                words.fill(background);
                continue;
            }
            self.row(upper, lower, words, columns.clone(), |x| {
                band.quarters(x, y) == 4
            });
        }
    }

    /// A row of pixels, of which only these pairs are not open. `is_gap` tells whether a pixel that is
    /// covered in part counts as whole.
    #[inline(never)]
    fn row(
        &self,
        upper: &[u8],
        lower: &[u8],
        words: &mut [u16],
        columns: Range<usize>,
        is_gap: impl Fn(i32) -> bool,
    ) {
        let (upper, lower) = (upper.as_chunks().0, lower.as_chunks().0);
        let (pairs, rest) = words.as_chunks_mut::<2>();
        let part =
            |n: usize, quarters| self.pair_in_part(quarters, |right| is_gap(2 * n as i32 + right));
        if let ([word], Some(upper), Some(lower)) =
            (rest, upper.get(pairs.len()), lower.get(pairs.len()))
        {
            [*word, _] = part(pairs.len(), [*upper, *lower].map(u32::from_le_bytes));
        }
        pairs.fill([Addend::mean([self.of(0); 4]); 2]);
        let end = columns.end.min(pairs.len());
        let first = columns.start.min(end);
        let reached = pairs.get_mut(first..end).unwrap_or_default();
        let [upper, lower] = [upper, lower].map(|row| row.get(first..end).unwrap_or_default());
        let reached = reached.iter_mut().zip(upper).zip(lower);
        for (n, ((pair, upper), lower)) in (first..).zip(reached) {
            let (a, b) = (u32::from_le_bytes(*upper), u32::from_le_bytes(*lower));
            if a | b == 0 {
                continue;
            }
            *pair = if a & b & COVERED == COVERED {
                [self.pixel(a, b), self.pixel(a >> 16, b >> 16)]
            } else {
                part(n, [a, b])
            };
        }
    }

    /// The mean of the two quarters in the lower halves of `upper` and `lower`.
    #[inline(always)]
    fn pixel(&self, upper: u32, lower: u32) -> u16 {
        let at = |word: u32| self.of(word & 255);
        Addend::mean([at(upper), at(upper >> 8), at(lower), at(lower >> 8)])
    }

    /// Two pixels of which some quarters are open. In a gap they have the first tone of their own, or of the other's.
    #[inline(never)]
    fn pair_in_part(&self, [a, b]: [u32; 2], is_gap: impl Fn(i32) -> bool) -> [u16; 2] {
        let tones = |right: u32| {
            let (upper, lower) = (a >> (16 * right), b >> (16 * right));
            [upper, upper >> 8, lower, lower >> 8].map(|tone| tone & 255)
        };
        let first = |tones: [u32; 4]| tones.into_iter().find(|tone| tone & 1 == 1);
        [0, 1].map(|right| {
            let own = tones(right);
            let is_open = own.iter().any(|tone| tone & 1 == 0);
            let open = match first(own).or_else(|| first(tones(1 - right))) {
                Some(tone) if is_open && is_gap(right as i32) => tone,
                _ => 0,
            };
            Addend::mean(own.map(|tone| self.of(if tone & 1 == 1 { tone } else { open })))
        })
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
