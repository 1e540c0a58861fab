//! Everything of rho-grid that runs on the PC: the library behind the `rho` command.
#![forbid(unsafe_code)]

pub mod bake;
pub mod bench;
pub mod blob_file;
pub mod cargo;
pub mod cli;
pub mod colour;
pub mod compare;
pub mod contents;
pub mod depth;
pub mod device;
pub mod encode;
pub mod failure;
pub mod firmware;
pub mod flash;
pub mod geometry;
pub mod machine;
pub mod mesh;
pub mod model;
pub mod palette;
pub mod panel;
pub mod paper;
pub mod peak;
pub mod peer;
pub mod picture;
pub mod profile;
pub mod qemu;
pub mod quantise;
pub mod reference;
pub mod render;
pub mod replace;
pub mod sampling;
pub mod scene;
pub mod source;
pub mod text;
pub mod view;
