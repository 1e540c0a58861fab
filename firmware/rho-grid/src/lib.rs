//! Draws point samples in recursive grids with 32-bit integers.
//!
//! A model of any number of polygons is baked on a PC into a *blob*: a hierarchy of point samples
//! in rho x rho x rho grids (Duguet & Drettakis 2003). This crate reads the blob in place, from
//! flash, and draws it into a [`Frame`](frame::Frame), without heap, floats, unsafe or panics, and
//! with the same bits on every machine.
//!
//! From the outside in:
//!
//! * [`render`]: a [`View`](render::View) is a camera as seen from a grid; [`render::draw`] draws.
//! * [`blob`]: bytes checked once; a [`Grid`](blob::Grid) is the proof that reading cannot fail.
//! * [`shading`], [`normal`]: one colour a normal and material, computed before drawing.
//! * [`frame`]: pixels, for and from embedded-graphics.
//! * [`camera`], [`mode`], [`q`], [`reciprocal`]: the words of the interface.
//!
//! It does not support floats, textures, transparency, or blobs on big-endian machines.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing
    )
)]

pub mod blob;
pub mod camera;
pub mod frame;
pub mod mode;
pub mod normal;
pub mod q;
pub mod reciprocal;
pub mod render;
pub mod shading;
