//! The record of the wires: which registers of the board the emulator saw written.
//!
//! QEMU's trace point `memory_region_ops_write` writes a line for each write to a device:
//!
//! ```text
//! memory_region_ops_write cpu 0 mr 0x55e1 addr 0x40021008 value 0x2a size 4 name 'pl022'
//! ```
//!
//! From these lines the bytes on the panel's serial line follow, whatever the firmware says
//! about them.

/// The panel's serial port (PL022).
const SPI: u32 = 0x4002_1000;
const SPI_CR0: u32 = SPI;
const SPI_CR1: u32 = SPI + 0x04;
const SPI_DATA: u32 = SPI + 0x08;
/// The panel's pins (FPGAIO MISC).
const MISC: u32 = 0x4002_804C;

/// CR0: frame size less one.
const FRAME_SIZE: u32 = 0xF;
/// CR1: on.
const ON: u32 = 1 << 1;
/// CR1: what is sent comes back inside the port and does not reach the wire.
const LOOPBACK: u32 = 1 << 0;

/// What happened on the wires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The pin register's new value.
    Pins(u32),
    /// A byte on the serial line; a 16-bit frame is two, the upper one first.
    Byte(u8),
}

/// A record that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WireError {
    /// A line of the record has no address or value.
    #[error("line {0} of the record of the wires makes no sense")]
    Line(usize),
    /// A frame of a size that no panel takes.
    #[error("the serial port was set to frames of {0} bits (8 and 16 are understood)")]
    FrameSize(u32),
}

/// The events in a record, in order.
///
/// # Errors
/// When a line cannot be read, or the serial port is used in a way that no panel understands.
pub fn read(record: &str) -> Result<Vec<Event>, WireError> {
    let mut events = Vec::new();
    let (mut cr0, mut cr1) = (0, 0);
    for (index, line) in record.lines().enumerate() {
        let Some(line) = line.strip_prefix("memory_region_ops_write ") else {
            continue;
        };
        let (address, value) = address_and_value(line).ok_or(WireError::Line(index + 1))?;
        match address {
            MISC => events.push(Event::Pins(value)),
            SPI_CR0 => cr0 = value,
            SPI_CR1 => cr1 = value,
            SPI_DATA if cr1 & (ON | LOOPBACK) == ON => match cr0 & FRAME_SIZE {
                7 => events.push(Event::Byte(value as u8)),
                15 => {
                    events.push(Event::Byte((value >> 8) as u8));
                    events.push(Event::Byte(value as u8));
                }
                other => return Err(WireError::FrameSize(other + 1)),
            },
            _ => {}
        }
    }
    Ok(events)
}

fn address_and_value(line: &str) -> Option<(u32, u32)> {
    let hex = |text: &str| u32::from_str_radix(text.strip_prefix("0x")?, 16).ok();
    let mut words = line.split(' ');
    words.find(|word| *word == "addr")?;
    let address = hex(words.next()?)?;
    if words.next()? != "value" {
        return None;
    }
    Some((address, hex(words.next()?)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(address: u32, value: u32) -> String {
        format!(
            "memory_region_ops_write cpu 0 mr 0x5 addr {address:#x} value {value:#x} size 4 \
             name 'any'\n"
        )
    }

    #[test]
    fn bytes_and_pins_come_in_the_order_of_the_record() {
        let record = [
            line(SPI_CR1, ON),
            line(SPI_CR0, 7),
            line(MISC, 9),
            line(SPI_DATA, 0x2C),
            line(SPI_CR0, 15),
            line(MISC, 0x18),
            line(SPI_DATA, 0xF81F),
        ]
        .concat();
        assert_eq!(
            read(&record).unwrap(),
            [
                Event::Pins(9),
                Event::Byte(0x2C),
                Event::Pins(0x18),
                Event::Byte(0xF8),
                Event::Byte(0x1F)
            ]
        );
    }

    #[test]
    fn other_devices_and_other_lines_are_left_out() {
        let record = format!(
            "qemu: warning\n{}{}",
            line(0x4000_4000, 65),
            line(SPI + 0x10, 2)
        );
        assert_eq!(read(&record).unwrap(), []);
    }

    #[test]
    fn a_port_that_is_off_or_looped_back_reaches_no_wire() {
        for state in [0, ON | LOOPBACK] {
            let record = [line(SPI_CR0, 7), line(SPI_CR1, state), line(SPI_DATA, 1)].concat();
            assert_eq!(read(&record).unwrap(), []);
        }
    }

    #[test]
    fn an_odd_frame_size_is_an_error() {
        let record = [line(SPI_CR0, 8), line(SPI_CR1, ON), line(SPI_DATA, 1)].concat();
        assert_eq!(read(&record), Err(WireError::FrameSize(9)));
    }

    #[test]
    fn a_line_without_value_is_an_error_that_names_it() {
        let record = "memory_region_ops_write cpu 0 mr 0x5 addr 0x40021008\n";
        assert_eq!(read(record), Err(WireError::Line(1)));
    }
}
