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
}
