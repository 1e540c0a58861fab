//! What a device answers: `key=value` lines, ended by `end`.
//!
//! The answer leaves by its own channel (a UART), so that it depends on no log. Device and
//! host share this one type: the device writes it, the host reads it.
//!
//! ```text
//! exit=0
//! size=240;320
//! frame_crc32=5f3a9c01
//! setup=0
//! (each phase)
//! pieces=0123
//! stack_bytes=1234
//! end
//! ```
//!
//! A piece is a phase by its place among them; they follow each other as they ran.
//!
//! A self-test adds `probe=EXPECTED;COUNTED` lines; a device that could not do what was asked
//! adds `message=TEXT`.

use core::fmt;
use core::str::FromStr;

use heapless::{String, Vec};

use crate::count::{PROBES, Phase, Phases, Probe};

/// The longest message; longer ones are cut.
pub const MAX_MESSAGE: usize = 240;

/// What a message is kept in.
pub type Message = String<MAX_MESSAGE>;

/// How a device ends: the exit code of the program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// The picture is on the panel.
    #[default]
    Done = 0,
    /// The request could not be read.
    Request = 10,
    /// There is no model, or none that can be drawn.
    Model = 11,
    /// The panel did not take what was sent.
    Panel = 12,
    /// The report could not be sent.
    Report = 13,
    /// The program panicked.
    Panic = 20,
    /// The processor faulted.
    Fault = 21,
}

impl Exit {
    /// All.
    pub const ALL: [Self; 7] = [
        Self::Done,
        Self::Request,
        Self::Model,
        Self::Panel,
        Self::Report,
        Self::Panic,
        Self::Fault,
    ];

    /// The exit code.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// What has this exit code.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|exit| exit.code() == code)
    }
}

impl fmt::Display for Exit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Done => "the picture is on the panel",
            Self::Request => "the request could not be read",
            Self::Model => "the model cannot be drawn",
            Self::Panel => "the panel did not take what was sent",
            Self::Report => "the report could not be sent",
            Self::Panic => "the program panicked",
            Self::Fault => "the processor faulted",
        })
    }
}

/// The answer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// How it ended.
    pub exit: Exit,
    /// Columns of the frame.
    pub width: u16,
    /// Rows of the frame.
    pub height: u16,
    /// CRC-32 (IEEE) of the frame's RGB565 words, little-endian, rows from the top.
    pub frame_crc32: u32,
    /// What the second of two equal frames cost.
    pub phases: Phases,
    /// How deep the stack has been.
    pub stack_bytes: u32,
    /// The counter's self-test, if it was asked for.
    pub probes: Vec<Probe, PROBES>,
    /// Why it could not be done; empty when it was.
    pub message: Message,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "exit={}", self.exit.code())?;
        writeln!(f, "size={};{}", self.width, self.height)?;
        writeln!(f, "frame_crc32={:08x}", self.frame_crc32)?;
        for phase in Phase::ALL {
            writeln!(f, "{}={}", phase.name(), self.phases.get(phase))?;
        }
        f.write_str("pieces=")?;
        for piece in self.phases.pieces() {
            write!(f, "{}", piece as u8)?;
        }
        writeln!(f, "\nstack_bytes={}", self.stack_bytes)?;
        for probe in &self.probes {
            writeln!(f, "probe={};{}", probe.expected, probe.counted)?;
        }
        if !self.message.is_empty() {
            f.write_str("message=")?;
            for c in self.message.chars() {
                // One line a message, whatever is in it.
                fmt::Write::write_char(f, if c.is_control() { ' ' } else { c })?;
            }
            f.write_str("\n")?;
        }
        writeln!(f, "end")
    }
}

/// Why a text is no report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReportError {
    /// The last line is not there: the device ended before it had told everything.
    Cut,
    /// A line that is none of a report's, by its number from 1.
    Line(usize),
    /// A key that every report has is not there.
    Missing(&'static str),
}

impl fmt::Display for ReportError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cut => f.write_str("the report has no end"),
            Self::Line(number) => write!(f, "line {number} of the report makes no sense"),
            Self::Missing(key) => write!(f, "the report has no {key}"),
        }
    }
}

impl core::error::Error for ReportError {}

fn pair<T: FromStr, U: FromStr>(text: &str) -> Option<(T, U)> {
    let (a, b) = text.split_once(';')?;
    Some((a.parse().ok()?, b.parse().ok()?))
}

impl Report {
    /// Reads what a device wrote.
    ///
    /// # Errors
    /// When lines are missing or make no sense.
    pub fn parse(text: &str) -> Result<Self, ReportError> {
        let mut report = Self::default();
        let mut seen = [("exit", false), ("size", false), ("frame_crc32", false)];
        for (index, line) in text.lines().enumerate() {
            if line == "end" {
                return match seen.iter().find(|(_, seen)| !seen) {
                    None => Ok(report),
                    Some((key, _)) => Err(ReportError::Missing(key)),
                };
            }
            let (key, value) = line.split_once('=').ok_or(ReportError::Line(index + 1))?;
            if let Some((_, seen)) = seen.iter_mut().find(|(k, _)| *k == key) {
                *seen = true;
            }
            report.set(key, value).ok_or(ReportError::Line(index + 1))?;
        }
        Err(ReportError::Cut)
    }

    fn set(&mut self, key: &str, value: &str) -> Option<()> {
        match key {
            "exit" => self.exit = Exit::from_code(value.parse().ok()?)?,
            "size" => (self.width, self.height) = pair(value)?,
            "frame_crc32" => self.frame_crc32 = u32::from_str_radix(value, 16).ok()?,
            "stack_bytes" => self.stack_bytes = value.parse().ok()?,
            "pieces" => {
                for digit in value.chars() {
                    let piece = digit.to_digit(10)? as usize;
                    self.phases.follow(*Phase::ALL.get(piece)?);
                }
            }
            "probe" => {
                let (expected, counted) = pair(value)?;
                self.probes.push(Probe { expected, counted }).ok()?;
            }
            "message" => self.message = value.parse().ok()?,
            _ => {
                let phase = Phase::ALL.into_iter().find(|p| p.name() == key)?;
                self.phases.sum(phase, value.parse().ok()?);
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::string::ToString;

    fn full() -> Report {
        let mut phases = Phases::default();
        for (i, phase) in Phase::ALL.into_iter().enumerate() {
            phases.add(phase, u64::MAX - i as u64);
        }
        Report {
            exit: Exit::Model,
            width: 240,
            height: 320,
            frame_crc32: 0x0123_abcd,
            phases,
            stack_bytes: 4_096,
            probes: Vec::from_slice(&[Probe {
                expected: 7,
                counted: 8,
            }])
            .unwrap(),
            message: "no model = nothing to draw".parse().unwrap(),
        }
    }

    #[test]
    fn a_report_reads_back_as_itself() {
        for report in [full(), Report::default()] {
            assert_eq!(Report::parse(&report.to_string()), Ok(report));
        }
    }

    #[test]
    fn a_report_cut_anywhere_is_told_from_a_whole_one() {
        let text = full().to_string();
        for length in 0..text.len() - 1 {
            assert!(Report::parse(&text[..length]).is_err(), "{length}");
        }
    }

    #[test]
    fn a_message_of_several_lines_stays_one_line() {
        let report = Report {
            message: "a\nend\nb".parse().unwrap(),
            ..Report::default()
        };
        let read = Report::parse(&report.to_string()).unwrap();
        assert_eq!(read.message, "a end b");
    }

    #[test]
    fn every_exit_code_reads_back_as_itself() {
        for exit in Exit::ALL {
            assert_eq!(Exit::from_code(exit.code()), Some(exit));
        }
    }

    proptest! {
        #[test]
        fn no_text_makes_the_parser_panic(text in "([a-z0-9_=;]*\n)*(end\n)?") {
            let _ = Report::parse(&text);
        }
    }
}
