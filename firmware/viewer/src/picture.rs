//! The seam between the device and the renderer: a model's picture into a frame.

use core::fmt;

use crate::canvas::Words;
use crate::count::{Counter, Stopwatch};
use crate::request::Scene;

/// Why a model is not drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelError {
    /// The flash where it should be is empty.
    Missing,
    /// This firmware cannot draw models.
    NoRenderer,
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Missing => "there is no model where one is looked for: the flash there is empty",
            Self::NoRenderer => "this firmware has no renderer",
        })
    }
}

impl core::error::Error for ModelError {}

/// Draws the model in `flash` into the first `width * height` words.
///
/// # Errors
/// When there is no model, or it is broken.
pub fn draw<C: Counter>(
    flash: &[u8],
    _scene: &Scene,
    _words: &mut Words,
    _watch: &mut Stopwatch<'_, C>,
) -> Result<(), ModelError> {
    if flash.iter().take(64).all(|byte| *byte == 0) {
        return Err(ModelError::Missing);
    }
    Err(ModelError::NoRenderer)
}
