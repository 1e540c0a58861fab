//! What is counted, without the emulator.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::atomic::{AtomicU64, Ordering};

/// An instruction's counters, added to by the translated code.
#[derive(Debug, Default)]
pub(crate) struct Slot {
    /// How often it ran.
    pub(crate) ran: AtomicU64,
    /// How often another than the next instruction followed.
    pub(crate) left: AtomicU64,
}

/// A block of translated code: instructions that run one after the other.
#[derive(Debug)]
pub(crate) struct Block {
    /// The address of its first instruction.
    pub(crate) start: u64,
    /// The address behind its last one.
    pub(crate) end: u64,
    /// The counters of its last one.
    pub(crate) last: &'static Slot,
}

/// All counters and the intervals so far.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    /// By address. An instruction that is translated again keeps its counters.
    slots: BTreeMap<u64, (&'static Slot, [u64; 2])>,
    /// The block that began to run last.
    previous: Option<&'static Block>,
    /// The lines of the intervals that have ended.
    lines: String,
}

impl Counts {
    pub(crate) const fn new() -> Self {
        Self {
            slots: BTreeMap::new(),
            previous: None,
            lines: String::new(),
        }
    }

    /// The counters of an address; they live as long as the emulator.
    pub(crate) fn slot(&mut self, address: u64) -> &'static Slot {
        let leaked = || (&*Box::leak(Box::default()), [0; 2]);
        self.slots.entry(address).or_insert_with(leaked).0
    }

    /// A block begins to run.
    pub(crate) fn enter(&mut self, block: &'static Block) {
        if let Some(previous) = self.previous.replace(block)
            && previous.end != block.start
        {
            previous.last.left.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// The counter was read: an interval ends.
    pub(crate) fn reading(&mut self) {
        for (address, (slot, before)) in &mut self.slots {
            let now = [&slot.ran, &slot.left].map(|count| count.load(Ordering::Relaxed));
            if now[0] > before[0] {
                let [ran, left] = [0, 1].map(|i| now[i] - before[i]);
                // Writing to a string cannot fail.
                let _ = writeln!(self.lines, "{address:08x} {ran} {left}");
            }
            *before = now;
        }
        self.lines.push_str("reading\n");
    }

    /// The intervals as text.
    pub(crate) fn lines(&self) -> &str {
        &self.lines
    }
}
