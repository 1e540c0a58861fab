//! `rho run` as a user calls it: exit codes, files, and what goes to which stream.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use host_tools::firmware::Firmware;
use host_tools::machine::Machine;

fn workspace() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// Built once, in the same place as for the tests of the whole.
fn firmware() -> &'static Path {
    static FIRMWARE: OnceLock<Firmware> = OnceLock::new();
    FIRMWARE
        .get_or_init(|| {
            let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
            let folder = target.join("firmware-under-test");
            Firmware::build(Machine::M3, workspace(), Some(&folder))
                .unwrap_or_else(|e| panic!("{e}"))
        })
        .path()
}

/// Runs the command in a folder of its own.
fn rho(folder: &Path, arguments: &[&str]) -> Output {
    rho_at(folder, arguments, None)
}

fn rho_at(folder: &Path, arguments: &[&str], path: Option<&Path>) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rho"));
    command.current_dir(folder).args(arguments);
    if let Some(path) = path {
        command.env("PATH", path).env_remove("CARGO");
    }
    command.output().unwrap()
}

fn code(output: &Output) -> i32 {
    let text = String::from_utf8_lossy(&output.stderr);
    output.status.code().unwrap_or_else(|| panic!("{text}"))
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn test_card<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let image = firmware().to_str().unwrap();
    let mut arguments = vec!["run", "--picture", "test-card", "--firmware", image];
    arguments.extend(more);
    arguments
}

fn scratch() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap();
    entries.map(|e| e.unwrap().file_name().into()).collect()
}

#[test]
fn the_picture_is_a_png_and_the_figures_are_one_line() {
    let folder = scratch();
    let output = rho(folder.path(), &test_card(&["-o", "card.png"]));
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.lines().count(), 1);
    assert!(text.contains(" instructions, "), "{text}");
    let file = std::io::BufReader::new(fs::File::open(folder.path().join("card.png")).unwrap());
    let reader = png::Decoder::new(file).read_info().unwrap();
    assert_eq!((reader.info().width, reader.info().height), (240, 320));
    assert_eq!(files(folder.path()), [Path::new("card.png")]);
}

#[test]
fn json_is_one_object_with_the_figures_and_nothing_else() {
    let folder = scratch();
    let output = rho(folder.path(), &test_card(&["--json", "-v"]));
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let object: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(object["instructions"].as_u64().unwrap() > 10_000);
    let phases = object["instructions_by_phase"].as_object().unwrap();
    let sum: u64 = phases
        .iter()
        .filter(|(name, _)| !["shading_tables", "send"].contains(&name.as_str()))
        .map(|(_, count)| count.as_u64().unwrap())
        .sum();
    assert_eq!(object["instructions"], sum);
    assert_eq!(phases.len(), 7);
    for key in ["pixels", "ram_bytes", "stack_bytes"] {
        assert!(object[key].as_u64().unwrap() > 1000, "{key}");
    }
    assert_eq!(object["frame_crc32"].as_str().unwrap().len(), 8);
    assert!(stderr(&output).contains("request"), "the log");
}

#[test]
fn bad_input_is_exit_2_and_leaves_the_old_picture() {
    let folder = scratch();
    fs::write(folder.path().join("cut.rho"), b"\x89RHO\r\n\x1a\n").unwrap();
    fs::write(folder.path().join("old.png"), b"old").unwrap();
    let image = firmware().to_str().unwrap();
    for (arguments, text) in [
        (&["run"][..], "no model"),
        (&["run", "missing.rho"], "missing.rho"),
        (&["run", "cut.rho"], "cut.rho"),
        (&["run", "cut.rho", "--footprint", "cat"], "point, splat"),
        (&["run", "cut.rho", "--cell-size", "-1"], "cell-size"),
        (&["run", "cut.rho", "--fov", "0"], "--fov"),
        (&["run", "cut.rho", "--timeout", "0"], "timeout"),
    ] {
        let arguments = [arguments, &["-o", "old.png", "--firmware", image]].concat();
        let output = rho(folder.path(), &arguments);
        assert_eq!(code(&output), 2, "{arguments:?}");
        assert!(stderr(&output).contains(text), "{}", stderr(&output));
        assert!(output.stdout.is_empty());
    }
    assert_eq!(fs::read(folder.path().join("old.png")).unwrap(), b"old");
}

#[test]
fn outside_the_workspace_the_firmware_must_be_named() {
    let folder = scratch();
    let output = rho(folder.path(), &["run", "--picture", "test-card"]);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("--firmware ELF"));
}

#[test]
fn without_the_emulator_the_command_that_installs_it_is_told() {
    let folder = scratch();
    let empty = folder.path().join("empty");
    fs::create_dir(&empty).unwrap();
    let output = rho_at(folder.path(), &test_card(&[]), Some(&empty));
    assert_eq!(code(&output), 3);
    assert!(stderr(&output).contains("apt-get install"));
}

#[test]
fn a_device_that_takes_too_long_is_exit_4() {
    let folder = scratch();
    let output = rho(folder.path(), &test_card(&["--timeout", "0.001"]));
    assert_eq!(code(&output), 4);
    assert!(stderr(&output).contains("timed out"));
}
