//! The scan that the tests measure, and blobs baked from it by the library.

use std::sync::OnceLock;

use host_tools::bake::{BakeOptions, GridChoice, Progress, bake};
use host_tools::blob_file::BlobFile;
use host_tools::encode::{Encoding, encode};
use host_tools::geometry::Geometry;
use host_tools::geometry::triangles::Triangles;
use host_tools::mesh::Mesh;
use host_tools::model::{self, LoadOptions};
use host_tools::palette::Palette;
use host_tools::sampling::{Sampling, Separation, Sequence, Tree};
use rho_grid::blob::Layout;

/// The Stanford bunny, at its original resolution.
///
/// # Panics
/// When it is missing: a test that did not run has not passed.
pub fn bunny() -> &'static Mesh {
    static BUNNY: OnceLock<Mesh> = OnceLock::new();
    BUNNY.get_or_init(|| {
        model::scan("bunny")
            .and_then(|path| model::load(&path, &LoadOptions::default()))
            .unwrap_or_else(|failure| panic!("{failure}"))
            .mesh
    })
}

/// The bunny's blob as `rho bake` makes it without flags: six thin grids of discs.
///
/// # Panics
/// When it cannot be baked.
#[must_use]
pub fn standard_bunny() -> &'static BlobFile {
    static BUNNY: OnceLock<BlobFile> = OnceLock::new();
    BUNNY.get_or_init(|| {
        let path = model::scan("bunny").unwrap_or_else(|failure| panic!("{failure}"));
        standard(path.to_str().expect("a name in UTF-8"))
    })
}

/// The blob of a model as `rho bake` makes it without flags.
///
/// # Panics
/// When it cannot be baked.
#[must_use]
pub fn standard(model: &str) -> BlobFile {
    let options = BakeOptions {
        grid: GridChoice::Standard(None),
        ..BakeOptions::default()
    };
    let baked =
        bake(model, &options, &Progress::default()).unwrap_or_else(|failure| panic!("{failure}"));
    BlobFile::from_bytes(&baked.bytes, model)
}

/// The bunny's blob, a cell for every cell of the finest grid that it meets.
///
/// # Panics
/// When it cannot be baked.
#[must_use]
pub fn baked_bunny(sequence: &[u8]) -> BlobFile {
    baked(&Triangles::new(bunny()), sequence)
}

/// The blob of an object, a cell for every cell of the finest grid that it meets.
///
/// # Panics
/// When it cannot be baked.
#[must_use]
pub fn baked<G: Geometry + ?Sized>(geometry: &G, sequence: &[u8]) -> BlobFile {
    let tree = sampled(geometry, sequence, Separation::TwentySix);
    encoded(&tree, Layout::MATERIAL)
}

/// The samples of an object.
///
/// # Panics
/// When it cannot be sampled.
#[must_use]
pub fn sampled<G: Geometry + ?Sized>(
    geometry: &G,
    sequence: &[u8],
    separation: Separation,
) -> Tree {
    let sampling = Sampling {
        sequence: Sequence::new(sequence).expect("a sequence"),
        separation,
        memory: 1 << 30,
    };
    sampling
        .sample(geometry, &0.into())
        .unwrap_or_else(|failure| panic!("{failure}"))
}

/// The blob of samples.
#[must_use]
pub fn encoded(tree: &Tree, layout: Layout) -> BlobFile {
    let samples = tree.levels.iter().flat_map(|level| &level.samples);
    let encoding = Encoding {
        layout,
        palette: Palette::of(samples.map(|sample| sample.colour)),
        origin: String::new(),
    };
    BlobFile::from_bytes(&encode(tree, &encoding), "a blob of the tests")
}
