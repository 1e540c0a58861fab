//! Why a blob is refused.

use core::fmt;

/// Why a blob is refused, named so that a person knows what to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BlobError {
    /// Does not begin with the magic bytes.
    NotABlob,
    /// Nothing there: the first bytes are all 00 or all FF.
    Missing,
    /// Written by a newer version of the format.
    Newer {
        /// Its version.
        version: u16,
    },
    /// Ends before its header says.
    Truncated {
        /// Length by its header, in bytes.
        expected: u32,
        /// Bytes that are there.
        found: u32,
    },
    /// Header or directory damaged.
    HeaderCrc,
    /// A page of the body is damaged.
    PageCrc {
        /// Which, counted from 0.
        page: u32,
    },
    /// The address is not divisible by 4.
    Misaligned,
    /// The header's own numbers contradict each other.
    Header,
    /// A section lies outside the body, overlaps its bounds, or has another length than it must.
    Section {
        /// Its kind.
        kind: u16,
    },
    /// A section that must not be passed over is not known to this reader.
    UnknownSection {
        /// Its kind.
        kind: u16,
    },
    /// A section is missing.
    MissingSection {
        /// Its kind.
        kind: u16,
    },
    /// The sequence of subdivisions is not one of the format's.
    Sequence,
    /// The attribute layout is not one of the format's.
    Layout,
    /// The attribute layout is valid, but this renderer does not draw it.
    LayoutNotDrawn,
    /// A child mask is empty or has bits beyond its subcells.
    Mask {
        /// Level, 0 the root.
        level: u8,
        /// Node within the level.
        node: u32,
    },
    /// A node's children are not where the numbering puts them.
    Children {
        /// Level, 0 the root.
        level: u8,
        /// Node within the level.
        node: u32,
    },
    /// An object names grids or materials that the blob does not have, or an empty box.
    Object {
        /// Which, counted from 0.
        object: u16,
    },
    /// An instance names an object or a material that the blob does not have, or its transform is
    /// none.
    Instance {
        /// Which, counted from 0.
        instance: u16,
    },
    /// A light's direction is not of length 1.
    Light {
        /// Which, counted from 0.
        light: u16,
    },
    /// The camera is none.
    Camera,
    /// A sample names a material that the blob or its object does not have.
    Material {
        /// Node, counted over all levels that have samples.
        node: u32,
    },
}

impl fmt::Display for BlobError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NotABlob => write!(f, "not a rho blob: the first bytes are others"),
            Self::Missing => write!(f, "no blob here: the memory is empty"),
            Self::Newer { version } => write!(
                f,
                "blob version {version} is newer than this reader ({})",
                super::format::VERSION
            ),
            Self::Truncated { expected, found } => {
                write!(f, "blob truncated: {found} of {expected} bytes")
            }
            Self::HeaderCrc => write!(f, "blob damaged: wrong CRC of the header"),
            Self::PageCrc { page } => write!(f, "blob damaged: wrong CRC of page {page}"),
            Self::Misaligned => write!(f, "blob at an address not divisible by 4"),
            Self::Header => write!(f, "blob invalid: header"),
            Self::Section { kind } => write!(f, "blob invalid: section {kind}"),
            Self::UnknownSection { kind } => {
                write!(f, "blob needs a newer reader: section {kind}")
            }
            Self::MissingSection { kind } => write!(f, "blob invalid: no section {kind}"),
            Self::Sequence => write!(f, "blob invalid: sequence of subdivisions"),
            Self::Layout => write!(f, "blob invalid: attribute layout"),
            Self::LayoutNotDrawn => {
                write!(
                    f,
                    "attribute layout not drawn by this version: use 13 + 3 or 11 + 2 + 3 bits"
                )
            }
            Self::Mask { level, node } => {
                write!(f, "blob invalid: mask of node {node}, level {level}")
            }
            Self::Children { level, node } => {
                write!(f, "blob invalid: children of node {node}, level {level}")
            }
            Self::Object { object } => write!(f, "blob invalid: object {object}"),
            Self::Instance { instance } => write!(f, "blob invalid: instance {instance}"),
            Self::Light { light } => write!(f, "blob invalid: light {light}"),
            Self::Camera => write!(f, "blob invalid: camera"),
            Self::Material { node } => write!(f, "blob invalid: material of node {node}"),
        }
    }
}

impl core::error::Error for BlobError {}
