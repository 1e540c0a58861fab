//! Everything of rho-grid that runs on the PC: the library behind the `rho` command.
#![forbid(unsafe_code)]

pub mod cli;
pub mod device;
pub mod failure;
pub mod firmware;
pub mod mesh;
pub mod panel;
pub mod qemu;
pub mod view;
