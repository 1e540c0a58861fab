//! What a command ends with when it does not succeed: a message, a way out, an exit code.

use std::fmt;

/// The exit codes of every command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// A comparison or a limit failed.
    Limit = 1,
    /// Usage or bad input.
    Input = 2,
    /// Something needed is missing on this machine (QEMU, a target, a window).
    Missing = 3,
    /// The device faulted or timed out.
    Device = 4,
}

/// An error as the user sees it: what and where, then what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// The exit code.
    pub exit: Exit,
    /// What went wrong and where.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
}

impl Failure {
    /// A comparison or a limit failed (exit 1).
    pub fn limit(message: impl Into<String>) -> Self {
        Self::new(Exit::Limit, message)
    }

    /// Usage or bad input (exit 2).
    pub fn input(message: impl Into<String>) -> Self {
        Self::new(Exit::Input, message)
    }

    /// Something needed is missing on this machine (exit 3).
    pub fn missing(message: impl Into<String>) -> Self {
        Self::new(Exit::Missing, message)
    }

    /// The device faulted or timed out (exit 4).
    pub fn device(message: impl Into<String>) -> Self {
        Self::new(Exit::Device, message)
    }

    /// Adds what to do about it.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    fn new(exit: Exit, message: impl Into<String>) -> Self {
        Self {
            exit,
            message: message.into(),
            help: None,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        if let Some(help) = &self.help {
            write!(f, "\n  help: {help}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Failure {}

/// The result of a command or of a part of one.
pub type Outcome<T = ()> = Result<T, Failure>;
