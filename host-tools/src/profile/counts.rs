//! What the emulator's plugin counted, phase by phase.

use std::collections::BTreeMap;

use rho_viewer::count::{Phase, Phases};

use crate::failure::{Failure, Outcome};

/// How often an instruction ran.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// How often it ran.
    pub ran: u64,
    /// How often another than the next instruction followed.
    pub left: u64,
}

/// By address.
pub type Counts = BTreeMap<u32, Count>;

/// The intervals that the plugin wrote, each ended by a reading of the counter.
fn intervals(text: &str) -> Option<Vec<Counts>> {
    let mut intervals = vec![Counts::new()];
    for line in text.lines() {
        if line == "reading" {
            intervals.push(Counts::new());
            continue;
        }
        let mut words = line.split(' ');
        let address = u32::from_str_radix(words.next()?, 16).ok()?;
        let ran = words.next()?.parse().ok()?;
        let left = words.next()?.parse().ok()?;
        intervals.last_mut()?.insert(address, Count { ran, left });
    }
    // What follows the last reading is no interval.
    intervals.pop();
    Some(intervals)
}

fn total(counts: &Counts) -> u64 {
    counts.values().map(|count| count.ran).sum()
}

/// The counts of each phase of the second frame, the readings of the counter included.
///
/// A [`Stopwatch`](rho_viewer::count::Stopwatch) reads the counter twice to learn what a reading
/// costs, then before and after each piece of two frames and of the transfer. Which phase a piece
/// belongs to the device reports, and the length of each phase.
///
/// # Errors
/// Exit 4 when the readings are not those of two frames, or the device counted otherwise.
pub fn by_phase(text: &str, phases: &Phases) -> Outcome<Vec<(Phase, Counts)>> {
    let broken = |what: &str| Failure::device(format!("the instructions counted: {what}"));
    let intervals =
        intervals(text).ok_or_else(|| broken("the plugin wrote something else than counts"))?;
    // Two readings for the overhead and two for the transfer; the rest is two frames.
    let in_a_frame = intervals.len().saturating_sub(4) / 2;
    if in_a_frame == 0 || 2 * in_a_frame + 4 != intervals.len() {
        return Err(broken(&format!(
            "the device read its counter {} times, which is not two frames",
            intervals.len()
        )));
    }
    let reading = total(&intervals[1]);
    // Each begins after one reading and ends with another.
    let second: Vec<Counts> = intervals
        .into_iter()
        .skip(2 + in_a_frame)
        .skip(1)
        .step_by(2)
        .collect();
    let pieces: Vec<Phase> = phases.pieces().collect();
    if pieces.len() != second.len() {
        return Err(broken("the device tells of other pieces"));
    }
    let mut found: Vec<(Phase, Counts)> = Vec::new();
    let mut lengths = Phases::default();
    for (phase, interval) in pieces.into_iter().zip(second) {
        lengths.add(phase, total(&interval).saturating_sub(reading));
        match found.iter_mut().find(|(known, _)| *known == phase) {
            None => found.push((phase, interval)),
            Some((_, sums)) => {
                for (address, count) in interval {
                    let sum = sums.entry(address).or_default();
                    sum.ran += count.ran;
                    sum.left += count.left;
                }
            }
        }
    }
    if Phase::ALL.iter().any(|p| lengths.get(*p) != phases.get(*p)) {
        return Err(broken("the device counted otherwise"));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two frames of a draw in two pieces and a clear; a reading costs 3.
    fn text() -> String {
        let mut text = "00000100 50 1\nreading\n00000200 3 0\nreading\n".to_owned();
        for frame in [100, 1] {
            for length in [10, 7, 20] {
                text += "00000400 5 0\nreading\n";
                text += &format!("00000300 {} 2\nreading\n", frame * length + 3);
            }
        }
        text + "00000500 1 0\nreading\n00000500 12 0\nreading\n00000600 9 0\n"
    }

    fn phases() -> Phases {
        let mut phases = Phases::default();
        phases.add(Phase::Draw, 10);
        phases.add(Phase::Clear, 7);
        phases.add(Phase::Draw, 20);
        phases.add(Phase::Send, 9);
        phases
    }

    #[test]
    fn the_second_frame_is_split_into_the_phases_that_the_device_reports() {
        let found = by_phase(&text(), &phases()).unwrap();
        let totals: Vec<_> = found.iter().map(|(p, c)| (*p, total(c))).collect();
        assert_eq!(
            totals,
            [(Phase::Draw, 36), (Phase::Clear, 10), (Phase::Send, 12)]
        );
        assert_eq!(found[0].1[&0x300].left, 4);
    }

    #[test]
    fn counts_that_the_device_does_not_share_are_refused() {
        let mut others = phases();
        others.add(Phase::Draw, 1);
        assert!(by_phase(&text(), &others).is_err());
        assert!(by_phase("", &phases()).is_err());
        assert!(by_phase("not a count\n", &phases()).is_err());
    }
}
