//! The gallery: each picture is made by the commands that stand under it on the page.
//!
//! `make gallery` writes `docs/gallery.md` and `docs/gallery/*.png` anew; look at every picture
//! before it is committed. Blobs stay in `target/gallery`.

use std::env;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use host_tools::model;
use host_tools::picture::Picture;
use rho_tests::firmware::workspace;

/// What stands for the folder with the scans in the commands of the page.
const MODELS: &str = "MODELS";

/// One model of the gallery.
struct Entry {
    /// Of the pictures and the blob.
    name: &'static str,
    title: &'static str,
    /// What is baked, and with which flags.
    bake: &'static str,
    views: &'static [&'static str],
    credit: &'static str,
}

const STANFORD: &str = "From the Stanford Computer Graphics Laboratory, by the \
    [Stanford 3D Scanning Repository](https://graphics.stanford.edu/data/3Dscanrep/): free for \
    research and publication with credit, no commercial use without permission.";

const ENTRIES: [Entry; 5] = [
    Entry {
        name: "bunny",
        title: "Stanford bunny",
        bake: "MODELS/bunny.ply.gz",
        views: &["near", "far"],
        credit: STANFORD,
    },
    Entry {
        name: "dragon",
        title: "Stanford dragon",
        bake: "MODELS/dragon.ply.gz",
        views: &["near", "far"],
        credit: STANFORD,
    },
    Entry {
        name: "buddha",
        title: "Happy Buddha, reduced to 100,000 triangles",
        bake: "MODELS/buddha_100k.ply.gz --up z",
        views: &["near", "far"],
        credit: STANFORD,
    },
    Entry {
        name: "oak",
        title: "Oak",
        bake: "MODELS/tree_oak.ply.gz",
        views: &["near", "far"],
        credit: "Generated with [ez-tree](https://github.com/dgreenheck/ez-tree) 1.1.0 (MIT), preset \
            oak_large with more segments, sections and leaves.",
    },
    Entry {
        name: "teapot",
        title: "Utah teapot",
        bake: "teapot",
        views: &["near", "near-turned", "far"],
        credit: "Martin Newell's patches, on a slab; `rho` has it built in.",
    },
];

const INTRODUCTION: &str = "\
# Gallery

Every picture was drawn by the firmware on the emulated Cortex-M3 and decoded from the bytes on its \
panel's wire: 240 x 320 pixels of RGB565, not scaled. The commands that made it stand below, with \
what they printed; `instructions` are those of one frame, counted exactly. `rho` stands for \
`cargo run --release --bin rho --` in this repository, `MODELS` for the folder with the scans, \
which are not part of it.

`make gallery` makes the pictures and this page again.
";

/// The folder with the scans.
fn models() -> PathBuf {
    let bunny = model::scan("bunny").unwrap_or_else(|failure| panic!("{failure}"));
    bunny.parent().unwrap().canonicalize().unwrap()
}

/// Runs `rho` as a user does in the workspace; what it printed.
fn rho(line: &str) -> String {
    let models = models().display().to_string();
    let arguments = line
        .split_whitespace()
        .map(|word| match word.strip_prefix(MODELS) {
            Some(file) => format!("{models}{file}"),
            None => word.to_owned(),
        });
    let output = Command::new(env::var_os("CARGO").unwrap_or("cargo".into()))
        .current_dir(workspace())
        .args(["run", "--quiet", "--release", "--package", "host-tools"])
        .args(["--bin", "rho", "--"])
        .args(arguments)
        .output()
        .expect("cargo runs");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "rho {line}\n{errors}");
    let figures = String::from_utf8_lossy(&output.stdout);
    // A bake tells what it made beside the blob, which may go to standard output.
    let report = if line.starts_with("bake") {
        &*errors
    } else {
        ""
    };
    format!("{report}{figures}").replace(&models, MODELS)
}

/// A command and what it prints, as on a terminal; but for lines of time and memory, which are
/// others on each machine.
fn transcript(page: &mut String, line: &str) {
    let printed = rho(line);
    println!("rho {line}\n{printed}");
    let _ = writeln!(page, "$ rho {line}");
    let figures = printed.lines().filter(|l| {
        let first = l.split_whitespace().next();
        !matches!(first, Some("seconds" | "memory"))
    });
    for line in figures {
        let _ = writeln!(page, "{line}");
    }
}

#[test]
#[ignore = "writes docs/gallery: make gallery"]
fn the_gallery_is_made_by_the_commands_on_its_page() {
    let at = |path: &str| workspace().join(path);
    for folder in ["target/gallery", "docs/gallery"] {
        fs::create_dir_all(at(folder)).unwrap();
    }
    let mut page = INTRODUCTION.to_owned();
    for Entry {
        name,
        title,
        bake,
        views,
        credit,
    } in ENTRIES
    {
        let mut console = String::new();
        let blob = format!("target/gallery/{name}.rho");
        transcript(&mut console, &format!("bake {bake} -o {blob}"));
        let mut pictures = String::new();
        for view in views {
            let picture = format!("gallery/{name}-{view}.png");
            let line = format!("run {blob} --view {view} -o docs/{picture}");
            transcript(&mut console, &line);
            let _ = writeln!(pictures, "![{title}, {view}]({picture})");
            check(&at("docs").join(picture));
        }
        let _ = write!(
            page,
            "\n## {title}\n\n{pictures}\n```console\n{console}```\n\n{credit}\n"
        );
    }
    fs::write(at("docs/gallery.md"), page).unwrap();
}

/// A picture of the panel's size with something on it, and not touching its border.
fn check(path: &Path) {
    let picture = Picture::read(path).unwrap_or_else(|failure| panic!("{failure}"));
    assert_eq!((picture.width, picture.height), (240, 320));
    let covered = |x: u32, y: u32| picture.rgb[(y * 240 + x) as usize] != [0; 3];
    let pixels = picture.rgb.iter().filter(|c| **c != [0; 3]).count();
    assert!(pixels > 300, "{}: {pixels}", path.display());
    assert!((0..240).all(|x| !covered(x, 0) && !covered(x, 319)));
    assert!((0..320).all(|y| !covered(0, y) && !covered(239, y)));
}
