//! Where the picture is taken from.

use crate::q::{Focal, Length, Rotation};

/// A pinhole camera, as integers which the host computes once.
///
/// Eye space is right-handed: x to the right, y up, the camera looks along -z. The pixel
/// (x, y) has its centre at (x + 0.5, y + 0.5), rows from the top; the optical axis passes
/// through (width / 2, height / 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Camera {
    /// World to eye; the rows are the camera's right, up and back in world coordinates.
    pub rotation: [[Rotation; 3]; 3],
    /// The world's origin in eye space; `(0, 0, -d)` when the eye looks at the origin from d.
    pub translation: [Length; 3],
    /// Focal length in pixels: `height / 2 / tan(fov / 2)`, times the zoom.
    pub focal: Focal,
    /// Width of the picture in pixels, 1 to [`Camera::MAX_SIDE`].
    pub width: u16,
    /// Height of the picture in pixels, 1 to [`Camera::MAX_SIDE`].
    pub height: u16,
}

impl Camera {
    /// The longest side of a picture in pixels.
    pub const MAX_SIDE: u16 = 1024;

    /// Whether it is one.
    ///
    /// # Errors
    /// What is wrong with its numbers.
    pub fn check(&self) -> Result<(), ViewError> {
        let sides = 1..=Self::MAX_SIDE;
        if !(sides.contains(&self.width) && sides.contains(&self.height)) {
            return Err(ViewError::Size);
        }
        if self.focal < Focal::ONE {
            return Err(ViewError::Focal);
        }
        for row in self.rotation {
            // Q56; rows computed in f64 and rounded are far within a thousandth.
            let square: i64 = row
                .iter()
                .map(|v| i64::from(v.to_bits() >> 2) * i64::from(v.to_bits() >> 2))
                .sum();
            if (square - (1 << 56)).abs() > 1 << 47 {
                return Err(ViewError::Rotation);
            }
        }
        Ok(())
    }
}

/// The camera's numbers exceed what a frame can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViewError {
    /// Width or height is 0 or above [`Camera::MAX_SIDE`].
    Size,
    /// The focal length is below one pixel.
    Focal,
    /// The rotation's rows are not of length 1.
    Rotation,
}

impl core::fmt::Display for ViewError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Size => "camera: width and height must be 1 to 1024",
            Self::Focal => "camera: the focal length must be at least one pixel",
            Self::Rotation => "camera: the rotation's rows must have length 1",
        })
    }
}

impl core::error::Error for ViewError {}
