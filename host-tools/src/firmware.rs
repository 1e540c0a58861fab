//! The program that runs on the emulated board: built, checked and measured.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use object::elf;
use object::read::elf::{ElfFile32, ProgramHeader, SectionHeader};
use object::{Endianness, Object, ObjectSection};

use crate::failure::{Failure, Outcome};

/// The package of the emulated board.
pub const PACKAGE: &str = "rho-mps2-an385";
/// What it is built for.
pub const TARGET: &str = "thumbv7m-none-eabi";
/// The cargo profile of all that runs on a microcontroller.
pub const PROFILE: &str = "firmware";

/// The board's memory for the program.
const FLASH: std::ops::Range<u64> = 0..4 << 20;
/// The board's memory for stack and statics.
const RAM: std::ops::Range<u64> = 0x2000_0000..0x2040_0000;

/// A checked image.
#[derive(Clone, Debug)]
pub struct Firmware {
    path: PathBuf,
    elf: Vec<u8>,
    ram_bytes: u64,
    flash_bytes: u64,
}

impl Firmware {
    /// Builds the image from the workspace that the folder lies in, and opens it. With
    /// `target_dir`, cargo writes there and not where it would by itself.
    ///
    /// # Errors
    /// When cargo or the target is missing, the folder is in no such workspace, or the build
    /// fails; cargo's own words are on standard error then.
    pub fn build(folder: &Path, target_dir: Option<&Path>) -> Outcome<Self> {
        let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let mut command = Command::new(cargo);
        command
            .args(["build", "--quiet", "--profile", PROFILE])
            .args(["--package", PACKAGE, "--target", TARGET])
            .arg("--message-format=json-render-diagnostics")
            .current_dir(folder)
            .stdin(Stdio::null());
        if let Some(target_dir) = target_dir {
            command.arg("--target-dir").arg(target_dir);
        }
        let output = command.output().map_err(|error| {
            Failure::missing(format!("cargo does not start: {error}"))
                .help("install Rust with https://rustup.rs, or pass --firmware ELF")
        })?;
        if !output.status.success() {
            return Err(build_failure(&String::from_utf8_lossy(&output.stderr)));
        }
        let path = executable(&String::from_utf8_lossy(&output.stdout))
            .ok_or_else(|| Failure::missing(format!("cargo built {PACKAGE} but named no image")))?;
        Self::open(&path)
    }

    /// Reads and checks an image.
    ///
    /// # Errors
    /// When it cannot be read, or would not run on the board.
    pub fn open(path: &Path) -> Outcome<Self> {
        let elf = fs::read(path)
            .map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
        let (ram_bytes, flash_bytes) = check(&elf).map_err(|reason| {
            Failure::input(format!("{}: {reason}", path.display())).help(format!(
                "build it with: cargo build --profile {PROFILE} -p {PACKAGE} --target {TARGET}"
            ))
        })?;
        // Absolute, because the emulator runs in a folder of its own.
        let path = fs::canonicalize(path)
            .map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
        Ok(Self {
            path,
            elf,
            ram_bytes,
            flash_bytes,
        })
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

/// The path of the image in cargo's messages.
fn executable(messages: &str) -> Option<PathBuf> {
    messages
        .lines()
        .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok())
        .filter(|message| message["target"]["name"] == PACKAGE)
        .find_map(|message| message["executable"].as_str().map(PathBuf::from))
}

/// What to tell when cargo fails, from what it wrote.
fn build_failure(stderr: &str) -> Failure {
    let or_elf = "or pass --firmware ELF";
    if stderr.contains("could not find `Cargo.toml`") || stderr.contains("did not match any") {
        return Failure::input("the firmware cannot be built: this folder is not in its workspace")
            .help(format!("run this in the project's folder, {or_elf}"));
    }
    if stderr.contains("can't find crate for `core`") || stderr.contains("may not be installed") {
        return Failure::missing(format!("the Rust target {TARGET} is not installed"))
            .help(format!("rustup target add {TARGET}"));
    }
    Failure::missing(format!(
        "the firmware does not build:\n{}",
        stderr.trim_end()
    ))
    .help(format!("mend what cargo complains about, {or_elf}"))
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
    fn the_image_is_found_in_cargos_messages() {
        let messages = concat!(
            r#"{"reason":"compiler-artifact","target":{"name":"rho-grid"},"executable":null}"#,
            "\n",
            r#"{"reason":"compiler-artifact","target":{"name":"rho-mps2-an385"},"executable":"/a/b"}"#,
            "\nnoise\n",
            r#"{"reason":"build-finished","success":true}"#
        );
        assert_eq!(executable(messages), Some(PathBuf::from("/a/b")));
    }

    #[test]
    fn a_missing_target_tells_the_command_that_mends_it() {
        let failure = build_failure("error[E0463]: can't find crate for `core`");
        assert_eq!(failure.exit, crate::failure::Exit::Missing);
        assert_eq!(
            failure.help.as_deref(),
            Some("rustup target add thumbv7m-none-eabi")
        );
    }

    #[test]
    fn a_folder_outside_the_workspace_is_told() {
        let failure = build_failure("error: could not find `Cargo.toml` in `/` or any parent");
        assert_eq!(failure.exit, crate::failure::Exit::Input);
    }

    #[test]
    fn what_is_no_image_is_refused() {
        assert!(check(b"").is_err());
        assert!(check(b"\x7fELF").is_err());
        let own = fs::read(env::current_exe().unwrap()).unwrap();
        assert!(check(&own).is_err(), "a program for the host");
    }
}
