//! What was measured, as tables in Markdown.

use std::fmt::Write;

use rho_viewer::count::Phase;

use super::Measured;
use crate::machine::Machine;
use crate::profile::cycles::Core;
use crate::profile::thumb::Class;
use crate::text::thousands;

/// The title over [`standard`].
pub const COST: &str = "Cost and quality";
/// The title over [`memory`].
pub const MEMORY: &str = "Memory, bytes";

/// A line of a table: the row's name, the view's, and what was measured.
pub type Line<'a> = (&'a str, &'a str, &'a Measured);

/// A table with these columns: the first two are text, the others numbers.
fn begin(columns: &[&str]) -> String {
    let mut table = format!("| {} |\n", columns.join(" | "));
    let ruler = columns
        .iter()
        .enumerate()
        .map(|(i, _)| if i < 2 { "---" } else { "---:" });
    let ruler: Vec<_> = ruler.collect();
    let _ = writeln!(table, "| {} |", ruler.join(" | "));
    table
}

fn line(table: &mut String, cells: &[String]) {
    let _ = writeln!(table, "| {} |", cells.join(" | "));
}

fn decibels(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.1}"))
}

/// Millions.
fn millions(number: u64) -> String {
    format!("{:.3}", number as f64 / 1e6)
}

/// Instructions and quality.
#[must_use]
pub fn standard(lines: &[Line<'_>]) -> String {
    const PHASES: [Phase; 6] = [
        Phase::Setup,
        Phase::Clear,
        Phase::Draw,
        Phase::Fill,
        Phase::ShadingTables,
        Phase::Send,
    ];
    let mut columns = vec!["what", "view", "instructions"];
    columns.extend(PHASES.map(Phase::name));
    columns.extend(["IoU", "dB union", "dB inside", "holes"]);
    let mut table = begin(&columns);
    for (name, view, measured) in lines {
        let Measured {
            phases, comparison, ..
        } = measured;
        let mut cells = vec![(*name).to_owned(), (*view).to_owned()];
        cells.push(thousands(phases.frame()));
        cells.extend(PHASES.map(|phase| thousands(phases.get(phase))));
        cells.push(format!("{:.3}", comparison.iou));
        cells.push(decibels(comparison.psnr_union));
        cells.push(decibels(comparison.psnr_inside));
        cells.push(comparison.holes.to_string());
        line(&mut table, &cells);
    }
    table
}

/// What each way in `ours` costs, in parts of what each in `others` costs in the same view.
#[must_use]
pub fn against(ours: &[Line<'_>], others: &[Line<'_>]) -> String {
    let mut columns = vec!["what", "view"];
    for (name, ..) in others {
        if !columns.contains(name) {
            columns.push(name);
        }
    }
    let mut table = begin(&columns);
    for (name, view, measured) in ours {
        let mut cells = vec![(*name).to_owned(), (*view).to_owned()];
        let same_view = others.iter().filter(|(_, other, _)| other == view);
        cells.extend(same_view.map(|(.., other)| {
            let part = measured.phases.frame() as f64 / other.phases.frame().max(1) as f64;
            format!("{part:.3}")
        }));
        line(&mut table, &cells);
    }
    table
}

/// What a way takes of the device, by its most expensive view.
#[must_use]
pub fn memory(lines: &[Line<'_>]) -> String {
    let mut table = begin(&["what", "for", "model", "program", "RAM", "stack"]);
    let mut done = Vec::new();
    for (name, _, measured) in lines {
        if done.contains(name) {
            continue;
        }
        done.push(name);
        let of_row = lines.iter().filter(|(other, ..)| other == name);
        let stack = of_row.map(|(.., m)| m.stack_bytes).max().unwrap_or(0);
        line(
            &mut table,
            &[
                (*name).to_owned(),
                "all views".to_owned(),
                thousands(measured.model_bytes as u64),
                thousands(measured.program_bytes),
                thousands(measured.ram_bytes),
                thousands(stack.into()),
            ],
        );
    }
    table
}

/// Instructions and cycles by core in millions, instructions by class in per cent; empty without
/// the plugin.
#[must_use]
pub fn classes(lines: &[Line<'_>]) -> String {
    let mut columns = vec!["what", "view", "instructions"];
    columns.extend(Core::ALL.map(Core::name));
    let classes = Class::ALL.into_iter().filter(|c| *c != Class::Float);
    columns.extend(classes.clone().map(Class::name));
    columns.extend(["taken", "registers moved at once"]);
    let mut table = begin(&columns);
    for (name, view, measured) in lines {
        let Some(work) = &measured.work else {
            continue;
        };
        let all = work.instructions();
        let share = |n: u64| format!("{:.1}", 100.0 * n as f64 / all.max(1) as f64);
        let mut cells = vec![(*name).to_owned(), (*view).to_owned(), millions(all)];
        cells.extend(Core::ALL.map(|core| millions(work.cycles(core))));
        cells.extend(classes.clone().map(|class| share(work.ran[class])));
        cells.push(share(work.taken));
        let several = [Class::LoadMultiple, Class::StoreMultiple];
        let moved: u64 = several.iter().map(|class| work.registers[*class]).sum();
        let by: u64 = several.iter().map(|class| work.ran[*class]).sum();
        cells.push(format!("{:.1}", moved as f64 / by.max(1) as f64));
        line(&mut table, &cells);
    }
    table
}

/// Instructions by core, from the same rows and views of each.
#[must_use]
pub fn cores(results: &[(Machine, Vec<(&str, String, Measured)>)]) -> String {
    let mut columns = vec!["what", "view"];
    columns.extend(results.iter().map(|(machine, _)| machine.core()));
    let mut table = begin(&columns);
    let first = results.first().map_or(&[][..], |(_, first)| first);
    for (i, (name, view, _)) in first.iter().enumerate() {
        let mut cells = vec![(*name).to_owned(), view.clone()];
        let of = results.iter().filter_map(|(_, all)| all.get(i));
        cells.extend(of.map(|(.., measured)| thousands(measured.phases.frame())));
        line(&mut table, &cells);
    }
    table
}

/// Cost against covered pixels and the model's size.
#[must_use]
pub fn growth(lines: &[(&str, &str, u64, &Measured)]) -> String {
    let mut table = begin(&[
        "what",
        "model, view",
        "triangles",
        "model bytes",
        "pixels",
        "instructions",
        "a pixel",
        "IoU",
        "holes",
    ]);
    for (name, view, triangles, measured) in lines {
        let instructions = measured.phases.frame();
        line(
            &mut table,
            &[
                (*name).to_owned(),
                (*view).to_owned(),
                thousands(*triangles),
                thousands(measured.model_bytes as u64),
                thousands(measured.pixels as u64),
                thousands(instructions),
                thousands(instructions / measured.pixels.max(1) as u64),
                format!("{:.3}", measured.comparison.iou),
                measured.comparison.holes.to_string(),
            ],
        );
    }
    table
}
