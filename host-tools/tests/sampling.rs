//! Sampling whole scans: the number of cells, and how long it takes.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicU64;
use std::time::Instant;

use glam::DVec3;
use host_tools::geometry::triangles::Triangles;
use host_tools::mesh::Mesh;
use host_tools::sampling::{Sampling, Separation, Sequence, Tree};

fn scan(name: &str) -> Mesh {
    let folder = std::env::var_os("RHO_MODELS").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/models"),
        PathBuf::from,
    );
    let path = folder.join(name);
    load(&path)
}

fn load(path: &Path) -> Mesh {
    let file = std::fs::read(path).unwrap_or_else(|error| {
        panic!(
            "{}: {error}; set RHO_MODELS to the folder of the test scans",
            path.display()
        )
    });
    let mut bytes = Vec::new();
    flate2::read::GzDecoder::new(&file[..])
        .read_to_end(&mut bytes)
        .unwrap();
    let end = bytes
        .windows(11)
        .position(|w| w == b"end_header\n")
        .unwrap()
        + 11;
    let header = std::str::from_utf8(&bytes[..end]).unwrap();
    let count = |what: &str| -> usize {
        let line = header.lines().find_map(|l| l.strip_prefix(what)).unwrap();
        line.trim().parse().unwrap()
    };
    let (vertices, faces) = (count("element vertex"), count("element face"));
    let mut at = end;
    let mut take = || {
        at += 4;
        <[u8; 4]>::try_from(&bytes[at - 4..at]).unwrap()
    };
    let mut positions: Vec<DVec3> = (0..vertices)
        .map(|_| DVec3::from_array([(); 3].map(|()| f64::from(f32::from_le_bytes(take())))))
        .collect();
    let triangles: Vec<[u32; 3]> = bytes[at..]
        .chunks_exact(13)
        .map(|f| [1, 5, 9].map(|i| u32::from_le_bytes(f[i..i + 4].try_into().unwrap())))
        .collect();
    assert_eq!(triangles.len(), faces);
    let low = positions.iter().copied().reduce(DVec3::min).unwrap();
    let high = positions.iter().copied().reduce(DVec3::max).unwrap();
    let side = (high - low).max_element();
    for p in &mut positions {
        *p = (*p - (low + high) / 2.0) / side;
    }
    let mut normals = vec![DVec3::ZERO; positions.len()];
    for t in &triangles {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        for v in t {
            normals[*v as usize] += (b - a).cross(c - a);
        }
    }
    for n in &mut normals {
        *n = n.try_normalize().unwrap_or(DVec3::Y);
    }
    Mesh {
        positions,
        normals,
        colours: Vec::new(),
        triangles,
    }
}

fn sampling(sequence: &[u8], separation: Separation) -> Sampling {
    Sampling {
        sequence: Sequence::new(sequence).unwrap(),
        separation,
        memory: 2 << 30,
    }
}

fn grow(mesh: &Mesh, sequence: &[u8], separation: Separation) -> Tree {
    sampling(sequence, separation)
        .sample(&Triangles::new(mesh), &AtomicU64::new(0))
        .unwrap()
}

/// The tables of Duguet & Drettakis 2003 print 26k and 230k nodes. The leaves were counted
/// once more by clipping triangles against boxes; the counts hold for boxes larger or smaller
/// by 1e-8, so no rounding decides them.
#[test]
fn the_bunny_has_the_cells_of_the_papers_table() {
    let bunny = scan("bunny.ply.gz");
    for (levels, leaves, nodes) in [(4, 22_459, 25_170), (5, 202_421, 227_591)] {
        let tree = grow(&bunny, &[3; 5][..levels], Separation::TwentySix);
        assert_eq!((tree.leaves(), tree.nodes()), (leaves, nodes));
    }
}

/// Times of sampling alone: `cargo test --release -p host-tools --test sampling -- --ignored
/// --nocapture`.
#[test]
#[ignore = "prints times"]
fn how_long_sampling_takes() {
    for (name, levels, separation) in [
        ("bunny.ply.gz", 4, Separation::TwentySix),
        ("bunny.ply.gz", 5, Separation::TwentySix),
        ("bunny.ply.gz", 5, Separation::Six),
        ("bunny.ply.gz", 6, Separation::TwentySix),
        ("dragon.ply.gz", 5, Separation::TwentySix),
        ("dragon.ply.gz", 5, Separation::Six),
    ] {
        let mesh = scan(name);
        let sampling = sampling(&[3; 6][..levels], separation);
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let start = Instant::now();
            let geometry = Triangles::new(&mesh);
            let ready = start.elapsed();
            let tree = pool
                .install(|| sampling.sample(&geometry, &AtomicU64::new(0)))
                .unwrap();
            println!(
                "{name} {separation:?} {} cells, {threads} threads: {:.3} s ({:.3} s to get ready), \
                 {} leaves (expected {}), {} nodes",
                sampling.sequence.cells(),
                start.elapsed().as_secs_f64(),
                ready.as_secs_f64(),
                tree.leaves(),
                sampling.expected_leaves(&geometry),
                tree.nodes()
            );
        }
    }
}
