//! The commands `reference` and `compare`, as a user runs them.

mod common;

use std::io::Write;
use std::process::{Command, Stdio};

use common::{TETRAHEDRON, json, rho};

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("t.obj"), TETRAHEDRON).unwrap();
    folder
}

#[test]
fn a_reference_compares_with_itself_as_equal() {
    let folder = folder();
    let at = folder.path();
    let drawn = rho(
        at,
        &[
            "reference",
            "t.obj",
            "-o",
            "t.png",
            "--depth",
            "d.png",
            "--json",
        ],
    );
    let drawn = json(&drawn);
    assert_eq!(drawn["format"], "obj");
    assert_eq!(drawn["triangles"], 4);
    assert!(drawn["covered"].as_u64().unwrap() > 1000);
    let compared = json(&rho(
        at,
        &[
            "compare",
            "t.png",
            "t.png",
            "--json",
            "--min-iou",
            "1",
            "--max-holes",
            "0",
            "--depth",
            "d.png",
            "--reference-depth",
            "d.png",
            "--cells",
            "243",
        ],
    ));
    for (key, value) in [("psnr_union", 120.0), ("psnr_inside", 120.0), ("iou", 1.0)] {
        assert_eq!(compared[key], value, "{key}");
    }
    assert!(compared["ssim"].as_f64().unwrap() > 0.999_999);
    assert_eq!(
        (&compared["holes"], &compared["leaks"]),
        (&0.into(), &0.into())
    );
    assert_eq!(compared["pixels"]["reference"], drawn["covered"]);
}

#[test]
fn the_same_command_writes_the_same_bytes_whatever_the_threads() {
    let folder = folder();
    let run = |threads: &str, name: &str| {
        let status = Command::new(env!("CARGO_BIN_EXE_rho"))
            .current_dir(folder.path())
            .env("RAYON_NUM_THREADS", threads)
            .args([
                "reference",
                "t.obj",
                "-q",
                "--view",
                "far-turned",
                "-o",
                name,
            ])
            .status();
        assert!(status.unwrap().success());
        std::fs::read(folder.path().join(name)).unwrap()
    };
    assert!(run("1", "a.png") == run("3", "b.png"));
}

#[test]
fn a_model_comes_from_standard_input_and_the_picture_goes_to_standard_output() {
    let folder = folder();
    let mut child = Command::new(env!("CARGO_BIN_EXE_rho"))
        .current_dir(folder.path())
        .args(["reference", "-", "-o", "-", "-q", "--size", "24x32"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child
        .stdin
        .take()
        .unwrap()
        .write_all(TETRAHEDRON.as_bytes())
        .unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    assert!(output.stdout.starts_with(b"\x89PNG"));
}

#[test]
fn broken_limits_exit_with_1_and_bad_input_with_2() {
    let folder = folder();
    let at = folder.path();
    for (name, more) in [
        ("n.png", &["--view", "near"][..]),
        ("f.png", &["--view", "far"]),
        ("s.png", &["--size", "24x32"]),
    ] {
        let command = [&["reference", "t.obj", "-q", "-o", name][..], more].concat();
        assert!(rho(at, &command).status.success());
    }
    for limit in [
        ["--min-iou", "0.9"],
        ["--min-psnr-inside", "20"],
        ["--min-psnr-union", "20"],
        ["--max-holes", "0"],
    ] {
        let command = [&["compare", "f.png", "n.png"][..], &limit].concat();
        let output = rho(at, &command);
        assert_eq!(output.status.code(), Some(1), "{limit:?} {output:?}");
        assert!(!output.stdout.is_empty() && !output.stderr.is_empty());
    }
    for command in [
        &["compare", "s.png", "n.png"][..],
        &["compare", "t.obj", "n.png"],
        &["compare", "none.png", "n.png"],
        &[
            "compare",
            "n.png",
            "n.png",
            "--depth",
            "n.png",
            "--reference-depth",
            "n.png",
            "--cells",
            "9",
        ],
        &["compare", "n.png", "n.png", "--cells", "9"],
        &["reference", "none.ply", "-o", "x.png"],
        &["reference", "t.obj", "-o", "no/folder/x.png"],
        &["reference", "t.obj", "-o", "x.png", "--samples", "0"],
        &["reference", "t.obj", "-o", "x.png", "--fov", "180"],
        &["reference", "t.obj", "-o", "x.png", "--memory", "100"],
        &["reference", "t.obj", "-o", "-", "--json"],
        &["reference", "t.obj"],
    ] {
        let output = rho(at, command);
        assert_eq!(output.status.code(), Some(2), "{command:?} {output:?}");
        assert!(output.stdout.is_empty(), "{command:?}");
        assert!(!at.join("x.png").exists());
    }
}
