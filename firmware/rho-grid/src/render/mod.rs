//! Drawing a grid: set-up, order, projection, footprint, visibility.
//!
//! ```text
//! Camera, Grid -> View (tables, once a frame) -> draw: cells from front to back or in any order
//!   -> bounds on the screen -> culled? hidden? small enough or leaf? -> footprint -> visibility
//! ```
//!
//! What varies is a type: a [`Visibility`], a [`Footprint`], a
//! [`Reciprocal`](crate::reciprocal::Reciprocal). [`draw`] is compiled for each combination that a
//! board uses; [`draw_mode`] has them all and is for boards and hosts that choose at run time.

mod disc;
mod eye_order;
pub mod footprint;
mod order;
mod project;
mod quarters;
pub mod shadow;
mod stamp;
mod tones;
mod traverse;
mod view;
mod visibility;
mod z_buffer;

pub use crate::camera::ViewError;
pub use eye_order::EyeOrder;
pub use quarters::{Blend, bands, quarter_words};
pub use shadow::ShadowView;
pub use tones::{Tones, tone_words};
pub use traverse::draw;
pub use view::View;
pub use visibility::{Canvas, Rect, Shape, Span, Stamp, Visibility};
pub use z_buffer::ZBuffer;

use crate::blob::Grid;
use crate::frame::Frame;
use crate::mode::{FootprintMode, Mode, ReciprocalMode, VisibilityMode};
use crate::reciprocal::{Divide, Table};
use crate::shading::Shade;
use footprint::{Disc, Footprint, PixelCentre, Point, Splat};

/// What a visibility method remembers about each pixel; a board has what its modes need.
#[derive(Debug, Default)]
pub struct Buffers<'a> {
    /// For eye order: [`EyeOrder::words`] words.
    pub coverage: &'a mut [u32],
    /// For the z-buffer: one a pixel.
    pub depth: &'a mut [u16],
}

impl Buffers<'_> {
    /// Forgets what was drawn, as far as `mode` looks at it.
    pub fn clear(&mut self, mode: Mode) {
        match mode.visibility {
            VisibilityMode::Eye => self.coverage.fill(0),
            VisibilityMode::Z => self.depth.fill(u16::MAX),
        }
    }
}

/// A buffer is too small for the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferTooSmall;

/// Draws the grid over the frame, behind what `buffers` remember as nearer.
///
/// # Errors
/// [`BufferTooSmall`] when `buffers` lack what the mode needs for the frame's size.
pub fn draw_mode(
    mode: Mode,
    grid: &Grid<'_>,
    view: &View,
    shading: &impl Shade,
    frame: &mut Frame<'_>,
    buffers: &mut Buffers<'_>,
) -> Result<(), BufferTooSmall> {
    match mode.visibility {
        VisibilityMode::Eye => {
            let mut target = EyeOrder::new(frame, buffers.coverage).ok_or(BufferTooSmall)?;
            let _ = draw_seen(mode, grid, view, shading, &mut target);
        }
        VisibilityMode::Z => {
            let target = ZBuffer::<_, false>::new(frame, buffers.depth);
            let mut target = target.ok_or(BufferTooSmall)?;
            let _ = draw_seen(mode, grid, view, shading, &mut target);
        }
    }
    Ok(())
}

/// As [`draw_mode`], for any [`Visibility`] of the caller's. Returns the pixels that the cube may
/// reach; `None` when that is none.
pub fn draw_seen<V: Visibility>(
    mode: Mode,
    grid: &Grid<'_>,
    view: &View,
    shading: &impl Shade,
    target: &mut V,
) -> Option<Rect> {
    match mode.footprint {
        FootprintMode::Point => draw_shaped::<V, Point>(mode, grid, view, shading, target),
        FootprintMode::Splat => draw_shaped::<V, Splat>(mode, grid, view, shading, target),
        FootprintMode::Box => draw_shaped::<V, PixelCentre>(mode, grid, view, shading, target),
        FootprintMode::Disc => draw_shaped::<V, Disc>(mode, grid, view, shading, target),
    }
}

/// As [`draw_seen`], dividing: each way to draw is code of its own, and frames that no table of
/// reciprocals is measured with need not have it twice.
pub fn draw_divided<V: Visibility>(
    footprint: FootprintMode,
    grid: &Grid<'_>,
    view: &View,
    shading: &impl Shade,
    target: &mut V,
) -> Option<Rect> {
    match footprint {
        FootprintMode::Point => draw::<V, Point, Divide>(grid, view, shading, target),
        FootprintMode::Splat => draw::<V, Splat, Divide>(grid, view, shading, target),
        FootprintMode::Box => draw::<V, PixelCentre, Divide>(grid, view, shading, target),
        FootprintMode::Disc => draw::<V, Disc, Divide>(grid, view, shading, target),
    }
}

fn draw_shaped<V: Visibility, F: Footprint>(
    mode: Mode,
    grid: &Grid<'_>,
    view: &View,
    shading: &impl Shade,
    target: &mut V,
) -> Option<Rect> {
    match mode.reciprocal {
        ReciprocalMode::Divide => draw::<V, F, Divide>(grid, view, shading, target),
        ReciprocalMode::Table => draw::<V, F, Table>(grid, view, shading, target),
    }
}
