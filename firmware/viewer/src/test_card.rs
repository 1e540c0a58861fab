//! The first image wanted on a new board.
//!
//! It tells at a glance what is wrong with a panel: swapped red and blue (the bars are
//! labelled), a mirrored or turned picture (text, and four corners of four colours), a window
//! off by a column or a row (the border is one pixel wide and touches every edge), lost low
//! bits (the gradients show 32 and 64 steps), a wrong aspect (the circle) and bytes lost on
//! the wire (the fine patterns shear).

use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{Point, Size};
use embedded_graphics::mono_font::MonoTextStyle;
use embedded_graphics::mono_font::ascii::{FONT_6X10, FONT_10X20};
use embedded_graphics::pixelcolor::{Rgb565, RgbColor, WebColors};
use embedded_graphics::prelude::{Drawable, Primitive};
use embedded_graphics::primitives::{Circle, PrimitiveStyle, Rectangle};
use embedded_graphics::text::{Alignment, Text};

use crate::size::{HEIGHT, WIDTH};

/// The bars from left to right, and the letter under each.
const BARS: [(Rgb565, &str); 8] = [
    (Rgb565::WHITE, "W"),
    (Rgb565::YELLOW, "Y"),
    (Rgb565::CYAN, "C"),
    (Rgb565::GREEN, "G"),
    (Rgb565::MAGENTA, "M"),
    (Rgb565::RED, "R"),
    (Rgb565::BLUE, "B"),
    (Rgb565::BLACK, "K"),
];

/// Left edge of bars and gradients; they are 224 pixels wide, which 8, 32 and 64 steps divide
/// evenly (64 into 3.5 pixels a step).
const LEFT: i32 = 8;
const BREADTH: i32 = 224;

/// Draws the card, 240 x 320 pixels.
///
/// # Errors
/// Those of the target.
pub fn draw<D>(target: &mut D) -> Result<(), D::Error>
where
    D: DrawTarget<Color = Rgb565>,
{
    let whole = Rectangle::new(Point::zero(), Size::new(WIDTH.into(), HEIGHT.into()));
    target.fill_solid(&whole, Rgb565::BLACK)?;
    whole
        .into_styled(PrimitiveStyle::with_stroke(Rgb565::WHITE, 1))
        .draw(target)?;
    corners(target)?;
    bars(target)?;
    gradients(target)?;
    fine_patterns(target)?;
    Circle::with_center(Point::new(120, 246), 71)
        .into_styled(PrimitiveStyle::with_stroke(Rgb565::WHITE, 1))
        .draw(target)?;
    let title = MonoTextStyle::new(&FONT_10X20, Rgb565::WHITE);
    Text::with_alignment("rho-grid", Point::new(120, 24), title, Alignment::Center).draw(target)?;
    let small = MonoTextStyle::new(&FONT_6X10, Rgb565::WHITE);
    for (text, y) in [("240 x 320  RGB565", 38), ("this edge is the bottom", 310)] {
        Text::with_alignment(text, Point::new(120, y), small, Alignment::Center).draw(target)?;
    }
    Ok(())
}

/// A numbered square of its own colour in each corner, two pixels inside the border.
fn corners<D: DrawTarget<Color = Rgb565>>(target: &mut D) -> Result<(), D::Error> {
    let (right, bottom) = (i32::from(WIDTH) - 19, i32::from(HEIGHT) - 19);
    for (x, y, colour, number) in [
        (3, 3, Rgb565::RED, "1"),
        (right, 3, Rgb565::GREEN, "2"),
        (3, bottom, Rgb565::BLUE, "3"),
        (right, bottom, Rgb565::YELLOW, "4"),
    ] {
        target.fill_solid(&Rectangle::new(Point::new(x, y), Size::new(16, 16)), colour)?;
        let ink = if colour == Rgb565::BLUE {
            Rgb565::WHITE
        } else {
            Rgb565::BLACK
        };
        Text::new(
            number,
            Point::new(x + 5, y + 11),
            MonoTextStyle::new(&FONT_6X10, ink),
        )
        .draw(target)?;
    }
    Ok(())
}

fn bars<D: DrawTarget<Color = Rgb565>>(target: &mut D) -> Result<(), D::Error> {
    let ink = MonoTextStyle::new(&FONT_6X10, Rgb565::WHITE);
    let mut x = LEFT;
    for (colour, letter) in BARS {
        let breadth = BREADTH / BARS.len() as i32;
        let area = Rectangle::new(Point::new(x, 48), Size::new(breadth as u32, 40));
        target.fill_solid(&area, colour)?;
        let middle = Point::new(x + breadth / 2, 98);
        Text::with_alignment(letter, middle, ink, Alignment::Center).draw(target)?;
        x += breadth;
    }
    Ok(())
}

/// Red, green, blue and grey from nothing to full, one step of the panel's own each.
fn gradients<D: DrawTarget<Color = Rgb565>>(target: &mut D) -> Result<(), D::Error> {
    for x in 0..BREADTH {
        let five = (x * 32 / BREADTH) as u8;
        let six = (x * 64 / BREADTH) as u8;
        for (row, colour) in [
            Rgb565::new(five, 0, 0),
            Rgb565::new(0, six, 0),
            Rgb565::new(0, 0, five),
            Rgb565::new(five, six, five),
        ]
        .into_iter()
        .enumerate()
        {
            let top = 108 + 18 * row as i32;
            let area = Rectangle::new(Point::new(LEFT + x, top), Size::new(1, 16));
            target.fill_solid(&area, colour)?;
        }
    }
    Ok(())
}

/// A chequer of single pixels, columns and rows one pixel apart, and a grid of diagonals.
fn fine_patterns<D: DrawTarget<Color = Rgb565>>(target: &mut D) -> Result<(), D::Error> {
    type Pattern = fn(i32, i32) -> bool;
    let patterns: [(i32, Pattern, Rgb565); 4] = [
        (8, |x, y| (x + y) % 2 == 0, Rgb565::WHITE),
        (44, |x, _| x % 2 == 0, Rgb565::CSS_ORANGE),
        (168, |_, y| y % 2 == 0, Rgb565::CSS_SKY_BLUE),
        (204, |x, y| x == y || x == 27 - y, Rgb565::WHITE),
    ];
    for (left, on, colour) in patterns {
        for (top, flip) in [(190, 0), (272, 1)] {
            let square = (0..28).flat_map(|y| (0..28).map(move |x| (x, y)));
            target.draw_iter(
                square
                    .filter(|(x, y)| on(*x + flip, *y))
                    .map(|(x, y)| embedded_graphics::Pixel(Point::new(left + x, top + y), colour)),
            )?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::size::PIXELS;
    use rho_grid::frame::Frame;
    use std::boxed::Box;

    #[test]
    fn the_border_is_one_pixel_wide_and_touches_every_edge() {
        let mut words = Box::new([0x1234; PIXELS]);
        let mut canvas = Frame::of_width(words.as_mut_slice(), WIDTH);
        draw(&mut canvas).unwrap();
        for x in 0..WIDTH {
            assert_eq!(canvas.pixel(x, 0), Some(Rgb565::WHITE));
            assert_eq!(canvas.pixel(x, HEIGHT - 1), Some(Rgb565::WHITE));
        }
        for y in 0..HEIGHT {
            assert_eq!(canvas.pixel(0, y), Some(Rgb565::WHITE));
            assert_eq!(canvas.pixel(WIDTH - 1, y), Some(Rgb565::WHITE));
        }
        for x in 1..WIDTH - 1 {
            assert_eq!(canvas.pixel(x, 1), Some(Rgb565::BLACK));
            assert_eq!(canvas.pixel(x, HEIGHT - 2), Some(Rgb565::BLACK));
        }
    }

    #[test]
    fn every_step_of_each_colour_is_there() {
        let mut words = Box::new([0; PIXELS]);
        draw(&mut Frame::of_width(words.as_mut_slice(), WIDTH)).unwrap();
        for bits in 0..32 {
            assert!(words.contains(&(bits << 11)), "red {bits}");
            assert!(words.contains(&bits), "blue {bits}");
        }
        for bits in 0..64 {
            assert!(words.contains(&(bits << 5)), "green {bits}");
        }
    }
}
