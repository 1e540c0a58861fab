//! The firmware under test, built once from this workspace into a target folder of its own.

use std::env;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Duration;

use host_tools::device::{self, Run};
use host_tools::failure::Outcome;
use host_tools::firmware::Firmware;
use host_tools::machine::Machine;
use host_tools::profile;

/// More than any test's frame takes, also on a busy machine.
pub const TIMEOUT: Duration = Duration::from_secs(60);

/// The workspace.
#[must_use]
pub fn workspace() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .unwrap_or(Path::new("."))
}

/// Where the firmware is built: beside the tests' own target folder, so that neither build
/// waits for the other's lock.
#[must_use]
pub fn target_dir() -> PathBuf {
    // A test runs from TARGET/PROFILE/deps.
    let target = env::current_exe()
        .ok()
        .and_then(|exe| exe.ancestors().nth(3).map(Path::to_path_buf));
    target
        .unwrap_or_else(|| workspace().join("target"))
        .join("firmware-under-test")
}

/// The emulator's plugin.
///
/// # Panics
/// When it does not build.
pub fn plugin() -> &'static Path {
    static PLUGIN: OnceLock<PathBuf> = OnceLock::new();
    PLUGIN.get_or_init(|| {
        profile::plugin(workspace(), Some(&target_dir()))
            .unwrap_or_else(|failure| panic!("the emulator's plugin: {failure}"))
    })
}

/// The firmware for the Cortex-M3.
///
/// # Panics
/// When it does not build.
pub fn firmware() -> &'static Firmware {
    static FIRMWARE: OnceLock<Firmware> = OnceLock::new();
    FIRMWARE.get_or_init(|| firmware_for(Machine::M3))
}

/// The firmware for a machine.
///
/// # Panics
/// When it does not build.
#[must_use]
pub fn firmware_for(machine: Machine) -> Firmware {
    Firmware::build(machine, workspace(), Some(&target_dir()))
        .unwrap_or_else(|failure| panic!("the firmware under test: {failure}"))
}

/// Runs the firmware under test on a line of text.
///
/// # Errors
/// Those of [`device::ask`].
///
/// # Panics
/// When something is missing on this machine: a test that did not run has not passed.
pub fn ask(line: &str, model: Option<&[u8]>) -> Outcome<Run> {
    ask_of(firmware(), line, model, TIMEOUT)
}

/// Runs a firmware on a line of text.
///
/// # Errors
/// Those of [`device::ask`].
///
/// # Panics
/// When something is missing on this machine.
pub fn ask_of(
    firmware: &Firmware,
    line: &str,
    model: Option<&[u8]>,
    timeout: Duration,
) -> Outcome<Run> {
    let result = device::ask(firmware, model, line, timeout);
    if let Err(failure) = &result {
        assert!(
            failure.exit != host_tools::failure::Exit::Missing,
            "{failure}\n  (`make test` installs it)"
        );
    }
    result
}
