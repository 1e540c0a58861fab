//! An ILI9341 panel in portrait on an SPI bus.
//!
//! The mipidsi crate knows the start-up sequence and the commands. Pixels take a way of their
//! own: a frame goes out as one slice of 16-bit words, most significant bit first on the wire,
//! which is the panel's own byte order; no pixel is handled by itself, and nothing in the way
//! can panic.

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::SpiDevice;
use mipidsi::dcs::{InterfaceExt, SetColumnAddress, SetPageAddress, WriteMemoryStart};
use mipidsi::interface::{Interface, InterfaceKind};
use mipidsi::models::ILI9341Rgb565;
use mipidsi::options::{ColorOrder, Orientation};

use crate::size::{HEIGHT, WIDTH};

/// Something that shows a picture.
pub trait Screen {
    /// Begins a picture of this size in the upper left of the screen.
    ///
    /// # Errors
    /// When the size is nothing or exceeds the screen, or the wire fails.
    fn begin(&mut self, width: u16, height: u16) -> Result<(), ScreenError>;

    /// Shows its next rows, from the top: RGB565 words.
    ///
    /// # Errors
    /// When they are more than the picture still wants, or the wire fails.
    fn rows(&mut self, words: &[u16]) -> Result<(), ScreenError>;

    /// Shows a whole picture, `width` words a row.
    ///
    /// # Errors
    /// Those of [`Screen::begin`] and [`Screen::rows`], and when the size is not that of the words.
    fn show(&mut self, words: &[u16], width: u16, height: u16) -> Result<(), ScreenError> {
        if words.len() != usize::from(width) * usize::from(height) {
            return Err(ScreenError::Size);
        }
        self.begin(width, height)?;
        self.rows(words)
    }
}

/// Why a screen shows nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScreenError {
    /// Words, width and height do not agree, or exceed the screen.
    Size,
    /// The bus or a pin failed.
    Wire,
}

impl core::fmt::Display for ScreenError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Size => "the frame does not fit the panel",
            Self::Wire => "the panel's bus failed",
        })
    }
}

impl core::error::Error for ScreenError {}

/// Commands in 8-bit frames with D/C low, pixels in 16-bit frames with D/C high.
#[derive(Debug)]
pub struct Wire<SPI, DC> {
    spi: SPI,
    dc: DC,
}

impl<SPI, DC> Wire<SPI, DC>
where
    SPI: SpiDevice<u8> + SpiDevice<u16>,
    DC: OutputPin,
{
    /// A device on the bus, and the pin that tells data (high) from commands (low).
    pub fn new(spi: SPI, dc: DC) -> Self {
        Self { spi, dc }
    }

    fn words(&mut self, words: &[u16]) -> Result<(), ScreenError> {
        SpiDevice::<u16>::write(&mut self.spi, words).map_err(|_| ScreenError::Wire)
    }
}

/// Words gathered before they go out when pixels come one by one.
const GATHERED: usize = 32;

impl<SPI, DC> Interface for Wire<SPI, DC>
where
    SPI: SpiDevice<u8> + SpiDevice<u16>,
    DC: OutputPin,
{
    type Word = u16;
    type Error = ScreenError;

    const KIND: InterfaceKind = InterfaceKind::Serial4Line;

    fn send_command(&mut self, command: u8, args: &[u8]) -> Result<(), ScreenError> {
        let wire = |_| ScreenError::Wire;
        self.dc.set_low().map_err(|_| ScreenError::Wire)?;
        SpiDevice::<u8>::write(&mut self.spi, &[command]).map_err(wire)?;
        self.dc.set_high().map_err(|_| ScreenError::Wire)?;
        if args.is_empty() {
            return Ok(());
        }
        SpiDevice::<u8>::write(&mut self.spi, args).map_err(wire)
    }

    fn send_pixels<const N: usize>(
        &mut self,
        pixels: impl IntoIterator<Item = [u16; N]>,
    ) -> Result<(), ScreenError> {
        let mut gathered = heapless::Vec::<u16, GATHERED>::new();
        for word in pixels.into_iter().flatten() {
            if gathered.is_full() {
                self.words(&gathered)?;
                gathered.clear();
            }
            // There is room: a full one has just been emptied.
            let _ = gathered.push(word);
        }
        self.words(&gathered)
    }

    fn send_repeated_pixel<const N: usize>(
        &mut self,
        pixel: [u16; N],
        count: u32,
    ) -> Result<(), ScreenError> {
        self.send_pixels((0..count).map(|_| pixel))
    }
}

/// A panel that has been started.
#[derive(Debug)]
pub struct Ili9341<SPI, DC> {
    wire: Wire<SPI, DC>,
    /// Whether every pixel of the panel has been written since it was started.
    covered: bool,
    /// Words that the picture still wants.
    wanted: usize,
}

impl<SPI, DC> Ili9341<SPI, DC>
where
    SPI: SpiDevice<u8> + SpiDevice<u16>,
    DC: OutputPin,
{
    /// Resets the panel and starts it; what it shows until the first frame is noise.
    ///
    /// The column order is mirrored and the colour order is BGR: so are the common modules
    /// wired, and that of the STM32F429I-DISCO.
    ///
    /// # Errors
    /// When the bus or a pin fails.
    pub fn start(
        wire: Wire<SPI, DC>,
        reset: impl OutputPin,
        delay: &mut impl DelayNs,
    ) -> Result<Self, ScreenError> {
        let display = mipidsi::Builder::new(ILI9341Rgb565, wire)
            .reset_pin(reset)
            .color_order(ColorOrder::Bgr)
            .orientation(Orientation::new().flip_horizontal())
            .init(delay)
            .map_err(|_| ScreenError::Wire)?;
        let (wire, _, _) = display.release();
        Ok(Self {
            wire,
            covered: false,
            wanted: 0,
        })
    }

    fn clear(&mut self) -> Result<(), ScreenError> {
        self.window(WIDTH, HEIGHT)?;
        for _ in 0..HEIGHT {
            self.wire.words(&[0; WIDTH as usize])?;
        }
        Ok(())
    }

    /// What follows fills this window from its upper left, row by row.
    fn window(&mut self, width: u16, height: u16) -> Result<(), ScreenError> {
        let (Some(right), Some(bottom)) = (width.checked_sub(1), height.checked_sub(1)) else {
            return Err(ScreenError::Size);
        };
        self.wire.write_command(SetColumnAddress::new(0, right))?;
        self.wire.write_command(SetPageAddress::new(0, bottom))?;
        self.wire.write_command(WriteMemoryStart)
    }
}

impl<SPI, DC> Screen for Ili9341<SPI, DC>
where
    SPI: SpiDevice<u8> + SpiDevice<u16>,
    DC: OutputPin,
{
    fn begin(&mut self, width: u16, height: u16) -> Result<(), ScreenError> {
        if width > WIDTH || height > HEIGHT {
            return Err(ScreenError::Size);
        }
        if !self.covered && (width, height) != (WIDTH, HEIGHT) {
            self.clear()?;
        }
        self.covered = true;
        self.wanted = usize::from(width) * usize::from(height);
        self.window(width, height)
    }

    fn rows(&mut self, words: &[u16]) -> Result<(), ScreenError> {
        self.wanted = self
            .wanted
            .checked_sub(words.len())
            .ok_or(ScreenError::Size)?;
        self.wire.words(words)
    }
}
