//! `rho bench`: every way to draw a model on the device, in one table.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::{ParallelProgressIterator, ProgressBar, ProgressStyle};
use rayon::prelude::*;
use rho_viewer::count::Phase;
use serde_json::json;

use crate::bench::rows::{Group, ROWS, Row, Way};
use crate::bench::{Figure, Ready, Subject, table, truths};
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
Cortex-M3: this renderer's modes, the paper's own algorithms by the same parts (a program for them alone
would need fewer instructions), and others' ways. Each draws the view twice; the instructions of the second
frame are counted, exactly. Quality is against 25 rays a pixel. `make bench` makes this page; a test fails
when a figure of ours grows by more than 2 % without it.

`instructions` is everything that a moved camera needs: all phases but shading_tables (which change with the
light) and send (the panel's).
";

/// Flags of the growth table's blobs.
const LIMIT: &str = "--flash 512K";

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
    /// Two views, no triangles, no other cores and no growth
    #[arg(long)]
    quick: bool,
    /// Rows whose name contains this, no other cores and no growth
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
        let results = self.results(&rows, views)?;
        let page = results.page(self.classes);
        if self.json {
            println!("{}", results.object());
        } else {
            print!("{}", page.trim_start());
        }
        if let Some(output) = &self.output {
            replace(output, format!("{INTRODUCTION}{page}").as_bytes())?;
        }
        Ok(())
    }

    fn results(&self, rows: &[Row], views: &[StandardView]) -> Outcome<Results> {
        let plugin = profile::plugin(Path::new("."), None)?;
        let views: Vec<_> = views
            .iter()
            .map(|view| (view.name().to_owned(), View::from(*view)))
            .collect();
        let bunny = Subject::scan("bunny", Up::Y)?;
        let mut results = Results {
            standard: self.measure(rows, Machine::M3, &bunny, &views, Some(&plugin))?,
            ..Results::default()
        };
        if self.quick || !self.only.is_empty() {
            return Ok(results);
        }
        let ours: Vec<Row> = rows
            .iter()
            .copied()
            .filter(|row| row.group == Group::Ours)
            .collect();
        for machine in Machine::ALL {
            let figures = self.measure(&ours, machine, &bunny, &views, None)?;
            results.cores.push((machine, figures));
        }
        results.growth = self.growth()?;
        Ok(results)
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
    ) -> Outcome<Vec<Figure>> {
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
                Ok(Figure {
                    row: ready.row.name,
                    view: name.clone(),
                    measured,
                })
            })
            .collect()
    }

    /// Our rows with other models and from other distances, and the models' triangles.
    fn growth(&self) -> Outcome<Vec<(u64, Figure)>> {
        let mut all = Vec::new();
        // The presets: rows of the blob that a bake makes by itself.
        let presets: Vec<Row> = ROWS
            .into_iter()
            .filter(|row| matches!(row.way, Way::Renderer { bake: "", .. }))
            .collect();
        let limited: Vec<Row> = presets.iter().map(|row| row.baked(LIMIT)).collect();
        for (name, up) in MODELS {
            let subject = Subject::scan(name, up)?;
            let triangles = subject.mesh.triangles.len() as u64;
            let mut add = |figures: Vec<Figure>| {
                all.extend(figures.into_iter().map(|figure| (triangles, figure)));
            };
            let near = View::from(StandardView::Near);
            let views = [(format!("{name}, near"), near)];
            add(self.measure(&limited, Machine::M3, &subject, &views, None)?);
            if name == "bunny" {
                let views = DISTANCES.map(|distance| {
                    let view = View { distance, ..near };
                    (format!("{name}, distance {distance}"), view)
                });
                add(self.measure(&presets, Machine::M3, &subject, &views, None)?);
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

/// All that was measured.
#[derive(Default)]
struct Results {
    /// Every row in every view.
    standard: Vec<Figure>,
    /// Our rows on each core.
    cores: Vec<(Machine, Vec<Figure>)>,
    /// Our rows with other models and from other distances, and the models' triangles.
    growth: Vec<(u64, Figure)>,
}

impl Results {
    /// The tables.
    fn page(&self, classes: bool) -> String {
        let mut page = String::new();
        let mut section = |title: &str, text: &str, table: String| {
            page += &format!("\n## {title}\n\n{text}{table}");
        };
        let standard = &self.standard;
        section(table::COST, "", table::standard(standard));
        let is_ours = |figure: &&Figure| {
            let mut ours = ROWS.iter().filter(|row| row.group == Group::Ours);
            ours.any(|row| row.name == figure.row)
        };
        let (ours, others): (Vec<_>, Vec<_>) = standard.iter().partition(is_ours);
        if !ours.is_empty() && !others.is_empty() {
            section(
                "Against the others",
                "Instructions of ours, in parts of theirs.\n\n",
                table::against(&ours, &others),
            );
        }
        section(table::MEMORY, "", table::memory(standard));
        if classes {
            section(
                "By class and core",
                "Instructions, and cycles estimated from the cores' tables for memory without wait \
                 states, in millions; classes in per cent of the instructions.\n\n",
                table::classes(standard),
            );
        }
        if !self.cores.is_empty() {
            section(
                "Other cores",
                "Instructions of the same frames, by programs built for each core; the pictures are \
                 the same, bit for bit.\n\n",
                table::cores(&self.cores),
            );
        }
        if !self.growth.is_empty() {
            section(
                "Growth",
                &format!(
                    "Other models, each baked with `{LIMIT}`, near; and the bunny from other \
                     distances.\n\n"
                ),
                table::growth(&self.growth),
            );
        }
        page
    }

    fn object(&self) -> serde_json::Value {
        let cores: serde_json::Map<_, _> = self
            .cores
            .iter()
            .map(|(machine, figures)| (machine.core().to_owned(), objects(figures.iter())))
            .collect();
        json!({
            "rows": objects(self.standard.iter()),
            "cores": cores,
            "growth": objects(self.growth.iter().map(|(_, figure)| figure)),
        })
    }
}

fn objects<'a>(figures: impl Iterator<Item = &'a Figure>) -> serde_json::Value {
    figures
        .map(|figure| {
            let measured = &figure.measured;
            let phases: serde_json::Map<_, _> = Phase::ALL
                .into_iter()
                .map(|phase| (phase.name().to_owned(), measured.phases.get(phase).into()))
                .collect();
            json!({
                "name": figure.row,
                "view": figure.view,
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
