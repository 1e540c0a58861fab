//! Scenes: the same bits on host and device in every mode, and objects that hide each other.

use std::fs;

use host_tools::bake::{BakeOptions, GridChoice, LayoutChoice, Progress, bake};
use host_tools::blob_file::BlobFile;
use host_tools::compare::compare;
use host_tools::device::Run;
use host_tools::model::LoadOptions;
use host_tools::picture::{Picture, rgb888};
use host_tools::reference::Shot;
use host_tools::reference::scene::SceneCaster;
use host_tools::render::{Drawn, render_from};
use host_tools::sampling::Sequence;
use host_tools::scene::Scene as File;
use host_tools::scene::bake::bake as bake_scene;
use host_tools::view::{StandardView, View};
use rho_grid::camera::Camera;
use rho_grid::mode::{FootprintMode, FrameMode, MapSize, Mode, Preset, ShadowMode, VisibilityMode};
use rho_tests::firmware::ask;
use rho_tests::snapshot;
use rho_viewer::request::{Request, Scene};

/// A ball through a ring, a coloured pot turned on its side, and a slab far behind; two lights, one of
/// them coloured, on a ground.
const SCENE: &str = r##"
background = "#204060"
[camera]
yaw = 25
pitch = 20
distance = 1.5
[[light]]
direction = [0.5, 0.8, 0.55]
[[light]]
direction = [-1, 0.3, 0.2]
colour = "#602010"
[[material]]
name = "floor"
diffuse = "#708050"
[[material]]
name = "gold"
diffuse = "#b08030"
phong = "#808080"
exponent = 20
[ground]
size = 3
material = "floor"
[[object]]
source = "shapes"
material = "gold"
stand = true
scale = 0.8
translation = [-0.5, 0, 0.4]
parameters = { parts = [{ shape = { torus = { ring = 0.5, tube = 0.1 } } }] }
rotation = [0, 30, 0]
[[object]]
source = "shapes"
material = "gold"
scale = 0.5
translation = [-0.5, 0.1, 0.4]
parameters = { parts = [{ shape = { sphere = { radius = 0.4 } } }] }
[[object]]
source = "teapot"
translation = [0.6, 0.3, 0.1]
rotation = [0, 40, 60]
scale = 0.7
"##;

fn baked(text: &str, options: &BakeOptions) -> BlobFile {
    let scene = File::parse(text, "test.toml", &[]).unwrap();
    let baked = bake_scene(&scene, "test.toml", options, &Progress::default()).unwrap();
    BlobFile::from_bytes(&baked.bytes, "test.rho")
}

fn standard() -> BakeOptions {
    BakeOptions {
        grid: GridChoice::Standard(None),
        ..BakeOptions::default()
    }
}

fn cameras(blob: &BlobFile) -> Vec<Camera> {
    let own = blob.blob().unwrap().camera().unwrap();
    let inside = View {
        distance: 0.25,
        pitch: 10.0,
        ..StandardView::Near.into()
    };
    let views = [
        StandardView::Near.into(),
        StandardView::FarTurned.into(),
        inside,
    ];
    let cameras = views.map(|view: View| view.camera().unwrap());
    [own].into_iter().chain(cameras).collect()
}

fn modes(blob: &BlobFile, camera: &Camera) -> Vec<Mode> {
    let blob = blob.blob().unwrap();
    let mut modes: Vec<Mode> = Preset::ALL.iter().map(|p| p.mode(&blob, camera)).collect();
    let fast = Preset::Fast.mode(&blob, camera);
    for (visibility, frame) in [
        (VisibilityMode::Eye, FrameMode::Words),
        (VisibilityMode::Z, FrameMode::Words),
    ] {
        for footprint in [FootprintMode::Disc, FootprintMode::Box] {
            modes.push(Mode {
                visibility,
                frame,
                footprint,
                ..fast
            });
        }
    }
    modes.push(Mode {
        shadows: ShadowMode::OnePass,
        visibility: VisibilityMode::Z,
        frame: FrameMode::Words,
        footprint: FootprintMode::Box,
        ..fast
    });
    for mode in [fast, Preset::Balanced.mode(&blob, camera)] {
        modes.push(Mode {
            shadows: ShadowMode::TwoPass,
            ..mode
        });
    }
    modes
}

fn drawn(blob: &BlobFile, camera: &Camera, mode: Mode) -> Drawn {
    let blob = blob.blob().unwrap();
    let light = blob.lights().next().unwrap().towards;
    render_from(&blob, camera, light, mode).unwrap()
}

/// The frame that the device draws.
fn drawn_by_device(blob: &BlobFile, camera: &Camera, mode: Mode) -> Vec<u16> {
    let request = Request::Model(Scene {
        camera: *camera,
        light: blob.blob().unwrap().lights().next().unwrap().towards,
        mode,
    });
    let run = ask(&request.line(), Some(blob.bytes())).and_then(Run::done);
    run.unwrap().words
}

#[test]
fn host_and_device_draw_the_same_bits_of_a_scene_in_every_mode() {
    let blob = baked(SCENE, &standard());
    for camera in cameras(&blob) {
        for mode in modes(&blob, &camera) {
            let ours = drawn(&blob, &camera, mode).words;
            let theirs = drawn_by_device(&blob, &camera, mode);
            assert!(ours == theirs, "{mode:?} {camera:?}");
        }
    }
}

#[test]
fn a_scene_is_as_its_snapshot_shows_it() {
    let blob = baked(SCENE, &standard());
    let camera = blob.blob().unwrap().camera().unwrap();
    let mode = Preset::Balanced.mode(&blob.blob().unwrap(), &camera);
    snapshot::check("scene", &drawn(&blob, &camera, mode).words, camera.width);
}

/// The grid that both share names materials, which the second pot's samples have none of.
#[test]
fn an_instance_of_one_material_is_that_whatever_its_samples_name() {
    const POTS: &str = r##"
[camera]
distance = 1.5
[[light]]
direction = [0.5, 0.8, 0.55]
shadows = true
[[light]]
direction = [-1, 0.3, 0.2]
[[material]]
name = "blue"
ambient = "#000008"
diffuse = "#0000e0"
[[object]]
source = "teapot"
translation = [-0.6, 0, 0]
[[object]]
source = "teapot"
translation = [0.6, 0, 0]
material = "blue"
"##;
    let blob = baked(POTS, &standard());
    let camera = blob.blob().unwrap().camera().unwrap();
    for shadows in [ShadowMode::None, ShadowMode::TwoPass] {
        let mode = Mode {
            shadows,
            ..Preset::Balanced.mode(&blob.blob().unwrap(), &camera)
        };
        let ours = drawn(&blob, &camera, mode);
        let right = ours
            .words
            .iter()
            .enumerate()
            .filter(|(i, _)| i % 240 >= 120);
        let pot = right
            .map(|(_, word)| rgb888(*word))
            .filter(|rgb| *rgb != [0; 3]);
        let mut pixels = 0;
        for [red, green, blue] in pot {
            pixels += 1;
            assert!(red == 0 && green == 0 && blue > 0, "{red} {green} {blue}");
        }
        assert!(pixels > 2000, "{pixels}");
        let theirs = drawn_by_device(&blob, &camera, mode);
        assert!(theirs == ours.words, "{shadows}");
    }
}

/// Whether a channel differs by more than a tenth of white.
fn is_seen(a: u16, b: u16) -> bool {
    let channels = rgb888(a).into_iter().zip(rgb888(b));
    channels.into_iter().any(|(a, b)| a.abs_diff(b) > 25)
}

/// Objects come from front to back by planes between them, and those that reach into each other
/// against depths; the depth buffer has all against depths. They may differ along edges, where one
/// footprint overhangs another's cell.
#[test]
fn eye_order_and_the_depth_buffer_show_the_same_objects_in_front() {
    let blob = baked(SCENE, &standard());
    for camera in cameras(&blob) {
        let fast = Preset::Fine.mode(&blob.blob().unwrap(), &camera);
        let of = |visibility| {
            let mode = Mode {
                visibility,
                frame: FrameMode::Words,
                ..fast
            };
            drawn(&blob, &camera, mode).words
        };
        let pairs = || {
            of(VisibilityMode::Eye)
                .into_iter()
                .zip(of(VisibilityMode::Z))
        };
        let seen = pairs().filter(|(eye, z)| is_seen(*eye, *z)).count();
        let all = pairs().count();
        println!("{seen} of {all}");
        assert!(seen * 50 < all, "{seen} of {all}: {camera:?}");
    }
}

/// Balls over each other and over a ground, the higher ones later in the file.
const OVER: &str = r##"
[camera]
yaw = 25
pitch = 30
distance = 1.5
[[light]]
direction = [0.3, 0.9, 0.2]
shadows = true
[[material]]
name = "floor"
diffuse = "#c0c0c0"
[ground]
size = 3
material = "floor"
[[object]]
source = "shapes"
scale = 0.6
translation = [0, 0.6, 0]
parameters = { parts = [{ shape = { sphere = { radius = 0.4 } } }] }
[[object]]
source = "shapes"
scale = 0.4
translation = [0.2, 1.3, 0.1]
parameters = { parts = [{ shape = { sphere = { radius = 0.4 } } }] }
"##;

/// Of the same samples: objects come in the order of the light, so that each shades what stands behind it. Along
/// edges of shadows some differ, since what comes later shades nothing.
#[test]
fn objects_shade_each_other_in_one_pass_as_they_do_in_two() {
    let options = BakeOptions {
        grid: GridChoice::Fixed(vec![Sequence::new(&[3; 4]).unwrap()]),
        ..standard()
    };
    let blob = baked(OVER, &options);
    for camera in cameras(&blob) {
        let ways = [ShadowMode::None, ShadowMode::OnePass, ShadowMode::TwoPass];
        let [none, one, two] = ways.map(|shadows| {
            let mode = Mode {
                visibility: VisibilityMode::Z,
                shadows,
                ..Mode::default()
            };
            drawn(&blob, &camera, mode).words
        });
        let differ = |a: &[u16], b: &[u16]| {
            let pixels = a.iter().zip(b);
            pixels.filter(|(a, b)| is_seen(**a, **b)).count()
        };
        let (other, shaded) = (differ(&one, &two), differ(&none, &two));
        println!("{other} pixels differ, {shaded} lie in a shadow");
        assert!(shaded > 10, "{shaded}: {camera:?}");
        assert!(3 * other <= shaded, "{other} of {shaded}: {camera:?}");
    }
}

#[test]
fn a_coloured_model_with_a_colour_a_sample_is_drawn_in_its_colours() {
    let folder = tempfile::tempdir().unwrap();
    // Red below, blue above.
    let model = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
                 property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
                 element face 2\nproperty list uchar int vertex_indices\nend_header\n\
                 -1 -1 0 255 0 0\n1 -1 0 255 0 0\n1 1 0 0 0 255\n-1 1 0 0 0 255\n\
                 3 0 1 2\n3 0 2 3\n";
    fs::write(folder.path().join("two.ply"), model).unwrap();
    let options = BakeOptions {
        layout: LayoutChoice::Colour,
        models: Some(folder.path().to_owned()),
        ..BakeOptions::default()
    };
    let baked = bake("two.ply", &options, &Progress::default()).unwrap();
    let blob = BlobFile::from_bytes(&baked.bytes, "two.rho");
    let camera = View::from(StandardView::Near).camera().unwrap();
    for (frame, footprint) in [
        (FrameMode::Words, FootprintMode::Disc),
        (FrameMode::Words, FootprintMode::Box),
    ] {
        let mode = Mode {
            frame,
            footprint,
            ..Mode::default()
        };
        let light = host_tools::render::light(host_tools::view::STANDARD_LIGHT);
        let drawn = render_from(&blob.blob().unwrap(), &camera, light, mode).unwrap();
        let at = |y: usize| rgb888(drawn.words[y * 240 + 120]);
        let ([r, _, b], [upper_r, _, upper_b]) = (at(230), at(90));
        assert!(r > 100 && b < 60, "{r} {b}");
        assert!(upper_b > 100 && upper_r < 60, "{upper_r} {upper_b}");
    }
}

/// Two posts on a floor under three lights, of which the last casts shadows.
const LIGHTS: &str = r##"
background = "#101418"
[camera]
yaw = 20
pitch = 28
distance = 1.5
[[light]]
direction = [-1.0, 0.6, 0.5]
colour = "#3060d0"
[[light]]
direction = [0.1, 0.4, 1.0]
colour = "#602818"
[[light]]
direction = [0.8, 0.7, 0.2]
colour = "#c0b8a8"
shadows = true
[[material]]
name = "floor"
ambient = "#101010"
diffuse = "#a0a0a0"
[[material]]
name = "post"
ambient = "#181008"
diffuse = "#c09048"
[ground]
size = 2.4
material = "floor"
[[object]]
source = "shapes"
material = "post"
stand = true
translation = [0.2, 0, -0.2]
parameters = { parts = [{ shape = { cylinder = { radius = 0.2, height = 1.0, round = 0.05 } } }] }
[[object]]
source = "shapes"
material = "post"
stand = true
translation = [-0.5, 0, 0.5]
scale = 0.5
parameters = { parts = [{ shape = { sphere = { radius = 0.5 } } }] }
"##;

/// What the ray-caster shows of [`LIGHTS`], before its background.
fn truth_of_lights() -> Picture {
    let scene = File::parse(LIGHTS, "lights.toml", &[]).unwrap();
    let caster = SceneCaster::new(&scene, &LoadOptions::default()).unwrap();
    let shot = Shot {
        samples: 1,
        ..Shot::standard(scene.camera)
    };
    caster.render(&shot, &|| ()).unwrap().picture
}

#[test]
fn in_the_shadow_of_one_light_the_others_shine() {
    let blob = baked(LIGHTS, &standard());
    let camera = blob.blob().unwrap().camera().unwrap();
    assert!(blob.blob().unwrap().lights().next().unwrap().casts_shadows);
    let truth = truth_of_lights();
    let preset = Preset::Fine.mode(&blob.blob().unwrap(), &camera);
    for frame in [FrameMode::Tones, FrameMode::Words] {
        let decibels = [ShadowMode::TwoPass, ShadowMode::None].map(|shadows| {
            let mode = Mode {
                frame,
                shadows,
                shadow_map: MapSize::of(256).unwrap(),
                ..preset
            };
            let drawn = drawn(&blob, &camera, mode);
            let behind = rgb888(drawn.background);
            let compared = compare(&drawn.picture(), &truth, behind, None).unwrap();
            compared.psnr_inside.unwrap()
        });
        println!("{frame:?}: with shadows and without {decibels:.2?} dB");
        assert!(decibels[0] > 27.0 && decibels[1] < 22.0, "{decibels:?}");
    }
}
