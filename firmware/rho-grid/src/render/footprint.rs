//! Which pixels a sample colours, from the bounds of its cell.

pub use super::project::Bounds;

/// Columns and rows of the frame, first and last; empty when a last is below its first. They may
/// lie beyond the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pixels {
    /// First and last column.
    pub x: (i32, i32),
    /// First and last row.
    pub y: (i32, i32),
}

/// A rule that chooses pixels.
pub trait Footprint {
    /// The pixels that a cell of these bounds colours when it is drawn from its sample.
    fn cover(bounds: Bounds) -> Pixels;

    /// Pixels of which a sample in or below a cell of these bounds may colour none other.
    fn reach(bounds: Bounds) -> Pixels;
}

/// The pixel in which the sample's centre lies.
#[derive(Clone, Copy, Debug)]
pub struct Point;

/// A square round the centre, as large as the cell's larger extent in whole pixels.
#[derive(Clone, Copy, Debug)]
pub struct Splat;

/// Every pixel whose centre the bounds hold.
///
/// A ray through a pixel's centre that meets the surface passes through a leaf, whose bounds hold
/// that centre: no holes, whatever the level drawn.
#[derive(Clone, Copy, Debug)]
pub struct PixelCentre;

impl Footprint for Point {
    #[inline(always)]
    fn cover(b: Bounds) -> Pixels {
        let (x, y) = (b.x >> 8, b.y >> 8);
        Pixels {
            x: (x, x),
            y: (y, y),
        }
    }

    #[inline(always)]
    fn reach(b: Bounds) -> Pixels {
        Pixels {
            x: ((b.x - b.half_x) >> 8, (b.x + b.half_x) >> 8),
            y: ((b.y - b.half_y) >> 8, (b.y + b.half_y) >> 8),
        }
    }
}

impl Footprint for Splat {
    #[inline(always)]
    fn cover(b: Bounds) -> Pixels {
        // Side in pixels, rounded up.
        let side = (b.half_x.max(b.half_y) + 127) >> 7;
        let first = |centre: i32| (centre - (side << 7) + 128) >> 8;
        let (x, y) = (first(b.x), first(b.y));
        Pixels {
            x: (x, x + side - 1),
            y: (y, y + side - 1),
        }
    }

    #[inline(always)]
    fn reach(b: Bounds) -> Pixels {
        // A splat within passes its cell by less than a pixel, and is a square: as wide as high.
        let half = b.half_x.max(b.half_y);
        Pixels {
            x: (((b.x - half) >> 8) - 1, ((b.x + half) >> 8) + 1),
            y: (((b.y - half) >> 8) - 1, ((b.y + half) >> 8) + 1),
        }
    }
}

impl PixelCentre {
    #[inline(always)]
    fn along(centre: i32, half: i32) -> (i32, i32) {
        ((centre - half + 127) >> 8, (centre + half - 128) >> 8)
    }
}

impl Footprint for PixelCentre {
    #[inline(always)]
    fn cover(b: Bounds) -> Pixels {
        Pixels {
            x: Self::along(b.x, b.half_x),
            y: Self::along(b.y, b.half_y),
        }
    }

    #[inline(always)]
    fn reach(b: Bounds) -> Pixels {
        // The bounds of subcells are wider than exact by their slack; so are these, and by more.
        let wider = |half: i32| half + (half >> 6) + 8;
        Pixels {
            x: Self::along(b.x, wider(b.half_x)),
            y: Self::along(b.y, wider(b.half_y)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds(x: i32, half: i32) -> Bounds {
        Bounds {
            x,
            y: x,
            half_x: half,
            half_y: half,
        }
    }

    #[test]
    fn pixel_centres_on_the_edge_of_the_bounds_belong_to_them() {
        // From 0.5 to 2.5 pixels: the centres of pixels 0, 1 and 2.
        assert_eq!(PixelCentre::cover(bounds(384, 256)).x, (0, 2));
        // A step less on each side: only pixel 1.
        assert_eq!(PixelCentre::cover(bounds(384, 255)).x, (1, 1));
        // Between two centres: none.
        assert_eq!(PixelCentre::cover(bounds(256, 100)).x, (1, 0));
    }

    #[test]
    fn a_splat_is_centred_and_as_large_as_the_cell() {
        assert_eq!(Splat::cover(bounds(128, 100)).x, (0, 0));
        assert_eq!(Splat::cover(bounds(256, 129)).x, (0, 1));
        assert_eq!(Splat::cover(bounds(-128, 300)).x, (-2, 0));
    }

    #[test]
    fn a_point_is_one_pixel_left_of_the_axis_too() {
        assert_eq!(Point::cover(bounds(-1, 500)).x, (-1, -1));
    }
}
