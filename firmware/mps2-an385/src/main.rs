//! The emulated board, QEMU's mps2-an385 (Cortex-M3, 25 MHz): wiring only.
//!
//! | what | where |
//! | --- | --- |
//! | program | 0x0000_0000, 4 MB |
//! | stack, then statics | 0x2000_0000, 4 MB |
//! | the model, put there by the emulator's loader | 0x2100_0000, 16 MB |
//! | panel (ILI9341): clock and data | SPI at 0x4002_1000 |
//! | panel: chip select, reset, data/command, backlight | MISC at 0x4002_804C, bits 0, 3, 4, 6 |
//! | counter, 25 MHz | 0x4002_8018 |
//! | report | UART0, 0x4000_4000 |
//! | request, log, exit code | semihosting |
#![no_std]
#![no_main]

#[cfg(not(target_os = "none"))]
compile_error!(
    "rho-mps2-an385 runs on the emulated board only; build it with: cargo build --profile \
     firmware -p rho-mps2-an385 --target thumbv7m-none-eabi"
);

mod bare;
mod clock;
mod pins;
mod spi;
mod uart;

use core::fmt::{self, Write};
use core::mem::MaybeUninit;
use core::panic::PanicInfo;

use cortex_m_rt::entry;
use defmt_semihosting as _;
use embedded_hal_bus::spi::ExclusiveDevice;
use rho_viewer::flow::{self, Device};
use rho_viewer::panel::{Ili9341, ScreenError, Wire};
use rho_viewer::picture::Memory;
use rho_viewer::report::{Exit, Report};
use rho_viewer::request::MAX_LINE;
use rho_viewer::size::{PIXELS, Words};

use crate::clock::{Clock, Delay};
use crate::pins::{Misc, Pin};
use crate::spi::Pl022;
use crate::uart::Uart;

#[entry]
fn main() -> ! {
    static mut WORDS: Words = [0; PIXELS];
    static mut MEMORY: Memory = Memory::new();
    static mut LINE: [MaybeUninit<u8>; MAX_LINE] = [MaybeUninit::uninit(); MAX_LINE];
    // A line that does not come, or is too long, is a request without a picture.
    let line = semihosting::sys::arm_compat::sys_get_cmdline_uninit(LINE)
        .ok()
        .and_then(|bytes| core::str::from_utf8(bytes).ok())
        .unwrap_or("");
    defmt::info!("request: {=str}", line);
    exit(show(line, WORDS, MEMORY))
}

/// Starts the panel, does what the line asks for, and reports.
fn show(line: &str, words: &mut Words, memory: &mut Memory) -> Exit {
    let screen = match panel() {
        Ok(screen) => screen,
        Err(error) => {
            defmt::error!("{}", defmt::Display2Format(&error));
            return Exit::Panel;
        }
    };
    let mut device = Device {
        screen,
        counter: Clock,
        flash: bare::model(),
        words,
        memory,
    };
    let mut report = flow::run(&mut device, line);
    report.stack_bytes = bare::stack_used();
    if report.exit == Exit::Done {
        defmt::info!("{=u64} instructions", report.phases.frame());
    } else {
        defmt::error!("{=str}", report.message.as_str());
    }
    match write!(Uart::start(), "{report}") {
        Ok(()) => report.exit,
        Err(_) => Exit::Report,
    }
}

fn panel() -> Result<Ili9341<ExclusiveDevice<Pl022, Pin, Delay>, Pin>, ScreenError> {
    let Misc {
        chip_select,
        reset,
        data_command,
        mut backlight,
    } = Misc::start();
    let Ok(device) = ExclusiveDevice::new(Pl022::start(), chip_select, Delay);
    let panel = Ili9341::start(Wire::new(device, data_command), reset, &mut Delay)?;
    let Ok(()) = embedded_hal::digital::OutputPin::set_high(&mut backlight);
    Ok(panel)
}

/// Ends the emulator with this code.
fn exit(exit: Exit) -> ! {
    semihosting::process::exit(exit.code().into())
}

/// Ends the emulator with a report of what broke. Nothing of it goes through the log, which may
/// be what broke.
fn broken(code: Exit, message: fmt::Arguments<'_>) -> ! {
    let mut report = Report {
        exit: code,
        ..Report::default()
    };
    // A message that is too long is cut; a line that is stuck still leaves the code.
    let _ = report.message.write_fmt(message);
    let _ = write!(Uart::start(), "{report}");
    exit(code)
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    broken(Exit::Panic, format_args!("{info}"))
}
