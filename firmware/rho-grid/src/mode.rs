//! How a frame is drawn: the choices that name a renderer.

use core::fmt;
use core::str::FromStr;

use crate::q::PixelSize;

/// How the nearest sample of a pixel is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VisibilityMode {
    /// Cells from front to back; the first sample keeps the pixel (one coverage bit a pixel).
    Eye,
    /// Cells in any order against a depth buffer.
    Z,
}

/// Which pixels a sample colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FootprintMode {
    /// The pixel in which its centre lies.
    Point,
    /// A square as large as its cell, round its centre.
    Splat,
    /// Every pixel whose centre lies in the projected bounds of its cell.
    Box,
    /// Every pixel whose centre lies in a disc in its tangent plane, moved by its offset.
    Disc,
}

/// How 1/w is found; both give the same integer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReciprocalMode {
    /// The core's divide instruction.
    Divide,
    /// A shifted table with one correction, for cores without a divider.
    Table,
}

/// What a frame is kept in while it is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameMode {
    /// RGB565 words.
    Words,
    /// A byte a pixel, an index of 128 tones; for eye order only.
    Tones,
}

/// A renderer and its one threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mode {
    /// How the nearest sample of a pixel is found.
    pub visibility: VisibilityMode,
    /// Which pixels a sample colours.
    pub footprint: FootprintMode,
    /// How 1/w is found.
    pub reciprocal: ReciprocalMode,
    /// What the frame is kept in.
    pub frame: FrameMode,
    /// A cell whose projection is at most this large is drawn from its own sample, its
    /// subcells are not visited.
    pub cell_size: PixelSize,
}

impl Default for Mode {
    fn default() -> Self {
        Self {
            visibility: VisibilityMode::Eye,
            footprint: FootprintMode::Box,
            reciprocal: ReciprocalMode::Divide,
            frame: FrameMode::Words,
            cell_size: PixelSize::from_bits(128),
        }
    }
}

/// The text names no such choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownName {
    /// The names there are, for the message.
    pub expected: &'static str,
}

impl fmt::Display for UnknownName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "expected one of: {}", self.expected)
    }
}

impl core::error::Error for UnknownName {}

/// Gives an enum its names on the command line, both ways.
macro_rules! names {
    ($type:ty, $all:literal, $($variant:path => $name:literal),+) => {
        impl $type {
            /// Every choice, in the order of the documentation.
            pub const ALL: &'static [Self] = &[$($variant),+];

            /// The name on the command line.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $($variant => $name),+ }
            }
        }

        impl FromStr for $type {
            type Err = UnknownName;
            fn from_str(text: &str) -> Result<Self, UnknownName> {
                match text {
                    $($name => Ok($variant),)+
                    _ => Err(UnknownName { expected: $all }),
                }
            }
        }

        impl fmt::Display for $type {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}

names!(VisibilityMode, "eye, z", VisibilityMode::Eye => "eye", VisibilityMode::Z => "z");
names!(
    FootprintMode, "point, splat, box, disc",
    FootprintMode::Point => "point", FootprintMode::Splat => "splat",
    FootprintMode::Box => "box", FootprintMode::Disc => "disc"
);
names!(
    ReciprocalMode, "divide, table",
    ReciprocalMode::Divide => "divide", ReciprocalMode::Table => "table"
);
names!(
    FrameMode, "words, tones", FrameMode::Words => "words", FrameMode::Tones => "tones"
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_reads_back_as_itself() {
        for v in VisibilityMode::ALL {
            assert_eq!(v.name().parse(), Ok(*v));
        }
        for v in FootprintMode::ALL {
            assert_eq!(v.name().parse(), Ok(*v));
        }
        for v in ReciprocalMode::ALL {
            assert_eq!(v.name().parse(), Ok(*v));
        }
        for v in FrameMode::ALL {
            assert_eq!(v.name().parse(), Ok(*v));
        }
    }

    #[test]
    fn an_unknown_name_is_an_error_that_lists_the_known_ones() {
        assert_eq!(
            "disk".parse::<FootprintMode>().unwrap_err().expected,
            "point, splat, box, disc"
        );
    }
}
