//! A small model that needs no file: a dented octahedron.

use glam::DVec3;
use host_tools::encode::{Encoding, encode};
use host_tools::geometry::triangles::Triangles;
use host_tools::mesh::Mesh;
use host_tools::palette::Palette;
use host_tools::sampling::{Sampling, Separation, Sequence};
use rho_grid::blob::Layout;

/// An octahedron in cube units, its upper front face pushed in, so that parts hide others.
#[must_use]
pub fn octahedron() -> Mesh {
    let p = |x, y, z| DVec3::new(x, y, z) / 2.0;
    let positions = vec![
        p(1.0, 0.0, 0.0),
        p(-1.0, 0.0, 0.0),
        p(0.0, 1.0, 0.0),
        p(0.0, -1.0, 0.0),
        p(0.0, 0.0, 1.0),
        p(0.0, 0.0, -1.0),
        p(0.15, 0.15, 0.15),
    ];
    let triangles = vec![
        [0, 2, 6],
        [2, 4, 6],
        [4, 0, 6],
        [2, 1, 4],
        [1, 3, 4],
        [3, 0, 4],
        [2, 0, 5],
        [1, 2, 5],
        [3, 1, 5],
        [0, 3, 5],
    ];
    let normals = positions.iter().map(|p| p.normalize()).collect();
    Mesh {
        positions,
        normals,
        colours: Vec::new(),
        triangles,
    }
}

/// Its blob, `3^4` cells an axis.
///
/// # Panics
/// When it cannot be sampled.
#[must_use]
pub fn blob() -> Vec<u8> {
    let mesh = octahedron();
    let sampling = Sampling {
        sequence: Sequence::new(&[3, 3, 3, 3]).expect("a sequence"),
        separation: Separation::TwentySix,
        memory: 1 << 28,
    };
    let tree = sampling
        .sample(&Triangles::new(&mesh), &0.into())
        .expect("a tree");
    let encoding = Encoding {
        layout: Layout::MATERIAL,
        palette: Palette::of([[255, 255, 255]].into_iter()),
        origin: String::new(),
    };
    encode(&tree, &encoding)
}
