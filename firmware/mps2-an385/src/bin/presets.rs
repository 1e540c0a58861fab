//! The viewer with the presets alone, in the memory of a small microcontroller.
#![no_std]
#![no_main]

use core::mem::MaybeUninit;

use cortex_m_rt::entry;
use rho_mps2_an385::{Clock, end, end_without_panel, line, model, panel};
use rho_viewer::flow::{self, Device};
use rho_viewer::request::MAX_LINE;
use rho_viewer::shadow::NoShadows;
use rho_viewer::strips::Strips;

#[entry]
fn main() -> ! {
    static mut STRIPS: Strips<NoShadows> = Strips::new();
    static mut LINE: [MaybeUninit<u8>; MAX_LINE] = [MaybeUninit::uninit(); MAX_LINE];
    let line = line(LINE);
    let screen = match panel() {
        Ok(screen) => screen,
        Err(error) => end_without_panel(&error),
    };
    let mut device = Device {
        screen,
        counter: Clock,
        flash: model(),
        painter: STRIPS,
    };
    end(flow::run(&mut device, line))
}
