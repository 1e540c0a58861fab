//! The Q formats of this crate, each a type of the `fixed` crate.
//!
//! A name says what the number means; the type says its range and step.

use fixed::types::{I1F15, I2F14, I2F30, I12F20, U2F30, U8F8, U20F12};

/// An entry of a rotation matrix or the component of a unit vector, -1 to 1, in steps of 2^-30.
pub type Rotation = I2F30;

/// A length in cube units (the bounding cube's side is 1), below 2048, in steps of 2^-20.
pub type Length = I12F20;

/// A focal length in pixels, below 2^20, in steps of 2^-12 pixel.
pub type Focal = U20F12;

/// The component of a normal or of a light's direction, -1 to 1, in steps of 2^-14.
pub type Unit = I2F14;

/// The size of a cell or splat on the screen in pixels, below 256, in steps of 1/256 pixel.
pub type PixelSize = U8F8;

/// Where an object stands in the scene, in sides of the scene's cube, -2 to 2, in steps of 2^-30.
pub type Place = I2F30;

/// The side of an object's cube in sides of the scene's, below 4, in steps of 2^-30.
pub type Scale = U2F30;

/// A coordinate in an object's cube, -0.5 to 0.5, in steps of 2^-15.
pub type Extent = I1F15;
