//! `rho paper`: the paper's tables and figures beside this project's.

use std::fs;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use crate::failure::{Failure, Outcome};
use crate::paper::models::MODELS;
use crate::paper::rendering::Device;
use crate::paper::{memory, normals, operations, ram, rendering};
use crate::replace::{check_replaceable, replace};

const EXAMPLES: &str = "\
Examples:
  rho paper -o docs/paper.md
  rho paper --only 3

The pictures go into a folder beside the page, named as it is without `.md`. Needs the scans (the folder
that RHO_MODELS names, else ../shared/models) and QEMU, and takes some minutes.";

/// Sets the tables of Duguet & Drettakis 2003 beside what is measured here
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct PaperArgs {
    /// One table alone, without figures: 1 to 5
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=5))]
    only: Option<u8>,
    /// Also write a page, with pictures
    #[arg(short, long, value_name = "F.md")]
    output: Option<PathBuf>,
    /// No progress
    #[arg(short, long)]
    quiet: bool,
}

impl PaperArgs {
    /// Runs the command.
    ///
    /// # Errors
    /// Exit 3 when a scan, QEMU or a target is missing, 4 when the device fails.
    pub fn run(&self) -> Outcome {
        if let Some(output) = &self.output {
            check_replaceable(output)?;
        }
        let bar = self.bar();
        let page = self.page(&|| bar.inc(1))?;
        bar.finish_and_clear();
        print!("{page}");
        match &self.output {
            Some(output) => replace(output, page.as_bytes()),
            None => Ok(()),
        }
    }

    fn page(&self, done: &dyn Fn()) -> Outcome<String> {
        let wants = |table: u8| self.only.is_none_or(|only| only == table);
        let device = (wants(2) || wants(5)).then(Device::new).transpose()?;
        let mut page = INTRODUCTION.to_owned();
        page += &models();
        let mut section = |title: &str, text: &str, table: &str| {
            page += &format!("\n## {title}\n\n{text}\n\n{table}");
        };
        if wants(1) || wants(4) {
            let (one, four) = (memory::table_1(done)?, memory::table_4(done)?);
            section("Table 1: memory above the leaves", TABLE_1, &one);
            section("Table 4: samples, alpha, bytes", TABLE_4, &four);
        }
        if let Some(device) = device.as_ref().filter(|_| wants(2)) {
            let table = operations::table_2(device, done)?;
            section("Table 2: operations a sample", TABLE_2, &table);
        }
        if wants(3) {
            section(
                "Table 3: the error of normals",
                TABLE_3,
                &normals::table_3(),
            );
        }
        if let Some(device) = device.as_ref().filter(|_| wants(5)) {
            let table = rendering::table_5(device, done)?;
            section("Table 5: a frame", TABLE_5, &table);
        }
        if self.only.is_none() {
            section("Memory by mode", MEMORY, &ram::modes());
        }
        if let (Some(device), Some(output), None) = (&device, &self.output, self.only) {
            let (folder, name) = folder_beside(output)?;
            let figures = rendering::figures(device, &folder, &name, done)?;
            section(
                "Figure 3: order by the light",
                FIGURE_3,
                &rendering::figure_3(),
            );
            section("Figures 1, 5 and 6", FIGURES, &figures);
        }
        page += NOT_REPRODUCED;
        Ok(page)
    }

    /// A bar, on a terminal only.
    fn bar(&self) -> ProgressBar {
        if self.quiet || !std::io::stderr().is_terminal() {
            return ProgressBar::hidden();
        }
        let all = memory::STEPS + operations::STEPS + rendering::STEPS;
        let style = ProgressStyle::with_template("paper {wide_bar} {pos}/{len} {eta}");
        let bar = ProgressBar::new(all as u64);
        bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
    }
}

/// The folder for a page's pictures, made if it is not there, and its name.
fn folder_beside(page: &Path) -> Outcome<(PathBuf, String)> {
    let folder = page.with_extension("");
    fs::create_dir_all(&folder).map_err(|error| {
        Failure::input(format!("{}: {error}", folder.display()))
            .help("name a page in a folder that can be written")
    })?;
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    Ok((folder.clone(), name.into_owned()))
}

/// The models, and what they stand for.
fn models() -> String {
    let mut text = String::from("\n## The models\n\n");
    for model in MODELS {
        let difference = if model.difference.is_empty() {
            "the same model at its original resolution"
        } else {
            model.difference
        };
        text += &format!(
            "* {} for the paper's {}: {difference}.\n",
            model.name, model.papers
        );
    }
    text += "* The paper's Blade was in no source that could be reached: it is absent from every table.\n\
        * The Big Scene has dragon, buddha, bunny, oak and willow on a ground of points\n  \
        (`host-tools/scenes/big.toml`); the paper's has the Blade for the bunny.\n\n\
        Bunny, dragon, Buddha: Stanford Computer Graphics Laboratory. The oak was grown by ez-tree.\n";
    text
}

const INTRODUCTION: &str = "\
# The paper's tables

Duguet & Drettakis, *Flexible Point-Based Rendering on Mobile Devices* (2003), beside this project, which
grew from it. `rho paper -o docs/paper.md` makes this page. Where a number is printed in the paper it stands
under *printed*. Instructions are counted in QEMU, exactly, on a Cortex-M3, in the paper's own settings (a
cell's box or point, a depth buffer, grids of rho = 3 with all intermediate samples) and not in those that
this project recommends: [bench.md](bench.md) has those.
";

const TABLE_1: &str = "\
Bits a leaf of masks and intermediate attributes, (sigma + rho^3) / (rho^d - 1). The formula has d = 2; a model's own
columns have the nodes that it really has, with 256, 243, 256 and 125 cells an axis for rho = 2 to 5. The paper
marks rho = 3 as best up to 16 bits where its own numbers have rho = 4 ahead (5.33 against 5.38).";

const TABLE_4: &str = "\
Level L has 3^(L + 1) cells an axis; samples are leaves and intermediate ones; alpha is children a node. A blob
holds masks (32 bits), where a node's children begin (2 bytes) and attributes (16 bits).";

const TABLE_2: &str = "\
Section 5.4 counts additions and shifts a sample, (3 rho^d + rho^3) / (rho^d - 1), or 6 for shadows in one pass. Beside
it, instructions a leaf of the bunny near: everything that a frame does, divisions, depth test and store
included, which the formula leaves out.";

const TABLE_3: &str = "\
The paper's statistic is 1 - n.q at its worst: of second order, and not what is seen. A light's n.l is wrong by
the first order, ten to forty times as much.";

const TABLE_5: &str = "\
Millions of instructions a frame, `near`; *printed* are the paper's frames a second on an iPAQ of 200 MHz as millions
of cycles. They are no measure of each other: cycles are not instructions, the paper's views are not
known but for one picture, and its cells may have been drawn otherwise. What can be compared is how columns and rows stand to each
other. Shadow maps have 256 x 256 texels and are made anew each frame.";

const MEMORY: &str = "\
Bytes of RAM for a panel of 240 x 320, beside the stack, which `rho run` measures. Words are RGB565; tones and quarters are
bytes, sent in strips of forty rows. Instances, at most 128, and materials, at most eight an object, have their room in every
mode; tables are as large as on a host of 64 bits, some bytes more than on a board. Objects are *tangled* when no plane
parts their boxes. The program `scenes` has all of tones and quarters with a map of 128: `cargo test --release --package
rho-tests --test budget -- --nocapture` prints its RAM and its flash.";

const FIGURE_3: &str = "\
The numbers tell when each of 3 x 3 subcells is drawn, for a light from above and a little from the left.";

const FIGURES: &str = "Drawn by the firmware, decoded from the panel's wire.";

const NOT_REPRODUCED: &str = "
## What cannot be reproduced

* The Blade and the paper's own trees: not to be had; stand-ins are marked above.
* Happy Buddha at 1.08 million triangles: a reduced one stands in. Its samples at level 5 are as many as the
  paper's, since cells and not triangles decide.
* Frames a second: no iPAQ. Instructions on another core are exact, and are another quantity.
* The views of Table 5, whose frames a second are averages: not stated.
* The sizes of files, exactly: the paper adds \"about 25 %\" for pointers without saying of what.
* Table 3 by \"random tests\": the worst of a dense set of directions is given here; random ones find less.
";
