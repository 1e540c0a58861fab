//! The command line: one file a command, nothing but flags, calls and printing.

use clap::{Parser, Subcommand};

use crate::failure::Outcome;

pub mod compare;
pub mod mode;
pub mod reference;
pub mod run;

/// Bakes 3D models for a microcontroller's flash and draws them with its code
#[derive(Parser, Debug)]
#[command(
    name = "rho",
    version,
    arg_required_else_help = true,
    propagate_version = true
)]
pub struct Rho {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    Run(Box<run::RunArgs>),
    Reference(reference::Reference),
    Compare(compare::Compare),
}

impl Rho {
    /// Runs the command.
    ///
    /// # Errors
    /// Whatever the command ends with; see [`crate::failure::Exit`].
    pub fn run(self) -> Outcome {
        match self.command {
            Command::Run(args) => args.run(),
            Command::Reference(command) => command.run(),
            Command::Compare(command) => command.run(),
        }
    }
}
