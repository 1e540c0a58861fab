//! What kind of work a Thumb instruction is (ARMv7-M Architecture Reference Manual, chapter A5).

use std::ops::{Index, IndexMut};

/// A kind of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// One register from memory.
    Load,
    /// One register to memory.
    Store,
    /// Several registers from memory.
    LoadMultiple,
    /// Several registers to memory.
    StoreMultiple,
    /// A product of 32 bits, also one that is added.
    Multiply,
    /// A product of 64 bits, also one that is added.
    LongMultiply,
    /// A quotient.
    Divide,
    /// Something else than the next instruction may follow.
    Branch,
    /// The floating-point unit's.
    Float,
    /// Additions, shifts, comparisons, moves.
    Other,
}

impl Class {
    /// All, in the order in which tables list them.
    pub const ALL: [Self; 10] = [
        Self::Load,
        Self::Store,
        Self::LoadMultiple,
        Self::StoreMultiple,
        Self::Multiply,
        Self::LongMultiply,
        Self::Divide,
        Self::Branch,
        Self::Float,
        Self::Other,
    ];

    /// The name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Load => "loads",
            Self::Store => "stores",
            Self::LoadMultiple => "loads of several",
            Self::StoreMultiple => "stores of several",
            Self::Multiply => "multiplies",
            Self::LongMultiply => "long multiplies",
            Self::Divide => "divides",
            Self::Branch => "branches",
            Self::Float => "floats",
            Self::Other => "other",
        }
    }
}

/// A number for each class.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ByClass<T>([T; Class::ALL.len()]);

impl<T> Index<Class> for ByClass<T> {
    type Output = T;
    fn index(&self, class: Class) -> &T {
        &self.0[class as usize]
    }
}

impl<T> IndexMut<Class> for ByClass<T> {
    fn index_mut(&mut self, class: Class) -> &mut T {
        &mut self.0[class as usize]
    }
}

/// An instruction, as far as its cost goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instruction {
    /// What it does.
    pub class: Class,
    /// Registers that it moves from or to memory.
    pub registers: u32,
    /// A multiplication that adds to a register.
    pub accumulates: bool,
}

impl Instruction {
    /// Reads an instruction from its first half-word and, when it is one of 32 bits, its second.
    #[must_use]
    pub fn decode(first: u16, second: u16) -> Self {
        if first >= 0xE800 {
            Self::wide(first, second)
        } else {
            Self::narrow(first)
        }
    }

    fn of(class: Class) -> Self {
        let registers = matches!(class, Class::Load | Class::Store).into();
        Self {
            class,
            registers,
            accumulates: false,
        }
    }

    fn multiple(load: bool, registers: u32) -> Self {
        let class = if load {
            Class::LoadMultiple
        } else {
            Class::StoreMultiple
        };
        Self {
            registers,
            ..Self::of(class)
        }
    }

    fn narrow(word: u16) -> Self {
        let class = match word {
            // B, with a condition or without; the two conditions left are UDF and SVC.
            0xD000..=0xDDFF | 0xE000..=0xE7FF => Class::Branch,
            // BX, BLX.
            0x4700..=0x47FF => Class::Branch,
            // ADD and MOV to the program counter.
            _ if matches!(word & 0xFF87, 0x4487 | 0x4687) => Class::Branch,
            // CBZ, CBNZ.
            _ if word & 0xF500 == 0xB100 => Class::Branch,
            // MULS.
            _ if word & 0xFFC0 == 0x4340 => Class::Multiply,
            // Of a literal.
            0x4800..=0x4FFF => Class::Load,
            // With a register as offset: STR, STRH, STRB come before the loads.
            0x5000..=0x55FF => Class::Store,
            0x5600..=0x5FFF => Class::Load,
            // With a number as offset: words, bytes, half-words, words on the stack.
            0x6000..=0x9FFF if word & 0x0800 == 0 => Class::Store,
            0x6000..=0x9FFF => Class::Load,
            // PUSH, POP: the ninth register is lr or pc.
            _ if word & 0xF600 == 0xB400 => {
                return Self::multiple(word & 0x0800 != 0, (word & 0x1FF).count_ones());
            }
            0xC000..=0xCFFF => {
                return Self::multiple(word & 0x0800 != 0, (word & 0xFF).count_ones());
            }
            _ => Class::Other,
        };
        Self::of(class)
    }

    fn wide(first: u16, second: u16) -> Self {
        let load = first & 0x0010 != 0;
        let class = match first {
            // TBB, TBH.
            _ if first & 0xFFF0 == 0xE8D0 && second & 0xFFE0 == 0xF000 => Class::Branch,
            // LDM, STM.
            0xE800..=0xE9FF if first & 0x0040 == 0 => {
                return Self::multiple(load, second.count_ones());
            }
            // LDRD, STRD: indexed or written back; the others are exclusive.
            0xE800..=0xE9FF if first & 0x0120 != 0 => return Self::multiple(load, 2),
            0xE800..=0xE9FF if load => Class::Load,
            0xE800..=0xE9FF => Class::Store,
            0xEC00..=0xEFFF | 0xFC00.. => Class::Float,
            0xF000..=0xF7FF if second & 0x8000 != 0 => {
                // BL and B; B with a condition, whose last two conditions are MSR, hints and so on.
                if second & 0x5000 != 0 || first & 0x0380 != 0x0380 {
                    Class::Branch
                } else {
                    Class::Other
                }
            }
            0xF800..=0xF9FF if load => Class::Load,
            0xF800..=0xF9FF => Class::Store,
            0xFB00..=0xFB7F => {
                // With 15 as the register that is added to, nothing is added.
                return Self {
                    accumulates: second >> 12 != 0xF,
                    ..Self::of(Class::Multiply)
                };
            }
            // SDIV, UDIV.
            _ if matches!(first & 0xFFF0, 0xFB90 | 0xFBB0) => Class::Divide,
            0xFB80..=0xFBFF => {
                // SMULL and UMULL only multiply.
                return Self {
                    accumulates: !matches!(first & 0xFFF0, 0xFB80 | 0xFBA0),
                    ..Self::of(Class::LongMultiply)
                };
            }
            _ => Class::Other,
        };
        Self::of(class)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Encodings as an assembler makes them.
    #[test]
    fn instructions_are_told_by_their_encodings() {
        for (text, words, class) in [
            ("ldr r0, [r1]", (0x6808, 0), Class::Load),
            ("ldrb r0, [r1, r2]", (0x5C88, 0), Class::Load),
            ("ldrsb r0, [r1, r2]", (0x5688, 0), Class::Load),
            ("ldr r0, [pc, #4]", (0x4801, 0), Class::Load),
            ("ldrh.w r0, [r1, #2]", (0xF8B1, 0x0002), Class::Load),
            ("str r0, [sp, #4]", (0x9001, 0), Class::Store),
            ("strb r0, [r1, r2]", (0x5488, 0), Class::Store),
            ("strh.w r0, [r1], #2", (0xF821, 0x0B02), Class::Store),
            ("muls r0, r1, r0", (0x4348, 0), Class::Multiply),
            (
                "smull r0, r1, r2, r3",
                (0xFB82, 0x0103),
                Class::LongMultiply,
            ),
            ("udiv r0, r1, r2", (0xFBB1, 0xF0F2), Class::Divide),
            ("sdiv r0, r1, r2", (0xFB91, 0xF0F2), Class::Divide),
            ("beq", (0xD0FE, 0), Class::Branch),
            ("b", (0xE7FE, 0), Class::Branch),
            ("b.w", (0xF000, 0xB800), Class::Branch),
            ("beq.w", (0xF000, 0x8000), Class::Branch),
            ("bl", (0xF000, 0xF800), Class::Branch),
            ("bx lr", (0x4770, 0), Class::Branch),
            ("cbz r0", (0xB100, 0), Class::Branch),
            ("cbnz r0", (0xB900, 0), Class::Branch),
            ("tbb [pc, r0]", (0xE8DF, 0xF000), Class::Branch),
            ("vadd.f32 s0, s0, s1", (0xEE30, 0x0A20), Class::Float),
            ("svc #0", (0xDF00, 0), Class::Other),
            ("it eq", (0xBF08, 0), Class::Other),
            ("dmb", (0xF3BF, 0x8F5F), Class::Other),
            ("add.w r0, r1, r2", (0xEB01, 0x0002), Class::Other),
            ("movw r0, #1", (0xF240, 0x0001), Class::Other),
            ("adds r0, r0, r1", (0x1840, 0), Class::Other),
            ("uxtb r0, r0", (0xB2C0, 0), Class::Other),
        ] {
            let (first, second) = words;
            assert_eq!(Instruction::decode(first, second).class, class, "{text}");
        }
    }

    #[test]
    fn registers_moved_at_once_are_counted() {
        for (text, words, class, registers) in [
            ("push {r4, r7, lr}", (0xB590, 0), Class::StoreMultiple, 3),
            ("pop {r4, r7, pc}", (0xBD90, 0), Class::LoadMultiple, 3),
            ("ldmia r0!, {r1, r2}", (0xC806, 0), Class::LoadMultiple, 2),
            (
                "stmia.w r0!, {r4-r11}",
                (0xE8A0, 0x0FF0),
                Class::StoreMultiple,
                8,
            ),
            (
                "ldrd r0, r1, [r2]",
                (0xE9D2, 0x0100),
                Class::LoadMultiple,
                2,
            ),
            ("ldr r0, [r1]", (0x6808, 0), Class::Load, 1),
        ] {
            let (first, second) = words;
            let read = Instruction::decode(first, second);
            assert_eq!((read.class, read.registers), (class, registers), "{text}");
        }
    }

    #[test]
    fn products_that_are_added_are_told_apart() {
        let adds = |first, second| Instruction::decode(first, second).accumulates;
        assert!(adds(0xFB01, 0x3002), "mla r0, r1, r2, r3");
        assert!(!adds(0xFB01, 0xF002), "mul.w r0, r1, r2");
        assert!(adds(0xFBC2, 0x0103), "smlal r0, r1, r2, r3");
        assert!(!adds(0xFBA2, 0x0103), "umull r0, r1, r2, r3");
    }
}
