//! The command line: one file a command, nothing but flags, calls and printing.

use clap::{Parser, Subcommand};

use crate::failure::Outcome;

pub mod bake;
pub mod bench;
pub mod compare;
pub mod info;
pub mod mode;
pub mod paper;
pub mod profile;
pub mod reference;
pub mod render;
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
    Bake(Box<bake::Bake>),
    Info(info::Info),
    Render(Box<render::Render>),
    Run(Box<run::RunArgs>),
    Profile(Box<profile::ProfileArgs>),
    Reference(reference::Reference),
    Compare(compare::Compare),
    Bench(bench::BenchArgs),
    Paper(paper::PaperArgs),
}

impl Rho {
    /// Runs the command.
    ///
    /// # Errors
    /// Whatever the command ends with; see [`crate::failure::Exit`].
    pub fn run(self) -> Outcome {
        match self.command {
            Command::Bake(command) => command.run(),
            Command::Info(command) => command.run(),
            Command::Render(command) => command.run(),
            Command::Run(command) => command.run(),
            Command::Profile(command) => command.run(),
            Command::Reference(command) => command.run(),
            Command::Compare(command) => command.run(),
            Command::Bench(command) => command.run(),
            Command::Paper(command) => command.run(),
        }
    }
}
