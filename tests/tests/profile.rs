//! The emulator's plugin and the device count the same instructions.

use host_tools::device;
use host_tools::profile::Profile;
use host_tools::profile::cycles::Core;
use host_tools::profile::place::Places;
use host_tools::profile::thumb::Class;
use host_tools::qemu::Job;
use host_tools::render;
use host_tools::view::{STANDARD_LIGHT, StandardView, View};
use rho_grid::mode::Mode;
use rho_tests::firmware::{TIMEOUT, firmware, plugin};
use rho_tests::model;
use rho_viewer::count::Phase;
use rho_viewer::request::{Request, Scene};

/// Instructions of a reading of the counter.
const READING: u64 = 3;

#[test]
fn every_phase_of_the_second_frame_is_counted_to_the_instruction() {
    let request = Request::Model(Scene {
        camera: View::from(StandardView::Near).camera().unwrap(),
        light: render::light(STANDARD_LIGHT),
        mode: Mode::default(),
    });
    let blob = model::blob();
    let line = request.line();
    let job = Job {
        firmware: firmware(),
        model: Some(&blob),
        request: &line,
        timeout: TIMEOUT,
        plugin: None,
    };
    let plain = device::answer(&job).unwrap().done().unwrap();
    let run = device::answer(&Job {
        plugin: Some(plugin()),
        ..job
    });
    let run = run.unwrap().done().unwrap();
    assert_eq!(run.report, plain.report, "watching changes nothing");

    let profile = Profile::new(firmware(), &run).unwrap();
    for phase in Phase::ALL {
        let counted = profile.total(|p| p == phase).instructions();
        let told = run.report.phases.get(phase);
        // A phase may run in several pieces, each with a reading of its own.
        let pieces = run.report.phases.pieces().filter(|piece| *piece == phase);
        let readings = pieces.count() as u64 * READING;
        assert_eq!(counted, told + readings, "{}", phase.name());
    }

    let draw = profile.total(|p| p == Phase::Draw);
    assert!(draw.taken > 0 && draw.taken < draw.ran[Class::Branch] + draw.ran[Class::LoadMultiple]);
    assert!(draw.registers[Class::StoreMultiple] >= 2 * draw.ran[Class::StoreMultiple]);
    let [m3, m4] = Core::ALL.map(|core| draw.cycles(core));
    assert!(draw.instructions() < m4 && m4 <= m3 && m3 < 2 * draw.instructions());

    // The source is known: most of the work of drawing is the renderer's.
    let mut places = Places::open(firmware().path()).unwrap();
    let by_file = profile.sum(|p| p == Phase::Draw, |at| places.of(at).file.clone());
    let renderer = by_file
        .iter()
        .filter(|(file, _)| file.contains("rho-grid/src/"));
    let own: u64 = renderer.map(|(_, work)| work.instructions()).sum();
    assert!(10 * own > 8 * draw.instructions(), "{by_file:?}");
}
