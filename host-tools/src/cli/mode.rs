//! The flags that choose how a frame is drawn.

use clap::Args;
use fixed::traits::ToFixed;
use rho_grid::mode::{FootprintMode, Mode, ReciprocalMode, VisibilityMode};
use rho_grid::q::PixelSize;

/// The flags that choose how a frame is drawn; what is not given is [`Mode::default`]'s.
#[derive(Args, Clone, Copy, Debug, Default)]
#[command(next_help_heading = "Mode")]
pub struct ModeArgs {
    /// How the nearest sample of a pixel is found: eye, z
    #[arg(long, value_name = "NAME")]
    visibility: Option<VisibilityMode>,
    /// Which pixels a sample colours: point, splat, box
    #[arg(long, value_name = "NAME")]
    footprint: Option<FootprintMode>,
    /// How 1/w is found: divide, table
    #[arg(long, value_name = "NAME")]
    reciprocal: Option<ReciprocalMode>,
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
            cell_size: self.cell_size.unwrap_or(default.cell_size),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn without_flags_the_mode_is_the_default() {
        assert_eq!(ModeArgs::default().mode(), Mode::default());
    }
}
