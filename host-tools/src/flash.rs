//! The finest grid whose blob fits into so many bytes of flash.
//!
//! A surface has about cells^2 leaves, so the size of a blob is foreseen, the finest one that
//! should fit is baked, and its true size corrects what is foreseen of its neighbours. One or two
//! bakes are the rule: the second only when the next finer one may fit after all.

use crate::failure::Outcome;
use crate::sampling::{MAX_CELLS, Sequence};

/// Foresight is believed when it is over the limit by more than this: leaves of a body's surface
/// are foreseen within 5 %, and once one grid is known its neighbours nearer than that.
const DOUBT: f64 = 1.1;

/// The tops of the mixed sequences, above nothing but 3s.
const TOPS: [&[u8]; 6] = [&[], &[2], &[4], &[5], &[2, 4], &[2, 5]];

/// Sequences that end in 3,3 below a 2, 4 or 5, two of them, or more 3s; from 9 cells an axis up,
/// each at most 5/4 to 3/2 of the one before.
#[must_use]
pub fn mixed() -> Vec<Sequence> {
    let mut all: Vec<Sequence> = TOPS
        .iter()
        .flat_map(|top| {
            (2..=7).filter_map(|threes| Sequence::new(&[top, &[3; 7][..threes]].concat()).ok())
        })
        .collect();
    all.sort_by_key(Sequence::cells);
    all
}

/// `rho` once, twice and so on, up to [`MAX_CELLS`] cells an axis.
#[must_use]
pub fn powers(rho: u8) -> Vec<Sequence> {
    (1..=MAX_CELLS.ilog2() as usize)
        .map_while(|n| Sequence::new(&vec![rho; n]).ok())
        .collect()
}

/// What was found among the candidates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Found<T> {
    /// The finest that fits, and what baking it gave.
    Fits(usize, T),
    /// None fits; the coarsest one's bytes.
    NeedsAtLeast(u64),
}

/// Finds the finest of `candidates` whose blob has at most `limit` bytes. They are in the order
/// of their sizes; `foreseen` is what each is thought to have, and `bake` tells the truth.
///
/// # Errors
/// Whatever `bake` fails with.
pub fn finest<T>(
    foreseen: &[u64],
    limit: u64,
    mut bake: impl FnMut(usize) -> Outcome<(u64, T)>,
) -> Outcome<Found<T>> {
    let mut fits = None;
    let mut least = 0;
    // What is still open: `low..high`.
    let (mut low, mut high) = (0, foreseen.len());
    // The last one baked: foreseen bytes become true ones by this factor.
    let mut factor = 1.0;
    while low < high {
        let expected = |i: usize| factor * foreseen[i] as f64;
        let next = match (low..high).rfind(|&i| expected(i) <= limit as f64) {
            Some(next) => next,
            None if fits.is_some() && expected(low) > DOUBT * limit as f64 => break,
            None => low,
        };
        let (bytes, made) = bake(next)?;
        factor = bytes as f64 / foreseen[next].max(1) as f64;
        if bytes <= limit {
            fits = Some((next, made));
            low = next + 1;
        } else {
            least = bytes;
            high = next;
        }
    }
    Ok(match fits {
        Some((index, made)) => Found::Fits(index, made),
        None => Found::NeedsAtLeast(least),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The choice among blobs of these true sizes, and how many were baked for it.
    fn choose(foreseen: &[u64], truth: &[u64], limit: u64) -> (Found<usize>, usize) {
        let mut bakes = 0;
        let found = finest(foreseen, limit, |i| {
            bakes += 1;
            Ok((truth[i], i))
        });
        (found.unwrap(), bakes)
    }

    #[test]
    fn mixed_sequences_rise_in_small_steps_and_end_in_3_3() {
        let cells: Vec<u32> = mixed().iter().map(Sequence::cells).collect();
        assert!(cells.starts_with(&[9, 18, 27, 36, 45, 54, 72, 81, 90, 108, 135, 162, 216, 243]));
        assert!(cells.is_sorted_by(|a, b| a < b && b <= &(2 * a)));
        assert_eq!(cells.last(), Some(&3645));
        assert!(mixed().iter().all(|s| s.as_slice().ends_with(&[3, 3])));
    }

    #[test]
    fn powers_end_at_the_most_cells() {
        assert_eq!(powers(2).len(), 12);
        assert_eq!(powers(3).last().map(Sequence::cells), Some(2187));
        assert_eq!(powers(5).last().map(Sequence::cells), Some(3125));
    }

    #[test]
    fn when_foresight_is_good_one_bake_suffices() {
        let sizes = [100, 400, 900, 1600, 2500];
        assert_eq!(choose(&sizes, &sizes, 1000), (Found::Fits(2, 2), 1));
        assert_eq!(choose(&sizes, &sizes, 1_000_000), (Found::Fits(4, 4), 1));
    }

    #[test]
    fn foresight_that_is_off_by_far_still_ends_at_the_finest() {
        let foreseen: Vec<u64> = (1..30).map(|i| 100 * i * i).collect();
        for wrong in [0.1, 0.5, 0.93, 1.0, 1.07, 3.0, 7.0] {
            for exponent in [1.8, 2.0, 2.4] {
                let truth: Vec<u64> = (1..30)
                    .map(|i| (100.0 * wrong * f64::from(i).powf(exponent)) as u64)
                    .collect();
                for limit in [700, 5000, 20_000, 70_000] {
                    let (found, bakes) = choose(&foreseen, &truth, limit);
                    let fitting = truth.iter().rposition(|&t| t <= limit);
                    let expected =
                        fitting.map_or(Found::NeedsAtLeast(truth[0]), |i| Found::Fits(i, i));
                    assert_eq!(found, expected, "{wrong} {exponent} {limit}");
                    assert!(bakes <= 6, "{bakes} {wrong} {exponent} {limit}");
                }
            }
        }
    }

    #[test]
    fn when_none_fits_the_least_is_told() {
        assert_eq!(choose(&[50, 90], &[60, 95], 40).0, Found::NeedsAtLeast(60));
        assert_eq!(choose(&[10, 20], &[60, 95], 40).0, Found::NeedsAtLeast(60));
    }
}
