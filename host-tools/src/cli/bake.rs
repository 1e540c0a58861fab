//! `rho bake`: a model to a blob for the microcontroller's flash.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;

use crate::bake::{
    self, BakeOptions, Baked, GridChoice, LayoutChoice, Progress, Report, SampleChoice,
};
use crate::encode::MAX_GRIDS;
use crate::failure::{Failure, Outcome};
use crate::geometry::procedural;
use crate::replace::{check_replaceable, replace};
use crate::sampling::{Separation, Sequence};
use crate::source::{self, ModelArgs};
use crate::text::{size, thousands};
use crate::view::Direction;

const EXAMPLES: &str = "\
Examples:
  rho bake bunny.ply.gz -o bunny.rho
  rho bake teapot -o teapot.rho --rho 2,3,3,3,3 --thin --layout offset
  rho bake bunny.ply.gz -o bunny.rho --rho 3,3,3,3 --rho 2,3,3,3,3 --thin --layout offset
  rho bake scan.obj -o scan.rho --flash 512K --up z
  rho bake bunny.ply.gz -o bunny.rho --bake-shadows 0.4,0.6,0.7
  gunzip -c bunny.ply.gz | rho bake - -o - --subdivisions 4 > bunny.rho

Without a flag of the grid the blob holds what the presets of run and render choose among: six
grids of 48, 60, 72, 96, 108 and 144 cells an axis, thin, with offsets, without intermediate samples; of a
model in several colours with materials, too. --flash alone takes as many of them as fit, the
coarser ones first.

Any other flag of the grid asks for one grid, by --rho 3 --subdivisions 5 where it says nothing
else. --rho N is the subdivision of every level, and --subdivisions says how many there are. With
--flash and no --subdivisions, the finest grid is chosen that fits: a power of --rho, else a 2, 4,
5, 2,4 or 2,5 above 3s. Of several grids the finest is left out, with a warning, until the others
fit. They share the materials, and are numbered as they are given.

The same model and flags give the same bytes on any machine.";

fn after_help() -> String {
    format!("{EXAMPLES}\n\n{}", procedural::list())
}

/// Bake a model into a blob for the microcontroller's flash
#[derive(Args, Clone, Debug)]
#[command(after_help = after_help())]
pub struct Bake {
    /// A mesh or points: .ply, .obj, .stl, .glb or .gltf, or one of them .gz; - for standard
    /// input; or an object that needs no file, with its parameters: teapot, terrain:seed=7
    #[arg(required = true, value_name = "MODEL")]
    pub model: Vec<String>,
    /// The blob to write; - for standard output
    #[arg(short, long, value_name = "OUT.rho")]
    pub output: PathBuf,
    /// Subdivision of all levels, or of each from the root down [default: see below]; given several
    /// times, the blob holds a grid for each
    #[arg(long, value_name = "N|N,N,...", help_heading = "Grid")]
    pub rho: Vec<Rho>,
    /// How often the cube is subdivided [default: 5, where --rho is one number]
    #[arg(long, value_name = "N", help_heading = "Grid")]
    pub subdivisions: Option<u8>,
    /// Leaves are only the cells whose central cross the surface meets: some 40 % fewer
    #[arg(long, help_heading = "Grid")]
    pub thin: bool,
    /// The finest grid, or as many of those given, as fit into so many bytes; K and M are 1024
    #[arg(long, value_name = "SIZE", value_parser = source::bytes, help_heading = "Grid")]
    pub flash: Option<u64>,
    /// What is kept of each sample [default: material]
    #[arg(long, value_enum, help_heading = "Grid")]
    pub layout: Option<LayoutChoice>,
    /// Which nodes have samples [default: all]; without intermediate ones --cell-size has no effect
    #[arg(long, value_enum, help_heading = "Grid")]
    pub samples: Option<SampleChoice>,
    /// Bake the shadows of a light into the samples, by rays: of one that is fixed to the model, towards which
    /// X,Y,Z points; they cost nothing to draw, but are right for that light alone
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub bake_shadows: Option<Direction>,
    /// What was made as one JSON object on standard output
    #[arg(long)]
    pub json: bool,
    /// No progress, no report and no warnings
    #[arg(short, long, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Also report nodes by level and materials
    #[arg(short, long)]
    pub verbose: bool,
    /// How the model is found and read.
    #[command(flatten)]
    pub model_args: ModelArgs,
}

/// `--rho`: one number for all levels, or the whole sequence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Rho {
    /// The same at each level.
    Every(u8),
    /// One a level.
    Each(Sequence),
}

impl FromStr for Rho {
    type Err = Failure;
    fn from_str(text: &str) -> Outcome<Self> {
        let sequence: Sequence = text.parse()?;
        Ok(match sequence.as_slice() {
            [rho] => Self::Every(*rho),
            _ => Self::Each(sequence),
        })
    }
}

impl Bake {
    /// Runs the command.
    ///
    /// # Errors
    /// Exit 2: see [`bake::bake`]; flags that contradict each other; a file that cannot be
    /// written. The output's file is then as it was.
    pub fn run(&self) -> Outcome {
        let started = Instant::now();
        let model = self.model()?;
        let options = BakeOptions {
            grid: self.grid()?,
            separation: if self.thin {
                Separation::Six
            } else {
                Separation::TwentySix
            },
            layout: self.layout.unwrap_or_default(),
            samples: self.samples.unwrap_or_default(),
            shadows: self.bake_shadows.map(|light| light.0),
            load: self.model_args.options(),
            models: self.model_args.models.clone(),
        };
        let progress = Progress::default();
        let Baked { bytes, mut report } =
            self.watched(&progress, || bake::bake(model, &options, &progress))?;
        let writing = Instant::now();
        replace(&self.output, &bytes)?;
        report.seconds.write = writing.elapsed().as_secs_f64();
        report.seconds.total = started.elapsed().as_secs_f64();
        if !self.quiet {
            for warning in &report.warnings {
                eprintln!("warning: {warning}");
            }
            self.print(&report);
        }
        if self.json {
            println!("{}", json!(report));
        }
        Ok(())
    }

    /// The one model, if it and the output can be.
    fn model(&self) -> Outcome<&str> {
        let [model] = &self.model[..] else {
            return Err(Failure::input(format!(
                "{} models are given, and this version bakes one",
                self.model.len()
            ))
            .help("bake each into a blob of its own"));
        };
        if self.json && self.output == Path::new("-") {
            return Err(
                Failure::input("--json and -o - both write to standard output")
                    .help("name a file for the blob"),
            );
        }
        // Before the work: a wrong folder should not cost a minute.
        check_replaceable(&self.output)?;
        let same = |a: &Path, b: &Path| {
            let whole = |path: &Path| path.canonicalize().ok();
            whole(a).is_some_and(|a| Some(a) == whole(b))
        };
        if same(Path::new(model), &self.output) {
            return Err(
                Failure::input(format!("{model} would be overwritten by its own blob"))
                    .help("name another file with -o"),
            );
        }
        Ok(model)
    }

    fn grid(&self) -> Outcome<GridChoice> {
        let said = self.thin || self.layout.is_some() || self.samples.is_some();
        if !said && self.rho.is_empty() && self.subdivisions.is_none() {
            return Ok(GridChoice::Standard(self.flash));
        }
        if let (None, Some(flash), [] | [Rho::Every(_)]) =
            (self.subdivisions, self.flash, &self.rho[..])
        {
            let rho = self.rho.first().and_then(|rho| match rho {
                Rho::Every(rho) => Some(*rho),
                Rho::Each(_) => None,
            });
            return Ok(GridChoice::Finest(rho, flash));
        }
        let one = [Rho::Every(3)];
        let given = if self.rho.is_empty() {
            &one[..]
        } else {
            &self.rho
        };
        let mut sequences = Vec::new();
        for rho in given {
            let sequence = self.sequence(rho)?;
            if sequences.contains(&sequence) {
                return Err(Failure::input(format!("--rho {sequence} is given twice"))
                    .help("leave one of them away"));
            }
            sequences.push(sequence);
        }
        if sequences.len() > MAX_GRIDS {
            return Err(Failure::input(format!(
                "{} grids are asked for, and a blob holds at most {MAX_GRIDS}",
                sequences.len()
            ))
            .help("give --rho less often"));
        }
        Ok(match self.flash {
            Some(flash) => GridChoice::Fits(sequences, flash),
            None => GridChoice::Fixed(sequences),
        })
    }

    fn sequence(&self, rho: &Rho) -> Outcome<Sequence> {
        match rho {
            Rho::Every(rho) => {
                Sequence::new(&vec![*rho; usize::from(self.subdivisions.unwrap_or(5))])
            }
            Rho::Each(sequence) => {
                let levels = sequence.as_slice().len();
                if let Some(n) = self.subdivisions.filter(|n| usize::from(*n) != levels) {
                    return Err(Failure::input(format!(
                        "--rho {sequence} has {levels} subdivisions, and --subdivisions says {n}"
                    ))
                    .help("leave --subdivisions away, or give --rho one number"));
                }
                Ok(sequence.clone())
            }
        }
    }

    /// Runs `work` with a bar, on a terminal only.
    fn watched<T: Send>(&self, progress: &Progress, work: impl FnOnce() -> T + Send) -> T {
        if self.quiet || self.json || !std::io::stderr().is_terminal() {
            return work();
        }
        let style = ProgressStyle::with_template("baking {wide_bar} {human_pos} leaves {eta}");
        let bar = ProgressBar::new(1);
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        let (done, waiting) = channel::<()>();
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let waiting = waiting;
                // Until `done` is dropped.
                while waiting.recv_timeout(Duration::from_millis(50))
                    == Err(RecvTimeoutError::Timeout)
                {
                    let expected = progress.expected.load(Ordering::Relaxed);
                    if expected > 0 {
                        bar.set_length(expected);
                        bar.set_position(progress.leaves.load(Ordering::Relaxed));
                    }
                }
                bar.finish_and_clear();
            });
            let result = work();
            drop(done);
            result
        })
    }

    /// The report for people.
    fn print(&self, report: &Report) {
        let contents = &report.contents;
        let triangles = report.triangles.map_or_else(String::new, |triangles| {
            format!(", {} triangles", thousands(triangles))
        });
        eprintln!("{} ({}{triangles})", report.model, report.format);
        for grid in &contents.grids {
            eprintln!(
                "  grid    {} cells an axis by {}, {}-separating, {}",
                grid.cells.last().unwrap_or(&1),
                grid.sequence(),
                grid.separation,
                grid.layout
            );
            eprintln!(
                "  samples {} leaves, {} nodes, alpha {:.3}, {} bytes",
                thousands(grid.leaf_samples),
                thousands(grid.nodes),
                grid.alpha,
                thousands(grid.bytes)
            );
        }
        if self.verbose {
            for grid in &contents.grids {
                for (cells, nodes) in grid.cells.iter().zip(&grid.nodes_by_level) {
                    eprintln!(
                        "          {cells:>4} cells an axis: {} nodes",
                        thousands(*nodes)
                    );
                }
            }
            eprintln!("          {} materials", contents.materials.len());
        }
        let sections: Vec<String> = contents
            .bytes
            .iter()
            .filter(|(name, _)| *name != "total")
            .map(|(name, bytes)| format!("{name} {}", thousands(*bytes)))
            .collect();
        eprintln!(
            "  bytes   {}: {}",
            thousands(contents.total_bytes()),
            sections.join(", ")
        );
        eprintln!(
            "          {:.3} bytes or {:.1} bits a leaf",
            contents.bytes_per_leaf,
            8.0 * contents.bytes_per_leaf
        );
        let s = &report.seconds;
        eprintln!(
            "  seconds {:.2}: read {:.2}, sample {:.2}, encode {:.2}, write {:.2}{}",
            s.total,
            s.read,
            s.sample,
            s.encode,
            s.write,
            match report.bakes {
                1 => String::new(),
                n => format!(" ({n} blobs tried)"),
            }
        );
        eprintln!("  memory  {} at the peak", size(report.peak_memory_bytes));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Flags {
        #[command(flatten)]
        bake: Bake,
    }

    fn grid(flags: &[&str]) -> Outcome<String> {
        let all = [&["bake", "m.ply", "-o", "m.rho"], flags].concat();
        let text = |sequences: &[Sequence]| {
            let all: Vec<String> = sequences.iter().map(Sequence::to_string).collect();
            all.join(" and ")
        };
        let flags = Flags::try_parse_from(all).map_err(|e| Failure::input(e.to_string()))?;
        Ok(match flags.bake.grid()? {
            GridChoice::Fixed(sequences) => text(&sequences),
            GridChoice::Fits(sequences, bytes) => format!("{} in {bytes}", text(&sequences)),
            GridChoice::Standard(None) => "standard".to_owned(),
            GridChoice::Standard(Some(bytes)) => format!("standard in {bytes}"),
            GridChoice::Finest(Some(rho), bytes) => format!("powers of {rho} in {bytes}"),
            GridChoice::Finest(None, bytes) => format!("any in {bytes}"),
        })
    }

    #[test]
    fn the_grid_is_what_the_flags_say() {
        for (flags, expected) in [
            (&[][..], "standard"),
            (&["--flash", "1K"], "standard in 1024"),
            (&["--thin"], "3,3,3,3,3"),
            (&["--layout", "material"], "3,3,3,3,3"),
            (&["--samples", "all"], "3,3,3,3,3"),
            (&["--subdivisions", "2"], "3,3"),
            (&["--rho", "2"], "2,2,2,2,2"),
            (&["--rho", "4", "--subdivisions", "6"], "4,4,4,4,4,4"),
            (&["--rho", "2,3"], "2,3"),
            (&["--rho", "2,3", "--rho", "4,3"], "2,3 and 4,3"),
            (
                &["--rho", "2", "--rho", "3", "--subdivisions", "2"],
                "2,2 and 3,3",
            ),
            (
                &["--flash", "1K", "--rho", "3,3", "--rho", "4"],
                "3,3 and 4,4,4,4,4 in 1024",
            ),
            (&["--rho", "2,3", "--subdivisions", "2"], "2,3"),
            (&["--flash", "1K", "--thin"], "any in 1024"),
            (&["--flash", "1K", "--rho", "3"], "powers of 3 in 1024"),
            (&["--flash", "1K", "--rho", "4,3"], "4,3 in 1024"),
            (&["--flash", "1K", "--subdivisions", "2"], "3,3 in 1024"),
        ] {
            assert_eq!(grid(flags).unwrap(), expected, "{flags:?}");
        }
    }

    #[test]
    fn flags_that_contradict_each_other_or_ask_too_much_are_refused() {
        for flags in [
            &["--rho", "2,3", "--subdivisions", "3"][..],
            &["--rho", "6"],
            &["--rho", "3,3", "--rho", "3,3"],
            &["--rho", "3,3", "--rho", "3", "--subdivisions", "2"],
            &["--rho", "1"],
            &["--rho", "x"],
            &["--subdivisions", "0"],
            &["--subdivisions", "8"],
            &["--subdivisions", "300"],
            &["--rho", "4,4,4,4,4,4,2"],
            &["--flash", "lots"],
            &["--preset", "balanced"],
        ] {
            assert!(grid(flags).is_err(), "{flags:?}");
        }
    }
}
