//! The panel's pins: bits of one register (application note AN385, FPGAIO MISC).

use core::convert::Infallible;

use embedded_hal::digital::{ErrorType, OutputPin};

use crate::bare::Register;

/// One pin. The register is shared; the program has one thread and no interrupts, so that
/// reading and writing it back loses nothing.
#[derive(Debug)]
pub struct Pin(u32);

/// The pins of the panel.
#[derive(Debug)]
pub(crate) struct Misc {
    /// Low selects the panel (CLCD_CS).
    pub(crate) chip_select: Pin,
    /// Low resets the panel (CLCD_RESET).
    pub(crate) reset: Pin,
    /// Low for a command, high for data (CLCD_RS).
    pub(crate) data_command: Pin,
    /// High lights the panel (CLCD_BL_CTRL).
    pub(crate) backlight: Pin,
}

impl Misc {
    /// Nothing selected, no reset, no light.
    pub(crate) fn start() -> Self {
        let pins = Self {
            chip_select: Pin(1 << 0),
            reset: Pin(1 << 3),
            data_command: Pin(1 << 4),
            backlight: Pin(1 << 6),
        };
        Register::MISC.write(pins.chip_select.0 | pins.reset.0);
        pins
    }
}

impl ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Register::MISC.write(Register::MISC.read() & !self.0);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Register::MISC.write(Register::MISC.read() | self.0);
        Ok(())
    }
}
