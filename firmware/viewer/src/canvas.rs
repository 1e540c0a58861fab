//! RGB565 words as something to draw on.

use core::convert::Infallible;

use embedded_graphics::Pixel;
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Size};
use embedded_graphics::pixelcolor::raw::RawU16;
use embedded_graphics::pixelcolor::{IntoStorage, Rgb565};
use embedded_graphics::primitives::Rectangle;

/// Columns of the panel in portrait.
pub const WIDTH: u16 = 240;

/// Rows of the panel in portrait.
pub const HEIGHT: u16 = 320;

/// Pixels of the panel.
pub const PIXELS: usize = WIDTH as usize * HEIGHT as usize;

/// The frame of a whole panel: RGB565 words, rows from the top.
pub type Words = [u16; PIXELS];

/// A borrowed frame that text and shapes are drawn on; what lies outside is left out.
#[derive(Debug)]
pub struct Canvas<'a> {
    words: &'a mut Words,
}

impl<'a> Canvas<'a> {
    /// Draws on these words.
    #[must_use]
    pub fn new(words: &'a mut Words) -> Self {
        Self { words }
    }

    /// The colour of a pixel; none outside.
    #[must_use]
    pub fn pixel(&self, x: u16, y: u16) -> Option<Rgb565> {
        let inside = x < WIDTH && y < HEIGHT;
        let index = usize::from(y) * usize::from(WIDTH) + usize::from(x);
        let word = *self.words.get(index).filter(|_| inside)?;
        Some(Rgb565::from(RawU16::new(word)))
    }
}

impl OriginDimensions for Canvas<'_> {
    fn size(&self) -> Size {
        Size::new(WIDTH.into(), HEIGHT.into())
    }
}

impl DrawTarget for Canvas<'_> {
    type Color = Rgb565;
    type Error = Infallible;

    fn draw_iter<I>(&mut self, pixels: I) -> Result<(), Infallible>
    where
        I: IntoIterator<Item = Pixel<Rgb565>>,
    {
        for Pixel(at, colour) in pixels {
            let (Ok(x), Ok(y)) = (u16::try_from(at.x), u16::try_from(at.y)) else {
                continue;
            };
            let index = usize::from(y) * usize::from(WIDTH) + usize::from(x);
            if x < WIDTH
                && let Some(word) = self.words.get_mut(index)
            {
                *word = colour.into_storage();
            }
        }
        Ok(())
    }

    fn fill_solid(&mut self, area: &Rectangle, colour: Rgb565) -> Result<(), Infallible> {
        let area = area.intersection(&Rectangle::new(
            embedded_graphics::geometry::Point::zero(),
            self.size(),
        ));
        // Inside the canvas after the intersection, so both are small and not negative.
        let (left, top) = (area.top_left.x as usize, area.top_left.y as usize);
        let (width, height) = (area.size.width as usize, area.size.height as usize);
        let rows = self.words.chunks_exact_mut(usize::from(WIDTH));
        for row in rows.skip(top).take(height) {
            if let Some(part) = row.get_mut(left..left + width) {
                part.fill(colour.into_storage());
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_graphics::geometry::Point;
    use embedded_graphics::pixelcolor::RgbColor;
    use std::boxed::Box;

    #[test]
    fn what_lies_outside_is_left_out() {
        let mut words = Box::new([0; PIXELS]);
        let mut canvas = Canvas::new(&mut words);
        let outside = [(-1, 0), (240, 0), (0, -1), (0, 320), (i32::MAX, i32::MAX)];
        let pixels = outside.map(|(x, y)| Pixel(Point::new(x, y), Rgb565::WHITE));
        canvas.draw_iter(pixels).unwrap();
        let area = Rectangle::new(Point::new(500, 500), Size::new(9, 9));
        canvas.fill_solid(&area, Rgb565::WHITE).unwrap();
        assert!(words.iter().all(|w| *w == 0));
    }

    #[test]
    fn a_rectangle_over_the_edge_fills_what_is_inside() {
        let mut words = Box::new([0; PIXELS]);
        let mut canvas = Canvas::new(&mut words);
        let area = Rectangle::new(Point::new(-5, 318), Size::new(7, 9));
        canvas.fill_solid(&area, Rgb565::WHITE).unwrap();
        assert_eq!(canvas.pixel(1, 319), Some(Rgb565::WHITE));
        assert_eq!(canvas.pixel(2, 319), Some(Rgb565::BLACK));
        assert_eq!(words.iter().filter(|w| **w != 0).count(), 4);
    }
}
