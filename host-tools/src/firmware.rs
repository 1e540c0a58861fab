//! The program that runs on the emulated board: built, checked and measured.

use std::fs;
use std::path::{Path, PathBuf};

use object::elf;
use object::read::elf::{ElfFile32, ProgramHeader, SectionHeader};
use object::{Endianness, Object, ObjectSection};

use crate::failure::{Failure, Outcome};
use crate::machine::Machine;

/// The board's memory for the program.
const FLASH: std::ops::Range<u64> = 0..4 << 20;
/// The board's memory for stack and statics.
const RAM: std::ops::Range<u64> = 0x2000_0000..0x2040_0000;

/// A checked image.
#[derive(Clone, Debug)]
pub struct Firmware {
    machine: Machine,
    path: PathBuf,
    elf: Vec<u8>,
    ram_bytes: u64,
    flash_bytes: u64,
}

impl Firmware {
    /// Builds the viewer from the workspace that the folder lies in, and opens it. With
    /// `target_dir`, cargo writes there and not where it would by itself.
    ///
    /// # Errors
    /// Those of [`Package::build`](crate::cargo::Package::build) and [`Firmware::open`].
    pub fn build(machine: Machine, folder: &Path, target_dir: Option<&Path>) -> Outcome<Self> {
        let built = machine.viewer().build(folder, target_dir);
        let path = built.map_err(|failure| {
            let help = failure.help.as_deref().unwrap_or_default();
            let help = format!("{help}, or pass --firmware ELF");
            failure.help(help)
        })?;
        Self::open(&path, machine)
    }

    /// Opens the image at the path; without one, builds the viewer from the workspace in the
    /// current folder.
    ///
    /// # Errors
    /// Those of [`Firmware::open`] and [`Firmware::build`].
    pub fn named_or_built(path: Option<&Path>, machine: Machine) -> Outcome<Self> {
        match path {
            Some(path) => Self::open(path, machine),
            None => Self::build(machine, Path::new("."), None),
        }
    }

    /// Reads and checks an image.
    ///
    /// # Errors
    /// When it cannot be read, or would not run on the board.
    pub fn open(path: &Path, machine: Machine) -> Outcome<Self> {
        let elf = fs::read(path)
            .map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
        let (ram_bytes, flash_bytes) = check(&elf).map_err(|reason| {
            Failure::input(format!("{}: {reason}", path.display()))
                .help(format!("build it with: {}", machine.viewer().command()))
        })?;
        // Absolute, because the emulator runs in a folder of its own.
        let path = fs::canonicalize(path)
            .map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
        Ok(Self {
            machine,
            path,
            elf,
            ram_bytes,
            flash_bytes,
        })
    }

    /// What it runs on.
    #[must_use]
    pub fn machine(&self) -> Machine {
        self.machine
    }

    /// Where it lies.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The image itself.
    #[must_use]
    pub fn elf(&self) -> &[u8] {
        &self.elf
    }

    /// RAM of its statics, in bytes.
    #[must_use]
    pub fn ram_bytes(&self) -> u64 {
        self.ram_bytes
    }

    /// Flash of code, constants and initial values, in bytes; without a model.
    #[must_use]
    pub fn flash_bytes(&self) -> u64 {
        self.flash_bytes
    }
}

/// RAM of statics and bytes of flash, if the image would run on the board.
fn check(elf: &[u8]) -> Result<(u64, u64), String> {
    let file = ElfFile32::<Endianness>::parse(elf)
        .map_err(|_| "this is no image for a 32-bit processor (ELF)".to_owned())?;
    if file.architecture() != object::Architecture::Arm {
        return Err("this is no image for an Arm processor".to_owned());
    }
    let endian = file.endian();
    let mut flash_bytes = 0;
    for header in file.elf_program_headers() {
        let size: u64 = header.p_filesz(endian).into();
        if header.p_type(endian) != elf::PT_LOAD || size == 0 {
            continue;
        }
        let at: u64 = header.p_paddr(endian).into();
        if !(FLASH.contains(&at) && FLASH.contains(&(at + size - 1))) {
            return Err(format!(
                "{size} bytes would be loaded at {at:#010x}, where the board has no flash"
            ));
        }
        flash_bytes += size;
    }
    let mut ram_bytes = 0;
    for section in file.sections() {
        let flags = section.elf_section_header().sh_flags(endian);
        if flags & elf::SHF_ALLOC == 0 || section.size() == 0 {
            continue;
        }
        let (at, size) = (section.address(), section.size());
        if RAM.contains(&at) && at + size <= RAM.end {
            ram_bytes += size;
        } else if !FLASH.contains(&at) {
            let name = section.name().unwrap_or("a section");
            return Err(format!(
                "{name} lies at {at:#010x}, where the board has no memory"
            ));
        }
    }
    let vectors = file
        .section_by_name(".vector_table")
        .and_then(|section| section.data().ok())
        .ok_or("the image is empty: it was linked without the linker script")?;
    let vector = |index: usize| -> Option<u64> {
        let bytes = vectors.get(4 * index..4 * index + 4)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?).into())
    };
    let (Some(stack), Some(reset)) = (vector(0), vector(1)) else {
        return Err("the image has no vector table".to_owned());
    };
    if !(RAM.contains(&(stack.saturating_sub(1))) && FLASH.contains(&reset) && reset % 2 == 1) {
        return Err(format!(
            "the vector table makes no sense: stack {stack:#010x}, reset {reset:#010x}"
        ));
    }
    Ok((ram_bytes, flash_bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_image_is_refused() {
        assert!(check(b"").is_err());
        assert!(check(b"\x7fELF").is_err());
        let own = fs::read(std::env::current_exe().unwrap()).unwrap();
        assert!(check(&own).is_err(), "a program for the host");
    }
}
