//! A request taken to the emulated device and back: the picture on its panel, what it cost,
//! and what it said.

use std::time::Duration;

use defmt_decoder::{DecodeError, Table};
use rho_viewer::report::{Exit, Report};
use rho_viewer::request::Request;

use crate::failure::{Failure, Outcome};
use crate::firmware::Firmware;
use crate::panel::{self, Glass, Panel};
use crate::qemu::{self, Job};
use crate::render::frame_crc32;

/// What a device did.
#[derive(Clone, Debug)]
pub struct Run {
    /// Its own words: exit code, phases, stack.
    pub report: Report,
    /// What a person sees on the panel, from the bytes on its wire: RGB565 words, rows from the
    /// top, as many as the report's width and height say.
    pub words: Vec<u16>,
    /// Commands on the wire.
    pub wire_commands: u64,
    /// Bytes of data on the wire.
    pub wire_bytes: u64,
    /// The log, a line each.
    pub log: Vec<String>,
    /// What the emulator's plugin counted; empty without one.
    pub counts: String,
}

impl Run {
    /// This run, if the device did what it was asked.
    ///
    /// # Errors
    /// When it refused, with what it said.
    pub fn done(self) -> Outcome<Self> {
        match self.report.exit {
            Exit::Done => Ok(self),
            Exit::Request | Exit::Model => Err(Failure::input(format!(
                "the device says: {}",
                self.report.message
            ))),
            exit => Err(Failure::device(format!(
                "the device says: {exit}: {}",
                self.report.message
            ))),
        }
    }

    /// Pixels that are not the background.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.words.iter().filter(|word| **word != 0).count()
    }
}

/// Has the request drawn by the firmware in the emulator, and decodes its wire.
///
/// A device that refuses what it is asked has done its work: that is told by [`Run::done`],
/// and the panel then shows the reason.
///
/// # Errors
/// When the emulator is missing, when the device panics, faults, locks up or takes too long,
/// and when the picture on the wire is not the frame that the device reports.
pub fn run(
    firmware: &Firmware,
    model: Option<&[u8]>,
    request: &Request,
    timeout: Duration,
) -> Outcome<Run> {
    ask(firmware, model, &request.line(), timeout)
}

/// The same for any line of text, also one that is no request.
///
/// # Errors
/// Those of [`run`].
pub fn ask(
    firmware: &Firmware,
    model: Option<&[u8]>,
    line: &str,
    timeout: Duration,
) -> Outcome<Run> {
    answer(&Job {
        firmware,
        model,
        request: line,
        timeout,
        plugin: None,
    })
}

/// The same for any job.
///
/// # Errors
/// Those of [`run`].
pub fn answer(job: &Job<'_>) -> Outcome<Run> {
    let record = qemu::run(job)?;
    let log = decode(job.firmware.elf(), &record.log);
    let broken = |what: String| {
        let mut message = what;
        for line in log
            .iter()
            .map(String::as_str)
            .chain(record.complaints.lines())
        {
            message.push_str("\n  ");
            message.push_str(line);
        }
        Failure::device(message)
    };
    let code = record
        .exit_code
        .ok_or_else(|| broken("the processor locked up (the stack may be too small)".to_owned()))?;
    let exit = u8::try_from(code)
        .ok()
        .and_then(Exit::from_code)
        .ok_or_else(|| broken(format!("the emulator ended with {code}")))?;
    if matches!(exit, Exit::Panic | Exit::Fault) {
        // Whatever it had written before, its last words come last.
        let last = record.report.rfind("exit=").unwrap_or(0);
        let message = Report::parse(&record.report[last..]).map(|report| report.message);
        return Err(broken(format!("{exit}: {}", message.unwrap_or_default())));
    }
    let report = match Report::parse(&record.report) {
        Ok(report) if report.exit == exit => report,
        Ok(_) => {
            return Err(broken(format!(
                "the report and the exit code {code} differ"
            )));
        }
        Err(_) if exit != Exit::Done => {
            return Err(broken(format!("the device ended with {code}: {exit}")));
        }
        Err(error) => return Err(broken(error.to_string())),
    };
    let events = panel::wire::read(&record.wires).map_err(|error| broken(error.to_string()))?;
    let mut panel = Panel::new(Glass::MODULE);
    panel.drive(events);
    let faults = panel.faults();
    if !faults.is_empty() {
        return Err(broken(format!(
            "on the panel's wire: {}",
            faults.join("; ")
        )));
    }
    let words = panel::crop(&panel.seen(), report.width, report.height);
    let crc32 = frame_crc32(&words);
    if crc32 != report.frame_crc32 {
        return Err(broken(format!(
            "the picture on the wire has CRC {crc32:08x}, the device's frame {:08x}",
            report.frame_crc32
        )));
    }
    Ok(Run {
        report,
        words,
        wire_commands: panel.commands(),
        wire_bytes: panel.data_bytes(),
        log,
        counts: record.counts,
    })
}

/// The log as lines, with the strings that the ELF keeps; what cannot be decoded is told as such.
fn decode(elf: &[u8], bytes: &[u8]) -> Vec<String> {
    let table = match Table::parse(elf) {
        Ok(Some(table)) => table,
        Ok(None) => return Vec::new(),
        Err(error) => return vec![format!("the log cannot be read: {error}")],
    };
    let mut decoder = table.new_stream_decoder();
    decoder.received(bytes);
    let mut lines = Vec::new();
    loop {
        match decoder.decode() {
            Ok(frame) => {
                let level = frame.level().map_or("", |level| level.as_str());
                lines.push(format!("{level:5} {}", frame.display_message()));
            }
            Err(DecodeError::UnexpectedEof) => return lines,
            Err(DecodeError::Malformed) => lines.push("(a broken line)".to_owned()),
        }
    }
}
