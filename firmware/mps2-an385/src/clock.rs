//! The counter of instructions, and delays.

use embedded_hal::delay::DelayNs;
use rho_viewer::count::{Counter, PROBES, Probe};

use crate::bare;

/// Cycles of the core a microsecond.
const MHZ: u32 = 25;

/// The board's 25 MHz counter. Under QEMU's `-icount shift=6` an instruction takes 64 ns, which
/// is 1.6 ticks; a frame of more than 2684 million instructions wraps it.
#[derive(Clone, Copy, Debug)]
pub struct Clock;

/// How many instructions the counter can tell apart: 2^32 ticks.
const WRAP: u32 = ((1u64 << 32) * 5 / 8) as u32;

/// The instruction at which the counter shows these ticks.
///
/// The emulator shows floor(1.6 n) after n instructions, so n is ceil(ticks / 1.6) for every
/// reading, while the difference of two readings, times 5/8, may be off by one.
fn instruction(ticks: u32) -> u32 {
    (u64::from(ticks) * 5).div_ceil(8) as u32
}

fn between(start: u32, end: u32) -> u32 {
    let (start, end) = (instruction(start), instruction(end));
    if end >= start {
        end - start
    } else {
        end + (WRAP - start)
    }
}

impl Counter for Clock {
    #[inline(always)]
    fn now(&self) -> u32 {
        bare::counter()
    }

    fn between(&self, start: u32, end: u32) -> u32 {
        between(start, end)
    }

    fn overhead(&self) -> u32 {
        let (start, end) = bare::nothing_counted();
        between(start, end)
    }

    fn self_test(&self) -> [Probe; PROBES] {
        bare::counted_code().map(|(expected, (start, end))| Probe {
            expected,
            counted: between(start, end),
        })
    }
}

/// Waits by running instructions, at least as many as the core has cycles in that time.
#[derive(Clone, Copy, Debug)]
pub struct Delay;

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        cortex_m::asm::delay((u64::from(ns) * u64::from(MHZ)).div_ceil(1000) as u32);
    }
}
