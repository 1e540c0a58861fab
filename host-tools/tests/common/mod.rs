//! What the tests of several commands share.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

/// The smallest closed model, as OBJ.
pub(crate) const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n\
                               f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

/// Runs the command in a folder.
pub(crate) fn rho(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rho"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the command runs")
}

/// The one JSON object that a command that succeeds prints.
pub(crate) fn json(output: &Output) -> Value {
    assert!(output.status.success(), "{output:?}");
    serde_json::from_slice(&output.stdout).expect("one JSON object and nothing else")
}
