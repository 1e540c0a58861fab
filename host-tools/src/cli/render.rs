//! `rho render`: the frame, computed on the PC by the device's own renderer.

use std::path::{Path, PathBuf};

use clap::Args;
use rho_grid::mode::Preset;
use serde_json::json;

use crate::blob_file::BlobFile;
use crate::cli::mode::ModeArgs;
use crate::depth::Depth;
use crate::failure::{Failure, Outcome};
use crate::render;
use crate::view::ViewArgs;

const EXAMPLES: &str = "\
Examples:
  rho render bunny.rho -o frame.png --view near-turned --preset fine
  rho render bunny.rho -o frame.png --depth depth.png --visibility z --footprint splat --json

A preset chooses among the blob's grids by the object's size on the screen, draws discs where the
samples have offsets, else boxes, in eye order, into tones.

The picture has the panel's 5, 6 and 5 bits, widened to 8 by repeating their upper ones; the
device draws the same bits. The depth picture is 16-bit grey with its range in two texts.";

/// Draw a blob as the device does, on the PC
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Render {
    /// A blob that `rho bake` wrote; - for standard input
    #[arg(value_name = "OUT.rho")]
    pub blob: PathBuf,
    /// The PNG to write; - for standard output
    #[arg(short, long, value_name = "F.png")]
    pub output: PathBuf,
    /// Also write the depth of each pixel, a 16-bit PNG
    #[arg(long, value_name = "D.png")]
    pub depth: Option<PathBuf>,
    /// What was drawn as one JSON object on standard output
    #[arg(long)]
    pub json: bool,
    /// No report
    #[arg(short, long)]
    pub quiet: bool,
    /// Where the eye stands.
    #[command(flatten)]
    pub view_args: ViewArgs,
    /// How it is drawn.
    #[command(flatten)]
    pub mode_args: ModeArgs,
}

impl Render {
    /// Runs the command.
    ///
    /// # Errors
    /// Exit 2: the blob cannot be used, the view is out of range, or a file cannot be written.
    pub fn run(&self) -> Outcome {
        let to_stdout = [self.output.as_path()]
            .into_iter()
            .chain(self.depth.as_deref())
            .filter(|path| *path == Path::new("-"))
            .count();
        if to_stdout + usize::from(self.json) > 1 {
            return Err(
                Failure::input("only one output can go to standard output").help("name a file")
            );
        }
        let file = BlobFile::read(&self.blob)?;
        let blob = file.blob()?;
        let camera = self.view_args.camera(Some(&blob))?;
        let mode = self.mode_args.mode(&blob, &camera)?;
        if let Some(warning) = ModeArgs::warning(mode, &blob).filter(|_| !self.quiet) {
            eprintln!("warning: {warning}");
        }
        let drawn = render::render_from(&blob, &camera, self.view_args.towards(Some(&blob)), mode)?;
        let (width, height) = (u32::from(drawn.width), u32::from(drawn.height));
        if let Some(path) = &self.depth {
            let values = drawn.depth.iter().copied().map(f64::from).collect();
            let depth = Depth {
                width,
                height,
                values,
            };
            depth.write(path)?;
        }
        drawn.picture().write(&self.output)?;
        let crc32 = format!("{:08x}", drawn.crc32());
        if self.json {
            println!(
                "{}",
                json!({
                    "width": width,
                    "height": height,
                    "pixels": drawn.pixels(),
                    "frame_crc32": crc32,
                    "visibility": mode.visibility.name(),
                    "footprint": mode.footprint.name(),
                    "reciprocal": mode.reciprocal.name(),
                    "frame": mode.frame.name(),
                    "grid": mode.grid,
                    "fineness": mode.fineness.map(Preset::name),
                    "cell_size": mode.cell_size.to_num::<f64>(),
                })
            );
        } else if !self.quiet {
            eprintln!(
                "{}: {} pixels, CRC {crc32}",
                self.output.display(),
                drawn.pixels()
            );
        }
        Ok(())
    }
}
