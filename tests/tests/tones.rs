//! Frames of a byte a pixel: the fast ways to draw into them against slow ones.

use host_tools::blob_file::BlobFile;
use host_tools::geometry::triangles::Triangles;
use host_tools::mesh::Mesh;
use host_tools::render;
use host_tools::sampling::Separation;
use host_tools::view::{STANDARD_LIGHT, View};
use rho_grid::blob::{Blob, Layout};
use rho_grid::mode::{Mode, Preset};
use rho_grid::reciprocal::Divide;
use rho_grid::render::footprint::Disc;
use rho_grid::render::{Rect, Stamp, Tones, View as Tables, Visibility, draw, tone_words};
use rho_grid::scene::{Placed, SceneTones};
use rho_tests::model::octahedron;
use rho_tests::random::Random;
use rho_tests::scan::{bunny, encoded, sampled, standard_bunny};

/// Forwards all that a frame of tones does, and counts the masks laid.
struct Counting<V> {
    inner: V,
    stamps: usize,
}

impl<V: Visibility> Visibility for Counting<V> {
    const FRONT_TO_BACK: bool = V::FRONT_TO_BACK;

    fn is_hidden(&self, rect: Rect) -> bool {
        self.inner.is_hidden(rect)
    }

    fn is_open(&self, x: u32, y: u32) -> bool {
        self.inner.is_open(x, y)
    }

    fn draw(&mut self, rect: Rect, w: i32, colour: impl FnOnce() -> u16) {
        self.inner.draw(rect, w, colour);
    }

    fn corner(&self, x: i32, y: i32) -> u32 {
        self.inner.corner(x, y)
    }

    fn stamp(&mut self, stamp: Stamp, mask: impl FnOnce() -> u32, colour: impl Fn() -> u16) {
        self.stamps += 1;
        self.inner.stamp(stamp, mask, colour);
    }
}

/// The same but for masks, which the trait's own method lays, pixel by pixel.
struct PixelByPixel<V>(V);

impl<V: Visibility> Visibility for PixelByPixel<V> {
    const FRONT_TO_BACK: bool = V::FRONT_TO_BACK;

    fn is_hidden(&self, rect: Rect) -> bool {
        self.0.is_hidden(rect)
    }

    fn is_open(&self, x: u32, y: u32) -> bool {
        self.0.is_open(x, y)
    }

    fn draw(&mut self, rect: Rect, w: i32, colour: impl FnOnce() -> u16) {
        self.0.draw(rect, w, colour);
    }
}

/// A grid of a blob and a view of it, ready to be drawn.
struct Scene<'a> {
    blob: Blob<'a>,
    grid: u16,
    tables: Box<Tables>,
    shades: Box<SceneTones>,
    width: u16,
    height: u16,
}

impl<'a> Scene<'a> {
    fn new(blob: Blob<'a>, grid: u16, view: &View) -> Self {
        let of = blob.grid(grid).unwrap();
        let mut tables = Box::new(Tables::empty());
        let camera = view.camera().unwrap();
        let mode = Mode {
            grid,
            ..Mode::default()
        };
        tables.prepare(&camera, &of, mode.cell_size).unwrap();
        let mut shades = Box::new(SceneTones::empty());
        let placed = Placed::new(&blob, 0, &camera, mode).unwrap();
        shades.shade(&blob, &placed, render::light(STANDARD_LIGHT));
        Self {
            blob,
            grid,
            tables,
            shades,
            width: view.width,
            height: view.height,
        }
    }

    /// Draws it; the pixels that it may reach.
    fn draw(&self, target: &mut impl Visibility) -> Option<Rect> {
        let grid = self.blob.grid(self.grid).unwrap();
        draw::<_, Disc, Divide>(&grid, &self.tables, &*self.shades, target)
    }

    /// The frame with rows of `stride` bytes, filled.
    fn drawn(&self, stride: usize) -> Vec<u8> {
        let mut buffer = vec![u32::MAX; tone_words(stride, self.height)];
        let mut tones =
            Tones::cleared(&mut buffer, stride, self.width, self.height).expect("the frame fits");
        if let Some(reach) = self.draw(&mut tones) {
            tones.fill(reach);
        }
        tones.rows().flatten().copied().collect()
    }
}

/// Triangles here and there, of any size: open surfaces, seen from both sides.
fn soup(random: &mut Random) -> Mesh {
    let mut mesh = Mesh {
        positions: Vec::new(),
        normals: Vec::new(),
        colours: Vec::new(),
        triangles: Vec::new(),
    };
    for _ in 0..12 {
        let mut corner = || [0; 3].map(|_| random.between(-0.5, 0.5)).into();
        let corners: [glam::DVec3; 3] = [corner(), corner(), corner()];
        let [a, b, c] = corners;
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners);
        mesh.normals.extend([(b - a).cross(c - a).normalize(); 3]);
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    mesh
}

/// Of closed and open surfaces, thin and not, in several sequences.
fn blobs(random: &mut Random) -> Vec<BlobFile> {
    let (octahedron, soup) = (octahedron(), soup(random));
    let of = |mesh: &Mesh, sequence: &[u8], separation, layout| {
        encoded(
            &sampled(&Triangles::new(mesh), sequence, separation),
            layout,
        )
    };
    let thin = (Separation::Six, Layout::OFFSET_THIN);
    let thick = (Separation::TwentySix, Layout::OFFSET);
    vec![
        standard_bunny().clone(),
        of(bunny(), &[4, 3, 3], thick.0, thick.1),
        of(&octahedron, &[5, 3, 3], thin.0, thin.1),
        of(&octahedron, &[2, 3], thin.0, thin.1),
        of(&soup, &[3; 4], thin.0, thin.1),
        of(&soup, &[2, 2, 3, 3], thick.0, thick.1),
    ]
}

/// From where discs are stamped, and from anywhere.
fn view(random: &mut Random) -> View {
    match random.bits() % 3 {
        0 => loop {
            // A focal length beyond its Q format is refused.
            let view = random.view();
            if view.camera().is_ok() {
                break view;
            }
        },
        _ => {
            let distance = random.between_by_factor(0.8, 16.0);
            random.side(distance)
        }
    }
}

#[test]
fn a_mask_laid_by_words_is_the_mask_laid_pixel_by_pixel() {
    let mut random = Random::new(21);
    let blobs = blobs(&mut random);
    let mut stamped = 0;
    for _ in 0..400 {
        let view = view(&mut random);
        let blob = blobs[random.bits() as usize % blobs.len()].blob().unwrap();
        let grid = random.bits() as u16 % blob.grid_count();
        let scene = Scene::new(blob, grid, &view);
        let buffer = || vec![0; tone_words(240, view.height)];
        let [mut by_words, mut by_pixels] = [buffer(), buffer()];
        let tones = |buffer| Tones::cleared(buffer, 240, view.width, view.height).unwrap();
        let mut counting = Counting {
            inner: tones(&mut by_words),
            stamps: 0,
        };
        let reach = scene.draw(&mut counting);
        stamped += usize::from(counting.stamps > 0);
        assert_eq!(reach, scene.draw(&mut PixelByPixel(tones(&mut by_pixels))));
        // The margins are compared too.
        assert!(by_words == by_pixels, "grid {grid} {view:?}");
    }
    println!("{stamped} of 400 frames have masks");
    assert!(stamped > 150, "{stamped}");
}

/// Windows stick out of rows, and rows follow each other without gaps: a byte too far, read or written,
/// is a pixel of the next row where the picture is as wide as the rows, and none where it is narrower.
#[test]
fn a_frame_is_the_same_in_rows_of_any_width() {
    fn compare(stride: u16, random: &mut Random) -> usize {
        let blob = standard_bunny();
        let mut covered = 0;
        for turn in 0..24 {
            // As wide as the rows, and narrower.
            let narrower = (random.bits() % u64::from(stride)) as u16 * u16::from(turn % 2 == 1);
            let view = View {
                width: stride - narrower,
                height: 1 + (random.bits() % 400) as u16,
                ..view(random)
            };
            let preset = Preset::ALL[random.bits() as usize % Preset::ALL.len()];
            let Ok(camera) = view.camera() else {
                continue;
            };
            let blob = blob.blob().unwrap();
            let grid = preset.mode(&blob, &camera).grid;
            let scene = Scene::new(blob, grid, &view);
            let tight = scene.drawn(stride.into());
            let wide = scene.drawn(1024);
            assert!(tight == wide, "rows of {stride}, grid {grid}, {view:?}");
            covered += tight.iter().filter(|tone| **tone != 0).count();
        }
        covered
    }
    let mut random = Random::new(22);
    let covered = [4, 12, 36, 100, 240, 1000].map(|stride| compare(stride, &mut random));
    println!("{covered:?} pixels");
    assert!(covered.iter().all(|pixels| *pixels > 20), "{covered:?}");
}

/// As above for what is filled: no pixel counts a neighbour that is in another row.
#[test]
fn what_is_filled_is_the_same_in_rows_of_any_width() {
    fn filled(stride: usize, width: u16, open: &[Rect]) -> Vec<u8> {
        let height = 40;
        let mut buffer = vec![0; tone_words(stride, height)];
        let mut tones = Tones::cleared(&mut buffer, stride, width, height).unwrap();
        for (y, x) in
            (0..u32::from(height)).flat_map(|y| (0..u32::from(width)).map(move |x| (y, x)))
        {
            let inside = |r: &Rect| (r.x0..=r.x1).contains(&x) && (r.y0..=r.y1).contains(&y);
            let pixel = Rect {
                x0: x,
                x1: x,
                y0: y,
                y1: y,
            };
            if !open.iter().any(inside) {
                tones.draw(pixel, 0, || ((2 * (x + y) as u16) & 0xFE) + 1);
            }
        }
        tones.fill(Rect {
            x0: 0,
            x1: u32::from(width) - 1,
            y0: 0,
            y1: u32::from(height) - 1,
        });
        tones.rows().flatten().copied().collect()
    }
    let mut random = Random::new(23);
    for turn in 0..400 {
        let width = 240 - (turn % 40) as u16;
        // Single pixels, strips along a row and down a column.
        let open: Vec<Rect> = (0..200)
            .map(|_| {
                let mut below = |side: u32| (random.bits() % u64::from(side)) as u32;
                let (x0, y0) = (below(width.into()), below(40));
                let (dx, dy) =
                    [(0, 0), (below(9), 0), (0, below(4)), (below(40), 0)][below(4) as usize];
                Rect {
                    x0,
                    x1: x0 + dx,
                    y0,
                    y1: y0 + dy,
                }
            })
            .collect();
        let (tight, wide) = (filled(240, width, &open), filled(1024, width, &open));
        let differ = tight.iter().zip(&wide).position(|(a, b)| a != b);
        let at = differ.map(|at| (at % usize::from(width), at / usize::from(width)));
        assert_eq!(at, None, "{width} pixels a row");
    }
}
