//! What a frame costs, phase by phase.

/// A counter of the board, read without set-up.
pub trait Counter {
    /// What it reads now. Costs the same number of instructions each time.
    fn now(&self) -> u32;

    /// What lies between two readings, in the board's unit (instructions in the emulator,
    /// cycles on silicon), as long as the counter has wrapped at most once.
    fn between(&self, start: u32, end: u32) -> u32;

    /// What lies between two readings with nothing between them: their own cost.
    fn overhead(&self) -> u32;

    /// Runs code of known lengths between readings: whether the counter reads true.
    fn self_test(&self) -> [Probe; PROBES];
}

/// How many pieces of code a self-test runs.
pub const PROBES: usize = 4;

/// Code of a known length, and what the counter made of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Probe {
    /// Instructions that ran.
    pub expected: u32,
    /// Instructions counted, the cost of a reading included.
    pub counted: u32,
}

/// The parts of a frame that are counted apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Tables that follow from the camera.
    Setup,
    /// What the frame before left behind.
    Clear,
    /// The colour of each normal under this light.
    ShadingTables,
    /// Cells and samples.
    Draw,
    /// What no sample covered.
    Fill,
    /// The depths that the light sees.
    ShadowMap,
    /// The frame to the panel.
    Send,
}

impl Phase {
    /// All, in the order in which they are reported.
    pub const ALL: [Self; 7] = [
        Self::Setup,
        Self::Clear,
        Self::ShadingTables,
        Self::Draw,
        Self::Fill,
        Self::ShadowMap,
        Self::Send,
    ];

    /// The name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Setup => "setup",
            Self::Clear => "clear",
            Self::ShadingTables => "shading_tables",
            Self::Draw => "draw",
            Self::Fill => "fill",
            Self::ShadowMap => "shadow_map",
            Self::Send => "send",
        }
    }

    /// Whether it belongs to the cost of a frame: the tables change with the light only, and
    /// the transfer is the panel's.
    #[must_use]
    pub const fn is_part_of_a_frame(self) -> bool {
        !matches!(self, Self::ShadingTables | Self::Send)
    }
}

/// Most pieces of a frame that are told: four an instance of a scene, and some.
pub const MAX_PIECES: usize = 640;

/// The count of each phase; one that did not run is 0.
///
/// A phase may run in several pieces, between others: which was which is kept in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Phases {
    sums: [u64; Phase::ALL.len()],
    /// The phase of each piece, by its place in [`Phase::ALL`].
    pieces: [u8; MAX_PIECES],
    count: usize,
}

impl Default for Phases {
    fn default() -> Self {
        Self {
            sums: [0; Phase::ALL.len()],
            pieces: [0; MAX_PIECES],
            count: 0,
        }
    }
}

impl Phases {
    /// What the phase cost.
    #[must_use]
    pub fn get(&self, phase: Phase) -> u64 {
        self.sums[phase as usize]
    }

    /// Adds to the phase, which ran once more; of pieces beyond [`MAX_PIECES`] the order is not kept.
    pub fn add(&mut self, phase: Phase, count: u64) {
        self.sum(phase, count);
        self.follow(phase);
    }

    /// Adds to the sum alone.
    pub(crate) fn sum(&mut self, phase: Phase, count: u64) {
        let sum = &mut self.sums[phase as usize];
        *sum = sum.saturating_add(count);
    }

    /// Adds a piece alone.
    pub(crate) fn follow(&mut self, phase: Phase) {
        if let Some(piece) = self.pieces.get_mut(self.count) {
            *piece = phase as u8;
            self.count += 1;
        }
    }

    /// The phases of the pieces in their order.
    pub fn pieces(&self) -> impl Iterator<Item = Phase> {
        let pieces = self.pieces.iter().take(self.count);
        pieces.filter_map(|piece| Phase::ALL.get(usize::from(*piece)).copied())
    }

    /// What a frame costs: every phase that is part of one.
    #[must_use]
    pub fn frame(&self) -> u64 {
        Phase::ALL
            .into_iter()
            .filter(|phase| phase.is_part_of_a_frame())
            .map(|phase| self.get(phase))
            .sum()
    }
}

/// Sums what runs between readings, without the cost of the readings.
#[derive(Debug)]
pub struct Stopwatch<'a, C> {
    counter: &'a C,
    overhead: u32,
    phases: Phases,
}

impl<'a, C: Counter> Stopwatch<'a, C> {
    /// Measures the cost of a reading first.
    pub fn new(counter: &'a C) -> Self {
        Self {
            counter,
            overhead: counter.overhead(),
            phases: Phases::default(),
        }
    }

    /// Runs `work` and adds what it cost to the phase.
    #[inline]
    pub fn time<T>(&mut self, phase: Phase, work: impl FnOnce() -> T) -> T {
        let start = self.counter.now();
        let result = work();
        let end = self.counter.now();
        self.phases.add(phase, u64::from(self.cost(start, end)));
        result
    }

    /// Forgets the sums, as before a second frame.
    pub fn reset(&mut self) {
        self.phases = Phases::default();
    }

    /// The sums.
    #[must_use]
    pub fn phases(&self) -> Phases {
        self.phases
    }

    /// The counter's self-test, the cost of a reading taken off.
    #[must_use]
    pub fn self_test(&self) -> [Probe; PROBES] {
        self.counter.self_test().map(|probe| Probe {
            counted: probe.counted.saturating_sub(self.overhead),
            ..probe
        })
    }

    fn cost(&self, start: u32, end: u32) -> u32 {
        self.counter
            .between(start, end)
            .saturating_sub(self.overhead)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::cell::Cell;

    /// Ticks three times a reading.
    #[derive(Default)]
    struct Ticks(Cell<u32>);

    impl Counter for Ticks {
        fn now(&self) -> u32 {
            self.0.set(self.0.get().wrapping_add(3));
            self.0.get()
        }
        fn between(&self, start: u32, end: u32) -> u32 {
            end.wrapping_sub(start)
        }
        fn overhead(&self) -> u32 {
            3
        }
        fn self_test(&self) -> [Probe; PROBES] {
            [Probe {
                expected: 5,
                counted: 8,
            }; PROBES]
        }
    }

    #[test]
    fn the_cost_of_reading_is_taken_off() {
        let ticks = Ticks(Cell::new(u32::MAX - 4));
        let mut watch = Stopwatch::new(&ticks);
        watch.time(Phase::Draw, || ticks.0.set(ticks.0.get().wrapping_add(100)));
        assert_eq!(watch.phases().get(Phase::Draw), 100);
        assert_eq!(watch.self_test()[0].counted, 5);
    }

    #[test]
    fn a_phase_that_runs_twice_is_summed_until_the_reset() {
        let ticks = Ticks::default();
        let mut watch = Stopwatch::new(&ticks);
        for _ in 0..2 {
            watch.time(Phase::Clear, || ticks.0.set(ticks.0.get() + 10));
        }
        assert_eq!(watch.phases().get(Phase::Clear), 20);
        watch.reset();
        assert_eq!(watch.phases(), Phases::default());
    }

    #[test]
    fn a_frame_leaves_out_shading_tables_and_the_transfer() {
        let mut phases = Phases::default();
        for (i, phase) in Phase::ALL.into_iter().enumerate() {
            phases.add(phase, 10u64.pow(i.try_into().unwrap()));
        }
        assert_eq!(phases.frame(), 111_011);
    }
}
