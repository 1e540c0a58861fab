//! The viewer on the emulated board.
#![no_std]
#![no_main]

use core::mem::MaybeUninit;

use cortex_m_rt::entry;
use rho_mps2_an385::{Clock, end, end_without_panel, line, model, panel};
use rho_viewer::flow::{self, Device};
use rho_viewer::picture::{Frames, Memory};
use rho_viewer::request::MAX_LINE;
use rho_viewer::size::{PIXELS, Words};

#[entry]
fn main() -> ! {
    static mut WORDS: Words = [0; PIXELS];
    static mut MEMORY: Memory = Memory::new();
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
        painter: &mut Frames {
            words: WORDS,
            memory: MEMORY,
        },
    };
    end(flow::run(&mut device, line))
}
