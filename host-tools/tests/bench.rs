//! `rho bench` and `rho profile` as a user calls them, as far as they end before the emulator
//! starts.

use std::process::{Command, Output};

fn rho(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rho"))
        .args(arguments)
        .output()
        .unwrap()
}

fn is_refused(arguments: &[&str], text: &str) {
    let output = rho(arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {errors}");
    assert!(errors.contains(text), "{arguments:?}: {errors}");
    assert!(output.stdout.is_empty());
}

#[test]
fn a_row_that_is_not_there_is_exit_2_and_tells_the_rows() {
    is_refused(&["bench", "--only", "cat"], "flat points");
}

#[test]
fn a_page_that_could_not_be_written_is_told_before_the_work() {
    is_refused(
        &["bench", "-o", "no-such-folder/bench.md"],
        "no-such-folder",
    );
}

#[test]
fn a_model_phase_or_core_that_is_not_there_is_exit_2() {
    is_refused(&["profile", "missing.rho"], "missing.rho");
    is_refused(&["profile", "a.rho", "--phase", "paint"], "shading_tables");
    is_refused(&["profile", "a.rho", "--core", "m7"], "m4");
}
