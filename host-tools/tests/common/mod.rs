//! What the tests of several commands share.

#![allow(dead_code, reason = "each test program takes what it needs")]

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

/// What a command that must end with exit 2 and print nothing says on stderr.
pub(crate) fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = rho(folder, arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?} {output:?}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

/// A folder with [`TETRAHEDRON`] in it.
pub(crate) fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("t.obj"), TETRAHEDRON).unwrap();
    folder
}

/// The files in a folder, sorted.
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}
