//! `rho bench`: every way to draw a model on the device, in one table.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::{ParallelProgressIterator, ProgressBar, ProgressStyle};
use rayon::prelude::*;
use rho_viewer::count::Phase;
use serde_json::json;

use crate::bench::rows::{Group, ROWS, Row, Way};
use crate::bench::{Measured, Ready, Subject, table, truths};
use crate::cli::profile::work_object;
use crate::failure::{Failure, Outcome};
use crate::machine::Machine;
use crate::model::Up;
use crate::profile;
use crate::replace::{check_replaceable, replace};
use crate::view::{StandardView, View};

const EXAMPLES: &str = "\
Examples:
  rho bench --quick
  rho bench --only discs --classes
  rho bench --classes -o docs/bench.md     # as `make bench` does

All rows draw the bunny, at its original resolution, in the standard views under the standard
light, twice in QEMU; the second frame is counted. The scans lie in the folder that RHO_MODELS
names, else in ../shared/models. `instructions` leaves out shading_tables and send. Cycles are
estimates from the cores' tables, for memory without wait states.";

const INTRODUCTION: &str = "\
# Benchmark

The Stanford bunny (69,451 triangles) in the standard views, 240x320, drawn by programs on the emulated
Cortex-M3: this renderer's modes, the paper's own algorithms by the same parts, and others' ways. Each draws
the view twice; the instructions of the second frame are counted, exactly. Quality is against 25 rays a pixel.
`make bench` makes this page; a test fails when a figure of ours grows by more than 2 % without it.

`instructions` is everything that a moved camera needs: all phases but shading_tables (which change with the
light) and send (the panel's).
";

/// Flags of the growth table's blobs.
const LIMIT: &str = "--flash 512K --thin --layout offset";

/// The growth table's models.
const MODELS: [(&str, Up); 4] = [
    ("cow", Up::Y),
    ("bunny", Up::Y),
    ("buddha_100k", Up::Z),
    ("dragon", Up::Y),
];

/// Distances of the growth table, in sides of the cube.
const DISTANCES: [f64; 5] = [1.6, 2.2883, 4.5766, 9.1532, 18.3064];

/// Measures every way to draw the bunny: instructions, quality, memory
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct BenchArgs {
    /// Two views, no triangles, no growth
    #[arg(long)]
    quick: bool,
    /// Rows whose name contains this
    #[arg(long, value_name = "TEXT", default_value = "")]
    only: String,
    /// Also instructions by class, and cycles by core
    #[arg(long)]
    classes: bool,
    /// Also write a page with the tables
    #[arg(short, long, value_name = "F.md")]
    output: Option<PathBuf>,
    /// One JSON object on standard output, nothing else
    #[arg(long)]
    json: bool,
    /// No progress
    #[arg(short, long)]
    quiet: bool,
}

/// A row, a view's name, what was measured.
type Result = (&'static str, String, Measured);

impl BenchArgs {
    /// Runs the command.
    ///
    /// # Errors
    /// Exit 2 when nothing is chosen, 3 when a scan, QEMU or a target is missing, 4 when a
    /// device fails.
    pub fn run(&self) -> Outcome {
        if let Some(output) = &self.output {
            check_replaceable(output)?;
        }
        let views: &[StandardView] = if self.quick {
            &[StandardView::Near, StandardView::Far]
        } else {
            &StandardView::ALL
        };
        let rows: Vec<Row> = ROWS.into_iter().filter(|row| self.wants(row)).collect();
        if rows.is_empty() {
            let names = ROWS.map(|row| row.name).join(", ");
            return Err(
                Failure::input(format!("no row's name contains {}", self.only))
                    .help(format!("the rows are: {names}")),
            );
        }
        let plugin = profile::plugin(Path::new("."), None)?;
        let named: Vec<_> = views
            .iter()
            .map(|v| (v.name().to_owned(), View::from(*v)))
            .collect();
        let bunny = Subject::scan("bunny", Up::Y)?;
        let results = self.measure(&rows, Machine::M3, &bunny, &named, Some(&plugin))?;
        let ours: Vec<Row> = rows
            .iter()
            .copied()
            .filter(|row| row.group == Group::Ours)
            .collect();
        let mut cores = Vec::new();
        for machine in Machine::ALL {
            if !self.quick && !ours.is_empty() {
                let results = self.measure(&ours, machine, &bunny, &named, None)?;
                cores.push((machine, results));
            }
        }
        let growth = if self.quick || !self.only.is_empty() {
            Vec::new()
        } else {
            self.growth()?
        };
        let lines: Vec<_> = results
            .iter()
            .map(|(n, v, m)| (*n, v.as_str(), m))
            .collect();
        let mut page = format!("\n## {}\n\n{}", table::COST, table::standard(&lines));
        let is_ours = |(name, ..): &&table::Line<'_>| ours.iter().any(|row| row.name == *name);
        let of_ours: Vec<_> = lines.iter().filter(is_ours).copied().collect();
        let others: Vec<_> = lines.iter().filter(|l| !is_ours(l)).copied().collect();
        if !of_ours.is_empty() && !others.is_empty() {
            page += &format!(
                "\n## Against the others\n\nInstructions of ours, in parts of theirs.\n\n{}",
                table::against(&of_ours, &others)
            );
        }
        page += &format!("\n## {}\n\n{}", table::MEMORY, table::memory(&lines));
        if self.classes {
            page += &format!(
                "\n## By class and core\n\nInstructions, and cycles estimated from the cores' tables for \
                 memory without wait states, in millions; classes in per cent of the \
                 instructions.\n\n{}",
                table::classes(&lines)
            );
        }
        if !cores.is_empty() {
            page += &format!(
                "\n## Other cores\n\nInstructions of the same frames, by programs built for each \
                 core; the pictures are the same, bit for bit.\n\n{}",
                table::cores(&cores)
            );
        }
        if !growth.is_empty() {
            let lines: Vec<_> = growth
                .iter()
                .map(|(triangles, (n, v, m))| (*n, v.as_str(), *triangles, m))
                .collect();
            page += &format!(
                "\n## Growth\n\nOther models, each baked with `{LIMIT}`, near; and the bunny from \
                 other distances.\n\n{}",
                table::growth(&lines)
            );
        }
        if self.json {
            let growth = growth.iter().map(|(_, result)| result);
            println!(
                "{}",
                json!({
                    "rows": objects(results.iter()),
                    "growth": objects(growth),
                })
            );
        } else {
            print!("{}", page.trim_start());
        }
        if let Some(output) = &self.output {
            replace(output, format!("{INTRODUCTION}{page}").as_bytes())?;
        }
        Ok(())
    }

    fn wants(&self, row: &Row) -> bool {
        let slow = matches!(row.way, Way::Triangles(..));
        row.name.contains(&self.only) && !(self.quick && slow)
    }

    /// Every row in every view.
    fn measure(
        &self,
        rows: &[Row],
        machine: Machine,
        subject: &Subject,
        views: &[(String, View)],
        plugin: Option<&Path>,
    ) -> Outcome<Vec<Result>> {
        let ready = rows
            .iter()
            .map(|row| Ready::new(*row, machine, subject, Path::new("."), None))
            .collect::<Outcome<Vec<_>>>()?;
        let only: Vec<_> = views.iter().map(|(_, view)| *view).collect();
        let truths = truths(&subject.mesh, &only)?;
        let jobs: Vec<_> = ready
            .iter()
            .flat_map(|ready| views.iter().zip(&truths).map(move |pair| (ready, pair)))
            .collect();
        let bar = self.bar(jobs.len());
        jobs.par_iter()
            .progress_with(bar)
            .map(|(ready, ((name, view), truth))| {
                let measured = ready.measure(view, truth, plugin)?;
                Ok((ready.row.name, name.clone(), measured))
            })
            .collect()
    }

    /// Our rows with other models and from other distances, and the models' triangles.
    fn growth(&self) -> Outcome<Vec<(u64, Result)>> {
        let mut all = Vec::new();
        let first = ROWS.into_iter().find(|row| row.group == Group::Ours);
        let Some((first, Way::Renderer { bake, run })) = first.map(|row| (row, row.way)) else {
            return Ok(all);
        };
        let row = |name, bake| Row {
            name,
            way: Way::Renderer { bake, run },
            ..first
        };
        for (name, up) in MODELS {
            let subject = Subject::scan(name, up)?;
            let triangles = subject.mesh.triangles.len() as u64;
            let mut rows = vec![row("the finest in 512 KiB", LIMIT)];
            let mut views = vec![(format!("{name}, near"), StandardView::Near.into())];
            let mut add = |results: Vec<Result>| {
                all.extend(results.into_iter().map(|result| (triangles, result)));
            };
            add(self.measure(&rows, Machine::M3, &subject, &views, None)?);
            if name == "bunny" {
                rows = vec![row(first.name, bake)];
                views = DISTANCES
                    .map(|distance| {
                        let near = View::from(StandardView::Near);
                        (
                            format!("{name}, distance {distance}"),
                            View { distance, ..near },
                        )
                    })
                    .into();
                add(self.measure(&rows, Machine::M3, &subject, &views, None)?);
            }
        }
        Ok(all)
    }

    /// A bar, on a terminal only.
    fn bar(&self, jobs: usize) -> ProgressBar {
        if self.quiet || self.json || !std::io::stderr().is_terminal() {
            return ProgressBar::hidden();
        }
        let style = ProgressStyle::with_template("frames {wide_bar} {pos}/{len} {eta}");
        let bar = ProgressBar::new(jobs as u64);
        bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
    }
}

fn objects<'a>(results: impl Iterator<Item = &'a Result>) -> Vec<serde_json::Value> {
    results
        .map(|(name, view, measured)| {
            let phases: serde_json::Map<_, _> = Phase::ALL
                .into_iter()
                .map(|phase| (phase.name().to_owned(), measured.phases.get(phase).into()))
                .collect();
            json!({
                "name": name,
                "view": view,
                "instructions": measured.phases.frame(),
                "instructions_by_phase": phases,
                "work": measured.work.as_ref().map(work_object),
                "pixels": measured.pixels,
                "comparison": measured.comparison,
                "model_bytes": measured.model_bytes,
                "ram_bytes": measured.ram_bytes,
                "stack_bytes": measured.stack_bytes,
                "program_bytes": measured.program_bytes,
            })
        })
        .collect()
}
