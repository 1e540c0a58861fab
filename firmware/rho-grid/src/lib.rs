//! Draws point samples in recursive grids with 32-bit integers.
#![no_std]
#![forbid(unsafe_code)]

pub mod camera;
pub mod mode;
pub mod q;
