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
//! nothing else; the parts of [`Block`] that may not be set only in loops for which [`stamp`] sets them. Each
//! access lies within what the pointer was made from:
//!
//! * *order*: `count` entries, at least one, made by [`Parents`].
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
//! * *circle*: eight or six bits of place, and [`Circle`] has a table of as many.
//! * *spread*: eight bits of a mask.
//! * *unlit*: eight bits of a word of 16; there are [`NORMALS`](crate::unlit::NORMALS) rows.
//! * *in the light*: displacements by subcell and by a list's number, as above; of what a word is moved by,
//!   its upper seven and its lowest three bits; the map by as many bits of u and of v as its side has, which
//!   [`stamp`] compares with its length.
//! * *pixels*: places have six bits each, so windows begin within 64 x 64 pixels of the corner, and
//!   [`stamp`] checks that those and three more, each way, are in the frame's bytes. In a band each window
//!   is compared with the last that lies in its bytes; one that begins before the first is, as a number
//!   without sign, beyond the last.

#![allow(unsafe_code, reason = "the one place with assembly")]

mod frame;

pub(in crate::render) use frame::{STRIDE, clear, is_covered, next_to_fill};

use core::arch::global_asm;
use core::mem::MaybeUninit;

use super::edge::{Edges, Within};
use super::lists::{FIRST, LISTS, Lists};
use super::mask::{Direction, HALF_PLANES};
use super::{Circle, FAR_AWAY, MAX_PARENTS, Parents, Stamps, classes};
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
    directions: *const Direction,
    circle: *const u8,
    /// 60, 64.
    tones: *const u8,
    spread: *const [u32; 2],
    /// 68, 72, 76.
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
    /// 180: where shadows are looked up; set if there are any.
    light: MaybeUninit<InLight>,
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
    /// 312: set if there are shadows.
    texels: MaybeUninit<Texels>,
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

unsafe extern "C" {
    fn rho_grid_stamp_two(block: *mut Block);
    fn rho_grid_stamp_three(block: *mut Block);
    fn rho_grid_stamp_four(block: *mut Block);
    fn rho_grid_stamp_band_two(block: *mut Block);
    fn rho_grid_stamp_band_three(block: *mut Block);
    fn rho_grid_stamp_band_four(block: *mut Block);
    fn rho_grid_stamp_both_two(block: *mut Block);
    fn rho_grid_stamp_both_three(block: *mut Block);
    fn rho_grid_stamp_both_four(block: *mut Block);
    fn rho_grid_stamp_two_cut(block: *mut Block);
    fn rho_grid_stamp_three_cut(block: *mut Block);
    fn rho_grid_stamp_four_cut(block: *mut Block);
    fn rho_grid_stamp_band_two_cut(block: *mut Block);
    fn rho_grid_stamp_band_three_cut(block: *mut Block);
    fn rho_grid_stamp_band_four_cut(block: *mut Block);
    fn rho_grid_stamp_both_two_cut(block: *mut Block);
    fn rho_grid_stamp_both_three_cut(block: *mut Block);
    fn rho_grid_stamp_both_four_cut(block: *mut Block);
    fn rho_grid_stamp_two_64(block: *mut Block);
    fn rho_grid_stamp_three_64(block: *mut Block);
    fn rho_grid_stamp_four_64(block: *mut Block);
    fn rho_grid_stamp_two_128(block: *mut Block);
    fn rho_grid_stamp_three_128(block: *mut Block);
    fn rho_grid_stamp_four_128(block: *mut Block);
    fn rho_grid_stamp_two_256(block: *mut Block);
    fn rho_grid_stamp_three_256(block: *mut Block);
    fn rho_grid_stamp_four_256(block: *mut Block);
    fn rho_grid_stamp_two_64_dim(block: *mut Block);
    fn rho_grid_stamp_two_128_dim(block: *mut Block);
    fn rho_grid_stamp_two_256_dim(block: *mut Block);
    fn rho_grid_stamp_three_64_dim(block: *mut Block);
    fn rho_grid_stamp_three_128_dim(block: *mut Block);
    fn rho_grid_stamp_three_256_dim(block: *mut Block);
    fn rho_grid_stamp_four_64_dim(block: *mut Block);
    fn rho_grid_stamp_four_128_dim(block: *mut Block);
    fn rho_grid_stamp_four_256_dim(block: *mut Block);
    fn rho_grid_stamp_shaded_two_cut(block: *mut Block);
    fn rho_grid_stamp_shaded_three_cut(block: *mut Block);
    fn rho_grid_stamp_shaded_four_cut(block: *mut Block);
    fn rho_grid_stamp_shaded_both_two(block: *mut Block);
    fn rho_grid_stamp_shaded_both_three(block: *mut Block);
    fn rho_grid_stamp_shaded_both_four(block: *mut Block);
    fn rho_grid_stamp_shaded_both_two_cut(block: *mut Block);
    fn rho_grid_stamp_shaded_both_three_cut(block: *mut Block);
    fn rho_grid_stamp_shaded_both_four_cut(block: *mut Block);
    fn rho_grid_stamp_shaded_deep_two(block: *mut Block);
    fn rho_grid_stamp_shaded_deep_three(block: *mut Block);
    fn rho_grid_stamp_shaded_deep_four(block: *mut Block);
    fn rho_grid_stamp_shaded_deep_two_cut(block: *mut Block);
    fn rho_grid_stamp_shaded_deep_three_cut(block: *mut Block);
    fn rho_grid_stamp_shaded_deep_four_cut(block: *mut Block);
    fn rho_grid_stamp_shaded_deep_both_two(block: *mut Block);
    fn rho_grid_stamp_shaded_deep_both_three(block: *mut Block);
    fn rho_grid_stamp_shaded_deep_both_four(block: *mut Block);
    fn rho_grid_stamp_shaded_deep_both_two_cut(block: *mut Block);
    fn rho_grid_stamp_shaded_deep_both_three_cut(block: *mut Block);
    fn rho_grid_stamp_shaded_deep_both_four_cut(block: *mut Block);
    fn rho_grid_stamp_deep_two(block: *mut Block);
    fn rho_grid_stamp_deep_three(block: *mut Block);
    fn rho_grid_stamp_deep_four(block: *mut Block);
    fn rho_grid_stamp_deep_both_two(block: *mut Block);
    fn rho_grid_stamp_deep_both_three(block: *mut Block);
    fn rho_grid_stamp_deep_both_four(block: *mut Block);
    fn rho_grid_stamp_deep_two_cut(block: *mut Block);
    fn rho_grid_stamp_deep_three_cut(block: *mut Block);
    fn rho_grid_stamp_deep_four_cut(block: *mut Block);
    fn rho_grid_stamp_deep_both_two_cut(block: *mut Block);
    fn rho_grid_stamp_deep_both_three_cut(block: *mut Block);
    fn rho_grid_stamp_deep_both_four_cut(block: *mut Block);
}

/// One of them for windows of two, three and four rows.
type Loops = [unsafe extern "C" fn(*mut Block); 3];

/// Stamps all subcells of a block's parents.
#[inline(always)]
pub(super) fn stamp<const BOTH: bool, V: Visibility, S: Shade>(
    stamps: &Stamps<'_>,
    parents: &Parents<'_, '_, u16>,
    target: &mut V,
    shading: &S,
) -> bool {
    let (Some(bytes), Some(tones)) = (target.bytes(), shading.tones(BOTH)) else {
        return false;
    };
    let Bytes {
        pixels,
        band,
        depths,
    } = bytes;
    // A word without the bits below those that are looked up.
    let looked_up = if BOTH { 2 * COUNT } else { COUNT };
    if tones.len() < looked_up {
        return false;
    }
    let shadows = shading.look_up();
    // Of bands, only what is drawn most.
    let mut edges = stamps.edges;
    let is_deep = depths.is_some();
    if band.is_some() && (BOTH || shadows.is_some()) {
        return false;
    }
    let bits = shadows.map_or(0, |shadows| shadows.bits.min(8));
    let side = 1u32 << bits;
    let (texels, unlit_of_all, rows_of_unlit) = match shadows {
        None => (MaybeUninit::uninit(), 0, 0),
        Some(shadows) => {
            let (table, rows_of_unlit) = shadows.unlit;
            let [[first, ..], ..] = table;
            let texels = Texels {
                unlit: table.as_ptr().cast(),
                rows_of_unlit,
                texel: [11 - bits, side - 1, 22 - 2 * bits, (side - 1) << bits],
            };
            (MaybeUninit::new(texels), u32::from(*first), rows_of_unlit)
        }
    };
    let light = match (shadows, &parents.light) {
        (None, None) => MaybeUninit::uninit(),
        // Maps of the three sizes.
        (Some(shadows), Some(light))
            if (6..=8).contains(&shadows.bits)
                && light.parents.len() >= parents.subcells
                && shadows.map.len() >> bits >> bits > 0 =>
        {
            MaybeUninit::new(InLight {
                unlit: unlit_of_all,
                moved: shadows.moved.as_ptr().cast(),
                parent: 0,
                plane: core::ptr::null(),
                map: shadows.map.as_ptr(),
                at: light.at,
                parents: light.parents.as_ptr(),
                cells: light.cells.as_ptr().wrapping_sub(FIRST as usize),
            })
        }
        _ => return false,
    };
    let (x, y) = stamps.corner;
    let stride = if band.is_some() { 2 * STRIDE } else { STRIDE };
    let corner = margin(stride) as i32 + (y - band.unwrap_or(0)) * stride as i32 + x;
    // 63 pixels on, and the window's three.
    let last = corner + 66 * (STRIDE as i32 + 1);
    let deep = match depths {
        None => MaybeUninit::uninit(),
        Some(Depths { words, factor }) => {
            let (width, height) = stamps.size;
            let farthest = i64::from(parents.centre.w)
                + 8 * stamps
                    .depths
                    .map(i64::from)
                    .map(i64::abs)
                    .iter()
                    .sum::<i64>();
            let depth = (farthest.unsigned_abs() * u64::from(factor)) >> 32;
            if depth >= 0xFFFE || words.len() < STRIDE * height as usize {
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
            MaybeUninit::new(Deep {
                depths: stamps.depths_of_plane(),
                deep_z: stamps.depths[2],
                parent_w: 0,
                plane_w: 0,
                factor,
                words: words.as_mut_ptr().wrapping_byte_sub(first.wrapping_mul(2)),
                here: 0,
                nearer: stamps.depths.iter().map(|step| step.abs()).sum(),
                around: stamps.around(),
            })
        }
    };
    // A window is as long as the margin.
    let windows = (pixels.len() + 1).saturating_sub(margin(stride)) as u32;
    let is_inside = match edges {
        _ if band.is_some() => true,
        None => corner >= 0 && (last as usize) < pixels.len(),
        Some(_) => {
            let (width, height) = stamps.size;
            let rows = pixels.len().saturating_sub(2 * margin(STRIDE)) / STRIDE;
            width as usize <= STRIDE && height as usize <= rows
        }
    };
    let order = parents.order.get(..parents.count).unwrap_or_default();
    if !is_inside
        || stamps.breadth >= 1 << 8
        || order.is_empty()
        || parents.displacements.len() < parents.subcells
    {
        return true;
    }
    let (rows, circle): (i32, *const u8) = match stamps.circle {
        Circle::Two(circle) => (2, circle.as_ptr()),
        Circle::Three(circle) => (3, circle.as_ptr().cast()),
        Circle::Four(circle) => (4, circle.as_ptr().cast()),
    };
    let directions = stamps.circle.directions();
    let (x, y) = stamps.origin(rows);
    let order = order.as_ptr_range();
    let mut block = Block {
        offsets: stamps.offsets,
        cells: stamps.cells,
        sight: stamps.sight.tangents,
        breadth: stamps.breadth,
        directions: directions.as_ptr(),
        circle,
        tones: tones.as_ptr(),
        spread: SPREAD.as_ptr(),
        classes: stamps.classes.0.as_ptr(),
        half_planes: HALF_PLANES.as_ptr(),
        // Of a frame within the pixels: it is neither negative nor beyond the last.
        corner: match band {
            None => pixels.as_mut_ptr().wrapping_add(corner as usize),
            Some(_) => core::ptr::without_provenance_mut(corner as usize),
        },
        list: core::ptr::null(),
        along_z: stamps.along_z,
        origin: 0u32.wrapping_sub(x as u32).wrapping_sub((y as u32) << 16),
        k: parents.k,
        centre: parents.centre,
        displacements: parents.displacements.as_ptr(),
        masks: parents.level.masks.as_ptr(),
        bases: parents.level.bases.as_ptr(),
        firsts: parents.level.offsets.as_ptr(),
        words: parents.words.as_ptr(),
        node: parents.first,
        order: order.start,
        end: order.end,
        lists: LISTS.as_ptr(),
        planes: MaybeUninit::uninit(),
        light,
        band: pixels.as_mut_ptr(),
        windows,
        cones: match parents.level.cones {
            cones if stamps.backs || cones.is_empty() => core::ptr::null(),
            cones => cones.as_ptr(),
        },
        step: stamps.sight.step,
        width: TWO_SIDED,
        cut: match edges {
            None => MaybeUninit::uninit(),
            Some(edges) => MaybeUninit::new(Cut {
                columns: edges.columns.as_ptr(),
                rows: edges.rows.as_ptr(),
                within: 0,
            }),
        },
        deep,
        texels,
    };
    let is_shaded = shadows.is_some();
    let loops: Loops = match (BOTH, edges.is_some()) {
        (_, true) if band.is_some() => [
            rho_grid_stamp_band_two_cut,
            rho_grid_stamp_band_three_cut,
            rho_grid_stamp_band_four_cut,
        ],
        (_, false) if band.is_some() => [
            rho_grid_stamp_band_two,
            rho_grid_stamp_band_three,
            rho_grid_stamp_band_four,
        ],
        (true, true) if is_shaded && is_deep => [
            rho_grid_stamp_shaded_deep_both_two_cut,
            rho_grid_stamp_shaded_deep_both_three_cut,
            rho_grid_stamp_shaded_deep_both_four_cut,
        ],
        (true, false) if is_shaded && is_deep => [
            rho_grid_stamp_shaded_deep_both_two,
            rho_grid_stamp_shaded_deep_both_three,
            rho_grid_stamp_shaded_deep_both_four,
        ],
        (false, true) if is_shaded && is_deep => [
            rho_grid_stamp_shaded_deep_two_cut,
            rho_grid_stamp_shaded_deep_three_cut,
            rho_grid_stamp_shaded_deep_four_cut,
        ],
        (false, false) if is_shaded && is_deep => [
            rho_grid_stamp_shaded_deep_two,
            rho_grid_stamp_shaded_deep_three,
            rho_grid_stamp_shaded_deep_four,
        ],
        (true, true) if is_shaded => [
            rho_grid_stamp_shaded_both_two_cut,
            rho_grid_stamp_shaded_both_three_cut,
            rho_grid_stamp_shaded_both_four_cut,
        ],
        (true, false) if is_shaded => [
            rho_grid_stamp_shaded_both_two,
            rho_grid_stamp_shaded_both_three,
            rho_grid_stamp_shaded_both_four,
        ],
        (false, true) if is_shaded => [
            rho_grid_stamp_shaded_two_cut,
            rho_grid_stamp_shaded_three_cut,
            rho_grid_stamp_shaded_four_cut,
        ],
        (true, true) if is_deep => [
            rho_grid_stamp_deep_both_two_cut,
            rho_grid_stamp_deep_both_three_cut,
            rho_grid_stamp_deep_both_four_cut,
        ],
        (true, false) if is_deep => [
            rho_grid_stamp_deep_both_two,
            rho_grid_stamp_deep_both_three,
            rho_grid_stamp_deep_both_four,
        ],
        (false, true) if is_deep => [
            rho_grid_stamp_deep_two_cut,
            rho_grid_stamp_deep_three_cut,
            rho_grid_stamp_deep_four_cut,
        ],
        (false, false) if is_deep => [
            rho_grid_stamp_deep_two,
            rho_grid_stamp_deep_three,
            rho_grid_stamp_deep_four,
        ],
        (true, true) => [
            rho_grid_stamp_both_two_cut,
            rho_grid_stamp_both_three_cut,
            rho_grid_stamp_both_four_cut,
        ],
        (true, false) => [
            rho_grid_stamp_both_two,
            rho_grid_stamp_both_three,
            rho_grid_stamp_both_four,
        ],
        (false, true) => [
            rho_grid_stamp_two_cut,
            rho_grid_stamp_three_cut,
            rho_grid_stamp_four_cut,
        ],
        (false, false) => match (bits, rows_of_unlit > 0) {
            (0, _) => [
                rho_grid_stamp_two,
                rho_grid_stamp_three,
                rho_grid_stamp_four,
            ],
            (6, false) => [
                rho_grid_stamp_two_64,
                rho_grid_stamp_three_64,
                rho_grid_stamp_four_64,
            ],
            (7, false) => [
                rho_grid_stamp_two_128,
                rho_grid_stamp_three_128,
                rho_grid_stamp_four_128,
            ],
            (_, false) => [
                rho_grid_stamp_two_256,
                rho_grid_stamp_three_256,
                rho_grid_stamp_four_256,
            ],
            (6, true) => [
                rho_grid_stamp_two_64_dim,
                rho_grid_stamp_three_64_dim,
                rho_grid_stamp_four_64_dim,
            ],
            (7, true) => [
                rho_grid_stamp_two_128_dim,
                rho_grid_stamp_three_128_dim,
                rho_grid_stamp_four_128_dim,
            ],
            (_, true) => [
                rho_grid_stamp_two_256_dim,
                rho_grid_stamp_three_256_dim,
                rho_grid_stamp_four_256_dim,
            ],
        },
    };
    let [two, three, four] = loops;
    let stamp_all = match rows {
        2 => two,
        3 => three,
        _ => four,
    };
    // SAFETY: the module's argument; all that is pointed to is borrowed here.
    unsafe { stamp_all(&raw mut block) };
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
    assert!(FIRST == 2);
    assert!(NORMALS == 256 && MAX_MATERIALS == 8);
    assert!(size_of::<Within>() == 4);
    assert!(FAR_AWAY == -0x1000_0000);
    assert!(TWO_SIDED == 127 && WIDTH_BITS == 7);
    assert!(core::mem::offset_of!(InLight, cells) == 28);
    assert!(size_of::<Lists>() == 5120);
    // Subcells and ranks have a byte each.
    assert!(MAX_PARENTS < 256);
};

global_asm!(
    // The tone of a sample into r7, where something may lie between it and the light; the table of
    // spread bits into r12. Takes r8 for the word and r1 for the next entry; r9 and r11 are free.
    ".macro RHO_SHADED backwards, bits, dim",
    "ldr r12, [r0, #60]",
    "lsr r9, r8, #3",
    "ldrb r7, [r12, r9]", // the tone in the light
    ".if \\dim",
    "ldr r11, [r0, #312]",
    "lsr r12, r8, #8",
    "ldrb r12, [r11, r12, lsl #3]", // and where that does not reach
    "str r12, [r0, #180]",
    ".else",
    "ldr r12, [r0, #180]",
    ".endif",
    "cmp r7, r12",
    "beq 6f", // it faces away
    "ldr r12, [r0, #184]",
    "lsr r9, r8, #6",
    "bfi r9, r8, #0, #3",
    "ldr r9, [r12, r9, lsl #2]", // what its normal and offset move it by
    ".if \\backwards",
    "ldrb r8, [r1]",
    ".else",
    "ldrb r8, [r1, #-1]",
    ".endif",
    "ldrd r11, r12, [r0, #188]",
    "and r8, r8, #15",
    "add r9, r9, r11",
    "ldr r8, [r12, r8, lsl #2]", // from its parent
    "ldr r12, [r0, #196]",
    "add r9, r9, r8",                        // its place in the light
    "ubfx r8, r9, #(11 - \\bits), #\\bits",  // u
    "ubfx r11, r9, #(22 - \\bits), #\\bits", // v
    "add r8, r8, r11, lsl #\\bits",
    "ldrh r8, [r12, r8, lsl #1]",
    "cmp r8, r9, lsr #22",
    "it lo",
    "ldrlo r7, [r0, #180]",
    "6:",
    "ldr r12, [r0, #64]",
    ".endm",
    // The same for maps of any size, under any lights, of words with or without materials.
    ".macro RHO_SHADED_ANY backwards, under",
    "ldr r12, [r0, #60]",
    "lsr r9, r8, #\\under",
    "ldrb r7, [r12, r9]", // the tone in the light
    "ldrd r11, r12, [r0, #312]",
    "and r12, r12, r8, lsr #8",
    "add r11, r11, r12, lsl #3",
    ".if \\under == 2",
    "ubfx r12, r8, #2, #3",
    "ldrb r12, [r11, r12]",
    ".else",
    "ldrb r12, [r11]",
    ".endif",
    "str r12, [r0, #180]",
    "cmp r7, r12",
    "beq 6f", // it faces away
    "ldr r12, [r0, #184]",
    "lsr r9, r8, #6",
    "bfi r9, r8, #0, #3",
    "ldr r9, [r12, r9, lsl #2]", // what its normal and offset move it by
    ".if \\backwards",
    "ldrb r8, [r1]",
    ".else",
    "ldrb r8, [r1, #-1]",
    ".endif",
    "ldrd r11, r12, [r0, #188]",
    "and r8, r8, #15",
    "add r9, r9, r11",
    "ldr r8, [r12, r8, lsl #2]", // from its parent
    "ldr r12, [r0, #196]",
    "add r9, r9, r8", // its place in the light
    "ldrd r8, r11, [r0, #320]",
    "lsr r8, r9, r8",
    "and r8, r8, r11",
    "add r12, r12, r8, lsl #1", // u
    "ldrd r8, r11, [r0, #328]",
    "lsr r8, r9, r8",
    "and r8, r8, r11", // v
    "ldrh r8, [r12, r8, lsl #1]",
    "cmp r8, r9, lsr #22",
    "it lo",
    "ldrlo r7, [r0, #180]",
    "6:",
    "ldr r12, [r0, #64]",
    ".endm",
    // Four pixels of a row: those that the sample opens become its tone. r10 the window.
    ".macro RHO_ROW bits, tone, at",
    "ldr r9, [r10, #\\at]",
    "bic \\bits, \\bits, r9",
    "mla r9, \\bits, \\tone, r9",
    "str r9, [r10, #\\at]",
    ".endm",
    // All rows: lr the mask, r12 the table of spread bits.
    ".macro RHO_ROWS rows, tone, band",
    ".if \\rows == 2",
    "add lr, r12, lr, lsl #3",
    "ldrd r11, r12, [lr]",
    ".else",
    "uxtb r9, lr",
    "lsr lr, lr, #8",
    "add r9, r12, r9, lsl #3",
    "add lr, r12, lr, lsl #3",
    "ldrd r11, r12, [r9]",
    ".endif",
    "RHO_ROW r11, \\tone, 0",
    "RHO_ROW r12, \\tone, 240*(1+\\band)",
    ".if \\rows == 3",
    "ldr r11, [lr]",
    "RHO_ROW r11, \\tone, 480*(1+\\band)",
    ".endif",
    ".if \\rows == 4",
    "ldrd r11, r12, [lr]",
    "RHO_ROW r11, \\tone, 480*(1+\\band)",
    "RHO_ROW r12, \\tone, 720*(1+\\band)",
    ".endif",
    ".endm",
    // Whether one of a row's pixels is open and in the frame: NE. Changes r7 and lr.
    ".macro RHO_OPEN row, band",
    "ldr r7, [r0, #240]",
    "ldr lr, [r0, #64]",
    "ubfx r7, r7, #(4 * \\row), #4",
    "ldr r7, [lr, r7, lsl #3]",
    "ldr lr, [r10, #(\\row * 240 * (1 + \\band))]",
    "bics r7, r7, lr",
    ".endm",
    // Goes on at 5 if one of a row's pixels would show the sample. r5 its depth, r6 the first pixel's;
    // r7 what is in the frame.
    ".macro RHO_SHOWS row, cut",
    ".irp column, 0, 1, 2, 3",
    ".if \\cut",
    "tst r7, #(1 << (4 * \\row + \\column))",
    "beq 8f",
    ".endif",
    "ldrh lr, [r6, #(480 * \\row + 2 * \\column)]",
    "cmp r5, lr",
    "blo 5f",
    "8:",
    ".endr",
    ".endm",
    // A pixel of a mask (the lowest bits of lr), that many bits on, if the sample is nearer than its depth.
    // r8 tone, r9 depth, r10 the window's pixels, r12 its depths.
    ".macro RHO_DEEP_PIXEL bits, row, column",
    "lsrs lr, lr, #\\bits",
    "bcc 8f",
    "ldrh r11, [r12, #(480 * \\row + 2 * \\column)]",
    "cmp r9, r11",
    "itt lo",
    "strhlo r9, [r12, #(480 * \\row + 2 * \\column)]",
    "strblo r8, [r10, #(240 * \\row + \\column)]",
    "8:",
    ".endm",
    // A row of it, whose last columns are empty if rows are few.
    ".macro RHO_DEEP_ROW rows, row",
    ".if \\row",
    "RHO_DEEP_PIXEL (5 - \\rows), \\row, 0",
    ".else",
    "RHO_DEEP_PIXEL 1, \\row, 0",
    ".endif",
    "RHO_DEEP_PIXEL 1, \\row, 1",
    ".if \\rows > 2",
    "RHO_DEEP_PIXEL 1, \\row, 2",
    ".endif",
    ".if \\rows > 3",
    "RHO_DEEP_PIXEL 1, \\row, 3",
    ".endif",
    ".endm",
    ".macro RHO_DEEP_ROWS rows",
    "ldr r12, [r0, #296]",
    "ldr r9, [r0, #300]",
    "add r12, r12, r10, lsl #1",
    "RHO_DEEP_ROW \\rows, 0",
    "RHO_DEEP_ROW \\rows, 1",
    ".if \\rows > 2",
    "RHO_DEEP_ROW \\rows, 2",
    ".endif",
    ".if \\rows > 3",
    "RHO_DEEP_ROW \\rows, 3",
    ".endif",
    ".endm",
    // One sample. r0 block, r1 next entry, r2 end, r3 place, r4 words, r5 classes, r6 half-planes,
    // r7 corner; r8 to r12 and lr are free.
    ".macro RHO_SAMPLES rows, backwards, under, shaded, band, cut, deep",
    "1:",
    ".if \\backwards",
    "ldrb r8, [r1, #-1]!",
    ".else",
    "ldrb r8, [r1], #1",
    ".endif",
    "and r9, r8, #15",
    ".if \\deep",
    "add lr, r0, r9, lsl #2",
    "ldr r10, [r0, #288]",
    "ldr lr, [lr, #236]",
    "ldr r11, [r0, #292]",
    "add r10, r10, lr", // its W
    "umull lr, r10, r10, r11",
    "str r10, [r0, #300]",
    ".endif",
    "lsr r8, r8, #4",
    "ldr r9, [r0, r9, lsl #2]",  // from the plane's middle
    "ldrh r8, [r4, r8, lsl #1]", // the attribute word
    "add r9, r9, r3",
    "and r10, r8, #7",
    "ldrsb r10, [r0, r10]", // the offset
    "lsr r11, r8, #7",
    "add r11, r5, r11, lsl #3",
    "ldrd r11, r12, [r11]", // across, towards
    "mla r9, r11, r10, r9", // the place
    ".if \\cut",
    "ldrd r10, lr, [r0, #232]",
    "str r10, [r0, #240]",
    "lsr r10, r9, #26",
    "add r10, lr, r10, lsl #2",
    "ldr lr, [r0, #240]",
    "ldrh r10, [r10, #2]", // its rows in the frame
    "str r10, [r0, #240]",
    "ubfx r10, r9, #10, #6",
    "ldrh lr, [lr, r10, lsl #2]", // its columns
    "ldr r10, [r0, #240]",
    "ands r10, r10, lr",
    "beq 4f",
    "str r10, [r0, #240]",
    ".endif",
    "ubfx r10, r9, #10, #6",
    "lsr lr, r9, #26",
    "rsb lr, lr, lr, lsl #4",
    "add r10, r10, r7",
    "add r10, r10, lr, lsl #(4+\\band)", // corner + 240 y + x, or 480 y
    ".if \\band",
    "ldr lr, [r0, #216]",
    "cmp r10, lr",
    "bhs 4f",
    "ldr lr, [r0, #212]",
    "add r10, r10, lr",
    ".endif",
    "ldr lr, [r0, #44]",
    "mla r11, r11, lr, r12", // the cosine
    "adds r11, r11, #0",     // clears the carry
    "bmi 3f",
    "2:",
    "ldr lr, [r0, #48]",
    "umull lr, r11, r11, lr", // half the strip's width
    "and r12, r12, #15",
    "ldr lr, [r0, #52]",
    "add r12, lr, r12, lsl #3",
    "ldrd lr, r12, [r12]",     // across the strip, base
    "bic r9, r9, #0xFC00FC00", // the parts of a pixel
    "mul lr, lr, r9",
    "add lr, lr, #0x02000000",
    "add r12, r12, lr, asr #26",
    "add lr, r12, r11",
    "sbc r12, r12, r11", // one less, the carry being clear
    "ldrh lr, [r6, lr, lsl #1]",
    "ldrh r12, [r6, r12, lsl #1]",
    "bic lr, lr, r12", // the strip
    ".if \\rows == 2",
    "ubfx r12, r9, #6, #4",
    "ubfx r9, r9, #22, #4",
    "add r12, r12, r9, lsl #4",
    "ldr r9, [r0, #56]",
    "ldrb r12, [r9, r12]",
    ".else",
    "ubfx r12, r9, #7, #3",
    "ubfx r9, r9, #23, #3",
    "add r12, r12, r9, lsl #3",
    "ldr r9, [r0, #56]",
    "ldrh r12, [r9, r12, lsl #1]",
    ".endif",
    ".if \\cut",
    "ldr r9, [r0, #240]",
    "and r12, r12, r9",
    ".endif",
    "ands lr, lr, r12", // the mask
    "beq 4f",
    ".if \\shaded",
    ".if \\shaded == 32",
    "RHO_SHADED_ANY \\backwards, \\under",
    ".else",
    "RHO_SHADED \\backwards, (\\shaded & 15), (\\shaded >> 4)",
    ".endif",
    ".if \\deep",
    "mov r8, r7",
    "RHO_DEEP_ROWS \\rows",
    ".else",
    "RHO_ROWS \\rows, r7, \\band",
    ".endif",
    "ldr r7, [r0, #76]",
    ".else",
    "ldrd r11, r12, [r0, #60]",
    "lsr r8, r8, #\\under",
    "ldrb r8, [r11, r8]", // the tone
    ".if \\deep",
    "RHO_DEEP_ROWS \\rows",
    ".else",
    "RHO_ROWS \\rows, r8, \\band",
    ".endif",
    ".endif",
    "4:",
    "cmp r1, r2",
    "bne 1b",
    "ldr pc, [sp], #4",
    "3:", // it faces away
    "ldr lr, [r0, #228]",
    "cmp lr, #127",
    "beq 7f",
    "cmn r11, #0x10000000",
    "blt 4b",
    "7:",
    ".if \\deep",
    "ldr r5, [r0, #300]",
    "ldr r6, [r0, #296]",
    "add r6, r6, r10, lsl #1",
    ".if \\cut",
    "ldr r7, [r0, #240]",
    ".endif",
    "RHO_SHOWS (\\rows / 2), \\cut",
    "RHO_SHOWS (\\rows / 2 - 1), \\cut",
    "add r5, r0, #68",
    "ldm r5, {{r5, r6, r7}}",
    "b 4b",
    "5:",
    "add r5, r0, #68",
    "ldm r5, {{r5, r6, r7}}",
    ".elseif \\cut",
    "RHO_OPEN (\\rows / 2), \\band",
    "bne 5f",
    "RHO_OPEN (\\rows / 2 - 1), \\band",
    "bne 5f",
    "ldr r7, [r0, #76]",
    "b 4b",
    "5:",
    "ldr r7, [r0, #76]",
    ".else",
    "ldr lr, [r10, #(\\rows / 2 * 240 * (1 + \\band))]",
    "mvn lr, lr",
    "tst lr, #0x01010101",
    "bne 5f",
    "ldr lr, [r10, #((\\rows / 2 - 1) * 240 * (1 + \\band))]",
    "mvn lr, lr",
    "tst lr, #0x01010101",
    "beq 4b",
    "5:",
    ".endif",
    "rsbs r11, r11, #0", // clears the carry: it is negative
    "b 2b",
    ".endm",
    // A plane: r1 its nine bits, r3 its place, r4 its words.
    ".macro RHO_PLANE rows, backwards, under, shaded, band, cut, deep",
    "cbnz r1, 5f",
    "bx lr",
    "5:",
    "str lr, [sp, #-4]!",
    "add r1, r1, r1, lsl #2",
    "ldr r2, [r0, #80]",
    "add r1, r2, r1, lsl #1",
    "ldrb r2, [r1], #1",
    ".if \\backwards",
    "mov r8, r1",
    "add r1, r1, r2",
    "mov r2, r8",
    ".else",
    "add r2, r2, r1",
    ".endif",
    "RHO_SAMPLES \\rows, \\backwards, \\under, \\shaded, \\band, \\cut, \\deep",
    ".endm",
    // Before a plane: its W; its displacements in the light, so many bytes from the first plane's.
    ".macro RHO_BEFORE at, shaded, deep",
    ".if \\deep",
    "ldrd r8, r9, [r0, #280]",
    ".if \\at == 0",
    "sub r9, r9, r8",
    ".elseif \\at == 72",
    "add r9, r9, r8",
    ".endif",
    "str r9, [r0, #288]",
    ".endif",
    ".if \\shaded",
    "ldr r8, [r0, #208]",
    ".if \\at",
    "add r8, r8, #\\at",
    ".endif",
    "str r8, [r0, #192]",
    ".endif",
    ".endm",
    // Goes on at 12 if all pixels that a parent's samples may reach are nearer than any of them. r3 its
    // place, r7 corner. (Of what reaches the edge, none is asked.)
    ".macro RHO_HIDDEN rows, cut, deep",
    ".if \\deep && !\\cut",
    "ldrd r9, r2, [r0, #304]",
    "ldr r8, [r0, #284]",
    "ldr r10, [r0, #292]",
    "sub r8, r8, r9",
    "umull r9, r8, r8, r10", // the least depth
    "sub r1, r3, r2",
    "add r2, r3, r2",
    "ubfx r9, r1, #10, #6",
    "ubfx r10, r2, #10, #6",
    "lsr r1, r1, #26",
    "lsr r2, r2, #26",
    "subs r10, r10, r9",
    "bmi 15f",
    "subs r2, r2, r1",
    "bmi 15f",
    "add r10, r10, #\\rows", // columns
    "add r2, r2, #\\rows",   // rows
    "rsb r1, r1, r1, lsl #4",
    "add r9, r9, r7",
    "add r9, r9, r1, lsl #4",
    "ldr r1, [r0, #296]",
    "add r9, r1, r9, lsl #1",
    "13:",
    "add r1, r9, r10, lsl #1",
    "14:",
    "ldrh lr, [r1, #-2]!",
    "cmp lr, r8",
    "bhi 15f",
    "cmp r1, r9",
    "bne 14b",
    "add r9, r9, #480",
    "subs r2, r2, #1",
    "bne 13b",
    "b 12f",
    "15:",
    ".endif",
    ".endm",
    // All parents; shadows are looked up in a map of 2^shaded texels a side, if that is not 0, and with 16
    // more under several lights; of 32, in whatever map there is.
    // Registers are saved for the caller, as its convention wants.
    ".macro RHO_BLOCK name, rows, under, shaded, band=0, cut=0, deep=0",
    ".section .text.\\name,\"ax\",%progbits",
    ".global \\name",
    ".type \\name,%function",
    ".thumb_func",
    "\\name:",
    "push {{r4-r11, lr}}",
    "add r1, r0, #68",
    "ldm r1, {{r5, r6, r7}}",
    "ldr r1, [r0, #132]",
    "10:",
    "ldr r12, [r1], #4", // order, subcell, rank
    "str r1, [r0, #132]",
    "ldr r11, [r0, #128]",
    "uxtb r1, r12",
    "ldr r2, [r0, #220]",
    "add r11, r11, r1", // the node
    "cbz r2, 9f",
    "ldrh r2, [r2, r11, lsl #1]", // its cone
    "ldr lr, [r0, #44]",
    "and r3, r2, #127",
    "str r3, [r0, #228]",
    "lsr r2, r2, #7",
    "add r2, r5, r2, lsl #3",
    "ldrd r8, r9, [r2]",
    "mla r8, r8, lr, r9", // towards
    "ldr r9, [r0, #224]",
    "mul r9, r9, r3",
    "cmn r8, r9",
    "blt 12f", // all of it faces away
    "9:",
    "ubfx r1, r12, #8, #8",
    ".if \\shaded",
    "ldr r2, [r0, #204]",
    "ldr r3, [r0, #200]",
    "ldr r2, [r2, r1, lsl #2]",
    "add r2, r2, r3",
    "str r2, [r0, #188]", // the parent in the light
    ".endif",
    "ldr r2, [r0, #108]",
    "add r1, r1, r1, lsl #1",
    "add r1, r2, r1, lsl #2",
    "ldm r1, {{r1, r2, r3}}", // the displacement
    "add lr, r0, #96",
    "ldm lr, {{r8, r9, r10}}",
    "add r1, r1, r8",
    "add r2, r2, r9",
    "add r3, r3, r10",
    ".if \\deep",
    "str r3, [r0, #284]",
    ".endif",
    "clz r8, r3",
    "lsl r3, r3, r8",
    "lsr r3, r3, #16",
    "mvn r9, #0",
    "udiv r3, r9, r3",
    "ldr r9, [r0, #92]",
    "lsl r3, r3, #14",
    "sub r8, r9, r8",
    "smull lr, r1, r1, r3",
    "smull lr, r2, r2, r3",
    "asr r1, r1, r8",
    "asr r2, r2, r8",
    "ldr r3, [r0, #88]",
    "add r3, r3, r1, lsl #2",
    "add r3, r3, r2, lsl #18", // the middle plane's place
    "RHO_HIDDEN \\rows, \\cut, \\deep",
    "mov r1, r11",
    "add r2, r0, #112",
    "ldm r2, {{r8, r9, r10, r11}}",
    "ldr r8, [r8, r1, lsl #2]", // its mask
    "lsr r2, r1, #9",
    "ldr r9, [r9, r2, lsl #2]",
    "ldrh r10, [r10, r1, lsl #1]",
    "add r9, r9, r10",
    "add r11, r11, r9, lsl #1", // its first child's word
    "ldr r9, [r0, #140]",
    "tst r12, #0x10000",
    "it ne",
    "addne r9, r9, #5120",
    "str r9, [r0, #80]",
    // low: r1 bits, r2 place, r3 words; mid: r4, r8, r9; high: r10, r11, r12.
    "push {{r5, r6, r7, r12}}",
    "ldr r6, [r0, #84]",
    "ubfx r1, r8, #0, #9",
    "ubfx r4, r8, #9, #9",
    "ubfx r10, r8, #18, #9",
    "add r5, r1, r1, lsl #2",
    "ldrb r5, [r9, r5, lsl #1]",
    "add r7, r4, r4, lsl #2",
    "ldrb r7, [r9, r7, lsl #1]",
    "mov r8, r3",
    "sub r2, r3, r6",
    "mov r3, r11",
    "add r9, r11, r5, lsl #1",
    "add r11, r8, r6",
    "add r12, r9, r7, lsl #1",
    "add r5, r0, #144",
    "stm r5, {{r1, r2, r3, r4, r8, r9, r10, r11, r12}}",
    "pop {{r5, r6, r7, r12}}",
    "tst r12, #0x20000",
    "bne 20f",
    "tst r12, #0x40000",
    "bne 11f",
    "RHO_BEFORE 0, \\shaded, \\deep",
    "add r2, r0, #144",
    "ldm r2, {{r1, r3, r4}}",
    "bl 30f",
    "RHO_BEFORE 36, \\shaded, \\deep",
    "add r2, r0, #156",
    "ldm r2, {{r1, r3, r4}}",
    "bl 30f",
    "RHO_BEFORE 72, \\shaded, \\deep",
    "add r2, r0, #168",
    "ldm r2, {{r1, r3, r4}}",
    "bl 30f",
    "b 12f",
    "11:",
    "RHO_BEFORE 72, \\shaded, \\deep",
    "add r2, r0, #168",
    "ldm r2, {{r1, r3, r4}}",
    "bl 30f",
    "RHO_BEFORE 36, \\shaded, \\deep",
    "add r2, r0, #156",
    "ldm r2, {{r1, r3, r4}}",
    "bl 30f",
    "RHO_BEFORE 0, \\shaded, \\deep",
    "add r2, r0, #144",
    "ldm r2, {{r1, r3, r4}}",
    "bl 30f",
    "12:",
    "ldrd r1, r2, [r0, #132]",
    "cmp r1, r2",
    "bne 10b",
    "pop {{r4-r11, pc}}",
    "20:",
    "tst r12, #0x40000",
    "bne 21f",
    "RHO_BEFORE 0, \\shaded, \\deep",
    "add r2, r0, #144",
    "ldm r2, {{r1, r3, r4}}",
    "bl 40f",
    "RHO_BEFORE 36, \\shaded, \\deep",
    "add r2, r0, #156",
    "ldm r2, {{r1, r3, r4}}",
    "bl 40f",
    "RHO_BEFORE 72, \\shaded, \\deep",
    "add r2, r0, #168",
    "ldm r2, {{r1, r3, r4}}",
    "bl 40f",
    "b 12b",
    "21:",
    "RHO_BEFORE 72, \\shaded, \\deep",
    "add r2, r0, #168",
    "ldm r2, {{r1, r3, r4}}",
    "bl 40f",
    "RHO_BEFORE 36, \\shaded, \\deep",
    "add r2, r0, #156",
    "ldm r2, {{r1, r3, r4}}",
    "bl 40f",
    "RHO_BEFORE 0, \\shaded, \\deep",
    "add r2, r0, #144",
    "ldm r2, {{r1, r3, r4}}",
    "bl 40f",
    "b 12b",
    "30:",
    "RHO_PLANE \\rows, 0, \\under, \\shaded, \\band, \\cut, \\deep",
    "40:",
    "RHO_PLANE \\rows, 1, \\under, \\shaded, \\band, \\cut, \\deep",
    ".size \\name, . - \\name",
    ".endm",
    ".syntax unified",
    "RHO_BLOCK rho_grid_stamp_two, 2, 3, 0",
    "RHO_BLOCK rho_grid_stamp_three, 3, 3, 0",
    "RHO_BLOCK rho_grid_stamp_four, 4, 3, 0",
    "RHO_BLOCK rho_grid_stamp_band_two, 2, 3, 0, 1",
    "RHO_BLOCK rho_grid_stamp_band_three, 3, 3, 0, 1",
    "RHO_BLOCK rho_grid_stamp_band_four, 4, 3, 0, 1",
    "RHO_BLOCK rho_grid_stamp_both_two, 2, 2, 0",
    "RHO_BLOCK rho_grid_stamp_both_three, 3, 2, 0",
    "RHO_BLOCK rho_grid_stamp_both_four, 4, 2, 0",
    "RHO_BLOCK rho_grid_stamp_two_cut, 2, 3, 0, 0, 1",
    "RHO_BLOCK rho_grid_stamp_three_cut, 3, 3, 0, 0, 1",
    "RHO_BLOCK rho_grid_stamp_four_cut, 4, 3, 0, 0, 1",
    "RHO_BLOCK rho_grid_stamp_band_two_cut, 2, 3, 0, 1, 1",
    "RHO_BLOCK rho_grid_stamp_band_three_cut, 3, 3, 0, 1, 1",
    "RHO_BLOCK rho_grid_stamp_band_four_cut, 4, 3, 0, 1, 1",
    "RHO_BLOCK rho_grid_stamp_both_two_cut, 2, 2, 0, 0, 1",
    "RHO_BLOCK rho_grid_stamp_both_three_cut, 3, 2, 0, 0, 1",
    "RHO_BLOCK rho_grid_stamp_both_four_cut, 4, 2, 0, 0, 1",
    "RHO_BLOCK rho_grid_stamp_deep_two, 2, 3, 0, 0, 0, 1",
    "RHO_BLOCK rho_grid_stamp_deep_three, 3, 3, 0, 0, 0, 1",
    "RHO_BLOCK rho_grid_stamp_deep_four, 4, 3, 0, 0, 0, 1",
    "RHO_BLOCK rho_grid_stamp_deep_both_two, 2, 2, 0, 0, 0, 1",
    "RHO_BLOCK rho_grid_stamp_deep_both_three, 3, 2, 0, 0, 0, 1",
    "RHO_BLOCK rho_grid_stamp_deep_both_four, 4, 2, 0, 0, 0, 1",
    "RHO_BLOCK rho_grid_stamp_deep_two_cut, 2, 3, 0, 0, 1, 1",
    "RHO_BLOCK rho_grid_stamp_deep_three_cut, 3, 3, 0, 0, 1, 1",
    "RHO_BLOCK rho_grid_stamp_deep_four_cut, 4, 3, 0, 0, 1, 1",
    "RHO_BLOCK rho_grid_stamp_deep_both_two_cut, 2, 2, 0, 0, 1, 1",
    "RHO_BLOCK rho_grid_stamp_deep_both_three_cut, 3, 2, 0, 0, 1, 1",
    "RHO_BLOCK rho_grid_stamp_deep_both_four_cut, 4, 2, 0, 0, 1, 1",
    "RHO_BLOCK rho_grid_stamp_two_64_dim, 2, 3, 22",
    "RHO_BLOCK rho_grid_stamp_two_128_dim, 2, 3, 23",
    "RHO_BLOCK rho_grid_stamp_two_256_dim, 2, 3, 24",
    "RHO_BLOCK rho_grid_stamp_three_64_dim, 3, 3, 22",
    "RHO_BLOCK rho_grid_stamp_three_128_dim, 3, 3, 23",
    "RHO_BLOCK rho_grid_stamp_three_256_dim, 3, 3, 24",
    "RHO_BLOCK rho_grid_stamp_four_64_dim, 4, 3, 22",
    "RHO_BLOCK rho_grid_stamp_four_128_dim, 4, 3, 23",
    "RHO_BLOCK rho_grid_stamp_four_256_dim, 4, 3, 24",
    "RHO_BLOCK rho_grid_stamp_shaded_two_cut, 2, 3, 32, 0, 1, 0",
    "RHO_BLOCK rho_grid_stamp_shaded_three_cut, 3, 3, 32, 0, 1, 0",
    "RHO_BLOCK rho_grid_stamp_shaded_four_cut, 4, 3, 32, 0, 1, 0",
    "RHO_BLOCK rho_grid_stamp_shaded_both_two, 2, 2, 32, 0, 0, 0",
    "RHO_BLOCK rho_grid_stamp_shaded_both_three, 3, 2, 32, 0, 0, 0",
    "RHO_BLOCK rho_grid_stamp_shaded_both_four, 4, 2, 32, 0, 0, 0",
    "RHO_BLOCK rho_grid_stamp_shaded_both_two_cut, 2, 2, 32, 0, 1, 0",
    "RHO_BLOCK rho_grid_stamp_shaded_both_three_cut, 3, 2, 32, 0, 1, 0",
    "RHO_BLOCK rho_grid_stamp_shaded_both_four_cut, 4, 2, 32, 0, 1, 0",
    "RHO_BLOCK rho_grid_stamp_shaded_deep_two, 2, 3, 32, 0, 0, 1",
    "RHO_BLOCK rho_grid_stamp_shaded_deep_three, 3, 3, 32, 0, 0, 1",
    "RHO_BLOCK rho_grid_stamp_shaded_deep_four, 4, 3, 32, 0, 0, 1",
    "RHO_BLOCK rho_grid_stamp_shaded_deep_two_cut, 2, 3, 32, 0, 1, 1",
    "RHO_BLOCK rho_grid_stamp_shaded_deep_three_cut, 3, 3, 32, 0, 1, 1",
    "RHO_BLOCK rho_grid_stamp_shaded_deep_four_cut, 4, 3, 32, 0, 1, 1",
    "RHO_BLOCK rho_grid_stamp_shaded_deep_both_two, 2, 2, 32, 0, 0, 1",
    "RHO_BLOCK rho_grid_stamp_shaded_deep_both_three, 3, 2, 32, 0, 0, 1",
    "RHO_BLOCK rho_grid_stamp_shaded_deep_both_four, 4, 2, 32, 0, 0, 1",
    "RHO_BLOCK rho_grid_stamp_shaded_deep_both_two_cut, 2, 2, 32, 0, 1, 1",
    "RHO_BLOCK rho_grid_stamp_shaded_deep_both_three_cut, 3, 2, 32, 0, 1, 1",
    "RHO_BLOCK rho_grid_stamp_shaded_deep_both_four_cut, 4, 2, 32, 0, 1, 1",
    "RHO_BLOCK rho_grid_stamp_two_64, 2, 3, 6",
    "RHO_BLOCK rho_grid_stamp_three_64, 3, 3, 6",
    "RHO_BLOCK rho_grid_stamp_four_64, 4, 3, 6",
    "RHO_BLOCK rho_grid_stamp_two_128, 2, 3, 7",
    "RHO_BLOCK rho_grid_stamp_three_128, 3, 3, 7",
    "RHO_BLOCK rho_grid_stamp_four_128, 4, 3, 7",
    "RHO_BLOCK rho_grid_stamp_two_256, 2, 3, 8",
    "RHO_BLOCK rho_grid_stamp_three_256, 3, 3, 8",
    "RHO_BLOCK rho_grid_stamp_four_256, 4, 3, 8",
);
