//! Where a frame's instructions go: by class, by core model, by place in the source.
//!
//! The emulator counts how often each address runs ([`counts`]); the image tells what stands
//! there ([`thumb`]) and whose it is ([`place`]); [`cycles`] weighs it.

pub mod counts;
pub mod cycles;
pub mod place;
pub mod thumb;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use object::{Object, ObjectSegment};
use rho_viewer::count::Phase;

use crate::cargo::Package;
use crate::device::Run;
use crate::failure::{Failure, Outcome};
use crate::firmware::Firmware;
use counts::{Count, Counts};
use cycles::Core;
use thumb::{ByClass, Class, Instruction};

/// The emulator's plugin.
pub const PLUGIN: Package<'_> = Package {
    name: "rho-qemu-plugin",
    program: None,
    profile: "release",
    target: None,
};

/// Instructions that ran, at one address or at many.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// How often each class ran.
    pub ran: ByClass<u64>,
    /// Registers moved from and to memory, by class.
    pub registers: ByClass<u64>,
    /// Branches that were taken.
    pub taken: u64,
    /// Half cycles, by the order of [`Core::ALL`].
    half_cycles: [u64; Core::ALL.len()],
}

impl Work {
    /// Instructions.
    #[must_use]
    pub fn instructions(&self) -> u64 {
        Class::ALL.into_iter().map(|class| self.ran[class]).sum()
    }

    /// Cycles on a core, estimated.
    #[must_use]
    pub fn cycles(&self, core: Core) -> u64 {
        self.half_cycles[core as usize] / 2
    }

    /// Adds an instruction.
    fn add(&mut self, instruction: &Instruction, count: Count, behind_a_load: bool) {
        let class = instruction.class;
        self.ran[class] += count.ran;
        self.registers[class] += count.ran * u64::from(instruction.registers);
        let is_branch = matches!(class, Class::Branch | Class::Load | Class::LoadMultiple);
        let left = if is_branch { count.left } else { 0 };
        self.taken += left;
        for (sum, core) in self.half_cycles.iter_mut().zip(Core::ALL) {
            *sum += count.ran * core.half_cycles(instruction, behind_a_load)
                + left * core.half_cycles_to_leave();
        }
    }

    /// Adds the work of another part.
    fn join(&mut self, other: &Self) {
        for class in Class::ALL {
            self.ran[class] += other.ran[class];
            self.registers[class] += other.registers[class];
        }
        self.taken += other.taken;
        for (sum, more) in self.half_cycles.iter_mut().zip(other.half_cycles) {
            *sum += more;
        }
    }
}

/// The work of the second frame, phase by phase, address by address.
#[derive(Clone, Debug)]
pub struct Profile {
    phases: Vec<(Phase, BTreeMap<u32, Work>)>,
}

impl Profile {
    /// Weighs what the plugin counted in a run of this image.
    ///
    /// # Errors
    /// When the counts are not those of two frames, or not of this image.
    pub fn new(firmware: &Firmware, run: &Run) -> Outcome<Self> {
        let code = Code::of(firmware)?;
        let phases = counts::by_phase(&run.counts, &run.report.phases)?;
        let phases = phases
            .into_iter()
            .map(|(phase, counts)| Ok((phase, code.weigh(&counts)?)))
            .collect::<Outcome<_>>()?;
        Ok(Self { phases })
    }

    /// All work of the phases that `wanted` chooses, summed by what `key` says of an address.
    pub fn sum<K: Ord>(
        &self,
        wanted: impl Fn(Phase) -> bool,
        mut key: impl FnMut(u32) -> K,
    ) -> BTreeMap<K, Work> {
        let mut sums: BTreeMap<K, Work> = BTreeMap::new();
        for (_, work) in self.phases.iter().filter(|(phase, _)| wanted(*phase)) {
            for (address, work) in work {
                sums.entry(key(*address)).or_default().join(work);
            }
        }
        sums
    }

    /// All work of the phases that `wanted` chooses.
    #[must_use]
    pub fn total(&self, wanted: impl Fn(Phase) -> bool) -> Work {
        let mut total = Work::default();
        for work in self.sum(wanted, |address| address).values() {
            total.join(work);
        }
        total
    }
}

/// Builds the plugin from the workspace that the folder lies in; where it lies.
///
/// # Errors
/// Those of [`Package::build`].
pub fn plugin(folder: &Path, target_dir: Option<&Path>) -> Outcome<PathBuf> {
    let path = PLUGIN.build(folder, target_dir)?;
    // Absolute, because the emulator runs in a folder of its own.
    fs::canonicalize(&path)
        .map_err(|error| Failure::missing(format!("{}: {error}", path.display())))
}

/// The bytes that an image puts into memory.
struct Code<'a>(Vec<(u32, &'a [u8])>);

impl<'a> Code<'a> {
    fn of(firmware: &'a Firmware) -> Outcome<Self> {
        let broken = |error| Failure::input(format!("{}: {error}", firmware.path().display()));
        let file = object::File::parse(firmware.elf()).map_err(broken)?;
        let mut parts = Vec::new();
        for segment in file.segments() {
            let data = segment.data().map_err(broken)?;
            parts.push((segment.address() as u32, data));
        }
        Ok(Self(parts))
    }

    fn half_word(&self, address: u32) -> Option<u16> {
        self.0.iter().find_map(|(start, bytes)| {
            let at = address.checked_sub(*start)? as usize;
            let two = bytes.get(at..at + 2)?.try_into().ok()?;
            Some(u16::from_le_bytes(two))
        })
    }

    fn weigh(&self, counts: &Counts) -> Outcome<BTreeMap<u32, Work>> {
        let mut before: Option<(u32, Class)> = None;
        let mut all = BTreeMap::new();
        for (&address, &count) in counts {
            let first = self.half_word(address).ok_or_else(|| {
                Failure::device(format!("{address:#010x} ran, which is not in the image"))
            })?;
            let second = self.half_word(address + 2).unwrap_or(0);
            let instruction = Instruction::decode(first, second);
            let behind_a_load = before == Some((address, Class::Load));
            let mut work = Work::default();
            work.add(&instruction, count, behind_a_load);
            all.insert(address, work);
            let bytes = if first >= 0xE800 { 4 } else { 2 };
            before = Some((address + bytes, instruction.class));
        }
        Ok(all)
    }
}
