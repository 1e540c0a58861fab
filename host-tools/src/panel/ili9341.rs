//! The ILI9341 controller: commands, address window and memory.
//!
//! After the controller's datasheet (ILITEK, version 1.11): its chapter 8 for the commands,
//! 8.2.20 to 8.2.22 for window and writing, 8.2.29 for the memory access order. Emulated is
//! what the serial interface can do to the picture; commands that only trim voltages, gamma or
//! timing are known by name and change nothing, and any other command is a fault.

use std::fmt;

/// Columns of the memory.
pub const WIDTH: u16 = 240;
/// Rows of the memory.
pub const HEIGHT: u16 = 320;
/// Pixels of the memory.
pub const PIXELS: usize = WIDTH as usize * HEIGHT as usize;

/// MADCTL: row order.
const MY: u8 = 1 << 7;
/// MADCTL: column order.
const MX: u8 = 1 << 6;
/// MADCTL: rows and columns exchanged.
const MV: u8 = 1 << 5;
/// MADCTL: colour order.
const BGR: u8 = 1 << 3;

/// Commands whose parameters change the picture.
mod code {
    pub(super) const SWRESET: u8 = 0x01;
    pub(super) const SLPIN: u8 = 0x10;
    pub(super) const SLPOUT: u8 = 0x11;
    pub(super) const INVOFF: u8 = 0x20;
    pub(super) const INVON: u8 = 0x21;
    pub(super) const DISPOFF: u8 = 0x28;
    pub(super) const DISPON: u8 = 0x29;
    pub(super) const CASET: u8 = 0x2A;
    pub(super) const PASET: u8 = 0x2B;
    pub(super) const RAMWR: u8 = 0x2C;
    pub(super) const MADCTL: u8 = 0x36;
    pub(super) const COLMOD: u8 = 0x3A;
    pub(super) const RAMWRC: u8 = 0x3C;
}

/// Code, name and number of parameters of the commands that are known. Memory writes take any.
const COMMANDS: [(u8, &str, usize); 33] = [
    (0x00, "NOP", 0),
    (code::SWRESET, "SWRESET", 0),
    (code::SLPIN, "SLPIN", 0),
    (code::SLPOUT, "SLPOUT", 0),
    (0x13, "NORON", 0),
    (code::INVOFF, "INVOFF", 0),
    (code::INVON, "INVON", 0),
    (0x26, "GAMSET", 1),
    (code::DISPOFF, "DISPOFF", 0),
    (code::DISPON, "DISPON", 0),
    (code::CASET, "CASET", 4),
    (code::PASET, "PASET", 4),
    (code::RAMWR, "RAMWR", usize::MAX),
    (0x34, "TEOFF", 0),
    (0x35, "TEON", 1),
    (code::MADCTL, "MADCTL", 1),
    (0x38, "IDMOFF", 0),
    (code::COLMOD, "COLMOD", 1),
    (code::RAMWRC, "RAMWRC", usize::MAX),
    (0x51, "WRDISBV", 1),
    (0x53, "WRCTRLD", 1),
    (0xB1, "FRMCTR1", 2),
    (0xB4, "INVTR", 1),
    (0xB7, "ETMOD", 1),
    (0xC0, "PWCTRL1", 1),
    (0xC1, "PWCTRL2", 1),
    (0xC5, "VMCTRL1", 2),
    (0xC7, "VMCTRL2", 1),
    (0xCB, "PWCTRLA", 5),
    (0xCF, "PWCTRLB", 3),
    (0xE0, "PGAMCTRL", 15),
    (0xE1, "NGAMCTRL", 15),
    (0xF2, "EN3G", 1),
];

/// What a controller cannot make sense of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// No such command, or one that is not emulated.
    UnknownCommand(u8),
    /// Data before any command, or more than the command takes.
    UnexpectedData(u8),
    /// The command was followed by fewer parameters than it takes.
    FewParameters(u8),
    /// A window that ends before it begins, or beyond the memory.
    Window,
    /// A pixel format other than 16 or 18 bits.
    PixelFormat(u8),
    /// A memory write ended inside a pixel.
    PartOfAPixel,
    /// Bytes while another chip, or none, was selected.
    NotSelected,
    /// Bytes while the reset pin was low.
    InReset,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownCommand(code) => write!(f, "unknown command {code:#04x}"),
            Self::UnexpectedData(code) => {
                write!(f, "data that {} does not take", name(*code))
            }
            Self::FewParameters(code) => write!(f, "too few parameters for {}", name(*code)),
            Self::Window => f.write_str("an address window outside the memory"),
            Self::PixelFormat(bits) => write!(f, "unknown pixel format {bits:#04x}"),
            Self::PartOfAPixel => f.write_str("a memory write that ended inside a pixel"),
            Self::NotSelected => f.write_str("bytes while the panel was not selected"),
            Self::InReset => f.write_str("bytes while the panel was in reset"),
        }
    }
}

fn name(code: u8) -> &'static str {
    COMMANDS
        .iter()
        .find(|(c, _, _)| *c == code)
        .map_or("no command", |(_, name, _)| name)
}

/// First and last address, both inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Range {
    first: u16,
    last: u16,
}

/// The controller.
#[derive(Clone, Debug)]
pub struct Ili9341 {
    /// Six bits each of red, green, blue.
    memory: Vec<[u8; 3]>,
    asleep: bool,
    on: bool,
    inverted: bool,
    madctl: u8,
    bits: u8,
    columns: Range,
    pages: Range,
    column: u16,
    page: u16,
    /// The last command, and what followed it: parameters, or the bytes of a pixel.
    command: Option<u8>,
    /// Parameters of the command, or bytes of the pixel, received so far.
    received: Vec<u8>,
    /// Parameters that the command still takes.
    wanted: usize,
    faults: Vec<(Fault, u64)>,
    commands: u64,
    data_bytes: u64,
}

impl Default for Ili9341 {
    fn default() -> Self {
        Self::new()
    }
}

impl Ili9341 {
    /// Power has just come: the memory holds noise (here a pattern), and the display sleeps.
    #[must_use]
    pub fn new() -> Self {
        let noise = |i: usize| [(i * 7 % 64) as u8, (i * 13 % 64) as u8, (i * 29 % 64) as u8];
        let mut controller = Self {
            memory: (0..PIXELS).map(noise).collect(),
            asleep: true,
            on: false,
            inverted: false,
            madctl: 0,
            bits: 18,
            columns: Range { first: 0, last: 0 },
            pages: Range { first: 0, last: 0 },
            column: 0,
            page: 0,
            command: None,
            received: Vec::new(),
            wanted: 0,
            faults: Vec::new(),
            commands: 0,
            data_bytes: 0,
        };
        controller.reset();
        controller
    }

    /// The values after a reset (8.2.2 and the table of each command); the memory stays.
    pub fn reset(&mut self) {
        self.asleep = true;
        self.on = false;
        self.inverted = false;
        self.madctl = 0;
        self.bits = 18;
        self.columns = Range {
            first: 0,
            last: WIDTH - 1,
        };
        self.pages = Range {
            first: 0,
            last: HEIGHT - 1,
        };
        (self.column, self.page) = (0, 0);
        self.command = None;
        self.received.clear();
        self.wanted = 0;
    }

    /// Remembers a fault; the same one again only counts.
    pub fn fault(&mut self, fault: Fault) {
        match self.faults.iter_mut().find(|(f, _)| *f == fault) {
            Some((_, count)) => *count += 1,
            None => self.faults.push((fault, 1)),
        }
    }

    /// The faults so far, and one for a command that still waits for its parameters.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let mut faults = self.faults.clone();
        if let Some(fault) = self.unfinished() {
            faults.push((fault, 1));
        }
        faults
            .into_iter()
            .map(|(fault, count)| match count {
                1 => fault.to_string(),
                _ => format!("{fault} ({count} times)"),
            })
            .collect()
    }

    /// Commands received.
    #[must_use]
    pub fn commands(&self) -> u64 {
        self.commands
    }

    /// Bytes of data received.
    #[must_use]
    pub fn data_bytes(&self) -> u64 {
        self.data_bytes
    }

    /// Whether the memory is shown.
    #[must_use]
    pub fn shows(&self) -> bool {
        self.on && !self.asleep
    }

    /// Whether colours are shown as their complement.
    #[must_use]
    pub fn inverted(&self) -> bool {
        self.inverted
    }

    /// Whether the colour order is blue, green, red. It takes effect on what is shown, not on
    /// what is written.
    #[must_use]
    pub fn bgr(&self) -> bool {
        self.madctl & BGR != 0
    }

    /// Six bits each of red, green and blue at a column and row of the memory.
    ///
    /// # Panics
    /// Outside the memory.
    #[must_use]
    pub fn cell(&self, column: u16, row: u16) -> [u8; 3] {
        assert!(column < WIDTH && row < HEIGHT, "({column}, {row})");
        self.memory[usize::from(row) * usize::from(WIDTH) + usize::from(column)]
    }

    /// What the last command still lacks.
    fn unfinished(&self) -> Option<Fault> {
        let code = self.command?;
        if matches!(code, code::RAMWR | code::RAMWRC) {
            (!self.received.is_empty()).then_some(Fault::PartOfAPixel)
        } else {
            (self.wanted > 0).then_some(Fault::FewParameters(code))
        }
    }

    /// A byte with D/C low.
    pub fn command(&mut self, code: u8) {
        if let Some(fault) = self.unfinished() {
            self.fault(fault);
        }
        self.commands += 1;
        self.received.clear();
        let Some((_, _, wanted)) = COMMANDS.iter().find(|(c, _, _)| *c == code) else {
            self.fault(Fault::UnknownCommand(code));
            self.command = None;
            self.wanted = 0;
            return;
        };
        self.command = Some(code);
        self.wanted = *wanted;
        match code {
            code::SWRESET => self.reset(),
            code::SLPIN => self.asleep = true,
            code::SLPOUT => self.asleep = false,
            code::INVOFF => self.inverted = false,
            code::INVON => self.inverted = true,
            code::DISPOFF => self.on = false,
            code::DISPON => self.on = true,
            code::RAMWR => (self.column, self.page) = (self.columns.first, self.pages.first),
            _ => {}
        }
    }

    /// A byte with D/C high.
    pub fn data(&mut self, byte: u8) {
        self.data_bytes += 1;
        let Some(code) = self.command else {
            self.fault(Fault::UnexpectedData(0));
            return;
        };
        if self.wanted == 0 {
            self.fault(Fault::UnexpectedData(code));
            return;
        }
        self.received.push(byte);
        if matches!(code, code::RAMWR | code::RAMWRC) {
            self.pixel_byte();
            return;
        }
        self.wanted -= 1;
        if self.wanted == 0 {
            self.parameters(code);
        }
    }

    /// All parameters of a command are there.
    fn parameters(&mut self, code: u8) {
        let range = |p: &[u8]| match p {
            [a, b, c, d] => Range {
                first: u16::from_be_bytes([*a, *b]),
                last: u16::from_be_bytes([*c, *d]),
            },
            _ => Range { first: 0, last: 0 },
        };
        // The longer side is the pages' unless rows and columns are exchanged.
        let (columns, pages) = if self.madctl & MV == 0 {
            (WIDTH, HEIGHT)
        } else {
            (HEIGHT, WIDTH)
        };
        match code {
            code::CASET => match range(&self.received) {
                r if r.first <= r.last && r.last < columns => self.columns = r,
                _ => self.fault(Fault::Window),
            },
            code::PASET => match range(&self.received) {
                r if r.first <= r.last && r.last < pages => self.pages = r,
                _ => self.fault(Fault::Window),
            },
            code::MADCTL => self.madctl = self.received[0],
            code::COLMOD => match self.received[0] & 0b111 {
                0b101 => self.bits = 16,
                0b110 => self.bits = 18,
                _ => self.fault(Fault::PixelFormat(self.received[0])),
            },
            _ => {}
        }
    }

    /// A byte of a memory write.
    fn pixel_byte(&mut self) {
        let colour = match (self.bits, &self.received[..]) {
            (16, [high, low]) => {
                let word = u16::from_be_bytes([*high, *low]);
                // Five bits become six by repeating the highest, as the controller's table does.
                let six = |five: u16| (five << 1 | five >> 4) as u8;
                [six(word >> 11), (word >> 5 & 0x3F) as u8, six(word & 0x1F)]
            }
            (18, [r, g, b]) => [r >> 2, g >> 2, b >> 2],
            _ => return,
        };
        self.received.clear();
        if let Some(index) = self.index() {
            self.memory[index] = colour;
        } else {
            self.fault(Fault::Window);
        }
        if self.column < self.columns.last {
            self.column += 1;
        } else {
            self.column = self.columns.first;
            self.page = if self.page < self.pages.last {
                self.page + 1
            } else {
                self.pages.first
            };
        }
    }

    /// Where the current column and page lie in the memory.
    fn index(&self) -> Option<usize> {
        let (mut x, mut y) = if self.madctl & MV == 0 {
            (self.column, self.page)
        } else {
            (self.page, self.column)
        };
        if x >= WIDTH || y >= HEIGHT {
            return None;
        }
        if self.madctl & MX != 0 {
            x = WIDTH - 1 - x;
        }
        if self.madctl & MY != 0 {
            y = HEIGHT - 1 - y;
        }
        Some(usize::from(y) * usize::from(WIDTH) + usize::from(x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sent(commands: &[(u8, &[u8])]) -> Ili9341 {
        let mut controller = Ili9341::new();
        for (code, data) in commands {
            controller.command(*code);
            data.iter().for_each(|byte| controller.data(*byte));
        }
        controller
    }

    const SIXTEEN: (u8, &[u8]) = (code::COLMOD, &[0x55]);
    const RED: [u8; 3] = [63, 0, 0];

    #[test]
    fn the_display_shows_when_it_is_awake_and_on() {
        assert!(!sent(&[]).shows());
        assert!(!sent(&[(code::SLPOUT, &[])]).shows());
        assert!(!sent(&[(code::DISPON, &[])]).shows());
        let both: [(u8, &[u8]); 2] = [(code::SLPOUT, &[]), (code::DISPON, &[])];
        assert!(sent(&both).shows());
        let mut controller = sent(&both);
        controller.command(code::SWRESET);
        assert!(!controller.shows());
    }

    #[test]
    fn a_window_is_filled_row_by_row_and_wraps_to_its_start() {
        let c = sent(&[
            SIXTEEN,
            (code::CASET, &[0, 10, 0, 11]),
            (code::PASET, &[0, 20, 1, 0]),
            (code::PASET, &[0, 20, 0, 21]),
            (
                code::RAMWR,
                &[0, 0, 0, 0x1F, 0x07, 0xE0, 0x07, 0xFF, 0xF8, 0],
            ),
        ]);
        assert_eq!(c.cell(11, 20), [0, 0, 63]);
        assert_eq!(c.cell(10, 21), [0, 63, 0]);
        assert_eq!(c.cell(11, 21), [0, 63, 63]);
        assert_eq!(c.cell(10, 20), RED, "the fifth pixel starts over");
        assert!(c.faults().is_empty());
    }

    #[test]
    fn writing_goes_on_where_it_stopped() {
        let c = sent(&[
            SIXTEEN,
            (code::RAMWR, &[0xF8, 0]),
            (code::RAMWRC, &[0x00, 0x1F]),
            (code::RAMWR, &[0x07, 0xE0]),
        ]);
        assert_eq!((c.cell(0, 0), c.cell(1, 0)), ([0, 63, 0], [0, 0, 63]));
    }

    #[test]
    fn the_access_order_turns_and_mirrors() {
        for (madctl, column, row) in [
            (0, 0, 0),
            (MX, 239, 0),
            (MY, 0, 319),
            (MX | MY, 239, 319),
            (MV, 0, 0),
            (MV | MX, 239, 0),
        ] {
            let data = [0xF8, 0, 0, 0x1F];
            let c = sent(&[SIXTEEN, (code::MADCTL, &[madctl]), (code::RAMWR, &data)]);
            assert_eq!(c.cell(column, row), RED, "{madctl:#x}");
            let (next_column, next_row) = match madctl & (MV | MX) {
                0 => (column + 1, row),
                MX => (column - 1, row),
                _ => (column, row + 1),
            };
            assert_eq!(c.cell(next_column, next_row), [0, 0, 63], "{madctl:#x}");
        }
        // In landscape a row has 320 columns.
        let wide: (u8, &[u8]) = (code::CASET, &[0, 0, 1, 0x3F]);
        assert!(sent(&[(code::MADCTL, &[MV]), wide]).faults().is_empty());
        assert!(!sent(&[wide]).faults().is_empty());
    }

    #[test]
    fn eighteen_bits_a_pixel_are_three_bytes() {
        let c = sent(&[(code::COLMOD, &[0x66]), (code::RAMWR, &[0xFC, 0x80, 0x04])]);
        assert_eq!(c.cell(0, 0), [63, 32, 1]);
    }

    #[test]
    fn every_five_bit_colour_comes_back_from_six() {
        for word in 0..32u16 {
            let bytes = (word << 11 | word).to_be_bytes();
            let c = sent(&[SIXTEEN, (code::RAMWR, &bytes)]);
            let [r, _, b] = c.cell(0, 0);
            assert_eq!((u16::from(r >> 1), u16::from(b >> 1)), (word, word));
        }
    }

    #[test]
    fn what_makes_no_sense_is_a_fault() {
        for (commands, text) in [
            (&[(0x99, &[][..])][..], "unknown command 0x99"),
            (&[(code::SLPOUT, &[1])], "data that SLPOUT does not take"),
            (&[(code::MADCTL, &[])], "too few parameters for MADCTL"),
            (
                &[(code::CASET, &[0, 5]), (0x00, &[])],
                "too few parameters for CASET",
            ),
            (&[(code::CASET, &[0, 9, 0, 8])], "an address window outside"),
            (
                &[(code::CASET, &[0, 0, 0, 240])],
                "an address window outside",
            ),
            (&[(code::COLMOD, &[0x51])], "unknown pixel format"),
            (&[SIXTEEN, (code::RAMWR, &[1])], "inside a pixel"),
        ] {
            let faults = sent(commands).faults();
            assert_eq!(faults.len(), 1, "{faults:?}");
            assert!(faults[0].contains(text), "{faults:?}");
        }
        let mut controller = Ili9341::new();
        controller.data(1);
        assert_eq!(controller.faults().len(), 1);
    }

    #[test]
    fn commands_that_only_trim_the_panel_are_known_by_name() {
        let c = sent(&[(0xB4, &[0]), (0x13, &[]), (0xC0, &[0x23]), (0xE0, &[0; 15])]);
        assert!(c.faults().is_empty());
        assert_eq!((c.commands(), c.data_bytes()), (4, 17));
    }
}
