//! One rho-grid of a blob: levels of nodes, their masks, children and attribute words.

use super::facing::{BACKS_BYTES, Backs};
use super::format::{
    BASE_NODES, GRID_BYTES, MAX_CELLS, MAX_SUBDIVISIONS, children_words, kind, mask_words,
};
use super::{Blob, BlobError, Layout, u32_at};

/// A recursive grid in flash (paper, section 4.2).
///
/// Holding one proves that every child mask is non-empty and names subcells of its rho only, that
/// every node's children exist in the next level, and that every attribute word names a material
/// of the blob: no accessor can fail.
#[derive(Clone, Copy, Debug)]
pub struct Grid<'a> {
    subdivisions: usize,
    separation: u8,
    layout: Layout,
    levels: [Level<'a>; MAX_SUBDIVISIONS],
    first_sampled: usize,
    nodes: u32,
    leaves: u32,
    attributes: Attributes<'a>,
    backs: Option<Backs<'a>>,
}

/// Attribute words, breadth first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Attributes<'a> {
    /// Of 16 bits.
    Halves(&'a [u16]),
    /// Of 32 bits.
    Words(&'a [u32]),
}

impl<'a> Attributes<'a> {
    /// Those of 16 bits; none when they have 32.
    #[inline(always)]
    pub(crate) fn halves(self) -> &'a [u16] {
        match self {
            Self::Halves(halves) => halves,
            Self::Words(_) => &[],
        }
    }

    /// Those of 32 bits; none when they have 16.
    #[inline(always)]
    pub(crate) fn words(self) -> &'a [u32] {
        match self {
            Self::Halves(_) => &[],
            Self::Words(words) => words,
        }
    }

    /// All from this one on.
    #[inline(always)]
    pub(crate) fn after(self, first: u32) -> Self {
        let first = first as usize;
        match self {
            Self::Halves(halves) => Self::Halves(halves.get(first..).unwrap_or_default()),
            Self::Words(words) => Self::Words(words.get(first..).unwrap_or_default()),
        }
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Halves(words) => words.len(),
            Self::Words(words) => words.len(),
        }
    }

    /// Whether there are none; a grid has some.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The nodes of one level above the leaves.
#[derive(Clone, Copy, Debug, Default)]
pub struct Level<'a> {
    /// Its cells are divided into rho x rho x rho, 2 to 5.
    pub rho: u8,
    /// Number of nodes.
    pub nodes: u32,
    /// The index of the first node's attribute word, the others follow; 0 where nodes have none.
    pub first: u32,
    pub(crate) masks: &'a [u32],
    pub(crate) bases: &'a [u32],
    pub(crate) offsets: &'a [u16],
    /// The cone of each node ([`super::facing`]); none of a grid that does not tell.
    pub(crate) cones: &'a [u16],
}

impl<'a> Level<'a> {
    /// The child mask of `node`, bit `i + rho j + rho rho k` for subcell (i, j, k); `RHO` must be
    /// this level's rho.
    #[inline(always)]
    #[must_use]
    pub fn mask<const RHO: usize>(&self, node: u32) -> [u32; 4] {
        let n = node as usize;
        let word = |i: usize| self.masks.get(i).copied().unwrap_or(0);
        match RHO {
            2 => [(word(n >> 2) >> (8 * (n & 3))) & 0xFF, 0, 0, 0],
            3 => [word(n), 0, 0, 0],
            4 => [word(2 * n), word(2 * n + 1), 0, 0],
            _ => [
                word(4 * n),
                word(4 * n + 1),
                word(4 * n + 2),
                word(4 * n + 3),
            ],
        }
    }

    /// The first child of `node`, numbered within the next level.
    #[inline(always)]
    #[must_use]
    pub fn first_child(&self, node: u32) -> u32 {
        let n = node as usize;
        let base = self.bases.get(n / BASE_NODES).copied().unwrap_or(0);
        base.wrapping_add(u32::from(self.offsets.get(n).copied().unwrap_or(0)))
    }

    /// The same for a level of any rho.
    #[inline(always)]
    #[must_use]
    pub fn mask_any(&self, node: u32) -> [u32; 4] {
        match self.rho {
            2 => self.mask::<2>(node),
            3 => self.mask::<3>(node),
            4 => self.mask::<4>(node),
            _ => self.mask::<5>(node),
        }
    }
}

/// The layout in a grid's description.
pub(super) fn layout(head: &[u8]) -> Layout {
    let byte = |at: usize| head.get(at).copied().unwrap_or(0);
    Layout {
        word_bytes: byte(2),
        normal: byte(3),
        offset: byte(4),
        material: byte(5),
        colour: byte(6),
        offset_range: byte(7),
    }
}

/// How fine a grid is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fineness {
    /// Leaves along an axis.
    pub cells: u32,
    /// Leaves that have a sample.
    pub leaves: u32,
}

/// That in a grid's description.
pub(super) fn fineness(head: &[u8]) -> Fineness {
    let byte = |at: usize| head.get(at).copied().unwrap_or(0);
    let subdivisions = usize::from(byte(0)).min(MAX_SUBDIVISIONS);
    let rhos = (0..subdivisions).map(|level| u32::from(byte(8 + level)));
    Fineness {
        cells: rhos.product(),
        leaves: u32_at(head, 20 + 4 * subdivisions),
    }
}

impl<'a> Grid<'a> {
    /// How often the root is subdivided, 1 to 12; leaves are at this level.
    #[must_use]
    pub fn subdivisions(&self) -> usize {
        self.subdivisions
    }

    /// 26 or 6: whether a leaf is any cell that the surface meets, or only one whose central cross
    /// it crosses ("thin").
    #[must_use]
    pub fn separation(&self) -> u8 {
        self.separation
    }

    /// What the bits of an attribute word mean.
    #[must_use]
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// The levels above the leaves, the root first.
    #[must_use]
    pub fn levels(&self) -> &[Level<'a>] {
        self.levels.get(..self.subdivisions).unwrap_or_default()
    }

    /// Number of leaf samples.
    #[must_use]
    pub fn leaf_samples(&self) -> u32 {
        self.leaves
    }

    /// The level from which on nodes have samples: 0 all of them, [`Self::subdivisions`] the leaves
    /// alone. Cells above are never drawn from their own sample, however small.
    #[must_use]
    pub fn first_sampled(&self) -> usize {
        self.first_sampled
    }

    /// The index of the first leaf's attribute word.
    #[must_use]
    pub fn first_leaf(&self) -> u32 {
        self.attributes.len() as u32 - self.leaves
    }

    /// Number of nodes over all levels, the root and the leaves among them.
    #[must_use]
    pub fn nodes(&self) -> u32 {
        self.nodes
    }

    /// The attribute words of all nodes that have a sample.
    #[must_use]
    pub fn attributes(&self) -> Attributes<'a> {
        self.attributes
    }

    /// Attribute word `index`: a node's number within its level after [`Level::first`] or
    /// [`Self::first_leaf`].
    #[inline(always)]
    #[must_use]
    pub fn attribute(&self, index: u32) -> u32 {
        let index = index as usize;
        match self.attributes {
            Attributes::Halves(words) => u32::from(words.get(index).copied().unwrap_or(0)),
            Attributes::Words(words) => words.get(index).copied().unwrap_or(0),
        }
    }

    /// Cells along an axis at `level`, 1 at the root, at most 4096.
    #[must_use]
    pub fn cells(&self, level: usize) -> u32 {
        self.levels()
            .iter()
            .take(level)
            .map(|l| u32::from(l.rho))
            .product()
    }

    /// From where backs of its samples show; `None` when the blob does not tell: from anywhere.
    #[must_use]
    pub fn backs(&self) -> Option<Backs<'a>> {
        self.backs
    }

    /// Finds the parts of grid `index`; lengths are checked, contents are not.
    pub(super) fn view(blob: &Blob<'a>, index: u16) -> Result<Self, BlobError> {
        let head = blob.required(kind::GRID, index)?;
        if head.len() != GRID_BYTES {
            return Err(BlobError::Section { kind: kind::GRID });
        }
        let byte = |at: usize| head.get(at).copied().unwrap_or(0);
        let subdivisions = usize::from(byte(0));
        let layout = layout(head);
        layout.check()?;
        if !layout.is_drawn() {
            return Err(BlobError::LayoutNotDrawn);
        }
        if subdivisions == 0 || subdivisions > MAX_SUBDIVISIONS || !matches!(byte(1), 6 | 26) {
            return Err(BlobError::Sequence);
        }
        let first_sampled = usize::from(byte(72));
        if first_sampled > subdivisions {
            return Err(BlobError::Section { kind: kind::GRID });
        }
        let count = |level: usize| u32_at(head, 20 + 4 * level);
        let mut masks = blob.words(kind::MASKS, index)?;
        let mut children = blob.words(kind::CHILDREN, index)?;
        let short = |kind| BlobError::Section { kind };
        let facing = blob.find(kind::FACING, index);
        let parts = facing.map(|bytes| bytes.split_at_checked(BACKS_BYTES));
        let parts = parts
            .map(|parts| parts.ok_or(short(kind::FACING)))
            .transpose()?;
        let (backs, mut cones) = match parts {
            Some((backs, cones)) => {
                let cones = bytemuck::try_cast_slice(cones);
                (Some(Backs(backs)), cones.map_err(|_| short(kind::FACING))?)
            }
            None => (None, &[][..]),
        };

        let mut levels = [Level::default(); MAX_SUBDIVISIONS];
        let mut cells = 1;
        let mut inner = 0u32;
        let mut first = 0u32;
        for (l, level) in levels.iter_mut().take(subdivisions).enumerate() {
            let rho = byte(8 + l);
            cells *= u32::from(rho);
            if !(2..=5).contains(&rho) || cells > MAX_CELLS {
                return Err(BlobError::Sequence);
            }
            let nodes = count(l);
            let n = nodes as usize;
            // The sums below must not wrap; masks and attributes bound them anyway.
            if nodes == 0 || nodes > 1 << 30 {
                return Err(BlobError::Section { kind: kind::GRID });
            }
            let (these, rest) = masks
                .split_at_checked(mask_words(rho, n))
                .ok_or(short(kind::MASKS))?;
            masks = rest;
            let (these_children, rest) = children
                .split_at_checked(children_words(n))
                .ok_or(short(kind::CHILDREN))?;
            children = rest;
            let (bases, offsets) = these_children
                .split_at_checked(n.div_ceil(BASE_NODES))
                .ok_or(short(kind::CHILDREN))?;
            let offsets: &[u16] = bytemuck::cast_slice(offsets);
            let these_cones = if backs.is_some() {
                let (these, rest) = cones.split_at_checked(n).ok_or(short(kind::FACING))?;
                cones = rest;
                these
            } else {
                &[]
            };
            *level = Level {
                rho,
                nodes,
                first,
                masks: these,
                bases,
                offsets: offsets.get(..n).unwrap_or_default(),
                cones: these_cones,
            };
            inner = inner
                .checked_add(nodes)
                .ok_or(BlobError::Section { kind: kind::GRID })?;
            if l >= first_sampled {
                first += nodes;
            }
        }
        let leaves = count(subdivisions);
        let attributes = if layout.word_bytes == 2 {
            let words = bytemuck::try_cast_slice(blob.required(kind::ATTRIBUTES, index)?);
            Attributes::Halves(words.map_err(|_| short(kind::ATTRIBUTES))?)
        } else {
            Attributes::Words(blob.words(kind::ATTRIBUTES, index)?)
        };
        if !masks.is_empty() {
            return Err(short(kind::MASKS));
        }
        if !children.is_empty() {
            return Err(short(kind::CHILDREN));
        }
        if !cones.is_empty() {
            return Err(short(kind::FACING));
        }
        if first.checked_add(leaves) != Some(attributes.len() as u32)
            || leaves == 0
            || count(0) != 1
        {
            return Err(short(kind::ATTRIBUTES));
        }
        Ok(Self {
            subdivisions,
            separation: byte(1),
            layout,
            levels,
            first_sampled,
            nodes: inner
                .checked_add(leaves)
                .ok_or(BlobError::Section { kind: kind::GRID })?,
            leaves,
            attributes,
            backs,
        })
    }

    /// Checks the contents of grid `index`: masks, children, materials.
    pub(super) fn check(blob: &Blob<'a>, index: u16, materials: usize) -> Result<(), BlobError> {
        let grid = Self::view(blob, index)?;
        for (l, level) in grid.levels().iter().enumerate() {
            let mut children = 0u32;
            let bits = u32::from(level.rho).pow(3);
            for node in 0..level.nodes {
                let mask = level.mask_any(node);
                let mut left = bits;
                let valid = mask.iter().all(|word| {
                    let here = left.min(32);
                    left -= here;
                    here == 32 || word >> here == 0
                });
                let set: u32 = mask.iter().map(|w| w.count_ones()).sum();
                if !valid || set == 0 {
                    return Err(BlobError::Mask {
                        level: l as u8,
                        node,
                    });
                }
                if level.first_child(node) != children {
                    return Err(BlobError::Children {
                        level: l as u8,
                        node,
                    });
                }
                children = children.saturating_add(set);
            }
            let next = grid.levels().get(l + 1).map_or(grid.leaves, |l| l.nodes);
            if children != next {
                return Err(BlobError::Children {
                    level: l as u8,
                    node: level.nodes,
                });
            }
        }
        // Of 32 bits none names a material.
        let Attributes::Halves(words) = grid.attributes else {
            return Ok(());
        };
        for (node, word) in words.iter().enumerate() {
            if grid.layout.material_of(u32::from(*word)) as usize >= materials {
                return Err(BlobError::Material { node: node as u32 });
            }
        }
        Ok(())
    }
}
