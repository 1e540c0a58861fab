//! Supplies the board's memory layout and the linker scripts.
//!
//! The arguments stand here and not in the configuration of cargo, because RUSTFLAGS in the
//! environment replaces what stands there, and the link then ends well with an empty image.

use std::path::PathBuf;
use std::{env, fs};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=board.x");
    println!("cargo::rerun-if-env-changed=DEFMT_LOG");
    println!("cargo::rustc-check-cfg=cfg(armv6m)");
    if env::var("TARGET").is_ok_and(|target| target.starts_with("thumbv6m")) {
        println!("cargo::rustc-cfg=armv6m");
    }
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        // main.rs says what to do instead.
        return Ok(());
    }
    // memory.x of the workspace root includes board.x, and is found first wherever cargo runs.
    let out = PathBuf::from(env::var("OUT_DIR")?);
    fs::copy("board.x", out.join("board.x"))?;
    println!("cargo::rustc-link-search={}", out.display());
    for argument in ["-Tlink.x", "-Tdefmt.x", "--nmagic"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
    // Unless the caller chose another level; defmt keeps only errors by itself.
    if env::var_os("DEFMT_LOG").is_none() {
        println!("cargo::rustc-env=DEFMT_LOG=info");
    }
    Ok(())
}
