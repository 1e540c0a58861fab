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
    pub(super) fn pixel(x: u32, y: u32) -> Self {
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
    pub(super) fn is_pixel(self) -> bool {
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
