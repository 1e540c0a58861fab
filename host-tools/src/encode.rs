//! A tree of samples to the bytes of a blob (SPEC.md of rho-grid).

use glam::DVec3;
use rayon::prelude::*;
use rho_grid::blob::format::{
    BASE_NODES, CAMERA_BYTES, CRC, ENTRY_BYTES, GRID_BYTES, HEADER_BYTES, MAGIC, MATERIAL_BYTES,
    MAX_SECTIONS, MAX_SUBDIVISIONS, OWN_MATERIAL, PAGE_BYTES, VERSION, kind,
};
use rho_grid::blob::{Instance, Layout, Light, Material};
use rho_grid::camera::Camera;
use rho_grid::q::Rotation;

use crate::facing::{self, Backs};
use crate::palette::Palette;
use crate::picture::rgb565;
use crate::quantise::normal_index;
use crate::sampling::{Separation, Tree, TreeLevel, TreeSample};

/// The most grids of a blob: each has five sections at most, and two are the blob's, or six a scene's.
pub const MAX_GRIDS: usize = (MAX_SECTIONS - 6) / 5;

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

/// A blob of several objects, each in one or more grids.
#[derive(Clone, Debug)]
pub struct SceneEncoding<'a> {
    /// What the instances are instances of.
    pub objects: &'a [ObjectEncoding],
    /// The materials, 1 to 32.
    pub materials: Vec<Material>,
    /// 1 to [`MAX_INSTANCES`](rho_grid::blob::format::MAX_INSTANCES).
    pub instances: Vec<Instance>,
    /// At most [`MAX_LIGHTS`](rho_grid::blob::format::MAX_LIGHTS).
    pub lights: Vec<Light>,
    /// Where the eye stands if nobody says otherwise.
    pub camera: Camera,
    /// RGB565.
    pub background: u16,
    /// Lines `key=value`: generator, options, source.
    pub origin: String,
}

/// An object and its grids.
#[derive(Clone, Debug)]
pub struct ObjectEncoding {
    /// A grid each.
    pub trees: Vec<Tree>,
    /// What an attribute word holds.
    pub layout: Layout,
    /// The colours of its own materials.
    pub palette: Palette,
    /// The blob's material that is the first of them.
    pub first_material: u16,
    /// How many of the blob's materials its samples may name.
    pub materials: u16,
    /// The box, in its cube, that holds its surface: low and high corner.
    pub bounds: [DVec3; 2],
}

/// The blob of a scene.
#[must_use]
pub fn encode_scene(scene: &SceneEncoding<'_>) -> Vec<u8> {
    let mut sections = Sections::default();
    sections.add(kind::ORIGIN, 0, scene.origin.clone().into_bytes());
    sections.add(kind::MATERIALS, 0, materials(&scene.materials));
    sections.add(kind::OBJECTS, 0, objects(scene.objects));
    sections.add(kind::INSTANCES, 0, instances(&scene.instances));
    if !scene.lights.is_empty() {
        sections.add(kind::LIGHTS, 0, lights(&scene.lights));
    }
    sections.add(kind::CAMERA, 0, camera(&scene.camera, scene.background));
    let mut grid = 0;
    for object in scene.objects {
        for tree in &object.trees {
            sections.add(kind::GRID, grid, description(tree, object.layout));
            sections.add(kind::MASKS, grid, masks(tree));
            sections.add(kind::CHILDREN, grid, children(tree));
            let words = attributes(tree, object.layout, &object.palette);
            sections.add(kind::ATTRIBUTES, grid, words);
            grid += 1;
        }
    }
    let mut first = 0;
    for object in scene.objects {
        sections.add_facing(first, &object.trees, object.layout);
        first += object.trees.len() as u16;
    }
    sections.write()
}

fn objects(objects: &[ObjectEncoding]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut first = 0;
    for object in objects {
        let grids = object.trees.len() as u16;
        for word in [first, grids, object.first_material, object.materials] {
            out.extend(word.to_le_bytes());
        }
        first += grids;
        let [low, high] = object.bounds;
        let q15 = |v: f64| (v.clamp(-0.5, 0.5) * 32768.0) as i16;
        for v in low.to_array() {
            out.extend(q15((v * 32768.0).floor() / 32768.0).to_le_bytes());
        }
        for v in high.to_array() {
            out.extend(q15((v * 32768.0).ceil() / 32768.0).to_le_bytes());
        }
    }
    out
}

fn instances(instances: &[Instance]) -> Vec<u8> {
    let mut out = Vec::new();
    for instance in instances {
        out.extend(instance.object.to_le_bytes());
        out.extend(instance.material.unwrap_or(OWN_MATERIAL).to_le_bytes());
        rotation(&mut out, &instance.rotation);
        out.extend(instance.scale.to_bits().to_le_bytes());
        for v in instance.translation {
            out.extend(v.to_bits().to_le_bytes());
        }
    }
    out
}

fn rotation(out: &mut Vec<u8>, rows: &[[Rotation; 3]; 3]) {
    for entry in rows.as_flattened() {
        out.extend(entry.to_bits().to_le_bytes());
    }
}

fn lights(lights: &[Light]) -> Vec<u8> {
    let mut out = Vec::new();
    for light in lights {
        for v in light.towards {
            out.extend(v.to_bits().to_le_bytes());
        }
        out.extend(u16::from(light.casts_shadows).to_le_bytes());
        out.extend(light.colour.iter().flat_map(|c| c.to_le_bytes()));
        out.extend([0; 2]);
    }
    out
}

fn camera(camera: &Camera, background: u16) -> Vec<u8> {
    let mut out = Vec::with_capacity(CAMERA_BYTES);
    rotation(&mut out, &camera.rotation);
    for v in camera.translation {
        out.extend(v.to_bits().to_le_bytes());
    }
    out.extend(camera.focal.to_bits().to_le_bytes());
    for word in [camera.width, camera.height, background, 0] {
        out.extend(word.to_le_bytes());
    }
    out
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
        sections.add(
            kind::ATTRIBUTES,
            grid,
            attributes(tree, encoding.layout, &encoding.palette),
        );
    }
    sections.add_facing(0, trees, encoding.layout);
    sections.write()
}

impl Sections {
    fn add(&mut self, kind: u16, grid: u16, bytes: Vec<u8>) {
        self.entries.push((kind, grid, bytes));
    }

    /// What of an object's grids, from number `first` on, faces away: of samples drawn as discs, if that
    /// is known.
    fn add_facing(&mut self, first: u16, trees: &[Tree], layout: Layout) {
        if layout.offset == 0 {
            return;
        }
        let Some(backs) = Backs::of(trees) else {
            return;
        };
        for (grid, tree) in (first..).zip(trees) {
            self.add(kind::FACING, grid, facing::section(tree, &backs));
        }
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

fn attributes(tree: &Tree, layout: Layout, palette: &Palette) -> Vec<u8> {
    let word = |sample: &TreeSample| -> u32 {
        let normal = normal_index(DVec3::from(sample.normal)) >> (13 - layout.normal);
        let offset = offset_step(layout, sample.offset);
        let material = if layout.material == 0 {
            0
        } else {
            palette.material(sample)
        };
        let colour = if layout.colour == 0 {
            0
        } else {
            rgb565(sample.mean).into()
        };
        layout.pack(normal, offset, material, colour)
    };
    tree.levels
        .iter()
        .flat_map(|level| level.samples.par_iter().map(word).collect::<Vec<_>>())
        .flat_map(|word| {
            word.to_le_bytes()
                .into_iter()
                .take(layout.word_bytes.into())
        })
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
