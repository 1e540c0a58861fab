//! Where a sample is, from its cell's centre: by its offset along the normal, and by a bias.
//!
//! A flat splat stands out of a surface that is not perpendicular to the light, and a disc's one look-up
//! serves all of its pixels. So that no surface shades itself, samples that are looked up are moved
//! outwards, by texels and by cells; splats inwards, by half of what they reach beyond a silhouette.

use super::view::pack;
use crate::blob::Layout;
use crate::normal::{COUNT, FACES, OCTANT};

/// Normals that are moved alike are told apart by their upper seven bits.
const CLASSES: usize = 128;
/// Normals of a class.
const ALIKE: usize = COUNT / CLASSES;
/// Offsets that there are for each.
const OFFSETS: usize = 8;

/// How far samples are moved in the light's space, so that none shades itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bias {
    /// Outwards along the normal, 256ths of a texel.
    pub texels: i32,
    /// And 256ths of a cell's side.
    pub cells: i32,
    /// Towards the light, 256ths of a texel's side.
    pub towards: i32,
    /// Back along u and v, halves of a texel.
    pub back: i32,
}

impl Bias {
    /// Of samples that are looked up.
    pub const LOOKED_UP: Self = Self {
        texels: 128,
        cells: 128,
        towards: 128,
        back: 0,
    };

    /// Of samples that lay splats of `side` x `side` texels, from the first of which they count.
    #[must_use]
    pub const fn splat(side: usize) -> Self {
        Self {
            texels: -80 * side as i32,
            cells: 0,
            towards: 0,
            back: side as i32 - 1,
        }
    }
}

/// The lengths of a map, in units of 2^-8 of u and v.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lengths {
    /// A texel's side.
    pub(super) texel: i32,
    /// A cell's side.
    pub(super) cell: i32,
    /// A side of the cube, Q16, across and in depth: the same length has other units in depth.
    pub(super) scale: [i64; 2],
}

/// By class of normal and offset, a displacement ([`super::view`]); and where an attribute word has the
/// two.
#[derive(Clone, Debug)]
pub(super) struct Moved {
    by_normal: [[u32; OFFSETS]; CLASSES],
    /// Shift from a word to its class; its offset is the lowest of it.
    to_class: u32,
}

impl Moved {
    /// Not yet filled.
    pub(super) const NONE: Self = Self {
        by_normal: [[0; OFFSETS]; CLASSES],
        to_class: 0,
    };

    pub(super) fn fill(
        &mut self,
        layout: Layout,
        axes: &[[i32; 3]; 3],
        lengths: Lengths,
        bias: Bias,
    ) {
        let under_normal = u32::from(layout.offset + layout.material);
        self.to_class = (under_normal + u32::from(layout.normal) - CLASSES.ilog2()) & 31;

        let Lengths { texel, cell, scale } = lengths;
        let [across, depth] = scale;
        // Up to 256 units, far more than a map's margin.
        let bounded = |length: i64| length.clamp(-(1 << 16), 1 << 16) as i32;
        let deep = |length: i32| bounded(i64::from(length) * depth / across);
        let outwards = (texel * bias.texels + cell * bias.cells) >> 8;
        let lengths: [(i32, i32); OFFSETS] = core::array::from_fn(|step| {
            // Bits above those of the offset are ignored: entries repeat.
            let offset = layout.offset_q8(step as u32);
            let length = bounded((outwards + ((cell * offset) >> 8)).into());
            (length, deep(length))
        });
        // Q22, as the products of lengths and Q14.
        let towards = deep((texel * bias.towards) >> 8) << 14;
        let back = (texel * bias.back) << 13;
        for (octant, moved) in self.by_normal.chunks_mut(OCTANT / ALIKE).enumerate() {
            // A component is negative where its bit is set, and so are its products with the axes.
            let sign = |bit: usize, v: i32| if octant & bit == 0 { v } else { -v };
            let axes = axes.map(|[x, y, z]| [sign(4, x), sign(2, y), sign(1, z)]);
            for (face, moved) in FACES.iter().step_by(ALIKE).zip(moved) {
                let [x, y, z] = face.map(i32::from);
                let [u, v, d] = axes.map(|[ax, ay, az]| (ax * x + ay * y + az * z) >> 14);
                for (moved, (length, deep)) in moved.iter_mut().zip(lengths) {
                    *moved = pack::<22>([u * length - back, v * length - back, d * deep - towards]);
                }
            }
        }
    }

    /// The displacements, if a word's class is in its upper seven bits, and its offset in the lowest three
    /// (or of no matter).
    #[cfg(rho_thumb)]
    pub(in crate::render) fn table(&self) -> Option<&[[u32; OFFSETS]; CLASSES]> {
        (self.to_class == 9).then_some(&self.by_normal)
    }

    /// From its cell's centre to where the sample with this attribute word is.
    #[inline(always)]
    pub(super) fn of(&self, word: u32) -> u32 {
        let class = (word >> self.to_class) as usize % CLASSES;
        let offset = word as usize % OFFSETS;
        let moved = self.by_normal.get(class).and_then(|m| m.get(offset));
        moved.copied().unwrap_or(0)
    }
}
