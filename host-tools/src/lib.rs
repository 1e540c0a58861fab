//! Everything of rho-grid that runs on the PC: the library behind the `rho` command.
#![forbid(unsafe_code)]

pub mod cli;
pub mod compare;
pub mod depth;
pub mod failure;
pub mod mesh;
pub mod model;
pub mod picture;
pub mod reference;
pub mod replace;
pub mod view;
