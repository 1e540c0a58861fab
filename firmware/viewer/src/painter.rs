//! Where a picture is drawn before it is sent: in whole, or strip by strip.
//!
//! A painter owns the memory that drawing takes and gives the rows of a picture from the top, as they
//! are ready. [`Frames`](crate::picture::Frames) has a frame of words and all modes;
//! [`Strips`](crate::strips::Strips) has what the presets need and never a whole frame of colours.

use core::convert::Infallible;

use embedded_graphics::draw_target::{DrawTarget, DrawTargetExt, Translated};
use embedded_graphics::geometry::Point;
use rho_grid::frame::Frame;

use crate::count::{Counter, Stopwatch};
use crate::panel::ScreenError;
use crate::picture::{Model, ModelError};
use crate::request::Scene;
use crate::size::WIDTH;

/// Takes the next rows of a picture: RGB565 words.
pub type Give<'a> = &'a mut dyn FnMut(&[u16]) -> Result<(), ScreenError>;

/// Draws shapes over a part of the panel, in the coordinates of the whole one.
pub type Shapes<'a> = &'a dyn Fn(&mut Canvas<'_, '_>);

/// A part of the panel.
pub type Canvas<'a, 'f> = Translated<'a, Frame<'f>>;

/// Why a picture was not drawn, or not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PaintError {
    /// The model cannot be drawn.
    Model(ModelError),
    /// Its rows were not taken.
    Screen(ScreenError),
}

impl From<ModelError> for PaintError {
    fn from(error: ModelError) -> Self {
        Self::Model(error)
    }
}

impl From<ScreenError> for PaintError {
    fn from(error: ScreenError) -> Self {
        Self::Screen(error)
    }
}

/// Draws pictures and gives their rows.
pub trait Painter {
    /// Draws a model as the scene has it. Rows are as wide as the scene's camera.
    ///
    /// # Errors
    /// When it cannot be drawn, or the rows are not taken.
    fn model<C: Counter>(
        &mut self,
        model: &Model<'_>,
        scene: &Scene,
        watch: &mut Stopwatch<'_, C>,
        give: Give<'_>,
    ) -> Result<(), PaintError>;

    /// Draws shapes over the whole panel.
    ///
    /// # Errors
    /// When the rows are not taken.
    fn shapes<C: Counter>(
        &mut self,
        shapes: Shapes<'_>,
        watch: &mut Stopwatch<'_, C>,
        give: Give<'_>,
    ) -> Result<(), ScreenError>;
}

/// Draws the part of shapes that lies in `words`, rows as wide as the panel, from row `first` on.
pub fn draw_part(words: &mut [u16], first: u16, shapes: Shapes<'_>) {
    let mut frame = Frame::of_width(words, WIDTH);
    shapes(&mut frame.translated(Point::new(0, -i32::from(first))));
}

/// Shapes as a function of a canvas, from one of any target that cannot fail.
pub fn infallible<T>(result: Result<T, <Canvas<'_, '_> as DrawTarget>::Error>) -> T {
    let result: Result<T, Infallible> = result;
    let Ok(value) = result;
    value
}
