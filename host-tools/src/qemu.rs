//! The emulated board: one of QEMU's, run once and never longer than allowed.

use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::failure::{Failure, Outcome};
use crate::firmware::Firmware;

/// The emulator.
const PROGRAM: &str = "qemu-system-arm";
/// Where the firmware looks for a model: the board's PSRAM.
pub const MODEL_ADDRESS: u32 = 0x2100_0000;
/// The size of that memory.
pub const MODEL_BYTES: u64 = 16 << 20;
/// The board's counter, whose readings bound what is counted.
const COUNTER_ADDRESS: u32 = 0x4002_8018;
/// How often the emulator is asked whether it has ended.
const POLL: Duration = Duration::from_millis(5);
/// A record of the wires longer than this is that of a program that writes for ever; a frame
/// needs 8 MB.
const RECORD_LIMIT: u64 = 1 << 30;

/// What to run.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    /// The program.
    pub firmware: &'a Firmware,
    /// The bytes of the model's memory, if any.
    pub model: Option<&'a [u8]>,
    /// The line of text that the program can ask for.
    pub request: &'a str,
    /// How long it may take.
    pub timeout: Duration,
    /// The library that counts how often each instruction runs, if that is wanted.
    pub plugin: Option<&'a Path>,
}

/// What came out.
#[derive(Clone, Debug)]
pub struct Record {
    /// How the program ended; none when the emulator itself was aborted, as it does when the
    /// processor locks up.
    pub exit_code: Option<i32>,
    /// The log, as the program encodes it.
    pub log: Vec<u8>,
    /// What the emulator complained about.
    pub complaints: String,
    /// What the program wrote to its UART.
    pub report: String,
    /// Each write to a device, a line each.
    pub wires: String,
    /// What the plugin counted; empty without one.
    pub counts: String,
}

/// Runs the program until it ends.
///
/// # Errors
/// When QEMU is missing or does not start, when the model is larger than its memory, and when
/// the program takes longer than allowed.
pub fn run(job: &Job<'_>) -> Outcome<Record> {
    let folder = tempfile::tempdir().map_err(|e| scratch(&e))?;
    let at = |name: &str| folder.path().join(name);
    let mut command = Command::new(PROGRAM);
    // The files have plain names in a folder of their own: no comma needs care.
    command
        .current_dir(folder.path())
        .args(["-M", job.firmware.machine().board()])
        .args(["-display", "none", "-monitor", "none"])
        .args(["-nic", "none", "-icount", "shift=6,sleep=off"])
        .args(["-serial", "file:report"])
        .args(["-trace", "memory_region_ops_write", "-D", "wires"])
        .arg("-semihosting-config")
        .arg(format!(
            "enable=on,target=native,arg={}",
            job.request.replace(',', ",,")
        ))
        .arg("-kernel")
        .arg(job.firmware.path());
    if let Some(model) = job.model {
        if model.len() as u64 > MODEL_BYTES {
            return Err(Failure::input(format!(
                "the model has {} bytes, {} more than the board's memory for it",
                model.len(),
                model.len() as u64 - MODEL_BYTES
            ))
            .help("bake it with fewer subdivisions, or with --flash 16M"));
        }
        fs::write(at("model"), model).map_err(|e| scratch(&e))?;
        command.arg("-device").arg(format!(
            "loader,file=model,addr={MODEL_ADDRESS:#x},force-raw=on"
        ));
    }
    if let Some(plugin) = job.plugin {
        let library = plugin.display().to_string().replace(',', ",,");
        command.arg("-plugin").arg(format!(
            "file={library},counter={COUNTER_ADDRESS:08x},out=counts"
        ));
    }
    let create = |name: &str| File::create(at(name)).map_err(|e| scratch(&e));
    command
        .stdin(Stdio::null())
        .stdout(create("log")?)
        .stderr(create("complaints")?);
    let child = command.spawn().map_err(|e| not_started(&e))?;
    let status = wait(child, job.timeout, &at("wires"))?;
    let text = |name: &str| {
        fs::read(at(name))
            .map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
            .unwrap_or_default()
    };
    Ok(Record {
        exit_code: status.code(),
        log: fs::read(at("log")).unwrap_or_default(),
        // The board's network chip is not connected, which is meant.
        complaints: text("complaints")
            .lines()
            .filter(|line| !line.ends_with("has no peer"))
            .map(|line| format!("{line}\n"))
            .collect(),
        report: text("report"),
        wires: text("wires"),
        counts: text("counts"),
    })
}

/// Waits for the end, but not for ever.
fn wait(mut child: Child, timeout: Duration, wires: &Path) -> Outcome<ExitStatus> {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait().map_err(|e| not_started(&e))? {
            return Ok(status);
        }
        let flood = fs::metadata(wires).is_ok_and(|file| file.len() > RECORD_LIMIT);
        let late = start.elapsed() >= timeout;
        if flood || late {
            // It may end by itself in this moment; either way it is gone afterwards.
            let _ = child.kill();
            let _ = child.wait();
            let seconds = timeout.as_secs_f64();
            return Err(if flood {
                Failure::device("the device writes to its pins and ports for ever")
            } else {
                Failure::device(format!("the device timed out after {seconds} s"))
                    .help("allow more with --timeout SECONDS")
            });
        }
        thread::sleep(POLL);
    }
}

fn scratch(error: &io::Error) -> Failure {
    Failure::missing(format!("no room for temporary files: {error}"))
        .help("free some space, or set TMPDIR to a folder that has some")
}

fn not_started(error: &io::Error) -> Failure {
    Failure::missing(format!("{PROGRAM} does not start: {error}"))
        .help("apt-get install --no-install-recommends qemu-system-arm")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::failure::Exit;

    #[test]
    fn what_does_not_end_is_killed_and_told() {
        let child = Command::new("sleep").arg("100").spawn().unwrap();
        let id = child.id();
        let failure = wait(child, Duration::from_millis(20), Path::new("none")).unwrap_err();
        assert_eq!(failure.exit, Exit::Device);
        assert!(failure.message.contains("timed out"));
        assert!(!Path::new(&format!("/proc/{id}")).exists());
    }

    #[test]
    fn a_missing_emulator_tells_the_command_that_installs_it() {
        let failure = not_started(&io::Error::from(io::ErrorKind::NotFound));
        assert_eq!(failure.exit, Exit::Missing);
        assert!(failure.help.unwrap().contains("apt-get install"));
    }
}
