//! The `rho` command.

use std::process::ExitCode;

use clap::Parser;
use host_tools::cli::Rho;

fn main() -> ExitCode {
    match Rho::parse().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::from(failure.exit as u8)
        }
    }
}
