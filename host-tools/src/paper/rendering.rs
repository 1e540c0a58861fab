//! Table 5 and the figures: what the device draws, and what it costs.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Parser;
use rho_grid::mode::Mode;
use rho_viewer::request::{Request, Scene};

use super::models::{MODELS, PaperModel, tri_grid};
use super::table;
use crate::bench::bake_with;
use crate::blob_file::BlobFile;
use crate::cli::mode::ModeArgs;
use crate::device::{self, Run};
use crate::failure::{Failure, Outcome};
use crate::firmware::Firmware;
use crate::machine::Machine;
use crate::model::{self, Up};
use crate::picture::Picture;
use crate::render;
use crate::text::size;
use crate::view::{STANDARD_LIGHT, StandardView, View};

/// Section 5.1: every leaf a point, against a depth buffer.
pub const POINTS: &str = "--visibility z --footprint point --cell-size 0";
/// The same with shadows in two passes.
const SHADOWED_POINTS: &str =
    "--visibility z --footprint point --cell-size 0 --shadows two-pass --shadow-map 256";
/// The same in one, by light order: the six additions of section 5.4.
pub const ONE_PASS: &str =
    "--visibility z --footprint point --cell-size 0 --shadows one-pass --shadow-map 256";
/// Section 5.2: a cell below a pixel is drawn from its own sample, a splat as large as it.
const SPLATS: &str = "--visibility z --footprint splat --cell-size 1";
/// The same with shadows in two passes.
const TWO_PASS_SPLATS: &str =
    "--visibility z --footprint splat --cell-size 1 --shadows two-pass --shadow-map 256";
/// And in one (section 5.3).
const ONE_PASS_SPLATS: &str =
    "--visibility z --footprint splat --cell-size 1 --shadows one-pass --shadow-map 256";
/// What this project draws by default.
const PRESET: &str = "--preset balanced";

/// The columns of Table 5 and their flags.
const WAYS: [(&str, &str); 5] = [
    ("points", POINTS),
    ("points with shadows", SHADOWED_POINTS),
    ("splats", SPLATS),
    ("shadows in two passes", TWO_PASS_SPLATS),
    ("in one pass", ONE_PASS_SPLATS),
];

/// The clock of the paper's iPAQ, in cycles a second.
const CLOCK: f64 = 200e6;

/// A row of Table 5: a model, a level, and the paper's frames a second.
struct Row {
    model: Option<PaperModel>,
    level: usize,
    printed: [Option<f64>; 5],
}

const fn row(model: Option<PaperModel>, level: usize, printed: [Option<f64>; 5]) -> Row {
    Row {
        model,
        level,
        printed,
    }
}

const fn all(fps: [f64; 5]) -> [Option<f64>; 5] {
    let [a, b, c, d, e] = fps;
    [Some(a), Some(b), Some(c), Some(d), Some(e)]
}

/// Without the Blade; with the dragon and the bunny, of which the paper has pictures and samples alone.
const ROWS: [Row; 7] = [
    row(Some(MODELS[2]), 4, all([5.49, 4.15, 3.47, 2.65, 2.99])),
    row(Some(MODELS[2]), 5, all([0.91, 0.63, 3.33, 2.46, 2.85])),
    row(Some(MODELS[1]), 4, [None; 5]),
    row(Some(MODELS[1]), 5, [None; 5]),
    row(Some(MODELS[0]), 4, [None; 5]),
    row(Some(MODELS[0]), 5, [None; 5]),
    row(None, 4, all([0.62, 0.30, 2.38, 1.83, 2.11])),
];

/// The emulated device.
#[derive(Debug)]
pub struct Device {
    firmware: Firmware,
    /// Where scenes lie.
    scenes: PathBuf,
}

/// The flags of `rho run` that a way has.
#[derive(Debug, Parser)]
struct RunFlags {
    #[command(flatten)]
    mode: ModeArgs,
}

/// Of the longest frame; a scene in points takes a few seconds.
const TIMEOUT: Duration = Duration::from_secs(300);

impl Device {
    /// Builds its program from the workspace in the current folder.
    ///
    /// # Errors
    /// Those of [`Firmware::build`].
    pub fn new() -> Outcome<Self> {
        Ok(Self {
            firmware: Firmware::build(Machine::M3, Path::new("."), None)?,
            scenes: PathBuf::from("host-tools/scenes"),
        })
    }

    /// Draws a view of a blob by flags of `rho run`.
    ///
    /// # Errors
    /// Those of the device.
    pub fn draw(&self, blob: &[u8], flags: &str, view: &View) -> Outcome<Run> {
        let file = BlobFile::from_bytes(blob, "the blob");
        let words = std::iter::once("run").chain(flags.split_whitespace());
        let parsed = RunFlags::try_parse_from(words).map_err(|e| Failure::input(e.to_string()))?;
        let camera = view.camera()?;
        let blob = file.blob()?;
        let mode: Mode = parsed.mode.mode(&blob, &camera)?;
        let light = blob
            .lights()
            .next()
            .map_or(render::light(STANDARD_LIGHT), |light| light.towards);
        let request = Request::Model(Scene {
            camera,
            light,
            mode,
        });
        device::run(&self.firmware, Some(file.bytes()), &request, TIMEOUT)?.done()
    }

    /// The Big Scene, all its grids divided by three as often as the level says.
    fn big_scene(&self, level: usize) -> Outcome<Vec<u8>> {
        let bunny = model::scan("bunny")?;
        let models = bunny.parent().unwrap_or(Path::new("."));
        let flags = format!("{} --models {}", tri_grid(level), models.display());
        let scene: OsString = self.scenes.join("big.toml").into();
        bake_with(scene, Up::Y, &flags)
    }

    /// What a row draws.
    fn baked(&self, row: &Row) -> Outcome<(String, Vec<u8>)> {
        let (name, blob) = match row.model {
            Some(model) => (model.name, model.baked(&tri_grid(row.level))?),
            None => ("Big Scene", self.big_scene(row.level)?),
        };
        Ok((format!("{name} ({})", row.level), blob))
    }
}

/// Table 5: millions of instructions a frame, beside the paper's frames a second as millions of
/// cycles.
///
/// # Errors
/// Those of baking and of the device.
pub fn table_5(device: &Device, done: &dyn Fn()) -> Outcome<String> {
    let near = View::from(StandardView::Near);
    let mut columns = vec!["model (level)".to_owned(), "blob".to_owned()];
    for (way, _) in WAYS {
        columns.extend([way.to_owned(), "printed".to_owned()]);
    }
    columns.push("`balanced`, from the same blob".to_owned());
    let mut rows = Vec::new();
    for row in &ROWS {
        let (name, blob) = device.baked(row)?;
        let mut cells = vec![name, size(blob.len() as u64)];
        for ((_, flags), printed) in WAYS.iter().zip(row.printed) {
            let run = device.draw(&blob, flags, &near)?;
            cells.push(millions(run.report.phases.frame() as f64));
            cells.push(printed.map_or("-".to_owned(), |fps| millions(CLOCK / fps)));
            done();
        }
        let run = device.draw(&blob, PRESET, &near)?;
        cells.push(millions(run.report.phases.frame() as f64));
        done();
        rows.push(cells);
    }
    let columns: Vec<_> = columns.iter().map(String::as_str).collect();
    Ok(table(&columns, &rows))
}

fn millions(number: f64) -> String {
    format!("{:.1} M", number / 1e6)
}

/// A picture like one of the paper's figures.
struct Figure {
    /// The file's name.
    file: &'static str,
    /// What it shows.
    caption: &'static str,
    model: Option<usize>,
    level: usize,
    flags: &'static str,
    view: Shot,
}

/// From where.
enum Shot {
    Standard(StandardView),
    /// Half as far away as `near`, and turned.
    Close,
}

const fn figure(
    file: &'static str,
    caption: &'static str,
    model: Option<usize>,
    level: usize,
    flags: &'static str,
    view: Shot,
) -> Figure {
    Figure {
        file,
        caption,
        model,
        level,
        flags,
        view,
    }
}

const NEAR: Shot = Shot::Standard(StandardView::Near);

const FIGURES: [Figure; 9] = [
    figure(
        "figure-1-big-scene.png",
        "Figure 1: the Big Scene, level 4, splats, shadows in two passes",
        None,
        4,
        TWO_PASS_SPLATS,
        NEAR,
    ),
    figure(
        "figure-5-far-points-4.png",
        "Figure 5: the Buddha, points at level 4",
        Some(2),
        4,
        POINTS,
        NEAR,
    ),
    figure(
        "figure-5-far-points-5.png",
        "points at level 5",
        Some(2),
        5,
        POINTS,
        NEAR,
    ),
    figure(
        "figure-5-far-splats-5.png",
        "splats at level 5",
        Some(2),
        5,
        SPLATS,
        NEAR,
    ),
    figure(
        "figure-5-close-points-4.png",
        "close: points at level 4",
        Some(2),
        4,
        POINTS,
        Shot::Close,
    ),
    figure(
        "figure-5-close-points-5.png",
        "points at level 5",
        Some(2),
        5,
        POINTS,
        Shot::Close,
    ),
    figure(
        "figure-5-close-splats-5.png",
        "splats at level 5",
        Some(2),
        5,
        SPLATS,
        Shot::Close,
    ),
    figure(
        "figure-6-points-5.png",
        "Figure 6: the dragon, points at level 5 with shadows in two passes",
        Some(1),
        5,
        SHADOWED_POINTS,
        NEAR,
    ),
    figure(
        "figure-6-one-pass.png",
        "splats with shadows in one pass",
        Some(1),
        5,
        ONE_PASS_SPLATS,
        NEAR,
    ),
];

/// Draws the figures into a folder; Markdown that shows them, with paths from `page`'s folder.
///
/// # Errors
/// Those of baking, of the device, and when a picture cannot be written.
pub fn figures(device: &Device, folder: &Path, page: &str, done: &dyn Fn()) -> Outcome<String> {
    let mut text = String::new();
    for figure in &FIGURES {
        let blob = match figure.model {
            Some(model) => MODELS[model].baked(&tri_grid(figure.level))?,
            None => device.big_scene(figure.level)?,
        };
        let view = match figure.view {
            Shot::Standard(view) => view.into(),
            Shot::Close => View {
                distance: 1.1,
                yaw: 20.0,
                pitch: 10.0,
                ..StandardView::Near.into()
            },
        };
        let run = device.draw(&blob, figure.flags, &view)?;
        let (width, height) = (run.report.width.into(), run.report.height.into());
        let picture = Picture::from_rgb565(width, height, &run.words);
        picture.write(&folder.join(figure.file))?;
        let instructions = millions(run.report.phases.frame() as f64);
        text += &format!(
            "![{caption}]({page}/{file})\n\n{caption}: {instructions} instructions.\n\n",
            caption = figure.caption,
            file = figure.file,
        );
        done();
    }
    Ok(text)
}

/// How often `done` is called by the table and the figures.
pub const STEPS: usize = ROWS.len() * (WAYS.len() + 1) + FIGURES.len();

/// Figure 3: the order in which section 5.3 draws the 3 x 3 subcells of a square for a light from the
/// upper left: by their centres along its direction.
#[must_use]
pub fn figure_3() -> String {
    // Towards the light, across the square.
    let (x, y) = (-1.0, 1.5);
    let mut cells: Vec<_> = (0..9).map(|n| (n % 3 - 1, 1 - n / 3)).collect();
    cells.sort_by(|a, b| {
        let along = |c: &(i32, i32)| f64::from(c.0) * x + f64::from(c.1) * y;
        along(b).total_cmp(&along(a))
    });
    let place = |column: i32, row: i32| {
        let at = cells.iter().position(|cell| *cell == (column, row));
        at.map_or(0, |at| at + 1).to_string()
    };
    let rows: Vec<_> = (-1..=1)
        .rev()
        .map(|row| {
            (-1..=1)
                .map(|column| place(column, row))
                .collect::<Vec<_>>()
        })
        .collect();
    table(&["left", "middle", "right"], &rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_nearer_to_the_light_comes_first() {
        let figure = figure_3();
        for row in ["| 1 | 2 | 4 |", "| 3 | 5 | 7 |", "| 6 | 8 | 9 |"] {
            assert!(figure.contains(row), "{figure}");
        }
    }
}
