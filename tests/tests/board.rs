//! The emulated board from end to end: a line of text in, a picture on the panel's wire out.

use host_tools::blob_file::BlobFile;
use host_tools::failure::Exit as Code;
use host_tools::render;
use host_tools::view::{STANDARD_LIGHT, StandardView, View};
use object::{Object, ObjectSection, ObjectSegment};
use rho_grid::frame::Frame;
use rho_grid::mode::{FootprintMode, Mode, ReciprocalMode, VisibilityMode};
use rho_tests::firmware::{ask, firmware};
use rho_tests::{model, snapshot};
use rho_viewer::report::Exit;
use rho_viewer::request::{Request, Scene};
use rho_viewer::size::{HEIGHT, PIXELS, WIDTH};
use rho_viewer::{message, test_card};

fn request(view: &View, mode: Mode) -> Request {
    Request::Model(Scene {
        camera: view.camera().unwrap(),
        light: render::light(STANDARD_LIGHT),
        mode,
    })
}

fn near() -> Request {
    request(&StandardView::Near.into(), Mode::default())
}

#[test]
fn the_test_card_on_the_wire_is_the_hosts_own_drawing_bit_for_bit() {
    let run = ask("picture=test-card", None).unwrap().done().unwrap();
    let mut words = Box::new([0; PIXELS]);
    test_card::draw(&mut Frame::of_width(words.as_mut_slice(), WIDTH)).unwrap();
    assert!(run.words == words.as_slice());
    snapshot::check("test-card", &run.words, WIDTH);
}

#[test]
fn a_frame_is_one_window_of_two_bytes_a_pixel() {
    let run = ask("picture=test-card", None).unwrap();
    // Eight parameters of the window, three of the start-up sequence.
    assert_eq!(run.wire_bytes, 2 * PIXELS as u64 + 8 + 3);
}

#[test]
fn the_counter_reads_true_to_the_instruction() {
    let run = ask("picture=count-loop", None).unwrap().done().unwrap();
    let expected: Vec<_> = run.report.probes.iter().map(|p| p.expected).collect();
    assert_eq!(expected, [0, 1, 7, 2_000_004]);
    for probe in &run.report.probes {
        assert_eq!(probe.counted, probe.expected);
    }
}

#[test]
fn two_runs_give_the_same_report() {
    let blob = model::blob();
    let [a, b] = [0; 2].map(|_| ask(&near().line(), Some(&blob)).unwrap());
    assert!(a.report.phases.frame() > 0);
    assert_eq!(a.report, b.report);
    assert!(a.words == b.words);
}

#[test]
fn the_device_draws_what_the_host_draws_in_every_mode() {
    let blob = BlobFile::from_bytes(&model::blob(), "the octahedron");
    let view = StandardView::NearTurned.into();
    for &visibility in VisibilityMode::ALL {
        for &footprint in FootprintMode::ALL {
            for &reciprocal in ReciprocalMode::ALL {
                let mode = Mode {
                    visibility,
                    footprint,
                    reciprocal,
                    ..Mode::default()
                };
                let line = request(&view, mode).line();
                let run = ask(&line, Some(blob.bytes())).unwrap().done().unwrap();
                let drawn =
                    render::render(&blob.blob().unwrap(), &view, STANDARD_LIGHT, mode).unwrap();
                assert!(run.words == drawn.words, "{mode:?}");
                assert!(run.pixels() > 5_000, "{mode:?}: {}", run.pixels());
            }
        }
    }
}

#[test]
fn a_picture_smaller_than_the_panel_is_the_hosts_too() {
    let blob = BlobFile::from_bytes(&model::blob(), "the octahedron");
    let view = View {
        width: 100,
        height: 77,
        ..StandardView::Far.into()
    };
    let line = request(&view, Mode::default()).line();
    let run = ask(&line, Some(blob.bytes())).unwrap().done().unwrap();
    let drawn = render::render(
        &blob.blob().unwrap(),
        &view,
        STANDARD_LIGHT,
        Mode::default(),
    )
    .unwrap();
    assert!(run.words == drawn.words);
}

/// What the device cannot do is shown on the panel, told in the report, and ends with a code.
fn refused(line: &str, blob: Option<&[u8]>, exit: Exit, text: &str) -> Vec<u16> {
    let run = ask(line, blob).unwrap();
    assert_eq!(run.report.exit, exit);
    assert!(run.report.message.contains(text), "{}", run.report.message);
    let mut words = Box::new([0; PIXELS]);
    let canvas = &mut Frame::of_width(words.as_mut_slice(), WIDTH);
    message::draw(canvas, "Nothing to show", &run.report.message).unwrap();
    assert!(run.words == words.as_slice(), "the panel shows the message");
    let failure = run.done().unwrap_err();
    assert_eq!(failure.exit, Code::Input);
    assert!(failure.message.contains(text), "{}", failure.message);
    words.to_vec()
}

#[test]
fn a_missing_model_is_told_on_the_panel() {
    let words = refused(&near().line(), None, Exit::Model, "no blob here");
    snapshot::check("missing-model", &words, WIDTH);
}

#[test]
fn a_model_cut_off_anywhere_is_told_on_the_panel() {
    let blob = model::blob();
    for kept in [31, 100, blob.len() / 2, blob.len() - 200] {
        let text = "truncated";
        refused(&near().line(), Some(&blob[..kept]), Exit::Model, text);
    }
}

#[test]
fn a_damaged_model_is_told_on_the_panel() {
    let mut blob = model::blob();
    let middle = blob.len() / 2;
    blob[middle] ^= 1;
    refused(&near().line(), Some(&blob), Exit::Model, "damaged");
    refused(
        &near().line(),
        Some(&[7; 5000]),
        Exit::Model,
        "not a rho blob",
    );
}

#[test]
fn a_model_of_a_newer_version_is_told_on_the_panel() {
    let mut blob = model::blob();
    blob[8] += 1;
    refused(&near().line(), Some(&blob), Exit::Model, "newer");
}

#[test]
fn a_line_that_is_no_request_is_told_on_the_panel() {
    refused("", None, Exit::Request, "picture is missing");
    refused("picture=cat", None, Exit::Request, "test-card");
    refused("picture=a,b", None, Exit::Request, "test-card");
    refused(&"x".repeat(5000), None, Exit::Request, "picture is missing");
}

#[test]
fn a_picture_larger_than_the_panel_is_told_on_it() {
    let view = View {
        width: HEIGHT,
        height: WIDTH,
        ..StandardView::Near.into()
    };
    let line = request(&view, Mode::default()).line();
    refused(&line, None, Exit::Request, "240 x 320");
}

#[test]
fn the_log_is_decoded_with_the_strings_of_the_image() {
    let run = ask("picture=test-card", None).unwrap();
    assert!(
        run.log
            .iter()
            .any(|l| l.ends_with("request: picture=test-card")),
        "{:?}",
        run.log
    );
}

#[test]
fn the_image_lies_where_the_board_has_memory() {
    let elf = object::File::parse(firmware().elf()).unwrap();
    let vectors = elf.section_by_name(".vector_table").unwrap();
    assert_eq!(vectors.address(), 0);
    let word = |i: usize| {
        let bytes = vectors.data().unwrap()[4 * i..4 * i + 4].try_into();
        u32::from_le_bytes(bytes.unwrap())
    };
    assert_eq!(word(0), 0x2001_0000, "the stack grows down from here");
    assert_eq!(u64::from(word(1)), elf.entry() | 1);
    let statics = elf.section_by_name(".bss").unwrap();
    assert!(statics.address() >= 0x2001_0000);
    assert!(elf.segments().all(|s| s.size() > 0));
    let text = elf.section_by_name(".text").unwrap();
    assert!(text.size() > 10_000 && text.address() < 4 << 20);
    // A frame at least, and far from all of the board's memory.
    let ram = firmware().ram_bytes();
    assert!((2 * PIXELS as u64..1 << 20).contains(&ram), "{ram}");
    // How much of its flash the program may take is said by its budget (budget.rs).
    assert!(firmware().flash_bytes() < 4 << 20);
}
