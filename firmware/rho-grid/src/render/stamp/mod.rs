//! Small discs, stamped block by block.
//!
//! Where discs are at most [`mask::LARGEST`] large and a block of cells far enough from the eye and
//! inside the frame, its samples need neither clipping nor arithmetic by pixel: a mask of 4 x 4
//! pixels from tables ([`mask`]), laid where the sample is. What is left to compute a sample is one
//! packed sum for its place, one product for its offset and one for the angle at which it is seen:
//!
//! ```text
//! frame   the normals turned into eye space, by class                     classes
//! block   line of sight, radius, offsets, steps from cell to cell         Stamps::new
//! parent  projected exactly                                               by the walk
//! sample  place = parent's + step + across(class) * offset                Stamps::plane
//!         c = towards(class) - line of sight . across(class)
//!         mask = circle(place) within c radii along the normal
//! ```
//!
//! Places are packed, x + 65536 y, in 512ths of a pixel from a corner near the block: sums and
//! products of one word serve both. Half a class, half a place: the errors are a sixteenth of a
//! pixel and a fortieth of the cosine; tests hold the masks to the exact disc
//! ([`super::disc`]).
//!
//! A sample that faces away is drawn only where the pixel in its middle is open. On a closed surface
//! it never is, but for the order within a parent; on an open one its back shows.

mod classes;
mod lists;
mod mask;

pub(super) use classes::Classes;

use super::view::{Step, Steps, View};
use super::visibility::Visibility;
use crate::blob::Layout;
use classes::FINER;
use lists::Order;
use mask::{Circle, Four, Round, Three, Two};

/// The entry of a table at `index`, taken modulo its length.
#[inline(always)]
#[allow(
    clippy::indexing_slicing,
    reason = "the index is reduced to the table's length"
)]
fn entry<T: Copy, const N: usize>(table: &[T; N], index: u32) -> T {
    table[index as usize % N]
}

/// A disc's radius in sides of its cell, times 256.
const RADIUS: i32 = 230;

/// What the samples of a block have in common.
pub(super) struct Stamps<'v> {
    classes: &'v Classes,
    /// Minus the tangents of the line of sight, 512 to the unit, y and x (the upper half).
    sight: u32,
    circle: Circle,
    /// The strip's half width for a cosine of 2^30, times 2^36 / 2^30 sixteenths of a pixel.
    breadth: u32,
    /// By offset step: sixteenths of a pixel.
    offsets: [i8; 8],
    /// From the first cell of a plane of 3 x 3 to each.
    cells: [u32; 16],
    /// From a plane to the next.
    along_z: u32,
    /// The pixel from which places count.
    corner: (i32, i32),
}

/// A cell whose subcells are stamped.
pub(super) struct Parent<'g> {
    /// Its centre, Q8 from the frame's corner.
    pub(super) x: i32,
    /// The same along y.
    pub(super) y: i32,
    /// Its distance along the optical axis, as [`Visibility::stamp`] takes it.
    pub(super) w: i32,
    /// Its subcells, 27 bits.
    pub(super) mask: u32,
    /// Attribute words, its first subcell's first.
    pub(super) words: &'g [u16],
    /// Along x, y, z: whether subcells are seen from the higher side.
    pub(super) descending: [bool; 3],
}

/// Half the window of packed places, in pixels.
const REACH: i32 = 64;

impl<'v> Stamps<'v> {
    /// For a block whose centre is projected to (x, y) (Q8 from the axis) with half extents `own`
    /// (Q8), and whose cells have a side of `side` (Q16) there; `None` when its discs cannot be
    /// stamped: too large, seen too far from the axis, or of another layout.
    #[inline(always)]
    pub(super) fn new(
        view: &'v View,
        layout: Layout,
        steps: &Steps,
        [x, y]: [i32; 2],
        own: i32,
        side: i32,
    ) -> Option<Self> {
        if layout != Layout::OFFSET_THIN && layout != Layout::OFFSET {
            return None;
        }
        if own > (REACH - 8) << 8 || side >= 1 << 19 {
            return None;
        }
        let (tx, ty) = (view.tangent(x), view.tangent(y));
        let square = tx * tx + ty * ty;
        if square > 1 << 17 {
            return None;
        }
        // 1 / sqrt(1 + t^2) by its series, 256 to the unit; t^2 is at most a half.
        let t2 = square >> 10;
        let length = 256 - (t2 >> 1) + ((3 * t2 * t2) >> 11) - ((5 * t2 * t2 * t2) >> 20);
        let radius = (side * (RADIUS >> 1)) >> 15;
        let circle = Circle::of(radius as u32)?;
        // 64ths of a pixel.
        let breadth = ((radius * length) >> 10) as u32;

        // Sixteenths of a pixel, rounded; below 4 pixels, so below 64.
        let unit = (side >> 4) * i32::from(layout.offset_range);
        let mut offset = (-7 * (unit >> 7)) >> 3;
        let step = (unit >> 7) >> 2;
        let offsets = core::array::from_fn(|_| {
            let here = (offset + (1 << 7)) >> 8;
            offset += step;
            here as i8
        });
        let packed = |s: &Step| ((s.x >> 7) as u32).wrapping_add(((s.y >> 7) as u32) << 16);
        let [sx, sy, sz] = &steps.steps;
        let (sx, sy, along_z) = (packed(sx), packed(sy), packed(sz));
        let mut cells = [0; 16];
        let mut row = 0u32.wrapping_sub(sx).wrapping_sub(sy);
        for cells in cells.chunks_exact_mut(3) {
            if let [a, b, c] = cells {
                (*a, *b, *c) = (
                    row,
                    row.wrapping_add(sx),
                    row.wrapping_add(sx).wrapping_add(sx),
                );
            }
            row = row.wrapping_add(sy);
        }
        let (mx, my) = (view.width << 7, view.height << 7);
        let corner = |v: i32| (v >> 8) - REACH;
        Some(Self {
            classes: &view.classes,
            sight: (-ty as u32).wrapping_add((-tx as u32) << 16),
            circle,
            breadth,
            offsets,
            cells,
            along_z,
            corner: (corner(x + mx), corner(y + my)),
        })
    }

    /// How far a disc reaches beyond its cell's bounds at most, Q8.
    pub(super) fn overhang(side: i32) -> i32 {
        // 0.9 sides less the half that is within, and the offset: at most 0.87 sides.
        ((side * 5) >> 10) + 1
    }

    /// Stamps all subcells of a parent divided by 3.
    #[inline(always)]
    pub(super) fn stamp<V: Visibility>(
        &self,
        target: &mut V,
        parent: &Parent<'_>,
        colour: impl Fn(u32) -> u16 + Copy,
    ) {
        match self.circle {
            Circle::Two(c) => self.planes(target, parent, Two(c), colour),
            Circle::Three(c) => self.planes(target, parent, Three(c), colour),
            Circle::Four(c) => self.planes(target, parent, Four(c), colour),
        }
    }

    #[inline(never)]
    fn planes<V: Visibility, C: Round>(
        &self,
        target: &mut V,
        parent: &Parent<'_>,
        circle: C,
        colour: impl Fn(u32) -> u16 + Copy,
    ) {
        // From the parent's centre to the middle of the window's first pixel, plus half a pixel so
        // that what is left over after whole pixels are taken is the window's part.
        let bias = 256 * (C::ROWS as i32 - 1);
        let place = |v: i32, corner: i32| ((v << 1) - (corner << 9) - bias) as u32;
        let (x, y) = self.corner;
        let middle = place(parent.x, x).wrapping_add(place(parent.y, y) << 16);
        let [dx, dy, dz] = parent.descending;
        let order = Order::new([dx, dy]);
        let low = parent.mask & 511;
        let mid = parent.mask >> 9 & 511;
        let high = parent.mask >> 18 & 511;
        let words = parent.words;
        let after_low = words.get(low.count_ones() as usize..).unwrap_or_default();
        let after_mid = after_low
            .get(mid.count_ones() as usize..)
            .unwrap_or_default();
        let below = middle.wrapping_sub(self.along_z);
        let above = middle.wrapping_add(self.along_z);
        let planes = [
            (low, words, below),
            (mid, after_low, middle),
            (high, after_mid, above),
        ];
        let mut plane = |(bits, words, at): (u32, &[u16], u32)| {
            let cells = order.cells(bits);
            if order.backwards {
                self.cells(target, parent.w, circle, words, at, cells.iter().rev(), colour);
            } else {
                self.cells(target, parent.w, circle, words, at, cells.iter(), colour);
            }
        };
        let [low, mid, high] = planes;
        let (first, last) = if dz { (high, low) } else { (low, high) };
        plane(first);
        plane(mid);
        plane(last);
    }

    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "the inner loop")]
    fn cells<'l, V: Visibility, C: Round>(
        &self,
        target: &mut V,
        w: i32,
        circle: C,
        words: &[u16],
        at: u32,
        cells: impl Iterator<Item = &'l u8>,
        colour: impl Fn(u32) -> u16,
    ) {
        for cell in cells {
            let cell = u32::from(*cell);
            let Some(word) = words.get(cell as usize >> 4) else {
                continue;
            };
            let word = u32::from(*word);
            let class = self.classes.of(word >> 3);
            let offset = i32::from(entry(&self.offsets, word));
            let place = at
                .wrapping_add(entry(&self.cells, cell))
                .wrapping_add(class.across.wrapping_mul(offset as u32));
            let x = self.corner.0 + (place >> 9 & 127) as i32;
            let y = self.corner.1 + (place >> 25) as i32;
            // The cosine, 2^30 to the unit.
            let towards = class
                .towards
                .wrapping_add(class.across.wrapping_mul(self.sight)) as i32;
            let middle = C::ROWS as i32 / 2;
            if towards < 0 && !target.is_open((x + middle) as u32, (y + middle) as u32) {
                continue;
            }
            let cosine = u64::from(towards.unsigned_abs());
            let half = ((cosine * u64::from(self.breadth)) >> 32) as u32;
            let parts = place & 0x01FF_01FF;
            let mask = mask::disc(circle, parts, class.towards, half);
            C::stamp(target, (x, y), mask, w, || colour(word));
        }
    }
}

const _: () = assert!(FINER == 4);
