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
//! Places are packed, x + 65536 y, in 1024ths of a pixel from a corner near the block: sums and
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
pub(super) use lists::Order;

use super::view::{Step, View};
use super::visibility::{Stamp, Visibility};
use crate::blob::Layout;
use crate::shading::Shade;
use classes::FINER;
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
    /// Minus the tangents of the line of sight, 512 to the unit, y and x (the upper half).
    sight: u32,
    /// The strip's half width in sixteenths of a pixel for a cosine of 1, times 4.
    breadth: u32,
    /// From a plane of cells to the next.
    along_z: u32,
    /// By offset step: 32nds of a pixel.
    offsets: [i8; 8],
    /// From the middle of a plane of 3 x 3 cells to each.
    cells: [u32; 16],
    classes: &'v Classes,
    circle: Circle,
    /// The pixel from which places count.
    corner: (i32, i32),
}

/// The cells of a block: parents divided by 3, projected one by one.
pub(super) trait Parents {
    /// Calls `stamp` with each from front to back.
    fn each(&self, stamp: impl FnMut(&Parent<'_>));
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
    /// Attribute words of all cells of its subcells' level.
    pub(super) words: &'g [u16],
    /// The first of its own.
    pub(super) first: usize,
    /// Along x, y, z: whether subcells are seen from the higher side.
    pub(super) descending: [bool; 3],
}

/// Half the window of packed places, in pixels.
const REACH: i32 = 32;

impl<'v> Stamps<'v> {
    /// For a block whose centre is projected to (x, y) (Q8 from the axis) with half extents `own`
    /// (Q8), and whose cells have a side of `side` and are `steps` apart (Q16); `None` when its
    /// discs cannot be stamped: too large, seen too far from the axis, or of another layout.
    #[inline(always)]
    pub(super) fn new(
        view: &'v View,
        layout: Layout,
        steps: &[Step; 3],
        [x, y]: [i32; 2],
        own: i32,
        side: i32,
    ) -> Option<Self> {
        if layout != Layout::OFFSET_THIN && layout != Layout::OFFSET {
            return None;
        }
        // A side of 2.6 pixels has discs of 0.8 sides then: still no holes.
        if own > (REACH - 4) << 8 || side > 170_000 {
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
        let circle = Circle::of((radius as u32).min(mask::LARGEST))?;
        // 64ths of a pixel.
        let breadth = ((radius * length) >> 10) as u32;

        // 32nds of a pixel, rounded; below 2.6 pixels, so below 84.
        let unit = ((side >> 4) * i32::from(layout.offset_range)) >> 7;
        let first = (1 << 6) - ((7 * unit) >> 3);
        let offsets =
            core::array::from_fn(|step| ((first + ((unit * step as i32) >> 2)) >> 7) as i8);

        let packed = |s: &Step| ((s.x >> 6) as u32).wrapping_add(((s.y >> 6) as u32) << 16);
        let [sx, sy, sz] = steps;
        let (sx, sy, along_z) = (packed(sx), packed(sy), packed(sz));
        let row = |middle: u32| [middle.wrapping_sub(sx), middle, middle.wrapping_add(sx)];
        let ([a, b, c], [d, e, f], [g, h, i]) = (row(0u32.wrapping_sub(sy)), row(0), row(sy));
        let (mx, my) = (view.width << 7, view.height << 7);
        let corner = |v: i32| (v >> 8) - REACH;
        Some(Self {
            classes: &view.classes,
            sight: (-ty as u32).wrapping_add((-tx as u32) << 16),
            circle,
            breadth,
            offsets,
            cells: [a, b, c, d, e, f, g, h, i, 0, 0, 0, 0, 0, 0, 0],
            along_z,
            corner: (corner(x + mx), corner(y + my)),
        })
    }

    /// How far a disc reaches beyond its cell's bounds at most, Q8.
    pub(super) fn overhang(side: i32) -> i32 {
        // 0.9 sides less the half that is within, and the offset: at most 0.87 sides.
        ((side * 5) >> 10) + 1
    }

    /// Stamps all subcells of a block's parents.
    #[inline(always)]
    pub(super) fn stamp<V: Visibility>(
        &self,
        target: &mut V,
        parents: &impl Parents,
        shading: &impl Shade,
    ) {
        match self.circle {
            Circle::Two(c) => self.block(target, parents, Two(c), shading),
            Circle::Three(c) => self.block(target, parents, Three(c), shading),
            Circle::Four(c) => self.block(target, parents, Four(c), shading),
        }
    }

    #[inline(never)]
    fn block<V: Visibility, C: Round>(
        &self,
        target: &mut V,
        parents: &impl Parents,
        circle: C,
        shading: &impl Shade,
    ) {
        let (x, y) = self.corner;
        let corner = target.corner(x, y);
        // From a centre to the middle of its window's first pixel, plus half a pixel, so that
        // what is left over after whole pixels are taken is the window's part.
        let bias = 512 * (C::ROWS as i32 - 1);
        let (x, y) = ((x << 10) + bias, (y << 10) + bias);
        let mut tail = [0; 16];
        parents.each(|parent| {
            let [dx, dy, dz] = parent.descending;
            let order = Order::new([dx, dy]);
            let middle =
                ((4 * parent.x - x) as u32).wrapping_add(((4 * parent.y - y) as u32) << 16);
            let mask = parent.mask;
            let low = order.cells(mask);
            let mid = order.cells(mask >> 9);
            let high = order.cells(mask >> 18);
            let mut plane = |(cells, count): (&[u8; 9], usize), at: u32, first: usize| {
                if count == 0 {
                    return;
                }
                let words = parent.words.get(first..).unwrap_or_default();
                let words: &[u16; 16] = match words.first_chunk() {
                    Some(words) => words,
                    None => {
                        // The last words of the grid.
                        for (tail, word) in tail.iter_mut().zip(words) {
                            *tail = *word;
                        }
                        &tail
                    }
                };
                let samples = Samples {
                    words,
                    at,
                    w: parent.w,
                    corner,
                };
                let cells = cells.iter().take(count);
                if order.backwards {
                    self.samples(target, &samples, cells.rev(), circle, shading);
                } else {
                    self.samples(target, &samples, cells, circle, shading);
                }
            };
            let first = parent.first;
            let firsts = [first, first + low.1, first + low.1 + mid.1];
            let below = middle.wrapping_sub(self.along_z);
            let above = middle.wrapping_add(self.along_z);
            let planes = [
                (low, below, firsts[0]),
                (mid, middle, firsts[1]),
                (high, above, firsts[2]),
            ];
            let [a, b, c] = planes;
            let (a, c) = if dz { (c, a) } else { (a, c) };
            for (cells, at, first) in [a, b, c] {
                plane(cells, at, first);
            }
        });
    }

    #[inline(always)]
    fn samples<'l, V: Visibility, C: Round>(
        &self,
        target: &mut V,
        samples: &Samples<'_>,
        cells: impl Iterator<Item = &'l u8>,
        circle: C,
        shading: &impl Shade,
    ) {
        for cell in cells {
            let cell = u32::from(*cell);
            let word = u32::from(entry(samples.words, cell >> 4));
            let class = self.classes.of(word >> 3);
            let offset = i32::from(entry(&self.offsets, word));
            let place = samples
                .at
                .wrapping_add(entry(&self.cells, cell))
                .wrapping_add(class.across.wrapping_mul(offset as u32));
            // The cosine, 2^30 to the unit.
            let towards = class
                .towards
                .wrapping_add(class.across.wrapping_mul(self.sight))
                as i32;
            let mask = || {
                let cosine = u64::from(towards.unsigned_abs());
                let half = ((cosine * u64::from(self.breadth)) >> 32) as u32;
                mask::disc(circle, place & 0x03FF_03FF, class.towards, half)
            };
            let stamp = Stamp {
                corner: samples.corner,
                x: place >> 10 & 63,
                y: place >> 26,
                away: towards < 0,
                w: samples.w,
            };
            C::stamp(target, stamp, mask, || shading.of_normal(word >> 3));
        }
    }
}

/// The samples of a plane of 3 x 3 cells.
struct Samples<'g> {
    words: &'g [u16; 16],
    /// The place of the middle cell.
    at: u32,
    w: i32,
    corner: u32,
}

const _: () = assert!(FINER == 4);
