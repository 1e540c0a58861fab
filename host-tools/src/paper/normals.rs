//! Table 3: what is lost when normals become faces of a refined octahedron.

use glam::DVec3;
use rho_grid::normal::child;

use super::table;

/// Refinements of the octahedron, and what the paper prints for them.
const LEVELS: [(u32, f64); 5] = [(3, 0.017), (4, 0.004), (5, 0.001), (6, 2.6e-4), (7, 6.4e-5)];

/// Directions tried along each edge of an octant.
const GRID: u32 = 300;

/// The power of the highlight.
const EXPONENT: i32 = 10;

/// The errors of a refinement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// The largest 1 - n.q: the paper's statistic.
    pub papers: f64,
    /// The largest, mean and root mean square of |n.l - q.l| over lights that shine on it.
    pub lighting: [f64; 3],
    /// The largest of |(n.h)^10 - (q.h)^10|.
    pub highlight: f64,
}

/// The face's normal, after this many refinements, of the triangle that `d` (not negative) passes.
fn quantised(d: DVec3, level: u32) -> DVec3 {
    let mut t = [DVec3::X, DVec3::Y, DVec3::Z];
    for _ in 0..level {
        let [a, b, c] = t;
        let mids = [a + b, b + c, c + a].map(DVec3::normalize);
        let [ab, bc, ca] = mids;
        let beyond = |corner: DVec3, p: DVec3, q: DVec3| {
            let n = p.cross(q);
            (n * n.dot(corner).signum()).dot(d) > 0.0
        };
        let corners = [beyond(a, ab, ca), beyond(b, bc, ab), beyond(c, ca, bc)];
        let which = corners.iter().position(|cut| *cut).map_or(0, |c| c + 1);
        t = child(which, t, mids);
    }
    let [a, b, c] = t;
    let n = (b - a).cross(c - a).normalize();
    n * n.dot(d).signum()
}

/// Directions spread evenly over the sphere (a spiral of the golden angle).
fn sphere(count: u32) -> impl Iterator<Item = DVec3> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count).map(move |i| {
        let y = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(count);
        let (sin, cos) = (golden * f64::from(i)).sin_cos();
        let r = (1.0 - y * y).sqrt();
        DVec3::new(r * cos, y, r * sin)
    })
}

/// The errors of a refinement, over directions of an octant and lights from everywhere.
#[must_use]
pub fn errors(level: u32) -> Errors {
    let mut errors = Errors::default();
    for i in 0..=GRID {
        for j in 0..=GRID - i {
            let [x, y] = [i, j].map(f64::from);
            let d = DVec3::new(x, y, f64::from(GRID) - x - y).normalize();
            errors.papers = errors.papers.max(1.0 - d.dot(quantised(d, level)));
        }
    }
    let lights: Vec<_> = sphere(200).collect();
    let (mut sum, mut square, mut count) = (0.0, 0.0, 0u32);
    for n in sphere(4000).map(DVec3::abs) {
        let q = quantised(n, level);
        // The light's side of the surface; lights and halfway vectors are spread alike.
        for light in lights.iter().filter(|light| n.dot(**light) > 0.0) {
            let (exact, drawn) = (n.dot(*light), q.dot(*light).max(0.0));
            let error = (exact - drawn).abs();
            let highlight = (exact.powi(EXPONENT) - drawn.powi(EXPONENT)).abs();
            errors.lighting[0] = errors.lighting[0].max(error);
            errors.highlight = errors.highlight.max(highlight);
            sum += error;
            square += error * error;
            count += 1;
        }
    }
    errors.lighting[1] = sum / f64::from(count.max(1));
    errors.lighting[2] = (square / f64::from(count.max(1))).sqrt();
    errors
}

/// Table 3: the paper's statistic, and the errors of what is seen.
#[must_use]
pub fn table_3() -> String {
    let rows: Vec<_> = LEVELS
        .iter()
        .map(|(level, printed)| {
            let errors = errors(*level);
            let [most, mean, rms] = errors.lighting;
            let mut row = vec![format!("{level} ({} bits)", 2 * level + 3)];
            row.extend(
                [errors.papers, *printed, most, mean, rms, errors.highlight]
                    .map(|e| format!("{e:.5}")),
            );
            row
        })
        .collect();
    table(
        &[
            "level",
            "largest 1 - n.q",
            "printed",
            "largest n.l - q.l",
            "mean",
            "root mean square",
            "largest error of a highlight, exponent 10",
        ],
        &rows,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantise::normal_index;
    use rho_grid::normal::normal;

    #[test]
    fn level_5_is_what_blobs_have() {
        for n in sphere(500).map(DVec3::abs) {
            let [x, y, z] = normal(normal_index(n)).map(|c| f64::from(c.to_bits()) / 16384.0);
            assert!(quantised(n, 5).distance(DVec3::new(x, y, z)) < 2e-4);
        }
    }

    #[test]
    fn the_papers_statistic_is_found_and_the_error_of_lighting_is_of_the_first_order() {
        let errors = errors(4);
        assert!((0.0035..0.0045).contains(&errors.papers), "{errors:?}");
        assert!(errors.lighting[0] > 10.0 * errors.papers, "{errors:?}");
    }
}
