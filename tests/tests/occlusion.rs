//! Which sample a pixel shows: what eye order skips is not missed, and where the methods differ.

use std::sync::OnceLock;

use host_tools::blob_file::BlobFile;
use host_tools::geometry::triangles::Triangles;
use host_tools::picture::rgb888;
use host_tools::render;
use host_tools::sampling::{Separation, Tree};
use host_tools::view::{STANDARD_LIGHT, StandardView, View};
use rho_grid::blob::{Grid, Layout};
use rho_grid::camera::Camera;
use rho_grid::frame::Frame;
use rho_grid::lighting::Lighting;
use rho_grid::mode::{FootprintMode, Mode, ReciprocalMode, VisibilityMode};
use rho_grid::q::PixelSize;
use rho_grid::render::{EyeOrder, Rect, View as Tables, Visibility, draw_seen};
use rho_grid::shading::Shading;
use rho_tests::random::Random;
use rho_tests::scan::{bunny, encoded, sampled};

/// The bunny at 243 cells, at 90 in a mixed sequence, and in thin cells with offsets.
fn blobs() -> &'static [BlobFile] {
    static BLOBS: OnceLock<Vec<BlobFile>> = OnceLock::new();
    BLOBS.get_or_init(|| {
        let bunny = Triangles::new(bunny());
        let of = |sequence: &[u8], separation, layout| {
            encoded(&sampled(&bunny, sequence, separation), layout)
        };
        vec![
            of(&[3; 5], Separation::TwentySix, Layout::MATERIAL),
            of(&[2, 5, 3, 3], Separation::TwentySix, Layout::MATERIAL),
            of(&[2, 3, 3, 3, 3], Separation::Six, Layout::OFFSET_THIN),
        ]
    })
}

/// Forty views: the standard ones, others from the same distance, and any.
fn views() -> Vec<View> {
    let mut random = Random::new(3);
    let mut views: Vec<View> = StandardView::ALL.into_iter().map(View::from).collect();
    views.extend((0..16).map(|_| random.side(2.2883)));
    views.extend((0..20).map(|_| random.view()));
    views
}

fn words(blob: &BlobFile, view: &View, mode: Mode) -> Vec<u16> {
    render::render(&blob.blob().unwrap(), view, STANDARD_LIGHT, mode)
        .unwrap()
        .words
}

/// A visibility method that never says that anything is hidden, so that every cell in view is
/// visited and every leaf is drawn, and that counts them.
struct Patient<V> {
    inner: V,
    drawn: usize,
}

impl<V: Visibility> Visibility for Patient<V> {
    const FRONT_TO_BACK: bool = V::FRONT_TO_BACK;

    fn is_hidden(&self, _: Rect) -> bool {
        false
    }

    /// What is drawn depends on this: it is no skipping.
    fn is_open(&self, x: u32, y: u32) -> bool {
        self.inner.is_open(x, y)
    }

    fn draw(&mut self, rect: Rect, w: i32, colour: impl FnOnce() -> u16) {
        self.drawn += 1;
        self.inner.draw(rect, w, colour);
    }
}

/// A frame in eye order without skipping, and how many samples were drawn for it.
fn patiently(blob: &BlobFile, view: &View, mode: Mode) -> (Vec<u16>, usize) {
    let camera = view.camera().unwrap();
    let blob = blob.blob().unwrap();
    let grid = blob.grid(0).unwrap();
    let mut tables = Box::new(Tables::empty());
    tables.prepare(&camera, &grid, mode.cell_size).unwrap();
    let mut colours = vec![0; Shading::words(blob.materials().len())];
    let light = render::light(STANDARD_LIGHT);
    let shading = Shading::new(
        &mut colours,
        grid.layout(),
        blob.materials(),
        &Lighting::white(light),
    )
    .unwrap();
    let (width, height) = (camera.width, camera.height);
    let mut words = vec![0; usize::from(width) * usize::from(height)];
    let mut frame = Frame::new(&mut words, width, height).unwrap();
    let mut coverage = vec![0; EyeOrder::words(width, height)];
    let mut target = Patient {
        inner: EyeOrder::new(&mut frame, &mut coverage).unwrap(),
        drawn: 0,
    };
    draw_seen(mode, &grid, &tables, &shading, &mut target);
    let drawn = target.drawn;
    (words, drawn)
}

/// A cell is skipped when all pixels that a point of it may be projected to are covered. A block
/// of boxes widens its leaves by what their steps may be off, beyond their cells: such a pixel,
/// where the model is not, may be skipped with the cell. Nothing else may.
#[test]
fn skipping_what_is_hidden_loses_nothing_but_overhang() {
    let (mut pixels, mut lost) = (0, 0);
    for (v, view) in views().iter().enumerate() {
        let blob = &blobs()[v % blobs().len()];
        for (f, &footprint) in FootprintMode::ALL.iter().enumerate() {
            let mode = Mode {
                footprint,
                cell_size: PixelSize::from_bits([128, 0, 512][(v / 3 + f) % 3]),
                ..Mode::default()
            };
            let (patient, _) = patiently(blob, view, mode);
            let skipping = words(blob, view, mode);
            let different = patient.iter().zip(&skipping).filter(|(a, b)| a != b);
            if footprint == FootprintMode::Box {
                pixels += patient.iter().filter(|word| **word != 0).count();
                lost += different.count();
            } else {
                assert_eq!(different.count(), 0, "{mode:?} {view:?}");
            }
        }
    }
    println!("boxes: {lost} of {pixels} pixels");
    assert!(lost * 5000 <= pixels, "{lost} of {pixels}");
}

/// Both find the same integer (which a unit test proves for each); so do the frames.
#[test]
fn the_table_and_the_divider_give_the_same_frame() {
    for (v, view) in views().iter().enumerate() {
        let blob = &blobs()[v % blobs().len()];
        for &footprint in FootprintMode::ALL {
            let mode = Mode {
                footprint,
                visibility: VisibilityMode::ALL[v % 2],
                ..Mode::default()
            };
            let table = Mode {
                reciprocal: ReciprocalMode::Table,
                ..mode
            };
            assert!(
                words(blob, view, mode) == words(blob, view, table),
                "{mode:?} {view:?}"
            );
        }
    }
}

/// Whether a channel differs by more than a tenth of white.
fn is_seen(a: u16, b: u16) -> bool {
    let channels = rgb888(a).into_iter().zip(rgb888(b));
    channels.into_iter().any(|(a, b)| a.abs_diff(b) > 25)
}

/// Eye order is exact for cells that hide each other. Where one footprint only overhangs
/// another's cell, the first in order stays, though the other may be nearer: a neighbour, mostly
/// of the same colour. Boxes, discs and points overhang little, splats by whole pixels.
///
/// Eye order never covers a pixel that the depth buffer leaves open. It leaves some open that the
/// depth buffer covers: what is skipped (see the test of that), and of discs the edges of those
/// that face away. In eye order these are not drawn where all in their middle is covered; to the depth
/// buffer every pixel is open, and it has them whole.
#[test]
fn eye_order_and_the_depth_buffer_show_the_same_but_where_footprints_overhang() {
    for (footprint, limit) in [
        (FootprintMode::Point, 0.002),
        (FootprintMode::Splat, 0.12),
        (FootprintMode::Box, 0.01),
        (FootprintMode::Disc, 0.015),
    ] {
        let (mut covered, mut more, mut less, mut seen) = (0, 0, 0, 0);
        for (v, view) in views().iter().enumerate() {
            let blob = &blobs()[v % blobs().len()];
            let of = |visibility| {
                let mode = Mode {
                    visibility,
                    footprint,
                    ..Mode::default()
                };
                words(blob, view, mode)
            };
            for (eye, z) in of(VisibilityMode::Eye)
                .into_iter()
                .zip(of(VisibilityMode::Z))
            {
                covered += usize::from(z != 0);
                more += usize::from(eye != 0 && z == 0);
                less += usize::from(eye == 0 && z != 0);
                seen += usize::from(is_seen(eye, z));
            }
        }
        println!("{footprint}: of {covered} pixels {seen} differ, {more} more, {less} less");
        let part = seen as f64 / covered as f64;
        assert!(part <= limit, "{footprint}: {part}");
        assert_eq!(more, 0, "{footprint}");
        let open = match footprint {
            FootprintMode::Point | FootprintMode::Splat => 0,
            FootprintMode::Box | FootprintMode::Disc => covered / 10_000,
        };
        assert!(less <= open, "{footprint}: {less}");
    }
}

/// The bunny's samples with those of all intermediate cells turned to face the other way.
fn turned_inside(tree: &Tree) -> Tree {
    let mut tree = tree.clone();
    let inner = tree.levels.len() - 1;
    for level in &mut tree.levels[..inner] {
        for sample in &mut level.samples {
            sample.normal = -sample.normal;
        }
    }
    tree
}

/// At size 0 no cell is small enough to be drawn from its own sample, however far it is.
#[test]
fn at_cell_size_0_only_leaves_are_drawn_and_each_once() {
    let tree = sampled(
        &Triangles::new(bunny()),
        &[3, 3, 4, 2],
        Separation::TwentySix,
    );
    let blob = encoded(&tree, Layout::MATERIAL);
    let turned = encoded(&turned_inside(&tree), Layout::MATERIAL);
    for view in [StandardView::Near, StandardView::FarTurned] {
        let view = View::from(view);
        for &footprint in FootprintMode::ALL {
            let mode = |cell_size| Mode {
                footprint,
                cell_size: PixelSize::from_bits(cell_size),
                ..Mode::default()
            };
            let leaves = words(&blob, &view, mode(0));
            assert!(leaves == words(&turned, &view, mode(0)), "{footprint}");
            // Where intermediate samples do show, the turned ones are seen.
            assert!(words(&blob, &view, mode(2000)) != words(&turned, &view, mode(2000)));
        }
        // All in view, and each has a pixel of its own.
        let point = Mode {
            footprint: FootprintMode::Point,
            cell_size: PixelSize::ZERO,
            ..Mode::default()
        };
        assert_eq!(patiently(&blob, &view, point).1, tree.leaves());
    }
}

/// The places of a grid's leaves, in cells of the leaves' level.
fn leaves(grid: &Grid<'_>) -> Vec<[i32; 3]> {
    let mut places = vec![[0; 3]];
    for level in grid.levels() {
        let rho = i32::from(level.rho);
        let subcells = |node: usize, [x, y, z]: [i32; 3]| {
            let mask = level.mask_any(node as u32);
            (0..rho.pow(3))
                .filter(move |bit| mask[*bit as usize / 32] >> (bit % 32) & 1 == 1)
                .map(move |bit| {
                    let [i, j, k] = [bit % rho, bit / rho % rho, bit / (rho * rho)];
                    [x * rho + i, y * rho + j, z * rho + k]
                })
        };
        let below = places.iter().enumerate();
        places = below.flat_map(|(node, at)| subcells(node, *at)).collect();
    }
    places
}

/// Of a grid's leaves, those whose centres are in front of the eye and a quarter of a cell within the
/// frame, and those that are within so many cells of it.
fn in_view(grid: &Grid<'_>, camera: &Camera, cells_around: f64) -> [usize; 2] {
    let cells = f64::from(grid.cells(grid.subdivisions()));
    let rotation = camera.rotation.map(|row| row.map(|v| v.to_num::<f64>()));
    let translation = camera.translation.map(|v| v.to_num::<f64>());
    let focal = camera.focal.to_num::<f64>();
    let half = [camera.width, camera.height].map(|side| f64::from(side) / 2.0);
    let counts = |margin: f64| {
        let is_seen = |place: &[i32; 3]| {
            let p = place.map(|c| (f64::from(c) + 0.5) / cells - 0.5);
            let eye: [f64; 3] = std::array::from_fn(|i| {
                translation[i] + (0..3).map(|k| rotation[i][k] * p[k]).sum::<f64>()
            });
            let depth = -eye[2] + margin;
            // How far outside the planes through the frame's edges.
            let beyond =
                |along: f64, half: f64| (along.abs() * focal - half * depth) / focal.hypot(half);
            depth > 0.0 && beyond(eye[0], half[0]) <= margin && beyond(eye[1], half[1]) <= margin
        };
        leaves(grid).iter().filter(|place| is_seen(place)).count()
    };
    // Where they are on the screen is rounded.
    [counts(-0.25 / cells), counts(cells_around / cells)]
}

/// From inside, and enlarged, what is visited is what is in view: all of that, and little more.
#[test]
fn only_what_is_in_view_is_refined() {
    let blob = &blobs()[0];
    let grid = blob.blob().unwrap().grid(0).unwrap();
    let all = grid.leaf_samples() as usize;
    let mode = Mode {
        footprint: FootprintMode::Point,
        cell_size: PixelSize::ZERO,
        ..Mode::default()
    };
    let near = View::from(StandardView::Near);
    let (_, whole) = patiently(blob, &near, mode);
    assert_eq!(whole, all, "nothing is left out of what is all in view");
    for (distance, zoom) in [
        (2.2883, 6.0),
        (2.2883, 24.0),
        (0.3, 1.0),
        (0.1, 1.0),
        (0.02, 4.0),
    ] {
        for yaw in [0.0, 70.0, 200.0] {
            let view = View {
                distance,
                zoom,
                yaw,
                pitch: 15.0,
                ..near
            };
            let (_, drawn) = patiently(blob, &view, mode);
            let [least, most] = in_view(&grid, &view.camera().unwrap(), 4.0);
            println!(
                "distance {distance}, zoom {zoom}, yaw {yaw}: {drawn} drawn, {least} to {most} of {all} in view"
            );
            assert!((least..=most).contains(&drawn), "{view:?}");
        }
    }
}
