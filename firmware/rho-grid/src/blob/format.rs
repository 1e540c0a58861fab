//! The numbers of SPEC.md.

/// First bytes of every blob.
pub const MAGIC: [u8; 8] = *b"\x89RHO\r\n\x1a\n";
/// The version written, and the newest one read.
pub const VERSION: u16 = 1;
/// Bytes of the header.
pub const HEADER_BYTES: usize = 32;
/// Bytes of a directory entry.
pub const ENTRY_BYTES: usize = 16;
/// Bytes that one CRC of the page table covers.
pub const PAGE_BYTES: usize = 4096;
/// Most sections of a blob: bounds the time of a look-up in the directory.
pub const MAX_SECTIONS: usize = 256;
/// Bytes of a grid's description.
pub const GRID_BYTES: usize = 76;
/// Most subdivisions of a grid: 2^12 cells an axis.
pub const MAX_SUBDIVISIONS: usize = 12;
/// Most cells along an axis at the leaves: bounds the depth and every table of the renderer.
pub const MAX_CELLS: u32 = 4096;
/// Nodes that share one base of the children section; 512 x 125 fits the 16-bit offset.
pub const BASE_NODES: usize = 512;
/// Bytes of a material.
pub const MATERIAL_BYTES: usize = 20;
/// Most materials of an object: a sample has three bits to name one.
pub const MAX_MATERIALS: usize = 8;
/// Most materials of a blob with several objects.
pub const MAX_SCENE_MATERIALS: usize = 32;
/// Bytes of an object.
pub const OBJECT_BYTES: usize = 20;
/// Bytes of an instance.
pub const INSTANCE_BYTES: usize = 56;
/// Most instances of a blob: bounds the tables that put them in order.
pub const MAX_INSTANCES: usize = 128;
/// The material of an instance that shows its samples' own.
pub const OWN_MATERIAL: u16 = 0xFFFF;
/// Bytes of a light.
pub const LIGHT_BYTES: usize = 16;
/// Most lights of a blob.
pub const MAX_LIGHTS: usize = 4;
/// Bytes of camera and background.
pub const CAMERA_BYTES: usize = 60;
/// A reader may pass over a section it does not know if this bit of its kind is set.
pub const OPTIONAL: u16 = 0x8000;

/// Kinds of sections.
pub mod kind {
    /// A grid's description.
    pub const GRID: u16 = 1;
    /// Child masks.
    pub const MASKS: u16 = 2;
    /// Where each node's children begin.
    pub const CHILDREN: u16 = 3;
    /// An attribute word a node.
    pub const ATTRIBUTES: u16 = 4;
    /// Materials.
    pub const MATERIALS: u16 = 5;
    /// Objects: which grids are the same thing, coarse and fine.
    pub const OBJECTS: u16 = 6;
    /// Instances: objects at their places.
    pub const INSTANCES: u16 = 7;
    /// Lights.
    pub const LIGHTS: u16 = 8;
    /// Camera and background.
    pub const CAMERA: u16 = 9;
    /// Where the blob comes from, as text.
    pub const ORIGIN: u16 = 0x8001;
    /// What of a grid faces away from where.
    pub const FACING: u16 = 0x8002;
}

/// The CRC-32 of headers and pages, that of IEEE 802.3 (one table of 1 kB).
pub const CRC: crc::Crc<u32, crc::Table<1>> =
    crc::Crc::<u32, crc::Table<1>>::new(&crc::CRC_32_ISO_HDLC);

/// Words of 32 bits that hold the masks of `nodes` nodes subdivided by `rho`.
#[must_use]
pub const fn mask_words(rho: u8, nodes: usize) -> usize {
    match rho {
        2 => nodes.div_ceil(4),
        3 => nodes,
        4 => nodes.saturating_mul(2),
        _ => nodes.saturating_mul(4),
    }
}

/// Words of 32 bits that tell where the children of `nodes` nodes begin.
#[must_use]
pub const fn children_words(nodes: usize) -> usize {
    nodes.div_ceil(BASE_NODES) + nodes.div_ceil(2)
}
