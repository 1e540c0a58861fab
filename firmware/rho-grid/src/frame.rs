//! A picture of RGB565 pixels in memory.

use embedded_graphics_core::Pixel;
use embedded_graphics_core::draw_target::DrawTarget;
use embedded_graphics_core::geometry::{Dimensions, OriginDimensions, Point, Size};
use embedded_graphics_core::pixelcolor::Rgb565;
use embedded_graphics_core::pixelcolor::raw::{RawData, RawU16};
use embedded_graphics_core::primitives::Rectangle;
use embedded_graphics_core::{Drawable, pixelcolor::PixelColor};

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

fn from_word(word: u16) -> Rgb565
where
    Rgb565: PixelColor,
{
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
