//! Table 2: operations a sample.

use super::models::{MODELS, contents};
use super::rendering::{Device, ONE_PASS, POINTS};
use super::table;
use crate::failure::Outcome;
use crate::text::thousands;
use crate::view::{StandardView, View};

/// Each rho, how often it divides the cube, and what the paper prints for points and for points with
/// shadows.
const RHOS: [(u32, usize, f64, f64); 4] = [
    (2, 8, 6.6, 10.7),
    (3, 5, 6.7, 10.1),
    (4, 4, 7.5, 10.6),
    (5, 3, 8.4, 11.5),
];

/// Section 5.4: so many additions a subcell, and a shift for each of the rho^3, by leaf; d = 2.
#[must_use]
pub fn formula(rho: u32, additions: u32) -> f64 {
    let square = f64::from(rho.pow(2));
    (f64::from(additions) * square + f64::from(rho.pow(3))) / (square - 1.0)
}

/// Table 2: the formula, what is printed, and the device's instructions a leaf of the bunny near.
///
/// # Errors
/// Those of baking and of the device.
pub fn table_2(device: &Device, done: &dyn Fn()) -> Outcome<String> {
    let [bunny, ..] = MODELS;
    let near = View::from(StandardView::Near);
    let mut rows = Vec::new();
    for (rho, subdivisions, points, shadows) in RHOS {
        let blob = bunny.baked(&format!("--rho {rho} --subdivisions {subdivisions}"))?;
        let leaves = contents(&blob, bunny.name)?.leaf_samples;
        let mut row = vec![format!("{rho}"), thousands(leaves)];
        for (additions, printed, flags) in [(3, points, POINTS), (6, shadows, ONE_PASS)] {
            let run = device.draw(&blob, flags, &near)?;
            let instructions = run.report.phases.frame() as f64 / leaves as f64;
            row.push(format!("{:.2}", formula(rho, additions)));
            row.push(format!("{printed:.1}"));
            row.push(format!("{instructions:.1}"));
            done();
        }
        rows.push(row);
    }
    Ok(table(
        &[
            "rho",
            "leaves",
            "points: formula",
            "printed",
            "instructions",
            "with shadows: formula",
            "printed",
            "instructions",
        ],
        &rows,
    ))
}

/// How often `done` is called.
pub const STEPS: usize = 2 * RHOS.len();

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_formula_is_the_papers_to_the_digit_that_it_prints() {
        for (rho, _, points, shadows) in RHOS {
            // Printed numbers are cut or rounded.
            assert!((formula(rho, 3) - points).abs() < 0.1, "{rho}");
            assert!((formula(rho, 6) - shadows).abs() < 0.1, "{rho}");
        }
    }
}
