//! From the host's line of text to the picture on the panel and the report.

use core::fmt::{self, Write};

use crate::size::{HEIGHT, WIDTH, Words};
use rho_grid::blob::format::CRC;
use rho_grid::frame::Frame;

use crate::count::{Counter, Phase, Stopwatch};
use crate::message;
use crate::panel::{Screen, ScreenError};
use crate::picture::{Memory, Model, ModelError};
use crate::report::{Exit, Report};
use crate::request::{Request, RequestError};
use crate::test_card;

/// What a board hands over.
#[derive(Debug)]
pub struct Device<'a, S, C> {
    /// Shows frames.
    pub screen: S,
    /// Tells what they cost.
    pub counter: C,
    /// The flash in which a model may lie, from its first byte.
    pub flash: &'a [u8],
    /// Where frames are drawn.
    pub words: &'a mut Words,
    /// What drawing a model needs beside.
    pub memory: &'a mut Memory,
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

/// Does what the line asks for. What cannot be done is told on the panel and in the report.
///
/// A picture is drawn twice and the second one is counted: so it clears what the first one
/// left behind, as every frame but the very first does.
pub fn run<S: Screen, C: Counter>(device: &mut Device<'_, S, C>, line: &str) -> Report {
    let mut report = Report::default();
    if let Err(stop) = answer(device, line, &mut report) {
        report.exit = stop.exit();
        // Cut, if ever longer than the longest message.
        let _ = write!(report.message, "{stop}");
        (report.width, report.height) = (WIDTH, HEIGHT);
        let canvas = &mut Frame::of_width(device.words.as_mut_slice(), WIDTH);
        let Ok(()) = message::draw(canvas, "Nothing to show", &report.message);
        // When the panel is what failed, the report still tells.
        if device.screen.show(device.words, WIDTH, HEIGHT).is_err() {
            report.exit = Exit::Panel;
        }
    }
    let pixels = usize::from(report.width) * usize::from(report.height);
    report.frame_crc32 = crc32(device.words.get(..pixels).unwrap_or(&[]));
    report
}

fn answer<S: Screen, C: Counter>(
    device: &mut Device<'_, S, C>,
    line: &str,
    report: &mut Report,
) -> Result<(), Stop> {
    let Device {
        screen,
        counter,
        flash,
        words,
        memory,
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
    let mut watch = Stopwatch::new(counter);
    for _ in 0..2 {
        watch.reset();
        match (&request, &model) {
            (Request::Model(scene), Some(model)) => {
                model
                    .draw(scene, words, memory, &mut watch)
                    .map_err(Stop::Model)?;
            }
            _ => {
                let canvas = &mut Frame::of_width(words.as_mut_slice(), WIDTH);
                let Ok(()) = watch.time(Phase::Draw, || test_card::draw(canvas));
            }
        }
    }
    if request == Request::CountLoop {
        report.probes.extend(watch.self_test());
    }
    let pixels = usize::from(report.width) * usize::from(report.height);
    let frame = words.get(..pixels).ok_or(Stop::TooLarge)?;
    watch.time(Phase::Send, || {
        screen.show(frame, report.width, report.height)
    })?;
    report.phases = watch.phases();
    Ok(())
}

/// CRC-32 of words as little-endian bytes.
#[must_use]
pub fn crc32(words: &[u16]) -> u32 {
    let mut digest = CRC.digest();
    for word in words {
        digest.update(&word.to_le_bytes());
    }
    digest.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::count::{PROBES, Probe};
    use crate::size::PIXELS;
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
        fn show(&mut self, words: &[u16], _: u16, _: u16) -> Result<(), ScreenError> {
            self.0 = words.to_vec();
            if self.1 {
                return Err(ScreenError::Wire);
            }
            Ok(())
        }
    }

    fn asked(line: &str, broken: bool) -> (Report, Vec<u16>) {
        let mut words = Box::new([0; PIXELS]);
        let mut device = Device {
            screen: Shown(Vec::new(), broken),
            counter: Still,
            flash: &[0; 64],
            words: &mut words,
            memory: &mut Memory::new(),
        };
        let report = run(&mut device, line);
        (report, device.screen.0)
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
                     frame=words grid=0 fineness=none cell_size=128";
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
