//! A frame of a byte a pixel, which knows what is covered.
//!
//! A tone is a number of the palette, doubled, plus one; an open pixel is 0. So the lowest bit tells
//! what is covered, four pixels are looked at and written as one word, and a frame needs half the
//! memory of RGB565 words and no coverage beside it:
//!
//! ```text
//! new = mask and not old       four pixels: 1 in each byte that the sample opens
//! old + new * tone             the product puts the tone into each of them
//! ```
//!
//! Rows follow each other without gaps. A window of four pixels may stick out of the frame by pixels
//! that its mask does not name: it then reads and writes back bytes of the rows beside it, or of the
//! margins before and after the frame.

#[cfg(rho_thumb)]
use super::visibility::Bytes;
use super::visibility::{Canvas, Rect, Shape, Stamp, Visibility};

/// The lowest bit of each of four pixels.
pub(super) const COVERED: u32 = 0x0101_0101;

/// A frame of tones.
#[derive(Debug)]
pub struct Tones<'a> {
    pixels: &'a mut [u8],
    /// Bytes from row to row: a multiple of 4, so that four pixels which are filled together lie in one row.
    stride: usize,
    width: u16,
    /// The frame's row that is the first here.
    first: i32,
    height: u16,
}

/// Bytes before the first pixel, and as many after the last: a window of four rows may begin two
/// pixels before the frame, or end three after it. So many are from a window's first pixel to beyond its last.
pub(super) const fn margin(stride: usize) -> usize {
    3 * stride + 4
}

/// Words that a frame of `height` rows needs.
#[must_use]
pub const fn tone_words(stride: usize, height: u16) -> usize {
    (2 * margin(stride) + stride * height as usize).div_ceil(4)
}

impl<'a> Tones<'a> {
    /// A frame in a buffer of [`tone_words`] words, cleared, `stride` bytes from row to row; `None` when the picture
    /// is wider than that, the buffer too short, or the stride no multiple of 4.
    #[must_use]
    pub fn cleared(buffer: &'a mut [u32], stride: usize, width: u16, height: u16) -> Option<Self> {
        let most = usize::from(u16::MAX);
        if stride == 0 || stride > most || !stride.is_multiple_of(4) || usize::from(width) > stride
        {
            return None;
        }
        let buffer = buffer.get_mut(..tone_words(stride, height))?;
        #[cfg(rho_thumb)]
        super::stamp::clear(buffer);
        #[cfg(not(rho_thumb))]
        buffer.fill(0);
        Some(Self {
            pixels: bytemuck::cast_slice_mut(buffer),
            stride,
            width,
            first: 0,
            height,
        })
    }

    /// The same for these rows of a frame alone: samples are drawn where a part of their window of
    /// four rows is among them.
    #[must_use]
    pub fn band(
        buffer: &'a mut [u32],
        stride: usize,
        width: u16,
        rows: core::ops::Range<u16>,
    ) -> Option<Self> {
        let first = i32::from(rows.start);
        let band = Self::cleared(buffer, stride, width, rows.len() as u16)?;
        Some(Self { first, ..band })
    }

    /// Covers each open pixel that has three or four covered neighbours with the tone of the one
    /// to its left, or else to its right: what no disc reached between discs that hardly touch.
    ///
    /// Row by row from the top, so that a pixel just covered counts for the next one, and those to its
    /// left and above it are looked at again. Pixels at the frame's edge are left, and so are four open
    /// ones together, the first a multiple of four, unless the one before them is covered.
    pub fn fill(&mut self, rect: Rect) {
        let y0 = (rect.y0 as i32).max(self.first + 1);
        let y1 = (rect.y1 as i32).min(self.first + i32::from(self.height) - 2);
        if y0 > y1 {
            return;
        }
        let end = self.at(0, y1 + 1);
        let start = self.at(0, y0);
        let mut at = start;
        loop {
            at = self.next_to_fill(at, end);
            if at >= end {
                return;
            }
            for pixel in at..at + 4 {
                if self.fill_one(pixel) {
                    let mut left = pixel - 1;
                    while self.fill_one(left) {
                        left -= 1;
                    }
                    if pixel >= start + self.stride {
                        self.fill_one(pixel - self.stride);
                    }
                }
            }
            at += 4;
        }
    }

    /// Of each four pixels from `from` on, the first of the next four in which one may be filled;
    /// `end` or more when there are none before that.
    fn next_to_fill(&self, from: usize, end: usize) -> usize {
        #[cfg(rho_thumb)]
        if self.stride == super::stamp::STRIDE {
            return super::stamp::next_to_fill(self.pixels, from, end);
        }
        let mut at = from;
        while at < end && !self.may_be_filled(at) {
            at += 4;
        }
        at
    }

    fn may_be_filled(&self, at: usize) -> bool {
        let covered = |from: usize| {
            let bytes = self.pixels.get(from..).and_then(|p| p.first_chunk());
            bytes.map_or(0, |bytes| word(*bytes)) & COVERED
        };
        let here = covered(at);
        let left = self.pixels.get(at - 1).is_some_and(|left| left & 1 == 1);
        if here == COVERED || here == 0 && !left {
            return false;
        }
        let beside = covered(at - 1) + covered(at + 1);
        let neighbours = beside + covered(at - self.stride) + covered(at + self.stride);
        // 3 and 4 have bit 2 when one more is counted.
        ((neighbours + COVERED) >> 2) & COVERED & !here != 0
    }

    /// Whether the pixel was open and is now covered.
    fn fill_one(&mut self, at: usize) -> bool {
        let pixel = |at: usize| self.pixels.get(at).copied().unwrap_or(0);
        if pixel(at) & 1 == 1 {
            return false;
        }
        let (left, right) = (pixel(at - 1), pixel(at + 1));
        let (above, below) = (pixel(at - self.stride), pixel(at + self.stride));
        if (left & 1) + (right & 1) + (above & 1) + (below & 1) < 3 {
            return false;
        }
        let x = (at - margin(self.stride)) % self.stride;
        let inside = x > 0 && x + 1 < usize::from(self.width);
        if let Some(pixel) = self.pixels.get_mut(at).filter(|_| inside) {
            *pixel = if left & 1 == 1 { left } else { right };
        }
        inside
    }

    /// The pixels, rows from the top.
    pub fn rows(&self) -> impl Iterator<Item = &[u8]> {
        let width = usize::from(self.width);
        let frame = self.pixels.get(margin(self.stride)..).unwrap_or_default();
        frame
            .chunks(self.stride)
            .take(self.height.into())
            .map(move |row| row.get(..width).unwrap_or_default())
    }

    /// Row `y` of those that are here, as long as rows are.
    pub(super) fn row(&self, y: i32) -> Option<&[u8]> {
        if y < 0 || y >= i32::from(self.height) {
            return None;
        }
        let at = margin(self.stride) + self.stride * y as usize;
        self.pixels.get(at..at + self.stride)
    }

    /// Of quarters: how many of those of pixel (x, y), from the first one here, are covered. All are in a gap
    /// between discs: where some are, some of each neighbour's and 11 of 16 of these together; or where 12 of 16 and
    /// 27 of 32 of all eight round it are. Beyond the frame and the band nothing says that it is none.
    #[must_use]
    pub fn quarters(&self, x: i32, y: i32) -> u32 {
        let [left, own, right] = self.three_in_quarters(x, y);
        let sum = left + right;
        if sum < 3 {
            return own;
        }
        let upper = self.three_in_quarters(x, y - 1);
        let sum = sum + upper[1];
        if sum < 7 {
            return own;
        }
        let lower = self.three_in_quarters(x, y + 1);
        let sum = sum + lower[1];
        let all = sum + upper[0] + upper[2] + lower[0] + lower[2];
        let beside = [left, right, upper[1], lower[1]];
        let is_gap = own > 0 && sum >= 11 && beside.iter().all(|covered| *covered > 0)
            || sum >= 12 && all >= 27;
        if is_gap { 4 } else { own }
    }

    /// Of quarters: how many are covered of those of pixel (x, y) and of its neighbours to the left and the right,
    /// which lies in the middle; four beyond the frame and the band.
    #[inline(always)]
    fn three_in_quarters(&self, x: i32, y: i32) -> [u32; 3] {
        if y < 0 || 2 * y + 1 >= i32::from(self.height) {
            return [4; 3];
        }
        let at = margin(self.stride) + self.stride * 2 * y as usize + 2 * x as usize;
        let six = |from: usize| self.pixels.get(from..from + 6)?.first_chunk::<6>().copied();
        if x > 0
            && 2 * x + 4 <= i32::from(self.width)
            && let (Some([a, b, c, d, rest @ ..]), Some([e, f, g, h, others @ ..])) =
                (six(at - 2), six(at - 2 + self.stride))
        {
            let sum = (word([a, b, c, d]) & COVERED) + (word([e, f, g, h]) & COVERED);
            let sum = sum + (sum >> 8);
            let [right, last] = [rest, others].map(|pair| u32::from(u16::from_le_bytes(pair)));
            let beyond = (right & 0x0101) + (last & 0x0101);
            return [sum & 7, sum >> 16 & 7, (beyond + (beyond >> 8)) & 7];
        }
        self.three_at_the_edge(x, y)
    }

    #[cold]
    fn three_at_the_edge(&self, x: i32, y: i32) -> [u32; 3] {
        let (Some(upper), Some(lower)) = (self.row(2 * y), self.row(2 * y + 1)) else {
            return [4; 3];
        };
        [x - 1, x, x + 1].map(|x| {
            if !(0..i32::from(self.width) / 2).contains(&x) {
                return 4;
            }
            let covered = |row: &[u8]| {
                let pair = row.get(2 * x as usize..).and_then(|row| row.first_chunk());
                pair.map_or(0, |[a, b]: &[u8; 2]| u32::from((a & 1) + (b & 1)))
            };
            covered(upper) + covered(lower)
        })
    }

    /// Covers what is open of `count` pixels from `at` on; a row's last few are followed by others, or by the margin.
    #[inline(always)]
    fn cover(&mut self, at: usize, count: usize, tone: u32) {
        let lay = |four: &mut [u8; 4], mask: u32| {
            let old = word(*four);
            *four = old
                .wrapping_add((!old & mask).wrapping_mul(tone))
                .to_le_bytes();
        };
        let Some(row) = self.pixels.get_mut(at..at + count.next_multiple_of(4)) else {
            return;
        };
        let (fours, _) = row.as_chunks_mut();
        let Some((last, fours)) = fours.split_last_mut() else {
            return;
        };
        for four in fours {
            lay(four, COVERED);
        }
        // One to four.
        lay(last, COVERED >> (8 * (count.wrapping_neg() & 3)));
    }

    #[inline(always)]
    fn is_open_at(&self, at: usize) -> bool {
        self.pixels.get(at).is_some_and(|pixel| pixel & 1 == 0)
    }

    #[inline(always)]
    fn at(&self, x: i32, y: i32) -> usize {
        ((y - self.first) * self.stride as i32 + x + margin(self.stride) as i32) as usize
    }
}

/// Four pixels.
#[inline(always)]
fn word(bytes: [u8; 4]) -> u32 {
    u32::from_le_bytes(bytes)
}

/// Two rows of a mask, four bits each, as the lowest bits of four bytes each.
pub(super) static SPREAD: [[u32; 2]; 256] = {
    let mut words = [[0; 2]; 256];
    let mut bits = 0;
    while bits < 256 {
        #[allow(
            clippy::indexing_slicing,
            reason = "evaluated by the compiler, where an index out of range is an error"
        )]
        {
            words[bits] = [row(bits as u32 & 15), row(bits as u32 >> 4)];
        }
        bits += 1;
    }
    words
};

const fn row(bits: u32) -> u32 {
    bits & 1 | (bits & 2) << 7 | (bits & 4) << 14 | (bits & 8) << 21
}

/// Row `row` of a mask.
#[inline(always)]
fn spread(mask: u32, row: usize) -> u32 {
    let pair = SPREAD.get((mask >> (8 * (row / 2))) as usize & 255);
    let [even, odd] = pair.copied().unwrap_or_default();
    if row.is_multiple_of(2) { even } else { odd }
}

impl Canvas for Tones<'_> {
    fn size(&self) -> (u16, u16) {
        (self.width, self.height)
    }

    fn first_row(&self) -> u32 {
        self.first as u32
    }

    #[cfg(rho_thumb)]
    #[inline(always)]
    fn bytes_beside_depths(&mut self) -> Option<&mut [u8]> {
        let as_wide = self.stride == super::stamp::STRIDE && usize::from(self.width) == self.stride;
        (as_wide && self.first == 0).then_some(&mut *self.pixels)
    }

    #[inline(always)]
    fn paint(&mut self, x: u32, y: u32, colour: u16) {
        let at = self.at(x as i32, y as i32);
        if let Some(pixel) = self.pixels.get_mut(at) {
            *pixel = colour as u8;
        }
    }

    fn depths(&self, depths: &mut [u16]) {
        #[cfg(rho_thumb)]
        super::stamp::set_ones(depths);
        #[cfg(not(rho_thumb))]
        depths.fill(u16::MAX);
        let depths = depths.chunks_exact_mut(usize::from(self.width).max(1));
        for (depths, row) in depths.zip(self.rows()) {
            let (eights, last) = row.as_chunks::<8>();
            for (depths, eight) in depths.chunks_exact_mut(8).zip(eights) {
                // Most are not covered.
                if u64::from_le_bytes(*eight) != 0 {
                    close(depths, eight);
                }
            }
            close(depths.get_mut(8 * eights.len()..).unwrap_or_default(), last);
        }
    }
}

/// Puts before all that comes what is covered: where the lowest bit is 1.
fn close(depths: &mut [u16], pixels: &[u8]) {
    for (depth, pixel) in depths.iter_mut().zip(pixels) {
        *depth = u16::from(pixel & 1).wrapping_sub(1);
    }
}

impl Visibility for Tones<'_> {
    const FRONT_TO_BACK: bool = true;

    /// The middle and the corners are asked first: of what shows, one of them is mostly open.
    #[inline(always)]
    fn is_hidden(&self, r: Rect) -> bool {
        let mut at = self.at(r.x0 as i32, r.y0 as i32);
        let (right, rows) = ((r.x1 - r.x0) as usize, (r.y1 - r.y0) as usize);
        let below = rows * self.stride;
        if self.is_open_at(at + rows / 2 * self.stride + right / 2)
            || self.is_open_at(at)
            || self.is_open_at(at + right)
            || self.is_open_at(at + below)
            || self.is_open_at(at + below + right)
        {
            return false;
        }
        let count = right + 1;
        #[cfg(rho_thumb)]
        if count >= 8 {
            return super::stamp::is_covered(self.pixels, self.stride, at, count, rows + 1);
        }
        for _ in 0..=rows {
            let row = self.pixels.get(at..at + count).unwrap_or_default();
            // Four pixels at a time; the last four may have been looked at before.
            let covered = match row.last_chunk() {
                Some(last) => row
                    .as_chunks()
                    .0
                    .iter()
                    .fold(word(*last), |all, four| all & word(*four)),
                None => row
                    .iter()
                    .fold(COVERED, |all, p| all & (u32::from(*p) * COVERED)),
            };
            if covered & COVERED != COVERED {
                return false;
            }
            at += self.stride;
        }
        true
    }

    #[inline(always)]
    fn is_open(&self, x: u32, y: u32) -> bool {
        self.is_open_at(self.at(x as i32, y as i32))
    }

    #[inline(always)]
    fn draw(&mut self, r: Rect, _w: i32, colour: impl FnOnce() -> u16) {
        if self.is_hidden(r) {
            return;
        }
        let tone = colour() as u8;
        let count = (r.x1 - r.x0 + 1) as usize;
        let mut at = self.at(r.x0 as i32, r.y0 as i32);
        for _ in r.y0..r.y1 + 1 {
            for pixel in self.pixels.get_mut(at..at + count).unwrap_or_default() {
                if *pixel & 1 == 0 {
                    *pixel = tone;
                }
            }
            at += self.stride;
        }
    }

    /// Covered four pixels at a time.
    fn draw_shape(&mut self, r: Rect, _w: i32, shape: &impl Shape, colour: impl Fn() -> u16) {
        let tone = u32::from(colour());
        let mut row = self.at(0, r.y0 as i32);
        for y in r.y0..r.y1 + 1 {
            let columns = shape.row(y).within(r.x0, r.x1);
            self.cover(row + columns.start as usize, columns.len(), tone);
            row += self.stride;
        }
    }

    #[cfg(rho_thumb)]
    fn bytes(&mut self) -> Option<Bytes<'_>> {
        const BAND: usize = 2 * super::stamp::STRIDE;
        let band = match self.stride {
            super::stamp::STRIDE => None,
            BAND => Some(self.first),
            _ => return None,
        };
        Some(Bytes {
            pixels: self.pixels,
            band,
            depths: None,
        })
    }

    #[inline(always)]
    fn corner(&self, x: i32, y: i32) -> u32 {
        self.at(x, y) as u32
    }

    /// A window of which a row is here, and all in the margins.
    #[inline(always)]
    fn holds(&self, x: i32, y: i32) -> bool {
        let from = self.pixels.get(self.at(x, y)..);
        from.is_some_and(|from| from.len() >= margin(self.stride))
    }

    #[inline(always)]
    fn stamp(&mut self, stamp: Stamp, mask: impl FnOnce() -> u32, colour: impl Fn() -> u16) {
        let from = stamp
            .corner
            .wrapping_add(stamp.y * self.stride as u32 + stamp.x) as usize;
        let stride = self.stride;
        let window = self.pixels.get_mut(from..from.wrapping_add(margin(stride)));
        let Some(window) = window else {
            return;
        };
        if stamp.away {
            let open = |row: usize| {
                let pixels = window.get(row * stride..).and_then(|row| row.first_chunk());
                spread(stamp.within, row) & !pixels.map_or(COVERED, |pixels| word(*pixels))
            };
            if open(stamp.rows / 2 - 1) | open(stamp.rows / 2) == 0 {
                return;
            }
        }
        let mask = mask();
        if mask == 0 {
            return;
        }
        let tone = u32::from(colour());
        for (row, pixels) in (0..stamp.rows).zip(window.chunks_mut(stride)) {
            let Some(pixels) = pixels.first_chunk_mut::<4>() else {
                return;
            };
            let old = word(*pixels);
            let new = spread(mask, row) & !old;
            *pixels = old.wrapping_add(new.wrapping_mul(tone)).to_le_bytes();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;

    fn at(tones: &Tones<'_>, x: i32, y: i32) -> Stamp {
        Stamp {
            corner: tones.corner(x, y),
            x: 0,
            y: 0,
            rows: 4,
            within: 0xFFFF,
            away: false,
            w: 0,
        }
    }

    #[test]
    fn the_first_tone_keeps_the_pixel_and_neighbours_keep_theirs() {
        let mut buffer = [0; tone_words(12, 6)];
        let mut tones = Tones::cleared(&mut buffer, 12, 10, 6).unwrap();
        tones.stamp(at(&tones, 2, 1), || 0b0110_1111_1111_0110, || 5);
        let two = Stamp {
            rows: 2,
            ..at(&tones, 4, 1)
        };
        tones.stamp(two, || 0b0011_0011, || 9);
        let mut rows = tones.rows();
        assert_eq!(rows.next(), Some([0; 10].as_slice()));
        assert_eq!(rows.next(), Some([0, 0, 0, 5, 5, 9, 0, 0, 0, 0].as_slice()));
        assert_eq!(rows.next(), Some([0, 0, 5, 5, 5, 5, 0, 0, 0, 0].as_slice()));
        assert_eq!(rows.count(), 3);
    }

    #[test]
    fn a_pixel_among_covered_ones_is_filled_and_others_are_not() {
        let mut buffer = [0; tone_words(12, 6)];
        let mut tones = Tones::cleared(&mut buffer, 12, 12, 6).unwrap();
        let all = Rect {
            x0: 0,
            x1: 11,
            y0: 0,
            y1: 5,
        };
        let cover = |tones: &mut Tones<'_>, x, y, tone| {
            tones.draw(
                Rect {
                    x0: x,
                    x1: x,
                    y0: y,
                    y1: y,
                },
                0,
                || tone,
            );
        };
        for (x, y) in [(3, 2), (5, 2), (4, 1), (4, 3), (8, 3), (10, 3), (9, 2)] {
            cover(&mut tones, x, y, 2 * x as u16 + 1);
        }
        tones.fill(all);
        let rows: [&[u8]; 6] = core::array::from_fn(|y| tones.rows().nth(y).unwrap());
        assert_eq!(rows[2][4], 7, "from the left");
        assert_eq!(rows[3][9], 17, "three are enough");
        let covered: usize = rows
            .iter()
            .flat_map(|r| r.iter())
            .map(|t| usize::from(t & 1))
            .sum();
        assert_eq!(covered, 9);
    }

    /// A frame of 12 x 6 in which all but these are covered.
    fn all_but<'a>(buffer: &'a mut [u32], open: &[(u32, u32)]) -> Tones<'a> {
        let mut tones = Tones::cleared(buffer, 12, 12, 6).unwrap();
        for (x, y) in (0..12).flat_map(|x| (0..6).map(move |y| (x, y))) {
            if !open.contains(&(x, y)) {
                tones.paint(x, y, 5);
            }
        }
        tones
    }

    fn open(tones: &Tones<'_>) -> usize {
        tones
            .rows()
            .flatten()
            .filter(|tone| **tone & 1 == 0)
            .count()
    }

    #[test]
    fn a_gap_of_one_row_is_filled_from_its_left_end() {
        let all = Rect {
            x0: 0,
            x1: 11,
            y0: 0,
            y1: 5,
        };
        for first in 2..5 {
            let gap: std::vec::Vec<(u32, u32)> = (first..9).map(|x| (x, 2)).collect();
            let mut buffer = [0; tone_words(12, 6)];
            let mut tones = all_but(&mut buffer, &gap);
            tones.fill(all);
            assert_eq!(open(&tones), 0, "from {first} on");
        }
    }

    #[test]
    fn what_is_filled_counts_for_what_is_left_of_it_and_above() {
        let all = Rect {
            x0: 0,
            x1: 11,
            y0: 0,
            y1: 5,
        };
        let corner = [(5, 2), (6, 2), (5, 3)];
        let mut buffer = [0; tone_words(12, 6)];
        let mut tones = all_but(&mut buffer, &corner);
        tones.fill(all);
        assert_eq!(open(&tones), 0);
        let square = [(5, 2), (6, 2), (5, 3), (6, 3)];
        let mut buffer = [0; tone_words(12, 6)];
        let mut tones = all_but(&mut buffer, &square);
        tones.fill(all);
        assert_eq!(open(&tones), 4, "too large for a gap");
    }

    #[test]
    fn a_pixel_of_quarters_counts_as_whole_in_a_gap_and_not_at_an_edge() {
        let mut buffer = [0; tone_words(12, 6)];
        let tones = all_but(&mut buffer, &[(4, 2), (5, 2), (4, 3), (3, 2)]);
        assert_eq!(
            tones.quarters(2, 1),
            4,
            "a quarter of itself, most of its neighbours"
        );
        assert_eq!(tones.quarters(1, 1), 4, "a quarter of one of them");
        let two = [(4, 2), (5, 2), (4, 3), (5, 3), (6, 2), (6, 3), (7, 2)];
        let mut buffer = [0; tone_words(12, 6)];
        let tones = all_but(&mut buffer, &two);
        assert_eq!(
            tones.quarters(2, 1),
            4,
            "nothing of itself, all but one pixel round it"
        );
        let mut buffer = [0; tone_words(12, 6)];
        let notch: std::vec::Vec<(u32, u32)> = (4..12).flat_map(|x| [(x, 2), (x, 3)]).collect();
        let tones = all_but(&mut buffer, &notch);
        assert_eq!(tones.quarters(2, 1), 4, "the end of a cut");
        assert_eq!(tones.quarters(3, 1), 0, "a cut");
        let beyond: std::vec::Vec<(u32, u32)> =
            (4..12).flat_map(|x| (0..6).map(move |y| (x, y))).collect();
        let mut buffer = [0; tone_words(12, 6)];
        let mut tones = all_but(&mut buffer, &beyond);
        tones.paint(4, 2, 5);
        assert_eq!(tones.quarters(2, 1), 1);
        assert_eq!(tones.quarters(3, 1), 0);
        assert_eq!(tones.quarters(0, 1), 4);
    }

    #[test]
    fn a_window_may_stick_out_of_every_corner() {
        let mut buffer = [0; tone_words(12, 6)];
        let mut tones = Tones::cleared(&mut buffer, 12, 12, 6).unwrap();
        for (x, y) in [(-2, -2), (10, -2), (-2, 4), (10, 4)] {
            let inside =
                |bit: i32| (0..12).contains(&(x + bit % 4)) && (0..6).contains(&(y + bit / 4));
            let mask = (0..16).filter(|b| inside(*b)).fold(0, |m, b| m | 1 << b);
            tones.stamp(at(&tones, x, y), || mask, || 7);
        }
        let covered: usize = tones.rows().flatten().map(|t| usize::from(t & 1)).sum();
        assert_eq!(covered, 16);
        assert!(tones.is_hidden(Rect {
            x0: 10,
            x1: 11,
            y0: 4,
            y1: 5
        }));
        assert!(!tones.is_hidden(Rect {
            x0: 9,
            x1: 11,
            y0: 4,
            y1: 5
        }));
    }
}
