//! A tree of samples to the bytes of a blob (SPEC.md of rho-grid).

use glam::DVec3;
use rayon::prelude::*;
use rho_grid::blob::format::{
    BASE_NODES, CRC, ENTRY_BYTES, GRID_BYTES, HEADER_BYTES, MAGIC, MATERIAL_BYTES, MAX_SECTIONS,
    MAX_SUBDIVISIONS, PAGE_BYTES, VERSION, kind,
};
use rho_grid::blob::{Layout, Material};

use crate::palette::Palette;
use crate::quantise::normal_index;
use crate::sampling::{Separation, Tree, TreeLevel, TreeSample};

/// The most grids of a blob: each has four sections, and two are the blob's.
pub const MAX_GRIDS: usize = (MAX_SECTIONS - 2) / 4;

/// A blob in the making: sections in the order in which they are added.
#[derive(Debug, Default)]
struct Sections {
    entries: Vec<(u16, u16, Vec<u8>)>,
}

/// What goes into a blob beside its trees.
#[derive(Clone, Debug)]
pub struct Encoding {
    /// What an attribute word holds.
    pub layout: Layout,
    /// The materials, 1 to 8; a sample gets the nearest colour's if the layout has material bits.
    pub palette: Palette,
    /// Lines `key=value`: generator, options, source.
    pub origin: String,
}

/// The blob with one grid.
#[must_use]
pub fn encode(tree: &Tree, encoding: &Encoding) -> Vec<u8> {
    encode_all(std::slice::from_ref(tree), encoding)
}

/// The blob with a grid a tree, in their order; at most [`MAX_GRIDS`].
#[must_use]
pub fn encode_all(trees: &[Tree], encoding: &Encoding) -> Vec<u8> {
    let mut sections = Sections::default();
    sections.add(kind::ORIGIN, 0, encoding.origin.clone().into_bytes());
    sections.add(kind::MATERIALS, 0, materials(&encoding.palette.materials()));
    for (grid, tree) in (0..).zip(trees) {
        sections.add(kind::GRID, grid, description(tree, encoding.layout));
        sections.add(kind::MASKS, grid, masks(tree));
        sections.add(kind::CHILDREN, grid, children(tree));
        sections.add(kind::ATTRIBUTES, grid, attributes(tree, encoding));
    }
    sections.write()
}

impl Sections {
    fn add(&mut self, kind: u16, grid: u16, bytes: Vec<u8>) {
        self.entries.push((kind, grid, bytes));
    }

    fn write(self) -> Vec<u8> {
        let padded = |n: usize| n.next_multiple_of(4);
        let content: usize = self.entries.iter().map(|(_, _, b)| padded(b.len())).sum();
        let directory = HEADER_BYTES + ENTRY_BYTES * self.entries.len();
        let body = directory + 4 * content.div_ceil(PAGE_BYTES);

        let mut out = Vec::with_capacity(body + content);
        out.extend(MAGIC);
        out.extend(VERSION.to_le_bytes());
        out.extend((HEADER_BYTES as u16).to_le_bytes());
        for word in [body + content, body, PAGE_BYTES, self.entries.len(), 0] {
            out.extend((word as u32).to_le_bytes());
        }
        let mut offset = body;
        for (kind, grid, bytes) in &self.entries {
            out.extend(kind.to_le_bytes());
            out.extend(grid.to_le_bytes());
            for word in [offset, bytes.len(), 0] {
                out.extend((word as u32).to_le_bytes());
            }
            offset += padded(bytes.len());
        }
        out.resize(body, 0);
        for (_, _, bytes) in &self.entries {
            out.extend(bytes);
            out.resize(padded(out.len() - body) + body, 0);
        }

        let pages: Vec<u32> = out[body..]
            .chunks(PAGE_BYTES)
            .map(crc32fast::hash)
            .collect();
        for (page, crc) in pages.into_iter().enumerate() {
            let at = directory + 4 * page;
            out[at..at + 4].copy_from_slice(&crc.to_le_bytes());
        }
        let mut digest = CRC.digest();
        digest.update(&out[..HEADER_BYTES - 4]);
        digest.update(&out[HEADER_BYTES..body]);
        out[HEADER_BYTES - 4..HEADER_BYTES].copy_from_slice(&digest.finalize().to_le_bytes());
        out
    }
}

fn materials(materials: &[Material]) -> Vec<u8> {
    let mut out = Vec::with_capacity(MATERIAL_BYTES * materials.len());
    for m in materials {
        for rgb in [m.ambient, m.diffuse, m.specular] {
            out.extend(rgb.iter().flat_map(|c| c.to_le_bytes()));
        }
        out.extend(m.exponent.to_le_bytes());
    }
    out
}

fn description(tree: &Tree, layout: Layout) -> Vec<u8> {
    let mut out = vec![
        tree.sequence.len() as u8,
        match tree.separation {
            Separation::TwentySix => 26,
            Separation::Six => 6,
        },
        layout.word_bytes,
        layout.normal,
        layout.offset,
        layout.material,
        layout.colour,
        layout.offset_range,
    ];
    out.extend(&tree.sequence);
    out.resize(8 + MAX_SUBDIVISIONS, 0);
    for level in &tree.levels {
        out.extend((level.nodes() as u32).to_le_bytes());
    }
    out.resize(GRID_BYTES - 4, 0);
    out.push(tree.first_sampled() as u8);
    out.resize(GRID_BYTES, 0);
    out
}

fn inner(tree: &Tree) -> impl Iterator<Item = (u8, &TreeLevel)> {
    tree.sequence.iter().copied().zip(&tree.levels)
}

fn masks(tree: &Tree) -> Vec<u8> {
    let mut out = Vec::new();
    for (rho, level) in inner(tree) {
        let bytes = match rho {
            2 => 1,
            3 => 4,
            4 => 8,
            _ => 16,
        };
        for mask in &level.masks {
            out.extend(&mask.to_le_bytes()[..bytes]);
        }
        out.resize(out.len().next_multiple_of(4), 0);
    }
    out
}

fn children(tree: &Tree) -> Vec<u8> {
    let mut out = Vec::new();
    for (_, level) in inner(tree) {
        let mut firsts = Vec::with_capacity(level.masks.len());
        let mut next = 0u32;
        for mask in &level.masks {
            firsts.push(next);
            next += mask.count_ones();
        }
        for base in firsts.iter().step_by(BASE_NODES) {
            out.extend(base.to_le_bytes());
        }
        for group in firsts.chunks(BASE_NODES) {
            for first in group {
                // At most 512 x 125.
                out.extend(((first - group[0]) as u16).to_le_bytes());
            }
        }
        out.resize(out.len().next_multiple_of(4), 0);
    }
    out
}

/// The step for an offset in sides of the cell, rounded down.
///
/// Of discs that overlap the foremost is seen, so that errors of rounding to nearest would all
/// show on the outside: on the bunny that costs 1 dB at the silhouette.
fn offset_step(layout: Layout, sides: f32) -> u32 {
    let half_step = f32::from(layout.offset_range) / 128.0 / f32::from(1_u8 << layout.offset);
    layout.offset_step(((sides - half_step).clamp(-2.0, 2.0) * 65536.0) as i32)
}

fn attributes(tree: &Tree, encoding: &Encoding) -> Vec<u8> {
    let word = |sample: &TreeSample| -> [u8; 2] {
        let layout = encoding.layout;
        let normal = normal_index(DVec3::from(sample.normal));
        let offset = offset_step(layout, sample.offset);
        let material = if layout.material == 0 {
            0
        } else {
            encoding.palette.nearest(sample.colour)
        };
        (layout.pack(normal, offset, material, 0) as u16).to_le_bytes()
    };
    tree.levels
        .iter()
        .flat_map(|level| level.samples.par_iter().map(word).collect::<Vec<_>>())
        .flatten()
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_offset_is_rounded_down_to_a_step() {
        let thin = Layout::OFFSET_THIN;
        // Steps lie at -7/16, -5/16 ... 7/16 of a cell.
        for (sides, step) in [
            (-1.0, 0),
            (-0.32, 0),
            (-0.31, 1),
            (0.06, 3),
            (0.07, 4),
            (0.43, 6),
            (0.44, 7),
            (9.0, 7),
        ] {
            assert_eq!(offset_step(thin, sides), step, "{sides}");
        }
        assert_eq!(offset_step(Layout::MATERIAL, 0.4), 0);
    }
}
