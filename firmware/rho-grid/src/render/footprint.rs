//! Which pixels a sample colours, from the bounds of its cell.

pub use super::project::Bounds;
use super::visibility::Rect;

/// Columns and rows of the frame, first and last; empty when a last is below its first. They may
/// lie beyond the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pixels {
    /// First and last column.
    pub x: (i32, i32),
    /// First and last row.
    pub y: (i32, i32),
}

impl Pixels {
    /// The same of pixels known to lie within the frame; `None` when there are none.
    #[inline(always)]
    pub(super) fn rect(self) -> Option<Rect> {
        let ((x0, x1), (y0, y1)) = (self.x, self.y);
        (x0 <= x1 && y0 <= y1).then_some(Rect {
            x0: x0 as u32,
            x1: x1 as u32,
            y0: y0 as u32,
            y1: y1 as u32,
        })
    }
}

/// A rule that chooses pixels.
///
/// Cells of the same extent are asked about together: what follows from the extent alone is in
/// the rule's own type, made once.
pub trait Footprint: Copy {
    /// Whether samples are drawn as discs where the projection allows it; what follows then serves
    /// the cells where it does not.
    const DISCS: bool = false;

    /// For cells of this half extent along x and y, Q8, whose centres are given with `Q` bits
    /// after the point: 8 or 16.
    fn of<const Q: u32>(half_x: i32, half_y: i32) -> Self;

    /// The pixels that a cell colours when it is drawn from its sample; x and y are its centre,
    /// with as many bits after the point.
    fn cover<const Q: u32>(self, x: i32, y: i32) -> Pixels;

    /// Pixels of which a sample in or below a cell of these bounds may colour none other, but for
    /// those to which no point of the cell is projected: boxes in a block are widened by what
    /// their steps may be off. `overhang` is how far a disc of the coarsest level drawn below may
    /// reach beyond the cell, in 256ths of the cell's half extent.
    fn reach(bounds: Bounds, overhang: i32) -> Pixels;
}

/// The pixel in which the sample's centre lies.
#[derive(Clone, Copy, Debug)]
pub struct Point;

impl Footprint for Point {
    #[inline(always)]
    fn of<const Q: u32>(_: i32, _: i32) -> Self {
        Self
    }

    #[inline(always)]
    fn cover<const Q: u32>(self, x: i32, y: i32) -> Pixels {
        let (x, y) = (x >> Q, y >> Q);
        Pixels {
            x: (x, x),
            y: (y, y),
        }
    }

    #[inline(always)]
    fn reach(b: Bounds, _: i32) -> Pixels {
        Pixels {
            x: ((b.x - b.half_x) >> 8, (b.x + b.half_x) >> 8),
            y: ((b.y - b.half_y) >> 8, (b.y + b.half_y) >> 8),
        }
    }
}

/// A square round the centre, as large as the cell's larger extent in whole pixels.
#[derive(Clone, Copy, Debug)]
pub struct Splat {
    /// Pixels.
    side: i32,
}

impl Footprint for Splat {
    #[inline(always)]
    fn of<const Q: u32>(half_x: i32, half_y: i32) -> Self {
        Self {
            side: (half_x.max(half_y) + 127) >> 7,
        }
    }

    #[inline(always)]
    fn cover<const Q: u32>(self, x: i32, y: i32) -> Pixels {
        let first = |centre: i32| (centre + ((1 - self.side) << (Q - 1))) >> Q;
        let (x, y) = (first(x), first(y));
        Pixels {
            x: (x, x + self.side - 1),
            y: (y, y + self.side - 1),
        }
    }

    #[inline(always)]
    fn reach(b: Bounds, _: i32) -> Pixels {
        // A splat within passes its cell by less than a pixel, and is a square: as wide as high.
        let half = b.half_x.max(b.half_y);
        Pixels {
            x: (((b.x - half) >> 8) - 1, ((b.x + half) >> 8) + 1),
            y: (((b.y - half) >> 8) - 1, ((b.y + half) >> 8) + 1),
        }
    }
}

/// Every pixel whose centre the bounds hold.
///
/// A ray through a pixel's centre that meets the surface passes through a leaf, whose bounds hold
/// that centre: no holes, whatever the level drawn.
#[derive(Clone, Copy, Debug)]
pub struct PixelCentre {
    /// Added to the centre: to the first and the last pixel centre, before rounding down.
    x: (i32, i32),
    y: (i32, i32),
}

impl Footprint for PixelCentre {
    #[inline(always)]
    fn of<const Q: u32>(half_x: i32, half_y: i32) -> Self {
        let ends = |half: i32| ((127 - half) << (Q - 8), (half - 128) << (Q - 8));
        Self {
            x: ends(half_x),
            y: ends(half_y),
        }
    }

    #[inline(always)]
    fn cover<const Q: u32>(self, x: i32, y: i32) -> Pixels {
        Pixels {
            x: ((x + self.x.0) >> Q, (x + self.x.1) >> Q),
            y: ((y + self.y.0) >> Q, (y + self.y.1) >> Q),
        }
    }

    #[inline(always)]
    fn reach(b: Bounds, _: i32) -> Pixels {
        // The bounds of subcells are wider than exact by their slack; so are these, and by more.
        let wider = |half: i32| half + (half >> 6) + 8;
        Self::of::<8>(wider(b.half_x), wider(b.half_y)).cover::<8>(b.x, b.y)
    }
}

/// A disc in the sample's tangent plane, moved along its normal by its offset: every pixel whose
/// centre it holds.
///
/// Cells which are too near or too large for that are drawn as [`PixelCentre`] has them.
#[derive(Clone, Copy, Debug)]
pub struct Disc(PixelCentre);

impl Footprint for Disc {
    const DISCS: bool = true;

    #[inline(always)]
    fn of<const Q: u32>(half_x: i32, half_y: i32) -> Self {
        Self(PixelCentre::of::<Q>(half_x, half_y))
    }

    #[inline(always)]
    fn cover<const Q: u32>(self, x: i32, y: i32) -> Pixels {
        self.0.cover::<Q>(x, y)
    }

    #[inline(always)]
    fn reach(b: Bounds, overhang: i32) -> Pixels {
        // Near the eye a half extent has up to 28 bits.
        let over = |half: i32| (i64::from(half) * i64::from(overhang)) >> 8;
        let wider = |half: i32| half + over(half) as i32 + 8;
        PixelCentre::of::<8>(wider(b.half_x), wider(b.half_y)).cover::<8>(b.x, b.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn along_x<F: Footprint>(x: i32, half: i32) -> (i32, i32) {
        F::of::<8>(half, half).cover::<8>(x, x).x
    }

    #[test]
    fn pixel_centres_on_the_edge_of_the_bounds_belong_to_them() {
        // From 0.5 to 2.5 pixels: the centres of pixels 0, 1 and 2.
        assert_eq!(along_x::<PixelCentre>(384, 256), (0, 2));
        // A step less on each side: only pixel 1.
        assert_eq!(along_x::<PixelCentre>(384, 255), (1, 1));
        // Between two centres: none.
        assert_eq!(along_x::<PixelCentre>(256, 100), (1, 0));
    }

    #[test]
    fn a_splat_is_centred_and_as_large_as_the_cell() {
        assert_eq!(along_x::<Splat>(128, 100), (0, 0));
        assert_eq!(along_x::<Splat>(256, 129), (0, 1));
        assert_eq!(along_x::<Splat>(-128, 300), (-2, 0));
    }

    #[test]
    fn a_point_is_one_pixel_left_of_the_edge_too() {
        assert_eq!(along_x::<Point>(-1, 500), (-1, -1));
    }
}
