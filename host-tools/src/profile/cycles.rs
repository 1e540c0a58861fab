//! About how many cycles instructions take: tables of the cores' manuals, not measurements.
//!
//! All are for memory without wait states. Times that depend on data are taken in the middle of
//! their range, since the emulator does not tell the data: a long multiplication of the Cortex-M3
//! takes 3 to 5 cycles (4 to 7 when it adds), a division 2 to 12. A branch refills the pipeline in
//! 1 to 3 cycles, counted as 2. Tables: ARM DDI 0337 (Cortex-M3, section 3.3.1), ARM 100166
//! (Cortex-M4, section 3.3.1).

use super::thumb::{Class, Instruction};

/// A core.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Core {
    /// ARMv7-M.
    CortexM3,
    /// ARMv7E-M, its floating-point unit unused.
    CortexM4,
}

impl Core {
    /// All.
    pub const ALL: [Self; 2] = [Self::CortexM3, Self::CortexM4];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::CortexM3 => "Cortex-M3",
            Self::CortexM4 => "Cortex-M4",
        }
    }

    /// Half cycles of an instruction when the next one follows it. A load behind a load
    /// overlaps with it.
    #[must_use]
    pub fn half_cycles(self, instruction: &Instruction, behind_a_load: bool) -> u64 {
        let cycles = |n: u32| u64::from(2 * n);
        let Instruction {
            class,
            registers,
            accumulates,
        } = *instruction;
        match (class, self) {
            (Class::Load, _) => cycles(if behind_a_load { 1 } else { 2 }),
            // The write buffer takes it.
            (Class::Store, _) => cycles(1),
            (Class::LoadMultiple | Class::StoreMultiple, _) => cycles(1 + registers),
            (Class::Multiply, Self::CortexM3) => cycles(1 + u32::from(accumulates)),
            (Class::LongMultiply, Self::CortexM3) => {
                if accumulates {
                    11
                } else {
                    cycles(4)
                }
            }
            (Class::Divide, _) => cycles(7),
            (Class::Multiply | Class::LongMultiply, Self::CortexM4)
            | (Class::Branch | Class::Float | Class::Other, _) => cycles(1),
        }
    }

    /// Half cycles that it takes longer when another instruction follows.
    #[must_use]
    pub const fn half_cycles_to_leave(self) -> u64 {
        4
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cores_differ_in_their_multiplications() {
        let mla = Instruction::decode(0xFB01, 0x3002);
        let smlal = Instruction::decode(0xFBC2, 0x0103);
        let both = |i| Core::ALL.map(|core| core.half_cycles(i, false));
        assert_eq!(both(&mla), [4, 2]);
        assert_eq!(both(&smlal), [11, 2]);
    }

    #[test]
    fn loads_overlap_and_several_registers_take_a_cycle_each() {
        let load = Instruction::decode(0x6808, 0);
        let core = Core::CortexM3;
        assert_eq!([false, true].map(|b| core.half_cycles(&load, b)), [4, 2]);
        let push = Instruction::decode(0xB590, 0);
        assert_eq!(core.half_cycles(&push, false), 8);
    }
}
