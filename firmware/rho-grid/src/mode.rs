//! How a frame is drawn: the choices that name a renderer.

use core::fmt;
use core::str::FromStr;

use crate::blob::{Blob, Fineness};
use crate::camera::Camera;
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
    /// A byte a quarter of a pixel, in bands, blended into RGB565 words; for eye order only.
    Quarters,
}

/// How what lies between the light and a sample is found (paper, section 5.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShadowMode {
    /// It is not.
    None,
    /// A shadow map is filled first, then looked up while drawing.
    TwoPass,
    /// The same, but the map of the frame before is kept while neither light nor object has moved.
    Kept,
    /// Cells come in the order in which the light meets them, and the map is filled while drawing; for
    /// one object, against depths.
    OnePass,
}

/// The side of a shadow map in texels: 64, 128 or 256. Texels have two bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapSize(u8);

impl MapSize {
    /// Every size.
    pub const ALL: [Self; 3] = [Self(6), Self(7), Self(8)];
    /// The largest.
    pub const LARGEST: Self = Self(8);

    /// The size of so many texels a side; `None` when there is none.
    #[must_use]
    pub const fn of(side: u16) -> Option<Self> {
        match side {
            64 => Some(Self(6)),
            128 => Some(Self(7)),
            256 => Some(Self(8)),
            _ => None,
        }
    }

    /// Texels a side.
    #[must_use]
    pub const fn side(self) -> u16 {
        1 << self.0
    }

    /// Words of 16 bits that a map of this size needs, a texel each: 8.5 kB, 33 kB or 130 kB. They are
    /// four rows and a splat more than the map has, for splats at its end.
    #[must_use]
    pub const fn words(self) -> usize {
        let side = 1 << self.0;
        (side + LightSplat::LARGEST as usize) * side + LightSplat::LARGEST as usize
    }

    /// The logarithm of its side.
    #[must_use]
    pub(crate) const fn bits(self) -> u32 {
        self.0 as u32
    }
}

/// The side of the splats that samples lay into a shadow map, 1 to 4 texels: the larger, the coarser
/// the grid that casts shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightSplat(u8);

impl LightSplat {
    /// The largest side.
    pub const LARGEST: u32 = 4;

    /// A side of so many texels; `None` when it is 0 or above [`Self::LARGEST`].
    #[must_use]
    pub const fn of(texels: u16) -> Option<Self> {
        if texels == 0 || texels as u32 > Self::LARGEST {
            return None;
        }
        Some(Self(texels as u8))
    }

    /// Texels along a side.
    #[must_use]
    pub const fn texels(self) -> u32 {
        self.0 as u32
    }
}

/// A tuple of choices by name: how fine a picture, and all that draws it fastest.
///
/// A preset chooses among the grids of a blob. The finer a cell on the screen, the nearer the
/// silhouette; how much that shows depends on the whole object's size there. With cells in
/// proportion to the square root of that size, quality falls slowly as the object recedes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// The fewest instructions for a picture without holes.
    Fast,
    /// Between the two.
    Balanced,
    /// A cell is about a pixel.
    Fine,
    /// In quarters of pixels, blended, from cells a little smaller than those of [`Preset::Fine`].
    Finest,
}

impl Preset {
    /// The number of cells an axis over the square root of the cube's side in pixels, times 10.
    const fn fineness(self) -> u64 {
        match self {
            Self::Fast => 55,
            Self::Balanced => 73,
            Self::Fine => 92,
            Self::Finest => 147,
        }
    }

    /// How this preset draws `blob` as `camera` sees it.
    #[must_use]
    pub fn mode(self, blob: &Blob<'_>, camera: &Camera) -> Mode {
        let index = choose(blob.finenesses(0..blob.grid_count()), self.cells(camera));
        let discs = blob.grid(index).is_none_or(|grid| grid.layout().offset > 0);
        Mode {
            visibility: VisibilityMode::Eye,
            // Of a scene, grids without offsets are drawn in boxes, one by one.
            footprint: if discs || blob.is_scene() {
                FootprintMode::Disc
            } else {
                FootprintMode::Box
            },
            reciprocal: ReciprocalMode::Divide,
            frame: match self {
                Self::Finest => FrameMode::Quarters,
                _ => FrameMode::Tones,
            },
            grid: if blob.is_scene() { 0 } else { index },
            fineness: blob.is_scene().then_some(self),
            ..Mode::default()
        }
    }

    /// Cells an axis, rounded up, that a cube at the origin should have.
    #[must_use]
    pub fn cells(self, camera: &Camera) -> u32 {
        let [_, _, z] = camera.translation;
        // Q20, at least half a cube's side away.
        let distance = u64::from(z.to_bits().unsigned_abs()).max(1 << 19);
        // Q16 pixels; a focal length has 32 bits.
        let side = (u64::from(camera.focal.to_bits()) << 24) / distance;
        // Q8.
        let root = side.isqrt();
        (root * self.fineness()).div_ceil(2560) as u32
    }
}

/// The number, among `grids`, of the coarsest that has as many cells an axis, else of the finest; 0
/// when there are none.
///
/// Fine enough is also what has as many leaves as a surface would have with two a square of
/// the cells wanted: foliage fills its cube, and a finer grid of it would only draw more samples into
/// the same pixels.
#[must_use]
pub fn choose(grids: impl Iterator<Item = Fineness>, cells: u32) -> u16 {
    let fitting = |grid: &Fineness| {
        let here = grid.cells;
        let dense = u64::from(grid.leaves) >= 2 * u64::from(cells).pow(2);
        // The coarsest that is fine enough, else the finest.
        let fine = here >= cells || dense;
        (!fine, if fine { here } else { u32::MAX - here })
    };
    let best = grids.enumerate().min_by_key(|(_, grid)| fitting(grid));
    best.map_or(0, |(index, _)| index as u16)
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
    /// Which of the blob's grids is drawn; of each object of a scene its own, or its last one.
    pub grid: u16,
    /// Each instance of a scene is drawn in the grid that this chooses by its size on the screen;
    /// in [`Self::grid`] if none.
    pub fineness: Option<Preset>,
    /// A cell whose projection is at most this large is drawn from its own sample, its
    /// subcells are not visited.
    pub cell_size: PixelSize,
    /// How shadows are found.
    pub shadows: ShadowMode,
    /// The shadow map's size.
    pub shadow_map: MapSize,
    /// How large the splats in it are.
    pub light_splat: LightSplat,
}

impl Mode {
    /// Why this is no way to draw, if it is none.
    #[must_use]
    pub fn contradiction(&self) -> Option<&'static str> {
        let words = self.frame == FrameMode::Words;
        let filled = matches!(self.footprint, FootprintMode::Box | FootprintMode::Disc);
        if !words && self.visibility == VisibilityMode::Z {
            return Some("a frame of tones or quarters is drawn in eye order alone");
        }
        if !words && !filled {
            return Some("a frame of tones or quarters is drawn in boxes or discs");
        }
        if self.shadows == ShadowMode::OnePass && self.visibility == VisibilityMode::Eye {
            return Some("shadows in one pass come in the order of the light, against depths");
        }
        let may_look_up = words && self.shadows == ShadowMode::None;
        if self.reciprocal == ReciprocalMode::Table && !may_look_up {
            return Some("the table of reciprocals serves frames of words without shadows");
        }
        None
    }
}

impl Default for Mode {
    fn default() -> Self {
        Self {
            visibility: VisibilityMode::Eye,
            footprint: FootprintMode::Box,
            reciprocal: ReciprocalMode::Divide,
            frame: FrameMode::Words,
            grid: 0,
            fineness: None,
            cell_size: PixelSize::from_bits(128),
            shadows: ShadowMode::None,
            shadow_map: MapSize(7),
            light_splat: LightSplat(2),
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
    Preset, "fast, balanced, fine, finest",
    Preset::Fast => "fast", Preset::Balanced => "balanced", Preset::Fine => "fine",
    Preset::Finest => "finest"
);
names!(
    FrameMode, "words, tones, quarters",
    FrameMode::Words => "words", FrameMode::Tones => "tones", FrameMode::Quarters => "quarters"
);
names!(
    ShadowMode, "none, two-pass, kept, one-pass",
    ShadowMode::None => "none", ShadowMode::TwoPass => "two-pass", ShadowMode::Kept => "kept",
    ShadowMode::OnePass => "one-pass"
);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::q::{Focal, Length, Rotation};

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
        for v in Preset::ALL {
            assert_eq!(v.name().parse(), Ok(*v));
        }
        for v in ShadowMode::ALL {
            assert_eq!(v.name().parse(), Ok(*v));
        }
        for v in FrameMode::ALL {
            assert_eq!(v.name().parse(), Ok(*v));
        }
    }

    #[test]
    fn an_object_four_times_as_far_wants_half_the_cells() {
        let camera = |distance: f64| Camera {
            rotation: [[Rotation::ZERO; 3]; 3],
            translation: [Length::ZERO, Length::ZERO, Length::from_num(-distance)],
            focal: Focal::from_num(386.27),
            width: 240,
            height: 320,
        };
        let cells = |preset: Preset| [2.2883, 9.1532].map(|d| preset.cells(&camera(d)));
        assert_eq!(cells(Preset::Fast), [72, 36]);
        assert_eq!(cells(Preset::Balanced), [95, 48]);
        assert_eq!(cells(Preset::Fine), [120, 60]);
        assert_eq!(cells(Preset::Finest), [191, 96]);
        // At and in the cube, and at any zoom, there is an answer.
        assert_eq!(
            Preset::Fine.cells(&camera(0.0)),
            Preset::Fine.cells(&camera(0.5))
        );
    }

    #[test]
    fn every_preset_is_a_way_to_draw_and_contradictions_are_not() {
        let words = Mode::default();
        let tones = Mode {
            frame: FrameMode::Tones,
            ..words
        };
        let table = Mode {
            reciprocal: ReciprocalMode::Table,
            ..words
        };
        for mode in [words, tones, table] {
            assert_eq!(mode.contradiction(), None);
        }
        let z = Mode {
            visibility: VisibilityMode::Z,
            ..tones
        };
        let points = Mode {
            footprint: FootprintMode::Point,
            ..tones
        };
        let divided = Mode {
            reciprocal: ReciprocalMode::Table,
            ..tones
        };
        for mode in [z, points, divided] {
            assert!(mode.contradiction().is_some(), "{mode:?}");
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
