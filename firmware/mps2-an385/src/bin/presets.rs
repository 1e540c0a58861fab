//! The viewer with the presets alone, in the memory of a small microcontroller.
#![no_std]
#![no_main]

use core::mem::MaybeUninit;

use cortex_m_rt::entry;
use rho_mps2_an385::view;
use rho_viewer::request::MAX_LINE;
use rho_viewer::shadow::NoShadows;
use rho_viewer::strips::Strips;

#[entry]
fn main() -> ! {
    static mut STRIPS: Strips<NoShadows> = Strips::new();
    static mut LINE: [MaybeUninit<u8>; MAX_LINE] = [MaybeUninit::uninit(); MAX_LINE];
    view(STRIPS, LINE)
}
