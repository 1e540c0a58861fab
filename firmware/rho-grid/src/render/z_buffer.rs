//! Cells in any order, a depth a pixel.

#[cfg(rho_thumb)]
use super::visibility::{Bytes, Depths};
use super::visibility::{Canvas, Rect, Stamp, Visibility};

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
    use crate::frame::Frame;

    fn rect(x0: u32, x1: u32, y0: u32, y1: u32) -> Rect {
        Rect { x0, x1, y0, y1 }
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
