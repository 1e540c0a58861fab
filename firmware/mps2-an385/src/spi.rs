//! The PL022 serial port of the panel as an embedded-hal bus of 8-bit and 16-bit frames.

use embedded_hal::spi::{Error, ErrorKind, ErrorType, SpiBus};

use crate::bare::Register;

/// Frame size less one in CR0; the rest of it is 0: Motorola format, mode 0, fastest clock.
const BITS_8: u32 = 7;
const BITS_16: u32 = 15;
/// The least divider of the clock (it must be even).
const DIVIDER: u32 = 2;
/// CR1: on.
const ON: u32 = 1 << 1;
/// SR: room in the queue to send.
const CAN_SEND: u32 = 1 << 1;
/// SR: something in the queue that was received.
const RECEIVED: u32 = 1 << 2;
/// SR: sending, or something left to send.
const BUSY: u32 = 1 << 4;
/// A frame takes 32 cycles of the clock; a port that is not done after so many readings of
/// its state is broken.
const PATIENCE: u32 = 10_000;

/// The port is stuck.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stuck;

impl Error for Stuck {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

/// The serial port.
#[derive(Debug)]
pub struct Pl022 {
    bits: u32,
}

impl Pl022 {
    /// Switches the port on.
    pub(crate) fn start() -> Self {
        Register::SPI_CPSR.write(DIVIDER);
        let mut port = Self { bits: 0 };
        port.frame(BITS_8);
        port
    }

    /// Sets the frame size, which the port takes only while it is off.
    fn frame(&mut self, bits: u32) {
        if self.bits != bits {
            Register::SPI_CR1.write(0);
            Register::SPI_CR0.write(bits);
            Register::SPI_CR1.write(ON);
            self.bits = bits;
        }
    }

    fn wait(mask: u32, state: u32) -> Result<(), Stuck> {
        (0..PATIENCE)
            .any(|_| Register::SPI_SR.read() & mask == state)
            .then_some(())
            .ok_or(Stuck)
    }

    /// Sends one frame and takes the one that comes back, so that neither queue fills.
    #[inline]
    fn exchange(word: u32) -> Result<u32, Stuck> {
        Self::wait(CAN_SEND, CAN_SEND)?;
        Register::SPI_DR.write(word);
        Self::wait(RECEIVED, RECEIVED)?;
        Ok(Register::SPI_DR.read())
    }
}

impl ErrorType for Pl022 {
    type Error = Stuck;
}

/// The bus for one frame size; the words differ in nothing else.
macro_rules! bus {
    ($word:ty, $bits:expr) => {
        impl SpiBus<$word> for Pl022 {
            fn read(&mut self, words: &mut [$word]) -> Result<(), Stuck> {
                self.frame($bits);
                for word in words {
                    *word = Self::exchange(0)? as $word;
                }
                Ok(())
            }

            fn write(&mut self, words: &[$word]) -> Result<(), Stuck> {
                self.frame($bits);
                for word in words {
                    Self::exchange(u32::from(*word))?;
                }
                Ok(())
            }

            fn transfer(&mut self, read: &mut [$word], write: &[$word]) -> Result<(), Stuck> {
                self.frame($bits);
                for i in 0..read.len().max(write.len()) {
                    let word = write.get(i).copied().unwrap_or(0);
                    let back = Self::exchange(u32::from(word))?;
                    if let Some(word) = read.get_mut(i) {
                        *word = back as $word;
                    }
                }
                Ok(())
            }

            fn transfer_in_place(&mut self, words: &mut [$word]) -> Result<(), Stuck> {
                self.frame($bits);
                for word in words {
                    *word = Self::exchange(u32::from(*word))? as $word;
                }
                Ok(())
            }

            fn flush(&mut self) -> Result<(), Stuck> {
                Self::wait(BUSY, 0)
            }
        }
    };
}

bus!(u8, BITS_8);
bus!(u16, BITS_16);
