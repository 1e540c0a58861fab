//! The board's programs within their budgets, and the small one drawing what the large one does.

use std::collections::BTreeMap;
use std::fs;

use host_tools::cargo::Package;
use host_tools::device::Run;
use host_tools::firmware::Firmware;
use host_tools::machine::Machine;
use host_tools::render;
use host_tools::view::{STANDARD_LIGHT, StandardView, View};
use rho_grid::mode::{Mode, Preset};
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

/// The program that has the presets alone.
fn small() -> Firmware {
    let package = Package {
        program: Some("presets"),
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
    let small = small();
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
    let run = draw(&small(), StandardView::Near, Mode::default());
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
