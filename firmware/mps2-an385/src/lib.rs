//! The emulated board, QEMU's mps2-an385 (Cortex-M3, 25 MHz): wiring only.
//!
//! Built for thumbv7em-none-eabihf it runs on mps2-an386, which has a Cortex-M4F and the same devices
//! at the same addresses; built for thumbv6m-none-eabi it runs on the Cortex-M3, which understands all
//! that a Cortex-M0 does.
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
//!
//! The library is what programs on this board share; the program is the viewer.
#![no_std]

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

use defmt_semihosting as _;
use embedded_hal_bus::spi::ExclusiveDevice;
use rho_viewer::flow::{self, Device};
use rho_viewer::painter::Painter;
use rho_viewer::panel::{Ili9341, ScreenError, Wire};
use rho_viewer::report::{Exit, Report};
use rho_viewer::request::MAX_LINE;

pub use crate::bare::model;
pub use crate::clock::{Clock, Delay};
use crate::pins::{Misc, Pin};
use crate::spi::Pl022;
use crate::uart::Uart;

/// The panel on its port.
pub type Panel = Ili9341<ExclusiveDevice<Pl022, Pin, Delay>, Pin>;

/// The viewer: draws what the host asks for, reports how it went and ends the emulator.
pub fn view(painter: &mut impl Painter, buffer: &'static mut [MaybeUninit<u8>; MAX_LINE]) -> ! {
    let line = line(buffer);
    let screen = match panel() {
        Ok(screen) => screen,
        Err(error) => end_without_panel(&error),
    };
    let mut device = Device {
        screen,
        counter: Clock,
        flash: model(),
        painter,
    };
    end(flow::run(&mut device, line))
}

/// What the host asks for. A line that does not come, or is too long, is an empty one.
pub fn line(buffer: &'static mut [MaybeUninit<u8>; MAX_LINE]) -> &'static str {
    let line = semihosting::sys::arm_compat::sys_get_cmdline_uninit(buffer)
        .ok()
        .and_then(|bytes| core::str::from_utf8(bytes).ok())
        .unwrap_or("");
    defmt::info!("request: {=str}", line);
    line
}

/// Starts the panel.
///
/// # Errors
/// When the port is stuck.
pub fn panel() -> Result<Panel, ScreenError> {
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

/// Reports how it went and ends the emulator with the report's code.
pub fn end(mut report: Report) -> ! {
    report.stack_bytes = bare::stack_used();
    if report.exit == Exit::Done {
        defmt::info!("{=u64} instructions", report.phases.frame());
    } else {
        defmt::error!("{=str}", report.message.as_str());
    }
    match write!(Uart::start(), "{report}") {
        Ok(()) => exit(report.exit),
        Err(_) => exit(Exit::Report),
    }
}

/// Ends the emulator when there is no panel to show or report anything on.
pub fn end_without_panel(error: &ScreenError) -> ! {
    defmt::error!("{}", defmt::Display2Format(error));
    exit(Exit::Panel)
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
