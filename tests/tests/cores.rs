//! The same bits from programs for other cores: without divider and long product, and with a
//! floating-point unit.

use host_tools::blob_file::BlobFile;
use host_tools::geometry::triangles::Triangles;
use host_tools::machine::Machine;
use host_tools::render;
use host_tools::sampling::Separation;
use host_tools::view::{STANDARD_LIGHT, StandardView, View};
use rho_grid::blob::Layout;
use rho_grid::mode::{FootprintMode, Mode, Preset, ReciprocalMode, ShadowMode, VisibilityMode};
use rho_tests::firmware::{TIMEOUT, ask_of, firmware_for};
use rho_tests::model;
use rho_tests::scan::{baked_bunny, bunny, encoded, sampled, standard_bunny};
use rho_viewer::request::{Request, Scene};

/// Every mode on a small model, and the bunny from the standard views: in boxes, in discs and by
/// every preset, whose loops are in assembly on some cores.
fn draws_the_hosts_bits(machine: Machine) {
    let firmware = firmware_for(machine);
    let discs = sampled(&Triangles::new(bunny()), &[3; 4], Separation::Six);
    let octahedron = BlobFile::from_bytes(&model::blob(), "the octahedron");
    let (boxes, discs) = (baked_bunny(&[3; 5]), encoded(&discs, Layout::OFFSET_THIN));
    let mut cases = Vec::new();
    for &visibility in VisibilityMode::ALL {
        for &footprint in FootprintMode::ALL {
            for &reciprocal in ReciprocalMode::ALL {
                let mode = Mode {
                    visibility,
                    footprint,
                    reciprocal,
                    ..Mode::default()
                };
                cases.push((&octahedron, StandardView::NearTurned, mode));
            }
        }
    }
    let footprint = FootprintMode::Disc;
    for view in StandardView::ALL {
        cases.push((&boxes, view, Mode::default()));
        cases.push((
            &discs,
            view,
            Mode {
                footprint,
                ..Mode::default()
            },
        ));
        let camera = View::from(view).camera().unwrap();
        for preset in Preset::ALL {
            let mode = preset.mode(&standard_bunny().blob().unwrap(), &camera);
            cases.push((standard_bunny(), view, mode));
            let shadows = ShadowMode::TwoPass;
            cases.push((standard_bunny(), view, Mode { shadows, ..mode }));
        }
    }
    for (blob, view, mode) in cases {
        let camera = View::from(view).camera().unwrap();
        let light = render::light(STANDARD_LIGHT);
        let line = Request::Model(Scene {
            camera,
            light,
            mode,
        })
        .line();
        let run = ask_of(&firmware, &line, Some(blob.bytes()), TIMEOUT);
        let run = run.unwrap().done().unwrap();
        let drawn = render::render(&blob.blob().unwrap(), &view.into(), STANDARD_LIGHT, mode);
        assert!(
            run.words == drawn.unwrap().words,
            "{machine:?}: {} {mode:?}",
            view.name()
        );
    }
}

#[test]
fn a_core_without_divider_and_long_product_draws_the_same_bits() {
    draws_the_hosts_bits(Machine::M0);
}

#[test]
fn a_core_with_a_floating_point_unit_draws_the_same_bits() {
    draws_the_hosts_bits(Machine::M4);
}

#[test]
fn the_counter_reads_true_on_every_core() {
    for machine in Machine::ALL {
        let run = ask_of(&firmware_for(machine), "picture=count-loop", None, TIMEOUT);
        for probe in run.unwrap().done().unwrap().report.probes {
            assert_eq!(probe.counted, probe.expected, "{machine:?}");
        }
    }
}
