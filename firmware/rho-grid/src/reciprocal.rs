//! 1/w, by the core's divider or by a table: the same integer either way.
//!
//! The paper, section 6.1, shifts a number until a small table serves it. Here every w is
//! *normalised* to 16 bits, and the reciprocal is
//!
//! ```text
//! reciprocal(n) = floor((2^32 - 1) / n),   n in 32768..=65535,   result in 65537..=131071
//! ```
//!
//! exact by UDIV, and by the table after one correction, which a test proves for every n.

use core::num::NonZeroU32;

/// How a core finds the reciprocal; the renderer is compiled for one.
pub trait Reciprocal {
    /// `floor((2^32 - 1) / n)` for n in 32768..=65535.
    fn of(n: u32) -> u32;
}

/// The core's divide instruction (or the compiler's routine where there is none).
#[derive(Clone, Copy, Debug)]
pub struct Divide;

/// The shifted table with one correction: two multiplications and no division.
#[derive(Clone, Copy, Debug)]
pub struct Table;

impl Reciprocal for Divide {
    #[inline(always)]
    fn of(n: u32) -> u32 {
        // The top bit is set already; saying so spares a test for 0.
        match NonZeroU32::new(n | 1 << 15) {
            Some(n) => u32::MAX / n,
            None => 0,
        }
    }
}

/// Entry i is the reciprocal's value at n = 32768 + 64 i in steps of 1/8, less one: chords of the
/// convex 1/n lie above it by less than 1/4, so interpolation starts at most 1 too low.
static KNOTS: [u32; 514] = knots();

impl Reciprocal for Table {
    #[inline(always)]
    fn of(n: u32) -> u32 {
        let i = (n >> 6).wrapping_sub(512) as usize;
        let (a, b) = match KNOTS.get(i..) {
            Some([a, b, ..]) => (*a, *b),
            _ => (0, 0),
        };
        let fraction = n & 63;
        // Between two knots, from eighths down to whole numbers, never above the true quotient.
        let estimate = (a - ((a - b) * fraction).div_ceil(64)) >> 3;
        // The one correction.
        let rest = u32::MAX.wrapping_sub(estimate.wrapping_mul(n));
        estimate + u32::from(rest >= n)
    }
}

#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
const fn knots() -> [u32; 514] {
    let mut knots = [0; 514];
    let mut i = 0;
    while i < knots.len() {
        let n = 32768 + 64 * i as u64;
        // Less 2 eighths: more than the chord's excess of 1/4 at most.
        knots[i] = ((0xFFFF_FFFF * 8) / n) as u32 - 2;
        i += 1;
    }
    knots
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_gives_the_dividers_integer_for_every_number() {
        for n in 32768..=65535 {
            assert_eq!(Table::of(n), Divide::of(n), "1/{n}");
        }
    }
}
