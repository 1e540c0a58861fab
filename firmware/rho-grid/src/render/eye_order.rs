//! Cells from front to back, a coverage bit a pixel.

use super::visibility::{Canvas, Rect, Shape, Visibility};
use crate::frame::Frame;

/// Cells from front to back, a coverage bit a pixel: each pixel is written once.
#[derive(Debug)]
pub struct EyeOrder<'a, 'f> {
    frame: &'a mut Frame<'f>,
    covered: &'a mut [u32],
    width: u32,
    stride: u32,
}

impl<'a, 'f> EyeOrder<'a, 'f> {
    /// Words of coverage that a frame needs.
    #[must_use]
    pub const fn words(width: u16, height: u16) -> usize {
        (width as usize).div_ceil(32) * height as usize
    }

    /// Over a frame and its coverage as it stands (zeros: nothing drawn yet); `None` when
    /// `coverage` is shorter than [`Self::words`].
    #[must_use]
    pub fn new(frame: &'a mut Frame<'f>, coverage: &'a mut [u32]) -> Option<Self> {
        let (width, height) = (frame.width(), frame.height());
        let covered = coverage.get_mut(..Self::words(width, height))?;
        Some(Self {
            frame,
            covered,
            width: u32::from(width),
            stride: u32::from(width).div_ceil(32),
        })
    }
}

impl Visibility for EyeOrder<'_, '_> {
    const FRONT_TO_BACK: bool = true;

    #[inline(always)]
    fn is_hidden(&self, r: Rect) -> bool {
        let (first, last) = (r.x0 >> 5, r.x1 >> 5);
        let from = u32::MAX << (r.x0 & 31);
        let to = u32::MAX >> (31 - (r.x1 & 31));
        let covered = |at: u32| self.covered.get(at as usize).copied().unwrap_or(u32::MAX);
        if first == last {
            // Cells are small: mostly a word a row.
            let mask = from & to;
            let mut at = r.y0 * self.stride + first;
            for _ in r.y0..r.y1 + 1 {
                if mask & !covered(at) != 0 {
                    return false;
                }
                at += self.stride;
            }
            return true;
        }
        for y in r.y0..r.y1 + 1 {
            let row = y * self.stride;
            for word in first..last + 1 {
                let mut mask = u32::MAX;
                if word == first {
                    mask &= from;
                }
                if word == last {
                    mask &= to;
                }
                if mask & !covered(row + word) != 0 {
                    return false;
                }
            }
        }
        true
    }

    #[inline(always)]
    fn draw(&mut self, r: Rect, _w: i32, colour: impl FnOnce() -> u16) {
        let (row, line) = (r.y0 * self.stride, r.y0 * self.width);
        if r.is_pixel() {
            // Most leaves near and far: no loop, and nothing is looked up for a covered pixel.
            if self.open(row, r.x0) {
                let colour = colour();
                self.write(line + r.x0, colour);
            }
            return;
        }
        if !self.is_hidden(r) {
            self.fill(r, colour());
        }
    }

    /// Only open pixels are tried: for most samples they are few.
    #[inline(always)]
    fn draw_shape(&mut self, r: Rect, _w: i32, shape: &impl Shape, colour: impl Fn() -> u16) {
        let word = r.x0 >> 5;
        if word == r.x1 >> 5 {
            let mask = (u32::MAX << (r.x0 & 31)) & (u32::MAX >> (31 - (r.x1 & 31)));
            self.draw_word(r, word, mask, shape, colour);
        } else {
            self.draw_words(r, shape, colour);
        }
    }
}

impl Canvas for EyeOrder<'_, '_> {
    fn size(&self) -> (u16, u16) {
        (self.frame.width(), self.frame.height())
    }

    #[inline(always)]
    fn paint(&mut self, x: u32, y: u32, colour: u16) {
        self.open(y * self.stride, x);
        self.write(y * self.width + x, colour);
    }

    fn depths(&self, depths: &mut [u16]) {
        let width = self.width as usize;
        let covered = self.covered.chunks_exact(self.stride as usize);
        for (depths, covered) in depths.chunks_exact_mut(width).zip(covered) {
            for (depths, covered) in depths.chunks_mut(32).zip(covered) {
                for (bit, depth) in depths.iter_mut().enumerate() {
                    *depth = if covered >> bit & 1 == 0 { u16::MAX } else { 0 };
                }
            }
        }
    }
}

impl EyeOrder<'_, '_> {
    /// Covers a pixel; whether it was open.
    #[inline(always)]
    fn open(&mut self, row: u32, x: u32) -> bool {
        let Some(word) = self.covered.get_mut((row + (x >> 5)) as usize) else {
            return false;
        };
        let bit = 1 << (x & 31);
        let open = *word & bit == 0;
        *word |= bit;
        open
    }

    #[inline(always)]
    fn write(&mut self, at: u32, colour: u16) {
        if let Some(pixel) = self.frame.pixels_mut().get_mut(at as usize) {
            *pixel = colour;
        }
    }

    /// Draws a shape over the pixels of each row that `mask` names in a word of coverage.
    #[inline(always)]
    fn draw_word(
        &mut self,
        r: Rect,
        word: u32,
        mask: u32,
        shape: &impl Shape,
        colour: impl Fn() -> u16,
    ) {
        let mut at = r.y0 * self.stride + word;
        for y in r.y0..r.y1 + 1 {
            let covered = self.covered.get(at as usize).copied().unwrap_or(u32::MAX);
            let mut open = mask & !covered;
            if open != 0 {
                let columns = shape.row(y).within(word << 5, word << 5 | 31);
                let from = |column: u32| u64::MAX << (column - (word << 5));
                open &= (from(columns.start) & !from(columns.end)) as u32;
                if let Some(covered) = self.covered.get_mut(at as usize) {
                    *covered |= open;
                }
                while open != 0 {
                    // The leftmost bit is the last column; any order serves.
                    let bit = 31 - open.leading_zeros();
                    open ^= 1 << bit;
                    self.write(y * self.width + (word << 5) + bit, colour());
                }
            }
            at += self.stride;
        }
    }

    /// The same over several words.
    #[inline(never)]
    fn draw_words(&mut self, r: Rect, shape: &impl Shape, colour: impl Fn() -> u16) {
        for word in (r.x0 >> 5)..(r.x1 >> 5) + 1 {
            let from = (word << 5).max(r.x0) & 31;
            let to = ((word << 5) + 31).min(r.x1) & 31;
            let mask = (u32::MAX << from) & (u32::MAX >> (31 - to));
            self.draw_word(r, word, mask, shape, &colour);
        }
    }

    /// Colours the open pixels.
    #[inline(never)]
    fn fill(&mut self, r: Rect, colour: u16) {
        for y in r.y0..r.y1 + 1 {
            let (row, line) = (y * self.stride, y * self.width);
            for x in r.x0..r.x1 + 1 {
                if self.open(row, x) {
                    self.write(line + x, colour);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::visibility::Span;
    use super::*;

    fn rect(x0: u32, x1: u32, y0: u32, y1: u32) -> Rect {
        Rect { x0, x1, y0, y1 }
    }

    #[test]
    fn in_eye_order_the_first_sample_keeps_the_pixel() {
        let mut buffer = [0; 100 * 2];
        let mut frame = Frame::new(&mut buffer, 100, 2).unwrap();
        let mut bits = [0; 8];
        let mut eye = EyeOrder::new(&mut frame, &mut bits).unwrap();
        assert!(!eye.is_hidden(rect(30, 70, 0, 1)));
        eye.draw(rect(30, 70, 0, 1), 0, || 1);
        eye.draw(rect(0, 99, 0, 0), 0, || 2);
        assert!(eye.is_hidden(rect(30, 70, 0, 1)));
        assert!(eye.is_hidden(rect(0, 99, 0, 0)));
        assert!(!eye.is_hidden(rect(70, 71, 1, 1)));
        eye.draw(rect(40, 50, 0, 1), 0, || panic!("no pixel is open"));
        assert_eq!(buffer[29..32], [2, 1, 1]);
        assert_eq!(buffer[129..132], [0, 1, 1]);
    }

    struct Rows([Span; 7]);

    impl Shape for Rows {
        fn row(&self, y: u32) -> Span {
            self.0[y as usize]
        }
    }

    #[test]
    fn of_a_shape_each_row_is_drawn_from_its_first_to_its_last_column_in_the_rectangle() {
        let span = |first, last| Span { first, last };
        let rows = Rows([
            span(-9, 3),
            span(40, 50),
            span(31, 32),
            span(64, 64),
            span(70, 300),
            span(120, 130),
            Span::NONE,
        ]);
        for (x0, x1) in [(0, 99), (0, 31), (2, 45), (33, 63), (45, 80)] {
            let mut buffer = [0; 100 * 7];
            let mut frame = Frame::new(&mut buffer, 100, 7).unwrap();
            let mut bits = [0; 28];
            let mut eye = EyeOrder::new(&mut frame, &mut bits).unwrap();
            eye.draw_shape(rect(x0, x1, 0, 6), 0, &rows, || 1);
            for (y, row) in buffer.chunks(100).enumerate() {
                for (x, pixel) in (0..).zip(row) {
                    let Span { first, last } = rows.0[y];
                    let held = (first.max(x0 as i32)..=last.min(x1 as i32)).contains(&x);
                    assert_eq!(*pixel == 1, held, "{x} {y} of {x0} to {x1}");
                }
            }
        }
    }
}
