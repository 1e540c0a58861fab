//! Small discs, stamped block by block.
//!
//! Where discs are at most [`mask::LARGEST`] large and a block of cells far enough from the eye, its
//! samples need no arithmetic by pixel: a mask of 4 x 4 pixels from tables ([`mask`]), or four of them, laid where the
//! sample is, and cut where that is beyond the frame ([`edge`]). What is left to compute a sample is one
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
//! A sample that faces away is left, and so are at once all samples of a parent that face away, by its
//! cone of normals, unless the blob says that backs show from where the eye is
//! ([`crate::blob::facing`]), or that a cell holds both sides of a sheet. Then, and if it faces away by
//! little, it is drawn where one of the eight pixels in its middle is open.

mod classes;
mod edge;
mod fields;
mod lists;
mod mask;
mod parents;
mod sight;
#[cfg(rho_thumb)]
mod thumb;
#[cfg(rho_thumb)]
pub(super) use thumb::{STRIDE, clear, is_covered, next_to_fill, set_ones};

pub(super) use classes::Classes;
pub(super) use fields::Kind;
pub(super) use parents::{InLight, ParentList, Parents};
pub(super) use sight::Sight;

use super::project::OverW;
use super::view::{Step, View};
use super::visibility::{Stamp, Visibility};
use crate::blob::Layout;
use crate::blob::facing::TWO_SIDED;
use crate::normal::CLASS_SHIFT;
use crate::reciprocal::Reciprocal;
use crate::shading::Shade;
use edge::Edges;
use fields::{Both, Colour, Fields, Offset, Offsets, UNITS};
use lists::{FIRST, Order};
use mask::Circle;

/// The entry of a table at `index`, taken modulo its length.
#[inline(always)]
#[allow(
    clippy::indexing_slicing,
    reason = "the index is reduced to the table's length"
)]
fn entry<T: Copy, const N: usize>(table: &[T; N], index: u32) -> T {
    table[index as usize % N]
}

/// How large discs are stamped, and how thick.
#[derive(Clone, Copy, Debug)]
pub(super) struct DiscCut {
    /// The radius in sides of a cell, times 256: of cells of less than 1.5 pixels, and of others.
    radii: [i32; 2],
    /// The least cosine at which a disc is seen, 2^30 to the unit.
    least_cosine: u32,
}

impl DiscCut {
    /// Of a view that is not yet prepared: zeros, which cost no flash.
    pub(super) const NONE: Self = Self {
        radii: [0; 2],
        least_cosine: 0,
    };

    /// Into pixels. Thin leaves of a plane along a diagonal of two axes stand 1 by the root of 2 apart, so that their
    /// discs meet from 0.866 on; of any other plane they stand closer. Offsets come in eighths, so that neighbouring
    /// discs of a plane that is seen almost from its edge may stand apart by more than they are thick: they are made
    /// as thick as half such a step.
    pub(super) const PIXELS: Self = Self {
        radii: [222; 2],
        least_cosine: 7 << 24,
    };

    /// Into quarters of pixels. What is covered in part is closed when it is blended
    /// ([`Tones::quarters`](super::Tones::quarters)), so discs are as large as looks
    /// best, or, where that makes no difference, as covers most.
    pub(super) const QUARTERS: Self = Self {
        radii: [200, 216],
        least_cosine: 0,
    };
}

/// The largest side of cells whose discs are stamped, Q16, and of those that have a mask of 4 x 4: 4 pixels and 2.9.
const LARGEST_SIDE: i32 = 264_000;
const LARGEST_SIDE_OF_FOUR: i32 = 192_000;

/// Pixels from a window's first to beyond its last.
const fn window(side: i32) -> i32 {
    if side > LARGEST_SIDE_OF_FOUR { 8 } else { 4 }
}

/// What turns away by more than this, a quarter, is left. A sample stands for a part of the surface,
/// not all of which faces as it does.
const FAR_AWAY: i32 = -(1 << 28);

/// What the samples of a block have in common, and those of all blocks of a frame.
pub(super) struct Stamps<'v> {
    sight: Sight,
    /// Whether backs may show, so that what faces away is not left at once.
    backs: bool,
    /// The strip's half width in sixteenths of a pixel for a cosine of 1, times 4.
    breadth: u32,
    cut: DiscCut,
    /// From a plane of cells to the next.
    along_z: u32,
    offsets: Offsets,
    /// [`Fields::OFFSETS`] of the grid's words.
    offsets_by_reach: &'static [Offsets; UNITS],
    /// What an offset may reach, in 128ths of a cell's side.
    offset_range: i32,
    /// From the middle of a plane of 3 x 3 cells to each.
    cells: [u32; 9],
    /// Steps in W along x, y and z.
    depths: [i32; 3],
    classes: &'v Classes,
    circle: Circle,
    /// The pixel from which places count.
    corner: (i32, i32),
    /// The frame's size: twice from its corner to the axis.
    size: (i32, i32),
    /// The frame's edges, if stamps may reach beyond them.
    edges: Option<Edges>,
    #[cfg(rho_thumb)]
    loops: thumb::Loops,
}

/// Half the window of packed places, in pixels.
const REACH: i32 = 32;

impl<'v> Stamps<'v> {
    /// For blocks that `view` shows, of a grid with this layout.
    pub(super) fn new(view: &'v View, layout: Layout) -> Self {
        Self {
            offsets_by_reach: Kind::of(layout).unwrap_or(Kind::Offset).offsets(),
            classes: &view.classes,
            sight: Sight::AHEAD,
            backs: !view.no_backs,
            circle: Circle::LEAST,
            breadth: 0,
            cut: view.cut,
            offsets: [0; 8],
            offset_range: layout.offset_range.into(),
            cells: [0; 9],
            along_z: 0,
            depths: [0; 3],
            corner: (0, 0),
            size: (view.width, view.height),
            edges: None,
            #[cfg(rho_thumb)]
            loops: thumb::Loops::NONE,
        }
    }

    /// Whether the places of a block that reaches so far from its centre (Q8) fit into packed ones, and discs of
    /// cells with this side (Q16) into a mask.
    #[inline(always)]
    pub(super) fn can_hold(view: &View, reach: i32, side: i32) -> bool {
        let beside = window(side);
        reach <= (REACH - beside) << 8 && side <= LARGEST_SIDE && view.width.min(view.height) >= 72
    }

    /// Whether what is projected up to here (Q8 from the axis, along x and y) is seen near enough to the axis.
    pub(super) fn sees(view: &View, [x, y]: [i32; 2]) -> bool {
        // Far beyond what is near enough, so that squares fit.
        let tangent = |v: i32| view.tangent(v).clamp(-1024, 1024);
        Sight::new([tangent(x), tangent(y)]).is_some()
    }

    /// For a block that they [can hold](Self::can_hold), whose centre is projected to (x, y) (Q8 from the
    /// axis), and whose cells have a side of `side` and are `steps` (Q16), in W `depths` apart; `is_inside` says
    /// that no stamp has pixels beyond the frame's edge. False when it is seen too far from the axis, or not at
    /// all.
    #[inline(always)]
    pub(super) fn turn_to(
        &mut self,
        view: &View,
        steps: &[Step; 3],
        [x, y]: [i32; 2],
        side: i32,
        depths: [i32; 3],
        is_inside: bool,
    ) -> bool {
        let (tx, ty) = (view.tangent(x), view.tangent(y));
        let square = tx * tx + ty * ty;
        let Some(sight) = Sight::new([tx, ty]) else {
            return false;
        };
        self.sight = sight;
        // 1 / sqrt(1 + t^2) by its series, 256 to the unit; t^2 is at most a half.
        let t2 = square >> 10;
        let length = 256 - (t2 >> 1) + ((3 * t2 * t2) >> 11) - ((5 * t2 * t2 * t2) >> 20);
        let [small, large] = self.cut.radii;
        let sides = if side < 3 << 15 { small } else { large };
        let radius = ((side >> 4) * sides) >> 12;
        let largest = match window(side) {
            4 => mask::LARGEST_OF_FOUR,
            _ => mask::LARGEST,
        };
        let Some(circle) = Circle::of((radius as u32).min(largest)) else {
            return false;
        };
        self.circle = circle;
        // 64ths of a pixel.
        self.breadth = ((radius * length) >> 10) as u32;

        let reach = ((side >> 4) * self.offset_range) >> 13;
        let all = self.offsets_by_reach;
        self.offsets = *all.get(reach as usize).or(all.last()).unwrap_or(&[0; 8]);

        let packed = |s: &Step| ((s.x >> 6) as u32).wrapping_add(((s.y >> 6) as u32) << 16);
        let [sx, sy, sz] = steps;
        let (sx, sy) = (packed(sx), packed(sy));
        self.along_z = packed(sz);
        let row = |middle: u32| [middle.wrapping_sub(sx), middle, middle.wrapping_add(sx)];
        let ([a, b, c], [d, e, f], [g, h, i]) = (row(0u32.wrapping_sub(sy)), row(0), row(sy));
        self.cells = [a, b, c, d, e, f, g, h, i];
        self.depths = depths;

        let corner = |v: i32, side: i32| ((v >> 8) + (side >> 1)) - REACH;
        let (width, height) = self.size;
        let corner = (corner(x, width), corner(y, height));
        if is_inside {
            // Windows in the frame begin within 64 pixels of a corner whose 64 windows are in it, too.
            let window = window(side);
            let moved = |corner: i32, side: i32| corner.min(side - 63 - window).max(0);
            self.corner = (moved(corner.0, width), moved(corner.1, height));
            self.edges = None;
        } else {
            self.corner = corner;
            self.edges = Edges::new(corner, self.size);
            return self.edges.is_some();
        }
        true
    }

    /// In W, from the middle of a plane of 3 x 3 cells to each.
    #[inline(always)]
    fn depths_of_plane(&self) -> [i32; 9] {
        let [x, y, _] = self.depths;
        let row = |middle: i32| [middle - x, middle, middle + x];
        let ([a, b, c], [d, e, f], [g, h, i]) = (row(-y), row(0), row(y));
        [a, b, c, d, e, f, g, h, i]
    }

    /// How far a sample's place may be from its parent's, packed, with a bit to spare for what is carried
    /// from x to y.
    #[cfg(rho_thumb)]
    fn around(&self) -> u32 {
        let [_, _, _, _, _, x, _, y, _] = self.cells;
        let farthest = self.offsets.iter().map(|v| v.unsigned_abs()).max();
        // An offset in 32nds times a direction, 32 to the unit.
        let offset = 34 * u32::from(farthest.unwrap_or(0));
        let along = |step: fn(u32) -> i32| {
            let steps = [x, y, self.along_z].map(|packed| step(packed).unsigned_abs() + 1);
            steps.iter().sum::<u32>() + offset
        };
        let lower = |packed: u32| i32::from(packed as i16);
        // What the lower half borrows is taken for the step's own: one less at most.
        let upper = |packed: u32| packed as i32 >> 16;
        along(lower) | along(upper) << 16
    }

    /// How far a disc, and what its window has beyond three pixels from there, reaches beyond its cell's bounds at
    /// most, Q8.
    pub(super) fn overhang(side: i32) -> i32 {
        // 0.87 sides less the half that is within, and the offset: at most 0.84 sides.
        // Q16 to Q8; shifted first, since near the eye a side has up to 31 bits.
        (((side >> 4) * 5) >> 6) + 1 + ((window(side) - 4) << 6)
    }

    /// Stamps all subcells of a block's parents, whose words are of this kind.
    #[inline(always)]
    pub(super) fn stamp<V: Visibility, R: Reciprocal>(
        &mut self,
        kind: Kind,
        target: &mut V,
        parents: &Parents<'_, '_>,
        shading: &impl Shade,
    ) {
        match kind {
            Kind::Offset => self.stamp_all::<Offset, V, R>(target, parents, shading),
            Kind::Both => self.stamp_all::<Both, V, R>(target, parents, shading),
            Kind::Colour => self.stamp_all::<Colour, V, R>(target, parents, shading),
        }
    }

    #[inline(always)]
    fn stamp_all<F: Fields, V: Visibility, R: Reciprocal>(
        &mut self,
        target: &mut V,
        parents: &Parents<'_, '_>,
        shading: &impl Shade,
    ) {
        #[cfg(rho_thumb)]
        if F::thumb(self, target, parents, shading) {
            return;
        }
        self.block::<F, V, R>(target, parents, shading);
    }

    /// What is taken from four times a screen coordinate (Q8 from the axis) for its packed place:
    /// from a centre to the middle of its window's first pixel, plus half a pixel, so that what is
    /// left over after whole pixels are taken is the window's part.
    #[inline(always)]
    fn origin(&self, rows: i32) -> (i32, i32) {
        let bias = 512 * (rows - 1);
        let (x, y) = self.corner;
        let (mx, my) = self.size;
        ((x << 10) + bias - (mx << 9), (y << 10) + bias - (my << 9))
    }

    #[inline(never)]
    fn block<F: Fields, V: Visibility, R: Reciprocal>(
        &self,
        target: &mut V,
        parents: &Parents<'_, '_>,
        shading: &impl Shade,
    ) {
        let (x, y) = self.corner;
        let corner = target.corner(x, y);
        let (x, y) = self.origin(self.circle.rows() as i32);
        let words = F::words(parents.words());
        let mut tail = [F::Word::default(); 16];
        // From entry `FIRST` on.
        let [a, b, c, d, e, f, g, h, i] = self.depths_of_plane();
        let depths = [0, 0, a, b, c, d, e, f, g, h, i, 0, 0, 0, 0, 0];
        let [a, b, c, d, e, f, g, h, i] = self.cells;
        let places = [0, 0, a, b, c, d, e, f, g, h, i, 0, 0, 0, 0, 0];
        let [.., deep_z] = self.depths;
        for parent in parents.order.entries() {
            let order = Order::from_bits(parent >> 16);
            let subcell = (parent >> 8 & 255) as usize;
            let Some(d) = parents.displacements.get(subcell) else {
                continue;
            };
            let centre = parents.centre.plus(*d);
            let over = OverW::new::<R>(centre.w, parents.k);
            let at = |v: i32, origin: i32| (4 * over.times(v)).wrapping_sub(origin) as u32;
            let middle = at(centre.x, x).wrapping_add(at(centre.y, y) << 16);

            let node = parents.first + (parent & 255);
            let cone = parents.cone(node).filter(|_| !self.backs);
            if cone.is_some_and(|cone| self.sight.is_hidden(cone, self.classes, 0)) {
                continue;
            }
            let two_sided = cone.is_none_or(|cone| u32::from(cone) & TWO_SIDED == TWO_SIDED);
            let [mask, ..] = parents.level.mask::<3>(node);
            let first = parents.level.first_child(node) as usize;
            let low = order.cells(mask);
            let mid = order.cells(mask >> 9);
            let high = order.cells(mask >> 18);
            let light = parents.light.map(|light| {
                let d = light.parents.get(subcell).copied().unwrap_or(0);
                (light.at.wrapping_add(d), light.cells)
            });
            let (along_z, w) = (self.along_z, centre.w);
            let last = first + low.1 + mid.1;
            let planes = [
                (low, (middle.wrapping_sub(along_z), w - deep_z), first, 0),
                (mid, (middle, w), first + low.1, 9),
                (high, (middle.wrapping_add(along_z), w + deep_z), last, 18),
            ];
            for ((cells, count), (at, w), first, plane) in order.planes(planes) {
                if count == 0 {
                    continue;
                }
                let words = words.get(first..).unwrap_or_default();
                let words: &[F::Word; 16] = match words.first_chunk() {
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
                    w,
                    places: &places,
                    depths: &depths,
                    corner,
                    light,
                    plane,
                    two_sided,
                };
                let cells = cells.iter().take(count);
                if order.is_backwards() {
                    self.samples::<F, _>(target, &samples, cells.rev(), shading);
                } else {
                    self.samples::<F, _>(target, &samples, cells, shading);
                }
            }
        }
    }

    #[inline(always)]
    fn samples<'l, F: Fields, V: Visibility>(
        &self,
        target: &mut V,
        samples: &Samples<'_, F::Word>,
        cells: impl Iterator<Item = &'l u8>,
        shading: &impl Shade,
    ) {
        for cell in cells {
            let cell = u32::from(*cell);
            let word: u32 = entry(samples.words, cell >> 4).into();
            let class = self.classes.of(F::normal(word));
            let offset = i32::from(entry(&self.offsets, F::offset(word)));
            let place = samples
                .at
                .wrapping_add(entry(samples.places, cell))
                .wrapping_add(class.across.wrapping_mul(offset as u32));
            let towards = self.sight.towards(class);
            if towards < FAR_AWAY && !samples.two_sided {
                continue;
            }
            let colour = || match samples.light {
                None => F::colour(shading, word),
                Some((at, cells)) => {
                    // The list's entry has the rank above the cell's number.
                    let subcell = samples.plane + (cell & 15) - FIRST;
                    let d = cells.get(subcell as usize).copied();
                    shading.colour_at(word, at.wrapping_add(d.unwrap_or(0)))
                }
            };
            let half = || {
                let cosine = u64::from(towards.unsigned_abs().max(self.cut.least_cosine));
                ((cosine * u64::from(self.breadth)) >> 32) as u32
            };
            let parts = place & 0x03FF_03FF;
            let (x, y) = (place >> 10 & 63, place >> 26);
            let w = samples.w + entry(samples.depths, cell);
            if let Circle::Eight(circles) = self.circle {
                let masks = mask::tiles(circles, parts, class.towards, half());
                self.tiles(target, samples.corner, (x, y), w, masks, colour);
                continue;
            }
            let within = self.edges.map_or(0xFFFF, |edges| edges.within(x, y));
            if within == 0 {
                continue;
            }
            let mask = || mask::disc(self.circle, parts, class.towards, half()) & within;
            let stamp = Stamp {
                corner: samples.corner,
                x,
                y,
                rows: self.circle.rows(),
                within,
                away: towards < 0,
                w,
            };
            target.stamp(stamp, mask, colour);
        }
    }

    /// Stamps the tiles of a large disc. If it faces away, it is asked of none whether it shows: each would ask for
    /// itself.
    #[inline(never)]
    fn tiles<V: Visibility>(
        &self,
        target: &mut V,
        corner: u32,
        (x, y): (u32, u32),
        w: i32,
        masks: [u32; mask::TILES],
        colour: impl Fn() -> u16,
    ) {
        for (tile, mask) in (0..).zip(masks) {
            let (x, y) = (x + tile % 2 * 4, y + tile / 2 * 4);
            let within = self.edges.map_or(0xFFFF, |edges| edges.within(x, y));
            if within == 0 {
                continue;
            }
            let stamp = Stamp {
                corner,
                x,
                y,
                rows: 4,
                within,
                away: false,
                w,
            };
            target.stamp(stamp, || mask & within, &colour);
        }
    }
}

/// The samples of a plane of 3 x 3 cells.
struct Samples<'g, W> {
    words: &'g [W; 16],
    /// The place of the middle cell.
    at: u32,
    w: i32,
    /// From there to each cell's.
    places: &'g [u32; 16],
    /// From there to each cell's W.
    depths: &'g [i32; 16],
    corner: u32,
    /// The parent in the light, and the way from there to its subcells.
    light: Option<(u32, &'g [u32; 27])>,
    /// The number of the plane's first subcell.
    plane: u32,
    /// Whether those that face away may show.
    two_sided: bool,
}

const _: () = assert!(CLASS_SHIFT == 4);
