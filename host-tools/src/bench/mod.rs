//! Measures ways to draw the same views: what they cost on the device and how near they come.
//!
//! [`rows`] lists the ways, [`table`] prints what was measured.

pub mod rows;
pub mod table;

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Parser;
use rho_grid::mode::Mode;
use rho_viewer::count::{Phase, Phases};
use rho_viewer::request::{Request, Scene};

use crate::blob_file::BlobFile;
use crate::cli::Rho;
use crate::cli::mode::ModeArgs;
use crate::compare::{Comparison, compare};
use crate::device::{self, Run};
use crate::failure::{Failure, Outcome};
use crate::firmware::Firmware;
use crate::machine::Machine;
use crate::mesh::Mesh;
use crate::model::{self, LoadOptions, Up};
use crate::peer;
use crate::picture::Picture;
use crate::profile::{Profile, Work};
use crate::qemu::Job;
use crate::reference::{Caster, Shot};
use crate::render;
use crate::view::{STANDARD_LIGHT, View};
use rows::{Row, Way};

/// More than the slowest peer takes.
const TIMEOUT: Duration = Duration::from_secs(600);

/// What a frame costs and how near it comes to the truth.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Instructions of the second frame.
    pub phases: Phases,
    /// The same by kind and core; `None` without the plugin.
    pub work: Option<Work>,
    /// Pixels drawn.
    pub pixels: usize,
    /// Against 25 rays a pixel.
    pub comparison: Comparison,
    /// The model in flash, in bytes.
    pub model_bytes: usize,
    /// Statics, in bytes.
    pub ram_bytes: u64,
    /// The deepest stack, in bytes.
    pub stack_bytes: u32,
    /// Code and constants, in bytes.
    pub program_bytes: u64,
}

/// A row of the table in one view.
#[derive(Clone, Debug)]
pub struct Figure {
    /// The row's name.
    pub row: &'static str,
    /// The view's name.
    pub view: String,
    /// What was measured.
    pub measured: Measured,
}

/// A way to draw, made ready: its program built, its model in the form that it takes.
#[derive(Debug)]
pub struct Ready {
    /// The way.
    pub row: Row,
    firmware: Firmware,
    /// A blob, or what a peer takes.
    model: BlobFile,
    flags: ModeArgs,
}

/// The flags of `rho run` that a row may have.
#[derive(Debug, Parser)]
struct RunFlags {
    #[command(flatten)]
    mode: ModeArgs,
}

/// The model of all rows.
#[derive(Debug)]
pub struct Subject {
    /// Where it lies.
    pub path: PathBuf,
    /// Which way is up in it.
    pub up: Up,
    /// Its triangles.
    pub mesh: Mesh,
}

impl Subject {
    /// Reads a scan; see [`model::scan`].
    ///
    /// # Errors
    /// Those of [`model::scan`] and [`model::load`].
    pub fn scan(name: &str, up: Up) -> Outcome<Self> {
        let path = model::scan(name)?;
        let options = LoadOptions {
            up,
            ..LoadOptions::default()
        };
        let mesh = model::load(&path, &options)?.mesh;
        Ok(Self { path, up, mesh })
    }
}

impl Ready {
    /// Builds the program and makes the model.
    ///
    /// # Errors
    /// Those of the commands that a row stands for.
    pub fn new(
        row: Row,
        machine: Machine,
        subject: &Subject,
        folder: &Path,
        target_dir: Option<&Path>,
    ) -> Outcome<Self> {
        let program = row.way.package(machine).build(folder, target_dir)?;
        let firmware = Firmware::open(&program, machine)?;
        let (model, run) = match row.way {
            Way::Renderer { bake, run } => (
                bake_with(subject.path.clone().into(), subject.up, bake)?,
                run,
            ),
            Way::Points(_) => (peer::points(&subject.mesh), ""),
            Way::Triangles(_, most) if most >= subject.mesh.triangles.len() => {
                (peer::triangles(&subject.mesh), "")
            }
            Way::Triangles(_, most) => {
                let small = peer::decimated(&subject.mesh, most);
                (peer::triangles(&small), "")
            }
        };
        let words = std::iter::once("run").chain(run.split_whitespace());
        let flags = RunFlags::try_parse_from(words).map_err(|e| Failure::input(e.to_string()))?;
        Ok(Self {
            row,
            firmware,
            model: BlobFile::from_bytes(&model, row.name),
            flags: flags.mode,
        })
    }

    /// Bytes of the model in flash.
    #[must_use]
    pub fn model_bytes(&self) -> usize {
        self.model.bytes().len()
    }

    /// Draws a view.
    ///
    /// # Errors
    /// Those of [`device::answer`], and what the device refuses.
    pub fn draw(&self, view: &View, plugin: Option<&Path>) -> Outcome<Run> {
        let camera = view.camera()?;
        let mode = self.mode(view)?;
        let request = Request::Model(Scene {
            camera,
            light: render::light(STANDARD_LIGHT),
            mode,
        });
        device::answer(&Job {
            firmware: &self.firmware,
            model: Some(self.model.bytes()),
            request: &request.line(),
            timeout: TIMEOUT,
            plugin,
        })
        .and_then(Run::done)
        .map_err(|failure| Failure {
            message: format!("{}: {}", self.row.name, failure.message),
            ..failure
        })
    }

    /// How a view is drawn.
    fn mode(&self, view: &View) -> Outcome<Mode> {
        match self.row.way {
            Way::Renderer { .. } => self.flags.mode(&self.model.blob()?, &view.camera()?),
            // Peers have one.
            Way::Points(_) | Way::Triangles(..) => Ok(Mode::default()),
        }
    }

    /// Draws a view and compares it with the truth.
    ///
    /// # Errors
    /// Those of [`Ready::draw`] and [`Profile::new`].
    pub fn measure(
        &self,
        view: &View,
        truth: &Picture,
        plugin: Option<&Path>,
    ) -> Outcome<Measured> {
        let run = self.draw(view, plugin)?;
        let work = plugin
            .map(|_| Profile::new(&self.firmware, &run))
            .transpose()?
            .map(|profile| profile.total(Phase::is_part_of_a_frame));
        let drawn = (run.report.width, run.report.height, run.words.as_slice());
        let picture = match self.row.way {
            Way::Renderer { .. } => {
                let (blob, mode) = (self.model.blob()?, self.mode(view)?);
                let light = render::light(STANDARD_LIGHT);
                render::picture(drawn, &blob, &view.camera()?, light, mode)?
            }
            Way::Points(_) | Way::Triangles(..) => {
                let (width, height, words) = drawn;
                Picture::from_rgb565(width.into(), height.into(), words)
            }
        };
        Ok(Measured {
            phases: run.report.phases,
            work,
            pixels: run.pixels(),
            comparison: compare(&picture, truth, [0; 3], None)?,
            model_bytes: self.model_bytes(),
            ram_bytes: self.firmware.ram_bytes(),
            stack_bytes: run.report.stack_bytes,
            program_bytes: self.firmware.flash_bytes(),
        })
    }
}

/// The blob that `rho bake` makes of a source with these flags.
///
/// # Errors
/// Those of the command.
pub fn bake_with(source: OsString, up: Up, flags: &str) -> Outcome<Vec<u8>> {
    let scratch = |error: std::io::Error| {
        Failure::missing(format!("no room for temporary files: {error}"))
            .help("free some space, or set TMPDIR to a folder that has some")
    };
    let folder = tempfile::tempdir().map_err(scratch)?;
    let blob = folder.path().join("model.rho");
    let fixed = ["rho", "bake", "--quiet", "-o"].map(Into::into);
    let paths = [blob.clone().into_os_string(), source];
    let up = match up {
        Up::Y => "--up y",
        Up::Z => "--up z",
    };
    let more = [flags, up].map(str::split_whitespace);
    let words = fixed
        .into_iter()
        .chain(paths)
        .chain(more.into_iter().flatten().map(Into::into));
    let command = Rho::try_parse_from(words).map_err(|e| Failure::input(e.to_string()))?;
    command.run()?;
    std::fs::read(&blob).map_err(scratch)
}

/// The truth of each view.
///
/// # Errors
/// When a view is out of range.
pub fn truths(mesh: &Mesh, views: &[View]) -> Outcome<Vec<Picture>> {
    let caster = Caster::new(mesh);
    views
        .iter()
        .map(|view| Ok(caster.render(&Shot::standard(*view), &|| ())?.picture))
        .collect()
}

/// The figures of a page of tables that [`table`] printed, by the names of row and view: the
/// instructions, and the model's bytes under `all views`.
#[must_use]
pub fn committed(page: &str) -> BTreeMap<(String, String), u64> {
    page.split("\n## ")
        .filter(|section| {
            [table::COST, table::MEMORY]
                .iter()
                .any(|t| section.starts_with(t))
        })
        .flat_map(str::lines)
        .filter_map(|line| {
            let mut cells = line.strip_prefix("| ")?.split(" | ");
            let key = (cells.next()?.to_owned(), cells.next()?.to_owned());
            let number = cells.next()?.replace(',', "").parse().ok()?;
            Some((key, number))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_read_from_the_tables_that_hold_them() {
        let page = "# Page\n\n## Cost and quality\n\n| what | view | instructions | setup |\n\
            | --- | --- | ---: | ---: |\n| a, b | near | 1,234,567 | 8 |\n\n## Memory, bytes\n\n\
            | a, b | all views | 90 | 8 |\n\n## Other cores\n\n| a, b | near | 1 | 2 |\n";
        let expected = [("all views", 90), ("near", 1_234_567)];
        let expected = expected.map(|(of, n)| (("a, b".to_owned(), of.to_owned()), n));
        assert_eq!(committed(page), BTreeMap::from(expected));
    }
}
