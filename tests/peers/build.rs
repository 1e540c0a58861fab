//! The linker scripts; the board's memory layout comes with the board's crate.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    for argument in ["-Tlink.x", "-Tdefmt.x", "--nmagic"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
}
