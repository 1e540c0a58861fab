//! The commands' manners: what they refuse, what they print, what they read and write.

mod common;

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use common::{TETRAHEDRON, folder, json, names, refused, rho};

/// Makes t.rho of t.obj.
fn bake(folder: &Path, flags: &[&str]) {
    let command = [&["bake", "t.obj", "-o", "t.rho", "-q"], flags].concat();
    assert!(rho(folder, &command).status.success());
}

#[test]
fn flags_and_names_that_cannot_be_are_refused() {
    let folder = folder();
    let at = folder.path();
    std::fs::write(at.join("scene.toml"), "").unwrap();
    let before = names(at);
    for (arguments, reason) in [
        (&["bake", "t.obj", "teapot", "-o", "o.rho"][..], "bakes one"),
        (&["bake", "scene.toml", "-o", "o.rho"], "no object"),
        (&["bake", "coffeepot", "-o", "o.rho"], "teapot"),
        (&["bake", "t.obj", "-o", "t.obj"], "overwritten"),
        (&["bake", "t.obj", "-o", "none/o.rho"], "none/o.rho"),
        (&["bake", "t.obj", "-o", "."], "directory"),
        (&["bake", "t.obj", "-o", "-", "--json"], "standard output"),
        (&["bake", "t.obj", "-o", "o.rho", "--rho", "7"], "7"),
        (
            &[
                "bake",
                "t.obj",
                "-o",
                "o.rho",
                "--rho",
                "3,3",
                "--subdivisions",
                "3",
            ],
            "--subdivisions",
        ),
        (
            &["bake", "t.obj", "-o", "o.rho", "--preset", "x"],
            "--preset",
        ),
        (&["bake", "t.obj"], "--output"),
        (&["bake", "-o", "o.rho"], "MODEL"),
        (&["render", "t.obj", "-o", "o.png"], "not a rho blob"),
        (&["render", "none.rho", "-o", "o.png"], "none.rho"),
        (&["info", "none.rho"], "none.rho"),
    ] {
        let error = refused(at, arguments);
        assert!(error.contains(reason), "{arguments:?} {error}");
        assert_eq!(names(at), before, "{arguments:?}");
    }
}

#[test]
fn bake_and_info_count_the_same() {
    let folder = folder();
    let at = folder.path();
    let command = [
        "bake", "t.obj", "-o", "t.rho", "--rho", "2,3,3", "--thin", "--json",
    ];
    let baked = json(&rho(at, &command));
    for step in ["read", "sample", "encode", "write", "total"] {
        assert!(baked["seconds"][step].as_f64().is_some(), "{step}");
    }
    assert!(baked["peak_memory_bytes"].as_u64().unwrap() > 1 << 20);
    assert_eq!(baked["warnings"], serde_json::json!([]));

    let info = json(&rho(at, &["info", "t.rho", "--json"]));
    for key in [
        "nodes",
        "leaf_samples",
        "bytes",
        "bytes_per_leaf",
        "grids",
        "materials",
        "origin",
    ] {
        assert!(!info[key].is_null(), "{key}");
        assert_eq!(info[key], baked[key], "{key}");
    }
    let length = std::fs::metadata(at.join("t.rho")).unwrap().len();
    assert_eq!(info["bytes"]["total"], length);
    let grid = &info["grids"][0];
    assert_eq!(grid["rho"], serde_json::json!([2, 3, 3]));
    assert_eq!(grid["cells"], serde_json::json!([1, 2, 6, 18]));
    assert_eq!(
        (&grid["nodes"], &grid["separation"]),
        (&info["nodes"], &6.into())
    );
    let (nodes, leaves) = (
        grid["nodes"].as_f64().unwrap(),
        grid["leaf_samples"].as_f64().unwrap(),
    );
    let alpha = (nodes - 1.0) / (nodes - leaves);
    assert!((grid["alpha"].as_f64().unwrap() - alpha).abs() < 1e-12);
    assert_eq!(info["origin"]["source"], "t.obj");
    let text = rho(at, &["info", "t.rho"]);
    let text = String::from_utf8(text.stdout).unwrap();
    assert!(text.contains("2,3,3") && text.contains("t.obj"), "{text}");
}

#[test]
fn a_blob_is_the_same_from_a_file_standard_input_or_the_folder_of_models() {
    let folder = folder();
    let at = folder.path();
    assert!(
        rho(at, &["bake", "t.obj", "-o", "a.rho", "-q"])
            .status
            .success()
    );
    let elsewhere = tempfile::tempdir().unwrap();
    let models = at.to_str().unwrap();
    let command = ["bake", "t.obj", "-o", "-", "-q", "--models", models];
    let output = rho(elsewhere.path(), &command);
    assert!(output.stdout == std::fs::read(at.join("a.rho")).unwrap());
    assert!(output.stderr.is_empty());

    let mut child = Command::new(env!("CARGO_BIN_EXE_rho"))
        .args(["bake", "-", "-o", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(TETRAHEDRON.as_bytes()).unwrap();
    drop(stdin);
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    assert!(output.stdout.starts_with(b"\x89RHO"));
    assert!(
        String::from_utf8(output.stderr)
            .unwrap()
            .contains("standard input")
    );
}

#[test]
fn a_damaged_blob_is_refused_with_the_reason() {
    let folder = folder();
    let at = folder.path();
    bake(at, &[]);
    let whole = std::fs::read(at.join("t.rho")).unwrap();
    let mut newer = whole.clone();
    newer[8] = 9;
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 4;
    for (bytes, reason) in [
        (newer, "version 9 is newer"),
        (damaged, "wrong CRC of page"),
        (whole[..whole.len() - 100].to_vec(), "truncated"),
        (
            b"a text, and longer than a header of 32 bytes".to_vec(),
            "not a rho blob",
        ),
        (Vec::new(), "empty"),
        ([&whole[..], b"more"].concat(), "4 bytes follow"),
    ] {
        std::fs::write(at.join("bad.rho"), bytes).unwrap();
        for command in [
            &["info", "bad.rho"][..],
            &["render", "bad.rho", "-o", "o.png"],
        ] {
            let error = refused(at, command);
            assert!(
                error.contains("bad.rho") && error.contains(reason),
                "{error}"
            );
        }
    }
    assert!(!at.join("o.png").exists());
}

#[test]
fn a_frame_has_the_same_pixels_as_its_numbers_say() {
    let folder = folder();
    let at = folder.path();
    bake(at, &[]);
    let command = [
        "render",
        "t.rho",
        "-o",
        "f.png",
        "--preset",
        "fine",
        "--depth",
        "d.png",
        "--json",
        "--view",
        "near-turned",
        "--visibility",
        "z",
        "--cell-size",
        "1.5",
    ];
    let drawn = json(&rho(at, &command));
    let picture = host_tools::picture::Picture::read(&at.join("f.png")).unwrap();
    let words = picture.to_rgb565();
    let crc = host_tools::render::frame_crc32(&words);
    assert_eq!(drawn["frame_crc32"], format!("{crc:08x}"));
    assert_eq!(drawn["pixels"], words.iter().filter(|w| **w != 0).count());
    assert_eq!(
        (&drawn["width"], &drawn["height"]),
        (&240.into(), &320.into())
    );
    assert_eq!(drawn["visibility"], "z");
    assert_eq!(drawn["footprint"], "disc");
    assert_eq!(drawn["reciprocal"], "divide");
    assert_eq!(
        (&drawn["frame"], &drawn["grid"]),
        (&"words".into(), &5.into())
    );
    assert_eq!(drawn["cell_size"], 1.5);
    let depth = host_tools::depth::Depth::read(&at.join("d.png")).unwrap();
    let known = depth.values.iter().filter(|d| d.is_finite());
    assert_eq!(drawn["pixels"], known.clone().count());
    assert!(known.clone().all(|d| (1.0..4.0).contains(d)));
}

#[cfg(unix)]
#[test]
fn a_reader_that_has_seen_enough_is_no_error() {
    let folder = folder();
    let at = folder.path();
    bake(at, &["--rho", "3"]);
    let mut info = Command::new(env!("CARGO_BIN_EXE_rho"))
        .current_dir(at)
        .args(["info", "t.rho"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(info.stdout.take());
    let ended = info.wait_with_output().unwrap();
    assert_eq!(String::from_utf8_lossy(&ended.stderr), "");
}
