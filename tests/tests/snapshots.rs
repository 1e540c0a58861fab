//! Pictures of the built-in teapot, compared with those kept beside the tests.

use embedded_graphics::Drawable;
use embedded_graphics::draw_target::DrawTargetExt;
use embedded_graphics::geometry::{Point, Size};
use embedded_graphics::mono_font::MonoTextStyle;
use embedded_graphics::mono_font::ascii::FONT_10X20;
use embedded_graphics::pixelcolor::raw::RawU16;
use embedded_graphics::pixelcolor::{IntoStorage, Rgb565, RgbColor};
use embedded_graphics::prelude::{PointsIter, Primitive};
use embedded_graphics::primitives::{PrimitiveStyle, Rectangle, RoundedRectangle};
use embedded_graphics::text::{Alignment, Text};
use embedded_graphics_simulator::SimulatorDisplay;
use host_tools::blob_file::BlobFile;
use host_tools::geometry::teapot::Teapot;
use host_tools::render::{self, Drawn};
use host_tools::view::{STANDARD_LIGHT, StandardView, View};
use rho_grid::frame::Frame;
use rho_grid::mode::Mode;
use rho_tests::firmware::ask;
use rho_tests::scan::baked;
use rho_tests::snapshot;
use rho_viewer::request::{Request, Scene};
use rho_viewer::size::{HEIGHT, WIDTH};

/// The teapot at 81 cells an axis.
fn teapot() -> BlobFile {
    baked(&Teapot::new(), &[3; 4])
}

fn view() -> View {
    StandardView::NearTurned.into()
}

fn drawn(blob: &BlobFile) -> Drawn {
    let blob = blob.blob().unwrap();
    render::render(&blob, &view(), STANDARD_LIGHT, Mode::default()).unwrap()
}

/// What the simulated screen shows: RGB565 words, rows from the top.
fn shown(screen: &SimulatorDisplay<Rgb565>) -> Vec<u16> {
    let points = Rectangle::new(Point::zero(), Size::new(WIDTH.into(), HEIGHT.into())).points();
    points.map(|p| screen.get_pixel(p).into_storage()).collect()
}

/// A frame is a target of embedded-graphics: what a user writes and draws goes over the picture
/// and leaves the rest of it alone.
#[test]
fn text_and_shapes_go_over_a_frame() {
    let mut words = drawn(&teapot()).words;
    let bare = words.clone();
    let mut frame = Frame::new(&mut words, WIDTH, HEIGHT).unwrap();
    let area = Rectangle::new(Point::new(20, 268), Size::new(200, 36));
    let border = PrimitiveStyle::with_stroke(Rgb565::CYAN, 2);
    let corner = Size::new(8, 8);
    RoundedRectangle::with_equal_corners(area, corner)
        .into_styled(border)
        .draw(&mut frame)
        .unwrap();
    let style = MonoTextStyle::new(&FONT_10X20, Rgb565::YELLOW);
    let middle = area.center() + Point::new(0, 6);
    Text::with_alignment("Utah teapot", middle, style, Alignment::Center)
        .draw(&mut frame)
        .unwrap();
    snapshot::check("teapot-with-caption", &words, WIDTH);
    for (i, (with, without)) in words.iter().zip(bare).enumerate() {
        let (x, y) = (i as i32 % i32::from(WIDTH), i as i32 / i32::from(WIDTH));
        let beside = !area.offset(1).contains(Point::new(x, y));
        assert!(*with == without || !beside, "({x}, {y})");
    }
}

/// A frame is also something to draw: any screen of embedded-graphics takes it, also a part of
/// one.
#[test]
fn a_frame_is_drawn_to_any_screen_as_it_is() {
    let mut words = drawn(&teapot()).words;
    let expected = words.clone();
    let frame = Frame::new(&mut words, WIDTH, HEIGHT).unwrap();
    let mut screen = SimulatorDisplay::<Rgb565>::new(Size::new(WIDTH.into(), HEIGHT.into()));
    frame.draw(&mut screen).unwrap();
    assert!(shown(&screen) == expected);

    let part = Rectangle::new(Point::new(40, 60), Size::new(100, 80));
    let mut screen = SimulatorDisplay::<Rgb565>::new(Size::new(WIDTH.into(), HEIGHT.into()));
    frame.draw(&mut screen.cropped(&part)).unwrap();
    for point in part.points() {
        let Point { x, y } = point - part.top_left;
        let word = expected[(y * i32::from(WIDTH) + x) as usize];
        assert_eq!(screen.get_pixel(point), RawU16::new(word).into(), "{point}");
    }
}

#[test]
fn the_panel_shows_the_teapot() {
    let blob = teapot();
    let request = Request::Model(Scene {
        camera: view().camera().unwrap(),
        light: render::light(STANDARD_LIGHT),
        mode: Mode::default(),
    });
    let run = ask(&request.line(), Some(blob.bytes())).unwrap();
    let run = run.done().unwrap();
    assert!(run.words == drawn(&blob).words);
    snapshot::check("teapot", &run.words, WIDTH);
}
