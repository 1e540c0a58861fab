//! Depth pictures: how far along the camera's axis each pixel's centre meets the model.
//!
//! As a PNG they are 16-bit grey: 0 is nothing, 1 to 65535 are near to far in equal steps.
//! The two texts `rho-depth-near` and `rho-depth-far` hold the depths of 1 and of 65535.

use std::path::Path;

use png::{BitDepth, ColorType, Transformations};

use crate::failure::{Failure, Outcome};
use crate::picture::{Head, decode, encode, read_file};
use crate::replace::replace;

const NEAR: &str = "rho-depth-near";
const FAR: &str = "rho-depth-far";

/// A depth for each pixel, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Depth {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` depths from the eye along the camera's axis, in cube units; infinite
    /// where there is nothing.
    pub values: Vec<f64>,
}

impl Depth {
    /// The depths as a PNG. Each comes back within (far - near) / 131,068.
    #[must_use]
    pub fn to_png(&self) -> Vec<u8> {
        let known = || self.values.iter().copied().filter(|d| d.is_finite());
        let near = known().reduce(f64::min).unwrap_or(0.0);
        let far = known().reduce(f64::max).unwrap_or(near);
        let scale = if far > near {
            65534.0 / (far - near)
        } else {
            0.0
        };
        let word = |depth: f64| {
            if depth.is_finite() {
                1 + ((depth - near) * scale).round() as u16
            } else {
                0
            }
        };
        let data: Vec<u8> = self
            .values
            .iter()
            .flat_map(|&d| word(d).to_be_bytes())
            .collect();
        let texts = [(NEAR, near.to_string()), (FAR, far.to_string())];
        let head = Head {
            width: self.width,
            height: self.height,
            kind: ColorType::Grayscale,
            depth: BitDepth::Sixteen,
            background: None,
            texts: &texts,
        };
        encode(&head, &data)
    }

    /// Reads a PNG that [`Depth::to_png`] made; `name` stands in messages.
    ///
    /// # Errors
    /// Exit 2 when it is not one.
    pub fn from_png(bytes: &[u8], name: &str) -> Outcome<Self> {
        let (info, data) = decode(bytes, name, Transformations::IDENTITY)?;
        let text = |key: &str| {
            let (_, text) = info.texts.iter().find(|(k, _)| k == key)?;
            text.parse().ok().filter(|d: &f64| d.is_finite())
        };
        let (ColorType::Grayscale, BitDepth::Sixteen, Some(near), Some(far)) =
            (info.color_type, info.bit_depth, text(NEAR), text(FAR))
        else {
            return Err(Failure::input(format!("{name} is not a depth picture"))
                .help("name a PNG that --depth wrote: 16-bit grey with its range as texts"));
        };
        let values = data
            .as_chunks()
            .0
            .iter()
            .map(|&b| match u16::from_be_bytes(b) {
                0 => f64::INFINITY,
                word => near + (far - near) * f64::from(word - 1) / 65534.0,
            });
        Ok(Self {
            width: info.width,
            height: info.height,
            values: values.collect(),
        })
    }

    /// Reads a depth picture.
    ///
    /// # Errors
    /// Exit 2 when the file cannot be read or is not a depth picture.
    pub fn read(path: &Path) -> Outcome<Self> {
        Self::from_png(&read_file(path)?, &path.display().to_string())
    }

    /// Replaces the PNG at `path`, at once and whole.
    ///
    /// # Errors
    /// Exit 2 when it cannot be written.
    pub fn write(&self, path: &Path) -> Outcome {
        replace(path, &self.to_png())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Picture;

    #[test]
    fn depths_come_back_within_half_a_step() {
        let depth = Depth {
            width: 3,
            height: 2,
            values: vec![f64::INFINITY, 1.7883, 2.2883, 2.0, 2.1234567, 1.9],
        };
        let back = Depth::from_png(&depth.to_png(), "d.png").unwrap();
        assert_eq!(back.values[0], f64::INFINITY);
        assert_eq!(back.values[1..3], depth.values[1..3]);
        for (a, b) in back.values[3..].iter().zip(&depth.values[3..]) {
            assert!((a - b).abs() <= 0.5 / 131_068.0, "{a} {b}");
        }
    }

    #[test]
    fn flat_and_empty_pictures_come_back() {
        for values in [vec![2.5, f64::INFINITY], vec![f64::INFINITY; 2]] {
            let depth = Depth {
                width: 1,
                height: 2,
                values,
            };
            assert_eq!(Depth::from_png(&depth.to_png(), "d.png").unwrap(), depth);
        }
    }

    #[test]
    fn another_png_is_not_a_depth_picture() {
        let png = Picture::filled(2, 2, [1, 2, 3]).to_png();
        let failure = Depth::from_png(&png, "colour.png").unwrap_err();
        assert!(
            failure
                .message
                .contains("colour.png is not a depth picture")
        );
    }
}
