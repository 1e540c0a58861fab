//! The flags that choose how a frame is drawn.

use clap::Args;
use fixed::traits::ToFixed;
use rho_grid::blob::{Blob, Grid};
use rho_grid::mode::{FootprintMode, FrameMode, Mode, ReciprocalMode, VisibilityMode};
use rho_grid::q::PixelSize;

/// The flags that choose how a frame is drawn; what is not given is [`Mode::default`]'s.
#[derive(Args, Clone, Copy, Debug, Default)]
#[command(next_help_heading = "Mode")]
pub struct ModeArgs {
    /// How the nearest sample of a pixel is found: eye, z
    #[arg(long, value_name = "NAME")]
    visibility: Option<VisibilityMode>,
    /// Which pixels a sample colours: point, splat, box, disc
    #[arg(long, value_name = "NAME")]
    footprint: Option<FootprintMode>,
    /// How 1/w is found: divide, table
    #[arg(long, value_name = "NAME")]
    reciprocal: Option<ReciprocalMode>,
    /// What the frame is kept in: words (RGB565), tones (a byte a pixel; eye order only)
    #[arg(long, value_name = "NAME")]
    frame: Option<FrameMode>,
    /// A cell at most this large on the screen is drawn from its own sample
    #[arg(long, value_name = "PX", value_parser = pixel_size, allow_hyphen_values = true)]
    cell_size: Option<PixelSize>,
}

/// Pixels in steps of 1/256, rounded to nearest.
fn pixel_size(text: &str) -> Result<PixelSize, String> {
    text.parse::<f64>()
        .ok()
        .filter(|size| size.is_finite())
        .and_then(f64::checked_to_fixed)
        .ok_or_else(|| format!("expected 0 to {} pixels, such as 0.5", PixelSize::MAX))
}

impl ModeArgs {
    /// The mode.
    #[must_use]
    pub fn mode(&self) -> Mode {
        let default = Mode::default();
        Mode {
            visibility: self.visibility.unwrap_or(default.visibility),
            footprint: self.footprint.unwrap_or(default.footprint),
            reciprocal: self.reciprocal.unwrap_or(default.reciprocal),
            frame: self.frame.unwrap_or(default.frame),
            cell_size: self.cell_size.unwrap_or(default.cell_size),
        }
    }

    /// What should be known before this mode draws this blob.
    #[must_use]
    pub fn warning(&self, blob: &Blob<'_>) -> Option<&'static str> {
        let centred = |grid: Grid<'_>| grid.layout().offset == 0;
        let discs = self.mode().footprint == FootprintMode::Disc;
        (discs && blob.grids().any(centred)).then_some(
            "this blob's samples have no offsets, and discs at the cells' centres leave holes: \
             bake it with --thin --layout offset, or use --footprint box",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::{Encoding, encode};
    use crate::palette::Palette;
    use crate::sampling::{Separation, Tree, TreeLevel, TreeSample};
    use rho_grid::blob::Layout;

    #[test]
    fn a_cell_size_is_read_to_the_nearest_step() {
        assert_eq!(pixel_size("0.5").unwrap(), PixelSize::from_bits(128));
        assert_eq!(pixel_size("0.002").unwrap(), PixelSize::from_bits(1));
    }

    #[test]
    fn a_cell_size_out_of_range_is_an_error() {
        for text in ["-1", "256", "inf", "NaN", "small"] {
            assert!(pixel_size(text).is_err(), "{text}");
        }
    }

    #[test]
    fn discs_without_offsets_are_warned_of() {
        let discs = ModeArgs {
            footprint: Some(FootprintMode::Disc),
            ..ModeArgs::default()
        };
        for (layout, warned) in [(Layout::MATERIAL, true), (Layout::OFFSET, false)] {
            let file = crate::blob_file::BlobFile::from_bytes(&one_leaf(layout), "leaf");
            let blob = file.blob().unwrap();
            assert_eq!(discs.warning(&blob).is_some(), warned);
            assert_eq!(ModeArgs::default().warning(&blob), None);
        }
    }

    fn one_leaf(layout: Layout) -> Vec<u8> {
        let sample = TreeSample {
            normal: glam::Vec3::Y,
            offset: 0.0,
            colour: [255; 3],
        };
        let level = |masks: &[u128]| TreeLevel {
            samples: vec![sample],
            masks: masks.to_vec(),
        };
        let tree = Tree {
            sequence: vec![2],
            separation: Separation::TwentySix,
            levels: vec![level(&[1]), level(&[])],
        };
        let encoding = Encoding {
            layout,
            palette: Palette::of(std::iter::empty()),
            origin: String::new(),
        };
        encode(&tree, &encoding)
    }

    #[test]
    fn without_flags_the_mode_is_the_default() {
        assert_eq!(ModeArgs::default().mode(), Mode::default());
    }
}
