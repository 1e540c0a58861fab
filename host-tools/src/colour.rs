//! A colour as people write it: `#rrggbb`, sRGB.

use std::str::FromStr;

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// An sRGB colour, written `#rrggbb`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Colour(pub [u8; 3]);

impl Colour {
    /// This colour at 0, `other` at 1, each channel by itself.
    #[must_use]
    pub fn mix(self, other: Self, share: f64) -> Self {
        let [a, b] = [self, other].map(|colour| DVec3::from_array(colour.0.map(f64::from)));
        Self(a.lerp(b, share).to_array().map(|c| c.round() as u8))
    }

    /// Each channel times `factor`, at most 255.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self(self.0.map(|c| (f64::from(c) * factor).round() as u8))
    }
}

impl FromStr for Colour {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let digits = text.strip_prefix('#').filter(|digits| {
            digits.len() == 6 && digits.bytes().all(|byte| byte.is_ascii_hexdigit())
        });
        let number = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok());
        let [_, rgb @ ..] = number
            .ok_or_else(|| format!("{text:?} is no colour such as #6a8f3c"))?
            .to_be_bytes();
        Ok(Self(rgb))
    }
}

impl TryFrom<String> for Colour {
    type Error = String;
    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Colour> for String {
    fn from(Colour([r, g, b]): Colour) -> Self {
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_colour_is_read_as_it_is_written() {
        let colour: Colour = "#6a8F3c".parse().unwrap();
        assert_eq!(colour, Colour([0x6a, 0x8f, 0x3c]));
        assert_eq!(String::from(colour), "#6a8f3c");
        for bad in ["6a8f3c", "#6a8f3", "#6a8f3c0", "#+a8f3c", "green", ""] {
            assert!(bad.parse::<Colour>().is_err(), "{bad}");
        }
    }

    #[test]
    fn mixing_ends_at_both_colours_and_brightness_at_white() {
        let (a, b) = (Colour([0, 100, 255]), Colour([200, 0, 255]));
        assert_eq!((a.mix(b, 0.0), a.mix(b, 1.0)), (a, b));
        assert_eq!(a.mix(b, 0.25), Colour([50, 75, 255]));
        assert_eq!(a.times(2.0), Colour([0, 200, 255]));
    }
}
