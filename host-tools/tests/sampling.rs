//! Sampling whole models: the number of cells, the shape of the teapot, and how long it takes.

use std::path::Path;
use std::sync::atomic::AtomicU64;
use std::time::Instant;

use glam::DVec3;
use host_tools::geometry::Geometry;
use host_tools::geometry::procedural::Procedural;
use host_tools::geometry::teapot::Teapot;
use host_tools::geometry::triangles::Triangles;
use host_tools::mesh::Mesh;
use host_tools::model::{self, LoadOptions};
use host_tools::sampling::{Sampling, Separation, Sequence};

fn scan(name: &str) -> Mesh {
    let path = model::scan(name).unwrap_or_else(|failure| panic!("{failure}"));
    load(&path)
}

fn load(path: &Path) -> Mesh {
    match model::load(path, &LoadOptions::default()) {
        Ok(loaded) => loaded.mesh,
        Err(failure) => panic!("{failure}"),
    }
}

fn sampling(sequence: &[u8], separation: Separation) -> Sampling {
    Sampling {
        sequence: Sequence::new(sequence).unwrap(),
        separation,
        memory: 2 << 30,
    }
}

/// The tables of Duguet & Drettakis 2003 print 26k and 230k nodes. The leaves were counted
/// once more by clipping triangles against boxes; the counts hold for boxes larger or smaller
/// by 1e-8, so no rounding decides them.
#[test]
fn the_bunny_has_the_cells_of_the_papers_table() {
    let bunny = scan("bunny");
    for (levels, leaves, nodes) in [(4, 22_459, 25_170), (5, 202_421, 227_591)] {
        let tree = sampling(&[3; 5][..levels], Separation::TwentySix)
            .sample(&Triangles::new(&bunny), &AtomicU64::new(0))
            .unwrap();
        assert_eq!((tree.leaves(), tree.nodes()), (leaves, nodes));
    }
}

/// Every vertex of a tessellation made by others lies on the patches, but for rounding to
/// f32: so all control points are right.
#[test]
fn the_teapot_has_the_shape_that_everyone_knows() {
    let known = scan("teapot");
    // Without the slab the pot is 6.434 wide and its middle 1.575 above the slab.
    let (size, up) = (6.434 / 7.2, (1.575 - 1.425) / 7.2);
    let pot = Teapot::new();
    let all: Vec<u32> = (0..pot.primitives()).collect();
    for vertex in known.positions.iter().step_by(41) {
        let place = *vertex * size + up * DVec3::Y;
        let off = pot.sample_at(&all, place).unwrap().position.distance(place);
        assert!(off < 1e-6, "{place} is {off} off");
    }
}

#[test]
fn the_teapot_and_its_triangles_meet_the_same_cells() {
    let pot = Teapot::new();
    let mesh = pot.mesh();
    for separation in [Separation::TwentySix, Separation::Six] {
        let sampling = sampling(&[2, 3, 3, 3], separation);
        let leaves = AtomicU64::new(0);
        let true_tree = sampling.sample(&pot, &leaves).unwrap();
        let tree = sampling.sample(&Triangles::new(&mesh), &leaves).unwrap();
        let (a, b) = (true_tree.leaves() as f64, tree.leaves() as f64);
        assert!((a / b - 1.0).abs() < 1e-3, "{a} {b}");
        // Discs of both lie in the same planes.
        let (a, b) = (&true_tree.levels[1], &tree.levels[1]);
        assert_eq!(a.masks.len(), b.masks.len());
        for (a, b) in a.samples.iter().zip(&b.samples) {
            assert!(a.normal.dot(b.normal) > 0.999, "{a:?} {b:?}");
            assert!((a.offset - b.offset).abs() < 1e-3, "{a:?} {b:?}");
        }
    }
}

/// A box that is nearer to the surface than a sixteenth of its diagonal counts as met, so
/// there are a few leaves more; crossings are exact.
#[test]
fn an_implicit_object_and_its_triangles_meet_the_same_cells() {
    let shapes = Procedural::named("shapes").unwrap();
    let duck = shapes.make(&shapes.defaults()).unwrap();
    let mesh = duck.mesh();
    for (separation, more) in [(Separation::TwentySix, 1.06), (Separation::Six, 1.005)] {
        let sampling = sampling(&[3; 4], separation);
        let leaves = AtomicU64::new(0);
        let true_tree = sampling.sample(&*duck, &leaves).unwrap();
        let tree = sampling.sample(&Triangles::new(&mesh), &leaves).unwrap();
        let ratio = true_tree.leaves() as f64 / tree.leaves() as f64;
        assert!((0.995..more).contains(&ratio), "{separation:?} {ratio}");
    }
}

/// Times of sampling alone: `cargo test --release -p host-tools --test sampling -- --ignored
/// --nocapture`.
#[test]
#[ignore = "prints times"]
fn how_long_sampling_takes() {
    let start = Instant::now();
    let pot = Teapot::new();
    println!("teapot laid out in {:.3} s", start.elapsed().as_secs_f64());
    for levels in [4, 5, 6] {
        time("teapot", &pot, &[3; 6][..levels]);
    }
    for name in [
        "bunny",
        "dragon",
        "buddha_100k",
        "tree_oak",
        "autzen_terrain_color",
    ] {
        let start = Instant::now();
        let mesh = scan(name);
        let read = start.elapsed();
        let geometry = Triangles::new(&mesh);
        println!(
            "{name}: {} triangles, read in {:.3} s, made ready in {:.3} s",
            mesh.triangles.len(),
            read.as_secs_f64(),
            (start.elapsed() - read).as_secs_f64()
        );
        for levels in [4, 5, 6] {
            time(name, &geometry, &[3; 6][..levels]);
        }
    }
}

fn time(name: &str, geometry: &impl Geometry, sequence: &[u8]) {
    for separation in [Separation::TwentySix, Separation::Six] {
        let sampling = sampling(sequence, separation);
        let expected = sampling.expected_leaves(geometry);
        let mut seconds = Vec::new();
        let mut counts = (0, 0);
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let start = Instant::now();
            let tree = pool
                .install(|| sampling.sample(geometry, &AtomicU64::new(0)))
                .unwrap();
            seconds.push(start.elapsed().as_secs_f64());
            counts = (tree.leaves(), tree.nodes());
        }
        println!(
            "{name} {separation:?} {} cells: {:.3} s on 1 thread, {:.3} s on 2; {} leaves \
             (expected {expected}), {} nodes",
            sampling.sequence.cells(),
            seconds[0],
            seconds[1],
            counts.0,
            counts.1
        );
    }
}
