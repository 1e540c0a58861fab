//! The viewer on the emulated board.
#![no_std]
#![no_main]

use core::mem::MaybeUninit;

use cortex_m_rt::entry;
use rho_mps2_an385::view;
use rho_viewer::picture::{Frames, Memory};
use rho_viewer::request::MAX_LINE;
use rho_viewer::size::{PIXELS, Words};

#[entry]
fn main() -> ! {
    static mut WORDS: Words = [0; PIXELS];
    static mut MEMORY: Memory = Memory::new();
    static mut LINE: [MaybeUninit<u8>; MAX_LINE] = [MaybeUninit::uninit(); MAX_LINE];
    let mut frames = Frames {
        words: WORDS,
        memory: MEMORY,
    };
    view(&mut frames, LINE)
}
