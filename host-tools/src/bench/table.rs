//! What was measured, as tables in Markdown.

use std::fmt::Write;

use rho_viewer::count::Phase;

use super::{Figure, Measured};
use crate::machine::Machine;
use crate::profile::cycles::Core;
use crate::profile::thumb::Class;
use crate::text::thousands;

/// The title over [`standard`].
pub const COST: &str = "Cost and quality";
/// The title over [`memory`].
pub const MEMORY: &str = "Memory, bytes";

/// A table with these columns: the first two are text, the others numbers.
fn begin(columns: &[&str]) -> String {
    let mut table = format!("| {} |\n", columns.join(" | "));
    let ruler: Vec<_> = (0..columns.len())
        .map(|i| if i < 2 { "---" } else { "---:" })
        .collect();
    let _ = writeln!(table, "| {} |", ruler.join(" | "));
    table
}

fn line(table: &mut String, cells: &[String]) {
    let _ = writeln!(table, "| {} |", cells.join(" | "));
}

/// The first cells of a figure's line.
fn begin_line(figure: &Figure) -> Vec<String> {
    vec![figure.row.to_owned(), figure.view.clone()]
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
pub fn standard(figures: &[Figure]) -> String {
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
    for figure in figures {
        let Measured {
            phases, comparison, ..
        } = &figure.measured;
        let mut cells = begin_line(figure);
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
pub fn against(ours: &[&Figure], others: &[&Figure]) -> String {
    let mut columns = vec!["what", "view"];
    for other in others {
        if !columns.contains(&other.row) {
            columns.push(other.row);
        }
    }
    let mut table = begin(&columns);
    for figure in ours {
        let mut cells = begin_line(figure);
        let same_view = others.iter().filter(|other| other.view == figure.view);
        cells.extend(same_view.map(|other| {
            let [ours, theirs] = [figure, other].map(|f| f.measured.phases.frame() as f64);
            format!("{:.3}", ours / theirs)
        }));
        line(&mut table, &cells);
    }
    table
}

/// What a way takes of the device, its stack in the view that needs most.
#[must_use]
pub fn memory(figures: &[Figure]) -> String {
    let mut table = begin(&["what", "for", "model", "program", "RAM", "stack"]);
    let mut done = Vec::new();
    for Figure { row, measured, .. } in figures {
        if done.contains(row) {
            continue;
        }
        done.push(row);
        let of_row = figures.iter().filter(|other| other.row == *row);
        let stack = of_row.map(|f| f.measured.stack_bytes).max().unwrap_or(0);
        let numbers = [
            measured.model_bytes as u64,
            measured.program_bytes,
            measured.ram_bytes,
            stack.into(),
        ];
        let mut cells = vec![(*row).to_owned(), "all views".to_owned()];
        cells.extend(numbers.map(thousands));
        line(&mut table, &cells);
    }
    table
}

/// Instructions and cycles by core in millions, instructions by class in per cent; empty without
/// the plugin.
#[must_use]
pub fn classes(figures: &[Figure]) -> String {
    let mut columns = vec!["what", "view", "instructions"];
    columns.extend(Core::ALL.map(Core::name));
    let classes = Class::ALL.into_iter().filter(|c| *c != Class::Float);
    columns.extend(classes.clone().map(Class::name));
    columns.extend(["taken", "registers moved at once"]);
    let mut table = begin(&columns);
    for figure in figures {
        let Some(work) = &figure.measured.work else {
            continue;
        };
        let all = work.instructions();
        let share = |n: u64| format!("{:.1}", 100.0 * n as f64 / all.max(1) as f64);
        let mut cells = begin_line(figure);
        cells.push(millions(all));
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
pub fn cores(figures: &[(Machine, Vec<Figure>)]) -> String {
    let mut columns = vec!["what", "view"];
    columns.extend(figures.iter().map(|(machine, _)| machine.core()));
    let mut table = begin(&columns);
    let first = figures.first().map_or(&[][..], |(_, first)| first);
    for (i, figure) in first.iter().enumerate() {
        let mut cells = begin_line(figure);
        let same = figures.iter().filter_map(|(_, all)| all.get(i));
        cells.extend(same.map(|figure| thousands(figure.measured.phases.frame())));
        line(&mut table, &cells);
    }
    table
}

/// Cost against covered pixels and the model's size.
#[must_use]
pub fn growth(figures: &[(u64, Figure)]) -> String {
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
    for (triangles, figure) in figures {
        let measured = &figure.measured;
        let instructions = measured.phases.frame();
        let numbers = [
            *triangles,
            measured.model_bytes as u64,
            measured.pixels as u64,
            instructions,
            instructions / measured.pixels.max(1) as u64,
        ];
        let mut cells = begin_line(figure);
        cells.extend(numbers.map(thousands));
        cells.push(format!("{:.3}", measured.comparison.iou));
        cells.push(measured.comparison.holes.to_string());
        line(&mut table, &cells);
    }
    table
}
