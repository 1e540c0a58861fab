//! Samples as discs in their tangent planes.
//!
//! Botsch, Wiratanaya, Kobbelt 2002, section 5: a sample is a disc round its point, perpendicular to
//! its normal, moved along the normal by the offset attribute. On the screen it is an ellipse. Within
//! a block the projection is affine: with A the 2 x 3 matrix whose columns are the block's steps,
//!
//! ```text
//! v = A n                      the normal, one cell's side long, on the screen
//! centre + v s                 the sample moved by s sides
//! S = r^2 (A A^T - v v^T)      the ellipse's matrix, r the disc's radius in sides
//! p^T S^-1 p <= 1              p belongs to it
//! px = S12 py / S22 +- sqrt(det S) / S22 * sqrt(S22 - py^2)        in a row: where this begins and ends
//! ```
//!
//! since the disc is the unit ball's shadow along n. So a sample costs six multiplications for v,
//! five for S and its determinant and two divisions, and a row a root, which is looked up, and two
//! multiplications.
//!
//! Numbers are kept in the block's own unit, chosen so that the longest step has 15 bits: the
//! ellipse's radius has 7 then, squares 14, products 28.

use super::view::{Half, Step};
use super::visibility::{Shape, Span};
use crate::blob::Layout;
use crate::normal::normal;

/// The disc's radius squared, in sides of a cell, times 256: r = 0.87 leaves hardly a hole between
/// thin leaves, whose lattice needs that where two axes are alike, and larger ones cost silhouette.
const RADIUS_SQUARED: i32 = 193;

/// What a block's discs have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct Discs {
    /// The steps, 15 bits and sign.
    steps: [Step; 3],
    /// A step's unit is 2^exponent / 65536 pixel; an ellipse's is 512 times that.
    exponent: u32,
    /// A A^T in the ellipse's unit: xx, xy, yy.
    ball: [i32; 3],
    layout: Layout,
}

/// A disc on the screen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ellipse {
    /// Its centre, Q16.
    pub(super) centre: Step,
    /// S: xx and yy.
    matrix: [i32; 2],
    /// Along x a row's middle, by y, and its half width, by a root of y ([`Shape::row`]): Q16.
    middle: i32,
    half_width: i32,
    /// Shift from Q16 to the ellipse's unit.
    shift: u32,
}

impl Discs {
    pub(super) const NONE: Self = Self {
        steps: [Step { x: 0, y: 0 }; 3],
        exponent: 0,
        ball: [0; 3],
        layout: Layout::MATERIAL,
    };

    /// For cells at these steps, Q16; `None` when they are larger than a hundred pixels.
    #[inline(always)]
    pub(super) fn new(steps: &[Step; 3], layout: Layout) -> Option<Self> {
        let longest = steps
            .iter()
            .fold(0, |most, s| most | s.x.unsigned_abs() | s.y.unsigned_abs());
        let exponent = (32 - longest.leading_zeros()).saturating_sub(15);
        if exponent > 7 {
            return None;
        }
        let steps = steps.map(|s| Step {
            x: s.x >> exponent,
            y: s.y >> exponent,
        });
        let dot = |a: fn(&Step) -> i32, b: fn(&Step) -> i32| {
            let sum: i64 = steps
                .iter()
                .map(|s| i64::from(a(s)) * i64::from(b(s)))
                .sum();
            (sum >> 18) as i32
        };
        Some(Self {
            ball: [
                dot(|s| s.x, |s| s.x),
                dot(|s| s.x, |s| s.y),
                dot(|s| s.y, |s| s.y),
            ],
            steps,
            exponent,
            layout,
        })
    }

    /// Half extents, Q8, from a cell's centre, of what any disc in it may reach.
    #[inline(always)]
    pub(super) fn reach(&self) -> Half {
        let [xx, _, yy] = self.ball;
        // 1.26 sides with an offset range of 0.87, 1.03 with 0.5.
        let wider = if self.layout.offset_range > 64 {
            323
        } else {
            264
        };
        let half = |square: i32| (((root(square) << self.exponent) * wider) >> 7) + 2;
        Half {
            x: half(xx),
            y: half(yy),
        }
    }

    /// The disc of the sample with this attribute word in the cell centred at `at`.
    #[inline(always)]
    pub(super) fn ellipse(&self, at: Step, word: u32) -> Ellipse {
        let n = normal(self.layout.normal_13(word)).map(|c| i32::from(c.to_bits()));
        let [nx, ny, nz] = n;
        let [sx, sy, sz] = self.steps;
        // 15 + 14 bits, three of them.
        let vx = (nx * sx.x + ny * sy.x + nz * sz.x) >> 14;
        let vy = (nx * sx.y + ny * sy.y + nz * sz.y) >> 14;
        let moved = self.layout.offset_q8(word);
        let [bxx, bxy, byy] = self.ball;
        // |v| is below 2^16: its squares are taken unsigned.
        let square = |v: i32| ((v.unsigned_abs() * v.unsigned_abs()) >> 18) as i32;
        let part = |ball: i32, vv: i32| ((ball - vv) * RADIUS_SQUARED) >> 8;
        // Seen from its edge a disc is a line; at least this thick it holds the pixels it crosses.
        let xx = part(bxx, square(vx)).max(1);
        let yy = part(byy, square(vy)).max(1);
        let xy = part(bxy, ((vx >> 1) * (vy >> 1)) >> 16);
        let determinant = (xx * yy - xy * xy).max(0) as u32;
        Ellipse {
            centre: Step {
                x: at.x + (((vx * moved) >> 8) << self.exponent),
                y: at.y + (((vy * moved) >> 8) << self.exponent),
            },
            matrix: [xx, yy],
            // At most the half extents, 7 bits, when multiplied by y or its root.
            middle: (xy << 16) / yy,
            half_width: ((fine_root(determinant) << 12) / yy as u32) as i32,
            shift: self.exponent + 9,
        }
    }
}

impl Ellipse {
    /// Half extents along x and y, Q16, rounded up.
    #[inline(always)]
    pub(super) fn half(&self) -> Step {
        let [xx, yy] = self.matrix;
        Step {
            x: root(xx) << self.shift,
            y: root(yy) << self.shift,
        }
    }
}

impl Shape for Ellipse {
    #[inline(always)]
    fn row(&self, y: u32) -> Span {
        let [_, yy] = self.matrix;
        // From the centre to the row's pixels' centres.
        let dy = (((y << 16) + 32768) as i32 - self.centre.y) >> self.shift;
        let square = yy - dy * dy;
        if square < 0 {
            return Span::NONE;
        }
        let middle = self.centre.x + ((self.middle * dy) >> (16 - self.shift));
        // Q16 by a root in sixteenths.
        let half = (self.half_width * fine_root(square as u32) as i32) >> (20 - self.shift);
        Span {
            first: (middle - half + 32767) >> 16,
            last: (middle + half - 32768) >> 16,
        }
    }
}

/// The square root of a number below 2^28, in sixteenths: exact to three of these and from a 50,000th less to a
/// hundredth more.
#[inline(always)]
fn fine_root(square: u32) -> u32 {
    // Of the numbers from 2^30 on the root has 16 bits.
    let zeros = (square | 1).leading_zeros() & !1;
    let root = FINE_ROOTS.get((square << zeros >> 24) as usize);
    (u32::from(root.copied().unwrap_or(u16::MAX)) << 4) >> (zeros / 2)
}

/// By the upper eight of 32 bits: the roots of the greatest numbers that have them, rounded up.
#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
static FINE_ROOTS: [u16; 256] = {
    let mut roots = [0; 256];
    let mut i = 0u32;
    while i < 256 {
        let root = ((i as u64 + 1) << 24).isqrt();
        roots[i as usize] = if root < 65535 { root + 1 } else { 65535 } as u16;
        i += 1;
    }
    roots
};

/// A length of which this is the square, rounded up.
#[inline(always)]
fn root(square: i32) -> i32 {
    (fine_root(square as u32) as i32 + 16) >> 4
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn roots_are_rounded_up_and_by_little() {
        for square in 0..16384 {
            let (root, exact) = (f64::from(root(square)), f64::from(square).sqrt());
            assert!(root >= exact, "{square}");
            assert!(root <= exact * 1.01 + 1.2, "{square}: {root}");
        }
    }

    #[test]
    fn fine_roots_are_exact_to_a_hundredth_and_a_sixteenth() {
        for square in (0..1 << 28).step_by(997).chain(0..4096) {
            let (root, exact) = (
                f64::from(fine_root(square)) / 16.0,
                f64::from(square).sqrt(),
            );
            assert!(root > exact * 0.99998 - 1.0 / 16.0, "{square}: {root}");
            assert!(root < exact * 1.01 + 3.0 / 16.0, "{square}: {root}");
        }
    }

    /// Steps of a cell of `side` pixels, turned about two axes.
    fn steps(side: f64, yaw: f64, pitch: f64) -> [[f64; 2]; 3] {
        let (sy, cy) = yaw.sin_cos();
        let (sp, cp) = pitch.sin_cos();
        [
            [cy * side, sy * sp * side],
            [0.0, -cp * side],
            [-sy * side, cy * sp * side],
        ]
    }

    proptest! {
        #[test]
        fn an_ellipse_is_the_discs_shadow(
            side in 0.3..60.0f64, yaw in -3.0..3.0f64, pitch in -1.5..1.5f64,
            index in 0..8192u32, step in 0..8u32, dx in -1.2..1.2f64, dy in -1.2..1.2f64
        ) {
            let exact = steps(side, yaw, pitch);
            let q16 = exact.map(|[x, y]| Step {
                x: (x * 65536.0).round() as i32,
                y: (y * 65536.0).round() as i32,
            });
            let layout = Layout::OFFSET_THIN;
            let discs = Discs::new(&q16, layout).unwrap();
            let ellipse = discs.ellipse(Step::default(), layout.pack(index, step, 0, 0));
            let n = normal(index).map(|c| f64::from(c.to_bits()) / 16384.0);
            let v: [f64; 2] = core::array::from_fn(|k| (0..3).map(|i| n[i] * exact[i][k]).sum());

            // The centre is where the normal and the offset say, to a fiftieth of a side.
            let sides = (2.0 * f64::from(step) + 1.0) / 8.0 - 1.0;
            let centre = [ellipse.centre.x, ellipse.centre.y].map(|c| f64::from(c) / 65536.0);
            for k in 0..2 {
                prop_assert!((centre[k] - v[k] * sides * 0.5).abs() < side / 50.0 + 0.01);
            }

            // Seen neither from its edge nor at it, a point is in or out as the exact one is.
            let dot = |a: usize, b: usize| -> f64 { (0..3).map(|i| exact[i][a] * exact[i][b]).sum() };
            let r2 = f64::from(RADIUS_SQUARED) / 256.0;
            let (xx, xy, yy) = (
                r2 * (dot(0, 0) - v[0] * v[0]),
                r2 * (dot(0, 1) - v[0] * v[1]),
                r2 * (dot(1, 1) - v[1] * v[1]),
            );
            let det = xx * yy - xy * xy;
            prop_assume!(det > 0.04 * side.powi(4));
            let (px, py) = (dx * side, dy * side);
            let value = (yy * px * px - 2.0 * xy * px * py + xx * py * py) / det;
            let row = |x: f64, y: f64| {
                // A pixel's centre there: the shape is asked by pixel, so it is moved instead.
                let moved = Ellipse {
                    centre: Step {
                        x: 32768 - (x * 65536.0) as i32,
                        y: 32768 - (y * 65536.0) as i32,
                    },
                    ..ellipse
                };
                !moved.row(0).within(0, 0).is_empty()
            };
            if value < 0.85 {
                prop_assert!(row(px, py), "{value}");
            } else if value > 1.2 {
                prop_assert!(!row(px, py), "{value}");
            }
            // And the half extents hold it.
            let half = ellipse.half();
            prop_assert!(f64::from(half.x) / 65536.0 >= xx.sqrt() * 0.97);
            prop_assert!(f64::from(half.y) / 65536.0 >= yy.sqrt() * 0.97);
        }
    }
}
