//! Tells whether the loops in assembly are wanted and the core has their instructions.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(rho_thumb)");
    println!("cargo::rerun-if-changed=build.rs");
    let target = std::env::var("TARGET").unwrap_or_default();
    let wanted = std::env::var_os("CARGO_FEATURE_ASM").is_some();
    if wanted && (target.starts_with("thumbv7") || target.starts_with("thumbv8m.main")) {
        println!("cargo::rustc-cfg=rho_thumb");
    }
}
