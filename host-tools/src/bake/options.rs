//! What a bake can be asked for, and what it does without being asked.

use std::path::PathBuf;

use glam::DVec3;
use rho_grid::blob::Layout;

use crate::model::LoadOptions;
use crate::sampling::{Separation, Sequence};
use crate::source::Model;

/// How a model is baked.
#[derive(Clone, Debug, PartialEq)]
pub struct BakeOptions {
    /// How the cube is cut.
    pub grid: GridChoice,
    /// Which cells are leaves.
    pub separation: Separation,
    /// What a sample's word holds.
    pub layout: LayoutChoice,
    /// Which nodes have samples.
    pub samples: SampleChoice,
    /// Towards the light whose shadows are baked, if there are to be any: in the model's axes, of any length.
    pub shadows: Option<DVec3>,
    /// How the model is read; its memory limit is that of the whole bake.
    pub load: LoadOptions,
    /// Where a model is looked for that is not in the current folder.
    pub models: Option<PathBuf>,
}

impl Default for BakeOptions {
    /// 243 cells an axis by 3,3,3,3,3, each that the surface meets, with materials.
    fn default() -> Self {
        Self {
            grid: GridChoice::Fixed(vec![
                Sequence::new(&[3; 5]).unwrap_or_else(|_| unreachable!()),
            ]),
            separation: Separation::TwentySix,
            layout: LayoutChoice::Material,
            samples: SampleChoice::All,
            shadows: None,
            load: LoadOptions::default(),
            models: None,
        }
    }
}

/// The grids of [`BakeOptions::standard`]: 48, 60, 72, 96, 108 and 144 cells an axis, for the presets. Blocks
/// have as many parents as can be stamped together, since each costs as much as ten of them: 4 x 4 x 4, but of cells
/// as large as `fast` draws near.
const STANDARD: [&[u8]; 6] = [
    &[4, 4, 3],
    &[4, 5, 3],
    &[2, 4, 3, 3],
    &[2, 4, 4, 3],
    &[3, 3, 4, 3],
    &[4, 3, 4, 3],
];

impl BakeOptions {
    /// What serves the presets best: thin grids of discs for every distance, as many as fit into
    /// `flash` bytes. A model in several colours gives up two bits of the normal and one of the offset
    /// for one of eight materials; so does one with baked shadows.
    pub(super) fn standard(model: &Model, flash: Option<u64>, given: Self) -> Self {
        let sequences = STANDARD.map(|s| Sequence::new(s).unwrap_or_else(|_| unreachable!()));
        let sequences = sequences.to_vec();
        Self {
            grid: match flash {
                Some(flash) => GridChoice::Fits(sequences, flash),
                None => GridChoice::Fixed(sequences),
            },
            separation: Separation::Six,
            layout: if model.is_coloured() || given.shadows.is_some() {
                LayoutChoice::Both
            } else {
                LayoutChoice::Offset
            },
            samples: SampleChoice::Leaves,
            ..given
        }
    }
}

/// How the cube is cut.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GridChoice {
    /// As the presets want it, within so many bytes; leaves, layout and samples follow.
    Standard(Option<u64>),
    /// By each of these sequences, one grid each.
    Fixed(Vec<Sequence>),
    /// By those of these sequences that fit into so many bytes together: while they do not,
    /// the finest is left out. One must fit.
    Fits(Vec<Sequence>, u64),
    /// As finely as fits into so many bytes, by a power of rho, or else by any sequence of
    /// [`flash::mixed`](crate::flash::mixed).
    Finest(Option<u8>, u64),
}

/// What a sample's word holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum LayoutChoice {
    /// A normal of 13 bits and one of 8 materials
    #[default]
    Material,
    /// A normal of 13 bits and an offset of 3 along it
    Offset,
    /// A normal of 11 bits, an offset of 2 along it and one of 8 materials
    Both,
    /// 32 bits: a normal of 13, an offset of 3 along it and a colour of 16
    Colour,
}

impl LayoutChoice {
    /// The layout; offsets reach as far as leaves of this separation need them.
    #[must_use]
    pub fn layout(self, separation: Separation) -> Layout {
        match (self, separation) {
            (Self::Material, _) => Layout::MATERIAL,
            (Self::Offset, Separation::Six) => Layout::OFFSET_THIN,
            (Self::Offset, Separation::TwentySix) => Layout::OFFSET,
            (Self::Both, Separation::Six) => Layout::BOTH_THIN,
            (Self::Both, Separation::TwentySix) => Layout::BOTH,
            (Self::Colour, Separation::Six) => Layout::COLOUR_THIN,
            (Self::Colour, Separation::TwentySix) => Layout::COLOUR,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Material => "material",
            Self::Offset => "offset",
            Self::Both => "both",
            Self::Colour => "colour",
        }
    }
}

/// Which nodes of a grid have samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum SampleChoice {
    /// All: what is small on the screen is drawn from fewer samples
    #[default]
    All,
    /// The leaves alone: a tenth smaller, for grids of which each serves one distance
    Leaves,
}
