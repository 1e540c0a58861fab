//! The emulated machines, and what is built for each.

use clap::ValueEnum;

use crate::cargo::Package;

/// A core, with the emulator's board that runs its programs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Machine {
    /// Cortex-M0: no divider, no long product; its program, run by a Cortex-M3
    M0,
    /// Cortex-M3
    #[default]
    M3,
    /// Cortex-M4F
    M4,
}

impl Machine {
    /// All, the smallest first.
    pub const ALL: [Self; 3] = [Self::M0, Self::M3, Self::M4];

    /// The core's name.
    #[must_use]
    pub const fn core(self) -> &'static str {
        match self {
            Self::M0 => "Cortex-M0",
            Self::M3 => "Cortex-M3",
            Self::M4 => "Cortex-M4F",
        }
    }

    /// What the emulator calls the board. It has none with a Cortex-M0 and enough memory.
    #[must_use]
    pub const fn board(self) -> &'static str {
        match self {
            Self::M0 | Self::M3 => "mps2-an385",
            Self::M4 => "mps2-an386",
        }
    }

    /// The Rust target.
    #[must_use]
    pub const fn target(self) -> &'static str {
        match self {
            Self::M0 => "thumbv6m-none-eabi",
            Self::M3 => "thumbv7m-none-eabi",
            Self::M4 => "thumbv7em-none-eabihf",
        }
    }

    /// The viewer for it. One program serves both boards: their devices and addresses are the
    /// same.
    #[must_use]
    pub const fn viewer(self) -> Package<'static> {
        Package {
            name: "rho-mps2-an385",
            program: Some("rho-mps2-an385"),
            // That of all that runs on a microcontroller.
            profile: "firmware",
            target: Some(self.target()),
        }
    }
}
