//! Which sample a pixel shows.

use core::ops::Range;

use crate::frame::Frame;

/// Pixels of the frame, first and last included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    /// First column.
    pub x0: u32,
    /// Last column, at least the first.
    pub x1: u32,
    /// First row.
    pub y0: u32,
    /// Last row, at least the first.
    pub y1: u32,
}

impl Rect {
    /// One pixel.
    #[inline(always)]
    fn pixel(x: u32, y: u32) -> Self {
        Self {
            x0: x,
            x1: x,
            y0: y,
            y1: y,
        }
    }

    /// The least that holds those of both that there are.
    #[must_use]
    pub fn of_both(one: Option<Self>, other: Option<Self>) -> Option<Self> {
        one.into_iter().chain(other).reduce(Self::with)
    }

    /// The least that holds both.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self {
            x0: self.x0.min(other.x0),
            x1: self.x1.max(other.x1),
            y0: self.y0.min(other.y0),
            y1: self.y1.max(other.y1),
        }
    }

    /// Whether it is one pixel.
    #[inline(always)]
    fn is_pixel(self) -> bool {
        self.x0 == self.x1 && self.y0 == self.y1
    }
}

/// A method to find the nearest sample of each pixel.
pub trait Visibility {
    /// Whether cells must come from front to back.
    const FRONT_TO_BACK: bool;

    /// Whether nothing behind what is drawn can show in `rect`.
    fn is_hidden(&self, rect: Rect) -> bool;

    /// Whether nothing can show in `rect` whose w is at least `nearest`.
    #[inline(always)]
    fn is_behind(&self, rect: Rect, _nearest: i32) -> bool {
        self.is_hidden(rect)
    }

    /// Draws a sample over `rect`, where it shows; `colour` is asked for at most once. `w` is its
    /// distance along the optical axis, in the view's own unit, below 2^29.
    fn draw(&mut self, rect: Rect, w: i32, colour: impl FnOnce() -> u16);

    /// Draws a sample over those pixels of `rect`, where it shows, that `shape` holds.
    #[inline(always)]
    fn draw_shape(&mut self, rect: Rect, w: i32, shape: &impl Shape, colour: impl Fn() -> u16) {
        for y in rect.y0..rect.y1 + 1 {
            for x in shape.row(y).within(rect.x0, rect.x1) {
                self.draw(Rect::pixel(x, y), w, &colour);
            }
        }
    }

    /// Whether a pixel may still show what is drawn next; pixels beyond the frame may not.
    #[inline(always)]
    fn is_open(&self, x: u32, y: u32) -> bool {
        !self.is_hidden(Rect::pixel(x, y))
    }

    /// Whether a pixel may show a sample of this w.
    #[inline(always)]
    fn shows(&self, x: u32, y: u32, _w: i32) -> bool {
        self.is_open(x, y)
    }

    /// What the loops in assembly draw into, if it is a frame that they know.
    #[cfg(rho_thumb)]
    fn bytes(&mut self) -> Option<Bytes<'_>> {
        None
    }

    /// A pixel, also one beyond the frame, from which [`Stamp`]s count.
    #[inline(always)]
    fn corner(&self, x: i32, y: i32) -> u32 {
        x as u32 & 0xFFFF | (y as u32) << 16
    }

    /// Whether stamps are laid whose 4 x 4 pixels begin at this one, which may lie beyond the frame.
    #[inline(always)]
    fn holds(&self, _x: i32, _y: i32) -> bool {
        true
    }

    /// Draws a sample, where it shows, over the pixels that a mask of 4 x 4 names: bit `4 j + i` for
    /// the pixel i to the right of the stamp's first one and j below it. Bits from row `rows` on are
    /// 0; so are those of pixels beyond the frame.
    #[inline(always)]
    fn stamp(&mut self, stamp: Stamp, mask: impl FnOnce() -> u32, colour: impl Fn() -> u16) {
        let x = i32::from(stamp.corner as i16) + stamp.x as i32;
        let y = ((stamp.corner as i32) >> 16) + stamp.y as i32;
        if !self.holds(x, y) {
            return;
        }
        if stamp.away {
            let mut middle = stamp.within & 255 << (4 * (stamp.rows / 2 - 1));
            loop {
                if middle == 0 {
                    return;
                }
                let bit = middle.trailing_zeros();
                middle &= middle - 1;
                let (x, y) = (x + (bit % 4) as i32, y + (bit / 4) as i32);
                if self.shows(x as u32, y as u32, stamp.w) {
                    break;
                }
            }
        }
        let mut left = mask();
        while left != 0 {
            let bit = left.trailing_zeros();
            left &= left - 1;
            let (x, y) = (x + (bit % 4) as i32, y + (bit / 4) as i32);
            self.draw(Rect::pixel(x as u32, y as u32), stamp.w, &colour);
        }
    }
}

/// A frame of tones as wide as the loops in assembly have it.
#[cfg(rho_thumb)]
#[derive(Debug)]
pub struct Bytes<'a> {
    /// Its pixels, and its margins.
    pub pixels: &'a mut [u8],
    /// Of a band of quarters, which is twice as wide, the first row.
    pub band: Option<i32>,
    /// What is drawn against depths.
    pub depths: Option<Depths<'a>>,
}

/// Depths of a frame's pixels, as [`ZBuffer`] has them.
#[cfg(rho_thumb)]
#[derive(Debug)]
pub struct Depths<'a> {
    /// One a pixel.
    pub words: &'a mut [u16],
    /// A depth is w times this over 2^32.
    pub factor: u32,
}

/// Where and how a mask is laid.
#[derive(Clone, Copy, Debug)]
pub struct Stamp {
    /// What [`Visibility::corner`] said.
    pub corner: u32,
    /// The mask's first pixel, to the right of the corner.
    pub x: u32,
    /// And below it.
    pub y: u32,
    /// Its rows, 2 to 4.
    pub rows: usize,
    /// Which of the 4 x 4 pixels lie in the frame, one at least.
    pub within: u32,
    /// The sample faces away: it shows only where one of the pixels in the two middle rows of 4 x 4
    /// and in the frame is open.
    pub away: bool,
    /// Its distance along the optical axis, as [`Visibility::draw`] takes it.
    pub w: i32,
}

/// A set of pixels without gaps in its rows, asked row by row.
pub trait Shape {
    /// The columns of row `y` that it holds.
    fn row(&self, y: u32) -> Span;
}

/// Columns of a row, first and last included, also beyond the frame; none when the last is before the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The first.
    pub first: i32,
    /// The last.
    pub last: i32,
}

impl Span {
    /// No columns.
    pub const NONE: Self = Self { first: 0, last: -1 };

    /// Those from `x0` to `x1`.
    #[inline(always)]
    pub fn within(self, x0: u32, x1: u32) -> Range<u32> {
        let (x0, x1) = (x0 as i32, x1 as i32);
        let first = self.first.clamp(x0, x1 + 1);
        let end = (self.last.min(x1) + 1).max(first);
        first as u32..end as u32
    }
}

/// Pixels to paint, each of which knows whether it is still open.
pub trait Canvas {
    /// Columns and rows.
    fn size(&self) -> (u16, u16);

    /// The frame's row that is the first here.
    fn first_row(&self) -> u32 {
        0
    }

    /// What the loops in assembly draw into, if depths follow each other as pixels do.
    #[cfg(rho_thumb)]
    fn bytes_beside_depths(&mut self) -> Option<&mut [u8]> {
        None
    }

    /// Paints a pixel, also one that is covered, and covers it.
    fn paint(&mut self, x: u32, y: u32, colour: u16);

    /// The depths, a word a pixel, behind which nothing shows: 0 where a pixel is covered, 65535
    /// where it is open.
    fn depths(&self, depths: &mut [u16]);
}

impl Canvas for Frame<'_> {
    fn size(&self) -> (u16, u16) {
        (self.width(), self.height())
    }

    #[inline(always)]
    fn paint(&mut self, x: u32, y: u32, colour: u16) {
        let at = (y * u32::from(self.width()) + x) as usize;
        if let Some(pixel) = self.pixels_mut().get_mut(at) {
            *pixel = colour;
        }
    }

    fn depths(&self, depths: &mut [u16]) {
        depths.fill(u16::MAX);
    }
}

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

/// A depth a pixel: the nearest sample wins, the first of equally near ones.
///
/// Depths are 16 bits of the view's w: a 2^16th of the depth that the whole cube can have in this view,
/// so that a leaf near the eye and one behind it differ. `IN_ORDER`, cells come from front to back and
/// are left with all below them where all depths are nearer; else every cell is drawn.
#[derive(Debug)]
pub struct ZBuffer<'a, C, const IN_ORDER: bool> {
    canvas: &'a mut C,
    depth: &'a mut [u16],
    width: u32,
    /// The frame's row that is the first here.
    first: u32,
    /// A depth is w times this over 2^32.
    factor: u32,
}

impl<'a, C: Canvas, const IN_ORDER: bool> ZBuffer<'a, C, IN_ORDER> {
    /// The factor of a grid that is alone: the upper 16 of w's 29 bits.
    const ALONE: u32 = 1 << (32 - 13);

    /// Over a canvas and its depths as they stand (65535: nothing drawn yet); `None` when `depth`
    /// has fewer words than the canvas pixels.
    #[must_use]
    pub fn new(canvas: &'a mut C, depth: &'a mut [u16]) -> Option<Self> {
        let (width, height) = canvas.size();
        let depth = depth.get_mut(..usize::from(width) * usize::from(height))?;
        Some(Self {
            first: canvas.first_row(),
            canvas,
            depth,
            width: u32::from(width),
            factor: Self::ALONE,
        })
    }

    /// For a view whose w is to be multiplied by `factor` over 2^32, so that depths of several views
    /// are in one unit.
    #[must_use]
    pub fn scaled(self, factor: u32) -> Self {
        Self { factor, ..self }
    }

    /// Where a pixel's depth is; beyond all where it has none.
    #[inline(always)]
    fn at(&self, x: u32, y: u32) -> usize {
        let row = y.wrapping_sub(self.first);
        row.wrapping_mul(self.width).wrapping_add(x) as usize
    }

    #[inline(always)]
    fn depth(&self, w: i32) -> u16 {
        // In front of the eye w is positive.
        let product = u64::from(w.max(0).unsigned_abs()) * u64::from(self.factor);
        (product >> 32).min(0xFFFE) as u16
    }
}

impl<C: Canvas, const IN_ORDER: bool> Visibility for ZBuffer<'_, C, IN_ORDER> {
    const FRONT_TO_BACK: bool = IN_ORDER;

    #[cfg(rho_thumb)]
    #[inline(always)]
    fn bytes(&mut self) -> Option<Bytes<'_>> {
        if !IN_ORDER {
            return None;
        }
        let depths = Depths {
            words: self.depth,
            factor: self.factor,
        };
        Some(Bytes {
            pixels: self.canvas.bytes_beside_depths()?,
            band: None,
            depths: Some(depths),
        })
    }

    #[inline(always)]
    fn is_hidden(&self, _: Rect) -> bool {
        false
    }

    #[inline(always)]
    fn is_behind(&self, r: Rect, nearest: i32) -> bool {
        if !IN_ORDER {
            return false;
        }
        let nearest = self.depth(nearest);
        let open = |x: u32, y: u32| {
            let depth = self.depth.get(self.at(x, y));
            depth.is_some_and(|depth| *depth > nearest)
        };
        // Of what shows, the middle or a corner mostly does.
        if open(r.x0.midpoint(r.x1), r.y0.midpoint(r.y1))
            || open(r.x0, r.y0)
            || open(r.x1, r.y0)
            || open(r.x0, r.y1)
            || open(r.x1, r.y1)
        {
            return false;
        }
        let mut at = self.at(r.x0, r.y0);
        let count = (r.x1 - r.x0 + 1) as usize;
        for _ in r.y0..r.y1 + 1 {
            let row = self.depth.get(at..at + count).unwrap_or_default();
            if row.iter().any(|depth| *depth > nearest) {
                return false;
            }
            at += self.width as usize;
        }
        true
    }

    #[inline(always)]
    fn shows(&self, x: u32, y: u32, w: i32) -> bool {
        if !IN_ORDER {
            return true;
        }
        let depth = self.depth.get(self.at(x, y)).copied().unwrap_or(0);
        x < self.width && self.depth(w) < depth
    }

    #[inline(always)]
    fn draw(&mut self, r: Rect, w: i32, colour: impl FnOnce() -> u16) {
        let here = self.depth(w);
        if r.is_pixel() {
            if self.nearer(r.x0, r.y0, here) {
                let colour = colour();
                self.canvas.paint(r.x0, r.y0, colour);
            }
            return;
        }
        self.fill(r, here, colour());
    }

    #[inline(always)]
    fn stamp(&mut self, stamp: Stamp, mask: impl FnOnce() -> u32, colour: impl Fn() -> u16) {
        let here = self.depth(stamp.w);
        let x = i32::from(stamp.corner as i16) + stamp.x as i32;
        let y = ((stamp.corner as i32) >> 16) + stamp.y as i32;
        let width = self.width as usize;
        let at = ((y - self.first as i32) * width as i32 + x) as usize;
        if IN_ORDER && stamp.away {
            let shows = |bit: usize| {
                let pixel = at.wrapping_add(bit / 4 * width + bit % 4);
                let depth = self.depth.get(pixel);
                stamp.within >> bit & 1 == 1 && depth.is_some_and(|depth| here < *depth)
            };
            let middle = 4 * (stamp.rows / 2 - 1);
            if !(middle..middle + 8).any(shows) {
                return;
            }
        }
        let mut left = mask();
        let mut shade = None;
        while left != 0 {
            let bit = left.trailing_zeros();
            left &= left - 1;
            let (column, row) = ((bit % 4) as usize, (bit / 4) as usize);
            let pixel = at.wrapping_add(row * width + column);
            if let Some(depth) = self.depth.get_mut(pixel)
                && here < *depth
            {
                *depth = here;
                let colour = *shade.get_or_insert_with(&colour);
                let (x, y) = (x + column as i32, y + row as i32);
                self.canvas.paint(x as u32, y as u32, colour);
            }
        }
    }
}

impl<C: Canvas, const IN_ORDER: bool> ZBuffer<'_, C, IN_ORDER> {
    /// Moves a pixel's depth to `here`; whether that is nearer.
    #[inline(always)]
    fn nearer(&mut self, x: u32, y: u32, here: u16) -> bool {
        let at = self.at(x, y);
        match self.depth.get_mut(at) {
            Some(depth) if here < *depth => {
                *depth = here;
                true
            }
            _ => false,
        }
    }

    /// Colours the pixels where this is nearer.
    #[inline(never)]
    fn fill(&mut self, r: Rect, here: u16, colour: u16) {
        for y in r.y0..r.y1 + 1 {
            for x in r.x0..r.x1 + 1 {
                if self.nearer(x, y, here) {
                    self.canvas.paint(x, y, colour);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
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

    #[test]
    fn in_the_z_buffer_the_nearer_sample_wins() {
        let mut buffer = [0; 4];
        let mut frame = Frame::new(&mut buffer, 2, 2).unwrap();
        let mut depth = [u16::MAX; 4];
        let mut z = ZBuffer::<_, false>::new(&mut frame, &mut depth).unwrap();
        z.draw(rect(0, 1, 0, 1), 1 << 20, || 1);
        z.draw(rect(0, 0, 0, 0), 1 << 19, || 2);
        z.draw(rect(0, 1, 0, 1), 1 << 20, || 3);
        z.draw(rect(1, 1, 1, 1), 1 << 20, || panic!("not nearer"));
        assert_eq!(buffer, [2, 1, 1, 1]);
    }
}
