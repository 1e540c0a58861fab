//! The size of the panel, upright.

/// Columns.
pub const WIDTH: u16 = 240;

/// Rows.
pub const HEIGHT: u16 = 320;

/// Pixels.
pub const PIXELS: usize = WIDTH as usize * HEIGHT as usize;

/// The frame of a whole panel: RGB565 words, rows from the top.
pub type Words = [u16; PIXELS];
