//! `rho run`: the frame, drawn by the firmware in QEMU and decoded from the panel's wire.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use rho_viewer::count::Phase;
use rho_viewer::request::{Request, Scene};
use serde_json::json;

use crate::blob_file::BlobFile;
use crate::cli::mode::ModeArgs;
use crate::device::{self, Run};
use crate::failure::{Failure, Outcome};
use crate::firmware::Firmware;
use crate::machine::Machine;
use crate::picture::Picture;
use crate::render;
use crate::view::ViewArgs;

const EXAMPLES: &str = "\
Examples:
  rho run bunny.rho -o frame.png --view near-turned
  rho run bunny.rho --preset fast --view far --json
  rho run --picture test-card -o card.png

A preset chooses among the blob's grids by the object's size on the screen, draws discs where the
samples have offsets, else boxes, in eye order, into tones. Instructions are those of the second of
two frames, exactly, without the shading tables, the tones' colours and the transfer to the panel.";

/// What to draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Subject {
    /// The model
    Model,
    /// Colours, gradients and corner marks: the first image on a new board
    TestCard,
    /// The test card, after code of known lengths that tells whether the counter reads true
    CountLoop,
}

/// Draws a frame with the firmware in QEMU and decodes it from the bytes on the panel's wire
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct RunArgs {
    /// The baked model
    #[arg(value_name = "OUT.rho")]
    model: Option<PathBuf>,
    /// Where the picture goes, as PNG; replaced whole or not at all
    #[arg(short, long, value_name = "F.png")]
    output: Option<PathBuf>,
    /// What to draw
    #[arg(long, value_enum, default_value_t = Subject::Model)]
    picture: Subject,
    /// The firmware's image; without it, it is built from the workspace in this folder
    #[arg(long, value_name = "ELF")]
    firmware: Option<PathBuf>,
    /// The core that draws
    #[arg(long, value_enum, default_value_t = Machine::M3)]
    core: Machine,
    /// How long the device may take, in seconds
    #[arg(long, value_name = "S", default_value = "60", value_parser = seconds)]
    timeout: Duration,
    /// One JSON object on standard output, nothing else
    #[arg(long)]
    json: bool,
    /// The device's log on standard error
    #[arg(short, long)]
    verbose: bool,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    mode: ModeArgs,
}

/// A duration in seconds.
pub(crate) fn seconds(text: &str) -> Result<Duration, String> {
    text.parse()
        .ok()
        .and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
        .filter(|duration| !duration.is_zero())
        .ok_or_else(|| "expected a number of seconds".to_owned())
}

impl RunArgs {
    /// Runs the command.
    ///
    /// # Errors
    /// See [`device::run`]; and when a file cannot be read or written.
    pub fn run(&self) -> Outcome {
        // Before a model is read: a wrong flag should not cost a second.
        self.view.view().camera()?;
        let mut baked = String::new();
        let file = self.model.as_deref().map(BlobFile::read).transpose()?;
        // The device checks it again; here a broken one is told with what to do.
        let blob = file.as_ref().map(BlobFile::blob).transpose()?;
        let request = match (self.picture, &blob) {
            (Subject::TestCard, _) => Request::TestCard,
            (Subject::CountLoop, _) => Request::CountLoop,
            (Subject::Model, None) => {
                return Err(Failure::input("there is no model to draw")
                    .help("name a baked one, or draw the test card: --picture test-card"));
            }
            (Subject::Model, Some(blob)) => {
                let camera = self.view.camera(Some(blob))?;
                let mode = self.mode.mode(blob, &camera)?;
                if let Some(warning) = ModeArgs::warning(mode, blob) {
                    eprintln!("warning: {warning}");
                }
                Request::Model(Scene {
                    camera,
                    light: self.view.towards(Some(blob)),
                    mode,
                })
            }
        };
        if let (Some(file), Some(blob)) = (&file, &blob) {
            let samples: u64 = blob.grids().map(|g| u64::from(g.leaf_samples())).sum();
            baked = format!(", {samples} samples in {} B of flash", file.bytes().len());
        }
        let model = file.as_ref().map(BlobFile::bytes);
        let firmware = Firmware::named_or_built(self.firmware.as_deref(), self.core)?;
        let run = device::run(&firmware, model, &request, self.timeout)?;
        if self.verbose {
            for line in &run.log {
                eprintln!("{line}");
            }
        }
        let run = run.done()?;
        if let Some(output) = &self.output {
            let (width, height) = (run.report.width, run.report.height);
            let picture = match (&request, &blob) {
                (Request::Model(scene), Some(blob)) => {
                    let drawn = (width, height, run.words.as_slice());
                    render::picture(drawn, blob, &scene.camera, scene.light, scene.mode)?
                }
                _ => Picture::from_rgb565(width.into(), height.into(), &run.words),
            };
            picture.write(output)?;
        }
        if self.json {
            println!("{}", self.object(&request, &firmware, model, &run));
        } else {
            println!("{}{}", line(&firmware, &run), baked);
        }
        check_counter(&run)
    }

    fn object(
        &self,
        request: &Request,
        firmware: &Firmware,
        model: Option<&[u8]>,
        run: &Run,
    ) -> serde_json::Value {
        let report = &run.report;
        let phases: serde_json::Map<_, _> = Phase::ALL
            .into_iter()
            .map(|phase| (phase.name().to_owned(), report.phases.get(phase).into()))
            .collect();
        let probes: Vec<_> = report
            .probes
            .iter()
            .map(|probe| json!({ "expected": probe.expected, "counted": probe.counted }))
            .collect();
        let mut object = json!({
            "picture": request.picture(),
            "request": request.to_string(),
            "width": report.width,
            "height": report.height,
            "instructions": report.phases.frame(),
            "instructions_by_phase": phases,
            "pixels": run.pixels(),
            "ram_bytes": firmware.ram_bytes(),
            "stack_bytes": report.stack_bytes,
            "program_bytes": firmware.flash_bytes(),
            "frame_crc32": format!("{:08x}", report.frame_crc32),
            "wire_commands": run.wire_commands,
            "wire_bytes": run.wire_bytes,
            "log": run.log,
        });
        if let Some(model) = model {
            object["model_bytes"] = model.len().into();
        }
        if !probes.is_empty() {
            object["counter"] = probes.into();
        }
        object
    }
}

/// The figures in one line.
fn line(firmware: &Firmware, run: &Run) -> String {
    let report = &run.report;
    format!(
        "{} instructions, {} pixels, {} B RAM + {} B stack, CRC {:08x}",
        report.phases.frame(),
        run.pixels(),
        firmware.ram_bytes(),
        report.stack_bytes,
        report.frame_crc32
    )
}

/// A counter that does not read true makes every figure worthless.
fn check_counter(run: &Run) -> Outcome {
    match run.report.probes.iter().find(|p| p.expected != p.counted) {
        None => Ok(()),
        Some(probe) => Err(Failure::limit(format!(
            "the device counted {} instructions where {} ran",
            probe.counted, probe.expected
        ))),
    }
}
