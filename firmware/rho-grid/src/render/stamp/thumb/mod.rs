//! The loops over parents, planes and samples in assembly, for ARMv7-M.
//!
//! [`Stamps::block`] and [`Stamps::samples`](super::Stamps) are the same in Rust, and are what draws
//! without the feature `asm`, on other cores and into other frames; the bits are the same. What is
//! gained: registers are given out by hand, no index is checked again that the block has checked,
//! and planes are a subroutine.
//!
//! # Safety
//!
//! The assembly reads and writes memory through the pointers of [`Block`] and its own stack, and
//! nothing else; edges and depths only in loops for which [`stamp`] sets them. Each
//! access lies within what the pointer was made from. What is the same for all blocks of a level is set once
//! ([`Loops`]), from what the walk borrows while it lasts; a level is known by where its masks are, and what is drawn
//! into is compared each time. The rest is set
//! for each block.
//!
//! * *order*: `count` entries, at least one, made by [`ParentList`](super::ParentList).
//! * *displacements*: an entry's subcell comes from a mask, which names subcells of the block's
//!   division only ([`Grid`](crate::blob::Grid) again); [`stamp`] checks that all have theirs.
//! * *masks, cones, bases, offsets, words*: an entry's rank is below the number of the block's children;
//!   [`Grid`](crate::blob::Grid) has proved that they, their children and the children's words exist.
//!   Only words of children are read.
//! * *lists*: nine bits of a mask times the size of a list; a list has as many entries as it says.
//! * *offsets by step, cells*: three bits; the number in a list's entry, 2 to 10.
//! * *classes, tones*: nine bits of a word of 16 or of a cone; thirteen, or fourteen where words name materials,
//!   and [`stamp`] checks that there are as many tones.
//! * *directions*: four bits. *Half-planes*: `ORIGIN` and the number of places are such that no sum of
//!   a place within a window and a half width stays outside; [`stamp`] bounds `breadth`.
//! * *circle*: eight or six bits of place, and [`Circle`] has a table of as many, or one for each of four tiles.
//! * *spread*: eight bits of a mask.
//! * *unlit*: seven bits of a word of 16; there are [`NORMALS`](crate::unlit::NORMALS) rows.
//! * *in the light*: displacements by subcell and by a list's number, as above; of what a word is moved by,
//!   its upper seven and its lowest three bits; the map by as many bits of u and of v as its side has, which
//!   [`stamp`] compares with its length.
//! * *columns, rows*: six bits of a place, of a large disc's tiles four more; [`Edges`] have as many.
//! * *pixels*: places have six bits each, so windows begin within 64 x 64 pixels of the corner, and
//!   [`stamp`] checks that those and three more, each way, are in the frame's bytes, or seven of large discs. Where stamps may reach
//!   beyond the frame, a window is touched only if one of its pixels is in it ([`Edges`]): all of those are
//!   in the bytes, by the margins, of a frame that is as wide and high as the view, which [`stamp`] compares.
//!   In a band each window is compared with the last that lies in its bytes; one that begins before the
//!   first is, as a number without sign, beyond the last.
//! * *depths*: one a pixel, without margins, of a frame whose rows are no narrower than the view; [`stamp`]
//!   compares their number. Only those are touched whose pixels are in the frame: by [`Edges`], or, where
//!   there are none, since [`stamp`] compares the 64 x 64 windows with the view's width and height. What is
//!   asked of a parent ends three pixels beyond the last place, as windows do.

#![allow(unsafe_code, reason = "the one place with assembly")]

mod frame;
mod loops;

pub(in crate::render) use frame::{STRIDE, clear, is_covered, next_to_fill, set_ones};

use core::mem::MaybeUninit;

use super::edge::{Edges, Within};
use super::lists::{FIRST, LISTS, Lists};
use super::mask::{Direction, STRIPS, Strips, TILES, WIDE, Wide};
use super::parents::MAX_PARENTS;
use super::{Circle, Classes, FAR_AWAY, Parents, Stamps, classes};
use crate::blob::facing::{TWO_SIDED, WIDTH_BITS};
use crate::blob::format::MAX_MATERIALS;
use crate::normal::COUNT;
use crate::render::project::Homogeneous;
use crate::render::tones::{SPREAD, margin};
use crate::render::visibility::{Bytes, Depths, Visibility};
use crate::shading::Shade;
use crate::unlit::NORMALS;

/// What the assembly reads; the offsets stand in its first lines.
#[repr(C)]
struct Block {
    /// 0: by offset step.
    offsets: [i8; 8],
    /// 8: from the middle of a plane.
    cells: [u32; 9],
    /// 44, 48.
    sight: u32,
    breadth: u32,
    /// 52, 56
    wide: *const Wide,
    circle: *const u8,
    /// 60, 64.
    tones: *const u8,
    spread: *const [u32; 2],
    /// 68, 72, 76. Within [`Strips`], what stands before them is read, too.
    classes: *const classes::Class,
    half_planes: *const u16,
    corner: *mut u8,
    /// 80: the list of the parent's order.
    list: *const u8,
    /// 84, 88, 92.
    along_z: u32,
    origin: u32,
    k: u32,
    /// 96, 100, 104.
    centre: Homogeneous,
    /// 108.
    displacements: *const Homogeneous,
    /// 112, 116, 120, 124.
    masks: *const u32,
    bases: *const u32,
    firsts: *const u16,
    words: *const u16,
    /// 128, 132, 136.
    node: u32,
    order: *const u32,
    end: *const u32,
    /// 140.
    lists: *const Lists,
    /// 144: bits, place and words of each plane.
    planes: MaybeUninit<[u32; 9]>,
    /// 180: where shadows are looked up, if there are any.
    light: InLight,
    /// 212: the first byte of a band, from which `corner` counts there.
    band: *mut u8,
    /// 216: how many windows begin in it.
    windows: u32,
    /// 220: by node, or null where backs show.
    cones: *const u16,
    /// 224.
    step: i32,
    /// 228: the width of the parent's cone.
    width: u32,
    /// 232: set if stamps may reach beyond the frame's edges.
    cut: MaybeUninit<Cut>,
    /// 244: set if there are depths.
    deep: MaybeUninit<Deep>,
    /// 312.
    texels: Texels,
    /// 336: of a large disc, the strip's half width and place, the circle, the direction; 352: the window; 356, 360:
    /// what of it is in the frame, by column and by row.
    large: MaybeUninit<[u32; 7]>,
}

/// The frame's edges.
#[repr(C)]
struct Cut {
    /// 232, 236.
    columns: *const Within,
    rows: *const Within,
    /// 240: of a sample's window, what is in the frame.
    within: u32,
}

/// What comparing with depths needs.
#[repr(C)]
struct Deep {
    /// 244: in W, from the middle of a plane to its cells.
    depths: [i32; 9],
    /// 280: in W, from a plane to the next; 284, 288: the W of the parent and of the plane.
    deep_z: i32,
    parent_w: i32,
    plane_w: i32,
    /// 292: what W is worth in a depth.
    factor: u32,
    /// 296: from here a pixel's depth is as many times two bytes away as its address says.
    words: *mut u16,
    /// 300: the sample's depth.
    here: u32,
    /// 304: how much nearer than its parent a sample may be, in W.
    nearer: i32,
    /// 308: how far from its parent's place a sample's may be.
    around: u32,
}

/// How a place in the light is looked up.
#[repr(C)]
struct Texels {
    /// 312, 316: tones where the first light does not reach, eight of each normal, and the bits of a normal.
    unlit: *const u8,
    rows_of_unlit: u32,
    /// 320, 324: from a place in the light to its u among texels: shift and mask; 328, 332: to v.
    texel: [u32; 4],
}

/// What looking up a sample's shadow needs.
#[repr(C)]
struct InLight {
    /// 180: the sample's tone where the light does not reach it.
    unlit: u32,
    /// 184: by class of normal and offset.
    moved: *const u32,
    /// 188, 192: the parent's place in the light, and the plane's displacements, less [`FIRST`].
    parent: u32,
    plane: *const u32,
    /// 196: the texels.
    map: *const u16,
    /// 200, 204, 208: the block's place, its parents' and their cells' displacements, less [`FIRST`].
    at: u32,
    parents: *const u32,
    cells: *const u32,
}

impl Texels {
    /// No shadows.
    const NONE: Self = Self {
        unlit: core::ptr::null(),
        rows_of_unlit: 0,
        texel: [0; 4],
    };
}

impl InLight {
    /// No shadows.
    const NONE: Self = Self {
        unlit: 0,
        moved: core::ptr::null(),
        parent: 0,
        plane: core::ptr::null(),
        map: core::ptr::null(),
        at: 0,
        parents: core::ptr::null(),
        cells: core::ptr::null(),
    };
}

/// Goes through a block, whose windows have so many rows.
type Loop = unsafe extern "C" fn(*mut Block, rows: u32);

unsafe extern "C" {
    fn rho_grid_stamp(block: *mut Block, rows: u32);
    fn rho_grid_stamp_large(block: *mut Block, rows: u32);
    fn rho_grid_stamp_large_cut(block: *mut Block, rows: u32);
    fn rho_grid_stamp_large_both_cut(block: *mut Block, rows: u32);
    fn rho_grid_stamp_shaded_large_cut(block: *mut Block, rows: u32);
    fn rho_grid_stamp_shaded_large_both_cut(block: *mut Block, rows: u32);
    fn rho_grid_stamp_band_large_cut(block: *mut Block, rows: u32);
    fn rho_grid_stamp_band_large_both_cut(block: *mut Block, rows: u32);
    fn rho_grid_stamp_band(block: *mut Block, rows: u32);
    fn rho_grid_stamp_both(block: *mut Block, rows: u32);
    fn rho_grid_stamp_band_both(block: *mut Block, rows: u32);
    fn rho_grid_stamp_band_both_cut(block: *mut Block, rows: u32);
    fn rho_grid_stamp_cut(block: *mut Block, rows: u32);
    fn rho_grid_stamp_band_cut(block: *mut Block, rows: u32);
    fn rho_grid_stamp_both_cut(block: *mut Block, rows: u32);
    fn rho_grid_stamp_64(block: *mut Block, rows: u32);
    fn rho_grid_stamp_128(block: *mut Block, rows: u32);
    fn rho_grid_stamp_256(block: *mut Block, rows: u32);
    fn rho_grid_stamp_64_dim(block: *mut Block, rows: u32);
    fn rho_grid_stamp_128_dim(block: *mut Block, rows: u32);
    fn rho_grid_stamp_256_dim(block: *mut Block, rows: u32);
    fn rho_grid_stamp_shaded_cut(block: *mut Block, rows: u32);
    fn rho_grid_stamp_shaded_both(block: *mut Block, rows: u32);
    fn rho_grid_stamp_shaded_both_cut(block: *mut Block, rows: u32);
    fn rho_grid_stamp_shaded_deep(block: *mut Block, rows: u32);
    fn rho_grid_stamp_shaded_deep_cut(block: *mut Block, rows: u32);
    fn rho_grid_stamp_shaded_deep_both(block: *mut Block, rows: u32);
    fn rho_grid_stamp_shaded_deep_both_cut(block: *mut Block, rows: u32);
    fn rho_grid_stamp_deep(block: *mut Block, rows: u32);
    fn rho_grid_stamp_deep_both(block: *mut Block, rows: u32);
    fn rho_grid_stamp_deep_cut(block: *mut Block, rows: u32);
    fn rho_grid_stamp_deep_both_cut(block: *mut Block, rows: u32);
}

/// The loops for the blocks of a level, and what they read that is the same for all of these.
pub(super) struct Loops {
    /// Within the frame, and at its edges; none where blocks are drawn by other means.
    loops: Option<[Loop; 2]>,
    /// The same of large discs. Those that are drawn less have no loop within the frame: they go by the one that looks
    /// at its edges.
    large: Option<(Option<Loop>, Loop)>,
    /// Whether they draw into a band, and against depths.
    kind: (bool, bool),
    /// For the level whose masks it points to.
    block: Block,
}

impl Loops {
    /// For no level.
    pub(super) const NONE: Self = Self {
        loops: None,
        large: None,
        kind: (false, false),
        block: Block {
            offsets: [0; 8],
            cells: [0; 9],
            sight: 0,
            breadth: 0,
            wide: WIDE.as_ptr(),
            circle: core::ptr::null(),
            tones: core::ptr::null(),
            spread: SPREAD.as_ptr(),
            classes: core::ptr::null(),
            half_planes: (&raw const STRIPS)
                .cast::<u16>()
                .wrapping_byte_add(core::mem::offset_of!(Strips, half_planes)),
            corner: core::ptr::null_mut(),
            list: core::ptr::null(),
            along_z: 0,
            origin: 0,
            k: 0,
            centre: Homogeneous::ZERO,
            displacements: core::ptr::null(),
            masks: core::ptr::null(),
            bases: core::ptr::null(),
            firsts: core::ptr::null(),
            words: core::ptr::null(),
            node: 0,
            order: core::ptr::null(),
            end: core::ptr::null(),
            lists: LISTS.as_ptr(),
            planes: MaybeUninit::uninit(),
            light: InLight::NONE,
            band: core::ptr::null_mut(),
            windows: 0,
            cones: core::ptr::null(),
            step: 0,
            width: TWO_SIDED,
            cut: MaybeUninit::uninit(),
            deep: MaybeUninit::uninit(),
            texels: Texels::NONE,
            large: MaybeUninit::uninit(),
        },
    };

    /// Turns to the level of these parents, into a band or not, against depths or not.
    #[inline(never)]
    fn turn_to<const BOTH: bool, S: Shade>(
        &mut self,
        classes: &Classes,
        backs: bool,
        parents: &Parents<'_, '_>,
        shading: &S,
        kind: (bool, bool),
    ) {
        let (is_band, is_deep) = kind;
        self.kind = kind;
        let block = &mut self.block;
        block.masks = parents.level.masks.as_ptr();
        self.loops = None;
        let Some(tones) = shading.tones(BOTH) else {
            return;
        };
        // A word without the bits below those that are looked up.
        let looked_up = if BOTH { 2 * COUNT } else { COUNT };
        let shadows = shading.look_up();
        // Of bands, only what is drawn most.
        if tones.len() < looked_up
            || parents.displacements.len() < parents.subcells
            || (is_band && shadows.is_some())
        {
            return;
        }
        let bits = shadows.map_or(0, |shadows| shadows.bits.min(8));
        let side = 1u32 << bits;
        let mut is_dim = false;
        match (shadows, &parents.light) {
            (None, None) => (),
            // Maps of the three sizes.
            (Some(shadows), Some(light))
                if (6..=8).contains(&shadows.bits)
                    && light.parents.len() >= parents.subcells
                    && shadows.map.len() >> bits >> bits > 0 =>
            {
                let (table, rows_of_unlit) = shadows.unlit;
                let [[first, ..], ..] = table;
                is_dim = rows_of_unlit > 0;
                block.texels = Texels {
                    unlit: table.as_ptr().cast(),
                    rows_of_unlit,
                    texel: [11 - bits, side - 1, 22 - 2 * bits, (side - 1) << bits],
                };
                block.light = InLight {
                    unlit: u32::from(*first),
                    moved: shadows.moved.as_ptr().cast(),
                    parent: 0,
                    plane: core::ptr::null(),
                    map: shadows.map.as_ptr(),
                    at: light.at,
                    parents: light.parents.as_ptr(),
                    cells: light.cells.as_ptr().wrapping_sub(FIRST as usize),
                };
            }
            _ => return,
        }
        block.tones = tones.as_ptr();
        block.classes = classes.0.as_ptr();
        block.k = parents.k;
        block.displacements = parents.displacements.as_ptr();
        block.bases = parents.level.bases.as_ptr();
        block.firsts = parents.level.offsets.as_ptr();
        block.words = parents.words().halves().as_ptr();
        block.cones = match parents.level.cones {
            cones if backs || cones.is_empty() => core::ptr::null(),
            cones => cones.as_ptr(),
        };
        block.width = TWO_SIDED;
        self.large = match (is_band, BOTH, shadows.is_some()) {
            _ if is_deep => None,
            (true, true, _) => Some((None, rho_grid_stamp_band_large_both_cut)),
            (true, false, _) => Some((None, rho_grid_stamp_band_large_cut)),
            (_, true, true) => Some((None, rho_grid_stamp_shaded_large_both_cut)),
            (_, false, true) => Some((None, rho_grid_stamp_shaded_large_cut)),
            (_, true, false) => Some((None, rho_grid_stamp_large_both_cut)),
            (_, false, false) => Some((Some(rho_grid_stamp_large), rho_grid_stamp_large_cut)),
        };
        self.loops = Some(match (is_band, BOTH, is_deep, shadows.is_some()) {
            (true, true, ..) => [rho_grid_stamp_band_both, rho_grid_stamp_band_both_cut],
            (true, false, ..) => [rho_grid_stamp_band, rho_grid_stamp_band_cut],
            (_, true, true, true) => [
                rho_grid_stamp_shaded_deep_both,
                rho_grid_stamp_shaded_deep_both_cut,
            ],
            (_, false, true, true) => [rho_grid_stamp_shaded_deep, rho_grid_stamp_shaded_deep_cut],
            (_, true, true, false) => [rho_grid_stamp_deep_both, rho_grid_stamp_deep_both_cut],
            (_, false, true, false) => [rho_grid_stamp_deep, rho_grid_stamp_deep_cut],
            (_, true, false, true) => [rho_grid_stamp_shaded_both, rho_grid_stamp_shaded_both_cut],
            (_, true, false, false) => [rho_grid_stamp_both, rho_grid_stamp_both_cut],
            (_, false, false, false) => [rho_grid_stamp, rho_grid_stamp_cut],
            (_, false, false, true) => [
                match (bits, is_dim) {
                    (6, false) => rho_grid_stamp_64,
                    (7, false) => rho_grid_stamp_128,
                    (_, false) => rho_grid_stamp_256,
                    (6, true) => rho_grid_stamp_64_dim,
                    (7, true) => rho_grid_stamp_128_dim,
                    (_, true) => rho_grid_stamp_256_dim,
                },
                rho_grid_stamp_shaded_cut,
            ],
        });
    }
}

/// Stamps all subcells of a block's parents, if there is a loop for them.
#[inline(always)]
pub(super) fn stamp<const BOTH: bool, V: Visibility, S: Shade>(
    stamps: &mut Stamps<'_>,
    parents: &Parents<'_, '_>,
    target: &mut V,
    shading: &S,
) -> bool {
    let Some(bytes) = target.bytes() else {
        return false;
    };
    let Bytes {
        pixels,
        band,
        depths,
    } = bytes;
    let kind = (band.is_some(), depths.is_some());
    if stamps.loops.block.masks != parents.level.masks.as_ptr() || stamps.loops.kind != kind {
        let (classes, backs) = (stamps.classes, stamps.backs);
        (stamps.loops).turn_to::<BOTH, S>(classes, backs, parents, shading, kind);
    }
    let Some([within, cut]) = stamps.loops.loops else {
        return false;
    };
    let (x, y) = stamps.corner;
    let (width, height) = stamps.size;
    let mut edges = stamps.edges;
    let is_large = matches!(stamps.circle, Circle::Eight(_));
    let (within, cut) = match stamps.loops.large {
        _ if !is_large => (Some(within), cut),
        Some(large) => large,
        None => return false,
    };
    if edges.is_none() && within.is_none() {
        edges = Edges::new((x, y), (width, height));
        if edges.is_none() {
            return true;
        }
    }
    if let Some(Depths { words, factor }) = depths {
        // A depth a pixel of rows as wide as those of the frame, so views are no wider.
        let farthest = i64::from(parents.centre.w)
            + 8 * stamps
                .depths
                .map(i64::from)
                .map(i64::abs)
                .iter()
                .sum::<i64>();
        let depth = (farthest.unsigned_abs() * u64::from(factor)) >> 32;
        let holds = width as usize <= STRIDE && STRIDE * height as usize <= words.len();
        if depth >= 0xFFFE || !holds {
            return false;
        }
        let fits = |corner: i32, side: i32| (0..side - 66).contains(&corner);
        if edges.is_none() && !(fits(x, width) && fits(y, height)) {
            edges = Edges::new(stamps.corner, stamps.size);
            if edges.is_none() {
                return true;
            }
        }
        let first = pixels.as_ptr().addr().wrapping_add(margin(STRIDE));
        stamps.loops.block.deep = MaybeUninit::new(Deep {
            depths: stamps.depths_of_plane(),
            deep_z: stamps.depths[2],
            parent_w: 0,
            plane_w: 0,
            factor,
            words: words.as_mut_ptr().wrapping_byte_sub(first.wrapping_mul(2)),
            here: 0,
            nearer: stamps.depths.iter().map(|step| step.abs()).sum(),
            around: stamps.around(),
        });
    }
    let stride = if band.is_some() { 2 * STRIDE } else { STRIDE };
    let corner = margin(stride) as i32 + (y - band.unwrap_or(0)) * stride as i32 + x;
    let window = if is_large { 8 } else { 4 };
    // 63 pixels on, and what the window has beyond its first.
    let last = corner + (62 + window) * (STRIDE as i32 + 1);
    let is_inside = match edges {
        _ if band.is_some() => true,
        None => corner >= 0 && (last as usize) < pixels.len(),
        Some(_) => {
            let rows = pixels.len().saturating_sub(2 * margin(STRIDE)) / STRIDE;
            width as usize <= STRIDE && height as usize <= rows
        }
    };
    let order = parents.order.entries();
    if !is_inside || stamps.breadth >= 1 << 8 || order.is_empty() {
        return true;
    }
    let (rows, circle): (i32, *const u8) = match stamps.circle {
        Circle::Two(circle) => (2, circle.as_ptr()),
        Circle::Three(circle) => (3, circle.as_ptr().cast()),
        Circle::Four(circle) => (4, circle.as_ptr().cast()),
        Circle::Eight(tiles) => (8, tiles.as_ptr().cast()),
    };
    let (x, y) = stamps.origin(rows);
    let order = order.as_ptr_range();
    let block = &mut stamps.loops.block;
    block.offsets = stamps.offsets;
    block.cells = stamps.cells;
    block.sight = stamps.sight.tangents;
    block.step = stamps.sight.step;
    block.breadth = stamps.breadth;
    block.circle = circle;
    // Of a frame it may lie before the first pixel, where windows that begin there are left.
    block.corner = match band {
        None => pixels.as_mut_ptr().wrapping_add(corner as usize),
        Some(_) => core::ptr::without_provenance_mut(corner as usize),
    };
    block.band = pixels.as_mut_ptr();
    // A window is as long as the margin.
    block.windows = (pixels.len() + 1).saturating_sub(margin(stride)) as u32;
    block.along_z = stamps.along_z;
    block.origin = 0u32.wrapping_sub(x as u32).wrapping_sub((y as u32) << 16);
    block.centre = parents.centre;
    block.node = parents.first;
    block.order = order.start;
    block.end = order.end;
    if let Some(light) = &parents.light {
        block.light.at = light.at;
    }
    let chosen = match (edges, within) {
        (None, Some(within)) => within,
        (None, None) => return true,
        (Some(edges), _) => {
            block.cut = MaybeUninit::new(Cut {
                columns: edges.columns.as_ptr(),
                rows: edges.rows.as_ptr(),
                within: 0,
            });
            cut
        }
    };
    // SAFETY: the module's argument; all that is pointed to is borrowed here, or by the walk to which the stamps
    // belong.
    unsafe { chosen(&raw mut *block, rows as u32) };
    true
}

const _: () = {
    assert!(core::mem::offset_of!(Block, sight) == 44);
    assert!(core::mem::offset_of!(Block, classes) == 68);
    assert!(core::mem::offset_of!(Block, centre) == 96);
    assert!(core::mem::offset_of!(Block, planes) == 144);
    assert!(core::mem::offset_of!(Block, light) == 180);
    assert!(core::mem::offset_of!(Block, windows) == 216);
    assert!(core::mem::offset_of!(Block, width) == 228);
    assert!(core::mem::offset_of!(Block, cut) == 232);
    assert!(core::mem::offset_of!(Cut, within) == 8);
    assert!(core::mem::offset_of!(Block, deep) == 244);
    assert!(core::mem::offset_of!(Deep, deep_z) == 36);
    assert!(core::mem::offset_of!(Deep, around) == 64);
    assert!(core::mem::offset_of!(Block, texels) == 312);
    assert!(core::mem::offset_of!(Texels, texel) == 8);
    assert!(core::mem::offset_of!(Block, large) == 336);
    assert!(core::mem::offset_of!(Strips, half_planes) == 3 * 16 * size_of::<Direction>());
    assert!(size_of::<Direction>() == 8);
    assert!(size_of::<Wide>() == 16 && core::mem::offset_of!(Wide, shifts) == 8);
    assert!(TILES == 4 && size_of::<[u16; 64]>() == 128);
    assert!(FIRST == 2);
    assert!(NORMALS == 128 && MAX_MATERIALS == 8);
    assert!(size_of::<Within>() == 4);
    assert!(FAR_AWAY == -0x1000_0000);
    assert!(TWO_SIDED == 127 && WIDTH_BITS == 7);
    assert!(core::mem::offset_of!(InLight, cells) == 28);
    assert!(size_of::<Lists>() == 5120);
    // Subcells and ranks have a byte each.
    assert!(MAX_PARENTS < 256);
};
