//! What MODEL means on the command line.

use std::path::Path;

use clap::Args;

use crate::failure::Outcome;
use crate::model::{self, LoadOptions, Loaded, Up};

/// The flags that say how a model is read.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Model")]
pub struct ModelArgs {
    /// Which way is up in the file
    #[arg(long, value_enum, default_value_t = Up::Y)]
    pub up: Up,
    /// Ignore the colours of the file
    #[arg(long)]
    pub white: bool,
    /// The most memory that a model may take; K, M, G are 1024
    #[arg(long, value_name = "SIZE", default_value = "4G", value_parser = bytes)]
    pub memory: u64,
}

impl ModelArgs {
    /// The same for the readers.
    #[must_use]
    pub fn options(&self) -> LoadOptions {
        LoadOptions {
            memory_limit: self.memory,
            up: self.up,
            white: self.white,
        }
    }
}

/// The mesh of a model: a path, or `-` for a file on standard input.
///
/// # Errors
/// As [`model::load`].
pub fn mesh(model: &str, options: &LoadOptions) -> Outcome<Loaded> {
    model::load(Path::new(model), options)
}

/// A number of bytes such as `512K`; K, M and G are powers of 1024.
///
/// # Errors
/// A sentence for the command line.
pub fn bytes(text: &str) -> Result<u64, String> {
    let (number, shift) = match text.strip_suffix(['K', 'M', 'G']) {
        Some(number) if text.ends_with('K') => (number, 10),
        Some(number) if text.ends_with('M') => (number, 20),
        Some(number) => (number, 30),
        None => (text, 0),
    };
    number
        .parse::<u64>()
        .ok()
        .and_then(|n| n.checked_mul(1 << shift))
        .ok_or_else(|| "expected a number of bytes, such as 65536, 512K or 4M".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_powers_of_1024() {
        assert_eq!(bytes("512K"), Ok(524_288));
        assert_eq!(bytes("4G"), Ok(4 << 30));
        assert_eq!(bytes("7"), Ok(7));
        for bad in ["", "K", "-1", "1k", "1.5M", "99999999999G"] {
            assert!(bytes(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_name_that_is_no_file_says_so() {
        let failure = mesh("nothing-here.ply", &LoadOptions::default()).unwrap_err();
        assert!(
            failure.message.contains("no file nothing-here.ply"),
            "{failure}"
        );
    }
}
