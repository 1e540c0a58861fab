//! The paper's models (its figure 4), and what stands in for them here.

use std::ffi::OsString;

use crate::bench::bake_with;
use crate::blob_file::BlobFile;
use crate::contents::Contents;
use crate::failure::Outcome;
use crate::model::{self, Up};

/// A model of the paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperModel {
    /// What it is called here.
    pub name: &'static str,
    /// What the paper calls it.
    pub papers: &'static str,
    /// A scan's name, or an object that needs no file.
    pub source: Source,
    /// Which way is up in it.
    pub up: Up,
    /// How it differs from the paper's; empty when it does not.
    pub difference: &'static str,
    /// The paper's samples in thousands, alpha and file in kilobytes, at its levels 3, 4 and 5.
    pub printed: [Printed; 3],
}

/// What the paper's Table 4 has for a model at a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Printed {
    /// Samples of all levels, thousands.
    pub samples: f64,
    /// Children a node.
    pub alpha: f64,
    /// Kilobytes of the file.
    pub file: f64,
}

/// Where a model comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// A file among the scans.
    Scan(&'static str),
    /// An object by name, with its parameters.
    Object(&'static str),
}

const fn at(samples: f64, alpha: f64, file: f64) -> Printed {
    Printed {
        samples,
        alpha,
        file,
    }
}

/// All but the Blade, which was not to be had.
pub const MODELS: [PaperModel; 5] = [
    PaperModel {
        name: "bunny",
        papers: "Bunny",
        source: Source::Scan("bunny"),
        up: Up::Y,
        difference: "",
        printed: [
            at(26.0, 9.36, 76.8),
            at(230.0, 9.03, 698.0),
            at(2100.0, 9.00, 6280.0),
        ],
    },
    PaperModel {
        name: "dragon",
        papers: "Dragon",
        source: Source::Scan("dragon"),
        up: Up::Y,
        difference: "",
        printed: [
            at(18.0, 9.75, 54.5),
            at(170.0, 9.19, 506.0),
            at(1500.0, 9.04, 4600.0),
        ],
    },
    PaperModel {
        name: "buddha",
        papers: "Buddha",
        source: Source::Scan("buddha_100k"),
        up: Up::Z,
        difference: "reduced to 100,000 triangles; the paper's has 1.08 million",
        printed: [
            at(14.0, 10.3, 41.5),
            at(130.0, 9.45, 396.0),
            at(1200.0, 9.07, 3650.0),
        ],
    },
    PaperModel {
        name: "oak",
        papers: "Arbre",
        source: Source::Scan("tree_oak"),
        up: Up::Y,
        difference: "another tree of the paper's size",
        printed: [
            at(40.0, 11.45, 114.0),
            at(370.0, 9.18, 1100.0),
            at(3200.0, 8.63, 9770.0),
        ],
    },
    PaperModel {
        name: "willow",
        papers: "Saule",
        source: Source::Object("willow"),
        up: Up::Y,
        difference: "another willow, grown by `rho bake willow`",
        printed: [
            at(45.0, 13.62, 121.0),
            at(430.0, 9.62, 1280.0),
            at(3400.0, 7.84, 10700.0),
        ],
    },
];

impl PaperModel {
    /// The blob that `rho bake` makes of it with these flags.
    ///
    /// # Errors
    /// Those of the command, and when a scan is missing.
    pub fn baked(&self, flags: &str) -> Outcome<Vec<u8>> {
        let source: OsString = match self.source {
            Source::Scan(name) => model::scan(name)?.into(),
            Source::Object(name) => name.into(),
        };
        bake_with(source, self.up, flags)
    }
}

/// The flags for the paper's tri-grid of a level, which has 3^(level + 1) cells an axis and keeps a
/// sample in every cell above the leaves.
#[must_use]
pub fn tri_grid(level: usize) -> String {
    format!("--rho 3 --subdivisions {}", level + 1)
}

/// What is in a blob.
///
/// # Errors
/// When it is none.
pub fn contents(bytes: &[u8], name: &str) -> Outcome<Contents> {
    let file = BlobFile::from_bytes(bytes, name);
    Ok(Contents::of(&file.blob()?))
}
