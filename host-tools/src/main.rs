//! The `rho` command.

use std::process::ExitCode;

use clap::Parser;
use host_tools::cli::Rho;

fn main() -> ExitCode {
    // Into a pipe whose reader has seen enough, as of `rho info m.rho | head`, writing just ends.
    sigpipe::reset();
    match Rho::parse().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::from(failure.exit as u8)
        }
    }
}
