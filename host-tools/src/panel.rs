//! The board's panel, emulated on the host from the record of its wires.
//!
//! Three steps, none of which trusts the firmware: [`wire`] reads which registers the emulator
//! saw written, [`ili9341`] is the controller that takes the bytes, and [`Panel`] holds both
//! together with the pins: what a person would see.

use crate::panel::ili9341::{HEIGHT, Ili9341, PIXELS, WIDTH};
use crate::panel::wire::Event;

pub mod ili9341;
pub mod wire;

/// Bits of the board's pin register (application note AN385, FPGAIO MISC).
mod pin {
    /// Low selects the panel.
    pub(super) const CHIP_SELECT: u32 = 1 << 0;
    /// Low resets it.
    pub(super) const RESET: u32 = 1 << 3;
    /// Low for a command, high for data.
    pub(super) const DATA: u32 = 1 << 4;
    /// High lights it.
    pub(super) const BACKLIGHT: u32 = 1 << 6;
}

/// How a panel's glass is wired to its controller: the MADCTL bits with which a picture
/// stands upright in its true colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Glass {
    /// Columns run against the controller's (MX must be set).
    pub mirrored: bool,
    /// The filter's order is blue, green, red (BGR must be set).
    pub bgr: bool,
}

impl Glass {
    /// The common 240 x 320 modules, and that of the STM32F429I-DISCO: MADCTL 0x48 stands upright.
    pub const MODULE: Self = Self {
        mirrored: true,
        bgr: true,
    };
}

/// A controller, its glass and its pins.
#[derive(Clone, Debug)]
pub struct Panel {
    controller: Ili9341,
    glass: Glass,
    pins: u32,
}

impl Panel {
    /// A panel that has just been given power.
    #[must_use]
    pub fn new(glass: Glass) -> Self {
        Self {
            controller: Ili9341::new(),
            glass,
            pins: 0,
        }
    }

    /// Does what the wires do.
    pub fn drive(&mut self, events: impl IntoIterator<Item = Event>) {
        for event in events {
            match event {
                Event::Pins(pins) => {
                    if pins & pin::RESET == 0 {
                        self.controller.reset();
                    }
                    self.pins = pins;
                }
                Event::Byte(byte) => {
                    if self.pins & pin::CHIP_SELECT != 0 {
                        self.controller.fault(ili9341::Fault::NotSelected);
                    } else if self.pins & pin::RESET == 0 {
                        self.controller.fault(ili9341::Fault::InReset);
                    } else if self.pins & pin::DATA == 0 {
                        self.controller.command(byte);
                    } else {
                        self.controller.data(byte);
                    }
                }
            }
        }
    }

    /// What went wrong on the wire.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        self.controller.faults()
    }

    /// Commands the controller took.
    #[must_use]
    pub fn commands(&self) -> u64 {
        self.controller.commands()
    }

    /// Bytes of parameters and pixels the controller took.
    #[must_use]
    pub fn data_bytes(&self) -> u64 {
        self.controller.data_bytes()
    }

    /// What a person would see, as RGB565 words, rows from the top: black while the panel is
    /// dark, asleep or off.
    #[must_use]
    pub fn seen(&self) -> Vec<u16> {
        let lit = self.pins & pin::BACKLIGHT != 0 && self.pins & pin::RESET != 0;
        if !lit || !self.controller.shows() {
            return vec![0; PIXELS];
        }
        let swapped = self.controller.bgr() != self.glass.bgr;
        let inverted = self.controller.inverted();
        (0..HEIGHT)
            .flat_map(|y| (0..WIDTH).map(move |x| (x, y)))
            .map(|(x, y)| {
                let column = if self.glass.mirrored {
                    WIDTH - 1 - x
                } else {
                    x
                };
                let [mut r, g, mut b] = self.controller.cell(column, y);
                if swapped {
                    (r, b) = (b, r);
                }
                // Six bits a colour in the controller; the frame had five of red and blue.
                let word = u16::from(r >> 1) << 11 | u16::from(g) << 5 | u16::from(b >> 1);
                if inverted { !word } else { word }
            })
            .collect()
    }
}

/// The upper left `width` x `height` words of a picture of a whole panel.
#[must_use]
pub fn crop(words: &[u16], width: u16, height: u16) -> Vec<u16> {
    words
        .chunks_exact(usize::from(WIDTH))
        .take(height.into())
        .flat_map(|row| row.iter().take(width.into()))
        .copied()
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const ON: u32 = pin::RESET | pin::BACKLIGHT;

    fn command(code: u8, parameters: &[u8]) -> Vec<Event> {
        let mut events = vec![
            Event::Pins(ON),
            Event::Byte(code),
            Event::Pins(ON | pin::DATA),
        ];
        events.extend(parameters.iter().map(|byte| Event::Byte(*byte)));
        events
    }

    /// Awake, on, 16 bits a pixel, with this MADCTL.
    fn started(madctl: u8) -> Panel {
        let mut panel = Panel::new(Glass::MODULE);
        panel.drive([Event::Pins(0)]);
        for (code, parameters) in [
            (0x11, &[][..]),
            (0x29, &[]),
            (0x3A, &[0x55]),
            (0x36, &[madctl]),
        ] {
            panel.drive(command(code, parameters));
        }
        // The memory is noise until it is written.
        panel.drive(command(0x2C, &vec![0; PIXELS * 2]));
        panel
    }

    fn first_pixel(panel: &mut Panel, word: u16) {
        panel.drive(command(0x2C, &word.to_be_bytes()));
    }

    #[test]
    fn a_word_written_upright_is_seen_as_itself() {
        let mut panel = started(0x48);
        for word in [0xF800, 0x07E0, 0x001F, 0x8410, 0xFFFF] {
            first_pixel(&mut panel, word);
            assert_eq!(panel.seen()[0], word);
        }
        assert_eq!(panel.faults(), [""; 0]);
    }

    #[test]
    fn without_the_mirror_bit_the_picture_is_mirrored() {
        let mut panel = started(0x08);
        first_pixel(&mut panel, 0xF800);
        assert_eq!(panel.seen()[usize::from(WIDTH) - 1], 0xF800);
    }

    #[test]
    fn without_the_bgr_bit_red_is_blue() {
        let mut panel = started(0x40);
        first_pixel(&mut panel, 0xF800);
        assert_eq!(panel.seen()[0], 0x001F);
    }

    #[test]
    fn inversion_shows_the_complement() {
        let mut panel = started(0x48);
        first_pixel(&mut panel, 0xF800);
        panel.drive(command(0x21, &[]));
        assert_eq!(panel.seen()[0], 0x07FF);
        panel.drive(command(0x20, &[]));
        assert_eq!(panel.seen()[0], 0xF800);
    }

    #[test]
    fn a_panel_that_is_dark_off_asleep_or_in_reset_is_black() {
        let mut panel = started(0x48);
        first_pixel(&mut panel, 0xFFFF);
        for code in [0x28, 0x10] {
            let mut panel = panel.clone();
            panel.drive(command(code, &[]));
            assert!(panel.seen().iter().all(|word| *word == 0), "{code:#x}");
        }
        for pins in [pin::RESET, pin::BACKLIGHT] {
            let mut panel = panel.clone();
            panel.drive([Event::Pins(pins)]);
            assert!(panel.seen().iter().all(|word| *word == 0), "{pins:#x}");
        }
    }

    #[test]
    fn bytes_to_a_panel_that_is_not_selected_are_faults_and_change_nothing() {
        let mut panel = started(0x48);
        let before = panel.seen();
        panel.drive([
            Event::Pins(ON | pin::CHIP_SELECT),
            Event::Byte(0x21),
            Event::Byte(0x21),
        ]);
        panel.drive([Event::Pins(ON)]);
        assert_eq!(panel.seen(), before);
        assert_eq!(panel.faults().len(), 1);
        assert!(panel.faults()[0].contains("not selected"));
        assert!(panel.faults()[0].contains('2'), "told once, with the count");
    }

    #[test]
    fn a_crop_keeps_the_upper_left() {
        let words: Vec<u16> = (0..PIXELS).map(|i| i as u16).collect();
        assert_eq!(crop(&words, 2, 2), [0, 1, 240, 241]);
    }
}
