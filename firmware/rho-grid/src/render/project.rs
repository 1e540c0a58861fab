//! From homogeneous coordinates to the screen.
//!
//! Screen coordinates are *Q8*: 256 to the pixel, from the optical axis, x to the right and y
//! down. X, Y carry the focal length; X, Y and W have exponents of their own, chosen by the
//! [`View`](super::View) so that no point of the cube exceeds 2^29. With `n` leading zeros of W,
//!
//! ```text
//! x = (X * reciprocal(W << n >> 16) >> 18) >> (k - n)
//! ```
//!
//! where the frame's constant k gathers all exponents. The reciprocal is at most 2^-15 too large
//! (W is cut to 16 bits) and 2^-16 too small, and the shifts round down by at most one step:
//! [`slack`] bounds the sum, and whoever needs bounds of a cell adds it.

use crate::reciprocal::Reciprocal;

/// A point in homogeneous screen coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub(super) struct Homogeneous {
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) w: i32,
}

impl Homogeneous {
    pub(super) const ZERO: Self = Self { x: 0, y: 0, w: 0 };

    /// Sums stay below 2^30: both are points or differences of points of the cube.
    #[inline(always)]
    pub(super) fn plus(self, d: Self) -> Self {
        Self {
            x: self.x + d.x,
            y: self.y + d.y,
            w: self.w + d.w,
        }
    }
}

/// 1/W, ready to multiply.
#[derive(Clone, Copy, Debug)]
pub(super) struct OverW {
    /// 2^14 times the reciprocal.
    factor: i32,
    /// k - n, 0 to 31.
    shift: u32,
    /// n, at most 30.
    zeros: u32,
}

impl OverW {
    /// For W in 2^(31 - k) to 2^30 - 1.
    #[inline(always)]
    pub(super) fn new<R: Reciprocal>(w: i32, k: u32) -> Self {
        let n = w.leading_zeros();
        let factor = R::of((w << n) as u32 >> 16) << 14;
        Self {
            factor: factor as i32,
            shift: k.wrapping_sub(n) & 31,
            zeros: n & 31,
        }
    }

    /// v / W in Q8, rounded down.
    #[inline(always)]
    pub(super) fn times(self, v: i32) -> i32 {
        (((i64::from(v) * i64::from(self.factor)) >> 32) as i32) >> self.shift
    }

    /// Of a W below half of this one: v / W in Q24, rounded down.
    #[inline(always)]
    pub(super) fn times_itself_q24(self, v: i32) -> i32 {
        let high = ((i64::from(v) * i64::from(self.factor)) >> 32) as i32;
        let n = self.zeros;
        if n <= 6 {
            high >> (6 - n)
        } else {
            high << (n - 6)
        }
    }

    /// v / W in Q16, rounded down; of lengths below 2^14 pixels.
    #[inline(always)]
    pub(super) fn times_q16(self, v: i32) -> i32 {
        let high = ((i64::from(v) * i64::from(self.factor)) >> 32) as i32;
        if self.shift >= 8 {
            high >> (self.shift - 8)
        } else {
            high << (8 - self.shift)
        }
    }
}

/// How far [`OverW::times`] may be off, in Q8, for results of magnitude `reach` (Q8).
#[inline(always)]
pub(super) fn slack(reach: i32) -> i32 {
    // 2^-15 of it, and a step for each of the two shifts.
    (reach >> 15) + 3
}

/// A cell's bounds on the screen: centre and half extent, Q8. They hold the whole cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bounds {
    /// From the frame's left edge.
    pub x: i32,
    /// From the frame's upper edge.
    pub y: i32,
    /// Half the extent along x.
    pub half_x: i32,
    /// Half the extent along y.
    pub half_y: i32,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reciprocal::{Divide, Table};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_quotient_is_within_the_slack_of_the_exact_one(
            v in -(1 << 29)..(1i32 << 29), w in 1..(1i32 << 30), k in 2..33u32
        ) {
            prop_assume!(w.leading_zeros() <= k && k - w.leading_zeros() < 32);
            let q = OverW::new::<Divide>(w, k).times(v);
            let exact = f64::from(v) / f64::from(w) * 2f64.powi(30 - k as i32);
            prop_assert!((f64::from(q) - exact).abs() <= f64::from(slack(q.abs())), "{q} {exact}");
            prop_assert_eq!(OverW::new::<Table>(w, k).times(v), q);
        }

        #[test]
        fn a_part_of_itself_is_within_two_steps_of_the_exact_one(
            part in -0.5..0.5f64, w in 4..(1i32 << 30), k in 2..33u32
        ) {
            prop_assume!(w.leading_zeros() <= k && k - w.leading_zeros() < 32);
            let v = (part * f64::from(w)) as i32;
            let q = OverW::new::<Divide>(w, k).times_itself_q24(v);
            let exact = f64::from(v) / f64::from(w) * f64::from(1 << 24);
            // The reciprocal's 2^-15, and two shifts: a step of the product is 2^(n - 6) of these.
            let step = 2f64.powi(w.leading_zeros() as i32 - 6).max(1.0);
            let slack = exact.abs() / f64::from(1 << 15) + 2.0 * step;
            prop_assert!((f64::from(q) - exact).abs() <= slack, "{q} {exact}");
        }
    }
}
