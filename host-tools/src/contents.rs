//! What is in a blob, counted.

use std::collections::BTreeMap;

use rho_grid::blob::format::kind;
use rho_grid::blob::{Blob, Grid, Layout, Material};
use serde::Serialize;

/// What is in a blob; the sums are over its grids.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contents {
    /// Intermediate nodes and leaves.
    pub nodes: u64,
    /// Samples of the finest levels.
    pub leaf_samples: u64,
    /// Bytes by section, `header` (with directory, page table and padding) and `total`.
    pub bytes: BTreeMap<String, u64>,
    /// All bytes over all leaves.
    pub bytes_per_leaf: f64,
    /// One a grid.
    pub grids: Vec<GridContents>,
    /// 1 to 8, of a scene up to 32.
    pub materials: Vec<MaterialContents>,
    /// What stands where; none of a blob that does not say.
    pub scene: Option<SceneContents>,
    /// Where the blob comes from: what it says of itself.
    pub origin: BTreeMap<String, String>,
}

/// What stands where.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneContents {
    /// The grids that are the same thing.
    pub objects: Vec<ObjectContents>,
    /// How many objects stand in the scene.
    pub instances: usize,
    /// How many lights.
    pub lights: usize,
    /// Whether one of them casts shadows.
    pub shadows: bool,
    /// Whether the blob has a camera.
    pub camera: bool,
    /// RGB565.
    pub background: u16,
}

/// An object of a scene.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ObjectContents {
    /// Its grids' numbers.
    pub grids: Vec<u16>,
    /// How often it stands in the scene.
    pub instances: usize,
    /// The blob's materials that its samples may name.
    pub materials: Vec<u16>,
}

impl SceneContents {
    fn of(blob: &Blob<'_>) -> Option<Self> {
        let instances: Vec<_> = (0..blob.instance_count())
            .filter_map(|i| blob.instance(i))
            .collect();
        let objects = (0..).zip(blob.objects());
        let objects = objects.map(|(number, object)| ObjectContents {
            grids: (object.first_grid..).take(object.grids.into()).collect(),
            instances: instances.iter().filter(|i| i.object == number).count(),
            materials: (object.first_material..)
                .take(object.materials.into())
                .collect(),
        });
        blob.is_scene().then(|| Self {
            objects: objects.collect(),
            instances: instances.len(),
            lights: blob.lights().len(),
            shadows: blob.lights().any(|light| light.casts_shadows),
            camera: blob.camera().is_some(),
            background: blob.background(),
        })
    }
}

/// What is in one grid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GridContents {
    /// The subdivision of each level above the leaves.
    pub rho: Vec<u8>,
    /// Cells an axis by level, from the root's 1.
    pub cells: Vec<u32>,
    /// Intermediate nodes and leaves.
    pub nodes: u64,
    /// The level from which on nodes have samples: 0 for all of them.
    pub first_sampled: usize,
    /// Nodes of each level, the root's 1 first, the leaves last.
    pub nodes_by_level: Vec<u64>,
    /// Samples of the finest level.
    pub leaf_samples: u64,
    /// Children a node above the leaves: nodes without the root over inner nodes.
    pub alpha: f64,
    /// Bytes of its sections.
    pub bytes: u64,
    /// 26, or 6 for thin leaves.
    pub separation: u8,
    /// What a sample's word holds.
    pub layout: LayoutContents,
}

/// What a sample's word holds, in bits.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LayoutContents {
    /// Bytes of a word.
    pub word_bytes: u8,
    /// The normal.
    pub normal: u8,
    /// The offset along the normal.
    pub offset: u8,
    /// The material.
    pub material: u8,
    /// The colour.
    pub colour: u8,
    /// The offset's range, in 1/128 of a cell's side either way.
    pub offset_range: u8,
}

/// One material, 1.0 the brightest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MaterialContents {
    /// Red, green, blue in the shade.
    pub ambient: [f64; 3],
    /// Red, green, blue added where the light falls squarely.
    pub diffuse: [f64; 3],
    /// Phong colour.
    pub specular: [f64; 3],
    /// Phong exponent.
    pub exponent: u16,
}

impl Contents {
    /// Counts.
    #[must_use]
    pub fn of(blob: &Blob<'_>) -> Self {
        let mut grids: Vec<_> = blob.grids().map(|grid| GridContents::of(&grid)).collect();
        let total = blob.bytes().len() as u64;
        let mut bytes = BTreeMap::new();
        for section in blob.sections() {
            let length = section.bytes.len() as u64;
            *bytes.entry(section_name(section.kind)).or_default() += length;
            let of_grids = kind::GRID..=kind::ATTRIBUTES;
            if let Some(grid) = grids.get_mut(usize::from(section.grid))
                && of_grids.contains(&section.kind)
            {
                grid.bytes += length;
            }
        }
        let sections: u64 = bytes.values().sum();
        bytes.insert("header".to_owned(), total - sections);
        bytes.insert("total".to_owned(), total);
        let leaf_samples = grids.iter().map(|g| g.leaf_samples).sum();
        Self {
            nodes: grids.iter().map(|g| g.nodes).sum(),
            leaf_samples,
            bytes,
            bytes_per_leaf: total as f64 / leaf_samples as f64,
            grids,
            materials: blob.materials().map(MaterialContents::from).collect(),
            scene: SceneContents::of(blob),
            origin: blob
                .origin()
                .lines()
                .filter_map(|line| line.split_once('='))
                .map(|(key, value)| (key.to_owned(), value.to_owned()))
                .collect(),
        }
    }

    /// All bytes.
    #[must_use]
    pub fn total_bytes(&self) -> u64 {
        self.bytes.get("total").copied().unwrap_or(0)
    }
}

impl GridContents {
    fn of(grid: &Grid<'_>) -> Self {
        let nodes = u64::from(grid.nodes());
        let leaf_samples = u64::from(grid.leaf_samples());
        let levels = grid.levels();
        Self {
            rho: levels.iter().map(|level| level.rho).collect(),
            cells: (0..=levels.len()).map(|level| grid.cells(level)).collect(),
            nodes,
            first_sampled: grid.first_sampled(),
            nodes_by_level: levels
                .iter()
                .map(|level| u64::from(level.nodes))
                .chain([leaf_samples])
                .collect(),
            leaf_samples,
            alpha: (nodes - 1) as f64 / (nodes - leaf_samples) as f64,
            bytes: 0,
            separation: grid.separation(),
            layout: grid.layout().into(),
        }
    }

    /// `2,3,3,3,3`
    #[must_use]
    pub fn sequence(&self) -> String {
        let numbers: Vec<String> = self.rho.iter().map(u8::to_string).collect();
        numbers.join(",")
    }
}

impl From<Layout> for LayoutContents {
    fn from(layout: Layout) -> Self {
        Self {
            word_bytes: layout.word_bytes,
            normal: layout.normal,
            offset: layout.offset,
            material: layout.material,
            colour: layout.colour,
            offset_range: layout.offset_range,
        }
    }
}

impl std::fmt::Display for LayoutContents {
    /// `13 normal + 3 material bits`
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} normal", self.normal)?;
        for (bits, what) in [
            (self.offset, "offset"),
            (self.material, "material"),
            (self.colour, "colour"),
        ] {
            if bits > 0 {
                write!(f, " + {bits} {what}")?;
            }
        }
        f.write_str(" bits")
    }
}

impl From<Material> for MaterialContents {
    fn from(material: Material) -> Self {
        let rgb = |words: [u16; 3]| words.map(|word| f64::from(word) / 32768.0);
        Self {
            ambient: rgb(material.ambient),
            diffuse: rgb(material.diffuse),
            specular: rgb(material.specular),
            exponent: material.exponent,
        }
    }
}

/// The name of a kind of section.
#[must_use]
pub fn section_name(kind: u16) -> String {
    match kind {
        kind::GRID => "grid",
        kind::MASKS => "masks",
        kind::FACING => "facing",
        kind::CHILDREN => "children",
        kind::ATTRIBUTES => "attributes",
        kind::MATERIALS => "materials",
        kind::OBJECTS => "objects",
        kind::INSTANCES => "instances",
        kind::LIGHTS => "lights",
        kind::CAMERA => "camera",
        kind::ORIGIN => "origin",
        other => return format!("section_{other:04x}"),
    }
    .to_owned()
}
