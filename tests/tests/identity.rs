//! The same bits everywhere: the firmware in the emulator and the library on the PC.

use std::sync::Mutex;
use std::thread;

use host_tools::blob_file::BlobFile;
use host_tools::device::Run;
use host_tools::geometry::triangles::Triangles;
use host_tools::render;
use host_tools::sampling::Separation;
use host_tools::view::{STANDARD_LIGHT, StandardView, View};
use rho_grid::blob::Layout;
use rho_grid::mode::{
    FootprintMode, FrameMode, LightSplat, MapSize, Mode, Preset, ReciprocalMode, ShadowMode,
    VisibilityMode,
};
use rho_grid::q::PixelSize;
use rho_tests::firmware::{ask, firmware};
use rho_tests::random::Random;
use rho_tests::scan::{baked_bunny, bunny, encoded, sampled, standard, standard_bunny};
use rho_viewer::request::{Request, Scene};

/// How many emulators run at a time.
const AT_A_TIME: usize = 2;

/// A frame to be drawn twice.
struct Case<'a> {
    blob: &'a BlobFile,
    name: &'a str,
    view: View,
    mode: Mode,
}

impl Case<'_> {
    /// Draws it on both; how they differ, if they do.
    fn difference(&self) -> Option<String> {
        let request = Request::Model(Scene {
            camera: self.view.camera().unwrap(),
            light: render::light(STANDARD_LIGHT),
            mode: self.mode,
        });
        let host = render::render(
            &self.blob.blob().unwrap(),
            &self.view,
            STANDARD_LIGHT,
            self.mode,
        )
        .unwrap();
        let complain = |what: String| Some(format!("{what}: {} {:?}", self.name, request.line()));
        let device = match ask(&request.line(), Some(self.blob.bytes())).and_then(Run::done) {
            Ok(run) => run,
            Err(failure) => return complain(failure.to_string()),
        };
        if device.report.frame_crc32 != host.crc32() {
            return complain("the device's CRC is another".into());
        }
        let pixels = device.words.iter().zip(&host.words);
        let different = pixels.filter(|(a, b)| a != b).count();
        if different > 0 || device.words.len() != host.words.len() {
            return complain(format!("{different} pixels on the wire are others"));
        }
        None
    }
}

/// Every visibility with the frames that it can draw into, footprint and reciprocal; they take
/// turns with four cell sizes.
fn modes() -> Vec<Mode> {
    let mut modes = Vec::new();
    for (visibility, frame) in [
        (VisibilityMode::Eye, FrameMode::Words),
        (VisibilityMode::Eye, FrameMode::Tones),
        (VisibilityMode::Eye, FrameMode::Quarters),
        (VisibilityMode::Z, FrameMode::Words),
    ] {
        for &footprint in FootprintMode::ALL {
            for &reciprocal in ReciprocalMode::ALL {
                let mode = Mode {
                    visibility,
                    footprint,
                    reciprocal,
                    frame,
                    ..Mode::default()
                };
                if mode.contradiction().is_none() {
                    modes.push(mode);
                }
            }
        }
    }
    modes
}

/// The four standard views, twelve of any kind, and some that go where a division is by next
/// to nothing: inside the cube, at a surface, and with pixels much smaller than a cell.
fn views() -> Vec<View> {
    let mut random = Random::new(1);
    let mut views: Vec<View> = StandardView::ALL.into_iter().map(View::from).collect();
    views.extend((0..12).map(|_| random.view()));
    let near = View::from(StandardView::Near);
    views.extend([
        View {
            distance: 0.0,
            fov: 90.0,
            ..near
        },
        View {
            distance: 0.3125,
            yaw: 41.0,
            pitch: -7.0,
            ..near
        },
        // The bunny's back, seen from a hundredth of the cube above it.
        View {
            distance: 0.25,
            pitch: 90.0,
            zoom: 3.0,
            ..near
        },
        View {
            zoom: 40.0,
            width: 1,
            height: 320,
            ..near
        },
    ]);
    views
}

/// All that is computed is integers, so nothing may differ: a bit that does is a bug of the
/// compiler's or (rather) of ours, such as a `usize` that is 64 bits wide on the PC.
#[test]
fn host_and_device_draw_the_same_bits_in_every_mode_from_everywhere() {
    firmware();
    let sequences: [(&str, &[u8]); 4] = [
        ("81 cells", &[3; 4]),
        ("243 cells", &[3; 5]),
        ("2,5,3,3", &[2, 5, 3, 3]),
        ("4,3,2", &[4, 3, 2]),
    ];
    let mut blobs = Vec::from(sequences.map(|(name, sequence)| (name, baked_bunny(sequence))));
    // Thin cells, samples with offsets: discs are moved.
    let thin = sampled(&Triangles::new(bunny()), &[2, 3, 3, 3, 3], Separation::Six);
    blobs.push(("2,3,3,3,3 thin", encoded(&thin, Layout::OFFSET_THIN)));
    let mut cases = Vec::new();
    for (v, view) in views().into_iter().enumerate() {
        for (m, mode) in modes().into_iter().enumerate() {
            // From view to view the two reciprocals take turns.
            if m % 2 == v / 2 % 2 {
                continue;
            }
            // So do blobs and cell sizes (256 to the pixel): each meets every mode.
            let (name, blob) = &blobs[(m / 2 + v) % blobs.len()];
            let size = [128, 0, 300, 1500][(m / 2 + v + v / 4) % 4];
            cases.push(Case {
                blob,
                name,
                view,
                mode: Mode {
                    cell_size: PixelSize::from_bits(size),
                    ..mode
                },
            });
        }
    }
    all_the_same(&cases);
}

/// What a user gets who chooses nothing but a preset. The host draws each mask pixel by pixel, the
/// device four pixels a word.
#[test]
fn host_and_device_draw_the_same_bits_by_every_preset_from_everywhere() {
    firmware();
    // Words with an offset; and with a material as well.
    let teapot = standard("teapot");
    let mut cases = Vec::new();
    for (name, blob) in [("the bunny", standard_bunny()), ("the teapot", &teapot)] {
        for view in views() {
            for preset in Preset::ALL {
                cases.push(Case {
                    blob,
                    name,
                    view,
                    mode: preset.mode(&blob.blob().unwrap(), &view.camera().unwrap()),
                });
            }
        }
    }
    let grids = |blob: &BlobFile| {
        let of = cases
            .iter()
            .filter(|case| case.blob.bytes() == blob.bytes());
        let mut grids: Vec<u16> = of.map(|case| case.mode.grid).collect();
        grids.sort_unstable();
        grids.dedup();
        grids
    };
    assert_eq!(
        grids(standard_bunny()),
        [0, 1, 2, 3, 4, 5],
        "each serves some view"
    );
    all_the_same(&cases);
}

/// Shadows, by maps and splats of every size, into every frame, by two passes and by one; of presets they
/// are looked up in assembly.
#[test]
fn host_and_device_draw_the_same_shadows() {
    firmware();
    let boxes = baked_bunny(&[3; 5]);
    let teapot = standard("teapot");
    let blobs = [
        ("the bunny", standard_bunny()),
        ("243 cells", &boxes),
        ("the teapot", &teapot),
    ];
    let mut cases = Vec::new();
    for (v, view) in views().into_iter().enumerate() {
        for (b, (name, blob)) in blobs.into_iter().enumerate() {
            let n = v + b;
            let preset = Preset::ALL[n % Preset::ALL.len()];
            let mode = preset.mode(&blob.blob().unwrap(), &view.camera().unwrap());
            let visibility = VisibilityMode::ALL[n / 3 % 2];
            let mut modes = vec![mode];
            if n % 4 == 0 {
                modes.push(Mode {
                    visibility,
                    frame: FrameMode::Words,
                    ..mode
                });
            }
            if n % 4 == 1 {
                modes.push(Mode {
                    visibility: VisibilityMode::Z,
                    frame: FrameMode::Words,
                    shadows: ShadowMode::OnePass,
                    ..mode
                });
            }
            cases.extend(modes.into_iter().map(|mode| Case {
                blob,
                name,
                view,
                mode: Mode {
                    shadows: match mode.shadows {
                        ShadowMode::None => [ShadowMode::TwoPass, ShadowMode::Kept][n % 2],
                        shadows => shadows,
                    },
                    shadow_map: MapSize::ALL[v % 3],
                    light_splat: LightSplat::of(1 + (v / 3 % 4) as u16).unwrap(),
                    ..mode
                },
            }));
        }
    }
    all_the_same(&cases);
}

/// Draws every case on both, several at a time.
fn all_the_same(cases: &[Case<'_>]) {
    let queue = Mutex::new(cases.iter());
    let differences = Mutex::new(Vec::new());
    thread::scope(|scope| {
        for _ in 0..AT_A_TIME {
            scope.spawn(|| {
                loop {
                    let Some(case) = queue.lock().unwrap().next() else {
                        break;
                    };
                    if let Some(difference) = case.difference() {
                        differences.lock().unwrap().push(difference);
                    }
                }
            });
        }
    });
    let differences = differences.into_inner().unwrap();
    assert!(
        differences.is_empty(),
        "{} of {} frames differ:\n{}",
        differences.len(),
        cases.len(),
        differences.join("\n")
    );
}
