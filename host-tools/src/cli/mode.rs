//! The flags that choose how a frame is drawn.

use clap::Args;
use fixed::traits::ToFixed;
use rho_grid::blob::{Blob, Grid};
use rho_grid::camera::Camera;
use rho_grid::mode::{
    FootprintMode, FrameMode, LightSplat, MapSize, Mode, Preset, ReciprocalMode, ShadowMode,
    VisibilityMode,
};
use rho_grid::q::PixelSize;

use crate::failure::{Failure, Outcome};

/// The flags that choose how a frame is drawn.
#[derive(Args, Clone, Copy, Debug, Default)]
#[command(next_help_heading = "Mode")]
pub struct ModeArgs {
    /// How fine, by a name for all of the following: fast, balanced, fine, finest [default: balanced]; a
    /// flag beside it overrides its part
    #[arg(long, value_name = "NAME")]
    preset: Option<Preset>,
    /// Which grid of a blob that has several, counted from 0 as `rho info` does; of a scene, of each
    /// object's grids [default: by the object's size on the screen]
    #[arg(long, value_name = "N")]
    grid: Option<u16>,
    /// How the nearest sample of a pixel is found: eye, z
    #[arg(long, value_name = "NAME")]
    visibility: Option<VisibilityMode>,
    /// Which pixels a sample colours: point, splat, box, disc
    #[arg(long, value_name = "NAME")]
    footprint: Option<FootprintMode>,
    /// How 1/w is found: divide, table
    #[arg(long, value_name = "NAME")]
    reciprocal: Option<ReciprocalMode>,
    /// What the frame is kept in: words (RGB565), tones (a byte a pixel; eye order only), quarters (a
    /// byte a quarter of a pixel, blended; eye order only)
    #[arg(long, value_name = "NAME")]
    frame: Option<FrameMode>,
    /// A cell at most this large on the screen is drawn from its own sample
    #[arg(long, value_name = "PX", value_parser = pixel_size, allow_hyphen_values = true)]
    cell_size: Option<PixelSize>,
    /// How shadows are found: none, two-pass (a shadow map is filled, then looked up), kept (the
    /// same, but the map stays while light and object do), one-pass (the map is filled while drawing
    /// an object in the order of the light, against depths; of a scene, objects shade those that are
    /// drawn after them) [default: none]
    #[arg(long, value_name = "NAME")]
    shadows: Option<ShadowMode>,
    /// Texels of the shadow map along a side: 64, 128, 256 [default: 128]
    #[arg(long, value_name = "N", value_parser = map_size)]
    shadow_map: Option<MapSize>,
    /// Texels along a side of the splats in it, 1 to 4; the larger, the coarser the grid that casts
    /// shadows [default: 2]
    #[arg(long, value_name = "N", value_parser = light_splat)]
    light_splat: Option<LightSplat>,
}

/// Texels along a side of a shadow map.
fn map_size(text: &str) -> Result<MapSize, String> {
    let size = text.parse().ok().and_then(MapSize::of);
    size.ok_or_else(|| "expected 64, 128 or 256".to_owned())
}

/// Texels along a side of a splat in it.
fn light_splat(text: &str) -> Result<LightSplat, String> {
    let splat = text.parse().ok().and_then(LightSplat::of);
    splat.ok_or_else(|| format!("expected 1 to {}", LightSplat::LARGEST))
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
    /// The mode in which `blob` is drawn as `camera` sees it.
    ///
    /// # Errors
    /// When the flags contradict each other.
    pub fn mode(&self, blob: &Blob<'_>, camera: &Camera) -> Outcome<Mode> {
        let preset = self.preset.unwrap_or(Preset::Balanced);
        let preset = preset.mode(blob, camera);
        let shadows = self.shadows.unwrap_or(preset.shadows);
        let one_pass = shadows == ShadowMode::OnePass;
        let visibility = match (self.visibility, one_pass) {
            (Some(VisibilityMode::Eye), true) => {
                return Err(Failure::input(
                    "shadows in one pass come in the order of the light, not of the eye",
                )
                .help("leave --visibility eye away, or take --shadows two-pass"));
            }
            (Some(visibility), _) => visibility,
            (None, true) => VisibilityMode::Z,
            (None, false) => preset.visibility,
        };
        let frame = match (visibility, self.frame) {
            (_, Some(frame)) => frame,
            (VisibilityMode::Eye, None) if self.is_for_words() => FrameMode::Words,
            (VisibilityMode::Eye, None) => preset.frame,
            (VisibilityMode::Z, None) => FrameMode::Words,
        };
        let mode = Mode {
            visibility,
            footprint: self.footprint.unwrap_or(preset.footprint),
            reciprocal: self.reciprocal.unwrap_or(preset.reciprocal),
            frame,
            grid: self.grid.unwrap_or(preset.grid),
            fineness: preset.fineness.filter(|_| self.grid.is_none()),
            cell_size: self.cell_size.unwrap_or(preset.cell_size),
            shadows,
            shadow_map: self.shadow_map.unwrap_or(preset.shadow_map),
            light_splat: self.light_splat.unwrap_or(preset.light_splat),
        };
        match mode.contradiction() {
            Some(why) => Err(Failure::input(why)
                .help("leave that flag away, or take --frame words (and no --shadows)")),
            None => Ok(mode),
        }
    }

    /// Whether a flag asks for what only frames of words have.
    fn is_for_words(&self) -> bool {
        let small = [FootprintMode::Point, FootprintMode::Splat].map(Some);
        small.contains(&self.footprint) || self.reciprocal == Some(ReciprocalMode::Table)
    }

    /// What should be known before this mode draws this blob.
    #[must_use]
    pub fn warning(mode: Mode, blob: &Blob<'_>) -> Option<&'static str> {
        let centred = |grid: Grid<'_>| grid.layout().offset == 0;
        let discs = mode.footprint == FootprintMode::Disc;
        (discs && mode.fineness.is_none() && blob.grid(mode.grid).is_some_and(centred)).then_some(
            "this blob's samples have no offsets, and discs at the cells' centres leave holes: \
             bake it with --thin --layout offset, or use --footprint box",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blob_file::BlobFile;
    use crate::encode::{Encoding, encode};
    use crate::palette::Palette;
    use crate::sampling::{Separation, Tree, TreeLevel, TreeSample};
    use crate::view::{StandardView, View};
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
        let camera = View::from(StandardView::Near).camera();
        for (layout, warned) in [(Layout::MATERIAL, true), (Layout::OFFSET, false)] {
            let file = BlobFile::from_bytes(&one_leaf(layout), "leaf");
            let blob = file.blob().unwrap();
            let discs = Mode {
                footprint: FootprintMode::Disc,
                ..Mode::default()
            };
            assert_eq!(ModeArgs::warning(discs, &blob).is_some(), warned);
            // Presets choose what the samples allow.
            let preset = ModeArgs::default().mode(&blob, camera.as_ref().unwrap());
            assert_eq!(ModeArgs::warning(preset.unwrap(), &blob), None);
        }
    }

    #[test]
    fn a_flag_overrides_the_preset_and_depths_need_words() {
        let camera = View::from(StandardView::Near).camera().unwrap();
        let file = BlobFile::from_bytes(&one_leaf(Layout::OFFSET), "leaf");
        let blob = file.blob().unwrap();
        let flags = ModeArgs {
            visibility: Some(VisibilityMode::Z),
            footprint: Some(FootprintMode::Splat),
            ..ModeArgs::default()
        };
        let mode = flags.mode(&blob, &camera).unwrap();
        assert_eq!(mode.visibility, VisibilityMode::Z);
        assert_eq!(mode.footprint, FootprintMode::Splat);
        assert_eq!(mode.frame, FrameMode::Words);
        let tones = ModeArgs {
            frame: Some(FrameMode::Tones),
            ..flags
        };
        let failure = tones.mode(&blob, &camera).unwrap_err();
        assert!(failure.message.contains("eye order"), "{failure}");
    }

    fn one_leaf(layout: Layout) -> Vec<u8> {
        let sample = TreeSample {
            normal: glam::Vec3::Y,
            offset: 0.0,
            colour: [255; 3],
            mean: [255; 3],
            two_sided: false,
            shaded: false,
        };
        let level = |masks: &[u128]| TreeLevel {
            samples: vec![sample],
            masks: masks.to_vec(),
        };
        let tree = Tree {
            sequence: vec![2],
            separation: Separation::TwentySix,
            rims: None,
            levels: vec![level(&[1]), level(&[])],
        };
        let encoding = Encoding {
            layout,
            palette: Palette::of(std::iter::empty()),
            origin: String::new(),
        };
        encode(&tree, &encoding)
    }
}
