//! The serial line on which the report leaves.

use core::fmt;

use crate::bare::Register;

/// The least divider of the clock; the emulator does not wait for a line.
const DIVIDER: u32 = 16;
/// CTRL: sending is on.
const SEND: u32 = 1 << 0;
/// STATE: no room for another byte.
const FULL: u32 = 1 << 0;
/// Ten bits at the divider take 160 cycles; a line that is not done by then is broken.
const PATIENCE: u32 = 10_000;

/// UART0, sending.
#[derive(Debug)]
pub(crate) struct Uart;

impl Uart {
    /// Switches the line on.
    pub(crate) fn start() -> Self {
        Register::UART_BAUDDIV.write(DIVIDER);
        Register::UART_CTRL.write(SEND);
        Self
    }
}

impl fmt::Write for Uart {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            if !(0..PATIENCE).any(|_| Register::UART_STATE.read() & FULL == 0) {
                return Err(fmt::Error);
            }
            Register::UART_DATA.write(byte.into());
        }
        Ok(())
    }
}
