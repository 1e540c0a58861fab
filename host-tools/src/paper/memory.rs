//! Tables 1 and 4: what a model takes.

use super::models::{MODELS, contents, tri_grid};
use super::table;
use crate::contents::Contents;
use crate::failure::Outcome;
use crate::text::{size, thousands};

/// Bits of an attribute, the rows of Table 1.
const SIGMAS: [u32; 7] = [0, 4, 8, 12, 16, 32, 48];

/// Each rho, and how often it divides the cube for the measurement: 125 to 256 cells an axis.
const RHOS: [(u32, usize); 4] = [(2, 8), (3, 5), (4, 4), (5, 3)];

/// Table 1 as printed.
const PRINTED: [[f64; 4]; 7] = [
    [2.66, 3.38, 4.26, 5.21],
    [4.0, 3.88, 4.53, 5.375],
    [5.33, 4.38, 4.8, 5.54],
    [6.67, 4.88, 5.06, 5.71],
    [8.0, 5.38, 5.33, 5.88],
    [13.33, 7.38, 6.4, 6.54],
    [18.67, 9.38, 7.47, 7.21],
];

/// Bits a leaf of what stands above the leaves, by the paper's formula of section 4.3.2 with d = 2.
#[must_use]
pub fn formula(rho: u32, sigma: u32) -> f64 {
    f64::from(sigma + rho.pow(3)) / (f64::from(rho).powi(2) - 1.0)
}

/// The same of a grid: a mask of rho^3 bits and an attribute for every node above the leaves.
fn measured(contents: &Contents, rho: u32, sigma: u32) -> f64 {
    let inner = (contents.nodes - contents.leaf_samples) as f64;
    f64::from(sigma + rho.pow(3)) * inner / contents.leaf_samples as f64
}

/// Table 1: the formula, what is printed, and what each model has.
///
/// # Errors
/// Those of baking.
pub fn table_1(done: &dyn Fn()) -> Outcome<String> {
    let mut columns = vec!["bits an attribute".to_owned()];
    for what in ["formula", "printed"]
        .into_iter()
        .chain(MODELS.map(|m| m.name))
    {
        columns.extend(RHOS.map(|(rho, _)| format!("{what} rho {rho}")));
    }
    let mut grids = Vec::new();
    for model in MODELS {
        for (rho, subdivisions) in RHOS {
            let flags = format!("--rho {rho} --subdivisions {subdivisions}");
            let blob = model.baked(&flags)?;
            grids.push((rho, contents(&blob, model.name)?));
            done();
        }
    }
    let rows: Vec<_> = SIGMAS
        .iter()
        .zip(PRINTED)
        .map(|(sigma, printed)| {
            let mut row = vec![sigma.to_string()];
            row.extend(RHOS.map(|(rho, _)| format!("{:.2}", formula(rho, *sigma))));
            row.extend(printed.map(|bits| format!("{bits:.2}")));
            let of = grids.iter();
            row.extend(of.map(|(rho, grid)| format!("{:.2}", measured(grid, *rho, *sigma))));
            row
        })
        .collect();
    let columns: Vec<_> = columns.iter().map(String::as_str).collect();
    Ok(table(&columns, &rows))
}

/// Table 4: samples, alpha and bytes at the paper's levels 3, 4 and 5.
///
/// # Errors
/// Those of baking.
pub fn table_4(done: &dyn Fn()) -> Outcome<String> {
    let mut rows = Vec::new();
    for model in MODELS {
        for (level, printed) in (3..).zip(model.printed) {
            let blob = model.baked(&tri_grid(level))?;
            let contents = contents(&blob, model.name)?;
            let alpha = contents.grids.first().map_or(0.0, |grid| grid.alpha);
            rows.push(vec![
                format!("{} ({level})", model.name),
                thousands(contents.nodes),
                format!("{:.0} k", printed.samples),
                format!("{alpha:.2}"),
                format!("{:.2}", printed.alpha),
                size(blob.len() as u64),
                format!("{:.0} kB", printed.file),
                format!("{:.2}", blob.len() as f64 / 1e3 / printed.file),
            ]);
            done();
        }
    }
    Ok(table(
        &[
            "model (level)",
            "samples",
            "printed",
            "alpha",
            "printed",
            "blob",
            "printed file",
            "blob to file",
        ],
        &rows,
    ))
}

/// How often `done` is called by both tables.
pub const STEPS: usize = MODELS.len() * (RHOS.len() + 3);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_formula_gives_the_papers_numbers() {
        for (sigma, printed) in SIGMAS.iter().zip(PRINTED) {
            for ((rho, _), bits) in RHOS.iter().zip(printed) {
                let ours = formula(*rho, *sigma);
                assert!((ours - bits).abs() < 0.011, "{rho} {sigma}: {ours} {bits}");
            }
        }
    }
}
