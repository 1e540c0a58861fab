//! An error as text on the panel: the one place a user of a bare board looks at.

use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{Point, Size};
use embedded_graphics::mono_font::MonoTextStyle;
use embedded_graphics::mono_font::ascii::{FONT_9X15, FONT_9X15_BOLD};
use embedded_graphics::pixelcolor::{Rgb565, RgbColor, WebColors};
use embedded_graphics::prelude::Drawable;
use embedded_graphics::primitives::Rectangle;
use embedded_graphics::text::Text;

use crate::size::{HEIGHT, WIDTH};

/// Letters that fit a line: 240 pixels less a margin of 12 on both sides, 9 a letter.
const COLUMNS: usize = 24;
const MARGIN: i32 = 12;
const LEADING: i32 = 18;

/// Lines of a text, broken between words, or inside a word that is longer than a line.
struct Lines<'a>(&'a str);

impl<'a> Iterator for Lines<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        let text = self.0.trim_start();
        if text.is_empty() {
            return None;
        }
        let limit = text
            .char_indices()
            .nth(COLUMNS)
            .map_or(text.len(), |(at, _)| at);
        let end = if limit == text.len() {
            limit
        } else {
            // A blank right after the last column may end the line as well.
            text.char_indices()
                .take_while(|(at, _)| *at <= limit)
                .filter(|(_, c)| c.is_whitespace())
                .last()
                .map_or(limit, |(at, _)| at)
        };
        let (line, rest) = text.split_at(end);
        self.0 = rest;
        Some(line.trim_end())
    }
}

/// Draws a headline and a text below it over the whole panel.
///
/// # Errors
/// Those of the target.
pub fn draw<D>(target: &mut D, headline: &str, text: &str) -> Result<(), D::Error>
where
    D: DrawTarget<Color = Rgb565>,
{
    let whole = Rectangle::new(Point::zero(), Size::new(WIDTH.into(), HEIGHT.into()));
    target.fill_solid(&whole, Rgb565::CSS_MIDNIGHT_BLUE)?;
    let band = Rectangle::new(Point::zero(), Size::new(WIDTH.into(), 8));
    target.fill_solid(&band, Rgb565::CSS_ORANGE)?;
    let bold = MonoTextStyle::new(&FONT_9X15_BOLD, Rgb565::CSS_ORANGE);
    let plain = MonoTextStyle::new(&FONT_9X15, Rgb565::WHITE);
    let mut y = 40;
    for line in Lines(headline) {
        Text::new(line, Point::new(MARGIN, y), bold).draw(target)?;
        y += LEADING;
    }
    y += LEADING / 2;
    for line in Lines(text) {
        Text::new(line, Point::new(MARGIN, y), plain).draw(target)?;
        y += LEADING;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn lines_break_between_words() {
        let lines: Vec<_> = Lines("the model in flash was cut off after 4096 bytes").collect();
        assert_eq!(
            lines,
            ["the model in flash was", "cut off after 4096 bytes"]
        );
    }

    #[test]
    fn a_word_longer_than_a_line_breaks_inside() {
        let lines: Vec<_> = Lines("abcdefghijklmnopqrstuvwxyz0123456789 x").collect();
        assert_eq!(lines, ["abcdefghijklmnopqrstuvwx", "yz0123456789 x"]);
    }

    #[test]
    fn letters_beyond_ascii_do_not_break_the_breaking() {
        let text = "é".repeat(60);
        assert_eq!(Lines(&text).map(|l| l.chars().count()).sum::<usize>(), 60);
        assert_eq!(Lines("   ").next(), None);
    }
}
