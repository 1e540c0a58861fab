//! The board's programs within their budgets, and the small one drawing what the large one does.

use std::collections::BTreeMap;
use std::fs;

use host_tools::bake::{BakeOptions, GridChoice, Progress};
use host_tools::blob_file::BlobFile;
use host_tools::cargo::Package;
use host_tools::device::Run;
use host_tools::firmware::Firmware;
use host_tools::machine::Machine;
use host_tools::render;
use host_tools::scene::Scene as File;
use host_tools::scene::bake::bake as bake_scene;
use host_tools::view::{STANDARD_LIGHT, StandardView, View};
use rho_grid::mode::{MapSize, Mode, Preset, ShadowMode};
use rho_tests::firmware::{TIMEOUT, ask_of, firmware, target_dir, workspace};
use rho_tests::scan::standard_bunny;
use rho_viewer::request::{Request, Scene};
use serde::Deserialize;

#[derive(Deserialize)]
struct Budget {
    ram: u64,
    flash: u64,
    stack: u32,
}

fn budget(program: &str) -> Budget {
    let path = workspace().join("firmware/mps2-an385/budget.toml");
    let text = fs::read_to_string(path).unwrap();
    let mut budgets: BTreeMap<String, Budget> = toml::from_str(&text).unwrap();
    budgets.remove(program).unwrap()
}

/// A program of the board that has not all modes.
fn small(name: &'static str) -> Firmware {
    let package = Package {
        program: Some(name),
        ..Machine::M3.viewer()
    };
    let path = package.build(workspace(), Some(&target_dir())).unwrap();
    Firmware::open(&path, Machine::M3).unwrap()
}

fn line(view: StandardView, mode: Mode) -> impl AsRef<str> {
    let camera = View::from(view).camera().unwrap();
    let light = render::light(STANDARD_LIGHT);
    Request::Model(Scene {
        camera,
        light,
        mode,
    })
    .line()
}

fn draw(firmware: &Firmware, view: StandardView, mode: Mode) -> Run {
    let model = Some(standard_bunny().bytes());
    ask_of(firmware, line(view, mode).as_ref(), model, TIMEOUT).unwrap()
}

#[test]
fn the_small_program_draws_the_presets_as_the_host_does_within_its_budget() {
    let small = small("presets");
    let limit = budget("presets");
    let blob = standard_bunny().blob().unwrap();
    for view in [StandardView::NearTurned, StandardView::Far] {
        for preset in Preset::ALL {
            let mode = preset.mode(&blob, &View::from(view).camera().unwrap());
            let run = draw(&small, view, mode).done().unwrap();
            let host = render::render(&blob, &view.into(), STANDARD_LIGHT, mode).unwrap();
            assert!(run.words == host.words, "{preset} {}", view.name());
            let stack = run.report.stack_bytes;
            assert!(stack <= limit.stack, "{preset}: {stack} bytes of stack");
        }
    }
    let (ram, flash) = (small.ram_bytes(), small.flash_bytes());
    println!("presets: {ram} B RAM, {flash} B flash");
    assert!(ram <= limit.ram, "{ram} bytes of RAM");
    assert!(flash <= limit.flash, "{flash} bytes of flash");
}

#[test]
fn the_small_program_refuses_other_modes_and_says_why() {
    let run = draw(&small("presets"), StandardView::Near, Mode::default());
    assert!(run.report.message.contains("presets"), "{:?}", run.report);
    assert!(run.done().is_err());
}

#[test]
fn the_program_with_all_modes_is_within_its_budget() {
    let limit = budget("rho-mps2-an385");
    let (ram, flash) = (firmware().ram_bytes(), firmware().flash_bytes());
    println!("all modes: {ram} B RAM, {flash} B flash");
    assert!(ram <= limit.ram, "{ram} bytes of RAM");
    assert!(flash <= limit.flash, "{flash} bytes of flash");
}

/// A pot in several colours on a floor, in a light that casts shadows.
const SCENE: &str = r##"
background = "#304050"
[camera]
yaw = 20
pitch = 25
distance = 1.6
[[light]]
direction = [0.8, 0.7, 0.2]
shadows = true
[[material]]
name = "floor"
diffuse = "#a09070"
[ground]
size = 2.4
material = "floor"
[[object]]
source = "teapot"
stand = true
"##;

#[test]
fn an_object_on_a_ground_with_shadows_fits_a_quarter_of_a_megabyte() {
    let scene = File::parse(SCENE, "pot.toml", &[]).unwrap();
    let options = BakeOptions {
        grid: GridChoice::Standard(None),
        ..BakeOptions::default()
    };
    let baked = bake_scene(&scene, "pot.toml", &options, &Progress::default()).unwrap();
    let file = BlobFile::from_bytes(&baked.bytes, "pot.rho");
    let blob = file.blob().unwrap();
    assert!(blob.materials().len() >= 4, "{}", blob.materials().len());
    let (small, limit) = (small("scenes"), budget("scenes"));
    let camera = blob.camera().unwrap();
    let light = blob.lights().next().unwrap().towards;
    for preset in Preset::ALL {
        let mode = Mode {
            shadows: ShadowMode::TwoPass,
            ..preset.mode(&blob, &camera)
        };
        let ask = |mode| {
            let request = Request::Model(Scene {
                camera,
                light,
                mode,
            });
            ask_of(&small, &request.line(), Some(file.bytes()), TIMEOUT).unwrap()
        };
        let run = ask(mode).done().unwrap();
        let host = render::render_from(&blob, &camera, light, mode).unwrap();
        assert!(run.words == host.words, "{preset}");
        assert!(
            run.report.stack_bytes <= limit.stack,
            "{preset}: {:?}",
            run.report
        );
        let large = ask(Mode {
            shadow_map: MapSize::of(256).unwrap(),
            ..mode
        });
        assert!(
            large.report.message.contains("shadow map"),
            "{:?}",
            large.report
        );
    }
    let (ram, flash) = (small.ram_bytes(), small.flash_bytes());
    println!("scenes: {ram} B RAM, {flash} B flash");
    assert!(
        ram + u64::from(limit.stack) <= 256_000,
        "{ram} bytes of RAM"
    );
    assert!(ram <= limit.ram, "{ram} bytes of RAM");
    assert!(flash <= limit.flash, "{flash} bytes of flash");
}
