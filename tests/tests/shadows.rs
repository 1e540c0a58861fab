//! Shadows against those of the ray-caster, and what they cost.

use std::sync::OnceLock;

use glam::DVec3;
use host_tools::bake::{BakeOptions, GridChoice, LayoutChoice, Progress, SampleChoice, bake};
use host_tools::blob_file::BlobFile;
use host_tools::model;
use host_tools::picture::Picture;
use host_tools::reference::{Caster, Shot};
use host_tools::render;
use host_tools::sampling::{Separation, Sequence};
use host_tools::shadows::{Pair, Wrong, compare};
use host_tools::view::{STANDARD_LIGHT, StandardView, View};
use rho_grid::mode::{
    FootprintMode, FrameMode, LightSplat, MapSize, Mode, Preset, ShadowMode, VisibilityMode,
};
use rho_tests::firmware::ask;
use rho_tests::scan::{bunny, standard_bunny};
use rho_viewer::count::Phase;
use rho_viewer::report::Report;
use rho_viewer::request::{Request, Scene};

/// Sides from which shadows are longer than from the standard scene's.
const LOW: [DVec3; 3] = [
    DVec3::new(1.0, 0.5, 0.2),
    DVec3::new(-0.9, 0.6, 0.1),
    DVec3::new(0.2, 1.0, 0.1),
];

fn caster() -> &'static Caster<'static> {
    static CASTER: OnceLock<Caster<'static>> = OnceLock::new();
    CASTER.get_or_init(|| Caster::new(bunny()))
}

/// One ray through each pixel's centre, with shadows and without.
fn truth(view: View, light: DVec3) -> [Picture; 2] {
    [true, false].map(|shadows| {
        let shot = Shot {
            samples: 1,
            light: light.normalize(),
            shadows,
            ..Shot::standard(view)
        };
        caster().render(&shot, &|| ()).unwrap().picture
    })
}

fn mode(preset: Preset, view: &View, shadow_map: u16) -> Mode {
    Mode {
        shadows: ShadowMode::TwoPass,
        shadow_map: MapSize::of(shadow_map).unwrap(),
        ..preset.mode(&standard_bunny().blob().unwrap(), &view.camera().unwrap())
    }
}

fn drawn(view: &View, light: DVec3, mode: Mode) -> Picture {
    let drawn = render::render(&standard_bunny().blob().unwrap(), view, light, mode).unwrap();
    Picture::from_rgb565(drawn.width.into(), drawn.height.into(), &drawn.words)
}

/// How a mode shades a view, against the truth.
fn judged(view: View, light: DVec3, mode: Mode, [shadowed, lit]: &[Picture; 2]) -> Wrong {
    let bare = Mode {
        shadows: ShadowMode::None,
        ..mode
    };
    let ours = [mode, bare].map(|mode| drawn(&view, light, mode));
    let ours = Pair {
        shadowed: &ours[0],
        lit: &ours[1],
    };
    compare(ours, Pair { shadowed, lit }, [0; 3]).unwrap()
}

/// Measured when the limits were set: about 1.1 % with maps of 128 and of 256 texels.
#[test]
fn of_the_bunny_near_few_pixels_are_shaded_wrongly() {
    let view = View::from(StandardView::Near);
    let truth = truth(view, STANDARD_LIGHT);
    for (size, limit) in [(64, 4.0), (128, 4.0), (256, 2.5)] {
        for preset in [Preset::Balanced, Preset::Fine] {
            let wrong = judged(view, STANDARD_LIGHT, mode(preset, &view, size), &truth);
            println!("{size} {preset}: {:.2} % {wrong:?}", wrong.per_cent());
            assert!(wrong.per_cent() <= limit, "{size} {preset}: {wrong:?}");
            assert!(wrong.shadowed > 400, "{wrong:?}");
        }
    }
}

/// Where much lies in shadow, most of it is found, and hardly a pixel of what is lit is dark.
#[test]
fn long_shadows_are_found_and_what_is_lit_stays_so() {
    let view = View::from(StandardView::NearTurned);
    for light in LOW {
        let truth = truth(view, light);
        let wrong = judged(view, light, mode(Preset::Balanced, &view, 128), &truth);
        println!("{light}: {:.2} % {wrong:?}", wrong.per_cent());
        let parts = |n: usize, of: usize| n as f64 / of as f64;
        assert!(
            parts(wrong.acne, wrong.covered) < 0.02,
            "{light}: {wrong:?}"
        );
        assert!(
            parts(wrong.leaks, wrong.shadowed) < 0.55,
            "{light}: {wrong:?}"
        );
    }
}

/// Frames of words, in boxes and discs, by either visibility, are shaded as the presets' are.
#[test]
fn every_mode_is_shaded_alike() {
    let view = View::from(StandardView::Near);
    let truth = truth(view, STANDARD_LIGHT);
    for visibility in [VisibilityMode::Eye, VisibilityMode::Z] {
        for &footprint in FootprintMode::ALL {
            let mode = Mode {
                visibility,
                footprint,
                frame: FrameMode::Words,
                ..mode(Preset::Balanced, &view, 128)
            };
            let wrong = judged(view, STANDARD_LIGHT, mode, &truth);
            println!(
                "{visibility} {footprint}: {:.2} % {wrong:?}",
                wrong.per_cent()
            );
            assert!(
                wrong.per_cent() < 4.0,
                "{visibility} {footprint}: {wrong:?}"
            );
        }
    }
}

/// Samples that lay the same splats, in one pass or before it: what comes later in the order of the light
/// does not shade what came earlier. As points: of larger footprints equally far from the eye the first one shows,
/// and that depends on the order.
#[test]
fn one_pass_and_two_differ_in_hardly_a_pixel() {
    for view in [StandardView::Near, StandardView::NearTurned] {
        let view = View::from(view);
        for light in [STANDARD_LIGHT, LOW[0], LOW[1]] {
            let two = Mode {
                visibility: VisibilityMode::Z,
                footprint: FootprintMode::Point,
                frame: FrameMode::Words,
                light_splat: LightSplat::of(1).unwrap(),
                // 108 cells: those of which two passes lay splats, too.
                grid: 4,
                ..mode(Preset::Balanced, &view, 128)
            };
            let one = Mode {
                shadows: ShadowMode::OnePass,
                ..two
            };
            let [one, two] = [one, two].map(|mode| drawn(&view, light, mode).rgb);
            // Of samples equally far from the eye the first one shows, so that shades differ a little.
            let shadowed = |a: &[u8; 3], b: &[u8; 3]| a[1].abs_diff(b[1]) > 32;
            let pixels = one.iter().zip(&two);
            let other = pixels.filter(|(a, b)| shadowed(a, b)).count();
            let covered = two.iter().filter(|rgb| **rgb != [0; 3]).count();
            println!("{light}: {other} of {covered}");
            assert!(1000 * other <= 3 * covered, "{light}: {other} of {covered}");
        }
    }
}

/// The bunny in one grid, with materials, and with shadows of the standard light baked or not.
fn with_materials(shadows: Option<DVec3>) -> BlobFile {
    let path = model::scan("bunny").unwrap();
    let options = BakeOptions {
        grid: GridChoice::Fixed(vec![Sequence::new(&[2, 4, 4, 3]).unwrap()]),
        separation: Separation::Six,
        layout: LayoutChoice::Both,
        samples: SampleChoice::Leaves,
        shadows,
        ..BakeOptions::default()
    };
    let baked = bake(path.to_str().unwrap(), &options, &Progress::default()).unwrap();
    BlobFile::from_bytes(&baked.bytes, "bunny.rho")
}

/// In frames of words, whose colours do not depend on what other materials there are.
#[test]
fn baked_shadows_are_as_right_as_those_of_a_map_and_cost_nothing() {
    let light = STANDARD_LIGHT.normalize();
    let (shadowed, lit) = (with_materials(Some(light)), with_materials(None));
    for name in [StandardView::Near, StandardView::NearTurned] {
        let view = View::from(name);
        let [dark, bright] = &truth(view, light);
        let camera = view.camera().unwrap();
        let bare = Mode {
            frame: FrameMode::Words,
            ..Preset::Balanced.mode(&lit.blob().unwrap(), &camera)
        };
        let mapped = Mode {
            shadows: ShadowMode::TwoPass,
            ..bare
        };
        let of = |blob: &BlobFile, mode: Mode| {
            let drawn = render::render(&blob.blob().unwrap(), &view, light, mode).unwrap();
            Picture::from_rgb565(drawn.width.into(), drawn.height.into(), &drawn.words)
        };
        let ours = of(&lit, bare);
        let wrong = |shadowed: &Picture| {
            let ours = Pair {
                shadowed,
                lit: &ours,
            };
            let theirs = Pair {
                shadowed: dark,
                lit: bright,
            };
            compare(ours, theirs, [0; 3]).unwrap()
        };
        let (baked, map) = (wrong(&of(&shadowed, bare)), wrong(&of(&lit, mapped)));
        println!("baked {:.2} % {baked:?}", baked.per_cent());
        println!("map of 128 {:.2} % {map:?}", map.per_cent());
        assert!(
            baked.per_cent() <= map.per_cent() + 0.1,
            "{baked:?} {map:?}"
        );

        let tones = Preset::Balanced.mode(&lit.blob().unwrap(), &camera);
        let of = |blob: &BlobFile, shadows: ShadowMode| {
            let mode = Mode { shadows, ..tones };
            let request = Request::Model(Scene {
                camera,
                light: render::light(light),
                mode,
            });
            let run = ask(&request.line(), Some(blob.bytes())).unwrap();
            run.done().unwrap().report.phases.frame()
        };
        let [baked, none, kept, made] = [
            of(&shadowed, ShadowMode::None),
            of(&lit, ShadowMode::None),
            of(&lit, ShadowMode::Kept),
            of(&lit, ShadowMode::TwoPass),
        ];
        println!("baked {baked}, none {none}, kept {kept}, two-pass {made} instructions");
        assert!(20 * baked < 21 * none, "{baked} {none}");
    }
}

fn report(mode: Mode) -> Report {
    let request = Request::Model(Scene {
        camera: View::from(StandardView::Near).camera().unwrap(),
        light: render::light(STANDARD_LIGHT),
        mode,
    });
    let run = ask(&request.line(), Some(standard_bunny().bytes())).unwrap();
    run.done().unwrap().report
}

#[test]
fn a_map_that_is_kept_costs_nothing_and_shades_alike() {
    let view = View::from(StandardView::Near);
    let made = mode(Preset::Balanced, &view, 128);
    let kept = report(Mode {
        shadows: ShadowMode::Kept,
        ..made
    });
    let made = report(made);
    assert_eq!(kept.frame_crc32, made.frame_crc32);
    let cost = |report: &Report| report.phases.get(Phase::ShadowMap);
    assert!(cost(&kept) < 500 && cost(&made) > 10_000);
}
