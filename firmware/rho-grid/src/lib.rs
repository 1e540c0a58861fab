//! Draws point samples in recursive grids with 32-bit integers.
//!
//! A model of any number of polygons is baked on a PC into a *blob*: a hierarchy of point samples
//! in rho x rho x rho grids (Duguet & Drettakis 2003). This crate reads the blob in place, from
//! flash, and draws it into a [`Frame`](frame::Frame), without heap, floats, panics or (but for the
//! loops of the feature `asm`) unsafe, and with the same bits on every machine.
//!
//! From the outside in:
//!
//! * [`scene`]: many objects in one frame; each is drawn as if it were alone.
//! * [`render`]: a [`View`](render::View) is a camera as seen from a grid; [`render::draw`] draws.
//! * [`blob`]: bytes checked once; a [`Grid`](blob::Grid) is the proof that reading cannot fail.
//! * [`lighting`], [`shading`], [`normal`]: one colour a normal and material, computed before drawing.
//! * [`frame`]: pixels, for and from embedded-graphics.
//! * [`camera`], [`mode`], [`q`], [`reciprocal`]: the words of the interface.
//!
//! ```
//! use rho_grid::blob::{Blob, BlobError};
//! use rho_grid::camera::Camera;
//! use rho_grid::frame::Frame;
//! use rho_grid::mode::Mode;
//! use rho_grid::lighting::Lighting;
//! use rho_grid::render::{Buffers, EyeOrder, View, draw_mode};
//! use rho_grid::shading::Shading;
//!
//! /// Draws the model in `flash` over `frame`; the tables are a board's statics.
//! fn picture(
//!     flash: &[u8],
//!     camera: &Camera,
//!     lighting: &Lighting,
//!     frame: &mut Frame<'_>,
//!     tables: &mut View,
//!     colours: &mut [u16],                                     // Shading::words(materials)
//!     coverage: &mut [u32; EyeOrder::words(240, 320)],
//! ) -> Result<(), BlobError> {
//!     let blob = Blob::parse(flash)?;                          // once, not a frame
//!     let mode = Mode::default();
//!     if let Some(grid) = blob.grid(0)
//!         && tables.prepare(camera, &grid, mode.cell_size).is_ok()
//!         && let Some(shading) = Shading::new(colours, grid.layout(), blob.materials(), lighting)
//!     {
//!         frame.clear_to(0);
//!         let mut buffers = Buffers { coverage, depth: &mut [] };
//!         buffers.clear(mode);
//!         // Only a buffer too small for the mode or the frame is an error.
//!         let _ = draw_mode(mode, &grid, tables, &shading, frame, &mut buffers);
//!     }
//!     Ok(())                                                   // then: frame.draw(&mut screen)
//! }
//! ```
//!
//! It does not support floats, textures, transparency, or blobs on big-endian machines.
#![no_std]
#![cfg_attr(not(feature = "asm"), forbid(unsafe_code))]
#![deny(unsafe_code)]
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
pub mod lighting;
pub mod mode;
pub mod normal;
pub mod q;
pub mod quantise;
pub mod reciprocal;
pub mod render;
pub mod scene;
pub mod shading;
mod unlit;
