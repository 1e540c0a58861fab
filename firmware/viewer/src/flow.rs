//! From the host's line of text to the picture on the panel and the report.

use core::fmt::{self, Write};

use crc::{Digest, Table};
use rho_grid::blob::format::CRC;

use crate::count::{Counter, Phase, Stopwatch};
use crate::message;
use crate::painter::{Give, PaintError, Painter, infallible};
use crate::panel::{Screen, ScreenError};
use crate::picture::{Model, ModelError};
use crate::report::{Exit, Report};
use crate::request::{Request, RequestError};
use crate::size::{HEIGHT, WIDTH};
use crate::test_card;

/// What a board hands over.
#[derive(Debug)]
pub struct Device<'a, S, C, P> {
    /// Shows pictures.
    pub screen: S,
    /// Tells what they cost.
    pub counter: C,
    /// The flash in which a model may lie, from its first byte.
    pub flash: &'a [u8],
    /// Draws them.
    pub painter: &'a mut P,
}

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The request could not be read.
    Request(RequestError),
    /// It asks for a picture larger than the panel.
    TooLarge,
    /// The model cannot be drawn.
    Model(ModelError),
    /// The panel shows nothing.
    Screen(ScreenError),
}

impl Stop {
    fn exit(&self) -> Exit {
        match self {
            Self::Request(_) | Self::TooLarge => Exit::Request,
            Self::Model(_) => Exit::Model,
            Self::Screen(_) => Exit::Panel,
        }
    }
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Request(error) => error.fmt(f),
            Self::TooLarge => write!(f, "the panel has only {WIDTH} x {HEIGHT} pixels"),
            Self::Model(error) => error.fmt(f),
            Self::Screen(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for Stop {}

impl From<ScreenError> for Stop {
    fn from(error: ScreenError) -> Self {
        Self::Screen(error)
    }
}

impl From<PaintError> for Stop {
    fn from(error: PaintError) -> Self {
        match error {
            PaintError::Model(error) => Self::Model(error),
            PaintError::Screen(error) => Self::Screen(error),
        }
    }
}

/// Does what the line asks for. What cannot be done is told on the panel and in the report.
///
/// A picture is drawn twice. The first is summed up; the second is counted and sent, and clears
/// what the first one left behind, as every frame but the very first does.
pub fn run<S: Screen, C: Counter, P: Painter>(
    device: &mut Device<'_, S, C, P>,
    line: &str,
) -> Report {
    let mut report = Report::default();
    if let Err(stop) = answer(device, line, &mut report) {
        report.exit = stop.exit();
        // Cut, if ever longer than the longest message.
        let _ = write!(report.message, "{stop}");
        (report.width, report.height) = (WIDTH, HEIGHT);
        // When the panel is what failed, the report still tells.
        if tell(device, &mut report).is_err() {
            report.exit = Exit::Panel;
        }
    }
    report
}

/// Shows the report's message.
fn tell<S: Screen, C: Counter, P: Painter>(
    device: &mut Device<'_, S, C, P>,
    report: &mut Report,
) -> Result<(), ScreenError> {
    let message = report.message.clone();
    let mut sum = CRC.digest();
    let mut shown = device.screen.begin(WIDTH, HEIGHT);
    let drawn = device.painter.shapes(
        &|canvas| infallible(message::draw(canvas, "Nothing to show", &message)),
        &mut Stopwatch::new(&device.counter),
        &mut |words| {
            add(&mut sum, words);
            if shown.is_ok() {
                shown = device.screen.rows(words);
            }
            Ok(())
        },
    );
    report.frame_crc32 = sum.finalize();
    drawn.and(shown)
}

fn answer<S: Screen, C: Counter, P: Painter>(
    device: &mut Device<'_, S, C, P>,
    line: &str,
    report: &mut Report,
) -> Result<(), Stop> {
    let Device {
        screen,
        counter,
        flash,
        painter,
    } = device;
    let request = Request::parse(line).map_err(Stop::Request)?;
    (report.width, report.height) = match &request {
        Request::Model(scene) => (scene.camera.width, scene.camera.height),
        Request::TestCard | Request::CountLoop => (WIDTH, HEIGHT),
    };
    if report.width > WIDTH || report.height > HEIGHT {
        return Err(Stop::TooLarge);
    }
    let model = match &request {
        Request::Model(_) => Some(Model::check(flash).map_err(Stop::Model)?),
        Request::TestCard | Request::CountLoop => None,
    };
    let watch = &mut Stopwatch::new(counter);
    let mut draw = |watch: &mut Stopwatch<'_, C>, give: Give<'_>| match (&request, &model) {
        (Request::Model(scene), Some(model)) => {
            painter.model(model, scene, watch, give).map_err(Stop::from)
        }
        _ => painter
            .shapes(&|canvas| infallible(test_card::draw(canvas)), watch, give)
            .map_err(Stop::from),
    };
    let mut sum = CRC.digest();
    draw(watch, &mut |words| {
        add(&mut sum, words);
        Ok(())
    })?;
    report.frame_crc32 = sum.finalize();
    watch.reset();
    watch.time(Phase::Send, || screen.begin(report.width, report.height))?;
    draw(watch, &mut |words| screen.rows(words))?;
    if request == Request::CountLoop {
        report.probes.extend(watch.self_test());
    }
    report.phases = watch.phases();
    Ok(())
}

/// Adds words to a sum, as little-endian bytes.
fn add(sum: &mut Digest<'_, u32, Table<1>>, words: &[u16]) {
    for word in words {
        sum.update(&word.to_le_bytes());
    }
}

/// CRC-32 of words as little-endian bytes.
#[must_use]
pub fn crc32(words: &[u16]) -> u32 {
    let mut sum = CRC.digest();
    add(&mut sum, words);
    sum.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::count::{PROBES, Probe};
    use crate::picture::{Frames, Memory};
    use crate::shadow::NoShadows;
    use crate::size::PIXELS;
    use crate::strips::Strips;
    use rho_grid::frame::Frame;
    use std::boxed::Box;
    use std::vec::Vec;

    struct Still;

    impl Counter for Still {
        fn now(&self) -> u32 {
            0
        }
        fn between(&self, _: u32, _: u32) -> u32 {
            0
        }
        fn overhead(&self) -> u32 {
            0
        }
        fn self_test(&self) -> [Probe; PROBES] {
            [Probe::default(); PROBES]
        }
    }

    #[derive(Default)]
    struct Shown(Vec<u16>, bool);

    impl Screen for Shown {
        fn begin(&mut self, _: u16, _: u16) -> Result<(), ScreenError> {
            self.0.clear();
            Ok(())
        }

        fn rows(&mut self, words: &[u16]) -> Result<(), ScreenError> {
            if self.1 {
                return Err(ScreenError::Wire);
            }
            self.0.extend(words);
            Ok(())
        }
    }

    fn asked(line: &str, broken: bool) -> (Report, Vec<u16>) {
        let mut words = Box::new([0; PIXELS]);
        let memory = &mut Memory::new();
        let mut device = Device {
            screen: Shown(Vec::new(), broken),
            counter: Still,
            flash: &[0; 64],
            painter: &mut Frames {
                words: &mut words,
                memory,
            },
        };
        let report = run(&mut device, line);
        let whole = device.screen.0;
        let mut strips = Device {
            screen: Shown(Vec::new(), broken),
            counter: Still,
            flash: &[0; 64],
            painter: &mut Strips::<NoShadows>::new(),
        };
        let by_strips = run(&mut strips, line);
        assert!(whole == strips.screen.0, "in strips it is the same");
        assert_eq!(report.frame_crc32, by_strips.frame_crc32);
        assert_eq!(report.message, by_strips.message);
        (report, whole)
    }

    #[test]
    fn the_crc_is_that_of_ieee_over_little_endian_words() {
        // The check value of CRC-32 is that of the nine digits; eight of them make four words.
        let words = [*b"12", *b"34", *b"56", *b"78"].map(u16::from_le_bytes);
        assert_eq!(crc32(&words), 0x9AE0_DAAF);
    }

    #[test]
    fn the_test_card_is_shown_and_reported() {
        let (report, shown) = asked("picture=test-card", false);
        assert_eq!(report.exit, Exit::Done);
        assert_eq!(report.frame_crc32, crc32(&shown));
        let mut card = Box::new([0; PIXELS]);
        test_card::draw(&mut Frame::of_width(card.as_mut_slice(), WIDTH)).unwrap();
        assert!(shown == card.as_slice());
    }

    #[test]
    fn what_cannot_be_done_is_told_on_the_panel_and_in_the_report() {
        for (line, exit, word) in [
            ("picture=cat", Exit::Request, "test-card"),
            ("picture=model", Exit::Request, "rotation"),
        ] {
            let (report, shown) = asked(line, false);
            assert_eq!(report.exit, exit);
            assert!(report.message.contains(word), "{}", report.message);
            assert_eq!(report.frame_crc32, crc32(&shown));
        }
    }

    #[test]
    fn an_empty_flash_is_told() {
        let scene = "picture=model rotation=1;0;0;0;1;0;0;0;1 translation=0;0;0 focal=9 \
                     size=240;320 light=0;0;1 visibility=eye footprint=box reciprocal=divide \
                     frame=words grid=0 fineness=none cell_size=128 shadows=none shadow_map=64 \
                     light_splat=1";
        let (report, _) = asked(scene, false);
        assert_eq!(report.exit, Exit::Model);
        assert!(report.message.contains("no blob"), "{}", report.message);
        let (report, _) = asked(&scene.replace("240;320", "320;240"), false);
        assert!(report.message.contains("240 x 320"), "{}", report.message);
    }

    #[test]
    fn a_panel_that_fails_is_told_in_the_report() {
        let (report, _) = asked("picture=test-card", true);
        assert_eq!(report.exit, Exit::Panel);
    }
}
