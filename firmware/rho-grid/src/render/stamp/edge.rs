//! Which pixels of a stamp lie in the frame, from tables.
//!
//! A window of 4 x 4 pixels that sticks out of the frame loses columns on one side and rows on one:
//! both are looked up by where it begins. Blocks are smaller than half a frame, so of each axis only
//! one edge matters.

use super::REACH;
use super::entry;

/// Where windows of a block may begin, of each axis: so many pixels from its corner on, and its tiles four more.
const PLACES: usize = 2 * REACH as usize + 4;

/// Of a window's 16 pixels, those that lie in the frame along one axis.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Within {
    /// When the axis is x.
    columns: u16,
    /// When it is y.
    rows: u16,
}

impl Within {
    /// The pixels of `nibble` along the axis.
    const fn new(nibble: u16) -> Self {
        let [a, b, c, d] = [nibble & 1, nibble >> 1 & 1, nibble >> 2 & 1, nibble >> 3];
        Self {
            columns: nibble * 0x1111,
            rows: (a | b << 4 | c << 8 | d << 12) * 15,
        }
    }
}

/// By where a window begins, from `PLACES` pixels before the frame's first pixel on.
#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
static FIRST: [Within; 2 * PLACES] = {
    let mut within = [Within::new(0); 2 * PLACES];
    let mut at = PLACES - 3;
    while at < 2 * PLACES {
        let out = PLACES.saturating_sub(at);
        within[at] = Within::new(15 << out & 15);
        at += 1;
    }
    within
};

/// By where a window begins, from `PLACES + 3` pixels before the last of those that show on.
#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, where an index out of range is an error"
)]
static LAST: [Within; 2 * PLACES + 3] = {
    let mut within = [Within::new(0); 2 * PLACES + 3];
    let mut at = 0;
    while at < PLACES + 3 {
        let out = (at + 1).saturating_sub(PLACES);
        within[at] = Within::new(15 >> out);
        at += 1;
    }
    within
};

/// The frame's edges near a block.
#[derive(Clone, Copy)]
pub(super) struct Edges {
    /// By the window's first column, from the block's corner.
    pub(super) columns: &'static [Within; PLACES],
    /// By its first row.
    pub(super) rows: &'static [Within; PLACES],
}

impl Edges {
    /// Of a frame of this size, each at least 72, for windows that count from this pixel; `None` when
    /// no window shows.
    pub(super) fn new(corner: (i32, i32), size: (i32, i32)) -> Option<Self> {
        let along = |corner: i32, side: i32| {
            let first_of_last = side - (PLACES as i32 + 3);
            let from = if corner <= first_of_last {
                let before = corner.min(0) + PLACES as i32;
                FIRST.get(usize::try_from(before).ok()?..)
            } else {
                LAST.get(usize::try_from(corner - first_of_last).ok()?..)
            };
            from?.first_chunk()
        };
        Some(Self {
            columns: along(corner.0, size.0)?,
            rows: along(corner.1, size.1)?,
        })
    }

    /// The pixels in the frame of the window that begins here.
    #[inline(always)]
    pub(super) fn within(&self, x: u32, y: u32) -> u32 {
        u32::from(entry(self.columns, x).columns & entry(self.rows, y).rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_window_keeps_the_pixels_that_lie_in_the_frame(
            width in 72..500i32, height in 72..500i32,
            corner in (-64..500i32, -64..500i32), place in (0..68u32, 0..68u32)
        ) {
            prop_assume!(corner.0 < width && corner.1 < height);
            let edges = Edges::new(corner, (width, height)).unwrap();
            let mut expected = 0;
            for bit in 0..16 {
                let x = corner.0 + place.0 as i32 + bit % 4;
                let y = corner.1 + place.1 as i32 + bit / 4;
                if (0..width).contains(&x) && (0..height).contains(&y) {
                    expected |= 1 << bit;
                }
            }
            prop_assert_eq!(edges.within(place.0, place.1), expected);
        }
    }
}
