//! `rho profile`: where the instructions of a frame go.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Args, ValueEnum};
use rho_viewer::count::Phase;
use rho_viewer::request::{Request, Scene};
use serde_json::json;

use crate::blob_file::BlobFile;
use crate::cli::mode::ModeArgs;
use crate::cli::run::seconds;
use crate::device;
use crate::failure::Outcome;
use crate::firmware::Firmware;
use crate::machine::Machine;
use crate::profile::cycles::Core;
use crate::profile::place::Places;
use crate::profile::thumb::Class;
use crate::profile::{self, Profile, Work};
use crate::qemu::Job;
use crate::text::thousands;
use crate::view::ViewArgs;

const EXAMPLES: &str = "\
Examples:
  rho profile bunny.rho --view near
  rho profile bunny.rho --view far --by line --top 40
  rho profile bunny.rho --phase shading_tables --by address

The second of two frames is counted, as by `rho run`: all phases but shading_tables and send,
unless one is named; each holds the three instructions that read the counter. A function is the
innermost one in the source, whatever the optimiser joined. Cycles are estimates from the core's
tables, for memory without wait states.";

/// What a line of the table stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum By {
    /// A function of the source
    Function,
    /// A line of the source
    Line,
    /// A file of the source
    File,
    /// A function of the image, with all that was joined into it
    Symbol,
    /// An instruction
    Address,
}

/// Tells where the instructions of a frame go: by class, phase, function, line or address
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct ProfileArgs {
    /// The baked model
    #[arg(value_name = "OUT.rho")]
    model: PathBuf,
    /// What a line of the table stands for
    #[arg(long, value_enum, default_value_t = By::Function)]
    by: By,
    /// One phase only
    #[arg(long, value_name = "NAME", value_parser = phase)]
    phase: Option<Phase>,
    /// Lines of the table
    #[arg(long, value_name = "N", default_value_t = 25)]
    top: usize,
    /// The firmware's image, with debug information; without it, it is built from the workspace
    /// in this folder
    #[arg(long, value_name = "ELF")]
    firmware: Option<PathBuf>,
    /// The core that draws
    #[arg(long, value_enum, default_value_t = Machine::M3)]
    core: Machine,
    /// How long the device may take, in seconds
    #[arg(long, value_name = "S", default_value = "300", value_parser = seconds)]
    timeout: Duration,
    /// One JSON object on standard output, nothing else
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    mode: ModeArgs,
}

fn phase(text: &str) -> Result<Phase, String> {
    let names = || Phase::ALL.map(Phase::name).join(", ");
    Phase::ALL
        .into_iter()
        .find(|phase| phase.name() == text)
        .ok_or_else(|| format!("expected one of: {}", names()))
}

impl ProfileArgs {
    /// Runs the command.
    ///
    /// # Errors
    /// Those of [`device::run`]; exit 3 when the plugin does not build.
    pub fn run(&self) -> Outcome {
        let file = BlobFile::read(&self.model)?;
        let blob = file.blob()?;
        let camera = self.view.camera(Some(&blob))?;
        let mode = self.mode.mode(&blob, &camera)?;
        if let Some(warning) = ModeArgs::warning(mode, &blob) {
            eprintln!("warning: {warning}");
        }
        let request = Request::Model(Scene {
            camera,
            light: self.view.towards(Some(&blob)),
            mode,
        });
        let firmware = Firmware::named_or_built(self.firmware.as_deref(), self.core)?;
        let plugin = profile::plugin(Path::new("."), None)?;
        let run = device::answer(&Job {
            firmware: &firmware,
            model: Some(file.bytes()),
            request: &request.line(),
            timeout: self.timeout,
            plugin: Some(&plugin),
        })?
        .done()?;
        let profile = Profile::new(&firmware, &run)?;
        let rows = self.rows(&profile, &mut Places::open(firmware.path())?);
        if self.json {
            println!("{}", self.object(&profile, &rows));
        } else {
            self.print(&profile, &rows);
        }
        Ok(())
    }

    fn wanted(&self, phase: Phase) -> bool {
        self.phase
            .map_or(phase.is_part_of_a_frame(), |only| only == phase)
    }

    /// The table's lines, most instructions first.
    fn rows(&self, profile: &Profile, places: &mut Places) -> Vec<(String, Work)> {
        let wanted = |phase| self.wanted(phase);
        let sums = profile.sum(wanted, |address| {
            let place = places.of(address);
            let file = if place.file.is_empty() {
                "?"
            } else {
                &place.file
            };
            match self.by {
                By::Function => format!("{}  {file}", place.function),
                By::Line => format!("{file}:{}", place.line),
                By::File => file.to_owned(),
                By::Symbol => place.symbol.clone(),
                By::Address => {
                    format!("{address:08x}  {file}:{}  {}", place.line, place.function)
                }
            }
        });
        let mut rows: Vec<_> = sums.into_iter().collect();
        rows.sort_by_key(|(_, work)| std::cmp::Reverse(work.instructions()));
        if self.by == By::Line {
            for (name, _) in rows.iter_mut().take(self.top) {
                let text = source_line(name);
                *name = format!("{name:<44}  {text}");
            }
        }
        rows
    }

    fn print(&self, profile: &Profile, rows: &[(String, Work)]) {
        let total = profile.total(|phase| self.wanted(phase));
        let all = total.instructions();
        let share = |n: u64| 100.0 * n as f64 / all.max(1) as f64;
        let cycles = Core::ALL.map(|core| {
            let millions = total.cycles(core) as f64 / 1e6;
            format!("{millions:.2} M cycles on a {}", core.name())
        });
        println!(
            "{} instructions, about {}",
            thousands(all),
            cycles.join(", ")
        );
        println!();
        for phase in Phase::ALL {
            let n = profile.total(|p| p == phase).instructions();
            if n > 0 {
                println!("{:>12}          {}", thousands(n), phase.name());
            }
        }
        println!();
        for class in Class::ALL {
            let n = total.ran[class];
            if n == 0 {
                continue;
            }
            let more = match class {
                Class::Branch => format!(", {} taken", thousands(total.taken)),
                Class::LoadMultiple | Class::StoreMultiple => {
                    format!(", {} registers", thousands(total.registers[class]))
                }
                _ => String::new(),
            };
            let share = share(n);
            println!("{:>12} {share:5.1} %  {}{more}", thousands(n), class.name());
        }
        println!();
        for (name, work) in rows.iter().take(self.top) {
            let n = work.instructions();
            println!("{:>12} {:5.1} %  {name}", thousands(n), share(n));
        }
        let rest: u64 = rows
            .iter()
            .skip(self.top)
            .map(|(_, work)| work.instructions())
            .sum();
        if rest > 0 {
            let more = rows.len() - self.top;
            println!(
                "{:>12} {:5.1} %  in {more} more (--top)",
                thousands(rest),
                share(rest)
            );
        }
    }

    fn object(&self, profile: &Profile, rows: &[(String, Work)]) -> serde_json::Value {
        let total = profile.total(|phase| self.wanted(phase));
        let phases: serde_json::Map<_, _> = Phase::ALL
            .into_iter()
            .map(|phase| {
                let n = profile.total(|p| p == phase).instructions();
                (phase.name().to_owned(), n.into())
            })
            .collect();
        let rows: Vec<_> = rows
            .iter()
            .map(|(name, work)| {
                let mut row = work_object(work);
                row["name"] = name.as_str().into();
                row
            })
            .collect();
        json!({ "total": work_object(&total), "phases": phases, "rows": rows })
    }
}

/// Work as JSON.
pub(crate) fn work_object(work: &Work) -> serde_json::Value {
    let by_class = |of: &dyn Fn(Class) -> u64| -> serde_json::Map<_, _> {
        let key = |class: Class| class.name().replace(' ', "_");
        Class::ALL
            .into_iter()
            .map(|class| (key(class), of(class).into()))
            .collect()
    };
    let cycles: serde_json::Map<_, _> = Core::ALL
        .into_iter()
        .map(|core| (core.name().to_owned(), work.cycles(core).into()))
        .collect();
    json!({
        "instructions": work.instructions(),
        "cycles": cycles,
        "classes": by_class(&|class| work.ran[class]),
        "registers": by_class(&|class| work.registers[class]),
        "branches_taken": work.taken,
    })
}

/// The text of `FILE:LINE`; empty when the file is not at hand.
fn source_line(name: &str) -> String {
    let text = name.rsplit_once(':').and_then(|(file, line)| {
        let text = fs::read_to_string(file).ok()?;
        let index = line.parse::<usize>().ok()?.checked_sub(1)?;
        Some(text.lines().nth(index)?.trim().to_owned())
    });
    text.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_go_by_their_names() {
        assert_eq!(phase("draw"), Ok(Phase::Draw));
        assert!(phase("paint").unwrap_err().contains("shading_tables"));
    }
}
