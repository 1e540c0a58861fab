//! A picture of RGB565 pixels in memory.

use embedded_graphics_core::Drawable;
use embedded_graphics_core::Pixel;
use embedded_graphics_core::draw_target::DrawTarget;
use embedded_graphics_core::geometry::{Dimensions, OriginDimensions, Point, Size};
use embedded_graphics_core::pixelcolor::Rgb565;
use embedded_graphics_core::pixelcolor::raw::{RawData, RawU16};
use embedded_graphics_core::primitives::Rectangle;

/// A frame: RGB565 words, rows from the top, borrowed from the board.
///
/// It is a [`DrawTarget`], so that text and shapes go over the picture, and a [`Drawable`], so
/// that it goes to any screen of embedded-graphics in one `fill_contiguous`.
#[derive(Debug)]
pub struct Frame<'a> {
    pixels: &'a mut [u16],
    width: u16,
    height: u16,
}

impl<'a> Frame<'a> {
    /// A frame of `width` x `height` in the first pixels of a buffer, as they are; `None` when
    /// they do not fit.
    #[must_use]
    pub fn new(buffer: &'a mut [u16], width: u16, height: u16) -> Option<Self> {
        let pixels = buffer.get_mut(..usize::from(width) * usize::from(height))?;
        Some(Self {
            pixels,
            width,
            height,
        })
    }

    /// A frame over a whole buffer, as it is, in as many full rows of `width` as it holds.
    #[must_use]
    pub fn of_width(buffer: &'a mut [u16], width: u16) -> Self {
        let rows = buffer.len().checked_div(usize::from(width)).unwrap_or(0);
        Self {
            pixels: buffer,
            width,
            height: u16::try_from(rows).unwrap_or(u16::MAX),
        }
    }

    /// Pixels a row.
    #[must_use]
    pub fn width(&self) -> u16 {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> u16 {
        self.height
    }

    /// RGB565 words, rows from the top.
    #[must_use]
    pub fn pixels(&self) -> &[u16] {
        self.pixels
    }

    /// RGB565 words, rows from the top.
    pub fn pixels_mut(&mut self) -> &mut [u16] {
        self.pixels
    }

    /// The colour of a pixel; none outside.
    #[must_use]
    pub fn pixel(&self, x: u16, y: u16) -> Option<Rgb565> {
        let inside = x < self.width && y < self.height;
        let at = usize::from(y) * usize::from(self.width) + usize::from(x);
        self.pixels
            .get(at)
            .filter(|_| inside)
            .map(|word| from_word(*word))
    }

    /// Every pixel becomes `colour` (RGB565).
    pub fn clear_to(&mut self, colour: u16) {
        self.pixels.fill(colour);
    }
}

impl OriginDimensions for Frame<'_> {
    fn size(&self) -> Size {
        Size::new(u32::from(self.width), u32::from(self.height))
    }
}

impl DrawTarget for Frame<'_> {
    type Color = Rgb565;
    type Error = core::convert::Infallible;

    /// Pixels beyond the frame are left out.
    fn draw_iter<I>(&mut self, pixels: I) -> Result<(), Self::Error>
    where
        I: IntoIterator<Item = Pixel<Rgb565>>,
    {
        for Pixel(Point { x, y }, colour) in pixels {
            if (0..i32::from(self.width)).contains(&x)
                && let Ok(y) = usize::try_from(y)
                && let Some(pixel) = self
                    .pixels
                    .get_mut(y * usize::from(self.width) + x as usize)
            {
                *pixel = RawU16::from(colour).into_inner();
            }
        }
        Ok(())
    }

    /// Row by row; what lies beyond the frame is left out.
    fn fill_solid(&mut self, area: &Rectangle, colour: Rgb565) -> Result<(), Self::Error> {
        let area = area.intersection(&self.bounding_box());
        // Within the frame now, so neither negative nor large.
        let (left, top) = (area.top_left.x as usize, area.top_left.y as usize);
        let (width, height) = (area.size.width as usize, area.size.height as usize);
        let rows = self.pixels.chunks_exact_mut(usize::from(self.width).max(1));
        for row in rows.skip(top).take(height) {
            if let Some(part) = row.get_mut(left..left + width) {
                part.fill(RawU16::from(colour).into_inner());
            }
        }
        Ok(())
    }
}

impl Drawable for Frame<'_> {
    type Color = Rgb565;
    type Output = ();

    /// Sends the whole frame, its top left corner at the target's origin.
    fn draw<D>(&self, target: &mut D) -> Result<(), D::Error>
    where
        D: DrawTarget<Color = Rgb565>,
    {
        let area = Rectangle::new(Point::zero(), self.bounding_box().size);
        target.fill_contiguous(&area, self.pixels.iter().map(|p| from_word(*p)))
    }
}

fn from_word(word: u16) -> Rgb565 {
    RawU16::new(word).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_graphics_core::pixelcolor::RgbColor;

    #[test]
    fn pixels_beyond_the_frame_are_left_out() {
        let mut buffer = [0; 6];
        let mut frame = Frame::new(&mut buffer, 3, 2).unwrap();
        let at = |x, y| Pixel(Point::new(x, y), Rgb565::WHITE);
        frame
            .draw_iter([at(-1, 0), at(3, 0), at(0, 2), at(2, 1), at(0, -1)])
            .unwrap();
        assert_eq!(buffer, [0, 0, 0, 0, 0, 0xFFFF]);
    }

    #[test]
    fn a_rectangle_over_the_edge_fills_what_is_inside() {
        let mut buffer = [0; 12];
        let mut frame = Frame::of_width(&mut buffer, 4);
        assert_eq!(frame.height(), 3);
        let fill = |frame: &mut Frame<'_>, x, y| {
            let area = Rectangle::new(Point::new(x, y), Size::new(3, 3));
            frame.fill_solid(&area, Rgb565::WHITE).unwrap();
        };
        fill(&mut frame, -1, 2);
        fill(&mut frame, 9, 9);
        assert_eq!(frame.pixel(1, 2), Some(Rgb565::WHITE));
        assert_eq!(frame.pixel(2, 2), Some(Rgb565::BLACK));
        assert_eq!(frame.pixel(4, 2), None);
        assert_eq!(buffer.iter().filter(|w| **w != 0).count(), 2);
    }

    #[test]
    fn a_frame_draws_into_another_target() {
        let mut a = [1, 2, 3, 4];
        let mut b = [0; 4];
        let source = Frame::new(&mut a, 2, 2).unwrap();
        let mut target = Frame::new(&mut b, 2, 2).unwrap();
        source.draw(&mut target).unwrap();
        assert_eq!(b, [1, 2, 3, 4]);
    }

    #[test]
    fn a_buffer_too_small_is_refused() {
        assert!(Frame::new(&mut [0; 5], 3, 2).is_none());
    }
}
